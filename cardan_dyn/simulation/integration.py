"""Integration: steps in time that keep a system's states consistent, with dense output."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..arrays import Array
from ..errors import CardanError
from .crossings import Crossings

_STIFF = 6.1
"""Step times the greatest rate of decay at which the steps of DOP853 are as long as its stability
allows (Hairer, Nørsett, Wanner: Solving Ordinary Differential Equations I, section II.10)."""
_STIFF_STEPS = 15
"""Steps in a row that have to be so long: then the equations are stiff."""
_STIFF_EVERY = 8
"""Steps after which this is looked at, as long as they are short enough."""
_FREE_OF_STAGES = {"DOP853": 7.0 / 15.0, "Radau": 0.4}
"""Middle of the longest part of a step in which the method has no stage."""
_WITHIN = 0.07
"""How far from there, as a fraction of the step, what has no stage near may be."""
_SHORTEST = 0.2
"""Shortest step over a crossing, in those around it: a shorter one has its stages so near that
their rounding is taken for its error."""
_MOST_PLACED = 8
"""Steps that are tried until one is placed so."""
_FINEST = 1e-13
"""Relative tolerance that a part of one is not made smaller than."""
_SHORTEST_AGAIN = 1e-14
"""Step, as a fraction of the time, up to which one that was misread is not taken again."""
_DIFFERENCE = 1.5e-8
"""Relative step of differences that Jacobians are made of, the root of eps."""
_FINER = 1.0 / 30.0
"""Part of a difference by which it is checked whether rates are straight over it."""
_STRAIGHT = 0.1
"""Greatest change of a column by that, as a fraction of it."""
_FINEST_DIFFERENCES = 4
"""How often differences are made finer; where none agree, rounding is what they see."""
_LOOKED_AT = 64
"""Number of steps after which it is looked whether equations have become stiff; then again each
time there are half as many more."""
_TRIED = 24
"""Steps after which it is looked whether an implicit method was worth its price."""


class Equations(Protocol):
    """A system of differential equations for rows `y`, whose states obey constraints as well."""

    turns: Array
    """What has to be added to a row, in turns of its entries; `wrap` changes it."""
    evaluations: int
    """How often derivatives were computed."""

    def derivative(self, time: float, y: Array) -> Array:
        """Return the time derivative of a row."""
        ...

    def restored(self, time: float, y: Array, *, crosses: bool = False) -> Array:
        """Return the row that obeys the constraints, near one that drifted."""
        ...

    def wrap(self, y: Array) -> Array:
        """Return a row without whole turns, which `turns` then counts."""
        ...

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
        ...

    def is_misread(self, y: Array, turns: Array) -> bool:
        """Return whether derivatives took a row at a step's end for one with other turns."""
        ...


Judge = Callable[[float, Array, Array, float], bool]
"""Returns whether steps are shorter than accuracy asks for, from the time [s], a row, the Jacobian
there and the length of the last step [s]."""


class Dense:
    """Rows within a step; what interpolates them is computed when the first is asked for.

    DOP853 needs three more derivatives for it, which most steps are not asked for.
    """

    __slots__ = ("_interpolant", "_kept", "_kind")

    def __init__(self, solver: Any, is_explicit: bool) -> None:
        """Keep the step that a solver of SciPy has just taken.

        Args:
            solver: after the step.
            is_explicit: whether interpolating it takes further derivatives.
        """
        self._interpolant: Callable[[float], Array] | None = None
        self._kept: Any = None
        if not is_explicit:
            self._interpolant = solver.dense_output()
            return
        # As `copy` does it, in a quarter of the time. The next step overwrites the stages.
        self._kept = object.__new__(type(solver))
        vars(self._kept).update(vars(solver), K_extended=solver.K_extended.copy())

    def prepare(self) -> Callable[[float], Array]:
        """Return what interpolates the rows; once it is there, the step can be copied."""
        if self._interpolant is None:
            self._interpolant = self._kept.dense_output()
            self._kept = None
        return self._interpolant

    def __call__(self, time: float) -> Array:
        """Return the row at a time."""
        return np.asarray(self.prepare()(time))


