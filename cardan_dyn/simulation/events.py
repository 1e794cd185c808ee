"""Events: conditions that are located while a simulation runs, and may end it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..checks import described, flag, number
from ..elements.stepping import zero
from ..errors import ArgumentError
from .forces import Named, StateFunction, state_function
from .integration import Integration

Reading = Callable[[float], tuple[Named, Named]]
"""Positions and speeds by name at a time."""

_INNER = 4
"""Places within a step at which events are looked at: two zeros of one between them are missed."""
_BEGUN = 1e-12
"""Value of an event at the start, as a fraction of its greatest in the first step, that counts as
zero: rounding alone decides on which side of zero it begins."""


@dataclass(frozen=True, eq=False)
class Event:
    """A condition that is located where its function passes through zero.

    Zero at the start does not count. Each step of the method is looked at in five places: what
    passes through zero and back between two of them is missed; `simulate(step=)` narrows them.

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


class Watched(NamedTuple):
    """An event as it is watched.

    Attributes:
        name: of the event.
        function: of time, positions and speeds.
        terminal, direction: see `Event`.
    """

    name: str
    function: StateFunction
    terminal: bool
    direction: int

    def value(self, time: float, reading: Reading) -> float:
        """Return the value of the function at a time.

        Raises:
            ArgumentError: it is no finite number.
        """
        result = self.function(time, *reading(time))
        try:
            value = float(result)
        except (TypeError, ValueError):
            value = np.nan
        if not np.isfinite(value):
            raise ArgumentError(
                f"event {self.name!r} returned {described(result)} at time {time:g} s, expected a "
                "finite number"
            )
        return value


def watched(events: Any) -> list[Watched]:
    """Return events as they are watched.

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
        result.append(Watched(name, function, flag("terminal", item.terminal), item.direction))
    return result


def places(start: float, end: float) -> list[float]:
    """Return the times of a step at which events are looked at, its ends among them [s]."""
    times: list[float] = np.linspace(start, end, _INNER + 2).tolist()
    return times


class EventSearch:
    """Locates events, step after step.

    Attributes:
        happened: those that were found, in order of time.
    """

    def __init__(self, events: list[Watched], reading: Reading) -> None:
        """Begin at time 0.

        Args:
            events: to be located.
            reading: of the state at time 0.
        """
        self._events = events
        self.happened: list[Happened] = []
        self._values = [event.value(0.0, reading) for event in events]
        self._is_first = True

    def step(self, start: float, end: float, reading: Reading) -> float | None:
        """Look for events within a step; return when a terminal one ends it, else None.

        Args:
            start: of the step [s].
            end: of the step [s].
            reading: of the states within it.
        """
        times = places(start, end)
        found: list[tuple[float, Watched]] = []
        for index, event in enumerate(self._events):
            values = [self._values[index]]
            values += [event.value(time, reading) for time in times[1:]]
            self._values[index] = values[-1]
            if self._is_first and abs(values[0]) <= _BEGUN * max(map(abs, values)):
                values[0] = 0.0
            for k, (before, after) in enumerate(pairwise(values)):
                if _passes(before, after, event.direction):
                    sign = 1.0 if before > 0.0 else -1.0

                    def falling(time: float, event: Watched = event, sign: float = sign) -> float:
                        return sign * event.value(time, reading)

                    found.append((zero(falling, times[k], times[k + 1]), event))
        self._is_first = False
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
        step = integration.steps[-1]

        def reading(time: float) -> tuple[Named, Named]:
            return integration.equations.named(*integration.row_on(step, time))

        stopped = self.step(step.start, step.end, reading)
        if stopped is None:
            return ""
        integration.cut(integration.on(step, stopped))
        return self.reason


def _passes(before: float, after: float, direction: int) -> bool:
    """Return whether a function passes zero between two values; one that starts there does not."""
    rises, falls = before < 0.0 <= after, before > 0.0 >= after
    return (rises and direction >= 0) or (falls and direction <= 0)
