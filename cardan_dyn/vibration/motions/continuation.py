"""Branch: periodic motions along a curve through speed, which turns back where motions vanish.

Speed is an unknown like the nodes of the motion; each step goes along the tangent of the curve and
is corrected across it, so that folds are passed as any other place (pseudo-arclength).

Source: Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import CardanError
from ..model.build import FINE, ROUGH, WORST_ERROR
from ..model.periodic_grid import MOST_NODES, next_size, resampled
from ..model.reduced_model import LocalEquation, ReducedModel
from .correction import along
from .harmonic_balance import course_of, jacobian, lacks_orders
from .search import Motions, MotionSearch

_FIRST, _SHORTEST, _LONGEST = 0.05, 1e-7, 0.3
"""Steps: 1 is the greatest motion on the branch so far, or the width of the range."""
_FORETOLD = 0.02
"""Error of a motion that was foretold, in the same measure, at which a step is right."""
_TURN = 0.9
"""Cosine of the angle between two tangents from which on a step was too long."""
_CORRECTED = 1e-10
"""Newton step, as a fraction of the range of the model, that no other follows."""
_MOST_CORRECTIONS = 7
_MOST_SWEEPS = 12
"""Steps on efforts by sweeps, with the derivatives of a rough model: they converge linearly."""
_FARTHEST = 0.1
"""Longest of these steps, as a fraction of the range: what is farther away is another motion."""
_MOST_POINTS = 3000
_GROWTH = 2.0
"""Range of the next model, as a multiple of the motion that has left one."""
_FULL = 0.98
"""Way from the middle of a model, in half ranges, from which on a motion takes a wider one."""
_BACK = 0.25
"""How far before its beginning a branch may come back, as a fraction of the range of speed."""
_FLAT = 1e-6
"""Length of the interval in which an extremum lies at last, as a fraction of two steps."""


class Point(NamedTuple):
    """A motion on a branch.

    Attributes:
        model: in which it was found.
        speed: of the drive [rad/s].
        q: `(N, n)` at the nodes of a period.
        sign: of the determinant of the equation's Jacobian.
        is_exact: whether sweeps agree, where the model is a rough one.
    """

    model: ReducedModel
    speed: float
    q: Array
    sign: float
    is_exact: bool = False

    @classmethod
    def of(cls, motions: Motions) -> Point:
        """Return the first of motions."""
        course = motions.course
        return cls(motions.model, float(course.speed[0]), course.q[0], float(motions.sign[0]))

    @property
    def error(self) -> float:
        """Error of a rough model that sweeps have not put right, as a fraction of the efforts."""
        return 0.0 if self.is_exact or self.model.error <= WORST_ERROR else self.model.error

    @property
    def motions(self) -> Motions:
        """The same as motions of one speed."""
        course = course_of(self.q[None], np.array([self.speed]), self.model.period)
        sign = np.array([self.sign])
        return Motions(self.model, np.zeros(1, dtype=int), course, sign, self.model)


class Branch:
    """Follows a branch from a motion to another speed.

    Attributes:
        points: in their order along the branch.
        is_whole: whether it reaches the other speed. Where it does not, motions are larger than
            `max_amplitude` of the search, or beyond what the mechanism can do.
    """

    def __init__(self, search: MotionSearch, start: Motions, last: float) -> None:
        """Follow the branch.

        Args:
            search: of the scene.
            start: a single motion.
            last: speed at which to end [rad/s].
        """
        self._search, self._units = search, search.rotating.units
        self._first, self._last = float(start.course.speed[0]), last
        self._width = abs(last - self._first)
        self._size = self._error = 0.0
        self.is_whole = False
        model = start.model
        if model is not start.middle:
            # A model about a large motion holds no other one.
            model = search.widest(np.mean(start.course.q[0], axis=0), search.max_amplitude)
        count = max(model.count, start.course.q.shape[1])
        q = resampled(start.course.q[0], count)
        self.points = [Point(model.on(count), self._first, q, float(start.sign[0]))]
        self._follow()

    def _follow(self) -> None:
        point = self.points[0]
        self._grow(point)
        way = np.sign(self._last - self._first)
        try:
            point, ahead = self._at_home(point, np.zeros_like(point.q), way)
            self.points = [point]
            step = _FIRST
            while len(self.points) < _MOST_POINTS and step >= _SHORTEST:
                found = self._step(point, ahead, step)
                if found is None:
                    step *= 0.4
                    continue
                point, ahead, factor = found
                self._grow(point)
                self.points.append(point)
                step = min(step * factor, _LONGEST)
                gone = (point.speed - self._first) * way / self._width
                if gone >= 1.0 or gone < -_BACK:
                    self.is_whole = gone >= 1.0
                    return
        except (CardanError, np.linalg.LinAlgError):
            return  # The range within which the mechanism can be modelled ends here.

    def _grow(self, point: Point) -> None:
        """Let the measure of lengths know a motion."""
        swing = (point.q - np.mean(point.q, axis=0)) / self._units
        self._size = max(self._size, float(np.sqrt(np.mean(swing**2))), 1e-9)

    def _step(
        self, point: Point, ahead: tuple[Array, float], step: float
    ) -> tuple[Point, tuple[Array, float], float] | None:
        """Return the next point, the way on, and by which factor steps may change; or None."""
        # Lengths have another measure where the branch has grown.
        length = self._length(*ahead)
        way, rate = ahead[0] / length, ahead[1] / length
        q, speed = point.q + step * way, point.speed + step * rate
        if speed * self._last <= 0.0:
            return None
        found = self._corrected(point.model, q, speed, way, rate)
        if found is None:
            if not self._holds(point.model, q):
                point, (way, rate) = self._at_home(point, way, rate)
                q, speed = point.q + step * way, point.speed + step * rate
                found = self._corrected(point.model, q, speed, way, rate)
            if found is None:
                return None
        gap = self._length(found.q - q, found.speed - speed)
        if gap > 2.0 * _FORETOLD:
            return None
        # What the next tangent is compared with has the nodes and the model of the new point.
        further, (q_way, rate_on) = self._at_home(found, way, rate)
        old = resampled(way, len(q_way))
        cosine = self._product((old, rate), (q_way, rate_on))
        if cosine < _TURN:
            return None
        factor = min(2.0, 0.9 * float(np.sqrt(_FORETOLD / max(gap, 1e-6))))
        return further, (q_way, rate_on), factor

    def _at_home(self, point: Point, way: Array, rate: float) -> tuple[Point, tuple[Array, float]]:
        """Return a point in a model that has room for it, on enough nodes; and the way on.

        Raises:
            CardanError: there is no such model.
        """
        model, q, speed = point.model, point.q, point.speed
        while True:
            if not self._holds(model, q):
                model = self._wider(q)
                count = max(model.count, len(q))
                model, q = model.on(count), resampled(q, count)
            elif lacks_orders(model, q[None])[0] and len(q) < MOST_NODES:
                count = next_size(len(q) + 1)
                model, q = model.on(count), resampled(q, count)
            elif model is point.model:
                break
            way = resampled(way, len(q))
            found = self._corrected(model, q, speed, way, rate)
            if found is None:
                raise CardanError("the branch ends")
            point = found
            model, q, speed = found.model, found.q, found.speed
        return point, self._tangent(point, way, rate)

    def _holds(self, model: ReducedModel, q: Array) -> bool:
        return bool(np.max(np.abs((q - model.centre) / model.half)) <= _FULL)

    def _wider(self, q: Array) -> ReducedModel:
        """Return a model that holds a motion.

        Raises:
            CardanError: none does.
        """
        middle = np.mean(q, axis=0)
        size = float(np.max(np.abs(q - middle) / self._units))
        if size < self._search.max_amplitude:
            for error in (FINE, ROUGH):
                model = self._search.widest(middle, _GROWTH * size, error)
                if self._holds(model, resampled(q, model.count)):
                    return model
        raise CardanError("motions are larger than what can be modelled")

    def _corrected(
        self, model: ReducedModel, q: Array, speed: float, way: Array, rate: float
    ) -> Point | None:
        """Return the motion across a way, or None."""
        across = self._dual(way, rate)
        for _ in range(_MOST_CORRECTIONS):
            equation, slope = self._equation(model, q, speed)
            matrix = self._bordered(model, equation, slope, speed, across)
            side = np.append(-equation.efforts[0].T.ravel(), 0.0)
            try:
                change = np.linalg.solve(matrix, side)
            except np.linalg.LinAlgError:
                return None
            change_q = change[:-1].reshape(q.shape[1], -1).T
            q, speed = q + change_q, speed + float(change[-1])
            length = float(np.max(np.abs(change_q / model.half)))
            if not np.isfinite(length) or length > 1.0 or speed * self._last <= 0.0:
                return None
            if length <= _CORRECTED and abs(change[-1]) <= _CORRECTED * abs(speed):
                sign = float(np.linalg.slogdet(matrix[:-1, :-1])[0])
                return Point(model, float(speed), q, sign) if self._is_near(model, q) else None
        return None

    def _is_near(self, model: ReducedModel, q: Array) -> bool:
        return bool(np.max(np.abs((q - model.centre) / model.half)) <= 1.02)

    def _equation(self, model: ReducedModel, q: Array, speed: float) -> tuple[LocalEquation, Array]:
        """Return the equation along a motion, and how efforts `(N, n)` change with the speed."""
        course = course_of(q[None], np.array([speed]), model.period)
        # They are quadratic in the speed, for which central differences are exact.
        beside = course_of(np.stack([q, q]), speed * np.array([0.5, 1.5]), model.period)
        efforts = model.efforts(beside)
        return model.equation(course), (efforts[1] - efforts[0]) / speed

    def _bordered(
        self,
        model: ReducedModel,
        equation: LocalEquation,
        slope: Array,
        speed: float,
        across: Array,
    ) -> Array:
        """Return the Jacobian with a column for the speed, and a row for the way."""
        inner = jacobian(equation, np.array([speed]), model.period)[0]
        size = len(inner)
        matrix = np.empty((size + 1, size + 1))
        matrix[:-1, :-1], matrix[:-1, -1], matrix[-1] = inner, slope.T.ravel(), across
        return matrix

    def _tangent(self, point: Point, way: Array, rate: float) -> tuple[Array, float]:
        """Return the way on of length 1, in the sense of another one."""
        equation, slope = self._equation(point.model, point.q, point.speed)
        matrix = self._bordered(point.model, equation, slope, point.speed, self._dual(way, rate))
        side = np.zeros(len(matrix))
        side[-1] = 1.0
        found = np.linalg.solve(matrix, side)
        ahead = found[:-1].reshape(point.q.shape[1], -1).T, float(found[-1])
        length = self._length(*ahead)
        return ahead[0] / length, ahead[1] / length

    def _dual(self, way: Array, rate: float) -> Array:
        """Return the row whose product with a change is its inner product with a way."""
        size = (self._size * self._units) ** 2 * way.size
        return np.append((way / size).T.ravel(), rate / self._width**2)

    def _product(self, first: tuple[Array, float], second: tuple[Array, float]) -> float:
        return float(self._dual(*first) @ np.append(second[0].T.ravel(), second[1]))

    def _length(self, way: Array, rate: float) -> float:
        return float(np.sqrt(self._product((way, rate), (way, rate))))

    def greatest(self, index: int, measure: Callable[[Point], float]) -> Point:
        """Return the point beside an inner one at which a measure is greatest.

        Args:
            index: of the point whose measure exceeds that of both neighbours.
            measure: of a point.
        """
        from scipy.optimize import minimize_scalar

        here = self.points[index]
        best = [self.between(here, self.points[index + 1], 0.0) or here]

        def value(place: float) -> float:
            beside = self.points[index + (1 if place > 0.0 else -1)]
            found = self.between(here, beside, abs(place))
            if found is None:
                return -measure(here)
            if measure(found) > measure(best[0]):
                best[0] = found
            return -measure(found)

        minimize_scalar(value, bounds=(-1.0, 1.0), method="bounded", options={"xatol": _FLAT})
        return best[0]

    def between(self, first: Point, second: Point, share: float) -> Point | None:
        """Return the point at a share of the way from one to the next."""
        model = max((first, second), key=lambda point: (np.min(point.model.half), len(point.q)))
        count = max(len(first.q), len(second.q))
        ends = [resampled(point.q, count) for point in (first, second)]
        way, rate = ends[1] - ends[0], second.speed - first.speed
        q, speed = ends[0] + share * way, first.speed + share * rate
        found = self._corrected(model.model.on(count), q, speed, way, rate)
        if found is None or found.model.error <= WORST_ERROR:
            return found
        return self._swept(found, resampled(way, len(found.q)), rate)

    def _swept(self, point: Point, way: Array, rate: float) -> Point:
        """Return a point of a rough model after steps across a way on efforts by sweeps.

        Where they do not converge, the point stays that of the rough model, whose error it has.
        """
        model, q, speed = point.model, point.q, point.speed
        efforts = self._search.build.efforts
        equation, slope = self._equation(model, q, speed)
        matrix = self._bordered(model, equation, slope, speed, self._dual(way, rate))
        for _ in range(_MOST_SWEEPS):
            course = course_of(q[None], np.array([speed]), model.period)
            try:
                left = along(efforts, model, course)[0]
                change = np.linalg.solve(matrix, np.append(-left.T.ravel(), 0.0))
            except (CardanError, np.linalg.LinAlgError):
                return point
            change_q = change[:-1].reshape(q.shape[1], -1).T
            q, speed = q + change_q, speed + float(change[-1])
            length = float(np.max(np.abs(change_q / model.half)))
            if not length <= _FARTHEST:
                return point
            if length <= _CORRECTED and abs(change[-1]) <= _CORRECTED * abs(speed):
                return point._replace(q=q, speed=speed, is_exact=True)
        return point
