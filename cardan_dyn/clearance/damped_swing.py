"""Damped swing: x'' + 2 α x' + ω² x = 0 in closed form, its derivatives and where they are zero."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arrays import Array

_ORDERS = 6
"""Derivatives that are kept, the zeroth among them."""
_APART = 0.5
"""Half the difference of both rates of decay, as a fraction of their mean, from which on each is
followed by itself: of their sum, derivatives lose the slow one."""
_GONE = 45.0
"""Time constants after which nothing is left of a decay."""
_GROWTH = 1.5
"""Of the panels of a quadrature where nothing swings."""


class DampedSwing:
    """A swing, or beyond critical damping a creep, from given values at the time 0."""

    def __init__(self, decay: float, frequency: float, value: float, rate: float) -> None:
        """Solve it.

        Args:
            decay: α [1/s], not negative.
            frequency: ω without damping [rad/s], positive.
            value: at the time 0.
            rate: derivative there.
        """
        self._decay, self._frequency = decay, frequency
        square = (frequency - decay) * (frequency + decay)
        self._swings, self._beta = square > 0.0, math.sqrt(abs(square))
        self._values = [value, rate]
        while len(self._values) <= _ORDERS:
            bend = -2.0 * decay * self._values[-1] - frequency**2 * self._values[-2]
            self._values.append(bend)
        fast = decay + self._beta
        slow = frequency**2 / fast
        self._rates = slow, fast
        self._parts: tuple[float, float] | None = None
        if not self._swings and self._beta > _APART * decay:
            self._parts = (
                (rate + fast * value) / (fast - slow),
                -(rate + slow * value) / (fast - slow),
            )

    def at(self, order: int, time: Any) -> Any:
        """Return a derivative at times, numbers or an array."""
        if self._parts is not None:
            pairs = zip(self._parts, self._rates, strict=True)
            return sum(part * (-rate) ** order * np.exp(-rate * time) for part, rate in pairs)
        value, weight = self._pair(order)
        decayed = np.exp(-self._decay * time)
        if self._beta == 0.0:
            return decayed * (value + weight * time)
        x, weight = self._beta * time, weight / self._beta
        if self._swings:
            return decayed * (value * np.cos(x) + weight * np.sin(x))
        gone = -np.expm1(-2.0 * x)
        return np.exp(-self._rates[0] * time) * (value * (1.0 - 0.5 * gone) + 0.5 * weight * gone)

    def _pair(self, order: int) -> tuple[float, float]:
        """Return p and w of a derivative exp(-α t) (p cos βt + w sin(βt) / β)."""
        value = self._values[order]
        return value, self._values[order + 1] + self._decay * value

    def zeros(self, order: int) -> Iterator[float]:
        """Yield the positive times at which a derivative is zero, ascending; they may not end."""
        if self._parts is not None:
            (slow, fast), (a, b) = self._rates, self._parts
            ratio = -b / a * (fast / slow) ** order if a else 0.0
            if ratio > 1.0:
                yield math.log(ratio) / (fast - slow)
            return
        value, weight = self._pair(order)
        if self._swings:
            x = math.atan2(-value, weight / self._beta) % math.pi
            while True:
                if x > 0.0:
                    yield x / self._beta
                x += math.pi
        ratio = -value / weight if weight else 0.0
        if self._beta == 0.0 and ratio > 0.0:
            yield ratio
        elif 0.0 < ratio * self._beta < 1.0:
            yield math.atanh(ratio * self._beta) / self._beta

    def bound(self, order: int, time: float) -> float:
        """Return what a derivative does not exceed from a time on; inf where it does not swing."""
        if not self._swings:
            return math.inf
        value, weight = self._pair(order)
        return math.exp(-self._decay * time) * math.hypot(value, weight / self._beta)

    def panels(self, length: float) -> Array:
        """Return bounds from 0 to a length, close enough for quadrature with 16 nodes in each."""
        if self._swings:
            swings = min(length, _GONE / self._decay) if self._decay else length
            bounds = np.linspace(0.0, swings, math.ceil(swings * self._frequency) + 2)
            return np.append(bounds, length) if swings < length else bounds
        first = 0.5 / self._rates[1]
        count = max(math.ceil(math.log(max(length / first, 1.0)) / math.log(_GROWTH)), 1)
        return np.concatenate([[0.0], length * _GROWTH ** -np.arange(count, -1.0, -1.0)])
