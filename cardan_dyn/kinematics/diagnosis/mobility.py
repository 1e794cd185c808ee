"""Mobility: which closure equations are independent over the motion, and whether drives decide it.

The rows that the joints of an open loop can reach follow from the description. How many of them are
independent while the loop is closed shows only over the motion: at single positions (dead points)
fewer are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import MobilityError
from ...mechanism.mechanism import Mechanism
from ...problem.problem import Problem
from ..closing.all_groups import ClosedState, Kinematics
from ..closing.stacked import ranks
from ..loops.groups import Group
from ..loops.needs import Needs, columns_of
from ..tolerances import CLOSURE_TOLERANCE, MOVES, REGULAR_CONDITION

_SHORT_WAY = 1e-3
"""Displacement of a drive [rad, or lengths of the mechanism] that shows whether it can move: where
a locked mechanism can only be shaken, the loops are open by the square of it afterwards, far more
than what counts as closed."""


class Redundancy(NamedTuple):
    """Result of a study of redundant rows.

    Attributes:
        kinematics: solves the rows that are known to be independent.
        settled: whether no other state of the motion can add to them.
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
        """Make the study.

        Args:
            problem: the drives, held joints and wanted outputs of the scene.
            groups: all groups of the scene.
            needed: which of them the outputs need.
            open_kinematics: see the attribute.
        """
        self.open_kinematics = open_kinematics
        self._problem = problem
        self._passives = problem.passive_columns
        self._decided_by_all = columns_of(groups)
        decided = columns_of([groups[index] for index in needed.motion])
        # Passives of groups that no output needs may stay undecided. Passives that belong to no
        # group at all may not: nothing could ever decide them.
        left_out = set(self._decided_by_all.tolist()) - set(decided.tolist())
        self._to_decide = set(self._passives.tolist()) - left_out

    def of_states(self, states: Array) -> Redundancy:
        """Return the redundant rows over closed states, after checking the mobility there.

        Args:
            states: `(K, size)` closed coordinates.

        Raises:
            MobilityError: the drives do not decide the motion, or too many do.
            SingularConfigurationError: all states are dead points.
        """
        state = self.open_kinematics.evaluate(states)
        if self._is_determined(state):
            return Redundancy(self.open_kinematics, settled=True)
        reductions = [group_state.reachable for group_state in state.groups]
        kinematics = self.open_kinematics.with_reductions(reductions)
        problem = self._problem
        check_mobility(
            problem.mechanism,
            kinematics.evaluate(states),
            problem.independent,
            list(problem.held),
            self._to_decide,
        )
        return Redundancy(kinematics)

    def refuse_locked(self, redundancy: Redundancy, start: Array) -> None:
        """Refuse a scene that starts in a position where a locked mechanism can be shaken.

        There, fewer closure equations are independent than anywhere around it, as if the drives
        could move. No position around it can be closed.

        Args:
            redundancy: of the start.
            start: `(size,)` closed coordinates.

        Raises:
            MobilityError: the mechanism is locked.
        """
        if redundancy.settled or can_move(redundancy.kinematics, start):
            return
        from .imbalance import imbalance  # Imported here: only errors need it.

        problem = self._problem
        error = imbalance(
            problem.mechanism,
            start,
            problem.independent,
            list(problem.held),
            self._to_decide,
            np.inf,
        )
        # A start in which all ways on are singular is refused where it is used; one so close to a
        # singular configuration that no position around it was closed need not be locked.
        if isinstance(error, MobilityError) and (
            error.mobility is None
            or error.mobility < len(problem.independent)
            or error.free
            or error.surplus
        ):
            raise error

    def _is_determined(self, state: ClosedState) -> bool:
        """Return whether every group has as many independent equations as passives somewhere."""
        return np.array_equal(self._decided_by_all, self._passives) and all(
            group_state.passive_rows.shape[1] - len(group_state.group.idle)
            == group_state.passive_rows.shape[2]
            and float(np.min(group_state.condition)) < REGULAR_CONDITION
            for group_state in state.groups
        )


def check_mobility(
    mechanism: Mechanism,
    state: ClosedState,
    drives: tuple[str, ...],
    held: list[str],
    passives: set[int],
) -> None:
    """Compare a scene's drives with its mobility, over closed positions.

    Args:
        mechanism: the mechanism.
        state: K closed positions, with the rows that are independent over the motion. At single
            ones (dead points) the rank may be lower than elsewhere, so the greatest one counts.
        drives: names of the driven joints.
        held: names of the held joints.
        passives: velocity coordinates that something must decide.

    Raises:
        MobilityError: too many or too few drives, or drives that leave joints free.
        SingularConfigurationError: there are enough drives, but all positions are dead points.
    """
    # Coordinates that nothing decides, and closure equations that the drives would have to meet.
    undecided, excess = set(passives), 0
    for group_state in state.groups:
        rank = ranks(group_state.scaled_rows)
        best = int(np.argmax(rank))
        excess += int(np.max(ranks(group_state.all_scaled_rows))) - int(rank[best])
        columns = group_state.group.passives
        decided = np.ones(len(columns), dtype=bool)
        if len(columns) - rank[best] != len(group_state.group.idle):
            decided = ~_moves(group_state.scaled_rows[best], int(rank[best]))
        undecided -= set(columns[decided].tolist())
    if not undecided and not excess:
        return
    from .imbalance import imbalance  # Imported here, as all that explains errors: few need it.

    raise imbalance(mechanism, state.x[-1], drives, held, passives, float(np.max(state.condition)))


def can_move(kinematics: Kinematics, start: Array) -> bool:
    """Return whether every drive can move away from closed coordinates `(size,)`, by itself."""
    coordinates, count = kinematics.coordinates, len(kinematics.drives)
    step = _SHORT_WAY * np.concatenate([np.eye(count), -np.eye(count)])
    columns = coordinates.column_of(kinematics.drives)
    step /= coordinates.scale[columns]
    state = kinematics.evaluate(np.repeat(start[None, :], 2 * count, axis=0))
    with np.errstate(all="ignore"):  # Rates in singular positions overflow; nothing is closed then.
        guess = state.x + coordinates.derivative(state.x, kinematics.rates(state, step))
        guess[:, columns] = start[columns] + step
        residual = kinematics.close(guess).residual
    moves = (residual < CLOSURE_TOLERANCE).reshape(2, count)
    return bool(np.all(np.any(moves, axis=0)))


def _moves(rows: Array, rank: int) -> Array:
    """Return `(p,)` which coordinates move in the motions that rows `(p, R)` leave free."""
    # The last left singular vectors are these motions.
    vectors, _, _ = np.linalg.svd(rows)
    return np.asarray(np.max(np.abs(vectors[:, rank:]), axis=1, initial=0.0) > MOVES)
