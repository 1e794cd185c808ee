"""Unloaded: sweeps of a scene on which no load acts, whose free coordinates count as driven."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import frozen
from ..dynamics.problem_solver import ProblemSolver
from ..problem.acting import AT_ZERO, Acting
from ..problem.samples import Targets, common_shape
from .collect import sweep_of
from .sweep import Sweep

NO_GRAVITY = np.zeros(3)


def unloaded(
    solver: ProblemSolver,
    targets: Targets,
    speeds: Array,
    accelerations: Array,
    gravity: Array = NO_GRAVITY,
    time: Array = AT_ZERO,
    near: tuple[Array, Array] | None = None,
    along_path: bool = False,
) -> Sweep:
    """Return the sweep of a scene without its loads.

    Args:
        solver: of the scene.
        targets: positions of all d coordinates, driven or free.
        speeds: `(..., d)`, which broadcast with the positions [rad/s or m/s].
        accelerations: likewise [rad/s² or m/s²].
        gravity: `(3,)` [m/s²].
        time: at which actuators act [s].
        near: closed coordinates and whole turns there, see `Motion`; the samples repeat them
            along further axes in front.
        along_path: see `Scene.sweep`.

    Raises:
        CardanError: as `Scene.sweep`.
    """
    acting = Acting(speeds, accelerations, frozen({}), frozen({}), gravity, frozen({}), time)
    targets = targets.expanded(common_shape({"position": targets.shape, **acting.shapes}))
    with np.errstate(over="ignore", invalid="ignore"):
        solver = solver.of_varied(targets.varied)
        solver.refuse_too_many(targets.size)
        if near is None:
            assembled = solver.assembled_in_turn(targets, along_path)
        else:
            repeats = targets.size // len(near[0]), 1
            assembled = solver.assembled_near(targets, *(np.tile(item, repeats) for item in near))
        return sweep_of(solver, assembled, acting)


def rows_of(sweep: Sweep, values: Any) -> Array:
    """Return what a sweep has of d coordinates, `(N, d)`: it has no last axis for one of them."""
    return np.asarray(values).reshape(-1, len(sweep.coordinates))
