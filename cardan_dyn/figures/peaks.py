"""Peaks: value and place of the extremes of lines, written beside them where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..kit.arrays import NOTHING, Array
from ..kit.quantities import number, prefix
from .style import LETTER, SMALL, Axes

_MOST_LINES = 2
"""Lines in axes up to which their peaks are labelled without being asked for."""
_FEWEST = 8
"""Points of a line from which on that is done: of fewer, each is seen."""
_LINE, _GAP = 1.25, 6.0
"""Height of a line in font sizes, and distance from the peak [pt]."""
_ASIDE = 4.0
"""Distance of a label at the end of the axes from that [pt]."""
_FLAT = 1e-6
"""Range of a line, as a fraction of its greatest value, below which it has no peak."""
_MOST_PARTS = 64
"""Parts of a step between samples that are looked at, at most."""
_ON_WHITE = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
_INSIDE = 0.6
"""Part of the width of a figure that its axes fill at least."""


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
    if peaks is False or (peaks is None and len(panel.get_lines()) > _MOST_LINES):
        return
    written: list[tuple[float, float, float, float]] = []
    room = {1.0: False, -1.0: False}
    for line in lines:
        if line.get_linestyle() == "None":
            continue  # Between points in no order there is nothing.
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        if np.max(np.abs(np.nan_to_num(y)), initial=0.0) <= NOTHING * scale:
            continue
        for place in _extremes(y, both=bool(peaks), fewest=1 if peaks else _FEWEST):
            side = _side(y, place)
            panel.scatter(x[place], y[place], s=16, color=line.get_color(), zorder=3)
            text = f"{_told(y, place, unit)} at {_told(x, place, at_unit)}"
            if _write(panel, text, (x[place], y[place]), side, x, written, asked=bool(peaks)):
                room[side] = True
    low, high = panel.get_ylim()
    beyond = (_LINE * SMALL + 2.0 * _GAP) / _height(panel) * (high - low)
    if any(room.values()):
        panel.set_ylim(low - beyond * room[-1.0], high + beyond * room[1.0])
        panel.set_autoscaley_on(True)


def _extremes(y: Array, *, both: bool, fewest: int) -> list[int]:
    """Return the places of the greatest and the least value, or of the greater by size alone."""
    known = y[np.isfinite(y)]
    if len(known) < fewest or not known.size:
        return []
    high, low = float(known.max()), float(known.min())
    size = max(abs(high), abs(low))
    if high - low <= _FLAT * size:
        return [0] if both and np.isfinite(y[0]) else []
    wanted = [high, low] if both else [high if abs(high) >= (1.0 - NOTHING) * abs(low) else low]
    return [int(np.flatnonzero(np.abs(y - value) <= NOTHING * size)[0]) for value in wanted]


def _side(y: Array, place: int) -> float:
    """Return 1 above and -1 below: where the line itself is not."""
    middle = 0.5 * (float(np.nanmax(y)) + float(np.nanmin(y)))
    return 1.0 if y[place] >= middle else -1.0


def _write(
    panel: Axes,
    text: str,
    at: tuple[float, float],
    side: float,
    x: Array,
    written: list[tuple[float, float, float, float]],
    *,
    asked: bool,
) -> bool:
    """Write a label above or below a point, unless it would cover another one, or a line."""
    low, high = (float(end) for end in (np.nanmin(x), np.nanmax(x)))
    bottom, top = panel.get_ylim()
    width = _INSIDE * panel.figure.get_figwidth() * 72.0
    across = (at[0] - low) / ((high - low) or 1.0)
    letters = LETTER * SMALL * len(text)
    # At the ends of the axes a label stands to the side that is within.
    lean = "left" if across * width < 0.5 * letters else "center"
    lean = "right" if (1.0 - across) * width < 0.5 * letters else lean
    start = across * width - {"left": 0.0, "center": 0.5, "right": 1.0}[lean] * letters
    height = (at[1] - bottom) / ((top - bottom) or 1.0) * _height(panel) + side * _GAP
    box = (start, start + letters, height, height + side * _LINE * SMALL)
    box = (*box[:2], min(box[2:]), max(box[2:]))
    if any(
        box[0] < other[1] and other[0] < box[1] and box[2] < other[3] and other[2] < box[3]
        for other in written
    ):
        return False
    scale = (width / ((high - low) or 1.0), _height(panel) / ((top - bottom) or 1.0))
    covers = any(_crosses(line, box, (low, bottom), scale) for line in panel.get_lines())
    if covers and not asked:
        return False
    written.append(box)
    panel.annotate(
        text,
        at,
        ({"left": _ASIDE, "center": 0.0, "right": -_ASIDE}[lean], side * _GAP),
        textcoords="offset points",
        ha=lean,
        va="bottom" if side > 0.0 else "top",
        fontsize=SMALL,
        bbox={**_ON_WHITE} if covers else None,
    )
    return True


def _crosses(
    line: Any,
    box: tuple[float, float, float, float],
    origin: tuple[float, float],
    scale: tuple[float, float],
) -> bool:
    """Return whether a line crosses a box [pt]."""
    x, y = (
        (np.asarray(values, dtype=float) - start) * per_unit
        for values, start, per_unit in zip(line.get_data(), origin, scale, strict=True)
    )
    if len(x) < 2:
        return False
    # Between samples a line goes on: each step is looked at in parts of a letter's height.
    steps = np.nan_to_num(np.hypot(np.diff(x), np.diff(y)), nan=0.0)
    parts = min(_MOST_PARTS, 1 + int(np.max(steps, initial=0.0) / SMALL))
    along = np.linspace(0.0, 1.0, parts, endpoint=False)
    across, up = (
        (values[:-1, None] + np.diff(values)[:, None] * along).ravel() for values in (x, y)
    )
    # The box of a label stands off its own line by the gap.
    inside = (across > box[0]) & (across < box[1]) & (up > box[2] + 1.0) & (up < box[3] - 1.0)
    return bool(np.any(inside))


def _height(panel: Axes) -> float:
    """Return about how high axes are [pt]."""
    rows = panel.get_gridspec().nrows if panel.get_gridspec() is not None else 1
    return max(20.0, 72.0 * (0.8 * float(panel.figure.get_figheight()) / rows - 0.3))


def _told(values: Array, place: int, unit: str) -> str:
    """Return one of some values as a text, in the unit in which an axis shows all of them."""
    size = float(np.nanmax(np.abs(values)))
    scale, shown = prefix(size, unit)
    value = 0.0 if abs(values[place]) <= NOTHING * size else float(values[place])
    text = number(value / scale).replace("-", "\N{MINUS SIGN}")
    return text + (shown if shown in ("", "°") else f" {shown}")
