"""Energy functions: inertia and force of a mechanism with one drive, over its position."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..errors import CardanError
from ..frozen import frozen
from ..problem.samples import Acting, Targets
from .fourier import Fourier

_FEWEST, _MOST = 64, 8192
"""Positions per period: the first number, which is doubled, and the greatest."""
_ROUNDING = 20.0
"""Rounding errors of an effort, in eps times its condition number, below which coefficients are."""


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
    samples, count, condition = np.zeros((2, 0)), _FEWEST, 1.0
    while True:
        samples, worst = _on_grid(solver, samples, period / count, count, with_loads)
        condition = max(condition, worst)
        functions = Fourier.of(samples, period)
        tolerance = _ROUNDING * np.finfo(float).eps * condition
        tail = float(np.max(functions.tail()))
        if tail < tolerance:
            inertia, force = (
                Fourier(functions.coefficients[[index]], functions.frequency)
                for index in range(2)
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


def _efforts(solver: ProblemSolver, positions: Array, with_loads: bool) -> tuple[Array, float]:
    """Return inertia and force `(2, N)` at positions, and the greatest condition number."""
    problem = solver.problem
    rate = problem.mechanism.coordinates.named[problem.drives[0]].rate
    assembled = solver.assemble(Targets.of_positions(positions[:, None]))
    shape, none = (len(positions),), np.zeros((len(positions), 1))
    rest = Acting(none, none, frozen({}), frozen({}), np.zeros((1, 3)), frozen({}))
    pushed = solver.solve(assembled, rest._replace(accelerations=none + 1.0))
    values = np.zeros((2, len(positions)))
    values[0] = pushed.efforts[:, rate]
    condition = float(np.max(pushed.condition))
    joint_loads = problem.joint_loads if with_loads else frozen({})
    link_loads = problem.link_loads if with_loads else frozen({})
    if np.any(problem.gravity) or joint_loads or link_loads:
        acting = rest._replace(
            joint_loads=joint_loads, link_loads=link_loads, gravity=problem.gravity[None, :]
        )
        held = solver.solve(assembled, acting.flat(shape))
        values[1] = -held.efforts[:, rate]
        condition = max(condition, float(np.max(held.condition)))
    return values, condition
