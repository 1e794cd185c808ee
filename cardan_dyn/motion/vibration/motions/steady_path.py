"""Steady path: the periodic motion from speed to speed, as a slow run through them follows it.

It is that of a branch, along which steps are short where the motion resonates. Where the branch
turns back in a fold, or ends, the path jumps to the motion that is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ....kit.errors import VibrationError
from .continuation import FIRST, Branch, Point
from .harmonic_balance import Motions, found_near
from .search import MotionSearch

_BESIDE = float(np.sqrt(ROUNDED))
"""Distance from a fold, as a fraction of the range: nearer, motions are known to no more digits."""


@dataclass(frozen=True, eq=False)
class SteadyPath:
    """Periodic motions in the order in which a run meets them.

    Attributes:
        points: a motion each.
        missed: speeds at which no motion was found [rad/s].
        sense: +1 where speeds rise along it, -1 where they fall.
    """

    points: tuple[Point, ...]
    missed: tuple[float, ...]
    sense: float

    @property
    def speed(self) -> Array:
        """Of the motions `(S,)` [rad/s]."""
        return np.array([point.speed for point in self.points])

    def near(self, speed: float) -> list[Motions]:
        """Return the motion at another speed, found from the nearest; none if there is none."""
        known = self.points[int(np.argmin(np.abs(self.speed - speed)))]
        return found_near(known.model, np.array([speed]), known.q[None])


def steady_path(search: MotionSearch, first: float, last: float) -> SteadyPath:
    """Follow the smallest motion at the first speed up or down to the last one.

    Args:
        search: of the scene.
        first: speed [rad/s].
        last: of the same sense.

    Raises:
        VibrationError: there is no motion at any of the speeds.
        CardanError: see `MotionSearch.primary`.
    """
    at, way, points, missed = first, last - first, list[Point](), list[float]()
    reason = ""
    while True:
        found, _ = search.smallest(np.array([at]))
        ahead = at + FIRST * way
        if found:
            points += _followed(Point.of(found[0]), first, last)
            at = points[-1].speed
            ahead = max(ahead, at + 2.0 * _BESIDE * way, key=lambda speed: (speed - at) / way)
        else:
            missed.append(at)
            reason = search.missed[0]
        if at == last:
            break
        at = last if (last - ahead) / way < _BESIDE else ahead
    if not points:
        raise VibrationError(reason, speed=at)
    return SteadyPath(tuple(points), tuple(missed), float(np.sign(way)))


def _followed(start: Point, first: float, last: float) -> list[Point]:
    """Return the motions of a branch until it turns back, ends, or reaches a speed."""
    if start.speed == last:
        return [start]
    branch = Branch(start, last, first=first, is_steady=True)
    end = last
    if branch.folds:
        end = branch.folds[0].point.speed - _BESIDE * (last - first)
    found = [point for point in branch.points if (end - point.speed) * (last - first) > 0.0]
    found = found or [start]
    if branch.folds or branch.is_whole:
        for point in branch.near(end)[:1]:
            found += map(Point.of, found_near(point.model, np.array([end]), point.q[None]))
    return found
