"""Orders: the amplitudes of a quantity over its number of oscillations per revolution."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from ..kit.arrays import NOTHING, Array
from ..kit.errors import ArgumentError
from ..kit.periodic import amplitudes
from .style import Axes, Figure, Onto, in_look, line_style, plain, sheet

_HATCHES = ("", "///", "", "xx", "", "++")
"""Of bars beside each other: every other one is white behind its hatch."""
EVEN = 1e-6
"""By what fraction of the mean step the steps of angles may differ. Rounding is far below; uneven
steps would appear as amplitudes that the quantity does not have."""
LEAST_SHOWN = 1e-6
"""Least amplitude on a logarithmic scale, as a fraction of the greatest: rounding errors would
stretch the scale over ten more decades."""


def order_amplitudes(position: ArrayLike, values: ArrayLike) -> tuple[Array, Array]:
    """Return the Fourier amplitudes of a quantity over the orders of revolution.

    Of a force or moment that is a component in axes that stand still: its size has kinks, and so
    orders that no component has, and axes that turn shift orders by one.

    Args:
        position: `(N,)` angles [rad], evenly spaced over one or more whole turns; the end of the
            last turn may be among them or not.
        values: `(N,)` of any unit.

    Returns:
        Orders and amplitudes, each `(K,)`: order 2 oscillates twice per turn, its amplitude
        is half the distance from peak to peak [unit of `values`]. Order 0 is the absolute value
        of the mean.

    Raises:
        ArgumentError: the angles are not evenly spaced over whole turns.

    >>> phi = np.linspace(0.0, 2.0 * np.pi, 73)
    >>> orders, amplitudes = order_amplitudes(phi, 1.0 - 3.0 * np.sin(2.0 * phi))
    >>> orders[:4].tolist(), amplitudes[:4].round(12).tolist()
    ([0.0, 1.0, 2.0, 3.0], [1.0, 0.0, 3.0, 0.0])
    """
    angle, quantity = np.asarray(position, dtype=float), np.asarray(values, dtype=float)
    if angle.ndim != 1 or angle.shape != quantity.shape or len(angle) < 3:
        raise ArgumentError(
            f"orders need at least 3 angles and as many values, not {angle.shape} and "
            f"{quantity.shape}"
        )
    steps = np.diff(angle)
    step = float(np.mean(steps))
    if not (step > 0.0 and np.max(np.abs(steps - step)) < EVEN * step):
        raise ArgumentError("orders need angles that rise evenly")
    turns = (angle[-1] - angle[0]) / (2.0 * np.pi)
    if abs(turns - round(turns)) < NOTHING and round(turns):
        quantity = quantity[:-1]
    else:
        turns = len(angle) * step / (2.0 * np.pi)
        if abs(turns - round(turns)) > NOTHING or not round(turns):
            raise ArgumentError(f"orders need whole turns, the angles cover {turns:.6g}")
    sizes = np.abs(amplitudes(quantity))
    return np.arange(len(sizes)) / round(turns), sizes


@in_look
def order_spectrum(
    position: ArrayLike,
    values: Mapping[str, ArrayLike],
    *,
    unit: str,
    highest: int = 8,
    logarithmic: bool = False,
    note: str = "",
    **onto: Unpack[Onto],
) -> Figure:
    """Draw the amplitudes of quantities over the orders of revolution as bars.

    See `order_amplitudes` for what has orders, and `Sweep.plot.orders`, which takes care of that.

    Args:
        position: `(N,)` angles [rad], as in `order_amplitudes`.
        values: label to values `(N,)`.
        unit: of the values.
        highest: greatest order that is drawn.
        logarithmic: draw amplitudes to a logarithmic scale.
        note: on what is drawn.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: the angles are not evenly spaced over whole turns, or more than one axes.
    """
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    found, greatest = {}, 0.0
    for label, quantity in values.items():
        orders, sizes = order_amplitudes(position, quantity)
        shown = orders <= highest + NOTHING
        found[label] = sizes[shown]
        greatest = max(greatest, float(np.max(sizes[shown])))
        at = orders[shown]
    draw_bars(axes, at, found)
    axes.set_xlabel("order: swings per revolution of the input [–]")
    axes.set_ylabel(f"amplitude [{unit}]")
    axes.set_xticks(range(highest + 1))
    axes.grid(visible=False, axis="x")
    if logarithmic and greatest:
        axes.set_yscale("log")
        axes.set_ylim(bottom=LEAST_SHOWN * greatest)
    if not greatest:
        axes.set_ylim(0.0, 1.0)
    return drawn.finish(columns=3, note=note)


def draw_bars(axes: Axes, orders: ArrayLike, sizes: Mapping[str, Array]) -> None:
    """Draw amplitudes as bars, those of one order beside each other.

    Args:
        axes: to draw on.
        orders: `(K,)`.
        sizes: label to amplitudes `(K,)`.
    """
    # The rest keeps the orders apart.
    width = 0.8 / max(len(sizes), 1)
    for index, (label, heights) in enumerate(sizes.items()):
        color, hatch = line_style(index)["color"], _HATCHES[index % len(_HATCHES)]
        axes.bar(
            np.asarray(orders) + (index - 0.5 * (len(sizes) - 1)) * width,
            heights,
            width,
            label=plain(label),
            color="white" if hatch else color,
            edgecolor=color,
            hatch=hatch,
        )
