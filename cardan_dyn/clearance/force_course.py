"""Force course: a joint's force over a period as a series, and where it swings round."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..simulation.fourier import Fourier

_NEWTON_STEPS = 20
_STAYS = 1e-12
"""Change of a position, as a fraction of a period, at which a minimum is found."""
_FLAT = 1e-4
"""Slope per radian, as a fraction of the greatest force, up to which a force that vanishes only
touches zero: it comes back the way it went, and a ramp is not what it follows."""


_DIP = 1e-6
"""Depth of a dip in the size of a force, as a fraction of the greatest, that may be rounding: a
force is exact beside the greatest of all joints alone."""


class Swing(NamedTuple):
    """A position at which the force across a pin is least, so that it swings round.

    Attributes:
        position: of the drive [rad].
        least: size of the force there [N].
        slope: size of its rate there [N/rad].
        direction: `(d,)` unit vector of the rate as the drive turns in its sense.
        way: how far the drive turns until the force is greatest [rad].
        growth: by which power of the speed the force's rate per time grows, d ln(slope Ω) / d ln Ω:
            3 if inertia alone acts.
    """

    position: float
    least: float
    slope: float
    direction: Array
    way: float
    growth: float


class ForceCourse:
    """The force across a pin over one period of a mechanism.

    Attributes:
        tail: last harmonics, as a fraction of the greatest of all components.
    """

    def __init__(self, forces: Array, period: float, inertial: Array | None = None) -> None:
        """Make the course.

        Args:
            forces: `(N, d)` at equidistant positions of the drive from 0 [N]: of one pin in the
                world, or those of several bearings beside each other.
            period: after which they repeat [rad].
            inertial: `(N, d)` that part of them which grows with the square of the speed, the rest
                not depending on it; None if it is all of them.
        """
        self._forces, self._period = forces, period
        self._sizes = np.linalg.norm(forces, axis=1)
        series = Fourier.of(forces.T, period)
        self.tail = _tail(series)
        self._local = _with_derivatives(series)
        self._inertial: Fourier | None = None
        if inertial is not None:
            self._inertial = _with_derivatives(Fourier.of(inertial.T, period))

    @property
    def most(self) -> float:
        """Greatest force of the samples [N]."""
        return float(np.max(self._sizes))

    def at(self, positions: Array) -> Array:
        """Return the force `(K, d)` at positions of the drive `(K,)` [N]."""
        return np.asarray(self._local(positions)[: self._forces.shape[1]].T)

    def greatest(self, position: float, way: float, sense: float) -> float:
        """Return the greatest force [N] of the samples over a way of the drive in a sense."""
        count = len(self._forces)
        since = sense * (self._period / count * np.arange(count) - position) % self._period
        return float(np.max(self._sizes[since <= way], initial=0.0))

    def swings(self, sense: float) -> list[Swing]:
        """Return where the force is least, in the order of positions.

        Args:
            sense: +1 or -1, in which the drive turns.
        """
        sizes = self._sizes
        step, greatest = self._period / len(sizes), float(np.max(sizes))
        found = []
        for index in _dips(sizes):
            position = self._least_near(index * step, step)
            force, rate, curvature = self._local.at(position).reshape(3, -1)
            slope, least = float(np.linalg.norm(rate)), float(np.linalg.norm(force))
            if slope == 0.0 or max(slope, least) <= _FLAT * greatest:
                continue
            found.append(
                Swing(
                    position=self._in_period(position),
                    least=least,
                    slope=slope,
                    direction=sense * rate / slope,
                    way=self._way_to_greatest(sizes, index, sense) * step,
                    growth=self._growth(position, force, rate, curvature),
                )
            )
        return found

    def _least_near(self, position: float, step: float) -> float:
        """Return where the force is least, within a step, by Newton's method on F · F'."""
        start = position
        for _ in range(_NEWTON_STEPS):
            force, rate, curvature = self._local.at(position).reshape(3, -1)
            bend = float(rate @ rate + force @ curvature)
            change = -float(force @ rate) / bend if bend > 0.0 else 0.0
            position += change
            if abs(change) <= _STAYS * self._period or abs(position - start) > step:
                break
        return position if abs(position - start) <= step else start

    def _in_period(self, position: float) -> float:
        """Return a position from 0 to below a period; its end is its beginning to rounding."""
        inside = position % self._period
        return 0.0 if self._period - inside <= _STAYS * self._period else inside

    def _growth(self, position: float, force: Array, rate: Array, curvature: Array) -> float:
        """Return by which power of the speed the rate per time grows, the least force moving."""
        if self._inertial is None:
            return 3.0
        # By d ln Ω the force grows by twice its inertial part, at one position.
        grown, grown_rate, _ = 2.0 * self._inertial.at(position).reshape(3, -1)
        moved = -(grown @ rate + force @ grown_rate) / (rate @ rate + force @ curvature)
        return float(1.0 + rate @ (curvature * moved + grown_rate) / (rate @ rate))

    @staticmethod
    def _way_to_greatest(sizes: Array, index: int, sense: float) -> int:
        """Return after how many samples in a sense the force is greatest for the first time."""
        turned = np.roll(sizes[:: int(sense)], -index if sense > 0 else index + 1)
        rises = np.nonzero(turned[1:] < turned[:-1])[0]
        return int(rises[0]) if rises.size else len(sizes)


def _dips(sizes: Array) -> list[int]:
    """Return where sizes over a period are least, but for dips that may be rounding."""
    is_least = (sizes < np.roll(sizes, 1)) & (sizes <= np.roll(sizes, -1))
    found, least = np.nonzero(is_least)[0].tolist(), _DIP * float(np.max(sizes))
    if np.ptp(sizes) <= least:
        return []
    while len(found) > 1:
        between = [
            np.max(np.roll(sizes, -low)[: (high - low) % len(sizes)])
            for low, high in zip(found, [*found[1:], found[0]], strict=True)
        ]
        rises = np.minimum(between, np.roll(between, 1)) - sizes[found]
        if np.min(rises) > least:
            break
        del found[int(np.argmin(rises))]
    return [int(index) for index in found]


def _tail(series: Fourier) -> float:
    """Return the greatest of the last quarter of coefficients, as a fraction of all.

    Of all functions together: one that is rounding has no end.
    """
    sizes = np.max(np.abs(series.coefficients), axis=0)
    greatest = float(np.max(sizes))
    last = sizes[(3 * len(sizes)) // 4 :]
    return float(np.max(last, initial=0.0)) / greatest if greatest > 0.0 else 0.0


def _with_derivatives(series: Fourier) -> Fourier:
    """Return functions, their first and their second derivatives in one series."""
    rate = series.derivative()
    every = (series, rate, rate.derivative())
    return Fourier(np.concatenate([item.coefficients for item in every]), series.frequency)
