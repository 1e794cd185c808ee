"""Branch follower: make a branch longer, step by step, at both of its ends at once.

Every step has a predictor (extrapolation from the end), a corrector (Newton's method) and step
control. Steps are so short that Newton's method cannot change the assembly mode, and shorter
towards singular configurations, where assembly modes meet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .all_groups import ClosedState, Kinematics
from .branch_end import LOWER, UPPER, Attempt, BranchEnd, refused
from .branch_table import BranchTable, nodes_of
from .correctors import Corrector
from .step_control import REJECTED_EXCESS, StepControl, allowed_correction
from .tolerances import SINGULAR_CONDITION

_AMBIGUOUS_CONDITION = 1e7
"""Condition number from which on rounding decides in which assembly mode a branch goes on: modes
are about its reciprocal apart, 1e-7 rad, and positions near a dead point known to the root of
rounding, 1e-8."""


class Followed(NamedTuple):
    """What following a branch has led to.

    Attributes:
        table: with all nodes that were reached.
        refused: the end that could not be followed to its target; None if both targets were
            reached.
    """

    table: BranchTable
    refused: BranchEnd | None


class _MovingEnd(NamedTuple):
    """An end of a branch that is being followed.

    Attributes:
        end: which end.
        control: chooses its steps.
        inverses: per group `(R, p)`, inverse closure equations at its node.
    """

    end: BranchEnd
    control: StepControl
    inverses: list[Array]


class _Trial(NamedTuple):
    """One step that was tried at E ends at once.

    Attributes:
        positions: `(E,)` drive positions that were tried.
        state: what the corrector found there.
        nodes: `(E, 3, size)` of that state.
        excess: `(E,)` ratio of the extrapolation's error to the allowed correction.
        is_accepted: `(E,)` whether the nodes lie on the branch.
    """

    positions: Array
    state: ClosedState
    nodes: Array
    excess: Array
    is_accepted: Array


class BranchFollower:
    """Follows a branch beyond its ends. Nothing in it changes."""

    def __init__(self, kinematics: Kinematics, unit: float, corrector: Corrector) -> None:
        """Make the follower.

        Args:
            kinematics: solves the branch; it has one drive.
            unit: drive displacement that counts as one radian [rad or m].
            corrector: brings extrapolations to closed loops.
        """
        self._kinematics = kinematics
        self._unit = unit
        self._corrector = corrector

    def follow(self, table: BranchTable, low: float, high: float) -> Followed:
        """Return a table that reaches from drive position `low` to `high`, where it can.

        If an end is refused, the table holds what was reached at both ends until then.
        """
        moving, refusal = self._begin(table, low, high)
        while moving and refusal is None:
            trial = self._try(table, moving)
            longer = table.with_nodes(trial.nodes[trial.is_accepted])
            moving, refusal = self._control(table, longer, moving, trial)
            table = longer
        return Followed(table, refusal)

    def _begin(
        self, table: BranchTable, low: float, high: float
    ) -> tuple[list[_MovingEnd], BranchEnd | None]:
        """Return the ends that have a way to go, and the one that cannot even start."""
        targets = [
            (end, target)
            for end, target in ((LOWER, low), (UPPER, high))
            if end.is_before(target, table)
        ]
        state = self._kinematics.evaluate(table.states[[end.node for end, _ in targets]])
        moving = []
        for row, (end, target) in enumerate(targets):
            condition = float(state.condition[row])
            if condition > SINGULAR_CONDITION:
                return [], self._refused(table, end, Attempt(target, 0.0, condition))
            control = StepControl(end.sign, target, self._unit, 1.0 / condition)
            moving.append(_MovingEnd(end, control, [inverse[row] for inverse in state.inverses]))
        return moving, None

    def _try(self, table: BranchTable, moving: list[_MovingEnd]) -> _Trial:
        """Take a step at every moving end: predict, correct and judge."""
        indices = [item.end.node for item in moving]
        positions = np.array(
            [item.control.next_position(table.positions[item.end.node]) for item in moving]
        )
        guess = table.extrapolated(indices, positions)
        state = self._corrector.correct(self._kinematics, guess)
        inverses = [
            np.stack(of_group) for of_group in zip(*(m.inverses for m in moving), strict=True)
        ]
        with np.errstate(all="ignore"):  # What did not converge is rejected, whatever it holds.
            nodes = nodes_of(self._kinematics, state)
            error = np.maximum(state.correction, table.error_back(nodes, indices))
            allowed = allowed_correction(state.condition)
            # A long step can end in another assembly mode, whose loops are closed as well.
            is_accepted = self._kinematics.same_side(state, inverses)
            is_accepted &= error < REJECTED_EXCESS * allowed
            is_accepted &= state.condition < _AMBIGUOUS_CONDITION
            is_accepted &= self._corrector.is_usable(state)
            return _Trial(positions, state, nodes, error / allowed, is_accepted)

    def _control(
        self, table: BranchTable, longer: BranchTable, moving: list[_MovingEnd], trial: _Trial
    ) -> tuple[list[_MovingEnd], BranchEnd | None]:
        """Choose the next steps; return the ends still on the way, and the one to be refused.

        Args:
            table: before the trial.
            longer: with the accepted nodes of the trial.
            moving: the ends that have moved.
            trial: how they have moved.
        """
        still_moving = []
        for row, item in enumerate(moving):
            end, control = item.end, item.control
            condition = float(trial.state.condition[row])
            is_accepted = bool(trial.is_accepted[row])
            if is_accepted:
                step = abs(float(trial.positions[row]) - float(table.positions[end.node]))
                control.accept(step, float(trial.excess[row]), 1.0 / condition)
                inverses = [inverse[row] for inverse in trial.state.inverses]
                item = item._replace(inverses=inverses)
            else:
                control.reject()
            if control.remaining(float(longer.positions[end.node])) <= 0.0:
                continue
            if control.is_stopped:
                # An accepted step that leads to no further one ends where modes meet.
                residual = 0.0 if is_accepted else float(trial.state.residual[row])
                attempt = Attempt(float(trial.positions[row]), residual, condition)
                return [], self._refused(longer, end, attempt)
            still_moving.append(item)
        return still_moving, None

    def _refused(self, table: BranchTable, end: BranchEnd, attempt: Attempt) -> BranchEnd:
        return refused(self._kinematics, table, end, self._unit, attempt)
