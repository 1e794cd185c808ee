"""Models of one scene, in ranges as wide as its motions need; what was built is kept."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import AccuracyError, CardanError
from ....kit.periodic import resampled
from ..model.build import FINE, ModelBuild
from ..model.efforts import FreeEfforts
from ..model.reduced_model import Course, LocalEquation, ReducedModel
from ..model.rotating_scene import RotatingScene
from .harmonic_balance import resolved

FIRST_RANGE = 0.0125
"""Half width of the first ranges, in units of the coordinates."""
NARROWEST = 0.1
"""Least range of a coordinate, as a fraction of the widest one."""
GROWTH = 3.0
"""Ratio of a range to the last one, where nothing tells how large motions are."""
_OFF_CENTRE = 0.1
"""Distance between the middles of two ranges, in half widths, at which one serves for both."""
_SHRINK = 0.8
"""Ratio of a range to the last one that could not be computed, or more."""
_POWER = 0.07
"""Inverse of the power of the range with which errors of models of many polynomials fall."""
ROOM = 1.1
"""Range of a model, as a multiple of that of the motions for which it is built."""
ROOM_AHEAD = 2.0
"""The same for a motion that has left a model, since those that follow may be larger."""
_NARROW = 0.02
"""Half width of the ranges about a motion, in units of the coordinates."""
_MOST_MODELS = 3
"""About one motion, each about what the last one led to."""
_CLOSE, _MOST_KEPT = 0.5, 24
"""Way of a motion from the middle of a model about another one, in half ranges, up to which that
has room for it; and how many such models are kept."""
_FARTHEST = 10.0
"""Way from the middle, in half ranges, from which no model about the new place is tried."""


@dataclass(frozen=True, eq=False)
class Motions:
    """Periodic motions of one model.

    Attributes:
        model: on the nodes of the motions.
        index: `(S,)` of the speed among those that were asked for.
        course: S motions.
        sign: `(S,)` of the determinant of their Jacobians.
        middle: a model on the same nodes that holds the means of the motions, which one about a
            large motion does not.
    """

    model: ReducedModel
    index: Array
    course: Course
    sign: Array
    middle: ReducedModel

    def part(self, chosen: Array | slice) -> Motions:
        """Return some of them, by a mask, indices or a slice."""
        course = Course(*(item[chosen] for item in self.course))
        return replace(self, index=self.index[chosen], course=course, sign=self.sign[chosen])

    @cached_property
    def equation(self) -> LocalEquation:
        """The equation of small changes along them."""
        return self.model.equation(self.course)


class MotionModels:
    """Reduced models of a rotating scene.

    Attributes:
        rotating: the scene.
        max_amplitude: farthest that a free coordinate may be from its mean, in its unit.
    """

    def __init__(self, rotating: RotatingScene, max_amplitude: float) -> None:
        self.rotating, self.max_amplitude = rotating, max_amplitude
        self._build = ModelBuild(rotating)
        self._models: dict[float, list[ReducedModel]] = {}
        self._refused: dict[float, list[Array]] = {}
        self._divisor: int | None = None
        self._about: list[ReducedModel] = []

    @property
    def efforts(self) -> FreeEfforts:
        """Of the free coordinates."""
        return self._build.efforts

    @property
    def period(self) -> float:
        """Of the equation in the drive's position [rad]; known after a model was built."""
        return self.rotating.period / (self._divisor or 1)

    def grown(self, centre: Array, share: Array) -> ReducedModel | None:
        """Return a model of a range that grows from the first one; None if it goes too far.

        Args:
            centre: `(n,)` middle of the range.
            share: its half widths `(n,)`, in units of the coordinates.

        Raises:
            CardanError: not even the first range can be computed.
        """
        if self._is_refused(share, FINE):
            return None
        try:
            return self._model(centre, share * self.rotating.units)
        except CardanError:
            if not self._models.get(FINE):
                raise
            self._refused.setdefault(FINE, []).append(share)
            return None

    def fine(self, centre: Array) -> list[ReducedModel]:
        """Return the known models about a place or one near it, the smallest first."""
        near = [
            model
            for model in self._models.get(FINE, [])
            if np.all(np.abs(model.centre[0] - centre) <= _OFF_CENTRE * model.half)
        ]
        return sorted(near, key=_size)

    def _is_refused(self, share: Array, wanted: float) -> bool:
        """Return whether a range, or one within it, could not be computed."""
        return any(bool(np.all(share >= other)) for other in self._refused.get(wanted, []))

    def _model(self, centre: Array, half: Array, wanted: float = FINE) -> ReducedModel:
        """Return a model of given ranges and error, or a known one that has them."""
        for model in self._models.get(wanted, []):
            is_near = np.all(np.abs(model.centre[0] - centre) <= _OFF_CENTRE * model.half)
            if is_near and np.array_equal(model.half, half):
                return model
        model = self._build.model(centre, half, self._divisor, wanted)
        self._divisor = model.divisor
        self._models.setdefault(wanted, []).append(model)
        return model

    def _holding(self, centre: Array, size: Array, wanted: float) -> ReducedModel | None:
        """Return the smallest known model that holds motions, or one finer than wanted."""
        holding = [
            model
            for error, models in self._models.items()
            if error <= wanted
            for model in models
            if np.all(np.abs(model.centre[0] - centre) + size * self.rotating.units <= model.half)
        ]
        return min(holding, key=_size, default=None)

    def widest(
        self, centre: Array, size: Array | float, error: float = FINE, *, room: float = 1.0
    ) -> ReducedModel:
        """Return the model of a known or new range that holds motions, as far as can be.

        Args:
            centre: `(n,)` middle of the ranges.
            size: half widths that motions need, of each coordinate `(n,)` or of all, in units of
                the coordinates.
            error: of the model.
            room: half widths of a new model, as a multiple of these.

        Raises:
            CardanError: not even a small range can be computed.
        """
        most, least = self.max_amplitude, min(FIRST_RANGE, self.max_amplitude)
        size = np.minimum(np.broadcast_to(size, self.rotating.units.shape), most)
        share = np.clip(room * size, max(NARROWEST * room * np.max(size), least), most)
        refused = 1.0
        while True:
            # A fine one that is hardly too narrow leads to a model about each motion beyond it.
            narrower = share if error <= FINE else _SHRINK * share
            enough = np.where(size <= share, size, narrower)
            known = self._holding(centre, enough, error)
            if known is not None:
                return known
            ratio = _SHRINK
            if not self._is_refused(share, error):
                try:
                    return self._model(centre, share * self.rotating.units, error)
                except CardanError as reason:
                    if np.max(share) <= least:
                        raise
                    ratio = _less(reason)
                    # What lies between is not tried.
                    self._refused.setdefault(error, []).append(share * ratio / _SHRINK)
            # What is refused again and again is so far beyond.
            refused *= _SHRINK
            share = np.maximum(min(ratio, refused) * share, least)

    def refined(self, speed: Array, q: Array, room: float = ROOM) -> list[Motions]:
        """Return the motions that rough ones are near to, with their index; some may have none.

        Those that are too large for a model of their range have models of their own, about them.

        Args:
            speed: `(K,)` [rad/s].
            q: `(K, N, n)` rough motions at the nodes of a period.
            room: range of a new model, as a multiple of theirs.
        """
        if not len(speed):
            return []
        units, result = self.rotating.units, []
        middle = np.mean(q, axis=(0, 1))
        sizes = np.max(np.abs(q - middle) / units, axis=1)
        (small,) = np.nonzero([not self._is_refused(ROOM * size, FINE) for size in sizes])
        if small.size:
            model = self.widest(middle, np.max(sizes[small], axis=0), room=room)
            left = model.half - np.abs(model.centre[0] - middle)
            small = small[np.all(sizes[small] * units <= left, axis=1)]
        if small.size:
            count = max(model.count, q.shape[1])
            guess = resampled(q[small], count, 1)
            for fine, chosen, found in resolved(model, speed[small], guess):
                every = Motions(fine, small[chosen], found.course, found.sign, fine)
                if np.any(found.converged):
                    result.append(every.part(found.converged))
        for item in np.setdiff1d(np.arange(len(speed)), small).tolist():
            result += self._along(speed, np.array([item]), q[item])
        return result

    def _along(self, speed: Array, index: Array, q: Array) -> list[Motions]:
        """Return the motion near a rough one `(N, n)` by a model about it, or none."""
        units = self.rotating.units
        middle = self.widest(np.mean(q, axis=0), FIRST_RANGE)
        # Speeds are often so close that a model about one motion has room for the next.
        known = [model for model in self._about if _distance(model, q) <= _CLOSE]
        if known:
            nearest = min(known, key=lambda model: _distance(model, q))
            found, _ = self._in(nearest, middle, speed, index, q)
            if found:
                return found
        for _ in range(_MOST_MODELS):
            try:
                model = self._build.along(q, _NARROW * units, middle.divisor)
            except CardanError:
                # It comes too near to where the mechanism cannot go.
                break
            found, q = self._in(model, middle, speed, index, q)
            if found:
                self._about = [model, *self._about[: _MOST_KEPT - 1]]
                return found
            if _distance(model, q) > _FARTHEST:
                break
        return []

    def _in(
        self, model: ReducedModel, middle: ReducedModel, speed: Array, index: Array, q: Array
    ) -> tuple[list[Motions], Array]:
        """Return the motion near another one in a model about it, or none, and what was reached."""
        count = max(model.count, middle.count, len(q))
        ((fine, _, found),) = resolved(model.on(count), speed[index], resampled(q, count)[None])
        if not found.converged[0]:
            return [], found.course.q[0]
        rest = middle.on(fine.count)
        return [Motions(fine, index, found.course, found.sign, rest)], found.course.q[0]


def _size(model: ReducedModel) -> int:
    """Return how many numbers a model has, and thus what it costs."""
    return int(model.coefficients.size)


def _less(reason: CardanError) -> float:
    """Return the ratio of a range to a greater one that was refused."""
    if not isinstance(reason, AccuracyError) or not np.isfinite(reason.residual):
        return _SHRINK
    # Errors of polynomials fall with a power of the range, their degree and more.
    return min(_SHRINK, max((reason.tolerance / reason.residual) ** _POWER, _SHRINK**4))


def _distance(model: ReducedModel, q: Array) -> float:
    """Return how far a motion `(N, n)` goes from the middle of a model, in half ranges."""
    count = max(model.count, len(q))
    gap = (resampled(q, count) - model.on(count).centre) / model.half
    return float(np.max(np.abs(gap)))
