"""Mobility: whether the drives of a scene decide its motion, no more and no less."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from .all_groups import ClosedState, Kinematics
from .stacked import ranks
from .tolerances import CLOSURE_TOLERANCE, MOVES

_SHORT_WAY = 1e-3
"""Displacement of a drive [rad, or lengths of the mechanism] that shows whether it can move: where
a locked mechanism can only be shaken, the loops are open by the square of it afterwards, far more
than what counts as closed."""


class _Balance(NamedTuple):
    """How the passives of a scene and its independent closure equations compare.

    Attributes:
        undecided: whether there are velocity coordinates that nothing decides.
        excess: number of closure equations that the drives would have to meet.
    """

    undecided: bool
    excess: int


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
    balance = _balance(state, passives)
    if not balance.undecided and not balance.excess:
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


def _balance(state: ClosedState, passives: set[int]) -> _Balance:
    """Return whether there are passives that nothing decides, and how many equations are left."""
    undecided = set(passives)
    excess = 0
    for group_state in state.groups:
        rank = ranks(group_state.scaled_rows)
        best = int(np.argmax(rank))
        excess += int(np.max(ranks(group_state.all_scaled_rows))) - int(rank[best])
        columns = group_state.group.passives
        if len(columns) - rank[best] == len(group_state.group.idle):
            undecided -= set(columns.tolist())
            continue
        undecided -= set(columns[~_moves(group_state.scaled_rows[best], int(rank[best]))].tolist())
    return _Balance(bool(undecided), excess)


def _moves(rows: Array, rank: int) -> Array:
    """Return `(p,)` which coordinates move in the motions that rows `(p, R)` leave free."""
    # The last left singular vectors are these motions.
    vectors, _, _ = np.linalg.svd(rows)
    return np.asarray(np.max(np.abs(vectors[:, rank:]), axis=1, initial=0.0) > MOVES)
