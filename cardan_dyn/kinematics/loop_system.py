"""Loop system: the loops of a mechanism, grouped and closed for any choice of drives."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from .all_groups import Kinematics
from .branch import Branch
from .group_solver import GroupSolver
from .loop_groups import Group, partition
from .structure import Structure


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
        self._looped_columns = {
            column
            for index in range(len(self.structure.paths))
            for column in self.structure.coordinates_on(index)
        }

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
        coordinates = self.mechanism.coordinates
        x = coordinates.neutral()
        for name, value in self.held.items():
            x[coordinates.named[name].column] = value
        return partition(self.structure, x, self._columns(drives), passives)

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
        solved = list(solved)
        if all(len(groups[index].loops) <= 1 for index in solved):
            return groups
        from .finer_groups import finer_groups  # Most scenes have single loops.

        return finer_groups(self.structure, groups, solved, state, self._columns(drives), passives)

    def kinematics(self, drives: tuple[str, ...], groups: list[Group]) -> Kinematics:
        """Return what solves all rows of some groups while some joints are driven."""
        solvers = [GroupSolver(self.mechanism, group) for group in groups]
        return Kinematics(self.mechanism.coordinates, self._columns(drives), solvers)

    def branch(self, joint: str, kinematics: Kinematics, state: Array) -> Branch:
        """Return the branch through a state, along the motion of one joint.

        Args:
            joint: name of the joint that moves; the only drive of the kinematics.
            kinematics: solves the branch.
            state: `(size,)` closed coordinates.
        """
        coordinate = self.mechanism.coordinates.named[joint]
        unit = self.mechanism.characteristic_length if coordinate.slides else 1.0
        return Branch(kinematics, state, coordinate.column, unit)

    def together(
        self, state: Array, joints: tuple[str, ...], passives: Array, left_out: set[int]
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
        solved = [
            index for index, group in enumerate(groups) if set(group.passives.tolist()) - left_out
        ]
        finer = self.finer(groups, joints, passives, solved, state)
        if finer is groups:
            return None
        needed = [group for group in finer if set(group.passives.tolist()) - left_out]
        return self.kinematics(joints, needed).with_open_reductions(state)

    def moved(
        self,
        state: Array,
        joint: str,
        value: float,
        passives: Array,
        left_out: set[int],
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
            groups = [
                group
                for group in self.groups((joint,), passives)
                if set(group.passives.tolist()) - left_out
            ]
            kinematics = self.kinematics((joint,), groups).with_open_reductions(state)
        else:
            kinematics = together.of_drive(coordinate.rate)
        branch = self.branch(joint, kinematics, state)
        branch.cover(min(value, state[column]), max(value, state[column]))
        return branch.states()[-1 if value > state[column] else 0]

    def _columns(self, joints: tuple[str, ...]) -> Array:
        return np.array(self.mechanism.coordinates.rates_of(joints), dtype=int)
