"""Finer groups: loops solved one after the other where closed loops show that they can be.

How many equations a loop adds is counted on open loops, since that needs no closed position. Some
loops have fewer while they are closed: a shaft between two universal joints with a slide in it may
be bent and twisted in any way while it is open, but only two of these six equations are left for
the slide once both its joints are in place. A line of such shafts counts as more equations than
joints, which would have to be solved all together.

Equations counted at a closed position divide such a line, but they may be too few there by chance.
So a division is taken only if it is proven at closed positions: every group decides all its joints,
and whatever other equations it has leave what earlier groups decide free. Where that holds at the
start and, for generic displacements of all drives, around it, the positions with closed loops are a
smooth surface over the drives, on which ranks change at singular positions alone.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..arrays import Array, generic
from .all_groups import Kinematics
from .group_solver import GroupSolver
from .group_state import GroupState
from .loop_groups import Group, partition
from .stacked import ranks
from .structure import Structure
from .tolerances import CLOSURE_TOLERANCE, REGULAR_CONDITION

_STATES = 6
"""Positions around the start. Any one of them shows what a generic displacement shows; the others
catch displacements that happen to be special."""
_AROUND = 0.05
"""Greatest displacement of a drive [rad, or lengths of the mechanism]: what goes wrong with even
the fourth power of it is 6e-6, far from closed, and nearly all mechanisms can move that far."""


def finer_groups(
    structure: Structure,
    groups: list[Group],
    solved: Iterable[int],
    x: Array,
    drives: Array,
    passives: Array,
) -> list[Group]:
    """Return finer groups that are proven around a closed position; the same ones if none are.

    Args:
        structure: of the mechanism.
        groups: from `partition`, with the equations of open loops.
        solved: indices of those whose loops are closed and whose motion is solved.
        x: `(size,)` closed coordinates.
        drives: velocity coordinates of the drives.
        passives: velocity coordinates that are neither driven nor held.
    """
    # Rods that spin idly stay together with all that touches them.
    divided = [
        _items(structure, groups[index])
        for index in solved
        if len(groups[index].loops) > 1 and not groups[index].idle
    ]
    if not divided:
        return groups
    moving = {*passives.tolist(), *drives.tolist()}
    of_open, of_closed = structure.ranks(x, moving), structure.ranks_at(x, moving)
    closed_items = set().union(*(_items(structure, groups[index]) for index in solved))
    while divided := [items for items in divided if _has_fewer(items, of_closed, of_open)]:
        trusted = set().union(*divided)
        counted = [
            of_closed[loop] if loop in trusted else rank for loop, rank in enumerate(of_open)
        ]
        finer = partition(structure, x, drives, passives, loop_ranks=counted)
        if _count(finer) <= _count(groups):
            break
        solvers = [
            GroupSolver(structure.mechanism, group)
            for group in finer
            if _items(structure, group) & closed_items
        ]
        kinematics = Kinematics(structure.mechanism.coordinates, drives, solvers)
        known = {_identity(group) for group in groups}
        new = [index for index, item in enumerate(solvers) if _identity(item.group) not in known]
        refuted = _refuted_at(kinematics, new, x)
        if not refuted:
            return finer if _is_proven_around(kinematics, new, x) else groups
        doubtful = set().union(*(_items(structure, solvers[k].group) for k in refuted))
        divided = [items for items in divided if items.isdisjoint(doubtful)]
    return groups


def _refuted_at(kinematics: Kinematics, new: list[int], x: Array) -> list[int]:
    """Return which of the new groups do not decide all their joints, and no others, at a position.

    Args:
        kinematics: of the finer groups, with all rows.
        new: indices of the new groups.
        x: `(size,)` closed coordinates.
    """
    solvers = [kinematics.solvers[index] for index in new]
    states = [solver.evaluate(x[None, :], solver.equations.full())[0] for solver in solvers]
    return [
        index
        for index, state in zip(new, states, strict=True)
        if not (_decides(state) and float(state.condition[0]) < REGULAR_CONDITION)
    ]


def _is_proven_around(kinematics: Kinematics, new: list[int], x: Array) -> bool:
    """Return whether new groups close the loops around a position, and decide their joints there.

    Args:
        kinematics: of the finer groups, with all rows.
        new: indices of the new groups.
        x: `(size,)` closed coordinates.
    """
    coordinates, drives = kinematics.coordinates, kinematics.drives
    columns = coordinates.column_of(drives)
    guess = np.repeat(x[None, :], _STATES, axis=0)
    guess[:, columns] += _AROUND * generic(_STATES, len(drives)) / coordinates.scale[columns]
    with np.errstate(all="ignore"):  # Where a drive cannot move that far, steps may overflow.
        state = kinematics.close(guess)
        if not np.all(state.residual < CLOSURE_TOLERANCE):
            return False
    return all(_decides(state.groups[index]) for index in new)


def _decides(state: GroupState) -> bool:
    """Return whether a group decides all its joints at all positions, and nothing else.

    Its other equations leave free what moves its joints, and hold wherever that goes.
    """
    own, rank = state.scaled_rows, state.scaled_rows.shape[1] - len(state.group.idle)
    return bool(np.all(ranks(own) == rank) and np.all(ranks(state.all_scaled_rows) == rank))


def _items(structure: Structure, group: Group) -> set[int]:
    """Return the loops and couplings of a group, the latter counted after all loops."""
    loops = len(structure.mechanism.loops)
    return {*group.loops, *(loops + index for index in group.couplings)}


def _has_fewer(items: set[int], ranks_now: list[int], ranks_open: list[int]) -> bool:
    """Return whether any loop among some items has fewer equations than while it is open."""
    return any(
        now < reached
        for loop, (now, reached) in enumerate(zip(ranks_now, ranks_open, strict=True))
        if loop in items
    )


def _count(groups: list[Group]) -> int:
    """Return how many groups have loops or couplings."""
    return sum(bool(group.loops or group.couplings) for group in groups)


def _identity(group: Group) -> tuple[object, ...]:
    return group.loops, group.couplings, tuple(group.passives.tolist())
