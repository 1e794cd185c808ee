"""Compared: results as points over closed forms as lines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from .style import (
    POINTS,
    Abscissa,
    Figure,
    Into,
    Size,
    in_look,
    point_style,
    sheet,
    thinned,
)

INPUT_LABEL = "rotation of the input shaft φ₁ [°]"


@in_look
def compared(
    position: ArrayLike,
    computed: Mapping[str, ArrayLike],
    closed: Mapping[str, ArrayLike],
    *,
    quantity: str,
    title: str = "",
    over: str = INPUT_LABEL,
    points: int = POINTS,
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw results as points over closed forms as lines.

    Args:
        position: `(N,)` angles [rad], the abscissa of all values.
        computed: label to computed values `(N,)`, drawn as points.
        closed: label to values of a formula `(N,)`, drawn as lines. A label that both have is
            drawn in one colour.
        quantity: label of the ordinate, with its unit.
        title: of the figure.
        over: label of the abscissa, with its unit.
        points: about how many points are drawn of each result.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: more than one axes.
    """
    at = Abscissa(np.rad2deg(np.asarray(position, dtype=float)), over, "angle")
    shown = thinned(len(at.values), points)
    indices = {label: index for index, label in enumerate({**computed, **closed})}
    drawn = sheet(ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    for label, values in closed.items():
        name = f"{label}, closed form" if label in computed else label
        at.draw(axes, {name: values}, indices[label], label=name)
    for label, values in computed.items():
        style = {**point_style(indices[label]), "label": f"{label}, Pinocchio"}
        axes.plot(at.values[shown], np.asarray(values)[shown], **style)
    drawn.over(at)
    axes.set_ylabel(quantity)
    return drawn.finish(title, 3 if len(computed) + len(closed) > 6 else 2)
