"""Grey pictures: readable in print, small in the repository."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEVELS = 16


def write(figure: Figure, path: Path) -> None:
    """Write a figure as a PNG of a few shades of grey."""
    from PIL import Image

    buffer = BytesIO()
    figure.savefig(buffer, dpi=130, format="png")
    Image.open(buffer).convert("L").quantize(_LEVELS).save(path, optimize=True)
