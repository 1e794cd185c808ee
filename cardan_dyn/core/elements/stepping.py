"""Stepping: integrators step by step, and where within a step functions fall to zero.

Simulations of mechanisms, with events and with pins that strike walls, and those of two masses
across a play all take their steps here, and locate here what ends them. Explicit steps are those of
Dormand and Prince of order 8 as Hairer, Nørsett and Wanner give them (Solving Ordinary Differential
Equations I, sections II.4 to II.6), with SciPy's coefficients; implicit ones SciPy's Radau.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.errors import SimulationError
from ...kit.extremes import peak
from ...kit.roots import zero
from .. import compiled

Rate = Callable[[float, Array], Array]
"""Time derivative of a row."""
Watch = Callable[[float, Array], float]
"""Function of time and row that is positive as long as the equations hold."""

_LOOSE: dict[str, Any] = {"rtol": 1e3, "atol": 1e300}
"""Tolerances that no step misses."""
_TERMS = 8
"""Coefficients of a polynomial of degree 7, as which DOP853 interpolates."""
_SAFETY, _SHORTER, _LONGER = 0.9, 0.2, 10.0
"""Part of the length that the error allows, and how a step differs from the one before at most."""
_MISSED = 1.0 / 8.0
"""Power of the error that a step had too much, by which the next is shorter..."""
_STEADY = 0.6 / 8.0, 0.2 / 8.0
"""...and those of its error, and of that before, otherwise: where errors swing, as they do in every
turn, fewer steps are missed."""
_LEAST_ERROR = 1e-4
"""Error of the step before that is counted at least."""
_INSTANTS = 10.0
"""Distances between numbers near a time that make the shortest step."""
_TO_GAP = np.array([0.5, 9.0 / 16.0, 0.0, -1.0 / 16.0])
"""Chebyshev series of 3 s² - 2 s³ over a step, s from 0 to 1."""
_PLACES = 5
"""Parts of a step at whose ends functions are looked at."""
_LOW = 0.3
"""Least of three values, as a fraction of the excess of the others, up to which it is looked for
negative ones beside it."""
_BESIDE = 1e-6
"""Part of an interval at which it is looked whether a function rises or falls at its end."""
INSTANT = 16.0 * EPS
"""Duration as a fraction of the time that cannot be divided into places."""
_MOST_STEPS = 1_000_000
"""Of one passage: some minutes."""


class Traced(NamedTuple):
    """A program that gives rates of rows.

    Attributes:
        given: handle of the program, and arrays for its inputs, of which the first are a row, and
            for its outputs, of which the last but one is 1 or less if the rates before it suit.
        counted: is told how many rates it gave.
    """

    given: tuple[Any, Array, Array]
    counted: Callable[[int], None]


class _Tableau(NamedTuple):
    """Coefficients of DOP853, whose S stages a step takes, the first at its start.

    Attributes:
        places: of the stages, as fractions of the step.
        rows: weights `(S, S)` of rates in the row of each stage.
        last: weights `(S,)` of rates in the row at the end.
        errors: weights `(2, S)` of rates in the errors of order 5 and 3.
        more_places: of the further stages that rows within the step need.
        more_rows: weights of all rates before, that at the end among them, in their rows.
        series: weights `(K, S + 4)` of all rates in each coefficient of a Chebyshev series.
    """

    places: list[float]
    rows: Array
    last: Array
    errors: Array
    more_places: list[float]
    more_rows: list[Array]
    series: Array


@cache
def _tableau() -> _Tableau:
    from scipy.integrate import DOP853  # Only simulations need it.

    stages, every = len(DOP853.B), DOP853.D.shape[1]
    # A row within a step differs from the first by the length times a polynomial in s and 1 - s,
    # each coefficient of which is a sum of rates (Hairer, Nørsett, Wanner: equation II.6.12).
    gap, first, last = np.zeros((3, every))
    gap[:stages], first[0], last[stages] = DOP853.B, 1.0, 1.0
    factors = np.array([gap, first - gap, 2.0 * gap - first - last, *DOP853.D])
    nodes = np.polynomial.chebyshev.chebpts1(_TERMS)
    alternating = np.array([[0.5 + 0.5 * x, 0.5 - 0.5 * x] * _TERMS for x in nodes])
    powers = np.cumprod(alternating[:, : len(factors)], axis=1)
    chebyshev = np.polynomial.chebyshev.chebvander(nodes, _TERMS - 1)
    more = range(stages + 1, every)
    return _Tableau(
        DOP853.C[:stages].tolist(),
        DOP853.A[:stages, :stages],
        DOP853.B,
        np.array([DOP853.E5[:stages], DOP853.E3[:stages]]),
        DOP853.C_EXTRA.tolist(),
        [row[:count] for row, count in zip(DOP853.A_EXTRA, more, strict=True)],
        np.linalg.solve(chebyshev, powers @ factors),
    )


@cache
def _table() -> Array:
    """Return the tableau of `compiled.kernel.explicit_step`."""
    tableau = _tableau()
    return np.vstack([tableau.rows, tableau.last, tableau.errors, tableau.places])


def _at(part: float) -> Array:
    """Return Chebyshev's polynomials `(K,)` at a fraction of a step."""
    place = 2.0 * part - 1.0
    values = [1.0, place]
    for _ in range(_TERMS - 2):
        values.append(2.0 * place * values[-1] - values[-2])
    return np.array(values)


