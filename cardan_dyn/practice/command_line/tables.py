"""Tables: they break no words, and become records where the terminal is too narrow."""

from __future__ import annotations

from collections.abc import Sequence

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

Cell = str | Text


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


def crop(text: str) -> None:
    """Print a line, cut off at the width of the terminal."""
    console().print(Text(text), no_wrap=True, overflow="ellipsis")


def show(
    headings: Sequence[str],
    rows: Sequence[Sequence[Cell] | str],
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
        printer.print(Text(title, style="bold"))
    least = [
        max(_words(text, index in texts) for text in (*heading.splitlines(), *_column(rows, index)))
        for index, heading in enumerate(headings)
    ]
    room = printer.width - sum(least)
    between = next((gap for gap in (2, 1) if gap * (len(least) - 1) <= room), None)
    if between is None:
        _print_records(printer, headings, rows)
    else:
        room -= between * (len(least) - 1)
        for index in texts:
            whole = max(map(cell_len, (headings[index], *_column(rows, index))))
            more = max(0, min(whole - least[index], room))
            least[index], room = least[index] + more, room - more
        _print_lines(printer, headings, rows, texts, least, " " * between)
    if caption:
        printer.print(Text(caption, style="dim"))


def _column(rows: Sequence[Sequence[Cell] | str], index: int) -> list[str]:
    return [str(row[index]) for row in rows if not isinstance(row, str)]


def _words(text: str, wraps: bool) -> int:
    """Return the width that a cell needs: of its longest word if it may be wrapped."""
    return max(map(cell_len, text.split() if wraps else [text]), default=0)


def _print_lines(
    printer: Console,
    headings: Sequence[str],
    rows: Sequence[Sequence[Cell] | str],
    texts: Sequence[int],
    widths: list[int],
    between: str,
) -> None:
    """Print rows as lines, as many as their cells need."""

    def line(cells: Sequence[Cell], at_bottom: bool = False) -> None:
        wrapped = []
        for cell, width in zip(cells, widths, strict=True):
            text = Text(cell) if isinstance(cell, str) else cell
            wrapped.append(list(text.wrap(printer, width)) or [Text()])
        height = max(map(len, wrapped))
        for index, lines in enumerate(wrapped):
            empty = [Text() for _ in range(height - len(lines))]
            wrapped[index] = empty + lines if at_bottom else lines + empty
        for parts in zip(*wrapped, strict=True):
            for index, part in enumerate(parts):
                part.rstrip()
                part.align("left" if index in texts else "right", widths[index])
            joined = Text(between).join(parts)
            joined.rstrip()
            printer.print(joined, no_wrap=True, overflow="ignore", crop=False)

    line(headings, at_bottom=True)
    printer.print(Text("─" * (sum(widths) + len(between) * (len(widths) - 1))))
    for row in rows:
        if isinstance(row, str):
            printer.print(Text(row, style="bold"))
        else:
            line(row)


def _print_records(
    printer: Console, headings: Sequence[str], rows: Sequence[Sequence[Cell] | str]
) -> None:
    """Print every row as its first cell, and below it the others beside their headings."""
    names = [heading.replace("\n", " ") for heading in headings]
    width = max(map(cell_len, names[1:]), default=0)
    for row in rows:
        if isinstance(row, str):
            printer.print(Text(row, style="bold"))
            continue
        printer.print(Text(str(row[0]), style="bold"))
        for name, cell in zip(names[1:], row[1:], strict=True):
            if not str(cell):
                continue
            text = Text(cell) if isinstance(cell, str) else cell
            margin = Text("  ") + Text(name.ljust(width)) + Text("  ")
            if printer.width - cell_len(margin.plain) < _words(str(cell), True):
                printer.print(Text("  ") + Text(name))
                margin = Text("    ")
            for part in text.wrap(printer, max(1, printer.width - cell_len(margin.plain))):
                part.rstrip()
                printer.print(margin + part, no_wrap=True, overflow="ignore", crop=False)
                margin = Text(" " * cell_len(margin.plain))
