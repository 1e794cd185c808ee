"""Steady path: the periodic motion from speed to speed, as a slow run through them follows it.

Steps are as long as the motion lets its next one be foretold: short where it resonates. Where it
ends in a fold, the path jumps to the motion that is left.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import VibrationError
from ....kit.periodic import resampled
from ..model.motion_equation import Course
from .harmonic_balance import Motions, found_near
from .search import MotionSearch

_FIRST, _LONGEST, _SHORTEST = 1 / 200, 1 / 24, 1e-6
"""Steps, as fractions of the range of speed."""
_FORETOLD = 0.02
"""Error of a motion that was foretold, as a fraction of the greatest on the path, at which the step
was as long as it should be."""
_BEYOND = 1.05
"""Size, as a multiple of what is looked for, from which on a motion is none."""


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

    def near(self, speeds: Array) -> list[Motions]:
        """Return motions at other speeds `(S,)`, found from the nearest of the path.

        Speeds at which there is none any more are left out; `index` is the place among `speeds`.
        """
        nearest = np.argmin(np.abs(self.speed[:, None] - speeds), axis=0)
        found = []
        for place, (at, speed) in enumerate(zip(nearest.tolist(), speeds.tolist(), strict=True)):
            known = self.motions[at]
            step = _at(known, speed, known.course.q[0], place)
            if step is not None:
                found.append(step)
        return found

    def together(self) -> list[Motions]:
        """Return all motions, those on as many nodes in one."""
        return together(self.motions)


def together(motions: Iterable[Motions]) -> list[Motions]:
    """Return motions, those on as many nodes in one."""
    groups: dict[int, list[Motions]] = {}
    for item in motions:
        groups.setdefault(item.model.count, []).append(item)
    return [_joined(group) for group in groups.values()]


def _joined(group: list[Motions]) -> Motions:
    """Return motions on as many nodes as one."""
    courses = zip(*(item.course for item in group), strict=True)
    return replace(
        group[0],
        index=np.concatenate([item.index for item in group]),
        course=Course(*(np.concatenate(parts) for parts in courses)),
        sign=np.concatenate([item.sign for item in group]),
    )


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
    return _Follower(search, first, last).path()


class _Follower:
    """Follows a motion from speed to speed."""

    def __init__(self, search: MotionSearch, first: float, last: float) -> None:
        self._search, self._last, self._way = search, last, last - first
        self._motions: list[Motions] = []
        self._missed: list[float] = []
        self._greatest = 0.0
        self._at, self._since = first, 0
        self._reason = ""

    def path(self) -> SteadyPath:
        self._begin(self._at)
        step = _FIRST
        while self._at != self._last:
            if not self._motions or self._at in self._missed:
                self._begin(self._next(_LONGEST))
                step = _FIRST
                continue
            speed = self._next(step)
            found, error = self._step(speed)
            if found is not None and error <= 2.0 * _FORETOLD:
                self._add(found)
                factor = np.sqrt(_FORETOLD / max(error, 1e-9))
                step = min(step * min(2.0, 0.9 * factor), _LONGEST)
            elif step > _SHORTEST:
                step = max(0.4 * step, _SHORTEST)
            else:
                self._begin(self._restart(speed))
                step = _FIRST
        if not self._motions:
            raise VibrationError(self._reason, speed=self._at)
        return SteadyPath(tuple(self._motions), tuple(self._missed), float(np.sign(self._way)))

    def _restart(self, speed: float) -> float:
        """Return a speed at which to begin anew, not too near to where that was done last."""
        begun = float(self._motions[self._since].course.speed[0]) if self._motions else self._at
        way = max((speed - begun) / self._way, _LONGEST)
        speed = begun + way * self._way
        return self._last if (self._last - speed) / self._way < 0.5 * _SHORTEST else speed

    def _next(self, step: float) -> float:
        """Return the speed a step further, the last one if that is near."""
        speed = self._at + step * self._way
        left = (self._last - speed) / self._way
        return self._last if left < 0.5 * _SHORTEST else speed

    def _begin(self, speed: float) -> None:
        """Begin with the smallest motion at a speed."""
        self._at, self._since = speed, len(self._motions)
        found, _ = self._search.smallest(np.array([speed]))
        if found:
            self._add(found[0])
        else:
            self._missed.append(speed)
            self._reason = next(iter(self._search.missed.values()))

    def _add(self, motions: Motions) -> None:
        self._motions.append(replace(motions, index=np.array([len(self._motions)])))
        self._at = float(motions.course.speed[0])
        self._greatest = max(self._greatest, self._size(motions.course.q[0]))

    def _size(self, q: Array) -> float:
        """Return how far a motion `(N, n)` goes from its mean, in units of the coordinates."""
        return float(np.max(np.abs(q - np.mean(q, axis=0)) / self._search.rotating.units))

    def _step(self, speed: float) -> tuple[Motions | None, float]:
        """Return the motion at a speed, and by how much it differs from what was foretold."""
        known = self._motions[self._since :][-3:]
        count = max(len(item.course.q[0]) for item in known)
        courses = [resampled(item.course.q[0], count) for item in known]
        places = [float(item.course.speed[0]) for item in known]
        foretold = np.zeros_like(courses[0])
        for own, (place, q) in enumerate(zip(places, courses, strict=True)):
            others = places[:own] + places[own + 1 :]
            foretold += q * float(np.prod([(speed - x) / (place - x) for x in others]))
        found, most = _at(known[-1], speed, foretold, 0), self._search.model.most
        if found is None or self._size(found.course.q[0]) > _BEYOND * most:
            return None, np.inf
        q = found.course.q[0]
        fine = max(len(q), count)
        gap = np.abs(resampled(q, fine) - resampled(foretold, fine)) / self._search.rotating.units
        return found, float(np.max(gap)) / max(self._greatest, 1e-12)


def _at(known: Motions, speed: float, guess: Array, place: int) -> Motions | None:
    """Return the motion at a speed beside another, from a guess `(N, n)`; None if none."""
    model = known.model
    guess = resampled(guess, max(model.count, len(guess)))
    found = found_near(model, np.array([speed]), guess[None])
    return replace(found[0], index=np.array([place])) if found else None
