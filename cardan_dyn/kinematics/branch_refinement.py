"""Branch refinement: halve the intervals of a branch's table until its guesses are good enough."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import SingularConfigurationError
from .all_groups import ClosedState, Kinematics
from .branch_table import BranchTable, nodes_of
from .tolerances import SAFE_CORRECTION

EXACT_CORRECTION = 2e-16
"""Error [rad] of a guess that needs no Newton step: the rounding of an angle of one radian."""
SAFE_GUESS_CORRECTION = 0.1 * SAFE_CORRECTION
"""Error [rad] of a guess that is safe at every position of an interval. The error is estimated for
the middle of each half, and a tenth leaves room for what the estimate misses."""
_ERROR_RATIO = 64.0
"""How many times smaller the error of quintic Hermite interpolation is on half of an interval:
2 to the sixth power."""
_LOST_CORRECTION = 0.5
"""Correction [rad] from which on a guess counts as lost: nothing shows any more that what Newton's
method found lies in the same assembly mode. It is the longest step that the solver takes."""


def halved(
    table: BranchTable, kinematics: Kinematics, is_open: Array, allowed: float
) -> tuple[BranchTable, Array]:
    """Halve the open intervals of a table, and find which halves are still too coarse.

    Args:
        table: `K` nodes.
        kinematics: with the rows that are known to be independent.
        is_open: `(K - 1,)` which intervals are to be halved.
        allowed: greatest error of a guess [rad].

    Returns:
        The table with a new node in the middle of every open interval, and which intervals of
        that table are open.

    Raises:
        SingularConfigurationError: the branch cannot be resolved.
    """
    left = np.nonzero(is_open)[0]
    middle = 0.5 * (table.positions[left] + table.positions[left + 1])
    state = kinematics.close(table.guess(middle))
    _check_mode(table, kinematics, left, middle, state)
    is_coarse = np.zeros((len(is_open), 2), dtype=bool)
    is_coarse[left] = (state.correction / _ERROR_RATIO > allowed)[:, None]
    # An interval that was not halved is still one interval, and stays closed.
    exists = np.stack([np.ones_like(is_open), is_open], axis=1)
    return table.with_nodes(nodes_of(kinematics, state)), is_coarse[exists]


def _check_mode(
    table: BranchTable, kinematics: Kinematics, left: Array, middle: Array, state: ClosedState
) -> None:
    """Check that states in the middle of intervals are in the assembly mode of the branch.

    Args:
        table: the branch.
        kinematics: that closed the states.
        left: `(M,)` indices of the nodes at the lower ends of the intervals.
        middle: `(M,)` drive positions of the states.
        state: that was found there.

    Raises:
        SingularConfigurationError: one of them may not be.
    """
    is_unsafe = state.correction > SAFE_CORRECTION
    if not np.any(is_unsafe):
        return
    nodes = kinematics.evaluate(table.states[left])
    is_lost = is_unsafe & ~kinematics.same_side(state, nodes.inverses)
    is_lost |= state.correction > _LOST_CORRECTION
    if np.any(is_lost):
        from .singularities import singularity_at  # Imported here: only errors need it.

        first = int(np.argmax(is_lost))
        singularity = singularity_at(kinematics, table.states[left[first]], table.states[0])
        raise SingularConfigurationError(
            f"the branch cannot be resolved near drive position {middle[first]:.9g}, which is "
            f"singular (condition {nodes.condition[first]:.1e}): {singularity.text}",
            position=float(middle[first]),
            condition=float(nodes.condition[first]),
            **singularity.details,
        )
