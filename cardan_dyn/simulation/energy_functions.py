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
from .forces import Forces
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


def energy_functions(solver: ProblemSolver, forces: Forces | None = None) -> EnergyFunctions:
    """Return inertia and force over a period of the drive.

    The mechanism at position φ moves with the kinetic energy I(φ) φ̇² / 2, and
    I φ̈ + I' φ̇² / 2 = Q.

    Args:
        solver: of a scene with one drive.
        forces: constant loads and springs that belong to the force; the weight alone if None.

    Raises:
        NotSuitableError: the drive does not turn through, or the functions are too uneven.
    """
    try:
        period = solver.assembly.period()
    except CardanError as error:
        raise NotSuitableError(str(error)) from error
    if period is None:
        raise NotSuitableError("the mechanism does not come back to itself")
    if forces is not None and solver.problem.elements:
        ends, _ = _efforts(solver, np.array([0.0, period]), forces)
        if abs(ends[1, 1] - ends[1, 0]) > _PERIODIC * np.max(np.abs(ends[1])):
            raise NotSuitableError("springs wind up as the drive turns")
    samples, count, condition = np.zeros((2, 0)), _FEWEST, 1.0
    while True:
        samples, worst = _on_grid(solver, samples, period / count, count, forces)
        condition = max(condition, worst)
        tolerance = _ROUNDING * np.finfo(float).eps * condition
        if np.max(np.abs(samples[1])) <= tolerance * _greatest_force(solver, forces):
            # What balances leaves nothing but rounding, which no series resolves.
            samples[1] = 0.0
        functions = Fourier.of(samples, period)
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


def _greatest_force(solver: ProblemSolver, forces: Forces | None) -> float:
    """Return how great a force weight and loads could be along the drive, if they did not balance.

    Of the order of the moments that they exert over the characteristic length.
    """
    problem = solver.problem
    length = problem.mechanism.characteristic_length
    mass = sum(item.mass for item in problem.mechanism.model.inertias)
    greatest = mass * length * float(np.linalg.norm(problem.gravity))
    if forces is not None:
        greatest += sum(float(np.max(np.abs(item))) for item in forces.joint_loads.values())
        for load in forces.link_loads.values():
            greatest += length * float(np.linalg.norm(load.force))
            greatest += float(np.linalg.norm(load.moment))
    return greatest


def _on_grid(
    solver: ProblemSolver, known: Array, step: float, count: int, forces: Forces | None
) -> tuple[Array, float]:
    """Return inertia and force `(2, count)` at equidistant positions, and the worst condition.

    Args:
        solver: of a scene with one drive.
        known: `(2, K)` of a coarser grid, K a part of `count`.
        step: between positions.
        count: number of positions.
        forces: see `energy_functions`.
    """
    is_new = np.ones(count, dtype=bool)
    if known.size:
        is_new[:: count // known.shape[1]] = False
    values = np.empty((2, count))
    values[:, ~is_new] = known
    values[:, is_new], worst = _efforts(solver, np.nonzero(is_new)[0] * step, forces)
    return values, worst


def without_elements(solver: ProblemSolver) -> ProblemSolver:
    """Return the solver of the same scene without force elements."""
    if not solver.problem.elements:
        return solver
    return ProblemSolver(replace(solver.problem, elements=()), like=solver)


def _efforts(solver: ProblemSolver, positions: Array, forces: Forces | None) -> tuple[Array, float]:
    """Return inertia and force `(2, N)` at positions, and the greatest condition number."""
    problem = solver.problem
    rate = problem.mechanism.coordinates.named[problem.drives[0]].rate
    shape, none = (len(positions),), np.zeros((len(positions), 1))
    rest = acting_on(problem, loads={}, gravity=np.zeros(3))._replace(
        joint_loads=frozen({}), link_loads=frozen({})
    )
    bare = without_elements(solver)
    assembled = bare.assemble(Targets.of_positions(positions[:, None]))
    pushed = bare.solve(assembled, rest._replace(accelerations=none + 1.0).flat(shape))
    values = np.zeros((2, len(positions)))
    values[0] = pushed.efforts[:, rate]
    condition = float(np.max(pushed.condition))
    acting = rest._replace(gravity=problem.gravity)
    if forces is not None:
        loads = frozen(forces.joint_loads), frozen(forces.link_loads)
        acting = acting._replace(joint_loads=loads[0], link_loads=loads[1])
        if bare is not solver:
            assembled = solver.assemble(Targets.of_positions(positions[:, None]))
    has_loads = acting.joint_loads or acting.link_loads or (forces is not None and problem.elements)
    if np.any(problem.gravity) or has_loads:
        held = (bare if forces is None else solver).solve(assembled, acting.flat(shape))
        values[1] = -held.efforts[:, rate]
        condition = max(condition, float(np.max(held.condition)))
    return values, condition
