"""Peaks: value and place of the extremes of lines, written beside them where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..kit.arrays import NOTHING, Array
from ..kit.quantities import amount
from .style import SMALL, Axes, width_of


def label_peaks(
    panel: Axes,
    lines: Sequence[Any],
    unit: str,
    at_unit: str,
    peaks: bool | None = None,
    scale: float = 0.0,
) -> None:
    """Mark extremes of lines, and write their values and places.

    A label that would cover another one is left out, its mark is not; over a line it is written
    only where it was asked for, on white.

    Args:
        panel: axes with a linear scale.
        lines: in it.
        unit: of their values.
        at_unit: of the abscissa.
        peaks: mark the greatest and the least value of each line, or nothing if False; if None,
            the greater one by size, where there are few lines.
        scale: size beside which lines are rounding, and have no peaks.
    """
    # Unasked, those of two lines at most are labelled.
    if peaks is False or (peaks is None and len(panel.get_lines()) > 2):
        return
    low, high = panel.get_ylim()
    written: list[Any] = []
    sides = {0.0}
    for line in lines:
        if line.get_linestyle() == "None":
            continue  # Between points in no order there is nothing.
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        if np.max(np.abs(np.nan_to_num(y)), initial=0.0) <= NOTHING * scale:
            continue
        # Of fewer points than eight, each is seen.
        for place in _extremes(y, both=bool(peaks), fewest=1 if peaks else 8):
            # Above or below: where the line itself is not.
            side = 1.0 if y[place] >= 0.5 * (np.nanmax(y) + np.nanmin(y)) else -1.0
            panel.scatter(x[place], y[place], s=16, color=line.get_color(), zorder=3)
            text = f"{_told(y, place, unit)} at {_told(x, place, at_unit)}"
            if _write(panel, text, (x[place], y[place]), side, written, asked=bool(peaks)):
                sides.add(side)
    if written:
        beyond = (high - low) * 2.5 * _line(panel) / panel.bbox.height
        panel.set_ylim(low + beyond * min(sides), high + beyond * max(sides))
        panel.set_autoscaley_on(True)


def _extremes(y: Array, *, both: bool, fewest: int) -> list[int]:
    """Return the places of the greatest and the least value, or of the greater by size alone."""
    known = y[np.isfinite(y)]
    if len(known) < fewest or not known.size:
        return []
    high, low = float(known.max()), float(known.min())
    size = max(abs(high), abs(low))
    if high - low <= 1e-6 * size:
        return [0] if both and np.isfinite(y[0]) else []
    wanted = [high, low] if both else [high if abs(high) >= (1.0 - NOTHING) * abs(low) else low]
    return [int(np.flatnonzero(np.abs(y - value) <= NOTHING * size)[0]) for value in wanted]


def _line(panel: Axes) -> float:
    """Return the size of letters in pixels."""
    return SMALL * float(panel.figure.dpi) / 72.0


def _write(
    panel: Axes,
    text: str,
    at: tuple[float, float],
    side: float,
    written: list[Any],
    *,
    asked: bool,
) -> bool:
    """Write a label above or below a point, unless it would cover another one, or a line."""
    from matplotlib.transforms import Bbox

    x, y = panel.transData.transform(at)
    height, width = _line(panel), width_of(text) * panel.figure.dpi
    # At the ends of the axes a label stands to the side that is within.
    starts = {
        "center": x - 0.5 * width,
        "left": x + 0.5 * height,
        "right": x - 0.5 * height - width,
    }
    within = (
        lean
        for lean, start in starts.items()
        if panel.bbox.x0 <= start and start + width <= panel.bbox.x1
    )
    lean = next(within, "center")
    start, near, far = starts[lean], y + 0.7 * side * height, y + 1.8 * side * height
    box = Bbox.from_extents(start, min(near, far), start + width, max(near, far))
    if any(box.overlaps(other) for other in written):
        return False
    paths = (line.get_transform().transform_path(line.get_path()) for line in panel.get_lines())
    covers = any(path.intersects_bbox(box, filled=False) for path in paths)
    if covers and not asked:
        return False
    written.append(box)
    lined = {"center": 0.0, "left": 0.5, "right": -0.5}[lean] * SMALL
    panel.annotate(
        text,
        at,
        (lined, 0.7 * side * SMALL),
        textcoords="offset points",
        ha=lean,
        va="bottom" if side > 0.0 else "top",
        fontsize=SMALL,
        bbox={"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8}
        if covers
        else None,
    )
    return True


def _told(values: Array, place: int, unit: str) -> str:
    """Return one of some values as a text, in the unit in which an axis shows all of them."""
    size = float(np.nanmax(np.abs(values)))
    return amount(float(values[place]), unit, size=size).replace("-", "\N{MINUS SIGN}")
