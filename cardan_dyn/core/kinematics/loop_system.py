"""Loop system: the loops of a mechanism, grouped and closed for any choice of drives."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from itertools import compress

import numpy as np

from ...kit.arrays import Array, generic
from ..mechanism.mechanism import Mechanism
from .closing.all_groups import Kinematics
from .closing.group_solver import solver_of
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
    trusted = {loop for group in divided for loop in group.loops}
    moving = {*passives.tolist(), *drives.tolist()}
    of_open, of_closed = structure.ranks(x, moving), structure.ranks_at(x, moving)
    counted = [of_closed[loop] if loop in trusted else rank for loop, rank in enumerate(of_open)]
    if counted == of_open:
        return groups
    finer = partition(structure, x, drives, passives, loop_ranks=counted)
    items = [group.items(structure) for group in finer]
    before = [group.items(structure) for group in groups]
    if sum(map(bool, items)) <= sum(map(bool, before)):
        return groups
    closed = set().union(*(before[index] for index in solved))
    known = [(own, group.passives.tolist()) for own, group in zip(before, groups, strict=True)]
    new = [
        (own, group.passives.tolist()) not in known for own, group in zip(items, finer, strict=True)
    ]
    if any(is_new and not own <= closed for is_new, own in zip(new, items, strict=True)):
        return groups
    chosen = [index for index, own in enumerate(items) if own and own <= closed]
    solvers = [solver_of(structure.mechanism, finer[index]) for index in chosen]
    kinematics = Kinematics(structure.mechanism.coordinates, drives, solvers)
    return finer if follow_drives(kinematics, [new[index] for index in chosen], x) else groups


def follow_drives(kinematics: Kinematics, new: list[bool], x: Array) -> bool:
    """Return whether groups follow generic displacements of all drives.

    They close their loops at all these positions and at the one amid them. The new ones are regular
    there, and decide their joints at all of them, and nothing else: their other equations leave
    free what moves their joints, and hold wherever that goes.

    Args:
        kinematics: of the groups.
        new: which of them are to be proven.
        x: `(size,)` closed coordinates.
    """
    coordinates, drives = kinematics.coordinates, kinematics.drives
    columns = coordinates.column_of(drives)
    guess = np.repeat(x[None, :], 1 + CONFIGURATIONS, axis=0)
    steps = AROUND * generic(CONFIGURATIONS, len(drives))
    guess[1:, columns] += steps / coordinates.scale[columns]
    with np.errstate(all="ignore"):  # Where a drive cannot move that far, steps may overflow.
        state = kinematics.close(guess)
    if not (state.residual < CLOSURE_TOLERANCE).all():
        return False
    for group in compress(state.groups, new):
        own, every = group.scaled_rows, group.all_scaled_rows
        rank = own.shape[1] - len(group.group.idle)
        if not group.condition[0] < REGULAR_CONDITION or (
            np.any(ranks(own) != rank) or np.any(ranks(every) != rank)
        ):
            return False
    return True
