"""Inertia: mass matrix and bias of the equation of motion in the coordinates of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import flag, numbers
from ..dynamics.problem_solver import ProblemSolver
from ..problem.samples import Targets, drive_values, targets_of
from .unloaded import unloaded

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def mass_matrix_of(solver: ProblemSolver, targets: Targets, along_path: bool = False) -> Array:
    """Return mass matrices `(..., n, n)` at positions of all coordinates; see `Scene.mass_matrix`.

    Raises:
        CardanError: as `Scene.sweep`.
    """
    bare = solver.complete.without_elements
    count = len(bare.problem.independent)
    still, near = np.zeros(count), None
    if along_path:
        there = unloaded(bare, targets, still, still, along_path=True).motion
        near = there.x, there.turns
    # A sample for each column, in front of the positions, so that errors count these.
    unit = np.eye(count).reshape(count, *[1] * len(targets.shape), count)
    sweep = unloaded(bare, targets, still, unit, near=near)
    columns = np.reshape(sweep.drive_effort, (count, *targets.shape, count))
    matrices = np.moveaxis(columns, 0, -1)
    return 0.5 * (matrices + np.swapaxes(matrices, -1, -2))


def bias_of(
    solver: ProblemSolver,
    position: object,
    speed: object,
    held: Mapping[str, ArrayLike] | None,
    time: object,
    along_path: object,
) -> Array:
    """Return biases `(..., n)`; see `Scene.bias`."""
    every = solver.complete
    problem = every.problem
    sweep = unloaded(
        every,
        targets_of(problem, position, held),
        drive_values("speed", speed, problem),
        np.zeros(len(problem.independent)),
        problem.gravity,
        numbers("time", time),
        along_path=flag("along_path", along_path),
    )
    return np.reshape(sweep.drive_effort, (*sweep.shape, -1))
