"""Stepping: SciPy's integrators step by step, and where within a step functions fall to zero.

Simulations of mechanisms, with events and with pins that strike walls, and those of two masses
across a play all take their steps here, and locate here what ends them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import SimulationError

Rate = Callable[[float, Array], Array]
"""Time derivative of a row."""
Watch = Callable[[float, Array], float]
"""Function of time and row that is positive as long as the equations hold."""

_LOOSE: dict[str, Any] = {"rtol": 1e3, "atol": 1e300}
"""Tolerances that no step misses."""
_MOST_STAGES = 32
"""Stages that a step and its interpolant take at most together."""
_TERMS = 8
"""Coefficients of a polynomial of degree 7, as which DOP853 interpolates."""
_ELSEWHERE = 0.3
"""Part of a step at which it is looked whether that is one."""
_TO_GAP = np.array([0.5, 9.0 / 16.0, 0.0, -1.0 / 16.0])
"""Chebyshev series of 3 s² - 2 s³ over a step, s from 0 to 1."""
_PLACES = 5
"""Parts of a step at whose ends functions are looked at."""
_LOW = 0.3
"""Least of three values, as a fraction of the excess of the others, up to which it is looked for
negative ones beside it."""
_BESIDE = 1e-6
"""Part of an interval at which it is looked whether a function rises or falls at its end."""
_HALVINGS = 40
"""Of an interval, at which a function that starts at zero is looked at before it has fallen."""
_INSTANT = 16.0 * np.finfo(float).eps
"""Duration as a fraction of the time that cannot be divided into places."""
_MOST_STEPS = 1_000_000
"""Of one passage: some minutes."""


class _Interpolant(NamedTuple):
    """What rates at the S stages of a step of DOP853 mean for rows within it.

    Attributes:
        taken: number of stages that the step itself takes after the one at its start.
        places: of the further stages that it needs, as fractions of the step.
        rows: weights `(S,)` of rates in the row of each further stage.
        series: weights `(K, S)` in each coefficient of a Chebyshev series over the step.
    """

    taken: int
    places: list[float]
    rows: list[Array]
    series: Array


@cache
def _interpolant() -> _Interpolant:
    """Return SciPy's, read off a step of length 1 whose rates are unit vectors."""
    from scipy.integrate import DOP853  # Only simulations need it.

    calls: list[tuple[float, Array]] = []

    def unit(time: float, row: Array) -> Array:
        calls.append((time, row))
        return np.eye(1, _MOST_STAGES, len(calls) - 1)[0]

    solver = DOP853(unit, 0.0, np.zeros(_MOST_STAGES), 1.0, first_step=1.0, **_LOOSE)
    solver.step()
    taken, dense = len(calls) - 1, solver.dense_output()
    count = len(calls)
    nodes = np.polynomial.chebyshev.chebpts1(_TERMS)
    weights = np.array([dense(0.5 * (1.0 + node))[:count] for node in nodes])
    series = np.linalg.solve(np.polynomial.chebyshev.chebvander(nodes, _TERMS - 1), weights)
    if not np.allclose(_at(_ELSEWHERE) @ series, dense(_ELSEWHERE)[:count], rtol=0.0, atol=1e-13):
        raise SimulationError("this version of SciPy interpolates steps of DOP853 in another way")
    more = calls[taken + 1 :]
    return _Interpolant(taken, [time for time, _ in more], [row[:count] for _, row in more], series)


def _at(part: float) -> Array:
    """Return Chebyshev's polynomials `(K,)` at a fraction of a step."""
    place = 2.0 * part - 1.0
    values = [1.0, place]
    for _ in range(_TERMS - 2):
        values.append(2.0 * place * values[-1] - values[-2])
    return np.array(values)


class Step:
    """An accepted step; rows within it take three more derivatives of DOP853, if they are read.

    Attributes:
        start, end: times [s]; it may be made to end sooner.
        first, last: rows at its start, and at its own end.
        rate: derivative of the last row.
        turns: of the first row, where equations count some.
        crosses: whether it leads over a crossing of assembly modes, beside which rows are as they
            are.
    """

    __slots__ = (
        *("start", "first", "end", "last", "rate", "turns", "crosses"),
        *("_length", "_implicit", "_derivative", "_rates", "_series"),
    )

    def __init__(self, start: float, first: Array, end: float, last: Array, rate: Array) -> None:
        self.start, self.first, self.end, self.last, self.rate = start, first, end, last, rate
        self.turns: Any = None
        self.crosses = False
        self._length = end - start
        self._implicit: Callable[[float], Array] | None = None
        self._derivative: Rate | None = None
        self._rates: list[Array] = []
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
        interpolant, length, rates = _interpolant(), self._length, self._rates
        for place, row in zip(interpolant.places, interpolant.rows, strict=True):
            stage = self.first + length * (row[: len(rates)] @ np.array(rates))
            rates.append(self._derivative(self.start + place * length, stage))
        series = length * (interpolant.series @ np.array(rates))
        # The row at the end may have been changed: rows lead there along 3 s² - 2 s³.
        gap = self.last - self.first - np.sum(series, axis=0)
        series[:4] += np.outer(_TO_GAP, gap)
        self._series, self._rates, self._derivative = series, [], None

    def dense(self, time: float) -> Array:
        """Return the row at a time; at its own end the last one."""
        if self._implicit is not None:
            return np.asarray(self._implicit(time))
        if self._derivative is not None:
            self.prepare()
        return np.asarray(self.first + _at((time - self.start) / self._length) @ self._series)


