"""Motion search: a periodic motion of a rotating scene at each of many speeds.

Models of small ranges come first; speeds whose motions leave them are solved in larger ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..errors import CardanError
from .harmonic_balance import resolved, solved
from .model_build import ModelBuild
from .periodic_grid import resampled
from .reduced_model import Course, ReducedModel
from .rotating_scene import RotatingScene

_FIRST = 0.05
"""Half width of the first ranges, in units of the coordinates."""
_GROWTH = 3.0
_AROUND = (0.09, 0.07, 0.05, 0.035, 0.025, 0.018, 0.012, 0.007, 0.003)
"""Relative distances of the speeds along which motions are carried to one that has none."""
_OFF_CENTRE = 0.1
"""Distance between the middles of two ranges, in half widths, at which one serves for both."""
_MOST_RANGES = 12


@dataclass(frozen=True, eq=False)
class Motions:
    """Periodic motions of one model.

    Attributes:
        model: on the nodes of the motions.
        index: `(S,)` of the speed among those that were asked for.
        course: S motions.
        sign: `(S,)` of the determinant of their Jacobians.
    """

    model: ReducedModel
    index: Array
    course: Course
    sign: Array

    def part(self, chosen: Array) -> Motions:
        """Return some of them, by a mask or indices."""
        course = Course(*(item[chosen] for item in self.course))
        return Motions(self.model, self.index[chosen], course, self.sign[chosen])


class MotionSearch:
    """Finds periodic motions of one rotating scene; models that were built are kept.

    Attributes:
        rotating: the scene.
        within: farthest that a free coordinate may be from its mean, in its unit.
        missed: index of speeds without a motion to the reason, of the last search.
    """

    def __init__(self, rotating: RotatingScene, within: float = 1.0) -> None:
        self.rotating, self.within = rotating, within
        self.build = ModelBuild(rotating)
        self.missed: dict[int, str] = {}
        self._models: list[ReducedModel] = []
        self._divisor: int | None = None

    @property
    def period(self) -> float:
        """Of the equation in the drive's position [rad]; known after a search."""
        return self.rotating.period / (self._divisor or 1)

    def primary(self, speeds: Array, *, carry: bool = True) -> list[Motions]:
        """Return one motion for each speed, mostly the smallest.

        Speeds without any are in `missed`.

        Args:
            speeds: `(S,)` [rad/s].
            carry: whether motions are carried from neighbouring speeds to those without one.

        Raises:
            CardanError: see `ModelBuild.model`.
        """
        missed: dict[int, str] = {}
        units = self.rotating.units
        centre, share = self.rotating.start[1:].copy(), min(_FIRST, self.within)
        left = np.arange(len(speeds))
        found: list[Motions] = []
        reason = ""
        for _ in range(_MOST_RANGES):
            try:
                model = self._model(centre, share * units)
            except CardanError as error:
                if not self._models:
                    raise
                reason = f"; larger motions cannot be computed: {error}"
                break
            there, motions, means = self._at(model, speeds, left)
            found += motions
            left = left[~there]
            if not left.size:
                self.missed = missed
                return found
            moved = np.median(means, axis=0)
            if not found and np.any(np.abs(moved - centre) > 0.5 * share * units):
                # What acts all the time moves the middle, not the range.
                centre = np.clip(moved, centre - 3.0 * share * units, centre + 3.0 * share * units)
                continue
            if share >= self.within:
                break
            share = min(_GROWTH * share, self.within)
        for item in self._carried(speeds, left) if left.size and carry else []:
            found.append(item)
            left = np.setdiff1d(left, item.index)
        for index in left.tolist():
            missed[index] = (
                f"no periodic motion was found at a speed of {speeds[index]:.12g} rad/s within "
                f"{self.within:g} rad (or characteristic lengths) of its mean{reason}"
            )
        self.missed = missed
        return found

    def _model(self, centre: Array, half: Array) -> ReducedModel:
        """Return a model of given ranges, or a known one that has them."""
        for model in self._models:
            if np.array_equal(model.half, half) and np.all(
                np.abs(model.centre - centre) <= _OFF_CENTRE * half
            ):
                return model
        model = self.build.model(centre, half, self._divisor)
        self._divisor = model.divisor
        self._models.append(model)
        return model

    def _carried(self, speeds: Array, left: Array) -> list[Motions]:
        """Return motions at some of the speeds of given indices, carried from neighbouring ones."""
        result: list[Motions] = []
        for side in (-1.0, 1.0):
            if not left.size:
                break
            ratio = 1.0 + side * np.array(_AROUND)
            begun = self.primary(speeds[left] * ratio[0], carry=False)
            if not begun:
                continue
            index = left[np.concatenate([item.index for item in begun])]
            middle = np.mean([np.mean(q, axis=0) for item in begun for q in item.course.q], axis=0)
            model = self.widest(middle, self.within)
            # Wide models may have more nodes than those in which the motions were found.
            count = max(model.count, *(item.model.count for item in begun))
            model = model.on(count)
            q = np.concatenate([resampled(item.course.q, count, 1) for item in begun])
            for factor in ratio[1:]:
                step = solved(model, speeds[index] * factor, q)
                q, index = step.course.q[step.converged], index[step.converged]
                if not index.size:
                    break
            if index.size:
                for fine, chosen, found in resolved(model, speeds[index], q):
                    every = Motions(fine, index[chosen], found.course, found.sign)
                    if np.any(found.converged):
                        result.append(every.part(found.converged))
                done = [item.index for item in result]
                left = np.setdiff1d(left, np.concatenate(done)) if done else left
        return result

    def widest(self, centre: Array, wanted: float) -> ReducedModel:
        """Return the model of a known or new range that holds what is wanted, as far as can be.

        Args:
            centre: `(n,)` middle of the ranges.
            wanted: half width, in units of the coordinates.

        Raises:
            CardanError: not even a small range can be computed.
        """
        share = min(_FIRST, self.within)
        while share < min(wanted, self.within):
            share = min(_GROWTH * share, self.within)
        while True:
            try:
                return self._model(centre, share * self.rotating.units)
            except CardanError:
                if share < 2.0 * _FIRST:
                    raise
                share *= 0.6

    def _at(
        self, model: ReducedModel, speeds: Array, left: Array
    ) -> tuple[Array, list[Motions], Array]:
        """Return which speeds have motions in a model, these, and means `(K, n)` of others."""
        guess = np.tile(model.centre, (len(left), model.count, 1))
        there, motions, means = np.zeros(len(left), dtype=bool), [], []
        for fine, index, found in resolved(model, speeds[left], guess):
            there[index] = found.converged
            means.append(np.mean(found.course.q[~found.converged], axis=1))
            if np.any(found.converged):
                every = Motions(fine, left[index], found.course, found.sign)
                motions.append(every.part(found.converged))
        return there, motions, np.concatenate(means)
