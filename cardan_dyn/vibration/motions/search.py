"""Search: a periodic motion of a rotating scene at each of many speeds.

Models of small ranges come first; speeds whose motions leave them are solved in larger ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Array
from ...errors import CardanError
from ..model.build import FINE, ROUGH, ModelBuild
from ..model.efforts import FreeEfforts
from ..model.periodic_grid import resampled
from ..model.reduced_model import Course, ReducedModel
from ..model.rotating_scene import RotatingScene
from .harmonic_balance import ROUGHLY, resolved, solved

_POSITIONS = 24
_STEP = 1e-4
"""Step of differences, in units of the coordinates."""
_LONGEST = 0.5
"""Longest step of Newton's method, in units of the coordinates."""
_MOST_STEPS = 40
_PLACED = 1e-3
"""Step, in units of the coordinates, at which the place is good enough to begin with."""
_FIRST = 0.05
"""Half width of the first ranges, in units of the coordinates."""
_GROWTH = 3.0
"""Ratio of a range to the last one: a wider model costs some three times as much."""
_AROUND = (0.09, 0.07, 0.05, 0.035, 0.025, 0.018, 0.012, 0.007, 0.003)
"""Relative distances of the speeds along which motions are carried to one that has none."""
_OFF_CENTRE = 0.1
"""Distance between the middles of two ranges, in half widths, at which one serves for both."""
_SHRINK = 0.8
"""Ratio of a range to the last one that could not be computed."""
_MOST_RANGES = 12
"""Of the loop over ranges, most of which are left for other middles."""
_ROOM = 1.05
"""Range of the model in which motions are refined, as a multiple of their own."""
_NARROW = 0.02
"""Half width of the ranges about a motion, in units of the coordinates."""
_MOST_MODELS = 3
"""About one motion, each about what the last one led to."""
_FARTHEST = 10.0
"""Way from the middle, in half ranges, from which no model about the new place is tried."""


def resting_place(efforts: FreeEfforts, start: Array, speeds: Array, units: Array) -> Array:
    """Return places `(n,)` at which mean efforts vanish; the start if none is met.

    Args:
        efforts: of the scene; their means are those over a revolution of the drive.
        start: places of the free coordinates to begin with `(n,)`.
        speeds: of the drive; the median one counts.
        units: of the coordinates `(n,)`.
    """
    speed, free = float(np.median(speeds)), len(start)
    drive = 2.0 * np.pi / _POSITIONS * np.arange(_POSITIONS)
    ways = np.vstack([np.zeros(free), _STEP * np.diag(units)])

    def mean_efforts(places: Array) -> Array:
        q = np.repeat(places, _POSITIONS, axis=0)
        positions = np.column_stack([np.tile(drive, len(places)), q])
        still = np.zeros_like(positions)
        rates = still.copy()
        rates[:, 0] = speed
        return efforts(positions, rates, still).reshape(len(places), _POSITIONS, free).mean(axis=1)

    place = start.copy()
    try:
        for _ in range(_MOST_STEPS):
            values = mean_efforts(place + ways)
            slopes = (values[1:] - values[0]).T / (_STEP * units)
            step = np.linalg.solve(slopes, -values[0])
            length = float(np.max(np.abs(step) / units))
            place = place + step * min(1.0, _LONGEST / length if length else 1.0)
            if length <= _PLACED:
                return place
    except (CardanError, np.linalg.LinAlgError):
        pass  # Nothing holds a coordinate, or the way leaves what the mechanism can do.
    return start


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


