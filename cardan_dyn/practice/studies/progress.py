"""Progress: how far a study is, at which rate, and how long it takes yet."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...kit.time_left import Task, is_watched

Told = Callable[[int, int], None]
"""Takes the number of cases that are done and that failed, of all."""


@contextmanager
def shown(wanted: bool | Told | None, total: int, done: int, note: str = "") -> Iterator[Told]:
    """Show a line in a terminal or notebook.

    Args:
        wanted: True or False; a function that is told instead; None for where somebody looks.
        total: number of cases.
        done: of them, before anything is computed.
        note: what is said above it.
    """
    if callable(wanted):
        yield wanted
        return
    if note and (is_watched() if wanted is None else wanted):
        print(note, file=sys.stderr)
    begun = time.monotonic()
    with Task("study", total - done, wanted) as task:

        def told(now: int, failed: int) -> None:
            def said() -> str:
                rate = (now - done) / max(time.monotonic() - begun, 1e-9)
                text = f"{now:,} of {total:,} cases, {rate:.3g}/s"
                return f"{text}, {failed:,} failed" if failed else text

            task.tell(now - done, said)

        yield told
