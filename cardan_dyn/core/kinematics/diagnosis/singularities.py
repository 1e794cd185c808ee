"""Singularities: which joints lose their freedom where drives stop deciding the motion."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import choices
from ...mechanism.coordinates import Coordinates
from ..closing.all_groups import Kinematics
from ..tolerances import MOVES, REGULAR_CONDITION

_RESTS = 1e-2
"""Rate below which a joint rests near a singular position, and singular value below which it is
one, as fractions of the greatest: singular positions are followed to ratios of 1e-4 and less, where
the motion that the drive does not decide is found to the square root of that. Where assembly modes
meet, the smallest singular value with the drives vanishes with the one without them; at a dead
point of the drive it exceeds that by more than the reciprocal."""


class Singularity(NamedTuple):
    """What happens at a singular position.

    Attributes:
        lost: names of the coordinates that cannot move there, as they can elsewhere; none where
            assembly modes meet.
        moving: names of the coordinates that can move while the drives rest.
        resting: names of the drives.
        modes_meet: whether two assembly modes meet, rather than a drive being in a dead point.
    """

    lost: tuple[str, ...]
    moving: tuple[str, ...]
    resting: tuple[str, ...]
    modes_meet: bool

    @property
    def text(self) -> str:
        """What it is in words, for a message that says where."""
        if not self.moving:
            return f"{choices(self.lost)} cannot move"
        verb = "rests" if len(self.resting) == 1 else "rest"
        moving = f"{choices(self.moving)} can move while {choices(self.resting)} {verb}"
        if self.modes_meet:
            return f"assembly modes meet, and {moving}"
        lost = f"{choices(self.lost)} cannot move there, and " if self.lost else ""
        return f"it is a dead point: {lost}{moving}"

    @property
    def details(self) -> dict[str, object]:
        """What errors carry of it."""
        return {"joints": self.lost, "moving": self.moving, "finding": self.text}


def singularity_at(kinematics: Kinematics, x: Array, regular: Array) -> Singularity:
    """Return what happens at, or very near, a singular position.

    Args:
        kinematics: solves the motion.
        x: `(size,)` closed coordinates there.
        regular: `(size,)` closed coordinates somewhere else.
    """
    state = kinematics.evaluate(np.stack([x, regular]))
    group = max(state.groups, key=lambda item: float(item.condition[0]))
    passives = group.group.passives
    left, values, _ = np.linalg.svd(group.scaled_rows[0])
    last = min(len(passives) - len(group.group.idle), len(values)) - 1
    coordinates = kinematics.coordinates
    resting = tuple(coordinates.names_of(set(kinematics.drives.tolist())))
    if last < 0 or values[last] > _RESTS * values[0]:
        # The passives can follow no motion of the drives, and none of their own.
        return Singularity(resting, (), resting, modes_meet=False)
    rates = np.abs(left[:, last])
    moving = passives[rates > _RESTS * np.max(rates)]
    with_drives = np.linalg.svd(group.all_scaled_rows[0], compute_uv=False)
    modes_meet = bool(_RESTS * with_drives[last] < values[last])
    lost: set[int] = set()
    if not modes_meet:
        with np.errstate(all="ignore"):  # The other position may be singular as well.
            usual = np.abs(kinematics.rates(state, np.ones((2, len(kinematics.drives))))[1])
        moves = usual > MOVES * np.max(usual)
        concerned = {*passives.tolist(), *kinematics.drives.tolist()} - set(moving.tolist())
        lost = {column for column in concerned if moves[column]}
        if len(kinematics.drives) == 1:
            lost |= set(kinematics.drives.tolist())
    can_move = tuple(coordinates.names_of(set(moving.tolist())))
    # A ball may lose one component of its rotation, and turn along another.
    cannot = [name for name in coordinates.names_of(lost) if name not in can_move]
    return Singularity(tuple(cannot), can_move, resting, modes_meet)


def gimbal_note(coordinates: Coordinates, x: Array, passives: Iterable[int]) -> str:
    """Return what to add to the message of an error, if a ball is in gimbal lock.

    With its middle angle at ±90°, the axes of the first and of the last turn coincide. That makes
    the closure equations singular where both angles are passive; the mechanism may be regular.

    Args:
        coordinates: layout of the row.
        x: `(size,)` coordinates at or near the singularity.
        passives: velocity coordinates that neither drives nor the scene prescribe.
    """
    if not coordinates.cardan:
        return ""
    passives = set(passives)
    names = {item.column: name for name, item in coordinates.named.items()}
    for joint in sorted(coordinates.cardan):
        columns, rates = coordinates.columns[joint], coordinates.velocity_columns[joint]
        first, middle, last = range(columns.stop - 3, columns.stop)
        if not {rates.stop - 3, rates.stop - 1} <= passives:
            continue
        # The condition is the reciprocal of the distance from ±90°: far greater where errors are.
        if abs(np.cos(x[middle])) < REGULAR_CONDITION**-0.5:
            angle = np.rad2deg(np.arctan2(np.sin(x[middle]), np.cos(x[middle])))
            return (
                f". {names[middle]!r} is {angle:.4g}° there; at ±90° the axes of {names[first]!r} "
                f"and {names[last]!r} coincide (gimbal lock), whatever the mechanism does: turn "
                f"the origin of {joint!r} in the description, or name no coordinate of it"
            )
    return ""
