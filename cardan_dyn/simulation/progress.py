"""Progress: how far a simulation got, as a bar or as calls of a function."""

from __future__ import annotations

from typing import Any

from ..checks import described
from ..errors import ArgumentError


class Progress:
    """Shows how far a simulation got."""

    def __init__(self, wanted: Any, duration: float) -> None:
        """Make it.

        Args:
            wanted: True for a bar, a function of the fraction done, or False.
            duration: of the simulation [s].

        Raises:
            ArgumentError: something else.
        """
        self._duration = duration
        self._function = wanted if callable(wanted) else None
        self._has_bar = wanted is True
        self._bar: Any = None
        if self._function is None and not isinstance(wanted, bool):
            raise ArgumentError(f"progress is {described(wanted)}, expected a bool or a function")

    def show(self, time: float) -> None:
        """Show that a time was reached [s]."""
        if self._function is not None:
            self._function(time / self._duration)
        elif self._has_bar:
            if self._bar is None:
                self._start_bar()
            self._bar.update(self._task, completed=time)

    def _start_bar(self) -> None:
        from rich.progress import Progress as Bar  # Few simulations show one.

        self._bar = Bar()
        self._task = self._bar.add_task("simulating", total=self._duration)
        self._bar.start()

    def close(self) -> None:
        """Take the bar off."""
        if self._bar is not None:
            self._bar.stop()
