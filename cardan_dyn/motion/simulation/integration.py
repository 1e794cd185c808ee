"""Integration: steps in time that keep a system's states consistent, with dense output."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...core.elements.stepping import INSTANT, ImplicitStepper, Step, Stepper, Traced
from ...kit.arrays import Array
from ...kit.errors import CardanError
from .crossings import Crossings
from .forces import State
from .stiffness import jacobian

FINEST = 2.5e-14
"""Least relative tolerance: below, steps cannot be judged in rounding arithmetic."""
_FREE_OF_STAGES = {"DOP853": (1.0 / 3.0, 0.6), "Radau": (0.155, 0.645)}
"""Longest part of a step in which the method has no stage, as fractions of it."""
_TRIED = 24
"""Steps after which it is looked whether equations are stiff, then again each time there are twice
as many; and after which it is looked whether an implicit method was worth its price."""


class Equations(Protocol):
    """A system of differential equations for rows `y`, whose states may obey constraints as well.

    What has a default is that of rows that obey none, and whose turns nothing else counts.
    """

    turns: Array
    """What has to be added to a row, in turns of its entries; `wrap` changes it."""
    evaluations: int
    """How often derivatives were computed."""

    def traced(self) -> Traced | None:
        """Return a program that gives derivatives sooner, see `Stepper`; None if there is none."""
        return None

    def derivative(self, time: float, y: Array) -> Array:
        """Return the time derivative of a row."""
        ...

    def wrap(self, y: Array) -> Array:
        """Return a row without whole turns, which `turns` then counts."""
        ...

    def named(self, y: Array, turns: Array) -> State:
        """Return positions and speeds by name of a row."""
        ...

    def restored(self, time: float, y: Array, *, crosses: bool = False) -> Array:
        """Return the row that obeys the constraints, near one that drifted."""
        return y

    def followed(
        self,
        turns: Array,
        ends: tuple[float, float],
        rows: tuple[Array, Array],
        way: Callable[[float], Array],
    ) -> Array:
        """Return the turns at the end of a part of a step, of which those at its start are known.

        Args:
            turns: at the step's start.
            ends: times of the part [s].
            rows: at them.
            way: rows at any time of the step.
        """
        return turns

    def is_misread(self, y: Array, turns: Array) -> bool:
        """Return whether derivatives took a row at a step's end for one with other turns."""
        return False

    def boundless(self, time: float, y: Array, turns: Array, apart: float) -> str:
        """Return why forces on a row have no bound, see `System`; empty if they have one."""
        return ""


Judge = Callable[[float, Array, float], bool]
"""Returns whether steps are shorter than accuracy asks for, from the time [s], a row and the length
of the last step [s]."""


class Point(NamedTuple):
    """A row with what it means.

    Attributes:
        time: [s].
        y: the row, its constraints restored.
        turns: of the row.
        rate: derivative of the row.
    """

    time: float
    y: Array
    turns: Array
    rate: Array


