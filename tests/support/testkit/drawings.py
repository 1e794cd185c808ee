"""What every figure must have: units on its axes, and files with something in them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from cardan_dyn import figures

UNIT = re.compile(r"\[(–|°|N|N·m|N/ms|N/µm|J|kg|mm|µm|s|µs|%)\]$")


def check_units_and_files(figure: Any, directory: Path) -> None:
    """Save a figure below a directory and look for content and units.

    Args:
        figure: of matplotlib.
        directory: an existing one.
    """
    vector, pixels = figures.save(figure, directory / "deep" / "figure")
    assert vector.read_text(encoding="utf-8").count("<path") > 5
    content = pixels.read_bytes()
    assert content.startswith(b"\x89PNG") and len(content) > 10_000
    for axes in figure.axes:
        if axes.name != "rectilinear":
            continue
        assert UNIT.search(axes.get_ylabel()), axes.get_ylabel()
        # Of axes that share their abscissa only the lowest says what it is.
        shared = axes.get_shared_x_axes().get_siblings(axes)
        labels = [sibling.get_xlabel() for sibling in shared if sibling.get_xlabel()]
        assert labels and all(UNIT.search(label) for label in labels), labels
