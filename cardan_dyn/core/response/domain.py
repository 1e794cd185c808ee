"""Domain: the drive positions for which a response holds, a period or a range."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array


class Domain(NamedTuple):
    """A period, sampled at equal steps, or a range, sampled at Chebyshev points.

    Samples lie on a circle: a period goes round it once, a range covers one half of it from its
    upper to its lower end and the other half on the way back. The phase of a position, 0 … 1, is
    where it lies on the circle.

    Attributes:
        origin: where a period starts; the middle of a range [rad or m].
        length: the period; half the range.
        periodic: whether it is a period.
    """

    origin: float
    length: float
    periodic: bool

    @property
    def interval(self) -> tuple[float, float]:
        """Least and greatest position [rad or m]; ±inf of a period."""
        if self.periodic:
            return -np.inf, np.inf
        return self.origin - self.length, self.origin + self.length

    def nodes(self, steps: int) -> Array:
        """Return the positions `(M,)` of samples for a number of steps.

        A period has one sample per step, a range one more. The positions for `steps` are every
        other one of those for twice as many, to the last digit.
        """
        if self.periodic:
            return self.origin + self.length * np.arange(steps) / steps
        # Sines of the distance from the middle keep the points symmetric.
        share = (steps - 2.0 * np.arange(steps + 1)) / steps
        return self.origin + self.length * np.sin(0.5 * np.pi * share)

    def steps(self, samples: int) -> int:
        """Return the number of steps between samples `(M,)`."""
        return samples - (not self.periodic)

    def at_share(self, share: Array) -> Array:
        """Return positions at a share 0 … 1 of all steps; `nodes` lie at k / steps."""
        if self.periodic:
            return self.origin + share * self.length
        return self.origin + self.length * np.sin(0.5 * np.pi * (1.0 - 2.0 * share))

    def on_circle(self, values: Array) -> Array:
        """Return samples `(C, M)` over a whole circle: those of a range there and back."""
        if self.periodic:
            return values
        return np.concatenate([values, values[:, -2:0:-1]], axis=1)

    def phase(self, positions: Array) -> Array:
        """Return the phases `(N,)`, 0 … 1, of positions; those beyond a range are clipped."""
        if self.periodic:
            return _phase_in_period(positions, self.origin, self.length)
        return np.arccos(np.clip((positions - self.origin) / self.length, -1.0, 1.0)) / (
            2.0 * np.pi
        )


def _phase_in_period(positions: Array, origin: float, period: float) -> Array:
    """Return phases 0 … 1 of positions in a period of whole turns, to rounding at any size.

    Beyond a period its remainder would carry the rounding of the period times the number of
    turns; sine and cosine are reduced exactly.
    """
    offset = positions - origin
    turns_per_period = round(period / (2.0 * np.pi))
    if np.max(np.abs(offset), initial=0.0) > period and turns_per_period >= 1:
        angle = np.arctan2(np.sin(positions), np.cos(positions))
        turns = np.rint((positions - angle) / (2.0 * np.pi))
        turns_left = turns - turns_per_period * np.floor(turns / turns_per_period)
        offset = angle + 2.0 * np.pi * turns_left - origin
    phase = offset / period
    phase -= np.floor(phase)
    # A phase just below zero is rounded to 1, which is the same as 0.
    return np.where(phase < 1.0, phase, 0.0)
