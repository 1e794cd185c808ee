"""Division: the loops of a scene in groups, and which of their closure equations are independent.

The rows that the joints of an open loop can reach follow from the description. How many of them are
independent while the loop is closed shows only over the motion: at single positions (dead points)
fewer are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import MobilityError
from ..problem.problem import Problem
from .closing.all_groups import ClosedState, Kinematics
from .closing.stacked import ranks
from .loop_system import LoopSystem
from .loops.groups import Group
from .loops.needs import Needs, columns_of, needs, needs_of_finer
from .tolerances import AROUND, CLOSURE_TOLERANCE, MOVES, REGULAR_CONDITION


@dataclass(frozen=True, eq=False)
class Division:
    """The loops of a scene, divided into groups. Nothing in it changes.

    Attributes:
        problem: the drives, held joints and wanted outputs of the scene.
        system: its loops.
        groups: all groups.
        needed: which of them the outputs need.
        kinematics: solves these, with all rows or with those that open loops can reach.
    """

    problem: Problem
    system: LoopSystem
    groups: list[Group]
    needed: Needs
    kinematics: Kinematics

    @staticmethod
    def of_open_loops(problem: Problem, system: LoopSystem) -> Division:
        """Return the division that the equations of open loops show."""
        groups = system.groups(problem.independent, problem.passive_columns)
        wanted = problem.wanted_bodies, problem.element_bodies
        return _into(problem, system, groups, needs(problem.mechanism, groups, *wanted))

    def around(self, state: Array) -> Division:
        """Return the finest division that is proven around a closed state `(size,)`.

        It solves the rows that open loops can reach.
        """
        problem, system, division = self.problem, self.system, self
        passives = problem.passive_columns
        finer = system.finer(self.groups, problem.independent, passives, self.needed.motion, state)
        if finer is not self.groups:
            wanted = problem.wanted_bodies, problem.element_bodies
            needed = needs_of_finer(problem.mechanism, finer, self.groups, self.needed, *wanted)
            division = _into(problem, system, finer, needed)
        return replace(division, kinematics=division.kinematics.with_open_reductions(state))

    @cached_property
    def decided(self) -> Array:
        """Velocity coordinates of the passive joints that the needed groups decide."""
        return columns_of([self.groups[index] for index in self.needed.motion])

    def independent(self, states: Array) -> Kinematics:
        """Return what solves the rows that are independent over closed states `(K, size)`.

        It is the division's own where no other state of the motion can add to them.

        Raises:
            MobilityError: the drives do not decide the motion, or too many do.
            SingularConfigurationError: all states are dead points.
        """
        key = self.kinematics.key, *(group.key for group in self.groups), states.tobytes()

        def is_determined() -> bool:
            return self._is_determined(self.kinematics.evaluate(states))

        if self.problem.mechanism.kept.of(
            "determined", (*key, self.problem.passive_columns.tobytes()), is_determined
        ):
            return self.kinematics
        state = self.kinematics.evaluate(states)
        known = self.kinematics.with_reductions([group.reachable for group in state.groups])
        self._check(known.evaluate(states))
        return known

    def refuse_locked(self, known: Kinematics, start: Array) -> None:
        """Refuse a scene that starts in a position where a locked mechanism can be shaken.

        There, fewer closure equations are independent than anywhere around it, as if the drives
        could move. No position around it can be closed.

        Args:
            known: solves what is independent at the start.
            start: `(size,)` closed coordinates.

        Raises:
            MobilityError: the mechanism is locked.
        """
        if known is self.kinematics or can_move(known, start):
            return
        from .diagnosis.imbalance import imbalance  # Imported here: only errors need it.

        error = imbalance(self.problem, start, self._to_decide, known)
        # A start in which all ways on are singular is refused where it is used; one so close to a
        # singular configuration that no position around it was closed need not be locked.
        if isinstance(error, MobilityError) and (
            error.mobility is None
            or error.mobility < len(self.problem.independent)
            or error.free
            or error.surplus
        ):
            raise error

    @property
    def _to_decide(self) -> set[int]:
        """Velocity coordinates that something must decide.

        Passives of groups that no output needs may stay undecided. Passives that belong to no group
        at all may not: nothing could ever decide them.
        """
        left_out = set(columns_of(self.groups).tolist()) - set(self.decided.tolist())
        return set(self.problem.passive_columns.tolist()) - left_out

    def _is_determined(self, state: ClosedState) -> bool:
        """Return whether every group has as many independent equations as passives somewhere."""
        return np.array_equal(columns_of(self.groups), self.problem.passive_columns) and all(
            group.passive_rows.shape[1] - len(group.group.idle) == group.passive_rows.shape[2]
            and float(np.min(group.condition)) < REGULAR_CONDITION
            for group in state.groups
        )

    def _check(self, state: ClosedState) -> None:
        """Compare the drives with the mobility, over closed positions.

        At single ones (dead points) the rank may be lower than elsewhere, so the greatest counts.
        """
        # Coordinates that nothing decides, and equations that the drives would have to meet.
        undecided, excess = self._to_decide, 0
        for group in state.groups:
            rank = ranks(group.scaled_rows)
            best = int(np.argmax(rank))
            excess += int(np.max(ranks(group.all_scaled_rows))) - int(rank[best])
            columns = group.group.passives
            decided = np.ones(len(columns), dtype=bool)
            if len(columns) - rank[best] != len(group.group.idle):
                # The last left singular vectors are the motions that are left free.
                free = np.linalg.svd(group.scaled_rows[best])[0][:, rank[best] :]
                decided = np.max(np.abs(free), axis=1, initial=0.0) <= MOVES
            undecided -= set(columns[decided].tolist())
        if undecided or excess:
            from .diagnosis.imbalance import imbalance  # Imported here: only errors need it.

            raise imbalance(self.problem, state.x[-1], self._to_decide, self.kinematics)


def _into(problem: Problem, system: LoopSystem, groups: list[Group], needed: Needs) -> Division:
    """Return the division into groups of which some are needed."""
    moving = [groups[index] for index in needed.motion]
    kinematics = system.kinematics(problem.independent, moving)
    return Division(problem, system, groups, needed, kinematics)


def can_move(kinematics: Kinematics, start: Array) -> bool:
    """Return whether every drive can move away from closed coordinates `(size,)`, by itself.

    Where a locked mechanism can only be shaken, the loops are open by the square of the way.
    """
    coordinates, count = kinematics.coordinates, len(kinematics.drives)
    step = AROUND * np.concatenate([np.eye(count), -np.eye(count)])
    columns = coordinates.column_of(kinematics.drives)
    step /= coordinates.scale[columns]
    state = kinematics.evaluate(np.repeat(start[None, :], 2 * count, axis=0))
    with np.errstate(all="ignore"):  # Rates in singular positions overflow; nothing is closed then.
        guess = state.x + coordinates.derivative(state.x, kinematics.rates(state, step))
        guess[:, columns] = start[columns] + step
        residual = kinematics.close(guess).residual
    moves = (residual < CLOSURE_TOLERANCE).reshape(2, count)
    return bool(np.all(np.any(moves, axis=0)))