class Integration:
    """Integrates equations, restoring their constraints after each accepted step.

    Attributes:
        equations: the differential equations.
        points: at the start and after every step.
        steps: the accepted ones.
        method: `DOP853` or `Radau`, the one in use.
        stiff_from: time from which on the equations were found to be stiff, None if they are not.
        crossings: finds those of the constraints; None if there is none.
        strictness: part of the tolerances that steps may use, from the next restart on.
    """

    def __init__(
        self,
        equations: Equations,
        y: Array,
        duration: float,
        *,
        method: str = "DOP853",
        rtol: float,
        atol: Array,
        step: float | None = None,
        longest: float = np.inf,
        crossings: Crossings | None = None,
        stops: Sequence[float] = (),
        is_stiff: Judge | None = None,
    ) -> None:
        """Start an integration at time 0.

        Args:
            equations: the differential equations.
            y: first row, which obeys the constraints.
            duration: end of time [s].
            method: `DOP853` or `Radau`.
            rtol: relative tolerance of a step.
            atol: absolute tolerances, like `y`.
            step: length of all steps [s]; chosen by the error if None.
            longest: step that is allowed then [s].
            crossings: finds those of the constraints, over which steps lead; None if there is none.
            stops: times [s], ascending, after which derivatives are others: steps end there.
            is_stiff: judges a row now and then; None if nothing can be stiff.
        """
        self.equations, self.method, self.crossings = equations, method, crossings
        self.steps: list[Step] = []
        self.stiff_from: float | None = None
        self.strictness = 1.0
        self._duration, self._step, self._longest = duration, step, longest
        self._stops = list(stops)
        self._rtol, self._atol = rtol, np.asarray(atol)
        self._is_cut = False
        self._stepper: Stepper | ImplicitStepper | None = None
        self._ahead: tuple[float, float, float] | None = None
        """Time of the crossing before which a step has just ended, the step that leads over, and
        the shortest that may."""
        self._judge, self._next_look = is_stiff, _TRIED
        self._tried: tuple[int, float] | None = None
        # Equations work in one set of memory; of threads that share a trajectory, one reads it.
        self._lock = threading.RLock()
        y = equations.wrap(y)
        rate = equations.derivative(self._resumed(0.0), y)
        self.points = [Point(0.0, y, equations.turns, rate)]

    def __getstate__(self) -> dict[str, Any]:
        # What was integrated can be copied; what could go on holds functions.
        for step in self.steps:
            with self._within(step):
                step.prepare()
        left_out = "_stepper", "_lock", "_judge", "crossings"
        return {name: value for name, value in self.__dict__.items() if name not in left_out}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.RLock()

    def _begun(
        self, length: float | None = None, *, loosely: bool = False
    ) -> Stepper | ImplicitStepper:
        """Return what steps anew, with a first length [s] if it is known, whatever its error."""
        rtol, atol, longest = self._rtol, self._atol, self._longest
        if self.strictness < 1.0:
            rtol = min(rtol, max(self.strictness * rtol, FINEST))
            atol = atol * (rtol / self._rtol)
        if self._step is not None:
            length = longest = min(self._step, self._duration)
        if loosely or self._step is not None:
            # Tolerances that no step misses make a step as long as it is wanted.
            rtol, atol = 1e3, np.full_like(atol, 1e300)
        asked: dict[str, Any] = {"rtol": rtol, "atol": atol, "longest": longest, "length": length}
        derivative = self.equations.derivative
        if self.method == "DOP853":
            return Stepper(derivative, self._end, **asked, traced=self.equations.traced)
        return ImplicitStepper(derivative, self._end, jacobian=self._jacobian, **asked)

    def _jacobian(self, time: float, y: Array) -> Array:
        """Return the derivatives `(n, n)` of the rates."""
        return jacobian(
            lambda row: self.equations.derivative(time, row), y, self._atol / self._rtol
        )

    @property
    def _end(self) -> float:
        """Time at which steps end: so far before a stop that no stage is rounded beyond it."""
        if not self._stops:
            return self._duration
        return self._stops[0] - 2.0 * float(np.spacing(self._stops[0]))

    def _resumed(self, time: float) -> float:
        """Return the time from which to go on, after a stop where steps have led to one."""
        if not self._stops or time < self._end:
            return time
        # What holds there holds for the next step.
        return math.nextafter(self._stops.pop(0), math.inf)

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self.points[-1].time

    @property
    def times(self) -> Array:
        """Times of the start and of the ends of steps `(N,)` [s]."""
        return np.array([point.time for point in self.points])

    @property
    def is_running(self) -> bool:
        """Whether the end has not been reached."""
        return not self._is_cut and self.time < self._duration

    def advance(self) -> str | None:
        """Take one step; return why it failed, None if it did not."""
        equations, begun = self.equations, self.points[-1]
        while True:
            if self.crossings is not None:
                self.crossings.begin()
            try:
                if self._stepper is None:
                    self._stepper = self._begun()
                stepper = self._stepper
                step = stepper.take(begun.time, begun.y, begun.rate)
                if self.crossings is not None and self._step is None and isinstance(step, Step):
                    step = self._placed(step, self.crossings)
            except CardanError:
                raise
            except (ValueError, ArithmeticError) as error:
                # SciPy's linear algebra refuses what is not finite.
                return f"loads or speeds lead beyond the greatest numbers ({error})"
            if isinstance(step, str):
                return step
            time, length = step.end, step.end - step.start
            step.turns = turns = equations.turns
            y = equations.restored(time, step.last)
            step.last = y
            if step.crosses and self.crossings is not None:
                with self.crossings.stages_closed():
                    step.prepare()
            step.rate = rate = equations.derivative(time, y)
            equations.turns = self._followed(step, time, y)
            if self._step or not equations.is_misread(y, turns) or length < INSTANT * time:
                break
            equations.turns, self._ahead = turns, None
            self._stepper = self._begun(0.5 * length)
        self.steps.append(step)
        wrapped = equations.wrap(y)
        self.points.append(Point(time, wrapped, equations.turns, rate))
        if (resumed := self._resumed(time)) > time:
            self.restart(self.points[-1]._replace(time=resumed))
        if not self.is_running:
            return None
        if isinstance(stepper, Stepper) and self._looks_stiff(time, wrapped, length):
            self._tried = len(self.steps) + _TRIED, length
            self.stiff_from, self.method, self._stepper = time, "Radau", None
        elif self._tried and len(self.steps) >= self._tried[0]:
            # Where slow motion asks for as many steps of lower order, they cost more.
            if length <= self._tried[1]:
                self.stiff_from, self.method = None, "DOP853"
                self._next_look = 2 * len(self.steps)
                self._stepper = self._begun(length)
            self._tried = None
        return None

    def _placed(self, step: Step, crossings: Crossings) -> Step:
        """Return a step that has no stage near a crossing.

        Args:
            step: that was taken; another one is returned if it had to be placed anew, perhaps to
                end where the next one leads over the crossing.
            crossings: finds those on its way.
        """
        begun = self.points[-1]
        start, y, length = begun.time, begun.y, step.end - step.start
        crossing: float | None
        before, after = _FREE_OF_STAGES[self.method]
        # Crossings are led to the middle, but for half of the way to a stage.
        lead, within = 0.5 * (before + after), 0.25 * (after - before)
        if self._ahead is not None:
            crossing, length, shortest = self._ahead
        elif crossings.may_be_near:
            # Stages near a crossing have perhaps made it short, and it is seen far beyond its end.
            bend = (step.last - y - length * begun.rate) / length**2
            length = max(length, self.steps[-1].end - self.steps[-1].start if self.steps else 0.0)

            def ahead(time: float) -> Array:
                return y + (time - start) * (begun.rate + (time - start) * bend)

            crossing = crossings.time(ahead, start, start + length)
            # The stages of a shorter step are so near that their rounding is taken for its error.
            shortest = within * length
        else:
            return step
        self._ahead = None
        farthest = np.inf
        while crossing is not None and crossing > start:
            crosses = (crossing - start) / lead <= length * (1.0 + within)
            if crosses:
                length = (crossing - start) / lead
            end = start + length if crosses else crossing - lead * length
            if end > self._end:
                break
            with crossings.stages_closed():
                loosely = crosses and length <= shortest
                tried = self._begun(end - start, loosely=loosely)
                placed = tried.take(start, y, begun.rate)
                if isinstance(placed, str):
                    break
                placed.prepare()
            if not crosses:
                self._ahead, self._stepper = (crossing, length, shortest), tried
                return placed
            if placed.end - start < 0.99 * length:
                length *= 0.5
                continue
            crossing = crossings.time(placed.dense, start, placed.end)
            if crossing is None or not crossings.is_one(placed.dense(crossing)):
                break
            last, farthest = farthest, abs(crossing - start - lead * length) / length
            if farthest <= within:
                self._stepper = self._begun(length) if loosely else tried
                placed.crosses = True
                return placed
            if not farthest < last:
                break
        return step

    def _looks_stiff(self, time: float, y: Array, length: float) -> bool:
        """Return whether a row is judged to be stiff, if it is time to."""
        if self._judge is None or self._step is not None or len(self.steps) < self._next_look:
            return False
        self._next_look = 2 * len(self.steps)
        return self._judge(time, y, length)

    def columns(self, times: Array) -> tuple[Array, Array, Array]:
        """Return rows, turns and rates at times `(N,)`, a row for each."""
        points = self.points if np.array_equal(times, self.times) else self.points_at(times)
        _, y, turns, rates = zip(*points, strict=True)
        return np.array(y), np.array(turns), np.array(rates)

    def points_at(self, times: Array) -> list[Point]:
        """Return the points at times within what was integrated."""
        if not self.steps:
            return [self.points[0]] * len(times)
        ends = np.array([step.end for step in self.steps])
        indices = np.minimum(np.searchsorted(ends, times), len(ends) - 1).tolist()
        return [
            self.on(self.steps[index], time)
            for index, time in zip(indices, times.tolist(), strict=True)
        ]

    def on(self, step: Step, time: float) -> Point:
        """Return the point at a time on one step."""
        with self._within(step):
            y, turns = self.row_on(step, time)
            self.equations.turns = turns
            return Point(time, y, turns, self.equations.derivative(time, y))

    def row_on(self, step: Step, time: float) -> tuple[Array, Array]:
        """Return the row at a time on one step, and its turns."""
        with self._within(step):
            y = self.equations.restored(time, step.dense(time), crosses=step.crosses)
            return y, self._followed(step, time, y)

    def _followed(self, step: Step, time: float, y: Array) -> Array:
        """Return the turns of a row at a time on a step."""
        if time <= step.start:
            return np.asarray(step.turns)
        return self.equations.followed(step.turns, (step.start, time), (step.first, y), step.dense)

    @contextmanager
    def _within(self, step: Step) -> Iterator[None]:
        """Let the equations count the turns of a step, in one thread at a time."""
        with self._lock:
            kept, self.equations.turns = self.equations.turns, step.turns
            try:
                yield
            finally:
                self.equations.turns = kept

    def restart(self, point: Point) -> None:
        """Go on from a point on the last step, from which on other forces act."""
        equations = self.equations
        self.steps[-1].end = point.time
        # Where other forces act, another crossing is ahead, or none.
        equations.turns, self._ahead = point.turns, None
        y = equations.wrap(point.y)
        rate = equations.derivative(point.time, y)
        self.points[-1] = Point(point.time, y, equations.turns, rate)
        self._stepper = None

    def cut(self, point: Point) -> None:
        """End at a point on the last step."""
        self.points[-1], self._is_cut = point, True
        self.steps[-1].end = point.time
