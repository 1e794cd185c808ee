"""Correctors: how the nodes of a branch are brought from an extrapolation to closed loops.

`OneNewtonStep` is the faster one: with its proof it took 60 to 63 % of the time of `FullClosure`
for one turn of the bundled universal joint, four-bar, needle drive and double shaft. What it
returns holds only after that proof, see `proven`; `FullClosure` needs none.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..arrays import Array
from .all_groups import ClosedState, Kinematics
from .branch_table import BranchTable, nodes_of, taylor
from .step_control import REJECTED_EXCESS, allowed_correction
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION

_NEWTON_STEPS = 6
"""Greatest number of Newton steps per node. Convergence is quadratic: from the allowed correction
of 0.03 rad about four steps reach rounding. A node that needs more steps is rejected, and a shorter
step of the branch is tried."""


class Corrector(Protocol):
    """How a node is corrected, and whether it can be used as it is."""

    def correct(self, kinematics: Kinematics, guess: Array) -> ClosedState:
        """Return states near guesses `(E, size)`."""

    def is_usable(self, state: ClosedState) -> Array:
        """Return `(E,)` whether corrected states may become nodes."""


class OneNewtonStep:
    """The quick way: one Newton step per node, which leaves an error of its square.

    All nodes are closed together afterwards, and the branch is then proven, see `proven`.
    """

    def correct(self, kinematics: Kinematics, guess: Array) -> ClosedState:
        """Return states after one Newton step from guesses `(E, size)`."""
        return kinematics.newton_step(guess)

    def is_usable(self, state: ClosedState) -> Array:
        """Return true for all states: the proof judges them later."""
        return np.ones(len(state.x), dtype=bool)


class FullClosure:
    """The careful way: every node is closed before the next one is tried."""

    def correct(self, kinematics: Kinematics, guess: Array) -> ClosedState:
        """Return states that Newton's method finds from guesses `(E, size)`."""
        return kinematics.close(guess, most=_NEWTON_STEPS)

    def is_usable(self, state: ClosedState) -> Array:
        """Return `(E,)` whether the loops are closed."""
        return np.asarray(state.residual < CLOSURE_TOLERANCE)


def proven(
    kinematics: Kinematics, table: BranchTable, low: float, high: float
) -> BranchTable | None:
    """Close the nodes of a table that `OneNewtonStep` has added, and check that each leads on.

    Neighbouring nodes lie on the same branch if the extrapolations between them are as good, in
    both directions, as step control demands, with no singular configuration between them.

    Args:
        kinematics: solves the branch.
        table: with new nodes below `low` and above `high`.
        low: lower end of the span whose nodes were proven before.
        high: upper end of that span.

    Returns:
        The table with closed nodes, or None if they are not proven to lie on one branch.
    """
    new = (table.positions <= low) | (table.positions >= high)
    positions = table.positions[new]
    state = kinematics.close(table.states[new])
    if np.any(~(state.residual < CLOSURE_TOLERANCE) | (state.correction > SAFE_CORRECTION)):
        return None
    nodes = nodes_of(kinematics, state)
    step = np.diff(positions)
    error_on = np.abs(taylor(nodes[:-1], step) - nodes[1:, 0])
    error_back = np.abs(taylor(nodes[1:], -step) - nodes[:-1, 0])
    error = np.max(np.maximum(error_on, error_back) * kinematics.coordinates.scale, axis=1)
    allowed = allowed_correction(state.condition)
    leads_on = error < REJECTED_EXCESS * np.minimum(allowed[:-1], allowed[1:])
    for group_state in state.groups:
        leads_on &= group_state.follows_on()
    # The two ends of the old span are neighbours here, but proven nodes lie between them.
    leads_on |= (positions[:-1] == low) & (positions[1:] == high)
    return table.with_replaced(new, nodes) if np.all(leads_on) else None
