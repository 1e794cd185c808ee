"""Characteristic: torque of a drive over its speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import described, numbers
from ..errors import ArgumentError

_CHANGE = 1e-6
"""Relative change of a speed for differences of the torque."""


@dataclass(frozen=True)
class Characteristic:
    """Torque of a drive, constant or a function of its speed.

    Attributes:
        torque: a number [N·m], or a function of the speed [rad/s] that returns one.

    Raises:
        ArgumentError: it is neither.
    """

    torque: float | Callable[[float], float]

    def __post_init__(self) -> None:
        if not callable(self.torque):
            object.__setattr__(self, "torque", _number("torque", self.torque))

    def __call__(self, speed: float) -> float:
        """Return the torque at a speed.

        Raises:
            ArgumentError: the function fails, or returns no finite number.
        """
        if not callable(self.torque):
            return self.torque
        at = f"torque at {speed:g} rad/s"
        try:
            value = self.torque(speed)
        except Exception as error:
            raise ArgumentError(f"{at} fails: {type(error).__name__}: {error}") from error
        return _number(at, value)

    def at(self, speeds: Array) -> Array:
        """Return the torques at speeds of any shape."""
        if not callable(self.torque):
            return np.full(speeds.shape, self.torque)
        return np.array([self(speed) for speed in speeds.ravel().tolist()]).reshape(speeds.shape)

    def slope(self, speeds: Array) -> Array:
        """Return derivatives of the torque by the speed [N·m·s/rad]."""
        if not callable(self.torque):
            return np.zeros(speeds.shape)
        change = _CHANGE * np.abs(speeds)
        return (self.at(speeds + change) - self.at(speeds - change)) / (2.0 * change)


def _number(label: str, value: Any) -> float:
    """Return one finite number.

    Raises:
        ArgumentError: it is none.
    """
    found = numbers(label, value)
    if found.size != 1:
        raise ArgumentError(f"{label} is {described(value)}, expected a number")
    return float(found.reshape(()))
