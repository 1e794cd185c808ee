"""Loop system: the loops of a mechanism, grouped and closed for any choice of drives."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np

from ...kit.arrays import Array, generic
from ..mechanism.mechanism import Mechanism
from .closing.all_groups import Kinematics
from .closing.group_solver import GroupState, solver_of
from .closing.stacked import ranks
from .loops.groups import Group, partition
from .loops.structure import Structure
from .tolerances import AROUND, CLOSURE_TOLERANCE, CONFIGURATIONS, REGULAR_CONDITION


class LoopSystem:
    """The loops of a mechanism with some joints held. Nothing in it changes.

    Attributes:
        mechanism: the mechanism.
        held: names of the held joints, and their positions [rad or m].
    """

    def __init__(self, mechanism: Mechanism, held: dict[str, float]) -> None:
        """Find what each loop depends on.

        Args:
            mechanism: see the attribute.
            held: see the attribute.
        """
        self.mechanism = mechanism
        self.held = held
        self.structure = Structure(mechanism)

    @cached_property
    def _looped_columns(self) -> set[int]:
        """Velocity coordinates that some loop or coupling depends on."""
        paths = range(len(self.structure.paths))
        return {column for index in paths for column in self.structure.coordinates_on(index)}

    def is_on_loops(self, joint: str) -> bool:
        """Return whether a loop or coupling depends on a joint."""
        columns = self.mechanism.coordinates.velocity_columns[joint]
        return columns.start in self._looped_columns

    def groups(self, drives: tuple[str, ...], passives: Array) -> list[Group]:
        """Return the groups in the order in which motion passes through them.

        Args:
            drives: names of the driven joints.
            passives: `(p,)` velocity coordinates that are neither driven nor held.
        """
        coordinates, driven = self.mechanism.coordinates, self._columns(drives)
        x = coordinates.neutral()
        for name, value in self.held.items():
            x[coordinates.named[name].column] = value
        ranks = None
        if len(self.structure.paths) > 1:  # A single loop is solved as a whole.
            ranks = self.structure.ranks(x, {*driven.tolist(), *passives.tolist()})
        key = driven.tobytes(), passives.tobytes(), *(ranks or ())
        return self.mechanism.kept.of(
            "groups",
            key,
            lambda: partition(self.structure, x, driven, passives, loop_ranks=ranks),
        )

    def finer(
        self,
        groups: list[Group],
        drives: tuple[str, ...],
        passives: Array,
        solved: Iterable[int],
        state: Array,
    ) -> list[Group]:
        """Return finer groups that are proven around a closed state, see `finer_groups`.

        Args:
            groups: from `groups`, for the same drives and passives.
            drives: names of the driven joints.
            passives: `(p,)` velocity coordinates that are neither driven nor held.
            solved: indices of the groups whose motion is solved.
            state: `(size,)` closed coordinates; those of other groups need not be.
        """
        solved, driven = list(solved), self._columns(drives)
        key = (
            *(group.key for group in groups),
            *(tuple(solved), state.tobytes(), driven.tobytes(), passives.tobytes()),
        )
        given = self.structure, groups, solved, state, driven, passives
        return self.mechanism.kept.of("finer groups", key, lambda: finer_groups(*given))

    def kinematics(self, drives: tuple[str, ...], groups: list[Group]) -> Kinematics:
        """Return what solves all rows of some groups while some joints are driven."""
        solvers = [solver_of(self.mechanism, group) for group in groups]
        return Kinematics(self.mechanism.coordinates, self._columns(drives), solvers)

    def together(
        self, state: Array, joints: tuple[str, ...], passives: Array, left_out: frozenset[int]
    ) -> Kinematics | None:
        """Return what solves the motion of several joints, each of which may move alone.

        Args:
            state: `(size,)` closed coordinates.
            joints: their names.
            passives: velocity coordinates that follow.
            left_out: see `moved`.

        Returns:
            Kinematics of groups finer than open loops show, see `finer_groups`; None where none are
            proven.
        """
        groups = self.groups(joints, passives)
        finer = self.finer(groups, joints, passives, _needed(groups, left_out), state)
        if finer is groups:
            return None
        needed = [finer[index] for index in _needed(finer, left_out)]
        return self.kinematics(joints, needed).with_open_reductions(state)

    def moved(
        self,
        state: Array,
        joint: str,
        value: float,
        passives: Array,
        left_out: frozenset[int],
        together: Kinematics | None = None,
    ) -> Array:
        """Return the state that a mechanism is in after one joint has moved to a value.

        The passives follow; all other joints rest.

        Args:
            state: `(size,)` closed coordinates.
            joint: name of the joint that moves.
            value: its position afterwards [rad or m].
            passives: velocity coordinates that follow.
            left_out: velocity coordinates that need not follow, since no output needs them.
            together: solves the motion of several joints, this one among them, if it is known.

        Returns:
            `(size,)` closed coordinates.

        Raises:
            AssemblyError: the value cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        coordinate = self.mechanism.coordinates.named[joint]
        column = coordinate.column
        if value == state[column]:
            return state
        if not self.is_on_loops(coordinate.joint):
            state = state.copy()
            state[column] = value
            return state
        if together is None:
            groups = self.groups((joint,), passives)
            needed = [groups[index] for index in _needed(groups, left_out)]
            kinematics = self.kinematics((joint,), needed).with_open_reductions(state)
        else:
            kinematics = together.of_drive(coordinate.rate)
        if (
            abs(value - state[column]) * self.mechanism.coordinates.scale[column]
            < CLOSURE_TOLERANCE
        ):
            # A way of mere rounding has no steps: there is nothing to be followed, only to close.
            near = state.copy()
            near[column] = value
            closed = kinematics.close(near[None, :])
            if closed.residual[0] < CLOSURE_TOLERANCE:
                return np.asarray(closed.x[0])
        from .following.branch import Branch  # Most scenes start where their joints are held.

        return Branch.shared(kinematics, state, self.mechanism.kept).at(value)

    def _columns(self, joints: tuple[str, ...]) -> Array:
        return np.array(self.mechanism.coordinates.rates_of(joints), dtype=int)


