"""Compared: results as points over closed forms as lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from .style import POINTS, Abscissa, Figure, Onto, in_look, point_style, sheet, thinned

INPUT_LABEL = "rotation of the input shaft φ₁ [°]"


@in_look
def compared(
    position: ArrayLike,
    computed: Mapping[str, ArrayLike],
    closed: Mapping[str, ArrayLike],
    *,
    quantity: str,
    over: str = INPUT_LABEL,
    points: int = POINTS,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw results as points over closed forms as lines.

    Args:
        position: `(N,)` angles [rad], the abscissa of all values.
        computed: label to computed values `(N,)`, drawn as points.
        closed: label to values of a formula `(N,)`, drawn as lines. A label that both have is
            drawn in one colour.
        quantity: label of the ordinate, with its unit.
        over: label of the abscissa, with its unit.
        points: about how many points are drawn of each result.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: more than one axes.
    """
    at = Abscissa(np.rad2deg(np.asarray(position, dtype=float)), over, "angle")
    shown = thinned(len(at.values), points)
    indices = {label: index for index, label in enumerate({**computed, **closed})}
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    for label, values in closed.items():
        name = f"{label}, closed form" if label in computed else label
        at.draw(axes, {name: values}, indices[label], label=name)
    for label, values in computed.items():
        style = {**point_style(indices[label]), "label": f"{label}, Pinocchio"}
        axes.plot(at.values[shown], np.asarray(values)[shown], **style)
    drawn.over(at)
    axes.set_ylabel(quantity)
    return drawn.finish(columns=3 if len(computed) + len(closed) > 6 else 2)
