"""Branch end: which end of a branch it is, and why it cannot be followed any farther."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import AssemblyError, CardanError, SingularConfigurationError
from .all_groups import Kinematics
from .branch_table import BranchTable
from .tolerances import CLOSURE_TOLERANCE, SINGULAR_CONDITION

_STEEP = 100.0
"""Derivative of a coordinate [per unit of the drive] from which on an end counts as near a dead
point of the drive, where derivatives grow without bound."""
_GREATEST_GAP = 1e-4
"""Greatest distance [units of the drive] between the last node and the estimated limit. The last
steps before a limit are much shorter, so a limit that lies farther away is a wrong estimate."""


class BranchEnd(NamedTuple):
    """One end of a branch.

    Attributes:
        node: index of its node in the table, 0 or -1.
        sign: direction of the drive that leads on from there, -1 or 1.
        error: why the branch cannot be followed beyond it; None if nothing is known against it.
    """

    node: int
    sign: float
    error: CardanError | None = None

    def is_before(self, target: float, table: BranchTable) -> bool:
        """Return whether a drive position lies beyond this end of a table."""
        return self.sign * (target - float(table.positions[self.node])) > 0.0


LOWER = BranchEnd(0, -1.0)
UPPER = BranchEnd(-1, 1.0)


class Attempt(NamedTuple):
    """A position beyond an end that was tried without success.

    Attributes:
        position: of the drive [rad or m].
        residual: closure error of what was found there.
        condition: condition number of the closure equations there.
    """

    position: float
    residual: float
    condition: float


def refused(
    kinematics: Kinematics, table: BranchTable, end: BranchEnd, unit: float, attempt: Attempt
) -> BranchEnd:
    """Return an end with the reason for which it cannot be followed.

    Args:
        kinematics: solves the branch.
        table: known part of the branch.
        end: where it ends.
        unit: drive displacement that counts as one radian [rad or m].
        attempt: the last one to go on.
    """
    from .gimbal_lock import gimbal_note  # Imported here: only errors need it.
    from .singularities import singularity_at

    nearest = limit(kinematics, table, end, unit)
    middle, last = table.states[table.size // 2], table.states[end.node]
    singularity = singularity_at(kinematics, last, middle)
    passives = [column for solver in kinematics.solvers for column in solver.group.passives]
    finding, hint = singularity.text, gimbal_note(kinematics.coordinates, last, passives)
    error: CardanError
    if attempt.residual < CLOSURE_TOLERANCE or attempt.condition > SINGULAR_CONDITION:
        condition = float(kinematics.evaluate(table.states[[end.node]]).condition[0])
        error = SingularConfigurationError(
            f"the mechanism cannot be followed past drive position {nearest:.9g}: the closure "
            f"equations become singular there (condition {condition:.1e}), {finding}{hint}",
            position=nearest,
            condition=condition,
            hint=hint,
            **singularity.details,
        )
    else:
        error = AssemblyError(
            f"the loops cannot be closed at drive position {attempt.position:.9g}; the nearest "
            f"position that can be reached is {nearest:.9g}, {finding}{hint}",
            position=attempt.position,
            nearest=nearest,
            residual=attempt.residual,
            finding=finding,
            hint=hint,
        )
    return end._replace(error=error)


def limit(kinematics: Kinematics, table: BranchTable, end: BranchEnd, unit: float) -> float:
    """Return the drive position at which the range of the drive ends, near an end of a table.

    Near a dead point passive joints move like the square root of the distance that remains, which
    gives that distance from the first two derivatives. Where assembly modes meet, the reciprocal
    condition number falls to zero in proportion to it.

    Args:
        kinematics: solves the branch.
        table: known part of the branch.
        end: the end before the limit.
        unit: drive displacement that counts as one radian [rad or m].
    """
    position = float(table.positions[end.node])
    _, slope, curvature = table.nodes[end.node]
    steepest = int(np.argmax(np.abs(slope)))
    if table.size < 2:
        return position
    if abs(slope[steepest]) * unit < _STEEP:
        remaining = _distance_to_singularity(kinematics, table, end)
    else:
        # A steep curve without curvature leads to no limit; its quotient, an infinity, is refused.
        with np.errstate(divide="ignore"):
            remaining = float(slope[steepest] / (2.0 * curvature[steepest]))
    return position + remaining if abs(remaining) < _GREATEST_GAP * unit else position


def _distance_to_singularity(kinematics: Kinematics, table: BranchTable, end: BranchEnd) -> float:
    """Return the drive displacement after which the reciprocal condition number vanishes."""
    last, before = end.node, end.node - int(end.sign)
    state = kinematics.evaluate(table.states[[last, before]])
    margin, margin_before = (1.0 / state.condition).tolist()
    step = float(table.positions[last]) - float(table.positions[before])
    return step * margin / (margin_before - margin) if margin_before > margin else 0.0