class Step:
    """An accepted step; rows within it take some more derivatives of DOP853, if they are read.

    Attributes:
        start, end: times [s]; it may be made to end sooner.
        first, last: rows at its start, and at its own end.
        rate: derivative of the last row, None until it is known.
        turns: of the first row, where equations count some.
        crosses: whether it leads over a crossing of assembly modes, beside which rows are as they
            are.
    """

    __slots__ = (
        *("start", "first", "end", "last", "rate", "turns", "crosses"),
        *("_length", "_own", "_implicit", "_derivative", "_rates", "_series"),
    )

    def __init__(self, start: float, first: Array, end: float, last: Array) -> None:
        self.start, self.first, self.end, self.last = start, first, end, last
        self.rate: Array | None = None
        self.turns: Any = None
        self.crosses = False
        self._length = end - start
        self._own: Any = last
        self._implicit: Callable[[float], Array] | None = None
        self._derivative: Rate | None = None
        self._rates: Any = None
        self._series: Any = None

    def __getstate__(self) -> dict[str, Any]:
        # What was integrated can be copied; derivatives are functions of what cannot.
        self.prepare()
        return {name: getattr(self, name) for name in self.__slots__}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            setattr(self, name, value)

    def prepare(self) -> None:
        """Take the further derivatives that rows within a step of DOP853 need."""
        if self._derivative is None:
            return
        derivative, tableau, length, rates = self._derivative, _tableau(), self._length, self._rates
        known, own = len(tableau.last), self._own
        if own is not self.last:
            rates[known] = derivative(self.start + length, own)
        else:
            if self.rate is None:
                self.rate = derivative(self.start + length, own)
            rates[known] = self.rate
        for place, weights in zip(tableau.more_places, tableau.more_rows, strict=True):
            known += 1
            stage = self.first + length * weights.dot(rates[:known])
            rates[known] = derivative(self.start + place * length, stage)
        series = length * tableau.series.dot(rates)
        # The row at the end may have been changed: rows lead there along 3 s² - 2 s³.
        gap = self.last - self.first - np.sum(series, axis=0)
        series[:4] += np.outer(_TO_GAP, gap)
        self._series = series
        self._own = self._rates = self._derivative = None

    def dense(self, time: float) -> Array:
        """Return the row at a time; at its own end the last one."""
        if self._implicit is not None:
            return np.asarray(self._implicit(time))
        if self._derivative is not None:
            self.prepare()
        return np.asarray(self.first + _at((time - self.start) / self._length) @ self._series)