class MotionSearch:
    """Finds periodic motions of one rotating scene; models that were built are kept.

    Attributes:
        rotating: the scene.
        max_amplitude: farthest that a free coordinate may be from its mean, in its unit.
        missed: index of speeds without a motion to the reason, of the last search.
    """

    def __init__(self, rotating: RotatingScene, max_amplitude: float = 1.0) -> None:
        self.rotating, self.max_amplitude = rotating, max_amplitude
        self.build = ModelBuild(rotating)
        self.missed: dict[int, str] = {}
        self._models: dict[float, list[ReducedModel]] = {}
        self._refused: dict[float, float] = {}
        self._reach = max_amplitude
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
        units = self.rotating.units
        centre, share = self.rotating.start[1:].copy(), min(_FIRST, self.max_amplitude)
        left, is_placed = np.arange(len(speeds)), False
        found: list[Motions] = []
        for _ in range(_MOST_RANGES):
            try:
                model = self._model(centre, share * units)
            except CardanError:
                if not self._models.get(FINE):
                    raise
                self._refused[FINE] = share
                break
            there, motions, means = self._at(model, speeds, left)
            found += motions
            left = left[~there]
            if not left.size:
                break
            if not found and not is_placed:
                is_placed, place = True, resting_place(self.build.efforts, centre, speeds, units)
                if np.any(np.abs(place - centre) > 0.5 * share * units):
                    centre = place
                    continue
            moved = np.median(means, axis=0)
            if not found and np.any(np.abs(moved - centre) > 0.5 * share * units):
                # What acts all the time moves the middle, not the range.
                centre = np.clip(moved, centre - 3.0 * share * units, centre + 3.0 * share * units)
                continue
            if share >= self.max_amplitude:
                break
            share = min(_GROWTH * share, self.max_amplitude)
        for ways in (self._roughly, self._carried) if carry else ():
            for item in ways(speeds, left, centre) if left.size else []:
                found.append(item)
                left = np.setdiff1d(left, item.index)
        self.missed = {
            index: f"no periodic motion was found at a speed of {speeds[index]:.12g} rad/s within "
            f"{self._reach:g} rad (or characteristic lengths) of its mean"
            for index in left.tolist()
        }
        return found

    def _model(self, centre: Array, half: Array, wanted: float = FINE) -> ReducedModel:
        """Return a model of given ranges and error, or a known one that has them."""
        for model in self._models.setdefault(wanted, []):
            if np.array_equal(model.half, half) and np.all(
                np.abs(model.centre[0] - centre) <= _OFF_CENTRE * half
            ):
                return model
        model = self.build.model(centre, half, self._divisor, wanted)
        self._divisor = model.divisor
        self._models[wanted].append(model)
        return model

    def widest(self, centre: Array, size: float, error: float = FINE) -> ReducedModel:
        """Return the model of a known or new range that holds motions, as far as can be.

        Args:
            centre: `(n,)` middle of the ranges.
            size: half width that motions need, in units of the coordinates.
            error: of the model.

        Raises:
            CardanError: not even a small range can be computed.
        """
        share = min(_FIRST, self.max_amplitude)
        while share < min(size, self.max_amplitude):
            share = min(_GROWTH * share, self.max_amplitude)
        while True:
            if share < self._refused.get(error, np.inf):
                try:
                    return self._model(centre, share * self.rotating.units, error)
                except CardanError:
                    if share < 2.0 * _FIRST:
                        raise
                    self._refused[error] = share
            share *= _SHRINK

    def _at(
        self, model: ReducedModel, speeds: Array, left: Array
    ) -> tuple[Array, list[Motions], Array]:
        """Return which speeds have motions in a model, these, and means `(K, n)` of others."""
        guess = np.tile(model.centre, (len(left), 1, 1))
        there, motions, means = np.zeros(len(left), dtype=bool), [], []
        for fine, index, found in resolved(model, speeds[left], guess):
            there[index] = found.converged
            means.append(np.mean(found.course.q[~found.converged], axis=1))
            if np.any(found.converged):
                every = Motions(fine, left[index], found.course, found.sign, fine)
                motions.append(every.part(found.converged))
        return there, motions, np.concatenate(means)

    def _roughly(self, speeds: Array, left: Array, centre: Array) -> list[Motions]:
        """Return motions at some of the speeds of given indices, by rough models of any range."""
        rough = self.widest(centre, self.max_amplitude, ROUGH)
        self._reach = float(np.min(rough.half / self.rotating.units))
        guess = np.tile(rough.centre, (len(left), 1, 1))
        found = solved(rough, speeds[left], guess, ROUGHLY)
        return self.refined(speeds, left[found.converged], found.course.q[found.converged])

    def _carried(self, speeds: Array, left: Array, centre: Array) -> list[Motions]:
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
            rough = self.widest(centre, self.max_amplitude, ROUGH)
            # Rough models may have fewer nodes than those in which the motions were found.
            count = max(rough.count, *(item.model.count for item in begun))
            rough = rough.on(count)
            q = np.concatenate([resampled(item.course.q, count, 1) for item in begun])
            for factor in (*ratio[1:], 1.0):
                step = solved(rough, speeds[index] * factor, q, ROUGHLY)
                q, index = step.course.q[step.converged], index[step.converged]
            result += self.refined(speeds, index, q)
            done = [item.index for item in result]
            left = np.setdiff1d(left, np.concatenate(done)) if done else left
        return result

    def refined(self, speeds: Array, index: Array, q: Array) -> list[Motions]:
        """Return the motions that rough ones are near to; some may have none.

        Those that are too large for a model of their range have models of their own, about them.

        Args:
            speeds: `(S,)`.
            index: `(K,)` of the motions' speeds.
            q: `(K, N, n)` rough motions at the nodes of a period.
        """
        if not index.size:
            return []
        units, result = self.rotating.units, []
        middle = np.mean(q, axis=(0, 1))
        sizes = np.max(np.abs(q - middle) / units, axis=(1, 2))
        small = np.nonzero(_ROOM * sizes < self._refused.get(FINE, np.inf))[0]
        if small.size:
            model = self.widest(middle, _ROOM * float(np.max(sizes[small])))
            small = small[sizes[small] <= np.min(model.half / units)]
        if small.size:
            count = max(model.count, q.shape[1])
            guess = resampled(q[small], count, 1)
            for fine, chosen, found in resolved(model, speeds[index[small]], guess):
                every = Motions(fine, index[small[chosen]], found.course, found.sign, fine)
                if np.any(found.converged):
                    result.append(every.part(found.converged))
        for item in np.setdiff1d(np.arange(len(index)), small).tolist():
            result += self._along(speeds, index[item : item + 1], q[item])
        return result

    def _along(self, speeds: Array, index: Array, q: Array) -> list[Motions]:
        """Return the motion near a rough one `(N, n)` by a model about it, or none."""
        units = self.rotating.units
        middle = self.widest(np.mean(q, axis=0), _FIRST)
        for _ in range(_MOST_MODELS):
            try:
                model = self.build.along(q, _NARROW * units, middle.divisor)
            except CardanError:
                # It comes too near to where the mechanism cannot go.
                break
            count = max(model.count, middle.count)
            guess = resampled(q, count)[None]
            ((fine, _, found),) = resolved(model.on(count), speeds[index], guess)
            if found.converged[0]:
                rest = middle.on(fine.count)
                return [Motions(fine, index, found.course, found.sign, rest)]
            q = found.course.q[0]
            if np.max(np.abs(q - fine.centre) / fine.half) > _FARTHEST:
                break
        return []
