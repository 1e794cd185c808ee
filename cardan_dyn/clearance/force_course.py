"""Force course: a joint's force over a period as a series, and where it swings round."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..simulation.fourier import Fourier

_NEWTON_STEPS = 20
_STAYS = 1e-12
"""Change of a position, as a fraction of a period, at which a minimum is found."""


class Swing(NamedTuple):
    """A position at which the force across a pin is least, so that it swings round.

    Attributes:
        position: of the drive [rad].
        least: size of the force there [N].
        slope: size of its rate there [N/rad].
        direction: `(3,)` unit vector of the rate as the drive turns in its sense, in the world.
        way: how far the drive turns until the force is greatest [rad].
    """

    position: float
    least: float
    slope: float
    direction: Array
    way: float


class ForceCourse:
    """The force across a pin over one period of a mechanism."""

    def __init__(self, forces: Array, period: float) -> None:
        """Make the course.

        Args:
            forces: `(N, 3)` in the world, at equidistant positions of the drive from 0 [N].
            period: after which they repeat [rad].
        """
        self._forces, self._period = forces, period
        self._series = Fourier.of(forces.T, period)
        self._rate = self._series.derivative()
        self._curvature = self._rate.derivative()
        self.tail = float(np.max(self._series.tail()))

    def swings(self, sense: float) -> list[Swing]:
        """Return where the force is least, in the order of positions.

        Args:
            sense: +1 or -1, in which the drive turns.
        """
        sizes = np.linalg.norm(self._forces, axis=1)
        is_least = (sizes < np.roll(sizes, 1)) & (sizes <= np.roll(sizes, -1))
        step = self._period / len(sizes)
        found = []
        for index in np.nonzero(is_least)[0].tolist():
            position = self._least_near(index * step, step)
            force, rate = self._series.at(position), self._rate.at(position)
            slope = float(np.linalg.norm(rate))
            if slope == 0.0:
                continue
            least = float(np.linalg.norm(force))
            way = self._way_to_greatest(sizes, index, sense)
            found.append(
                Swing(position % self._period, least, slope, sense * rate / slope, way * step)
            )
        return found

    def _least_near(self, position: float, step: float) -> float:
        """Return where the force is least, within a step, by Newton's method on F · F'."""
        start = position
        for _ in range(_NEWTON_STEPS):
            force, rate = self._series.at(position), self._rate.at(position)
            bend = float(rate @ rate + force @ self._curvature.at(position))
            change = -float(force @ rate) / bend if bend > 0.0 else 0.0
            position += change
            if abs(change) <= _STAYS * self._period or abs(position - start) > step:
                break
        return position if abs(position - start) <= step else start

    @staticmethod
    def _way_to_greatest(sizes: Array, index: int, sense: float) -> int:
        """Return after how many samples in a sense the force is greatest for the first time."""
        turned = np.roll(sizes[:: int(sense)], -index if sense > 0 else index + 1)
        rises = np.nonzero(turned[1:] < turned[:-1])[0]
        return int(rises[0]) if rises.size else len(sizes)
