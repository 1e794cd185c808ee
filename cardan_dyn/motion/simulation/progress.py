"""Progress: how far a simulation got, as a line with the time left or as calls of a function."""

from __future__ import annotations

import time as clock
from typing import Any

from ...kit.checks import described
from ...kit.errors import ArgumentError
from ...kit.time_left import Task
from .forces import needs

INTERRUPTED = "interrupted"
"""Reason of a simulation that Ctrl-C ended before its time."""
_MANY = 100_000
"""Steps of a simulation from which on it is said how many there will be, and when it would end."""
_COUNTED = 500
"""Steps from whose time the others are reckoned."""


class Progress:
    """Shows how far a simulation got.

    Attributes:
        notes: what was said beside it: of steps far more than a motion needs.
    """

    def __init__(self, wanted: Any, duration: float) -> None:
        """Make it.

        Args:
            wanted: True or False, None for where somebody looks (see `time_left`); or a function
                of the fraction done, or of that and of what is said beside it.
            duration: of the simulation [s].

        Raises:
            ArgumentError: something else.
        """
        self._duration = duration
        self._function = wanted if callable(wanted) else None
        self._wanted = wanted
        self._task: Task | None = None
        self.notes: tuple[str, ...] = ()
        self._takes_note = self._function is not None and needs(self._function) == 2
        self._steps, self._mark = 0, (0.0, clock.monotonic())
        if self._function is None and not (wanted is None or isinstance(wanted, bool)):
            raise ArgumentError(f"progress is {described(wanted)}, expected a bool or a function")

    def show(self, time: float) -> None:
        """Show that a time was reached [s]."""
        note = "; ".join(self.notes)
        if self._function is not None:
            self._function(time / self._duration, *[note] * self._takes_note)
        elif self._wanted is not False:
            self._task = self._task or Task("simulation", self._duration, self._wanted)
            self._task.tell(time, note)

    def step(self, time: float) -> None:
        """Show that a step reached a time [s], and reckon how many there will be."""
        self._steps += 1
        if self._steps % _COUNTED == 0:
            begun, then = self._mark
            now = clock.monotonic()
            left = _COUNTED * (self._duration - time) / max(time - begun, 1e-300)
            if self._steps + left >= _MANY:
                ends = clock.localtime(clock.time() + min(left * (now - then) / _COUNTED, 1e10))
                self.notes = (
                    f"slow: {self._steps} steps led to {time:.3g} s; steps of "
                    f"{(time - begun) / _COUNTED:.1e} s make {self._steps + left:.1e} in all, at "
                    f"this rate until {clock.strftime('%Y-%m-%d %H:%M', ends)}",
                )
            self._mark = time, now
        self.show(time)

    def close(self) -> None:
        """Take the line off."""
        if self._task is not None:
            self._task.close()
