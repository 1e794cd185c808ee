"""HTML table: a small table of names and texts, as notebooks show it."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


def html_table(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return a table in HTML.

    Args:
        title: plain text above it.
        rows: header and plain text of each row; line breaks of the text are kept.
    """
    lines = [f"<tr><th>{escape(header)}</th><td>{_cell(text)}</td></tr>" for header, text in rows]
    return f"<table><caption>{escape(title)}</caption>{''.join(lines)}</table>"


def _cell(text: str) -> str:
    return escape(text).replace("\n", "<br>")
