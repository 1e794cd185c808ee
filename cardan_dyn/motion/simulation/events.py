"""Events: conditions that are located while a simulation runs, and may end it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...core.elements.stepping import INSTANT
from ...kit.arrays import EPS, ROUNDED, Array
from ...kit.checks import described, flag, number
from ...kit.errors import ArgumentError
from ...kit.roots import zeros
from .forces import Named, State, number_at, state_function
from .integration import Integration

Reading = Callable[[list[float]], list[State]]
"""States at times."""

_DEGREE = 8
"""Degree of the polynomials that events are read off, each over a part of a step..."""
_NODES = np.polynomial.chebyshev.chebpts2(_DEGREE + 1)
_SERIES = np.linalg.inv(np.polynomial.chebyshev.chebvander(_NODES, _DEGREE)).T
"""...through the values at Chebyshev's nodes, of whose series these are the coefficients."""
_FALLEN = 1e-2
"""Part of all of them to which the second half has fallen where a polynomial is off by no more than
its sum: beside a kink it has not."""
_MOST_PARTS = 1024
"""Parts of a step that are looked at before the function is given up as faster than that, and those
that are halved because it is constant."""
_NEAR = 0.01
"""Part of what a function reads has moved so far that lies between two places at most, where the
function is constant."""


@dataclass(frozen=True, eq=False)
class Event:
    """A condition that is located where its function passes through zero.

    Zero at the start does not count, nor where the function touches zero and turns back. Parts of
    each step are halved until a polynomial through nine values of the function tells for certain,
    by its own error, how often it passes through zero: as finely as the function needs, not the
    motion. A function that changes still faster is told of in `Trajectory.notes`.

    Where it is constant while what it reads of the state moves, as switches and saturated functions
    are, nothing tells what is between: there it is looked at wherever what it reads has moved by a
    hundredth of its way so far, or of 1 rad or m if that is less. What passes zero and returns
    between such places may be missed, which the notes say. What falls to zero in a pulse between
    all places, but varies smoothly at these, is not seen; `simulate(step=)` narrows them.

    Attributes:
        function: of time, or of time, positions and speeds by joint names.
        terminal: whether the simulation ends there.
        direction: +1 where only rises through zero count, -1 for falls, 0 for both.
        name: how `Trajectory.events` calls it; the function's name if empty.
    """

    function: Callable[..., float]
    terminal: bool = False
    direction: int = 0
    name: str = ""


class Happened(NamedTuple):
    """An event that happened: its name, and when [s]."""

    name: str
    time: float


def watched(events: Any) -> list[Event]:
    """Return events as they are watched: checked, by name, of time, positions and speeds.

    Args:
        events: an `Event` or a function, or several; functions may have attributes `terminal` and
            `direction`.

    Raises:
        ArgumentError: something else.
    """
    if isinstance(events, Event) or callable(events):
        events = [events]
    if isinstance(events, np.ndarray) and not events.ndim:
        events = [events.item()]
    if not isinstance(events, Iterable):
        raise ArgumentError(f"events is {described(events)}, expected functions or Event(...)")
    result = []
    for index, item in enumerate(events):
        label = f"events[{index}]"
        if not isinstance(item, Event):
            if not callable(item):
                raise ArgumentError(f"{label} is {described(item)}, expected a function or Event")
            item = Event(
                item,
                bool(getattr(item, "terminal", False)),
                int(np.sign(number(f"{label}: direction", getattr(item, "direction", 0)))),
            )
        if number(f"{label}: direction", item.direction) not in (-1.0, 0.0, 1.0):
            raise ArgumentError(f"{label}: direction {described(item.direction)}; it is -1, 0 or 1")
        name = item.name or getattr(item.function, "__name__", label)
        function = state_function(label, item.function)
        result.append(Event(function, flag("terminal", item.terminal), item.direction, name))
    return result


class _Read(Named):
    """Positions or speeds of one state, of which is kept which were read, and between what."""

    def __init__(self, given: Named, ranges: dict[str, tuple[float, float]]) -> None:
        self._given, self._ranges = given, ranges

    def __getitem__(self, name: str) -> float:
        value = self._given[name]
        low, high = self._ranges.get(name, (value, value))
        self._ranges[name] = min(low, value), max(high, value)
        return value

    def __iter__(self) -> Iterator[str]:
        return iter(self._given)

    def __len__(self) -> int:
        return len(self._given)


