"""Time left: a line that says how far something is and how long it takes yet, where somebody looks.

Whatever may take long says so by a `Task`, and no caller passes anything on. Nothing is
shown in scripts whose output is piped, in worker processes and other threads, or within two
seconds of what is begun first. What runs inside of something longer moves that on by its part.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable

_PATIENCE = 2.0
"""Time [s] after which something is shown."""
_EVERY = 0.2
"""Time [s] between two lines: often enough to be seen moving, and too seldom to cost anything."""
_WIDTH = 24
"""Characters of the bar."""
_PROCESS = os.getpid()

_running: list[Task] = []
"""What is shown, or would be, and what runs inside of it."""
_is_wanted: bool | None = None


class progress:  # noqa: N801  # A word that reads like the functions beside it.
    """Show progress, or do not; `cd.progress(False)`, or `with cd.progress(False): ...`.

    Without, it is shown in terminals and notebooks of whatever takes more than two seconds,
    unless the environment has `CARDAN_DYN_PROGRESS=0`.

    Args:
        wanted: True or False; None for where somebody looks.
    """

    def __init__(self, wanted: bool | None) -> None:
        global _is_wanted
        self._before, _is_wanted = _is_wanted, wanted

    def __enter__(self) -> progress:
        return self

    def __exit__(self, *error: object) -> None:
        global _is_wanted
        _is_wanted = self._before


def is_watched() -> bool:
    """Return whether progress is shown unless somebody says otherwise."""
    if os.environ.get("CARDAN_DYN_PROGRESS") == "0":
        return False
    # A notebook's stream is no terminal. That its package is there says nothing: Dask imports it.
    if type(sys.stderr).__module__.partition(".")[0] == "ipykernel":
        return True
    return sys.stderr is not None and sys.stderr.isatty()


class Task:
    """Something that takes time; it ends by `close`, or as a context."""

    def __init__(self, what: str, total: float, wanted: bool | None = None) -> None:
        """Begin.

        Args:
            what: is done, in a word or two.
            total: number of steps, of any kind.
            wanted: whether to show it; as `progress` says if None.
        """
        self._what, self._total = what, total
        self._begun = time.monotonic()
        self._done, self._part, self._said = 0.0, 0.0, ""
        self._is_drawn = False
        wanted = _is_wanted if wanted is None else wanted
        own = threading.current_thread() is threading.main_thread() and os.getpid() == _PROCESS
        self._is_shown = own and (is_watched() if wanted is None else wanted)
        self._outer = _running[-1] if self._is_shown and _running else None
        # Many that are over at once make a long one together: who waits counts from its begin.
        self._next: float = self._outer._next if self._outer else self._begun + _PATIENCE
        if self._is_shown:
            _running.append(self)

    def __enter__(self) -> Task:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def tell(self, done: float, said: str | Callable[[], str] = "") -> None:
        """Say how many steps are done, and what else there is to say, or how to find that out."""
        if not self._is_shown:
            return
        self._done, self._part = done, 0.0
        self._show(said)

    def _show(self, said: str | Callable[[], str] = "") -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _EVERY
        done = self._done + self._part
        fraction = min(1.0, max(0.0, done / self._total)) if self._total > 0 else 0.0
        if self._outer is not None:
            self._outer._part = max(self._outer._part, fraction)
            self._outer._show()
            return
        text = said() if callable(said) else said
        line = _line(self._what, fraction, now - self._begun, text)
        width = max(20, _columns() - 1)
        self._draw(line[:width].ljust(min(width, len(self._said))))
        self._said = line[:width]

    def _draw(self, text: str) -> None:
        self._is_drawn = True
        try:
            sys.stderr.write(f"\r{text}")
            sys.stderr.flush()
        except (OSError, ValueError):  # Nobody reads it any more, which ends no computation.
            self._is_shown = False

    def close(self) -> None:
        """End it; its line is taken off."""
        if self in _running:
            del _running[_running.index(self) :]
        if self._is_drawn:
            self._draw(" " * len(self._said) + "\r")
            self._is_drawn = False


def _line(what: str, fraction: float, elapsed: float, said: str) -> str:
    """Return what is shown."""
    full = round(_WIDTH * fraction)
    bar = "━" * full + "─" * (_WIDTH - full)
    left = f"{duration(elapsed * (1.0 - fraction) / fraction)} left" if fraction > 0.0 else ""
    parts = (what, bar, f"{100.0 * fraction:.0f} %", left, said)
    return "  ".join(part for part in parts if part)


def duration(seconds: float) -> str:
    """Return a time as it is said: `3:07`, `2:03:07`, `5 days`."""
    if seconds >= 48.0 * 3600.0:
        return f"{seconds / 86400.0:.0f} days"
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02d}:{second:02d}" if hours else f"{minute}:{second:02d}"


def _columns() -> int:
    """Return the width of where it is shown."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError, AttributeError):
        return 80
