"""Located: equations integrated up to where one of several functions falls to zero, to rounding."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import SimulationError

Rate = Callable[[float, Array], Array]
"""Time derivative of a state."""
Watch = Callable[[float, Array], float]
"""Function of time and state that is positive as long as the equations hold."""

_PLACES = 5
"""Parts of a step at whose ends functions are looked at: what falls and rises within one is
missed."""
_INSTANT = 16.0 * np.finfo(float).eps
"""Duration as a fraction of the time that cannot be divided into places."""
_HALVINGS = 40
"""Of a place, at which a function that starts at zero is looked at before it has fallen there."""
_MOST_STEPS = 1_000_000
"""Of one passage: some minutes."""


class Step(NamedTuple):
    """A step of a passage.

    Attributes:
        start, end: times [s].
        state: at its start.
        dense: returns the state at a time within it.
    """

    start: float
    end: float
    state: Array
    dense: Callable[[float], Array]


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
    from scipy.integrate import DOP853  # Only simulations need it.

    steps: list[Step] = []
    if not end - time > _INSTANT * abs(time):
        return Passage(end, state, None, steps)
    search = _Search(rate, watches, [watch(time, state) for watch in watches])
    solver = DOP853(rate, time, state, end, rtol=rtol, atol=atol, max_step=longest)
    while solver.status == "running":
        before = np.array(solver.y)
        message = solver.step()
        if solver.status == "failed" or len(steps) >= _MOST_STEPS:
            reason = message or f"{_MOST_STEPS} steps did not lead to its end"
            raise SimulationError(
                f"contact could not be integrated beyond {solver.t:.6g} s ({reason}); take a "
                "softer contact or less damping",
                time=float(solver.t),
            )
        step = Step(float(solver.t_old), float(solver.t), before, solver.dense_output())
        found = search.within(step, np.array(solver.y))
        if found is not None:
            steps.append(step._replace(end=found[0]))
            return Passage(found[0], on_step(rate, step, found[0]), found[1], steps)
        steps.append(step)
    return Passage(float(solver.t), np.array(solver.y), None, steps)


class _Search:
    """Looks for the first function that falls to zero, step after step."""

    def __init__(self, rate: Rate, watches: Sequence[Watch], begun: list[float]) -> None:
        """Begin with the values of the functions at the start."""
        self._rate, self._watches, self._begun = rate, watches, begun
        self._has_risen = [value > 0.0 for value in begun]

    def within(self, step: Step, last: Array) -> tuple[float, int] | None:
        """Return when and which function falls within a step, None if none does.

        Args:
            step: the step.
            last: state at its end.
        """
        times = np.linspace(step.start, step.end, _PLACES + 1).tolist()
        for low, high in pairwise(times):
            there = last if high == step.end else step.dense(high)
            fallen = []
            for k, watch in enumerate(self._watches):
                value = watch(high, there)
                if value <= 0.0 and (self._has_risen[k] or value < self._begun[k]):
                    fallen.append(k)
                self._has_risen[k] |= value > 0.0
            if fallen:
                return min(
                    (_fall(self._rate, step, self._watches[k], low, high), k) for k in fallen
                )
        return None


def on_step(rate: Rate, step: Step, time: float) -> Array:
    """Return the state at a time within a step, by a shorter one: better than its interpolant."""
    from scipy.integrate import DOP853

    if time <= step.start:
        return step.state
    options: dict[str, Any] = {"rtol": 1e3, "atol": 1e300, "first_step": time - step.start}
    solver = DOP853(rate, step.start, step.state, time, **options)
    while solver.status == "running":
        solver.step()
    return np.array(solver.y)


def _fall(rate: Rate, step: Step, watch: Watch, low: float, high: float) -> float:
    """Return when a function falls to zero between two places of a step; `low` if it never rose."""
    from scipy.optimize import brentq

    def value(time: float) -> float:
        return watch(time, on_step(rate, step, time))

    if value(low) <= 0.0:
        # It may have risen for less than a place.
        nearer = (low + (high - low) * 0.5**k for k in range(1, _HALVINGS))
        risen = next((time for time in nearer if value(time) > 0.0), None)
        if risen is None:
            return low
        low = risen
    if value(high) > 0.0:  # Its interpolant alone has fallen, by rounding.
        return high
    return float(brentq(value, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps))