class EventSearch:
    """Locates events, step after step.

    Attributes:
        happened: those that were found, in order of time.
        notes: of events that change faster than they were followed, or are constant between.
    """

    def __init__(self, events: list[Event], reading: Reading) -> None:
        """Begin at time 0.

        Args:
            events: to be located.
            reading: of the state at time 0.
        """
        self._tracks = [_Track(event, *reading([0.0])) for event in events]
        self.happened: list[Happened] = []
        self.notes: list[str] = []

    def step(self, start: float, end: float, reading: Reading) -> float | None:
        """Look for events within a step; return when a terminal one ends it, else None.

        Args:
            start: of the step [s].
            end: of the step [s].
            reading: of the states within it.
        """
        known: dict[float, State] = {}

        def states(times: list[float]) -> list[State]:
            if new := [time for time in times if time not in known]:
                known.update(zip(new, reading(new), strict=True))
            return [known[time] for time in times]

        found: list[tuple[float, Event]] = []
        for track in self._tracks:
            was_lost, was_constant = track.is_lost, track.is_constant
            found += [(time, track.event) for time in track.passes(start, end, states)]
            if track.is_lost and not was_lost:
                self.notes.append(
                    f"event {track.event.name!r} changes so fast from {start:.6g} to {end:.6g} s "
                    f"that {_MOST_PARTS} parts of that time do not tell how often it passes "
                    "through zero: from there on some of its times may be missing; give a "
                    "smoother function"
                )
            if track.is_constant and not was_constant:
                self.notes.append(
                    f"event {track.event.name!r} is constant between {start:.6g} and {end:.6g} s "
                    "while what it reads moves, as a switch or a saturated function is: passages "
                    "through zero and back that are closer than about a hundredth of that way may "
                    "be missing; give a function that passes through zero smoothly, such as "
                    "abs(position) - width, or shorter steps by step="
                )
        for time, event in sorted(found, key=lambda item: item[0]):
            self.happened.append(Happened(event.name, time))
            if event.terminal:
                return time
        return None

    @property
    def reason(self) -> str:
        """Why a simulation ends at the last event."""
        return f"event {self.happened[-1].name!r}"

    def follow(self, integration: Integration) -> str:
        """Look at the last step of an integration; cut it at a terminal event, and say which."""
        step, named = integration.steps[-1], integration.equations.named

        def reading(times: list[float]) -> list[State]:
            return [named(*integration.row_on(step, time)) for time in times]

        stopped = self.step(step.start, step.end, reading)
        if stopped is None:
            return ""
        integration.cut(integration.on(step, stopped))
        return self.reason


