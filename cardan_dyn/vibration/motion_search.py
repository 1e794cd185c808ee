"""Motion search: periodic motions of a rotating scene at many speeds, and those that coexist.

Models of small ranges come first; speeds whose motions leave them are solved in larger ones. Near
forced resonances, where a motion is large, the whole range is searched from many guesses along the
modes that resonate.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from ..arrays import Array
from ..errors import CardanError
from .averaged import modes
from .harmonic_balance import Found, resolved
from .model_build import ModelBuild
from .periodic_grid import resampled
from .reduced_model import Course, ReducedModel
from .rotating_scene import RotatingScene

_FIRST = 0.05
"""Half width of the first ranges, in units of the coordinates."""
_GROWTH = 3.0
_OFF_CENTRE = 0.1
"""Distance between the middles of two ranges, in half widths, at which one serves for both."""
_MOST_RANGES = 12
_WINDOW = 0.12
"""Relative distance from a forced resonance within which other motions are searched."""
_MOST_ORDER = 12
_LARGE = 5e-3
"""Amplitude, in units of the coordinates, from which on a motion is large enough for others."""
_SPREAD = 8.0
"""How many times larger than a motion others are searched."""
_SHARES = (0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9)
_PHASES = (0.0, 0.25, 0.5, 0.75)
"""Guesses: amplitudes as shares of the range, phases as shares of a turn."""
_SAME = 1e-6
"""Difference of two motions, as a fraction of their range, at which they are the same."""


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

    def primary(self, speeds: Array) -> list[Motions]:
        """Return one motion for each speed, the smallest that was found.

        Speeds without any are in `missed`.

        Args:
            speeds: `(S,)` [rad/s].

        Raises:
            CardanError: see `ModelBuild.model`.
        """
        self.missed = {}
        units = self.rotating.units
        centre, share = self.rotating.start[1:].copy(), min(_FIRST, self.within)
        left, found = np.arange(len(speeds)), []
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
                return found
            moved = np.median(means, axis=0)
            if not found and np.any(np.abs(moved - centre) > 0.5 * share * units):
                # What acts all the time moves the middle, not the range.
                centre = np.clip(moved, centre - 3.0 * share * units, centre + 3.0 * share * units)
                continue
            if share >= self.within:
                break
            share = min(_GROWTH * share, self.within)
        for index in left.tolist():
            self.missed[index] = (
                f"no periodic motion was found at a speed of {speeds[index]:.12g} rad/s within "
                f"{self.within:g} rad (or characteristic lengths) of its mean{reason}"
            )
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

    def _largest(self, centre: Array, share: float) -> ReducedModel:
        """Return the model of given ranges, or of the largest ones within that can be computed."""
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

    def others(self, motions: Motions) -> list[Motions]:
        """Return further motions at the same speeds, near forced resonances.

        Args:
            motions: one for each speed, from `primary`.
        """
        middle = np.mean(motions.course.q, axis=1)
        size = np.max(np.abs(motions.course.q - middle[:, None]) / self.rotating.units, axis=(1, 2))
        resonances = self._resonances(motions)
        near = [index for index in range(len(size)) if size[index] > _LARGE and resonances[index]]
        if not near:
            return []
        share, wanted = min(_FIRST, self.within), _SPREAD * float(np.max(size[near]))
        while share < min(wanted, self.within):
            share = min(_GROWTH * share, self.within)
        centre = np.mean(middle[near], axis=0)
        model = self._largest(centre, share)
        guesses: list[Array] = []
        indices: list[int] = []
        for index in near:
            for order, shape in resonances[index]:
                guesses += list(self._guesses(model, order, shape, middle[index]))
            indices += [index] * (len(guesses) - len(indices))
        speeds = motions.course.speed[indices]
        known: dict[int, list[Array]] = {index: [motions.course.q[index]] for index in near}
        different = []
        for fine, chosen, found in resolved(model, speeds, np.array(guesses)):
            different += self._different(motions, fine, found, np.array(indices)[chosen], known)
        return different

    def _guesses(self, model: ReducedModel, order: int, shape: Array, middle: Array) -> Array:
        """Return guesses `(G, N, n)` that swing in a mode at an order of the period."""
        phase = order * 2.0 * np.pi / model.period * model.positions
        scaled = shape / np.max(np.abs(shape) / model.half)
        return np.array(
            [
                middle + share * (np.exp(1j * (phase + 2.0 * np.pi * turn))[:, None] * scaled).real
                for share, turn in product(_SHARES, _PHASES)
            ]
        )

    def _resonances(self, motions: Motions) -> list[list[tuple[int, Array]]]:
        """Return for each motion the orders and mode shapes that are near a forced resonance."""
        equation = motions.model.equation(motions.course)
        found = modes(
            *(
                np.mean(item, axis=1)
                for item in (equation.mass, equation.damping, equation.stiffness)
            )
        )
        base = np.abs(motions.course.speed) * 2.0 * np.pi / motions.model.period
        ratio = found.frequency / base[:, None]
        orders = np.rint(ratio)
        near = (orders >= 1) & (orders <= _MOST_ORDER)
        near &= np.abs(ratio - orders) <= _WINDOW * np.maximum(orders, 1.0)
        return [
            [
                (int(orders[index, mode]), found.shape[index, :, mode])
                for mode in np.nonzero(near[index])[0]
            ]
            for index in range(len(ratio))
        ]

    def _different(
        self,
        motions: Motions,
        model: ReducedModel,
        found: Found,
        indices: Array,
        known: dict[int, list[Array]],
    ) -> list[Motions]:
        """Return found motions that differ from each other and from known ones, which they join."""
        kept = []
        for item in np.nonzero(found.converged)[0].tolist():
            q, others = found.course.q[item], known[int(indices[item])]
            if all(_gap(q, other, model.half) > _SAME for other in others):
                others.append(q)
                kept.append(item)
        if not kept:
            return []
        index = motions.index[indices]
        return [Motions(model, index, found.course, found.sign).part(np.array(kept))]


def _gap(first: Array, second: Array, half: Array) -> float:
    """Return the greatest difference of two motions `(N, n)`, which may differ in their nodes."""
    count = max(len(first), len(second))
    return float(np.max(np.abs(resampled(first, count) - resampled(second, count)) / half))