class Stepper:
    """DOP853, one step at a time, whose rows may be changed in between."""

    def __init__(
        self,
        derivative: Rate,
        end: float,
        *,
        rtol: float,
        atol: Array | float,
        longest: float = np.inf,
        length: float | None = None,
        traced: Callable[[], Traced | None] = lambda: None,
    ) -> None:
        """Make it.

        Args:
            derivative: of a row.
            end: of time, may be infinite [s].
            rtol: relative tolerance of a step.
            atol: absolute tolerances, like a row.
            longest: step that is allowed [s].
            length: of the first step; None if nothing is known of it [s].
            traced: returns a program that gives the derivative sooner where it suits, if any.
        """
        self._derivative, self._end, self._length = derivative, end, length
        self._traced = traced
        self._rtol, self._atol, self._longest = rtol, atol, longest
        self._tableau = tableau = _tableau()
        self._every = tableau.series.shape[1]
        # Weights times the length of a step, of each stage but the first, behind that of the row.
        stages = len(tableau.places)
        self._weights = np.ones((stages, 1 + stages))
        self._stages = [
            (index, place, self._weights[index, : 1 + index])
            for index, place in enumerate(tableau.places)
        ][1:]
        self._allowed = np.array(atol, dtype=float).ravel()
        self._error: float | None = None

    def take(self, time: float, row: Array, rate: Array) -> Step | str:
        """Return a step, or why it failed.

        Args:
            time: at its start [s].
            row: there.
            rate: its derivative.
        """
        last = row
        length = self._first_length(time, row, rate) if self._length is None else self._length
        shortest = _INSTANTS * (math.nextafter(time, math.inf) - time)
        length, was_missed = max(min(length, self._longest), shortest), False
        while True:
            if not length >= shortest:
                return "the step that accuracy asks for is shorter than numbers are apart"
            end = min(time + length, self._end)
            length = end - time
            weighed = np.empty((1 + self._every, row.size))
            rates = weighed[1:]
            weighed[0], rates[0] = row, rate
            last, fifth, third = self._taken(time, length, weighed)
            error = 0.0
            if fifth or third:
                error = length * fifth / math.sqrt((fifth + 0.01 * third) * row.size)
            if third == math.inf:  # Beyond all numbers as well, and not zero.
                error = math.inf
            if error < 1.0:
                break
            # One that leads beyond all numbers says nothing of its length.
            factor = _SAFETY / error**_MISSED if error < math.inf else 0.0
            length, was_missed = length * max(_SHORTER, factor), True
        factor = min(self._factor(error), 1.0 if was_missed else _LONGER)
        self._length, self._error = length * factor, max(error, _LEAST_ERROR)
        step = Step(time, row, end, last)
        step._derivative, step._rates = self._derivative, rates
        return step

    def _taken(self, time: float, length: float, weighed: Array) -> tuple[Array, float, float]:
        """Return the row at the end, and the sums of squares of two errors.

        Errors of order 5 and 3, as fractions of what is allowed.

        Args:
            time: at the start [s].
            length: of the step [s].
            weighed: row at the start, its rate, and rates `(1 + K, n)` of all other stages, which
                are written.
        """
        # Twin: `explicit_step` of compiled/stepping.c.
        derivative, tableau, row, rates = self._derivative, self._tableau, weighed[0], weighed[1:]
        taken = len(tableau.last)
        if compiled.kernel is not None:
            last, stages = np.empty_like(row), np.empty((taken, row.size))
            given = time, length, weighed, stages, [*stages], self._allowed, self._rtol, last
            traced = self._traced()
            by = traced and traced.given
            *sums, runs = compiled.kernel.explicit_step(_table(), derivative, *given, by)
            if traced is not None:
                traced.counted(runs)
            return last, *sums
        np.multiply(tableau.rows, length, out=self._weights[:, 1:])
        for index, place, weights in self._stages:
            stage = weights.dot(weighed[: 1 + index])
            rates[index] = derivative(time + place * length, stage)
        last = row + length * tableau.last.dot(rates[:taken])
        errors = tableau.errors.dot(rates[:taken])
        errors /= self._atol + self._rtol * np.maximum(np.abs(row), np.abs(last))
        return last, float(errors[0].dot(errors[0])), float(errors[1].dot(errors[1]))

    def _factor(self, error: float) -> float:
        """Return by how much the next step is longer than one of an error."""
        if not error:
            return _LONGER
        if self._error is None:
            return _SAFETY / error**_MISSED
        now, before = _STEADY
        return _SAFETY * self._error**before / error**now

    def _first_length(self, time: float, row: Array, rate: Array) -> float:
        """Return the length of a first step by what the rate changes over a short one."""
        longest = min(self._longest, self._end - time)
        scale = self._atol + self._rtol * np.abs(row)
        size, slope = _mean(row / scale), _mean(rate / scale)
        short = 1e-6 if size < 1e-5 or slope < 1e-5 else 0.01 * size / slope
        short = min(short, longest)
        after = self._derivative(time + short, row + short * rate)
        bend = _mean((after - rate) / scale) / short
        if max(slope, bend) <= 1e-15:
            length = max(1e-6, 1e-3 * short)
        else:
            length = (0.01 / max(slope, bend)) ** _MISSED
        return min(100.0 * short, length, longest)