class Stepper:
    """DOP853 or Radau of SciPy, one step at a time, whose rows may be changed in between.

    A solver of SciPy interpolates its last step alone, from stages that the next one overwrites:
    for DOP853 they are kept here as its function is called.
    """

    def __init__(
        self,
        derivative: Rate,
        end: float,
        *,
        method: str = "DOP853",
        rtol: float,
        atol: Array | float,
        longest: float = np.inf,
        jacobian: Rate | None = None,
        length: float | None = None,
    ) -> None:
        """Make it.

        Args:
            derivative: of a row.
            end: of time, may be infinite [s].
            method: `DOP853` or `Radau`.
            rtol: relative tolerance of a step.
            atol: absolute tolerances, like a row.
            longest: step that is allowed [s].
            jacobian: derivatives of rates, for `Radau`.
            length: of the first step; None if nothing is known of it [s].
        """
        import scipy.integrate  # Only simulations need it.

        self._kind = getattr(scipy.integrate, method)
        self.is_explicit = method == "DOP853"
        self._derivative, self._end, self._length = derivative, end, length
        self._options: dict[str, Any] = {"rtol": rtol, "atol": atol, "max_step": longest}
        if not self.is_explicit:
            self._options["jac"] = jacobian
        self._solver: Any = None
        self._stages: list[tuple[Array, Array]] = []
        self._taken = _interpolant().taken if self.is_explicit else 0

    def take(self, time: float, row: Array, rate: Array) -> Step | str:
        """Return a step, or why it failed.

        Args:
            time: at its start [s].
            row: there.
            rate: its derivative.
        """
        stages, solver = self._stages, self._solver
        stages.clear()
        if solver is None:
            solver = self._solver = self._begun(time, row, rate)
        elif solver.y is not row:
            solver.y = row
        message = solver.step()
        if solver.status == "failed":
            return str(message)
        step = Step(time, row, float(solver.t), solver.y, stages[-1][1])
        if self.is_explicit:
            step._derivative = self._derivative
            step._rates = [rate] + [found for _, found in stages[-self._taken :]]
        else:
            step._implicit = solver.dense_output()
        return step

    def _begun(self, time: float, row: Array, rate: Array) -> Any:
        """Return a solver at a row whose derivative is known."""
        evaluated, keep = self._derivative, self._stages.append

        def derivative(at: float, stage: Array) -> Array:
            found = rate if stage is row else evaluated(at, stage)
            keep((stage, found))
            return found

        length = None if self._length is None else min(self._length, self._end - time)
        return self._kind(derivative, time, row, self._end, first_step=length, **self._options)

    def decay(self) -> float:
        """Return the rate of decay that the last stages of a step saw [1/s]; 0 if they coincide."""
        (before, rate_before), (last, rate) = self._stages[-2:]
        way = float(np.linalg.norm(last - before))
        return float(np.linalg.norm(rate - rate_before)) / way if way > 0.0 else 0.0


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
    if not end - time > _INSTANT * abs(time):
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
        time, state, slope = step.end, step.last, step.rate
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
    from scipy.optimize import minimize_scalar  # Only simulations need it.

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
        least = minimize_scalar(value, bounds=(low, high), method="bounded")
        if least.fun <= 0.0:
            return zero(exact, low if k else times[0], float(least.x))
    return np.inf


def zero(value: Callable[[float], float], low: float, high: float) -> float:
    """Return when a function falls to zero between two times, to rounding; `low` if it never rose.

    Args:
        value: positive at `low`, or soon after it; not positive at `high`, but for rounding.
        low: [s].
        high: [s].
    """
    from scipy.optimize import brentq  # Only simulations need it.

    if value(low) <= 0.0:
        # It may have risen for less than the time between them.
        nearer = (low + (high - low) * 0.5**k for k in range(1, _HALVINGS))
        risen = next((time for time in nearer if value(time) > 0.0), None)
        if risen is None:
            return low
        low = risen
    if value(high) > 0.0:
        return high
    return float(brentq(value, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps))
