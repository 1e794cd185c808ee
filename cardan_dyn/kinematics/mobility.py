"""Mobility: whether the drives of a scene decide its motion, no more and no less."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import (
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ..mechanism.mechanism import Mechanism
from .all_groups import ClosedState
from .stacked import ranks

_MOVES = 1e-6
"""Component of a unit vector of free motion above which a joint counts as moving. Joints that the
loops decide have components there as well, by rounding of about 1e-16."""


class _Balance(NamedTuple):
    """How the passives of a scene and its independent closure equations compare.

    Attributes:
        undecided: velocity coordinates that nothing decides.
        excess: number of closure equations that the drives would have to meet.
    """

    undecided: set[int]
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
    undecided, excess = _balance(state, passives)
    if not undecided and not excess:
        return
    names = mechanism.coordinates.names_of(undecided)
    # What the loops take away from all coordinates that are not held, at the same positions.
    mobility = len(drives) - excess + _freedom(state, undecided)
    if mobility == len(drives):
        from .gimbal_lock import gimbal_note  # Only errors need it.

        solved = (group_state.group for group_state in state.groups)
        note = gimbal_note(mechanism.coordinates, state.x[-1], solved)
        position = state.x[-1, mechanism.coordinates.columns_of(drives)]
        raise SingularConfigurationError(
            f"{mechanism.name}: position {as_text(position)} of {list(drives)}, where the scene "
            "starts, is a dead point: the drive does not decide the motion there of "
            f"{choices(names)}. "
            f"Give start={{joint: position}} to begin elsewhere, or choose another drive{note}",
            position=as_position(position),
            condition=float(np.max(state.condition)),
        )
    loops = f"its loops leave mobility {mobility}" if mechanism.loops else "it has no loop"
    held_text = f" with {choices(held)} held" if held else ""
    raise MobilityError(
        f"{mechanism.name}: driven by {choices(drives)}{held_text}, {loops}: "
        f"{_advice(mechanism, mobility, [*drives, *held], len(drives), names)}",
        mobility=mobility,
        free=names,
    )


def _balance(state: ClosedState, passives: set[int]) -> _Balance:
    """Return which passives nothing decides, and how many equations are left over."""
    undecided = set(passives)
    excess = 0
    for group_state in state.groups:
        rank = ranks(group_state.scaled_rows)
        best = int(np.argmax(rank))
        excess += int(np.max(ranks(group_state.all_scaled_rows))) - int(rank[best])
        if len(group_state.group.passives) - rank[best] == len(group_state.group.idle):
            undecided -= set(group_state.group.passives.tolist())
            continue
        # The last left singular vectors are the motions that the equations leave free.
        vectors, _, _ = np.linalg.svd(group_state.scaled_rows[best])
        motion = np.max(np.abs(vectors[:, rank[best] :]), axis=1, initial=0.0)
        undecided -= set(group_state.group.passives[~(motion > _MOVES)].tolist())
    return _Balance(undecided, excess)


def _freedom(state: ClosedState, undecided: set[int]) -> int:
    """Return how many independent motions the passives have while the drives rest."""
    count = 0
    for group_state in state.groups:
        passives = group_state.group.passives
        rank = int(np.max(ranks(group_state.scaled_rows)))
        count += len(passives) - rank - len(group_state.group.idle)
        undecided = undecided - set(passives.tolist())
    return count + len(undecided)


def _advice(
    mechanism: Mechanism,
    mobility: int,
    prescribed: list[str],
    drive_count: int,
    undecided: list[str],
) -> str:
    """Return what to change where the drives do not match the mobility."""
    coupled = _coupled(mechanism, prescribed) if drive_count > mobility else ""
    if coupled:
        return coupled
    if mobility == 0:
        return "it is locked: stop holding a joint, or check loops and couplings"
    if drive_count > mobility:
        return "drop a drive or stop holding a joint"
    advice = f"drive or hold {mobility - drive_count} of them"
    return f"nothing decides the motion of: {choices(undecided)}; {advice}"


def _coupled(mechanism: Mechanism, prescribed: list[str]) -> str:
    """Return which couplings connect prescribed joints, and what to do; empty without any.

    Couplings of one joint with another are followed from joint to joint, like a train of wheels.
    """
    velocities = mechanism.coordinates.velocity_columns
    names = {velocities[name].start: name for name in velocities}
    edges = [
        (item.name, item.predecessor_columns[0], item.successor_columns[0])
        for item in mechanism.couplings
        if len(item.predecessor_columns) == len(item.successor_columns) == 1
    ]
    for first in prescribed:
        reached, used = [velocities[first].start], []
        for column in reached:
            for name, *ends in edges:
                if column in ends and name not in used:
                    used.append(name)
                    reached += [end for end in ends if end not in reached]
        both = [names[column] for column in reached if names[column] in prescribed]
        if len(both) > 1:
            return (
                f"{choices(used)} couple{'s' * (len(used) == 1)} {choices(both)}: "
                "drive or hold only one of them"
            )
    return ""