class Segment(NamedTuple):
    """One accepted step.

    Attributes:
        start, end: times [s].
        turns: of the row with which it starts.
        dense: returns the row at a time, before constraints are restored.
        first: the row with which it starts.
        crosses: whether it is a step over a crossing, beside which rows are as they are.
    """

    start: float
    end: float
    turns: Array
    dense: Dense
    first: Array
    crosses: bool = False


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
        segments: the accepted steps.
        method: `DOP853` or `Radau`, the one in use.
        stiff_from: time from which on the equations were found to be stiff, None if they are not.
        crossings: finds those of the constraints; None if there is none.
        strictness: part of the tolerances that steps may use, from the next start on.
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
            is_stiff: judges a row now and then, None if only the steps themselves tell.
        """
        self.crossings = crossings
        self._ahead: tuple[float, float, float] | None = None
        """Time of the crossing before which a step has just ended, the step that leads over, and
        the shortest that may."""
        self.equations, self.method = equations, method
        self.segments: list[Segment] = []
        self.stiff_from: float | None = None
        self.strictness = 1.0
        self._stiff_steps = 0
        self._judge, self._next_look = is_stiff, _LOOKED_AT
        self._tried: tuple[int, float] | None = None
        self._duration, self._step = duration, step
        self._tolerances: dict[str, Any] = {"rtol": rtol, "atol": atol, "max_step": longest}
        self._scale = np.asarray(atol) / rtol
        self._solver: Any = None
        # Equations work in one set of memory; of threads that share a trajectory, one reads it.
        self._lock = threading.RLock()
        y = equations.wrap(y)
        self.points = [Point(0.0, y, equations.turns, self.equations.derivative(0.0, y))]

    def __getstate__(self) -> dict[str, Any]:
        # What was integrated can be copied; solvers, which could go on, hold functions.
        for segment in self.segments:
            with self._within(segment):
                segment.dense.prepare()
        left_out = "_solver", "_lock", "_judge", "crossings"
        return {name: value for name, value in self.__dict__.items() if name not in left_out}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.RLock()

    def _start_solver(self, time: float, y: Array, first_step: float | None = None) -> None:
        self._solver = self._solver_from(time, y, first_step)

    def _solver_from(self, time: float, y: Array, first_step: float | None = None) -> Any:
        from scipy.integrate import DOP853, Radau  # Only simulations need it.

        options = dict(self._tolerances, first_step=first_step)
        if self.strictness < 1.0:
            rtol, atol = options["rtol"], options["atol"]
            options["rtol"] = min(rtol, max(self.strictness * rtol, _FINEST))
            options["atol"] = atol * (options["rtol"] / rtol)
        if self._step is not None:
            # Tolerances that no step misses make every step as long as the longest allowed.
            length = min(self._step, self._duration)
            options = {"rtol": 1e3, "atol": 1e300, "first_step": length, "max_step": length}
        if self.method == "Radau":
            options["jac"] = self._jacobian
        kind = {"DOP853": DOP853, "Radau": Radau}[self.method]
        return kind(self.equations.derivative, time, y, self._duration, **options)

    def _jacobian(self, time: float, y: Array) -> Array:
        """Return the derivatives `(n, n)` of the rates, by differences.

        Friction that sets in within a small part of the speeds has slopes that great differences
        do not see: they are made finer until two of them agree.
        """
        rate = self.equations.derivative(time, y)
        jacobian = np.empty((y.size, y.size))

        def column(index: int, difference: float) -> Array:
            moved = y.copy()
            moved[index] += difference
            return (self.equations.derivative(time, moved) - rate) / (moved[index] - y[index])

        for index in range(y.size):
            size = abs(float(y[index]))
            difference = _DIFFERENCE * max(size, float(self._scale[index]))
            first = column(index, difference)
            jacobian[:, index] = coarse = first
            for _ in range(_FINEST_DIFFERENCES):
                difference *= _FINER
                if size + difference == size:
                    break
                fine = column(index, difference)
                if np.max(np.abs(fine - coarse)) <= _STRAIGHT * np.max(np.abs(fine)):
                    jacobian[:, index] = coarse
                    break
                coarse = fine
        return jacobian

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self.points[-1].time

    @property
    def is_running(self) -> bool:
        """Whether the end has not been reached."""
        return self._solver is None or self._solver.status == "running"

    def advance(self) -> str | None:
        """Take one step; return why it failed, None if it did not."""
        if self._solver is None:
            self._start_solver(0.0, self.points[0].y)
        equations, is_explicit = self.equations, self.method == "DOP853"
        while True:
            solver, crosses = self._solver, False
            try:
                if self.crossings is not None:
                    self.crossings.begin()
                message = solver.step()
                if self.crossings is not None and self._step is None and message is None:
                    self._solver, crosses = self._placed(solver, self.crossings)
                    solver = self._solver
            except CardanError:
                raise
            except (ValueError, ArithmeticError) as error:
                # SciPy's linear algebra refuses what is not finite.
                return f"loads or speeds lead beyond the greatest numbers ({error})"
            if solver.status == "failed":
                return str(message)
            is_stiff = is_explicit and self._step is None and self._is_stiff()
            before, time, turns = self.points[-1], float(solver.t), equations.turns
            y = equations.restored(time, solver.y)
            rate = self.equations.derivative(time, y)
            # The interpolant ends where the next step begins.
            solver.y = y
            if is_explicit:
                solver.f = rate
            dense = Dense(solver, is_explicit)
            segment = Segment(before.time, time, turns, dense, before.y, crosses)
            if crosses and self.crossings is not None:
                with self.crossings.stages_closed():
                    dense.prepare()
            equations.turns = self._followed(segment, time, y)
            length = time - before.time
            if self._step or not equations.is_misread(y, turns) or length < _SHORTEST_AGAIN * time:
                break
            equations.turns, self._ahead = turns, None
            self._start_solver(before.time, before.y, 0.5 * length)
        self.segments.append(segment)
        solver.y = wrapped = equations.wrap(y)
        self.points.append(Point(time, wrapped, equations.turns, rate))
        if not self.is_running:
            return None
        if is_stiff or (is_explicit and self._looks_stiff(time, wrapped, length)):
            if not is_stiff:
                self._tried = len(self.segments) + _TRIED, length
            self.stiff_from, self.method = time, "Radau"
            self._start_solver(time, wrapped)
        elif self._tried and len(self.segments) >= self._tried[0]:
            # Where slow motion asks for as many steps of lower order, they cost more.
            if length < self._tried[1]:
                self.stiff_from, self.method, self._stiff_steps = None, "DOP853", 0
                self._next_look = 2 * len(self.segments)
                self._start_solver(time, wrapped, length)
            self._tried = None
        return None

    def _placed(self, solver: Any, crossings: Crossings) -> tuple[Any, bool]:
        """Return the solver after a step that has no stage near a crossing.

        Args:
            solver: that has just taken a step.
            crossings: finds those on its way.

        Returns:
            The solver, and whether its step leads over one: another solver if the step had to be
            placed anew, perhaps to end where the next one leads over the crossing.
        """
        start, y, length = float(solver.t_old), solver.y_old, float(solver.t - solver.t_old)
        crossing: float | None
        if self._ahead is not None:
            crossing, length, shortest = self._ahead
        elif crossings.may_be_near:
            # Stages near a crossing have perhaps made it short, and it is seen far beyond its end.
            rate = self.points[-1].rate
            bend = (solver.y - y - length * rate) / length**2
            before = self.segments[-1] if self.segments else None
            length = max(length, before.end - before.start if before else 0.0)

            def ahead(time: float) -> Array:
                return y + (time - start) * (rate + (time - start) * bend)

            crossing = crossings.time(ahead, start, start + length)
            shortest = _SHORTEST * length
        else:
            return solver, False
        self._ahead = None
        lead = _FREE_OF_STAGES[self.method]
        for _ in range(_MOST_PLACED):
            if crossing is None or crossing <= start:
                break
            crosses = (crossing - start) / lead <= length * (1.0 + _WITHIN)
            if crosses:
                length = (crossing - start) / lead
            end = start + length if crosses else crossing - lead * length
            if end > self._duration:
                break
            with crossings.stages_closed():
                placed = self._solver_from(start, y, end - start)
                tolerances = placed.rtol, placed.atol
                if crosses and length <= shortest:
                    placed.rtol, placed.atol = 1e3, 1e300
                if placed.step() is not None:
                    break
                placed.rtol, placed.atol = tolerances
                dense = Dense(placed, self.method == "DOP853")
                dense.prepare()
            if not crosses:
                self._ahead = crossing, length, shortest
                return placed, False
            if float(placed.t - start) < 0.99 * length:
                length *= 0.5
                continue
            crossing = crossings.time(dense, start, float(placed.t))
            if crossing is None or not crossings.is_one(dense(crossing)):
                break
            if abs(crossing - start - lead * length) <= _WITHIN * length:
                return placed, True
        return solver, False

    def _looks_stiff(self, time: float, y: Array, length: float) -> bool:
        """Return whether a row is judged to be stiff, if it is time to."""
        if self._judge is None or self._step is not None or len(self.segments) < self._next_look:
            return False
        self._next_look = len(self.segments) * 3 // 2
        return self._judge(time, y, self._jacobian(time, y), length)

    def _is_stiff(self) -> bool:
        """Return whether stability, not accuracy, has limited the last steps of DOP853."""
        if not self._stiff_steps and len(self.segments) % _STIFF_EVERY:
            return False
        solver = self._solver
        stages = solver.K
        before = solver.y_old + solver.h_previous * (stages[:11].T @ solver.A[11, :11])
        way = float(np.linalg.norm(solver.y - before))
        if way > 0.0:
            rate = float(np.linalg.norm(stages[12] - stages[11])) / way
            self._stiff_steps = self._stiff_steps + 1 if solver.h_previous * rate > _STIFF else 0
        return self._stiff_steps >= _STIFF_STEPS

    def at(self, time: float) -> Point:
        """Return the point at a time within what was integrated."""
        if not self.segments:
            return self.points[0]
        ends = np.array([segment.end for segment in self.segments])
        return self.on(self.segments[min(int(np.searchsorted(ends, time)), len(ends) - 1)], time)

    def on(self, segment: Segment, time: float) -> Point:
        """Return the point at a time on one step."""
        with self._within(segment):
            y = self._restored(segment, time)
            turns = self._followed(segment, time, y)
            self.equations.turns = turns
            return Point(time, y, turns, self.equations.derivative(time, y))

    def row_on(self, segment: Segment, time: float) -> tuple[Array, Array]:
        """Return the row at a time on one step, and its turns."""
        with self._within(segment):
            y = self._restored(segment, time)
            return y, self._followed(segment, time, y)

    def _followed(self, segment: Segment, time: float, y: Array) -> Array:
        """Return the turns of a row at a time on a step."""
        if time <= segment.start:
            return segment.turns
        before = segment.first
        return self.equations.followed(
            segment.turns, (segment.start, time), (before, y), segment.dense
        )

    @contextmanager
    def _within(self, segment: Segment) -> Iterator[None]:
        """Let the equations count the turns of a step, in one thread at a time."""
        with self._lock:
            kept, self.equations.turns = self.equations.turns, segment.turns
            try:
                yield
            finally:
                self.equations.turns = kept

    def _restored(self, segment: Segment, time: float) -> Array:
        y = segment.dense(time)
        if segment.crosses:
            return self.equations.restored(time, y, crosses=True)
        return self.equations.restored(time, y)

    def points_at(self, times: Array) -> list[Point]:
        """Return the points at times within what was integrated."""
        if not self.segments:
            return [self.points[0]] * len(times)
        ends = np.array([segment.end for segment in self.segments])
        last = len(ends) - 1
        indices = np.minimum(np.searchsorted(ends, times), last).tolist()
        return [
            self.on(self.segments[index], time)
            for index, time in zip(indices, times.tolist(), strict=True)
        ]

    def restart(self, point: Point) -> None:
        """Go on from a point on the last step, from which on other forces act."""
        equations = self.equations
        self.segments[-1] = self.segments[-1]._replace(end=point.time)
        # Where other forces act, another crossing is ahead, or none.
        equations.turns, self._ahead = point.turns, None
        y = equations.wrap(point.y)
        rate = self.equations.derivative(point.time, y)
        self.points[-1] = Point(point.time, y, equations.turns, rate)
        if point.time < self._duration:
            self._start_solver(point.time, y)
        else:
            self._solver.status = "finished"

    def cut(self, point: Point) -> None:
        """End at a point on the last step."""
        self.points[-1] = point
        self.segments[-1] = self.segments[-1]._replace(end=point.time)
        self._solver.status = "finished"
