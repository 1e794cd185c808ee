"""Far: close loops from far away, where Newton's method leads nowhere.

Descriptions often give positions of the joints in which the loops are not quite closed, or not at
all. `closed_from` lowers the closure error wherever it starts; `assembled_near` tries other starts
where that ends in a minimum of the error; `states_around` leaves closed configurations at which
fewer closure equations are independent than anywhere else (dead points, change points).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, Array, generic
from ...proof.closed_positions import refuse_left
from ..loops.groups import independent_groups
from ..loops.structure import Structure
from ..tolerances import AROUND, CLOSURE_TOLERANCE, LONGEST_WAY, STATES_AROUND
from .group_solver import GroupSolver, GroupState, solver_of
from .stacked import ranks, times, transposed

_MOST_STEPS = 200
"""Greatest number of steps. From half a radian off some 10 suffice; in narrow curved valleys of the
error, as near singular configurations, steps become short."""
_CLOSED = 1e-13
"""Closure error at which a start is closed: some hundred times the rounding of its equations, which
are solved as normal equations and so come no nearer where they are badly conditioned."""
_FIRST_DAMPING = 1e-3
"""First damping relative to the greatest diagonal element of the normal equations: small, so that
starts from nearby take steps like Newton's, and it grows fourfold with every step refused."""
_LEAST_GAIN = 1e-3
"""Least ratio of the actual to the predicted fall of the squared error of a step that is taken."""
_AMPLITUDES = (0.02, 0.1, 0.3, 1.0, np.pi)
"""Greatest displacements [rad, or lengths of the mechanism] of further starts: small ones leave a
singular position, from which no step leads away, and keep the assembly mode; large ones find a
closed configuration wherever it is."""
_STARTS = 12
"""Starts per amplitude. They are solved together, and the search ends with the first amplitude that
leads to closed loops."""


def closed_from(solver: GroupSolver, x: Array) -> tuple[Array, Array]:
    """Close the loops of a group from starts that may be far from closed.

    Args:
        solver: of the group; its passives move.
        x: `(N, size)` coordinates to start from; kept as they are.

    Returns:
        Coordinates `(N, size)` and closure errors `(N,)` that were reached; the caller judges them.
    """
    x = x.copy()
    matrices, error, residual = solver.linearised(x)
    squares = np.sum(error**2, axis=1)
    normal = matrices @ transposed(matrices)
    greatest = np.max(np.diagonal(normal, axis1=1, axis2=2), axis=1, initial=1e-300)
    damping, growth = _FIRST_DAMPING * greatest, np.full(len(x), 2.0)
    # Less would be lost in the rounding of the normal equations, which may be singular without.
    rounding = matrices.shape[1] * EPS
    identity = np.eye(matrices.shape[1])
    for _ in range(_MOST_STEPS if matrices.shape[1] else 0):
        (active,) = np.nonzero((residual > _CLOSED) & np.isfinite(damping))
        if not active.size:
            break
        rows = matrices[active]
        gradient = times(rows, error[active])
        shifted = rows @ transposed(rows) + damping[active, None, None] * identity
        step = -np.linalg.solve(shifted, gradient[:, :, None])[:, :, 0]
        longest = np.max(np.abs(step), axis=1)
        step *= np.minimum(1.0, LONGEST_WAY / np.maximum(longest, LONGEST_WAY))[:, None]
        linear = error[active] + times(transposed(rows), step)
        predicted = squares[active] - np.sum(linear**2, axis=1)
        tried = solver.moved(x[active], step)
        new_matrices, new_error, new_residual = solver.linearised(tried)
        new_squares = np.sum(new_error**2, axis=1)
        # Comparisons with numbers that are not finite are false, so these steps are not taken.
        gain = np.minimum((squares[active] - new_squares) / np.maximum(predicted, 1e-300), 1.0)
        taken = gain > _LEAST_GAIN
        better = active[taken]
        x[better], matrices[better], error[better] = (
            tried[taken],
            new_matrices[taken],
            new_error[taken],
        )
        residual[better], squares[better] = new_residual[taken], new_squares[taken]
        # Nielsen's rule: damping falls smoothly where the linear model holds, else grows faster
        # and faster.
        damping[better] *= np.maximum(1.0 / 3.0, 1.0 - (2.0 * gain[taken] - 1.0) ** 3)
        np.maximum(damping, rounding * greatest, out=damping)
        growth[better] = 2.0
        worse = active[~taken]
        damping[worse] *= growth[worse]
        growth[worse] *= 2.0
        # In a minimum of the error, no step lowers it by more than rounding.
        damping[active[predicted <= rounding * squares[active]]] = np.inf
    return x, residual


