"""Steady path: the periodic motion from speed to speed, as a slow run through them follows it.

It is that of a branch, along which steps are short where the motion resonates. Where the branch
turns back in a fold, or ends, the path jumps to the motion that is left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ....kit.errors import VibrationError
from ..model.motion_equation import Course
from .continuation import FIRST, Branch, Point
from .harmonic_balance import Motions, found_near
from .search import MotionSearch

_BESIDE = float(np.sqrt(ROUNDED))
"""Distance from a fold, as a fraction of the range: nearer, motions are known to no more digits."""


@dataclass(frozen=True, eq=False)
class SteadyPath:
    """Periodic motions in the order in which a run meets them.

    Attributes:
        motions: of one speed each, their `index` being the place on the path.
        missed: speeds at which no motion was found [rad/s].
        sense: +1 where speeds rise along it, -1 where they fall.
    """

    motions: tuple[Motions, ...]
    missed: tuple[float, ...]
    sense: float

    @property
    def speed(self) -> Array:
        """Of the motions `(S,)` [rad/s]."""
        return np.array([float(item.course.speed[0]) for item in self.motions])

    def near(self, speed: float) -> list[Motions]:
        """Return the motion at another speed, found from the nearest; none if there is none."""
        known = self.motions[int(np.argmin(np.abs(self.speed - speed)))]
        return found_near(known.model, np.array([speed]), known.course.q)

    def together(self) -> list[Motions]:
        """Return all motions, those on as many nodes in one."""
        groups: dict[int, list[Motions]] = {}
        for item in self.motions:
            groups.setdefault(item.model.count, []).append(item)
        return [_joined(group) for group in groups.values()]


def _joined(group: list[Motions]) -> Motions:
    """Return motions on as many nodes as one."""
    index, sign = (
        np.concatenate(parts)
        for parts in zip(*((item.index, item.sign) for item in group), strict=True)
    )
    courses = zip(*(item.course for item in group), strict=True)
    return Motions(group[0].model, index, Course(*map(np.concatenate, courses)), sign)


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
    at, way, motions, missed = first, last - first, list[Motions](), list[float]()
    reason = ""
    while True:
        found, _ = search.smallest(np.array([at]))
        ahead = at + FIRST * way
        if found:
            motions += _followed(Point.of(found[0]), first, last)
            at = float(motions[-1].course.speed[0])
            ahead = max(ahead, at + 2.0 * _BESIDE * way, key=lambda speed: (speed - at) / way)
        else:
            missed.append(at)
            reason = search.missed[0]
        if at == last:
            break
        at = last if (last - ahead) / way < _BESIDE else ahead
    if not motions:
        raise VibrationError(reason, speed=at)
    numbered = (replace(item, index=np.array([place])) for place, item in enumerate(motions))
    return SteadyPath(tuple(numbered), tuple(missed), float(np.sign(way)))


def _followed(start: Point, first: float, last: float) -> list[Motions]:
    """Return the motions of a branch until it turns back, ends, or reaches a speed."""
    if start.speed == last:
        return [start.motions]
    branch = Branch(start, last, first=first, is_steady=True)
    end = last
    if branch.folds:
        end = branch.folds[0].point.speed - _BESIDE * (last - first)
    points = [point for point in branch.points if (end - point.speed) * (last - first) > 0.0]
    found = [point.motions for point in points or [start]]
    if branch.folds or branch.is_whole:
        for point in branch.near(end)[:1]:
            found += found_near(point.model, np.array([end]), point.q[None])
    return found
