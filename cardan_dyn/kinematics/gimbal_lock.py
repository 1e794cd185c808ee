"""Gimbal lock: where the three angles of a ball do not decide how it turns."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..arrays import Array
from ..mechanism.coordinates import Coordinates

_NEAR = 1e-3
"""Distance [rad] of the middle angle from ±90° up to which a singularity that was found counts as
gimbal lock. The condition number is the reciprocal of that distance, and errors are raised where it
is a million or more."""


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
        if abs(np.cos(x[middle])) < np.sin(_NEAR):
            angle = np.rad2deg(np.arctan2(np.sin(x[middle]), np.cos(x[middle])))
            return (
                f". {names[middle]!r} is {angle:.4g}° there; at ±90° the axes of {names[first]!r} "
                f"and {names[last]!r} coincide (gimbal lock), whatever the mechanism does: turn "
                f"the origin of {joint!r} in the description, or name no coordinate of it"
            )
    return ""
