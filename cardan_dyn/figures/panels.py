"""Panels: axes below each other over one abscissa, with lines and their peaks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Unpack

import numpy as np

from ..kit.arrays import Array
from ..kit.quantities import amount, span
from .peaks import label_peaks
from .style import Abscissa, Figure, Onto, settle, sheet


class Panel(NamedTuple):
    """What one axes shows.

    Attributes:
        label: of the ordinate.
        unit: of the values.
        scale: size beside which they are rounding.
        curves: names to values `(N,)`; one name is drawn alike on all axes, and no other one is.
        limits: least and greatest that the curves of these names should keep to, drawn where they
            are near.
    """

    label: str
    unit: str
    scale: float
    curves: dict[str, Array]
    limits: dict[str, tuple[float, float]]


def stacked(
    at: Abscissa,
    panels: Sequence[Panel],
    *,
    note: str = "",
    peaks: bool | None = None,
    line: Mapping[str, Any] | None = None,
    labels: Mapping[str, str] | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw panels below each other over one abscissa.

    Args:
        at: the abscissa.
        panels: what they show.
        note: on what is drawn.
        peaks: see `label_peaks`.
        line: properties of the lines, for `Axes.plot`.
        labels: names of curves to what legends call them, if not by these.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: other axes than are needed.
    """
    size = 7.2, 1.4 + 2.6 * len(panels)
    drawn = sheet(len(panels), size=size, share_x=True, **onto)
    first = [drawn.drawn(row) for row in range(len(panels))]
    drawn.over(at)
    names = dict.fromkeys(name for panel in panels for name in panel.curves)
    styles = {name: index for index, name in enumerate(names)}
    told = {name: name for name in names} | dict(labels or {})
    for item in panels:
        for name, ends in item.limits.items():
            told[name] += f", {_in_words(*ends, item.unit)}"
    for row, (label, unit, scale, curves, limits) in enumerate(panels):
        panel, lines = drawn.panels[row], []
        for name, values in curves.items():
            shown = {told[name]: values}
            lines += at.draw(panel, shown, first[row] + styles[name], **(line or {}))
            for side, limit in zip((-1.0, 1.0), limits.get(name, ()), strict=False):
                if side * limit <= 2.0 * np.nanmax(side * values, initial=0.0):
                    panel.axhline(limit, color=lines[-1].get_color(), linestyle=":")
        panel.set_ylabel(label)
        settle(panel, scale)
        label_peaks(panel, lines, unit, at.unit, peaks, scale)
    return drawn.finish(columns=4, note=note)


def _in_words(least: float, most: float, unit: str) -> str:
    told = f"limit {amount(most, unit)}" if least == -most else f"limits {span(least, most, unit)}"
    return told.replace("-", "−")
