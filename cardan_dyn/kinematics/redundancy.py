"""Redundancy: which rows of the closure equations are independent over the motion, as a value.

A loop's rows that its open joints can reach are found at once. How many of them are independent
while it is closed shows only over the motion: at single positions (dead points) fewer are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..problem.problem import Problem
from .all_groups import ClosedState, Kinematics
from .branch import Branch
from .loop_groups import Group
from .mobility import check_mobility
from .needs import Needs, columns_of
from .tolerances import CLOSURE_TOLERANCE

_REGULAR = 1e6
"""Condition number of positions that leave no doubt about the rank: their smallest singular value
is a thousand times `RANK_TOLERANCE`."""
STATES_STUDIED = 32
"""States of a branch from which independent rows are read. Two or three can all be special: a
parallelogram's two ends are."""


class Redundancy(NamedTuple):
    """What is known about redundant rows.

    Attributes:
        kinematics: solves the rows that are known to be independent.
        settled: whether no other state can add to them.
    """

    kinematics: Kinematics
    settled: bool = False


class RedundancyStudy:
    """Finds the redundant rows of a scene's kinematics from its closed states.

    Attributes:
        open_kinematics: solves all rows that open loops can reach.
    """

    def __init__(
        self, problem: Problem, groups: list[Group], needed: Needs, open_kinematics: Kinematics
    ) -> None:
        self.open_kinematics = open_kinematics
        self._problem = problem
        self._passives = problem.passive_columns
        self._decided_by_all = columns_of(groups)
        decided = columns_of([groups[index] for index in needed.motion])
        # What the outputs leave out need not be decided, unless no group decides it at all.
        left_out = set(self._decided_by_all.tolist()) - set(decided.tolist())
        self._to_decide = set(self._passives.tolist()) - left_out

    def of_states(self, states: Array, branch: Branch | None = None) -> Redundancy:
        """Return the redundant rows over closed states, after checking the mobility there.

        Args:
            states: `(K, size)` closed coordinates.
            branch: that they are on, if any.

        Raises:
            MobilityError: the drives do not decide the motion, or too many do.
            SingularConfigurationError: all states are dead points.
        """
        state = self.open_kinematics.evaluate(states)
        if self._is_determined(state):
            return Redundancy(self.open_kinematics, settled=True)
        if branch is not None and len(states) < STATES_STUDIED:
            between = self.open_kinematics.close(
                branch.guess(np.linspace(*branch.span, STATES_STUDIED))
            )
            closed = between.x[between.residual < CLOSURE_TOLERANCE]
            states = np.concatenate([states, closed])
            state = self.open_kinematics.evaluate(states)
        reductions = [group_state.reachable for group_state in state.groups]
        kinematics = self.open_kinematics.with_reductions(reductions)
        problem = self._problem
        check_mobility(
            problem.mechanism,
            kinematics.evaluate(states),
            problem.drives,
            list(problem.held),
            self._to_decide,
        )
        return Redundancy(kinematics)

    def _is_determined(self, state: ClosedState) -> bool:
        """Return whether every group has as many independent equations as passives somewhere."""
        return np.array_equal(self._decided_by_all, self._passives) and all(
            group_state.passive_rows.shape[1] == group_state.passive_rows.shape[2]
            and float(np.min(group_state.condition)) < _REGULAR
            for group_state in state.groups
        )
