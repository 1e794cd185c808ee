"""Mobility: whether the drives of a scene decide its motion, no more and no less."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import (
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ..mechanism.mechanism import Mechanism
from .all_groups import ClosedState
from .tolerances import RANK_TOLERANCE


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
        state: closed positions, with the rows that are independent over the motion.
            At single ones (dead points) the rank may be lower than elsewhere, so the greatest one
            counts.
        drives: names of the driven joints.
        held: names of the held joints.
        passives: velocity coordinates that something must decide.

    Raises:
        MobilityError: too many or too few drives, or drives that leave joints free.
        SingularConfigurationError: there are enough drives, but all positions are dead points.
    """
    free = set(passives)
    excess = 0
    for closed in state.groups:
        passive = ranks(closed.scaled_rows)
        best = int(np.argmax(passive))
        excess += int(np.max(ranks(closed.all_scaled_rows))) - int(passive[best])
        vectors, _, _ = np.linalg.svd(closed.scaled_rows[best])
        moves = np.max(np.abs(vectors[:, passive[best] :]), axis=1, initial=0.0) > 1e-6
        free -= set(closed.group.passives[~moves].tolist())
    if not free and not excess:
        return
    names = mechanism.coordinates.velocity_columns
    undecided = [
        name
        for name, columns in names.items()
        if free.intersection(range(columns.start, columns.stop))
    ]
    # What the loops take away from all coordinates that are not held, at the same positions.
    mobility = len(drives) - excess + _freedom(state, free)
    loops = f"its loops leave mobility {mobility}" if mechanism.loops else "it has no <loop>"
    if mobility == len(drives):
        position = state.x[-1, [mechanism.coordinates.columns[name].start for name in drives]]
        raise SingularConfigurationError(
            f"{mechanism.name}: position {as_text(position)} of {list(drives)}, where the scene "
            "starts, is a dead point: the drive does not decide the motion there of "
            f"{choices(undecided)}. "
            "Give start={joint: position} to begin elsewhere, or choose another drive",
            position=as_position(position),
            condition=float(np.max(state.condition)),
        )
    if mobility == 0:
        advice = "it is locked: stop holding a joint, or check loops and couplings"
    elif len(drives) > mobility:
        advice = "drop a drive or stop holding a joint"
    else:
        advice = f"nothing decides the motion of: {choices(undecided)}; drive or hold them"
    raise MobilityError(
        f"{mechanism.name}: {len(drives)} drive(s) {list(drives)}, but with {held} held {loops}: "
        f"{advice}",
        mobility=mobility,
        free=undecided,
    )


def _freedom(state: ClosedState, free: set[int]) -> int:
    """Return how many independent motions the passives have while the drives rest."""
    count = 0
    for closed in state.groups:
        passives = closed.group.passives
        count += len(passives) - int(np.max(ranks(closed.scaled_rows)))
        free = free - set(passives.tolist())
    return count + len(free)


def ranks(rows: Array) -> Array:
    """Return the ranks `(K,)` of stacked closure matrices."""
    if 0 in rows.shape[1:]:
        return np.zeros(len(rows), dtype=int)
    values = np.linalg.svd(rows, compute_uv=False)
    return np.asarray(np.sum(values > RANK_TOLERANCE * np.max(values), axis=1))
