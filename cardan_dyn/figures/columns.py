"""Columns: lines over anything, an axes per unit."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ..kit.arrays import Array
from .peaks import label_peaks
from .style import Abscissa, Figure, Into, Size, plain, settle, sheet
from .wrenches import MARK

Column = tuple[Array, str]
"""Values `(N,)`, and their unit."""


def over_column(
    at: Abscissa,
    columns: Mapping[str, Column],
    *,
    title: str = "",
    ylabel: str = "",
    scales: Mapping[str, float] | None = None,
    marked: Collection[str] = (),
    note: str = "",
    peaks: bool | None = None,
    ax: Into = None,
    figsize: Size | None = None,
    line: Mapping[str, Any] | None = None,
) -> Figure:
    """Draw columns over an abscissa; those of one unit share their axes, angles are in degrees.

    Args:
        at: the abscissa.
        columns: names to values and units.
        title: of the figure.
        ylabel: of the ordinate, if all have one unit; the unit if empty.
        scales: units to sizes beside which values are rounding.
        marked: names of columns that are not determined by statics.
        note: on what is drawn.
        peaks: see `label_peaks`.
        ax: see `sheet`.
        figsize: likewise.
        line: properties of the lines, for `Axes.plot`.

    Raises:
        ArgumentError: other axes than are needed.
    """
    shown = {name: _in_degrees(*column) for name, column in columns.items()}
    units = list(dict.fromkeys(unit for _, unit in shown.values()))
    drawn = sheet(
        len(units), size=(7.2, 1.4 + 2.6 * len(units)), share_x=True, ax=ax, figsize=figsize
    )
    firsts = {unit: drawn.drawn(row) for row, unit in enumerate(units)}
    panels = dict(zip(units, drawn.panels, strict=True))
    curves: dict[str, list[Any]] = {unit: [] for unit in units}
    for index, (name, (values, unit)) in enumerate(shown.items()):
        style = {
            **at.style(firsts[unit] + index),
            "label": plain(name),
            **(line or {}),
        }
        style["label"] = f"{style['label']}{MARK if name in marked else ''}"
        curves[unit] += panels[unit].plot(at.values, values, **style)
    for unit, panel in panels.items():
        label = f"[{unit}]" if unit not in ("", "1") else "[–]"
        panel.set_ylabel(ylabel if ylabel and len(units) == 1 else label)
        scale = (scales or {}).get(unit, 0.0)
        settle(panel, scale)
        told = unit if unit != "1" else ""
        label_peaks(panel, curves[unit], told, at.unit, peaks, scale)
    drawn.over(at)
    return drawn.finish(title, 3, note)


def _in_degrees(values: Array, unit: str) -> Column:
    return (np.rad2deg(values), "°") if unit == "rad" else (values, unit)
