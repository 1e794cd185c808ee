"""Continuation: periodic motions along a curve through speed, which turns back where they vanish.

Speed is an unknown like the nodes of the motion; each step goes along the tangent of the curve and
is corrected across it, so that folds are passed as any other place (pseudo-arclength). Where the
sign of the Jacobian changes without a fold, another curve crosses this one.

Source: Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, ROUNDED, Array
from ....kit.errors import CardanError
from ....kit.extremes import peak
from ....kit.periodic import MOST_NODES, next_size, resampled, tail
from ....kit.time_left import Task
from ..model.motion_equation import LocalEquation, MotionEquation
from .harmonic_balance import Motions, course_of, jacobian, lacks_orders, swings

_FIRST, _SHORTEST, _LONGEST = 0.05, 1e-7, 0.3
"""Steps: 1 is the greatest motion on the branch so far, or the width of the range."""
_FORETOLD = 0.02
"""Error of a motion that was foretold, in the same measure, at which a step is right."""
_TURN = 0.9
"""Cosine of the angle between two tangents from which on a step was too long."""
_AT_LAST = 5e-3
"""Shortest step towards the end of what is asked for."""
_CUT = 1e-4
"""Highest orders, as a fraction of a motion, that a rough branch may lack."""
_MOST_CORRECTIONS = 7
_MOST_POINTS, _MOST_ROUGH = 3000, 200
"""Of a branch, and of a rough one: none that was of use had more than a hundred."""
_HALVINGS = 6
"""Of the interval in which two branches cross, which then is shorter than the first step aside."""
_LOOP = 8
"""Points before which no curve can be closed."""
_BACK = 0.25
"""How far before its beginning a branch may come back, as a fraction of the range of speed."""


class Point(NamedTuple):
    """A motion on a branch.

    Attributes:
        model: equation on its nodes.
        speed: of the drive [rad/s].
        q: `(N, n)` at the nodes of a period.
        sign: of the determinant of the equation's Jacobian.
    """

    model: MotionEquation
    speed: float
    q: Array
    sign: float

    @classmethod
    def of(cls, motions: Motions, row: int = 0) -> Point:
        """Return one of motions."""
        course, sign = motions.course, float(motions.sign[row])
        return cls(motions.model, float(course.speed[row]), course.q[row], sign)

    def is_same(self, other: Point, gap: Array) -> bool:
        """Return whether another motion differs by no more than a gap `(n,)`, and in no sign."""
        count = max(len(self.q), len(other.q))
        apart = np.abs(resampled(self.q, count) - resampled(other.q, count))
        # Near a fold two motions are close, but of opposite signs.
        return self.sign == other.sign and bool(np.all(apart <= gap))

    @property
    def motions(self) -> Motions:
        """The same as motions of one speed."""
        course = course_of(self.q[None], np.array([self.speed]), self.model.period)
        sign = np.array([self.sign])
        return Motions(self.model, np.zeros(1, dtype=int), course, sign)


Way = tuple[Array, float]
"""By how much a motion `(N, n)` and its speed change."""


class Fold(NamedTuple):
    """Where a branch turns back.

    Attributes:
        place: number of the point nearby.
        sense: in which speed went before.
        point: right there.
    """

    place: int
    sense: float
    point: Point


class Branch:
    """Follows a branch from a motion until it leaves a range of speed.

    Attributes:
        points: in their order along the branch.
        is_whole: whether it leaves the range at its other end.
        reason: why it does not.
    """

    def __init__(
        self,
        start: Point,
        last: float,
        *,
        first: float | None = None,
        way: Way | None = None,
        is_rough: bool = False,
    ) -> None:
        """Follow the branch.

        Args:
            start: its first point.
            last: speed at which the range ends [rad/s].
            first: speed at which it begins; somewhat before the start if None.
            way: along which to leave the start; towards the last speed if None.
            is_rough: whether points near to motions are enough, which have fewer nodes.
        """
        self._units, self._most = start.model.units, start.model.most
        self._is_rough = is_rough
        self._first = start.speed - _BACK * (last - start.speed) if first is None else first
        self._last = last
        self._width = abs(last - (start.speed if first is None else first))
        self._size = 0.0
        self.is_whole, self.reason = False, ""
        self.points = [start]
        self._grow(start)
        try:
            self._follow(start, way)
        except CardanError as error:
            self.reason = str(error)
        except np.linalg.LinAlgError:
            self.reason = "it has no way on that is its own"

    def _follow(self, point: Point, way: Way | None) -> None:
        sense = np.sign(self._last - self._first)
        if way is not None:
            way = resampled(way[0], len(point.q)), way[1]
        way = way or (np.zeros_like(point.q), sense)
        point, ahead = self._at_home(point, self._tangent(point, way))
        self.points = [point]
        step, shortest = _FIRST, _SHORTEST
        most = _MOST_ROUGH if self._is_rough else _MOST_POINTS
        with Task("branch", abs(self._last - self._first)) as task:
            while len(self.points) < most and step >= shortest:
                try:
                    found = self._step(point, ahead, step)
                except CardanError as error:
                    found, shortest, self.reason = None, _AT_LAST, str(error)
                if found is None:
                    step *= 0.4
                    continue
                (point, ahead, factor), self.reason = found, ""
                self._grow(point)
                self.points.append(point)
                step = min(step * factor, _LONGEST)
                task.tell((point.speed - self._first) * sense)
                self.is_whole = (point.speed - self._last) * sense >= 0.0
                if self.is_whole:
                    return
                if (point.speed - self._first) * sense < 0.0:
                    self.reason = "it turns back to where it began"
                    return
                if len(self.points) > _LOOP and self._apart(point, self.points[0]) < 0.5 * step:
                    self.points.append(self.points[0])
                    self.reason = "it is a closed curve"
                    return
        if len(self.points) >= most:
            self.reason = f"it was followed for {most} points only, and goes on"
        self.reason = self.reason or "steps became too short for it to be followed"

    def _grow(self, point: Point) -> None:
        """Let the measure of lengths know a motion."""
        swing = (point.q - np.mean(point.q, axis=0)) / self._units
        self._size = max(self._size, float(np.sqrt(np.mean(swing**2))), 1e-9)

    def _step(self, point: Point, ahead: Way, step: float) -> tuple[Point, Way, float] | None:
        """Return the next point, the way on, and by which factor steps may change; or None."""
        # Lengths have another measure where the branch has grown.
        length = self._length(*ahead)
        way, rate = ahead[0] / length, ahead[1] / length
        q, speed = point.q + step * way, point.speed + step * rate
        if speed * self._last <= 0.0:
            return None
        found = self._corrected(point.model, q, speed, (way, rate))
        if found is None:
            return None
        there, tangent = found
        gap = self._length(there.q - q, there.speed - speed)
        if gap > 2.0 * _FORETOLD:
            return None
        # What the next tangent is compared with has the nodes and the model of the new point.
        further, (q_way, rate_on) = self._at_home(there, tangent)
        old = resampled(way, len(q_way))
        cosine = self._product((old, rate), (q_way, rate_on))
        if cosine < _TURN:
            return None
        factor = min(2.0, 0.9 * float(np.sqrt(_FORETOLD / max(gap, 1e-6))))
        return further, (q_way, rate_on), factor

    def _at_home(self, point: Point, way: Way) -> tuple[Point, Way]:
        """Return a point on enough nodes, and the way on.

        Args:
            point: on too few, maybe.
            way: the way on there.

        Raises:
            CardanError: it is larger than is asked for.
        """
        while True:
            if swings(point.q[None], self._units)[0] > self._most:
                raise CardanError(
                    f"its motions are larger than `max_amplitude`, {self._most:g}: a greater one "
                    "looks farther"
                )
            if not self._lacks_orders(point) or len(point.q) == MOST_NODES:
                return point, way
            model = point.model.on(next_size(len(point.q) + 1))
            q, way = resampled(point.q, model.count), (resampled(way[0], model.count), way[1])
            found = self._corrected(model, q, point.speed, way)
            if found is None:
                raise CardanError("no motion was found beside its last one")
            point, way = found

    def _lacks_orders(self, point: Point) -> bool:
        if not self._is_rough:
            return bool(lacks_orders(point.model, point.q[None])[0])
        return bool(np.max(tail(point.q - np.mean(point.q, axis=0))) > _CUT)

    def _corrected(
        self, model: MotionEquation, q: Array, speed: float, way: Way
    ) -> tuple[Point, Way] | None:
        """Return the motion across a way, and the way on there, in the same sense; or None."""
        across, before = self._dual(*way), np.nan
        for _ in range(_MOST_CORRECTIONS):
            equation, matrix = self._bordered(model, q, speed, across)
            sides = np.zeros((len(matrix), 2))
            sides[:-1, 0], sides[-1, 1] = -equation.efforts[0].T.ravel(), 1.0
            try:
                change, ahead = np.linalg.solve(matrix, sides).T
            except np.linalg.LinAlgError:
                return None
            change_q = change[:-1].reshape(q.shape[1], -1).T
            q, speed = q + change_q, speed + float(change[-1])
            length = max(
                float(np.max(np.abs(change_q / self._units))), abs(float(change[-1] / speed))
            )
            if not length <= self._most or speed * self._last <= 0.0:
                return None
            # Steps shrink by their squares.
            if length <= ROUNDED or length * (length / before) ** 2 <= EPS:
                sign = float(np.linalg.slogdet(matrix[:-1, :-1])[0])
                return Point(model, float(speed), q, sign), self._unit(ahead, q)
            before = length
        return None

    def _bordered(
        self, model: MotionEquation, q: Array, speed: float, across: Array
    ) -> tuple[LocalEquation, Array]:
        """Return the equation of a motion, and its Jacobian beside the speed's, above a row."""
        at = np.array([speed])
        equation = model.along(course_of(q[None], at, model.period))
        inner = jacobian(equation, at, model.period)[0]
        matrix = np.empty((len(inner) + 1, len(inner) + 1))
        matrix[:-1, :-1], matrix[:-1, -1], matrix[-1] = inner, equation.slope[0].T.ravel(), across
        return equation, matrix

    def _tangent(self, point: Point, way: Way) -> Way:
        """Return the way on of length 1, in the sense of another one."""
        _, matrix = self._bordered(point.model, point.q, point.speed, self._dual(*way))
        side = np.zeros(len(matrix))
        side[-1] = 1.0
        return self._unit(np.linalg.solve(matrix, side), point.q)

    def _unit(self, change: Array, q: Array) -> Way:
        """Return a change of nodes and speed `(n N + 1,)` as a way of length 1."""
        way, rate = change[:-1].reshape(q.shape[1], -1).T, float(change[-1])
        length = self._length(way, rate)
        return way / length, rate / length

    def _dual(self, way: Array, rate: float) -> Array:
        """Return the row whose product with a change is its inner product with a way."""
        size = (self._size * self._units) ** 2 * way.size
        return np.append((way / size).T.ravel(), rate / self._width**2)

    def _product(self, first: Way, second: Way) -> float:
        return float(self._dual(*first) @ np.append(second[0].T.ravel(), second[1]))

    def _length(self, way: Array, rate: float) -> float:
        return float(np.sqrt(self._product((way, rate), (way, rate))))

    def _apart(self, first: Point, second: Point) -> float:
        """Return the distance of two points."""
        count = max(len(first.q), len(second.q))
        way = resampled(first.q, count) - resampled(second.q, count)
        return self._length(way, first.speed - second.speed)

    def greatest(self, index: int, measure: Callable[[Point], float]) -> Point:
        """Return the point beside an inner one at which a measure is greatest.

        Args:
            index: of the point whose measure exceeds that of both neighbours.
            measure: of a point.
        """
        here = self.points[index]

        def at(place: float) -> Point:
            beside = self.points[index + (1 if place > 0.0 else -1)]
            return self.between(here, beside, abs(place)) or here

        place, _ = peak(lambda place: measure(at(place)), -1.0, 1.0)
        return max(at(0.0), at(place), key=measure)

    @cached_property
    def folds(self) -> list[Fold]:
        """Where the branch turns back, in the order along it."""
        steps = np.sign(np.diff([point.speed for point in self.points]))
        (turns,) = np.nonzero(steps[1:] * steps[:-1] < 0.0)
        return [
            Fold(index, sense, self.greatest(index, _speed_along(sense)))
            for index, sense in zip((turns + 1).tolist(), steps[turns].tolist(), strict=True)
        ]

    @cached_property
    def _turned(self) -> tuple[list[Point], Array, set[int]]:
        """Points with the folds in place of those nearby, their speeds, and where the folds are."""
        folds = {fold.place: fold.point for fold in self.folds}
        points = [folds.get(place, point) for place, point in enumerate(self.points)]
        return points, np.array([point.speed for point in points]), set(folds)

    def near(self, speed: float) -> list[Point]:
        """Return where the branch passes a speed, interpolated."""
        points, speeds, folds = self._turned
        found = []
        is_between = (speeds[:-1] - speed) * (speeds[1:] - speed) <= 0.0
        for place in np.nonzero(is_between & (speeds[:-1] != speeds[1:]))[0].tolist():
            first, second = points[place : place + 2]
            share = (speed - first.speed) / (second.speed - first.speed)
            # Beside a fold the way goes with the root of the speed's.
            if place in folds:
                share = np.sqrt(share)
            elif place + 1 in folds:
                share = 1.0 - np.sqrt(1.0 - share)
            one = second if place in folds else first
            count = max(len(first.q), len(second.q))
            ends = [resampled(point.q, count) for point in (first, second)]
            q = ends[0] + share * (ends[1] - ends[0])
            found.append(Point(one.model, speed, q, one.sign))
        return found

    def crossed(self) -> list[tuple[Point, Way]]:
        """Return where other branches cross this one, each with the way along the other."""
        beside = {fold.place + side for fold in self.folds for side in (-1, 0)}
        found = []
        for place, (first, second) in enumerate(pairwise(self.points)):
            if first.sign * second.sign < 0.0 and place not in beside:
                found.append(self._aside(self._sign_change(first, second), first, second))
        return found

    def _sign_change(self, first: Point, second: Point) -> Point:
        """Return a point near to the place between two points at which the sign changes."""
        low, high, found = 0.0, 1.0, first
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            point = self.between(first, second, middle)
            if point is None:
                break  # Right there Newton's method has no way on.
            found = point
            low, high = (middle, high) if point.sign == first.sign else (low, middle)
        return found

    def _aside(self, point: Point, first: Point, second: Point) -> tuple[Point, Way]:
        """Return a point at which the Jacobian is singular, and the way across this branch."""
        ends = [resampled(end.q, len(point.q)) for end in (first, second)]
        way = self._tangent(point, (ends[1] - ends[0], second.speed - first.speed))
        _, matrix = self._bordered(point.model, point.q, point.speed, self._dual(*way))
        scale = np.append(np.repeat(self._units * self._size, len(point.q)), self._width)
        rows = np.max(np.abs(matrix * scale), axis=1, keepdims=True)
        aside = np.linalg.svd(matrix * scale / rows)[2][-1] * scale
        return point, self._unit(aside, point.q)

    def beside(self, point: Point, way: Way) -> Point | None:
        """Return the point at a first step along a way that leaves this branch; None if none."""
        q, speed = point.q + _FIRST * way[0], point.speed + _FIRST * way[1]
        found = self._corrected(point.model, q, speed, way)
        return found and found[0]

    def between(self, first: Point, second: Point, share: float) -> Point | None:
        """Return the point at a share of the way from one to the next."""
        count = max(len(first.q), len(second.q))
        ends = [resampled(point.q, count) for point in (first, second)]
        way, rate = ends[1] - ends[0], second.speed - first.speed
        q, speed = ends[0] + share * way, first.speed + share * rate
        found = self._corrected(first.model.on(count), q, speed, (way, rate))
        return found and found[0]


def _speed_along(sense: float) -> Callable[[Point], float]:
    return lambda point: sense * point.speed
