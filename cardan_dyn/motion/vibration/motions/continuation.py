"""Continuation: periodic motions along a curve through speed, which turns back where they vanish.

Speed is an unknown like the nodes of the motion; each step goes on through the last points along
their tangents and is corrected across these, so that folds are passed as any other place
(pseudo-arclength). Where the sign of the Jacobian changes without a fold, another curve crosses
this one.

Source: Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, ROUNDED, Array
from ....kit.differences import displacements, slopes
from ....kit.errors import CardanError
from ....kit.periodic import MOST_NODES, next_size, resampled, tail
from ....kit.time_left import Task
from ..model.motion_equation import Course, LocalEquation, MotionEquation
from .harmonic_balance import MOST_STEPS, Motions, course_of, jacobian, lacks_orders, swings

FIRST, _SHORTEST, _LONGEST = 0.05, 1e-7, 0.3
"""Steps: 1 is the greatest motion on the branch so far, or the width of the range."""
FORETOLD = 0.02
"""Error of a motion that was foretold, in the same measure, at which a step is right."""
_TURN = 0.45
"""Angle between two tangents [rad] from which on a step was too long."""
_CUT = 1e-4
"""Highest orders, as a fraction of a motion, that a rough branch may lack; shortest step towards
the end of what is asked for."""
_MOST_POINTS, _MOST_ROUGH = 3000, 200
"""Of a branch, and of a rough one: none that was of use had more than a hundred."""
_BACK = 0.25
"""How far before its beginning a branch may come back, as a fraction of the range of speed."""


Way = Array
"""By how much a state changes, see `Point`."""


class Point(NamedTuple):
    """A motion on a branch.

    Attributes:
        model: equation on its nodes.
        state: `(n N + 1,)` the free coordinates at the nodes of a period, one after the other, and
            the speed of the drive.
        sign: of the determinant of the equation's Jacobian.
        way: along the branch, in either sense; None if it was not asked for.
    """

    model: MotionEquation
    state: Array
    sign: float
    way: Way | None = None

    @classmethod
    def of(cls, motions: Motions, row: int = 0) -> Point:
        """Return one of motions."""
        course = motions.course
        state = np.append(course.q[row].T, course.speed[row])
        return cls(motions.model, state, float(motions.sign[row]))

    @property
    def q(self) -> Array:
        """The free coordinates `(N, n)`."""
        return self.state[:-1].reshape(len(self.model.units), -1).T

    @property
    def speed(self) -> float:
        """Of the drive [rad/s]."""
        return float(self.state[-1])

    def on(self, count: int) -> Point:
        """Return the same on another number of nodes."""
        return self._replace(model=self.model.on(count), state=self.resampled(self.state, count))

    def resampled(self, change: Array, count: int) -> Array:
        """Return a change of a state, or a state, on another number of nodes."""
        nodes = change[:-1].reshape(len(self.model.units), -1)
        return np.append(resampled(nodes, count, 1), change[-1])

    def is_same(self, other: Point, gap: Array) -> bool:
        """Return whether another motion differs by no more than a gap `(n,)`, and in no sign."""
        count = max(len(self.q), len(other.q))
        apart = np.abs(self.on(count).q - other.on(count).q)
        # Near a fold two motions are close, but of opposite signs.
        return self.sign == other.sign and bool(np.all(apart <= gap))

    @property
    def course(self) -> Course:
        """The same as that of one motion."""
        return course_of(self.q[None], self.state[-1:], self.model.period)


def motions_of(points: Sequence[Point]) -> list[Motions]:
    """Return points as motions, those on as many nodes in one, whose `index` are their places."""
    counts = np.array([len(point.q) for point in points])
    found = []
    for count in np.unique(counts):
        (index,) = np.nonzero(counts == count)
        some = [points[place] for place in index.tolist()]
        q, speed, sign = (
            np.array([getattr(point, name) for point in some]) for name in ("q", "speed", "sign")
        )
        model = some[0].model
        found.append(Motions(model, index, course_of(q, speed, model.period), sign))
    return found


class Fold(NamedTuple):
    """Where a branch turns back.

    Attributes:
        place: number of the point nearby.
        sense: in which speed went before.
        point: right there; the one nearby if it was not met.
        is_met: whether the place itself was found.
    """

    place: int
    sense: float
    point: Point
    is_met: bool


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
        is_steady: bool = False,
    ) -> None:
        """Follow the branch.

        Args:
            start: its first point.
            last: speed at which the range ends [rad/s].
            first: speed at which it begins; somewhat before the start if None.
            way: along which to leave the start; towards the last speed if None.
            is_rough: whether points near to motions are enough, which have fewer nodes.
            is_steady: whether steps never become longer, and it ends behind its first fold.
        """
        self._units, self._most = start.model.units, start.model.most
        self._is_rough, self._is_steady = is_rough, is_steady
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
        sense, ahead = np.sign(self._last - self._first), np.zeros_like(point.state)
        ahead[-1] = sense
        if way is not None:
            ahead = point.resampled(way, len(point.q))
        point = self._at_home(point._replace(way=self._tangent(point, ahead)))
        self.points = [point]
        step, shortest, longest = FIRST, _SHORTEST, FIRST if self._is_steady else _LONGEST
        has_turned = False
        most = _MOST_ROUGH if self._is_rough else _MOST_POINTS
        with Task("branch", abs(self._last - self._first)) as task:
            while len(self.points) < most and step >= shortest:
                try:
                    found = self._step(step)
                except CardanError as error:
                    found, shortest, self.reason = None, _CUT, str(error)
                if found is None:
                    step *= 0.4
                    continue
                point, factor = found
                self._grow(point)
                has_turned |= (point.speed - self.points[-1].speed) * sense < 0.0
                self.points.append(point)
                step = min(step * factor, longest)
                task.tell((point.speed - self._first) * sense)
                self.is_whole = (point.speed - self._last) * sense >= 0.0
                if self.is_whole:
                    self.reason = ""
                    return
                if not has_turned:
                    continue
                if self._is_steady or (point.speed - self._first) * sense < 0.0:
                    self.reason = "it turns back to where it began"
                    return
                if len(self.points) > 2 and self._apart(point, self.points[0]) < 0.5 * step:
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

    def _step(self, step: float) -> tuple[Point, float] | None:
        """Return the next point, and by which factor steps may change; or None."""
        point = self.points[-1]
        way = self._along(point)
        guess = point._replace(state=point.state + step * way)
        if len(self.points) > 1:
            at, places = self._curve(self.points[-3:])
            guess = at(places[-1] + step)
        if guess.speed * self._last <= 0.0:
            return None
        there = self._corrected(guess, way)
        if there is None:
            return None
        gap = self._apart(there, guess)
        if gap > 2.0 * FORETOLD:
            return None
        further = self._at_home(there)
        # What the next tangent is compared with has the nodes of the new point.
        old = further.resampled(way, len(further.q))
        turn = float(np.arccos(min(1.0, self._product(old, self._along(further)))))
        if turn > _TURN:
            return None
        factor = 0.8 * min(_TURN / max(turn, EPS), np.sqrt(FORETOLD / max(gap, EPS)))
        return further, min(2.0, float(factor))

    def _along(self, point: Point) -> Way:
        """Return the way along the branch at one of its points, of length 1.

        Lengths have another measure where the branch has grown.
        """
        if point.way is not None:
            return self._unit(point.way)
        ahead = np.zeros_like(point.state)
        ahead[-1] = 1.0
        return self._tangent(point, ahead)

    def _curve(self, points: Sequence[Point]) -> tuple[Callable[[float], Point], Array]:
        """Return what foretells points at places on the way through some, and where these are.

        It is the polynomial through them along their tangents, over lengths of arcs of circles.
        """
        from scipy.interpolate import KroghInterpolator  # Few scripts need it.

        count = max(len(point.q) for point in points)
        first = points[0].on(count)
        values = np.array([point.on(count).state for point in points])
        ways = np.array([point.resampled(self._along(point), count) for point in points])
        measure = self._weights(values[0])
        chords = np.diff(values, axis=0)
        sense = np.sign(np.sum(ways * measure * np.concatenate([chords[:1], chords]), axis=1))
        ways *= sense[:, None]
        turns = np.arccos(np.minimum(1.0, np.sum(ways[1:] * measure * ways[:-1], axis=1)))
        arcs = np.sqrt(np.sum(measure * chords**2, axis=1)) / np.sinc(turns / (2.0 * np.pi))
        places = np.append(0.0, np.cumsum(arcs))

        known = np.stack([values, ways], axis=1).reshape(2 * len(values), -1)
        curve = KroghInterpolator(np.repeat(places, 2), known)

        def at(place: float) -> Point:
            return first._replace(state=curve(place), way=curve.derivative(place))

        return at, places

    def _at_home(self, point: Point) -> Point:
        """Return a point on enough nodes.

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
                return point
            finer = point.on(next_size(len(point.q) + 1))
            found = self._corrected(finer, point.resampled(self._along(point), len(finer.q)))
            if found is None:
                raise CardanError("no motion was found beside its last one")
            point = found

    def _lacks_orders(self, point: Point) -> bool:
        if not self._is_rough:
            return bool(lacks_orders(point.model, point.q[None])[0])
        return bool(np.max(tail(point.q - np.mean(point.q, axis=0))) > _CUT)

    def _corrected(self, guess: Point, way: Way) -> Point | None:
        """Return the motion across a way, with the way on there in the same sense; or None."""
        across, before, state = self._weights(way) * way, np.nan, guess.state
        units = np.repeat(self._units, len(guess.q))
        for _ in range(MOST_STEPS):
            equation, matrix = self._bordered(guess._replace(state=state), across)
            sides = np.zeros((len(matrix), 2))
            sides[:-1, 0], sides[-1, 1] = -equation.efforts[0].T.ravel(), 1.0
            try:
                change, ahead = np.linalg.solve(matrix, sides).T
            except np.linalg.LinAlgError:
                return None
            state = state + change
            length = float(np.max(np.abs(change / np.append(units, state[-1]))))
            if not length <= self._most or float(state[-1]) * self._last <= 0.0:
                return None
            # Steps shrink by their squares; short ones that shrink no more are rounding.
            is_rounding = 0.5 * before < length <= np.sqrt(ROUNDED)
            if is_rounding or length <= ROUNDED or length * (length / before) ** 2 <= EPS:
                sign = float(np.linalg.slogdet(matrix[:-1, :-1])[0])
                return Point(guess.model, state, sign, self._unit(ahead))
            if length > before:  # It leads to another motion, or nowhere.
                return None
            before = length
        return None

    def _bordered(self, point: Point, across: Array) -> tuple[LocalEquation, Array]:
        """Return the equation of a motion, and its Jacobian beside the speed's, above a row."""
        model, course = point.model, point.course
        equation = model.along(course)
        inner = jacobian(equation, course.speed, model.period)[0]
        side = equation.slope[0].T.reshape(-1, 1)
        return equation, np.vstack([np.hstack([inner, side]), across])

    def _tangent(self, point: Point, way: Way) -> Way:
        """Return the way on of length 1, in the sense of another one."""
        _, matrix = self._bordered(point, self._weights(way) * way)
        side = np.zeros(len(matrix))
        side[-1] = 1.0
        return self._unit(np.linalg.solve(matrix, side))

    def _weights(self, way: Way) -> Array:
        """Return what squares of the changes of a way are weighed with in that of its length."""
        count = (len(way) - 1) // len(self._units)
        sizes = np.append(np.repeat(self._size * self._units, count), self._width)
        sizes[:-1] *= np.sqrt(len(way) - 1)
        return np.asarray(sizes**-2.0)

    def _product(self, first: Way, second: Way) -> float:
        return float(np.sum(self._weights(first) * first * second))

    def _length(self, way: Way) -> float:
        return float(np.sqrt(self._product(way, way)))

    def _unit(self, way: Way) -> Way:
        """Return a way with length 1."""
        return way / self._length(way)

    def _between(self, first: Point, second: Point, count: int = 0) -> Way:
        """Return the way from one point to another, on the nodes of the finer one or on others."""
        count = count or max(len(first.q), len(second.q))
        return second.on(count).state - first.on(count).state

    def _apart(self, first: Point, second: Point) -> float:
        """Return the distance of two points."""
        return self._length(self._between(first, second))

    def greatest(self, index: int, measure: Callable[[Point], float]) -> tuple[Point, bool]:
        """Return the point beside an inner one at which a measure is greatest.

        And whether it was met: if not, it is the inner one.

        Args:
            index: of the point whose measure exceeds that of both neighbours.
            measure: of a point.
        """

        def rise(point: Point) -> float:
            changes = displacements(np.ones(1)) * self._along(point)
            moved = (point._replace(state=point.state + change) for change in changes)
            return float(slopes(np.array([measure(item) for item in moved]), np.ones(1))[0])

        top = self.points[index]
        first, second = self.points[index : index + 2]
        if rise(top) < 0.0:
            first, second = self.points[index - 1 : index + 1]
        found = self.reached(first, second, rise)
        return max(top, found or top, key=measure), found is not None

    def reached(
        self, first: Point, second: Point, measure: Callable[[Point], float]
    ) -> Point | None:
        """Return the point between two at which a measure is zero; None if none is found.

        Args:
            first: a point.
            second: another one beside it, whose measure has the other sign.
            measure: of a point.
        """
        from scipy.optimize import brentq

        is_above, gap = measure(first) > 0.0, np.inf
        while True:
            at, places = self._curve([first, second])
            if (measure(at(0.0)) > 0.0) == (measure(at(places[-1])) > 0.0):
                # To rounding, it is zero at one of them.
                return min(first, second, key=lambda point: abs(measure(point)))
            place = brentq(lambda place, at=at: measure(at(place)), *places)
            there, before = self._met(first, second, place / places[-1]), gap
            if there is None:
                return None
            point, gap = there
            if gap <= ROUNDED or gap > 0.5 * before:
                return point
            if (measure(point) > 0.0) == is_above:
                first = point
            else:
                second = point

    @cached_property
    def folds(self) -> list[Fold]:
        """Where the branch turns back, in the order along it."""
        steps = np.sign(np.diff([point.speed for point in self.points]))
        (turns,) = np.nonzero(steps[1:] * steps[:-1] < 0.0)
        return [
            Fold(index, sense, *self.greatest(index, _speed_along(sense)))
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
        from scipy.optimize import brentq

        points, speeds, folds = self._turned
        found = []
        is_between = (speeds[:-1] - speed) * (speeds[1:] - speed) <= 0.0
        for place in np.nonzero(is_between & (speeds[:-1] != speeds[1:]))[0].tolist():
            first, second = points[place : place + 2]
            at, places = self._curve([first, second])
            passed = at(brentq(lambda place, at=at: at(place).speed - speed, *places))
            # In a fold itself the sign changes.
            one = second if place in folds else first
            passed.state[-1] = speed
            found.append(passed._replace(sign=one.sign))
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
        while high - low > FORETOLD:
            middle = 0.5 * (low + high)
            met = self._met(first, second, middle)
            if met is None:
                break  # Right there Newton's method has no way on.
            found, _ = met
            low, high = (middle, high) if found.sign == first.sign else (low, middle)
        return found

    def _aside(self, point: Point, first: Point, second: Point) -> tuple[Point, Way]:
        """Return a point at which the Jacobian is singular, and the way across this branch."""
        way = self._tangent(point, self._between(first, second, len(point.q)))
        _, matrix = self._bordered(point, self._weights(way) * way)
        scale = np.append(np.repeat(self._units * self._size, len(point.q)), self._width)
        rows = np.max(np.abs(matrix * scale), axis=1, keepdims=True)
        return point, self._unit(np.linalg.svd(matrix * scale / rows)[2][-1] * scale)

    def beside(self, point: Point, way: Way) -> Point | None:
        """Return the point at a first step along a way that leaves this branch; None if none."""
        return self._corrected(point._replace(state=point.state + FIRST * way), way)

    def _met(self, first: Point, second: Point, share: float) -> tuple[Point, float] | None:
        """Return the point at a share of the way to the next, and how far from it was foretold."""
        at, places = self._curve([first, second])
        guess = at(share * places[-1])
        found = self._corrected(guess, self._between(first, second, len(guess.q)))
        return found and (found, self._apart(found, guess))


def _speed_along(sense: float) -> Callable[[Point], float]:
    return lambda point: sense * point.speed
