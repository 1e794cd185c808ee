"""Markup: small pieces of HTML that notebooks show. All text is escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


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