def _needed(groups: list[Group], left_out: frozenset[int]) -> list[int]:
    """Return the indices of groups that decide what is not left out."""
    return [index for index, group in enumerate(groups) if set(group.passives.tolist()) - left_out]


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
    closed = set().union(*(groups[index].items(structure) for index in solved))
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
        left = [
            group
            for group in divided
            if all(
                group.items(structure).isdisjoint(other.items(structure))
                and not np.isin(group.passives, other.passives).any()
                for other in doubtful
            )
        ]
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

    With x `(size,)`.
    """
    known = {_identity(group) for group in groups}
    is_known = [_identity(group) in known for group in finer]
    items = [group.items(structure) for group in finer]
    open_ones = [
        group
        for group, own, is_old in zip(finer, items, is_known, strict=True)
        if not (is_old or own <= closed)
    ]
    if open_ones:
        return open_ones
    chosen = [index for index, own in enumerate(items) if own and own <= closed]
    solvers = [solver_of(structure.mechanism, finer[index]) for index in chosen]
    kinematics = Kinematics(structure.mechanism.coordinates, drives, solvers)
    new = [local for local, index in enumerate(chosen) if not is_known[index]]
    return [solvers[index].group for index in _refuted(kinematics, new, x)]


def _refuted(kinematics: Kinematics, new: list[int], x: Array) -> list[int]:
    """Return which of the new groups do not follow generic displacements of all drives.

    A group does if it closes its loops and decides its joints, and no others, at all these
    positions and at the one amid them, which has to be regular, and if all groups do whose motion
    it depends on.

    With x `(size,)`.
    """
    coordinates, drives = kinematics.coordinates, kinematics.drives
    columns = coordinates.column_of(drives)
    guess = np.repeat(x[None, :], 1 + CONFIGURATIONS, axis=0)
    steps = AROUND * generic(CONFIGURATIONS, len(drives))
    guess[1:, columns] += steps / coordinates.scale[columns]
    with np.errstate(all="ignore"):  # Where a drive cannot move that far, steps may overflow.
        states = kinematics.close(guess).groups
    refuted, undecided = [], set[int]()
    for index, state in enumerate(states):
        follows = undecided.isdisjoint(state.group.known.tolist())
        follows = follows and bool(np.all(state.residual < CLOSURE_TOLERANCE))
        if index in new:
            is_regular = float(state.condition[0]) < REGULAR_CONDITION
            follows = follows and is_regular and _decides(state)
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


def _count(groups: list[Group]) -> int:
    """Return how many groups have loops or couplings."""
    return sum(bool(group.loops or group.couplings) for group in groups)


def _identity(group: Group) -> tuple[object, ...]:
    return group.loops, group.couplings, tuple(group.passives.tolist())
