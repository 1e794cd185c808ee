"""Columns: lines of a table over one of its columns, an axes per unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import Array
from .style import TITLE_SIZE, Figure, angle_axis, axes_grid, curve_style, legend

Column = tuple[Array, str]
"""Values `(N,)`, and their unit."""


def over_column(over: str, abscissa: Column, columns: Mapping[str, Column], title: str) -> Figure:
    """Return a figure of columns over another one, in degrees where that is an angle.

    Args:
        over: name of the abscissa.
        abscissa: its values and unit.
        columns: names to values and units.
        title: of the figure.
    """
    values, unit = abscissa
    at, unit = (np.rad2deg(values), "°") if unit == "rad" else (values, unit)
    units = list(dict.fromkeys(unit for _, unit in columns.values()))
    figure, axes = axes_grid(len(units), size=(7.2, 1.4 + 2.6 * len(units)), share_x=True)
    panels = dict(zip(units, np.atleast_1d(axes), strict=True))
    for index, (name, (line, its)) in enumerate(columns.items()):
        panels[its].plot(at, line, **curve_style(index, len(at)), label=name)
    for its, panel in panels.items():
        panel.set_ylabel(f"[{its}]" if its != "1" else "[–]")
    if unit == "°":
        angle_axis(panels[units[-1]], f"{over} [°]", values)
    else:
        panels[units[-1]].set_xlabel(f"{over} [{unit}]")
    figure.suptitle(title, fontsize=TITLE_SIZE)
    legend(figure, min(len(columns), 3))
    return figure
