"""Extension of the site: formulas as MathML, which browsers set themselves, offline."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.errors import ExtensionError

_FUNCTION = r"\\(?:sin|cos|tan|arcsin)(?:\^\w)?"

_ACCENTED = re.compile(r"<mover><mi>([^<]+)</mi><mo[^>]*>&#x(0\w+);</mo></mover>")
_COMBINING = {"002D9": "\u0307", "000A8": "\u0308", "000AF": "\u0304", "0007E": "\u0303"}
"""Dot, two dots, bar and tilde, as they stand alone and above a letter."""


def formula(tex: str, display: str) -> str:
    """Return MathML, with the thin spaces about functions that TeX sets by itself."""
    tex = re.sub(rf"(?<=[\w}}])\s*(?={_FUNCTION})", r"\\,", tex)
    tex = re.sub(rf"({_FUNCTION})\s*(?=[\w\\])", r"\1\\,", tex)
    written = convert(tex, display=display)
    if "\\" in written:
        raise ExtensionError(f"a command of this formula is not known: {tex}")
    return _ACCENTED.sub(accented, written)


def accented(found: re.Match[str]) -> str:
    """Return a letter with its dots, bar or tilde as text has them.

    Where there is no font for mathematics, browsers set them as small as exponents.
    """
    return f'<mi style="font-style: italic">{found[1]}{_COMBINING[found[2]]}</mi>'


def inline(writer: Any, node: nodes.math) -> None:
    """Write a formula within a line."""
    writer.body.append(formula(node.astext(), "inline"))
    raise nodes.SkipNode


def block(writer: Any, node: nodes.math_block) -> None:
    """Write a formula on lines of its own, which scroll where a screen is narrower."""
    # Focusable, so that it is scrolled by keys as well.
    writer.body.append(
        '<div class="formula" tabindex="0" style="overflow-x: auto; margin: 1em 0">'
        '<div style="width: max-content; min-width: 100%; padding: 0.2em 0">'
        f"{formula(node.astext(), 'block')}</div></div>"
    )
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Make it the way in which Sphinx writes formulas."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True}
