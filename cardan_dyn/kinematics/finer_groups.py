"""Finer groups: loops solved one after the other where closed loops show that they can be.

How many equations a loop has is counted while it is open, since that needs no closed position. Some
loops have fewer when they are closed: a shaft with a slide between two universal joints can move
in all six ways against its bearing while it is open, but while the joints at both ends are in place
four equations say all. Counted as open, a line of such shafts has more equations than joints, and
would be solved all together.

Equations counted at a closed position divide such a line, but there they may be too few by chance.
So a division is taken only where it is proven: at the start, and at positions around it that
generic displacements of all drives lead to, each group closes its loops, decides all its joints,
and leaves free what earlier groups decide. Then the closed positions around the start are a smooth
surface over the drives. On it, what vanishes around the start vanishes everywhere up to singular
positions, which no motion passes, so that the groups stay divided all over the motion.
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
        groups[index] for index in solved if len(groups[index].loops) > 1 and not groups[index].idle
    ]
    if not divided:
        return groups
    moving = {*passives.tolist(), *drives.tolist()}
    of_open, of_closed = structure.ranks(x, moving), structure.ranks_at(x, moving)
    closed = set().union(*(_items(structure, groups[index]) for index in solved))
    while True:
        trusted = {loop for group in divided for loop in group.loops}
        if all(of_closed[loop] == of_open[loop] for loop in trusted):
            return groups
        counted = [
            of_closed[loop] if loop in trusted else rank for loop, rank in enumerate(of_open)
        ]
        finer = partition(structure, x, drives, passives, loop_ranks=counted)
        if _count(finer) <= _count(groups):
            return groups
        doubtful = _unproven(structure, groups, finer, x, drives, closed)
        if not doubtful:
            return finer
        left = [group for group in divided if not any(_share(group, other) for other in doubtful)]
        if len(left) == len(divided):
            return groups
        divided = left


def _unproven(
    structure: Structure,
    groups: list[Group],
    finer: list[Group],
    x: Array,
    drives: Array,
    closed: set[int],
) -> list[Group]:
    """Return which of the finer groups are not proven.

    Args:
        structure: of the mechanism.
        groups: from open loops; those of them that are among the finer ones need no proof.
        finer: the groups in question.
        x: `(size,)` closed coordinates.
        drives: velocity coordinates of the drives.
        closed: the loops and couplings that are closed there.
    """
    known = {_identity(group) for group in groups}
    is_known = [_identity(group) in known for group in finer]
    items = [_items(structure, group) for group in finer]
    open_ones = [
        group
        for group, own, is_old in zip(finer, items, is_known, strict=True)
        if not (is_old or own <= closed)
    ]
    if open_ones:
        return open_ones
    chosen = [index for index, own in enumerate(items) if own and own <= closed]
    solvers = [GroupSolver(structure.mechanism, finer[index]) for index in chosen]
    kinematics = Kinematics(structure.mechanism.coordinates, drives, solvers)
    new = [local for local, index in enumerate(chosen) if not is_known[index]]
    refuted = _refuted_at(kinematics, new, x) or _refuted_around(kinematics, new, x)
    return [solvers[index].group for index in refuted]


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


def _refuted_around(kinematics: Kinematics, new: list[int], x: Array) -> list[int]:
    """Return which of the new groups do not follow generic displacements of all drives.

    A group does if it closes its loops, decides its joints at all these positions, and no others,
    and if all groups do whose motion it depends on.

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
        states = kinematics.close(guess).groups
    refuted, undecided = [], set[int]()
    for index, state in enumerate(states):
        follows = undecided.isdisjoint(state.group.known.tolist())
        follows = follows and bool(np.all(state.residual < CLOSURE_TOLERANCE))
        if index in new:
            follows = follows and _decides(state)
        if not follows:
            refuted += [index] if index in new else []
            undecided |= set(state.group.passives.tolist())
    return refuted


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


def _share(first: Group, second: Group) -> bool:
    """Return whether two groups have loops, couplings, or joints that they decide, in common."""
    return not (
        set(first.loops).isdisjoint(second.loops)
        and set(first.couplings).isdisjoint(second.couplings)
        and set(first.passives.tolist()).isdisjoint(second.passives.tolist())
    )


def _count(groups: list[Group]) -> int:
    """Return how many groups have loops or couplings."""
    return sum(bool(group.loops or group.couplings) for group in groups)


def _identity(group: Group) -> tuple[object, ...]:
    return group.loops, group.couplings, tuple(group.passives.tolist())
