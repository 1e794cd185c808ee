"""Contact law: what all laws of contact have in common, and checks of their numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import number, positive
from ...kit.errors import ArgumentError
from ...kit.frozen import Value

if TYPE_CHECKING:
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    Numbers: TypeAlias = float | ArrayLike  # Floats apart, of which Python's arithmetic is faster.


class ContactLaw(Value):
    """A law of contact: frozen data, checked when it is made; equal where all values are.

    Attributes:
        stiffness: k [N/mⁿ], positive.
    """

    stiffness: float

    @property
    def needs_touch_speed(self) -> bool:
        """Whether the force depends on the speed at which the touch began."""
        return False

    @property
    def order(self) -> float:
        """Exponent n of the spring part k δⁿ."""
        return 1.0

    @property
    def kinks(self) -> tuple[float, ...]:
        """Depths at which a derivative of the force jumps, in ascending order [m]."""
        return ()

    def force(self, depth: Numbers, rate: Numbers, touch_speed: Numbers = 0.0) -> Array:
        """Return the force that presses the sides apart [N].

        It is smooth and not clipped: below zero where the law would pull, so that the zero at
        which the sides part can be located, and continued oddly to negative depths.

        Args:
            depth: δ [m].
            rate: δ̇ [m/s].
            touch_speed: δ̇ at which this touch began [m/s]; not looked at by laws that do not need
                it. Where it is not positive, a touch that began at rest, there is no damping.

        Returns:
            In the broadcast shape.
        """
        raise NotImplementedError

    def energy(self, depth: ArrayLike) -> Array:
        """Return what the spring part stores [J], in the shape of `depth`: k δⁿ⁺¹ / (n + 1)."""
        power = self.order + 1.0
        return self.stiffness * np.maximum(depth, 0.0) ** power / power

    def restitution(self, touch_speed: float, mass: float) -> float:
        """Return the restitution e of a free impact: speed afterwards over speed before.

        Args:
            touch_speed: before it [m/s], positive.
            mass: reduced mass of both sides [kg], positive.

        Returns:
            Between 0 and 1, exact to 1e-10.

        Raises:
            ArgumentError: an argument is no positive number.
        """
        return self._restitution(positive("touch_speed", touch_speed), positive("mass", mass))

    def _restitution(self, touch_speed: float, mass: float) -> float:
        """Return the restitution of checked arguments."""
        raise NotImplementedError

    def _spring(self, depth: ArrayLike) -> Array:
        """Return the force of the spring part, continued oddly."""
        depth = np.asarray(depth, dtype=float)
        return self.stiffness * np.sign(depth) * np.abs(depth) ** self.order

    def _spring_of(self, depth: float) -> float:
        """Return the force of the spring part at one depth, in Python's arithmetic."""
        return math.copysign(self.stiffness * abs(depth) ** self.order, depth)

    def _set(self, **values: object) -> None:
        """Set fields; only constructors call it."""
        for field, value in values.items():
            object.__setattr__(self, field, value)

    def _set_spring(self, stiffness: object, exponent: object) -> None:
        """Set stiffness and exponent to what was checked; only constructors call it."""
        self._set(
            stiffness=positive(self._label("stiffness"), stiffness),
            exponent=number(self._label("exponent"), exponent, 1.0),
        )

    def _label(self, field: str) -> str:
        return f"{type(self).__name__}: {field}"


def ranged(label: str, given: object, least: float) -> float:
    """Return a restitution from a least one to 1.

    Raises:
        ArgumentError: it is no number, or out of range.
    """
    value = number(label, given)
    if not least <= value <= 1.0:
        raise ArgumentError(f"{label} is {value:g}; it lies from {least:g} to 1")
    return value
