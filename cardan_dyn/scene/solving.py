"""Solving: a sweep, or assembled positions, from what a user asks for."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, is_column
from ..dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..errors import ArgumentError
from ..problem.samples import acting_on, common_shape, targets_of
from ..results.collect import sweep_of
from ..results.sweep import Sweep

_OVERFLOW: Any = {"over": "ignore", "invalid": "ignore"}
"""NumPy need not warn of numbers that overflow: results that contain them are refused."""


class Asked(NamedTuple):
    """What a sweep is asked for, unchecked; see `Scene.sweep`."""

    position: Any
    speed: object = 0.0
    acceleration: object = 0.0
    held: object = None
    loads: object = None
    gravity: object = None
    inertia: object = None
    along_path: bool = False
    workers: int = 1
    time: object = 0.0


def assembled(solver: ProblemSolver, asked: Asked) -> AssembledPositions:
    """Return closed positions; see `Scene.assemble`."""
    targets = targets_of(solver.problem, asked.position, asked.held)
    with np.errstate(**_OVERFLOW):
        return solver.of_varied(targets.varied).assemble(targets, asked.along_path)


def swept(solver: ProblemSolver, asked: Asked) -> Sweep:
    """Return what is solved and proven; see `Scene.sweep`."""
    acting = acting_on(
        solver.problem,
        asked.speed,
        asked.acceleration,
        asked.loads,
        asked.gravity,
        asked.inertia,
        asked.time,
    )
    with np.errstate(**_OVERFLOW):
        if isinstance(asked.position, AssembledPositions):
            positions = _again(solver, asked.position, asked)
            shape = positions.shape
            if asked.position.targets.was_column:
                # As if the positions were given here, and not to `assemble`.
                whole = common_shape({"position": (*shape, 1), **acting.shapes})
                shape = shape if is_column(whole) else (*shape, 1)
                acting = acting.without_columns() if is_column(whole) else acting
            if common_shape({"position": shape, **acting.shapes}) != shape:
                listed = ", ".join(f"{name} {size}" for name, size in acting.shapes.items() if size)
                raise ArgumentError(
                    f"the positions were assembled in shape {shape}, which these exceed: {listed}; "
                    "give the positions an axis for each of theirs"
                )
        else:
            shapes = acting.shapes
            targets = targets_of(solver.problem, asked.position, asked.held, shapes)
            if targets.was_column:
                acting = acting.without_columns()
                shapes = acting.shapes
            shape = common_shape({"position": targets.shape, **shapes})
            solver = solver.of_varied(targets.varied)
            positions = solver.assembled_in_turn(targets.expanded(shape), asked.along_path)
        solver = positions.solver
        solution = solver.solve(positions, acting, asked.workers)
    return sweep_of(solver, positions, acting, solution)


def reachable(solver: ProblemSolver, asked: Asked) -> Array:
    """Return which positions can be reached; see `Scene.reachable`."""
    targets = targets_of(solver.problem, asked.position, asked.held)
    with np.errstate(**_OVERFLOW):
        is_there = solver.of_varied(targets.varied).assembly.reachable(targets)
    return is_there.reshape(targets.shape)


def _again(
    solver: ProblemSolver, assembled: AssembledPositions, asked: Asked
) -> AssembledPositions:
    """Return positions that were assembled before.

    Raises:
        ArgumentError: they are those of another scene, or were assembled in another way.
    """
    if asked.along_path and not assembled.along_path:
        raise ArgumentError(
            "along_path: these positions were assembled along straight lines; write "
            "assemble(..., along_path=True)"
        )
    if asked.held is not None:
        raise ArgumentError(
            "held: these positions were assembled with held joints where they are; write "
            "assemble(..., held=...)"
        )
    return solver.current(assembled)