def _mean(values: Array) -> float:
    """Return the root of the mean square of values."""
    return float(np.linalg.norm(values)) / math.sqrt(values.size)


class ImplicitStepper:
    """SciPy's Radau, one step at a time, whose rows may be changed in between."""

    def __init__(
        self,
        derivative: Rate,
        end: float,
        *,
        rtol: float,
        atol: Array | float,
        jacobian: Rate,
        longest: float = np.inf,
        length: float | None = None,
    ) -> None:
        """Make it.

        Args:
            derivative: of a row.
            end: of time, may be infinite [s].
            rtol: relative tolerance of a step.
            atol: absolute tolerances, like a row.
            jacobian: derivatives of rates.
            longest: step that is allowed [s].
            length: of the first step; None if nothing is known of it [s].
        """
        self._derivative, self._end, self._length = derivative, end, length
        self._options = {"rtol": rtol, "atol": atol, "max_step": longest, "jac": jacobian}
        self._solver: Any = None

    def take(self, time: float, row: Array, rate: Array) -> Step | str:
        """Return a step, or why it failed, see `Stepper.take`."""
        solver = self._solver
        if solver is None:
            solver = self._solver = self._begun(time, row, rate)
        elif solver.y is not row:
            solver.y = row
        message = solver.step()
        if solver.status == "failed":
            return str(message)
        step = Step(time, row, float(solver.t), solver.y)
        step._implicit = solver.dense_output()
        return step

    def _begun(self, time: float, row: Array, rate: Array) -> Any:
        """Return a solver at a row whose derivative is known."""
        from scipy.integrate import Radau  # Only stiff simulations need it.

        evaluated = self._derivative

        def derivative(at: float, stage: Array) -> Array:
            return rate if stage is row else evaluated(at, stage)

        length = None if self._length is None else min(self._length, self._end - time)
        return Radau(derivative, time, row, self._end, first_step=length, **self._options)


class Passage(NamedTuple):
    """What was integrated.

    Attributes:
        time: of its end [s].
        state: there.
        event: index of the function that fell to zero there, None if time was up.
        steps: that were taken.
    """

    time: float
    state: Array
    event: int | None
    steps: list[Step]


