"""Columns: lines over anything, an axes per unit."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ..kit.arrays import Array
from .panels import Panel, stacked
from .style import Abscissa, Figure
from .wrenches import MARK

Column = tuple[Array, str]
"""Values `(N,)`, and their unit."""


def over_column(
    at: Abscissa,
    columns: Mapping[str, Column],
    *,
    ylabel: str = "",
    scales: Mapping[str, float] | None = None,
    marked: Collection[str] = (),
    **options: Any,
) -> Figure:
    """Draw columns over an abscissa; those of one unit share their axes, angles are in degrees.

    Args:
        at: the abscissa.
        columns: names to values and units.
        ylabel: of the ordinate, if all have one unit; the unit if empty.
        scales: units to sizes beside which values are rounding.
        marked: names of columns that are not determined by statics.
        options: of `stacked`.

    Raises:
        ArgumentError: other axes than are needed.
    """
    curves: dict[str, dict[str, Array]] = {}
    for name, (values, unit) in columns.items():
        if unit == "rad":
            values, unit = np.rad2deg(values), "°"
        told = f"{name}{MARK if name in marked else ''}"
        curves.setdefault("" if unit == "1" else unit, {})[told] = values
    own = ylabel if len(curves) == 1 else ""
    panels = [
        Panel(own or f"[{unit or '–'}]", unit, (scales or {}).get(unit, 0.0), drawn, {})
        for unit, drawn in curves.items()
    ]
    return stacked(at, panels, **options)
