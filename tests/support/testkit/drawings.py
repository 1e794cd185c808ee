"""What every figure must have: units on its axes, and files with something in them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from cardan_dyn import figures

UNIT = re.compile(r"\[(–|°|[pnµmkMGT]?(N·m|N|J|m|s)|[kMG]?N/ms|N/µm|kg|%)\]$")


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


def texts_of(figure: Any) -> list[tuple[str, Any]]:
    """Return all texts that a figure shows, and their boxes in pixels, as they are drawn."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Annotation, Text

    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    found = []
    ticks = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            slack = 1e-6 * (high - low)
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                shown = tick.label1.get_visible() and low - slack <= tick.get_loc() <= high + slack
                if not shown:
                    ticks.add(tick.label1)
                ticks.add(tick.label2)
    for item in figure.findobj(Text):
        if item in ticks or not item.get_visible() or not item.get_text().strip():
            continue
        # The box of an annotation takes in its arrow.
        of = (
            Text.get_window_extent if isinstance(item, Annotation) else type(item).get_window_extent
        )
        found.append((item.get_text(), of(item, renderer)))
    return found


def check_texts(figure: Any, slack: float = 1.0) -> None:
    """Look whether texts of a figure cover each other or are cut at its edges.

    Args:
        figure: of matplotlib.
        slack: by which boxes, which are larger than their letters, may overlap [pixels].
    """
    texts = texts_of(figure)
    width, height = figure.get_size_inches() * figure.dpi
    for text, box in texts:
        assert box.x0 > -slack and box.y0 > -slack, ("cut", text, box)
        assert box.x1 < width + slack and box.y1 < height + slack, ("cut", text, box)
    for index, (text, box) in enumerate(texts):
        for other, its in texts[:index]:
            across = min(box.x1, its.x1) - max(box.x0, its.x0)
            up = min(box.y1, its.y1) - max(box.y0, its.y0)
            assert across <= slack or up <= slack, (text, other, across, up)
