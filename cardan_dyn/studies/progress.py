"""Progress: how far a study is, at which rate, and how long it takes yet."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Told = Callable[[int, int], None]
"""Takes the number of cases that are done and that failed, of all."""


@contextmanager
def shown(wanted: bool | Told | None, total: int, done: int, note: str = "") -> Iterator[Told]:
    """Show a bar in a terminal or notebook.

    Args:
        wanted: True or False; a function that is told instead; None for a bar where somebody looks.
        total: number of cases.
        done: of them, before anything is computed.
        note: what is said above the bar.
    """
    if callable(wanted):
        yield wanted
        return
    if wanted is None:
        wanted = sys.stderr.isatty() or "ipykernel" in sys.modules
    if not wanted:
        yield lambda done, failed: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        """Cases per second."""

        def render(self, task: Task) -> Text:
            return Text(f"{task.speed:.3g}/s" if task.speed else "")

    columns = (
        TextColumn("{task.completed:,.0f} of {task.total:,.0f} cases"),
        BarColumn(),
        TextColumn("{task.percentage:.0f} %"),
        Rate(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[failed]}", style="red"),
    )
    with Progress(*columns, console=Console(stderr="ipykernel" not in sys.modules)) as bar:
        if note:
            bar.console.print(note, markup=False)
        task = bar.add_task("", total=total, completed=done, failed="")

        def told(done: int, failed: int) -> None:
            bar.update(task, completed=done, failed=f"{failed} failed" if failed else "")

        yield told