def advance(
    rate: Rate,
    time: float,
    state: Array,
    end: float,
    watches: Sequence[Watch],
    *,
    rtol: float,
    atol: Array,
    longest: float = np.inf,
) -> Passage:
    """Integrate by DOP853 until a function falls to zero.

    A function may start at zero, or below by rounding: it has fallen there unless it rises.

    Args:
        rate: time derivative of the state.
        time: of the start [s].
        state: there.
        end: of time, may be infinite [s].
        watches: functions, positive as long as the equations hold.
        rtol: relative tolerance of a step.
        atol: absolute tolerances, like the state.
        longest: step that is allowed [s].

    Raises:
        SimulationError: no step is short enough, or there are too many.
    """
    steps: list[Step] = []
    if not end - time > INSTANT * abs(time):
        return Passage(end, state, None, steps)
    stepper = Stepper(rate, end, rtol=rtol, atol=atol, longest=longest)
    slope = rate(time, state)
    while time < end:
        step = stepper.take(time, state, slope)
        if isinstance(step, str) or len(steps) >= _MOST_STEPS:
            reason = step if isinstance(step, str) else f"{_MOST_STEPS} steps did not reach its end"
            raise SimulationError(
                f"contact could not be integrated beyond {time:.6g} s ({reason}); take a "
                "softer contact or less damping",
                time=time,
            )
        steps.append(step)
        falls = _falls(rate, step, watches)
        first = min(falls, default=np.inf)
        if first < np.inf:
            step.end = first
            return Passage(first, on_step(rate, step, first), falls.index(first), steps)
        time, state = step.end, step.last
        if step.rate is None:
            step.rate = rate(time, state)
        slope = step.rate
    return Passage(time, state, None, steps)


def on_step(rate: Rate, step: Step, time: float) -> Array:
    """Return the state at a time within a step, by a shorter one: better than its interpolant."""
    at, state = step.start, step.first
    if time <= at:
        return state
    stepper = Stepper(rate, time, length=time - at, **_LOOSE)
    while at < time:
        part = stepper.take(at, state, rate(at, state))
        if isinstance(part, str):
            break
        at, state = part.end, part.last
    return state


def _falls(rate: Rate, step: Step, watches: Sequence[Watch]) -> list[float]:
    """Return when functions fall within a step, to rounding; inf for those that do not."""
    times = np.linspace(step.start, step.end, _PLACES + 1).tolist()
    dense = cache(step.dense)
    return [
        first_fall(
            lambda time, watch=watch: watch(time, dense(time)),  # type: ignore[misc]
            times,
            lambda time, watch=watch: watch(time, on_step(rate, step, time)),  # type: ignore[misc]
        )
        for watch in watches
    ]


def first_fall(
    value: Callable[[float], float],
    times: list[float],
    exact: Callable[[float], float] | None = None,
) -> float:
    """Return when a function falls through zero for the first time; inf if it does not.

    One that starts at zero or below has fallen there, unless it rises first.

    Args:
        value: the function; a least value between two times is looked for where it is small.
        times: ascending.
        exact: the same to rounding, if it takes longer.
    """
    exact = value if exact is None else exact
    values = [value(time) for time in times]
    last = len(times) - 1
    for k in range(last + 1):
        if k and values[k] <= 0.0 and (values[k - 1] > 0.0 or values[k] < values[0]):
            return zero(exact, times[k - 1], times[k])
        around = [values[j] for j in (k - 1, k + 1) if 0 <= j <= last]
        if not 0.0 < values[k] <= min(around):
            continue
        low, high = times[max(k - 1, 0)], times[min(k + 1, last)]
        if 0 < k < last:
            if values[k] > _LOW * (max(around) - values[k]):
                continue
        elif value(times[k] + _BESIDE * (high - low) * (1.0 if k == 0 else -1.0)) >= values[k]:
            continue  # The least value is that of the step before or after it.
        at, negative = peak(lambda time: -value(time), low, high)
        if negative >= 0.0:
            return zero(exact, low if k else times[0], at)
    return np.inf
