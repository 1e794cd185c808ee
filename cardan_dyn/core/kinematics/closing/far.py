"""Far: close loops from far away, where Newton's method leads nowhere.

Descriptions often give positions of the joints in which the loops are not quite closed, or not at
all. `closed_from` lowers the closure error wherever it starts, `starts_about` says where else to
start; `assembled_near` does so where that ends in a minimum of the error; `states_around` leaves
closed configurations at which fewer closure equations are independent than anywhere else (dead
points, change points).
"""

from __future__ import annotations

from collections.abc import Container
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, ROUNDED, Array, generic
from ...proof.closed_positions import refuse_left
from ..loops.groups import independent_groups
from ..loops.structure import Structure
from ..tolerances import AROUND, CLOSURE_TOLERANCE, CONFIGURATIONS, LONGEST_WAY
from .group_solver import MOST_STEPS, GroupSolver, GroupState, solver_of
from .stacked import ranks, times, transposed

_STARTS = 24
"""Starts about a place: some for each assembly mode, of which robots have sixteen at most."""


def starts_about(solver: GroupSolver, x: Array, reach: float, still: Container[int] = ()) -> Array:
    """Return coordinates `(K, size)` about others, the same ones in every call.

    Args:
        solver: of a group; its passives are displaced.
        x: `(size,)` coordinates, or `(K, size)`.
        reach: greatest displacement [rad, or lengths of the mechanism].
        still: velocity coordinates that stay.
    """
    passives = solver.group.passives
    step = reach * generic(_STARTS, len(passives))
    step[:, [rate in still for rate in passives.tolist()]] = 0.0
    return solver.moved(np.broadcast_to(x, (_STARTS, x.shape[-1])), step)


def closed_from(solver: GroupSolver, x: Array) -> tuple[Array, Array]:
    """Close the loops of a group from starts that may be far from closed.

    Steps are damped by the square of the error at most: from nearby they are Newton's. What is
    closed is improved until rounding refuses a step.

    Args:
        solver: of the group; its passives move.
        x: `(N, size)` coordinates to start from; kept as they are.

    Returns:
        Coordinates `(N, size)` and closure errors `(N,)` that were reached; the caller judges them.

    Source: Yamashita and Fukushima (2001); Nielsen (1999) for damping after a step.
    """
    x, size = x.copy(), len(solver.group.passives)
    matrices, error, residual = solver.linearised(x)
    squares = np.sum(error**2, axis=1)
    # What rounding alone keeps open stays as it is.
    damping, growth = np.where(residual > ROUNDED, squares, np.inf), np.full(len(x), 2.0)
    for _ in range(MOST_STEPS if size else 0):
        (active,) = np.nonzero((residual > EPS) & np.isfinite(damping))
        if not active.size:
            break
        rows = matrices[active]
        normal = rows @ transposed(rows)
        # Less would be lost in the rounding of the normal equations, which may be singular without.
        least = EPS * np.trace(normal, axis1=1, axis2=2)
        shifted = normal + np.maximum(damping[active], least)[:, None, None] * np.eye(size)
        step = -np.linalg.solve(shifted, times(rows, error[active])[:, :, None])[:, :, 0]
        longest = np.max(np.abs(step), axis=1)
        step *= np.minimum(1.0, LONGEST_WAY / np.maximum(longest, LONGEST_WAY))[:, None]
        linear = error[active] + times(transposed(rows), step)
        predicted = squares[active] - np.sum(linear**2, axis=1)
        tried = solver.moved(x[active], step)
        there = solver.linearised(tried)
        new_squares = np.sum(there[1] ** 2, axis=1)
        # Comparisons with numbers that are not finite are false, so these steps are not taken.
        taken = (new_squares < squares[active]) & (predicted > 0.0)
        better, worse = active[taken], active[~taken]
        gain = np.minimum((squares[better] - new_squares[taken]) / predicted[taken], 1.0)
        x[better], squares[better] = tried[taken], new_squares[taken]
        matrices[better], error[better], residual[better] = (own[taken] for own in there)
        # Damping falls smoothly where the linear model holds, else it grows faster and faster.
        fallen = damping[better] * np.maximum(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3)
        damping[better] = np.minimum(fallen, squares[better])
        growth[better] = 2.0
        damping[worse] = np.maximum(damping[worse], least[~taken]) * growth[worse]
        growth[worse] *= 2.0
        # In a minimum of the error, no step lowers it by more than rounding.
        is_least = predicted <= size * EPS * squares[active]
        damping[active[is_least | (~taken & (residual[active] < CLOSURE_TOLERANCE))]] = np.inf
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
    """Return coordinates in which the loops of a group are closed, and the closure error.

    Small displacements leave a singular position, from which no step leads away, and keep the
    assembly mode; large ones find a closed configuration wherever it is.
    """
    least, error = x, np.inf
    for reach in (0.0, *np.geomspace(AROUND, np.pi, 5)):
        reached, residual = closed_from(
            solver, starts_about(solver, x, reach) if reach else x[None, :]
        )
        # Of closed ones the nearest counts.
        away = np.linalg.norm(solver.coordinates.apart(reached, x), axis=1)
        best = int(np.argmin(np.where(residual < CLOSURE_TOLERANCE, away, np.inf)))
        if not residual[best] < CLOSURE_TOLERANCE:
            best = int(np.argmin(residual))
        if residual[best] < error:
            least, error = reached[best], float(residual[best])
        if error < CLOSURE_TOLERANCE:
            break
    return least, error


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


def states_around(solver: GroupSolver, first: Array, count: int = CONFIGURATIONS) -> GenericStates:
    """Return generic ones of some states around closed coordinates; only the passives move.

    Args:
        solver: of the group.
        first: `(size,)` closed coordinates.
        count: number of states that are tried, those among them.
    """
    step = AROUND * generic(count, len(solver.group.passives))
    step[0] = 0.0
    starts = solver.moved(np.broadcast_to(first, (count, len(first))), step)
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
