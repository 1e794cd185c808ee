"""Pages: what reports have in common, one HTML file each that needs nothing else.

A template extends `base.html`, which says how a page looks on screens, in the dark and on paper.
"""

from __future__ import annotations

import base64
import io
import os
import re
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from ..._version import __version__
from ...figures.style import LOOK, Figure
from ...kit.checks import writing
from ..viewer.viewing import templates

_BREAKS = re.compile(r"(?<=_)(?=.)|(?<=[a-z][.:])(?=[A-Za-z])|(?<=[a-z])(?=[A-Z][a-z])")
"""Between the words of a name."""
_MINUS = re.compile(r"(?<![\w)-])-(?=\.?\d)")
"""The hyphen of a negative number."""
FRAMES = 181
"""Positions of a moving scene, and of curves at least."""
BESIDE = 6
"""Curves of a figure, or columns of numbers on a sheet of paper, that can be told apart."""
HIGHEST = 8
"""Greatest order that is listed: those above are small where joint angles are those of lines."""
EPOCH = "SOURCE_DATE_EPOCH"
"""Environment variable [s since 1970] that builds set to be reproducible."""


def template(name: str) -> Any:
    """Return the template of a page.

    Raises:
        MissingExtraError: Jinja is not installed.
    """
    environment = templates("report")
    environment.filters |= {"css_text": css_text, "soft": soft}
    return environment.get_template(name)


def write(path: Path, name: str, **content: Any) -> Path:
    """Write a page.

    Args:
        path: of the HTML file; its directory is made if it does not exist.
        name: of a template.
        content: what it takes: the `title` of the page; where it extends `base.html`, names and
            values at its head as `title_block`; in another language than English the `language`, a
            tag as HTML has it, and the `Wording` as `_`.

    Raises:
        MissingExtraError: Jinja is not installed.
        ArgumentError: it cannot be written.
    """
    text = template(name).render(version=__version__, **content)
    with writing(path) as part:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(text, encoding="utf-8")
    return path


def today() -> date:
    """Return the day that a report has unless given: that of SOURCE_DATE_EPOCH, or today in UTC."""
    seconds = os.environ.get(EPOCH, "")
    if seconds.isascii() and seconds.isdigit():
        return datetime.fromtimestamp(int(seconds), UTC).date()
    return datetime.now(UTC).date()


def image(figure: Figure) -> str:
    """Return a figure as SVG in a data URI; equal figures give equal texts."""
    import matplotlib

    buffer = io.BytesIO()
    with matplotlib.rc_context(LOOK):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def css_text(text: str) -> Any:
    """Return a text as CSS in a style element has it: what ends either of them is escaped."""
    from markupsafe import Markup

    safe = "".join(
        letter if letter.isalnum() or letter in " .,:;-_/()·" else f"\\{ord(letter):x} "
        for letter in text
    )
    return Markup(f'"{safe}"')


def soft(text: object) -> Any:
    """Return a text whose names, as joints and links have them, may break between their words.

    Its negative numbers have minus signs, as those of figures do.
    """
    from markupsafe import Markup, escape

    shown = _MINUS.sub("−", str(text))
    return Markup("<wbr>").join(escape(part) for part in _BREAKS.split(shown))