class _Track:
    """One event as it is followed from step to step.

    Attributes:
        event: the event.
        parts: number of equal parts in which the next step is looked at first.
        is_lost: whether parts were too many to tell how often it passes through zero.
        is_constant: whether it was constant where what it reads moved.
    """

    def __init__(self, event: Event, start: State) -> None:
        self.event, self.parts, self.is_lost, self.is_constant = event, 1, False, False
        self._ranges: tuple[dict[str, tuple[float, float]], ...] = {}, {}
        self._last, self._is_first = self._value(0.0, start), True

    def _value(self, time: float, state: State) -> float:
        position, speed = map(_Read, state, self._ranges)
        returned = self.event.function(time, position, speed)
        return number_at(f"event {self.event.name!r}", returned, time)

    def passes(self, start: float, end: float, states: Reading) -> list[float]:
        """Return when the function passes through zero within a step [s]."""

        def look(times: Array) -> Array:
            pairs = zip(times.tolist(), states(times.tolist()), strict=True)
            return np.array([self._value(*pair) for pair in pairs])

        times, values = self._seen(start, end, look, states)
        # Rounding alone decides on which side of zero it begins.
        if self._is_first and abs(self._last) <= ROUNDED * float(np.max(np.abs(values))):
            self._last = 0.0
        values[0], self._is_first, self._last = self._last, False, float(values[-1])
        # What touches zero at a place and turns back has not passed.
        told = values != 0.0
        told[-1] = True
        times, values = times[told], values[told]
        before, after = np.sign(values[:-1]), np.sign(values[1:])
        passes = (before != 0.0) & (before != after) & (before * self.event.direction <= 0.0)
        ends = (times[:-1][passes], times[1:][passes]), (values[:-1][passes], values[1:][passes])
        return zeros(lambda times, _: look(times), *ends).tolist()

    def _seen(
        self, start: float, end: float, look: Callable[[Array], Array], states: Reading
    ) -> tuple[Array, Array]:
        """Return times, ascending, and values of the function, which passes zero once between two.

        Or not at all, if they have one sign; but for rounding, and where it is lost.
        """
        low, high = _divided(start, end, self.parts)
        found, looked, halved, is_even, greatest = [], 0, 0, True, 0.0
        shortest = INSTANT * end
        while low.size:
            times = _places(low, high)
            values = look(times.ravel()).reshape(times.shape)
            greatest = max(greatest, float(np.max(np.abs(values))))
            is_known, dips = _settled(times, values, ROUNDED * greatest, shortest)
            constant = np.nonzero(is_known & _constant(values))[0]
            looked += len(low) - len(constant)
            moves = [self._moves(times[part], end, states) for part in constant]
            if any(moves):
                self.is_constant = True
                halved += sum(moves)
                is_known[constant[moves]] = halved > _MOST_PARTS
            self.is_lost |= looked > _MOST_PARTS and not np.all(is_known)
            if self.is_lost:
                # As far as nine places tell: what is finer could be noise without end.
                times = _places(*_divided(start, end, 1)).ravel()
                self.parts = 1
                return times, look(times)
            found += [(times[is_known].ravel(), values[is_known].ravel()), (dips, look(dips))]
            if is_even:
                # Another step may need no more than this.
                self.parts = len(low) if found[2:] else max(1, 3 * len(low) // 4)
                is_even = not np.any(is_known)
            low, high = low[~is_known], high[~is_known]
            middle = 0.5 * (low + high)
            low = np.column_stack([low, middle]).ravel()
            high = np.column_stack([middle, high]).ravel()
        times, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
        order = np.argsort(times, kind="stable")
        return times[order], values[order]

    def _moves(self, times: Array, end: float, states: Reading) -> bool:
        """Return whether what the function reads moves far between neighbouring times `(n,)`.

        Time alone moves where it reads nothing of the state, from 0 to the end of the step.
        """
        if not any(self._ranges):
            return bool(np.max(np.diff(times)) > _NEAR * end)
        rows = states(times.tolist())
        for kind, most in enumerate((1.0, np.inf)):
            for name, (low, high) in self._ranges[kind].items():
                # By less, smooth functions may be constant but for rounding as well.
                if high - low > np.sqrt(EPS) * max(1.0, -low, high):
                    steps = np.abs(np.diff([state[kind][name] for state in rows]))
                    if np.max(steps) > _NEAR * min(high - low, most):
                        return True
        return False


def _divided(start: float, end: float, count: int) -> tuple[Array, Array]:
    """Return the starts and ends `(count,)` of equal parts of a step."""
    edges = np.linspace(start, end, count + 1)
    return edges[:-1], edges[1:]


def _places(low: Array, high: Array) -> Array:
    """Return the times `(P, n)` at which parts of a step are looked at, their ends among them."""
    times = low[:, None] + 0.5 * (high - low)[:, None] * (1.0 + _NODES)
    times[:, -1] = high
    return times


def _constant(values: Array) -> Array:
    """Return which parts `(P, n)` have three equal values in a row, of which no series can tell.

    But for rounding; a smooth function has two, on both sides of where it turns back.
    """
    equal = np.abs(np.diff(values)) <= 2.0 * np.spacing(np.abs(values[:, 1:]))
    return np.asarray(np.any(equal[:, 1:] & equal[:, :-1], axis=1))


def _settled(times: Array, values: Array, rounding: float, shortest: float) -> tuple[Array, Array]:
    """Return which parts tell how often a function passes through zero, and more times for it.

    The last coefficients of the series tell by how much the polynomial may be off: where it turns
    back farther from zero than that, its zeros are those of the function. Where it does so between
    two places, on the other side of zero, it adds a time.

    Args:
        times: of parts `(P, n)`, see `_places` [s].
        values: of the function `(P, n)`.
        rounding: error of the values.
        shortest: part that is not divided [s].
    """
    series = values @ _SERIES
    sizes, lengths = np.abs(series), times[:, -1] - times[:, 0]
    slopes = 2.0 * (sizes @ np.arange(_DEGREE + 1)) / lengths
    off, noise = np.sum(sizes[:, -(_DEGREE // 2) :], axis=1), rounding + shortest * slopes
    varies = np.sum(sizes[:, 1:], axis=1)
    is_clear = sizes[:, 0] > varies + off
    is_known = is_clear | (lengths <= shortest)
    may_be = ~is_known & (off <= np.maximum(noise, _FALLEN * varies))
    more: list[float] = []
    for part in np.nonzero(may_be)[0].tolist():
        own, error = series[part], float(off[part])
        slope = np.polynomial.chebyshev.chebder(own)
        # Those that are complex tell where it almost turns back.
        turns = np.polynomial.chebyshev.chebroots(slope).real
        turns = np.sort(turns[np.abs(turns) < 1.0])
        heights = np.polynomial.chebyshev.chebval(turns, own)
        farthest = np.abs(np.concatenate([heights, values[part, [0, -1]]]))
        if error > noise[part] and np.min(farthest) <= 2.0 * error:
            continue
        is_known[part] = True
        after = np.searchsorted(_NODES, turns)
        beside = values[part, after - 1], values[part, np.minimum(after, _DEGREE)]
        turned = (heights * beside[0] < 0.0) & (heights * beside[1] < 0.0)
        more += (times[part, 0] + 0.5 * lengths[part] * (1.0 + turns[turned])).tolist()
    return is_known, np.array(more)
