"""Energy functions: inertia and force of a mechanism with one drive, over its position."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..errors import CardanError
from ..frozen import frozen
from ..problem.samples import Targets, acting_on
from .fourier import Fourier

_FEWEST, _MOST = 64, 8192
"""Positions per period: the first number, which is doubled, and the greatest."""
_ROUNDING = 20.0
"""Rounding errors of an effort, in eps times its condition number, below which coefficients are."""


_PERIODIC = 1e-9
"""Difference of forces a period apart, as a fraction of them, that counts as none."""


class NotSuitableError(Exception):
    """A method of simulation does not suit a scene; another one is taken. Never leaves here."""


class EnergyFunctions(NamedTuple):
    """Inertia and force along the only drive.

    Attributes:
        inertia: `I(φ)` [kg·m² or kg].
        force: `Q(φ)` of weight, loads and springs at rest [N·m or N].
        error: of both, relative to their greatest values.
    """

    inertia: Fourier
    force: Fourier
    error: float


def energy_functions(solver: ProblemSolver, with_loads: bool) -> EnergyFunctions:
    """Return inertia and force over a period of the drive.

    The mechanism at position φ moves with the kinetic energy I(φ) φ̇² / 2, and
    I φ̈ + I' φ̇² / 2 = Q.

    Args:
        solver: of a scene with one drive.
        with_loads: whether the constant loads of the scene belong to the force.

    Raises:
        NotSuitableError: the drive does not turn through, or the functions are too uneven.
    """
    try:
        period = solver.assembly.period()
    except CardanError as error:
        raise NotSuitableError(str(error)) from error
    if period is None:
        raise NotSuitableError("the mechanism does not come back to itself")
    if with_loads and solver.problem.elements:
        ends, _ = _efforts(solver, np.array([0.0, period]), with_loads)
        if abs(ends[1, 1] - ends[1, 0]) > _PERIODIC * np.max(np.abs(ends[1])):
            raise NotSuitableError("springs wind up as the drive turns")
    samples, count, condition = np.zeros((2, 0)), _FEWEST, 1.0
    while True:
        samples, worst = _on_grid(solver, samples, period / count, count, with_loads)
        condition = max(condition, worst)
        functions = Fourier.of(samples, period)
        tolerance = _ROUNDING * np.finfo(float).eps * condition
        tail = float(np.max(functions.tail()))
        if tail < tolerance:
            inertia, force = (
                Fourier(functions.coefficients[[index]], functions.frequency) for index in range(2)
            )
            return EnergyFunctions(inertia, force, tolerance)
        # Coefficients fall exponentially, so that the tail tells how many will do.
        factor = np.log(tolerance) / np.log(min(tail, 0.5))
        count *= 2 ** max(1, int(np.ceil(np.log2(factor))))
        if count > _MOST:
            raise NotSuitableError(f"{_MOST} positions do not resolve the inertia over a turn")


def _on_grid(
    solver: ProblemSolver, known: Array, step: float, count: int, with_loads: bool
) -> tuple[Array, float]:
    """Return inertia and force `(2, count)` at equidistant positions, and the worst condition.

    Args:
        solver: of a scene with one drive.
        known: `(2, K)` of a coarser grid, K a part of `count`.
        step: between positions.
        count: number of positions.
        with_loads: see `energy_functions`.
    """
    is_new = np.ones(count, dtype=bool)
    if known.size:
        is_new[:: count // known.shape[1]] = False
    values = np.empty((2, count))
    values[:, ~is_new] = known
    values[:, is_new], worst = _efforts(solver, np.nonzero(is_new)[0] * step, with_loads)
    return values, worst


def without_elements(solver: ProblemSolver) -> ProblemSolver:
    """Return the solver of the same scene without force elements."""
    if not solver.problem.elements:
        return solver
    return ProblemSolver(replace(solver.problem, elements=()), like=solver)


def _efforts(solver: ProblemSolver, positions: Array, with_loads: bool) -> tuple[Array, float]:
    """Return inertia and force `(2, N)` at positions, and the greatest condition number."""
    problem = solver.problem
    rest = acting_on(problem, loads={}, gravity=np.zeros(3))._replace(
        joint_loads=frozen({}), link_loads=frozen({})
    )
    bare = without_elements(solver)
    assembled = bare.assemble(Targets.of_positions(positions[:, None]))
    pushed = bare.solve(assembled, rest._replace(accelerations=np.ones(1)))
    values = np.zeros((2, len(positions)))
    values[0] = pushed.efforts[:, 0]
    condition = float(np.max(pushed.condition))
    acting = rest._replace(gravity=problem.gravity)
    if with_loads:
        acting = acting._replace(joint_loads=problem.joint_loads, link_loads=problem.link_loads)
        if bare is not solver:
            assembled = solver.assemble(Targets.of_positions(positions[:, None]))
    has_loads = acting.joint_loads or acting.link_loads or (with_loads and problem.elements)
    if np.any(problem.gravity) or has_loads:
        held = (solver if with_loads else bare).solve(assembled, acting)
        values[1] = -held.efforts[:, 0]
        condition = max(condition, float(np.max(held.condition)))
    return values, condition
