"""Loop system: the loops of a mechanism, grouped and solved for any choice of drives."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from .all_groups import Kinematics
from .branch import Branch
from .group_solver import GroupSolver
from .loop_groups import Group, partition
from .structure import Structure


class LoopSystem:
    """The loops of a mechanism with some joints held.

    Attributes:
        mechanism: the mechanism.
        held: held joints and their positions.
    """

    def __init__(self, mechanism: Mechanism, held: dict[str, float]) -> None:
        self.mechanism = mechanism
        self.held = held
        self._structure = Structure(mechanism)
        items = range(len(self._structure.paths))
        self._on_loops = {
            column for item in items for column in self._structure.coordinates_on(item)
        }

    def is_on_loops(self, joint: str) -> bool:
        """Return whether a loop or coupling depends on a joint with one coordinate."""
        return self._column(joint) in self._on_loops

    def groups(self, drives: tuple[str, ...], passives: Array) -> list[Group]:
        """Return the groups for some drives and passives `(p,)`, in the order of motion."""
        coordinates = self.mechanism.coordinates
        x = coordinates.neutral()
        for name, value in self.held.items():
            x[coordinates.columns[name]] = value
        return partition(self._structure, x, self._columns(drives), passives)

    def kinematics(self, drives: tuple[str, ...], groups: list[Group]) -> Kinematics:
        """Return what solves some groups for some drives, all rows kept."""
        solvers = [GroupSolver(self.mechanism, group) for group in groups]
        return Kinematics(self.mechanism.coordinates, self._columns(drives), solvers)

    def branch(self, joint: str, kinematics: Kinematics, state: Array) -> Branch:
        """Return the branch on which closed coordinates `(size,)` lie while one joint moves."""
        slides = self.mechanism.joints[joint].type == "prismatic"
        unit = self.mechanism.characteristic_length if slides else 1.0
        return Branch(kinematics, state, self.mechanism.coordinates.columns[joint].start, unit)

    def moved(
        self, state: Array, joint: str, value: float, passives: Array, left_out: set[int]
    ) -> Array:
        """Follow the mechanism from a state while one joint moves to a value.

        The passives follow; all other joints rest.

        Args:
            state: `(size,)` closed coordinates.
            joint: what moves.
            value: where it goes [rad or m].
            passives: velocity coordinates that follow.
            left_out: velocity coordinates that need not follow, since no output needs them.

        Raises:
            CardanError: the value cannot be reached.
        """
        column = self.mechanism.coordinates.columns[joint].start
        if value == state[column]:
            return state
        if not self.is_on_loops(joint):
            state = state.copy()
            state[column] = value
            return state
        groups = [
            group
            for group in self.groups((joint,), passives)
            if set(group.passives.tolist()) - left_out
        ]
        kinematics = self.kinematics((joint,), groups).with_open_reductions(state)
        branch = self.branch(joint, kinematics, state)
        branch.cover(min(value, state[column]), max(value, state[column]))
        return branch.states()[-1 if value > state[column] else 0]

    def _column(self, joint: str) -> int:
        return self.mechanism.coordinates.velocity_columns[joint].start

    def _columns(self, joints: tuple[str, ...]) -> Array:
        return np.array([self._column(name) for name in joints], dtype=int)