def assembled_near(
    structure: Structure, x: Array, free: Array, needed: Array
) -> tuple[Array, float]:
    """Return a closed configuration near one that may be far from closed.

    Args:
        structure: of the mechanism.
        x: `(size,)` coordinates to start from.
        free: velocity coordinates that may move.
        needed: velocity coordinates whose loops are closed; others stay as they are.

    Returns:
        Coordinates `(size,)` and their closure error. The error is the least that was found where
        loops could not be closed.
    """
    mechanism, worst, wanted = structure.mechanism, 0.0, set(needed.tolist())
    groups = [
        group
        for group in independent_groups(structure, free)
        # Of a loop all of whose joints are pinned, no coordinate is free; it has to be closed too.
        if any(
            not wanted.isdisjoint(structure.coordinates_on(item)) for item in group.items(structure)
        )
    ]
    moving = {column for group in groups for column in group.passives.tolist()}
    # What the joint of a loop can make up for, no other joint has to.
    x = mechanism.fitted(x, set(range(mechanism.model.nv)) - moving)
    for group in groups:
        before = x
        x, residual = _closed_group(solver_of(mechanism, group), before)
        if residual < CLOSURE_TOLERANCE:
            refuse_left(mechanism, group.loops, group.couplings, before, x)
        worst = max(worst, residual)
    return x, worst


def _closed_group(solver: GroupSolver, x: Array) -> tuple[Array, float]:
    """Return coordinates in which the loops of a group are closed, and the closure error."""
    best, residual = closed_from(solver, x[None, :])
    if residual[0] < CLOSURE_TOLERANCE:
        return best[0], float(residual[0])
    # The same starts in every call, so that a scene starts in the same configuration every time.
    generator = np.random.default_rng(7)
    least, least_residual = best[0], float(residual[0])
    for amplitude in _AMPLITUDES:
        step = generator.uniform(-amplitude, amplitude, (_STARTS, len(solver.group.passives)))
        starts = solver.moved(np.repeat(x[None, :], _STARTS, axis=0), step)
        reached, residual = closed_from(solver, starts)
        closed = residual < CLOSURE_TOLERANCE
        if np.any(closed):
            reached, residual = reached[closed], residual[closed]
            apart = solver.coordinates.apart(reached, x)
            nearest = int(np.argmin(np.linalg.norm(apart, axis=1)))
            return reached[nearest], float(residual[nearest])
        if np.min(residual) < least_residual:
            index = int(np.argmin(residual))
            least, least_residual = reached[index], float(residual[index])
    return least, least_residual


class GenericStates(NamedTuple):
    """Closed configurations of loops and couplings that have no joint in common with others.

    Attributes:
        x: `(K, size)` closed configurations in which as many equations as possible are independent;
            the one that they lie around is the first, if it is one of them.
        group: their closure equations there, all of them.
        rank: how many are independent there.
        rank_at_start: how many are independent at the coordinates that were given, or where the
            loops are assembled near them.
    """

    x: Array
    group: GroupState
    rank: int
    rank_at_start: int


def generic_states(
    structure: Structure, most_coordinates: int, x: Array
) -> list[GenericStates | GroupSolver]:
    """Return generic states of all independent sets of loops and couplings.

    Args:
        structure: of the mechanism.
        most_coordinates: of a set; of a larger one only its solver is returned.
        x: `(size,)` coordinates near which the loops are closed.

    Raises:
        AssemblyError: loops cannot be closed.
    """
    mechanism = structure.mechanism
    every = np.arange(mechanism.model.nv)
    result: list[GenericStates | GroupSolver] = []
    for group in independent_groups(structure, every):
        solver = solver_of(mechanism, group)
        if group.passives.size > most_coordinates:
            result.append(solver)
            continue
        first, residual = assembled_near(structure, x, every, group.passives)
        if not residual < CLOSURE_TOLERANCE:
            _, worst = assembled_near(structure, x, every, every)
            from ..diagnosis.reach import unclosed  # Imported here: only errors need it.

            raise unclosed(mechanism, worst)
        result.append(states_around(solver, first))
    return result


def states_around(solver: GroupSolver, first: Array) -> GenericStates:
    """Return generic states around closed coordinates `(size,)`; only the passives move."""
    step = AROUND * generic(STATES_AROUND, len(solver.group.passives))
    step[0] = 0.0
    starts = solver.moved(np.repeat(first[None, :], STATES_AROUND, axis=0), step)
    reached, residual = closed_from(solver, starts)
    is_closed = residual < CLOSURE_TOLERANCE
    # The first one was closed by the caller, if only to the rounding of its badly conditioned rows.
    is_closed[0] = True
    reached = reached[is_closed]
    full = solver.equations.full
    state = solver.evaluate(reached, full)
    rank = ranks(state.scaled_rows)
    greatest = int(np.max(rank))
    reached = reached[rank == greatest]
    regular = solver.evaluate(reached, full)
    return GenericStates(reached, regular, greatest, int(rank[0]))
