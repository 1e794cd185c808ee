"""Tables: they break no words, and become records where the terminal is too narrow."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any, Literal

import click
from rich.align import Align
from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

_COLOURS = {
    "pass": "green",
    "default": "green",
    "fail": "bold red",
    "FAIL": "bold red",
    "open": "yellow",
}
"""Of words in the last column."""


class _Console(Console):
    """Leaves a closed pipe to the group of commands."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def console() -> Console:
    """Return what prints on standard output."""
    return _Console(highlight=False, emoji=False)


def say(text: str, style: str = "") -> None:
    """Print a line as it is, wrapped at words."""
    console().print(Text(text, style=style))


def print_json(content: Any, unknown: Callable[[str], Any] = lambda word: None) -> None:
    """Print JSON; `unknown` gives what stands for `NaN`, `Infinity` and `-Infinity`."""
    plain = json.loads(json.dumps(content), parse_constant=unknown)
    click.echo(json.dumps(plain, ensure_ascii=False, indent=1))


def crop(text: str) -> None:
    """Print a line, cut off at the width of the terminal."""
    console().print(Text(text), no_wrap=True, overflow="ellipsis")


def show(
    headings: Sequence[str],
    rows: Sequence[Sequence[str] | str],
    *,
    title: str = "",
    caption: str = "",
    texts: Sequence[int] = (0,),
) -> None:
    """Print a table; as a record for each row where words do not fit beside each other.

    Args:
        headings: of the columns; one may have several lines.
        rows: cells, or the title of the rows that follow.
        title: above the table.
        caption: below it.
        texts: columns that hold words, aligned to the left; those of numbers are not wrapped.
    """
    printer = console()
    if title:
        say(title, "bold")
    columns = [
        [*heading.splitlines(), *(row[index] for row in rows if not isinstance(row, str))]
        for index, heading in enumerate(headings)
    ]
    # A cell needs its longest word if it may be wrapped.
    widths = [
        max(cell_len(word) for text in column for word in (text.split() if k in texts else [text]))
        for k, column in enumerate(columns)
    ]
    room = printer.width - sum(widths)
    between = next((gap for gap in (2, 1) if gap * (len(widths) - 1) <= room), None)
    if between is None:
        _print_records(headings, rows)
    else:
        room -= between * (len(widths) - 1)
        for index in texts:
            more = max(0, min(max(map(cell_len, columns[index])) - widths[index], room))
            widths[index], room = widths[index] + more, room - more
        _print_lines(headings, rows, texts, widths, between)
    if caption:
        say(caption, "dim")


def _print_lines(
    headings: Sequence[str],
    rows: Sequence[Sequence[str] | str],
    texts: Sequence[int],
    widths: Sequence[int],
    between: int,
) -> None:
    """Print rows as lines, as many as their cells need."""
    printer, padding = console(), (0, between - 1, 0, 0)
    table = Table(box=SIMPLE_HEAD, show_edge=False, padding=padding, pad_edge=False)
    for index, (heading, width) in enumerate(zip(headings, widths, strict=True)):
        side: Literal["left", "right"] = "left" if index in texts else "right"
        head = Align(Text(heading, justify=side), side, vertical="bottom")
        table.add_column(head, justify=side, width=width, header_style="")
    for row in rows:
        table.add_row(*([Text(row, "bold")] if isinstance(row, str) else _coloured(row)))
    for parts in printer.render_lines(table, pad=False):
        line = Text.assemble(*((part.text, part.style or "") for part in parts))
        line.rstrip()
        printer.print(line, no_wrap=True)


def _coloured(row: Sequence[str]) -> list[Text]:
    return [*map(Text, row[:-1]), Text(row[-1], _COLOURS.get(row[-1], ""))]


def _print_records(headings: Sequence[str], rows: Sequence[Sequence[str] | str]) -> None:
    """Print every row as its first cell, and below it the others beside their headings."""
    printer, names = console(), [heading.replace("\n", " ") for heading in headings]
    width = max(map(cell_len, names[1:]), default=0)
    for row in rows:
        first, *others = [Text(row)] if isinstance(row, str) else _coloured(row)
        say(first.plain, "bold")
        for name, cell in zip(names[1:], others, strict=False):
            if not cell:
                continue
            margin = f"  {name.ljust(width)}  "
            if printer.width - cell_len(margin) < max(map(cell_len, cell.plain.split())):
                say(f"  {name}")
                margin = "    "
            for part in cell.wrap(printer, max(1, printer.width - cell_len(margin))):
                part.rstrip()
                printer.print(Text(margin) + part, no_wrap=True, overflow="ignore", crop=False)
                margin = " " * cell_len(margin)
