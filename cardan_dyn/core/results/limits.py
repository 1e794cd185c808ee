"""Limits: what a description allows its joints, and where a sweep goes beyond that."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.errors import ModelError
from ...kit.quantities import amount
from ..mechanism.mechanism import Mechanism

_LISTED = 3
"""Limits that are told of many that are exceeded."""
UNLIMITED = (-np.inf, np.inf)
_NO_LIMIT = 1e3
"""Range of a coordinate [rad or m] from which on its limits count as none: descriptions write
such numbers where the format requires a limit."""
_TURN = 2.0 * np.pi - 0.02
"""Range of an angle [rad] from which on its limits count as none: exporters write ±3.14 for it."""


def described_limits(mechanism: Mechanism, name: str) -> tuple[float, float]:
    """Return the limits of a coordinate that the description means as such [rad or m].

    A slide may have one end alone, the other one is infinite then; an angle comes round to any.
    """
    joint = mechanism.joints[mechanism.drivable[name].joint]
    if joint.type not in ("revolute", "prismatic"):
        return UNLIMITED
    model = mechanism.model
    column = model.idx_qs[joint.id]
    low, high = float(model.lowerPositionLimit[column]), float(model.upperPositionLimit[column])
    if joint.type == "revolute":
        return (low, high) if 0.0 < high - low < _TURN else UNLIMITED
    if 0.0 < high - low < _NO_LIMIT:
        return low, high
    low, high = (
        low if abs(low) < _NO_LIMIT else -np.inf,
        high if abs(high) < _NO_LIMIT else np.inf,
    )
    return (low, high) if np.isinf([low, high]).any() else UNLIMITED


def exceeded(sweep: Any) -> tuple[str, ...]:
    """Return in words where a sweep goes beyond limits of its description, the farthest first.

    These are positions and speeds of all joints, and efforts of drives, of what is held and of
    actuated joints. An angle is the same after a turn; limits of zero for speeds and efforts are
    none, as URDF requires some. What is beyond by rounding of the greatest values is not.
    """
    found = []
    for what, values, low, high, unit in _limited(sweep):
        flat = np.ravel(np.broadcast_to(values, sweep.shape))
        over = np.nan_to_num(np.maximum(flat - high, low - flat), nan=-np.inf)
        worst = int(over.argmax()) if over.size else 0
        sizes = np.nan_to_num(np.abs([low, high, *flat]), nan=0.0, posinf=0.0)
        if over.size and over[worst] > NOTHING * sizes.max():
            value = float(flat[worst])
            limit = high if value > high else low
            told = f"({amount(limit, unit)}): {amount(value, unit)} at {_at(sweep, worst)}"
            # Beside what is allowed, or where one end alone is, beside the value.
            room = high - low if np.isfinite(high - low) else abs(value)
            found.append((over[worst] / room if room else np.inf, f"exceeds {what} {told}"))
    return tuple(text for _, text in sorted(found, key=lambda item: -item[0]))


def briefly(exceeded: Sequence[str]) -> list[str]:
    """Return the farthest of what is exceeded, and how many others there are."""
    count = len(exceeded) if len(exceeded) <= _LISTED + 1 else _LISTED
    more = [f"exceeds {len(exceeded) - count} more limits by less"] * (count < len(exceeded))
    return [*exceeded[:count], *more]


def _limited(sweep: Any) -> Iterator[tuple[str, Array, float, float, str]]:
    """Yield what has limits, its values `(...)`, least and greatest that are allowed, a unit."""
    for name, item in sweep.mechanism.drivable.items():
        low, high = described_limits(sweep.mechanism, name)
        if (low, high) == UNLIMITED:
            continue
        values = np.asarray(sweep.motion.position(name))
        if item.slides:
            yield f"limit of {name}", values, low, high, "m"
            continue
        turn, middle = 2.0 * np.pi, (low + high) / 2.0
        near = values - turn * np.round((values - middle) / turn)
        low, high = float(np.degrees(low)), float(np.degrees(high))
        yield f"limit of {name}", np.degrees(near), low, high, "°"
    for joint in sweep.mechanism.description.joints:
        if joint.name in sweep.mechanism.drivable and 0.0 < joint.limits.velocity < np.inf:
            most, unit = joint.limits.velocity, sweep.mechanism.drivable[joint.name].unit
            speeds = sweep.motion.velocity(joint.name)
            yield f"speed limit of {joint.name}", speeds, -most, most, f"{unit}/s"
    limits = effort_limits(sweep.mechanism)
    for name, values in efforts(sweep).items():
        if name in limits:
            unit = sweep.mechanism.drivable[name].effort_unit
            yield f"effort limit of {name}", values, *limits[name], unit


def effort_limits(mechanism: Mechanism) -> dict[str, tuple[float, float]]:
    """Return the least and greatest efforts of joints by their description [N·m or N]."""
    every = {item.name: item.limits.efforts for item in mechanism.description.joints}
    return {
        name: (least, greatest)
        for name, (least, greatest) in every.items()
        if (least, greatest) not in ((0.0, 0.0), UNLIMITED)
    }


def efforts(sweep: Any) -> dict[str, Array]:
    """Return the efforts of what is driven, held or actuated, as far as they are known."""
    try:
        of_drives = np.reshape(sweep.drive_effort, (*sweep.shape, -1))
        found = dict(zip(sweep.coordinates, np.moveaxis(of_drives, -1, 0), strict=False))
        return found | dict(sweep.holding_effort) | dict(getattr(sweep, "actuated_effort", {}))
    except ModelError:  # The outputs leave them out.
        return {}


def _at(sweep: Any, sample: int) -> str:
    """Return where a sample is: its time, the position of a single drive, or its number."""
    if np.ndim(sweep.time):
        time = np.ravel(np.broadcast_to(sweep.time, sweep.shape))[sample]
        return f"t = {amount(float(time), 's')}"
    if len(sweep.coordinates) != 1:
        return f"sample {sample}"
    (name,) = sweep.coordinates
    value = float(np.ravel(np.broadcast_to(sweep.position, sweep.shape))[sample])
    if sweep.mechanism.drivable[name].slides:
        return f"{name} {amount(value, 'm')}"
    return f"{name} {amount(float(np.degrees(value)), '°')}"
