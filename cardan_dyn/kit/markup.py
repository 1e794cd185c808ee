"""Markup: tables of plain text, and small pieces of HTML that notebooks show, all escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def aligned(rows: Sequence[Sequence[str]], numeric: Sequence[bool] = ()) -> str:
    """Return rows of texts below each other, with columns of numbers on the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    sides = [">" if is_number else "<" for is_number in numeric] or ["<"] * len(widths)
    shown = [zip(row, sides, widths, strict=True) for row in rows]
    lines = ("  ".join(f"{text:{side}{width}}" for text, side, width in row) for row in shown)
    return "\n".join(map(str.rstrip, lines))


def element(tag: str, text: object) -> str:
    """Return an element with plain text, whose line breaks are kept."""
    return f"<{tag}>{escape(str(text)).replace(chr(10), '<br>')}</{tag}>"


def table(header: Iterable[object], rows: Iterable[Iterable[object]], caption: str = "") -> str:
    """Return a table of plain texts."""
    title = element("caption", caption) if caption else ""
    head = f"<thead>{_row('th', header)}</thead>"
    body = f"<tbody>{''.join(_row('td', row) for row in rows)}</tbody>"
    return f"<table>{title}{head}{body}</table>"


def listed(tag: str, items: Iterable[object]) -> str:
    """Return a list, `ol` or `ul`, of plain texts."""
    return f"<{tag}>{''.join(element('li', item) for item in items)}</{tag}>"


def _row(tag: str, texts: Iterable[object]) -> str:
    return f"<tr>{''.join(element(tag, text) for text in texts)}</tr>"
