"""Designs: results over two parameters or many, as maps, contours, bars, points and lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from ..kit.arrays import Array
from ..kit.errors import ArgumentError
from ..kit.quantities import amount, column, prefix, unit_of
from .style import (
    SMALL,
    Figure,
    Onto,
    abscissa,
    in_look,
    line_style,
    plain,
    shaped,
    sheet,
    shorten,
    wrapped,
)

_COLOURS = "cividis"
"""A scale of colours that is even in grey as well."""
_MISSING = "0.8"
"""Colour of cells without a value."""


@in_look
def value_map(
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    *,
    labels: tuple[str, str, str],
    limit: float | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw a result over two parameters, a coloured cell for each of their values.

    Args:
        x: parameter along the abscissa `(N,)`, rising.
        y: parameter along the ordinate `(M,)`, rising.
        values: `(N, M)`; nan where there is none, which is grey.
        labels: of x, y and the values, with units.
        limit: value along which a line is drawn.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    across, up, cells = _over_two(x, y, values)
    onto["title"] = _joined(onto.get("title", ""), _limit_in_words(cells, limit, labels[2]))
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    axes.set_facecolor(_MISSING)
    cells_drawn = axes.pcolormesh(across, up, cells.T, shading="nearest", cmap=_COLOURS)
    shorten(drawn.figure.colorbar(cells_drawn, ax=axes, label=labels[2]).ax)
    _name_missing(axes, cells)
    _draw_limit(axes, across, up, cells, limit)
    axes.grid(visible=False)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    return drawn.finish()


@in_look
def contour_map(
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    *,
    labels: tuple[str, str, str],
    limit: float | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw lines of equal values over two parameters, with their numbers.

    Args:
        x: parameter along the abscissa `(N,)`, rising, two values at least.
        y: parameter along the ordinate `(M,)`, likewise.
        values: `(N, M)`; nan where there is none.
        labels: of x, y and the values, with units; the latter is written above.
        limit: value along which a thick line is drawn; the side beyond it is hatched.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match, or no finite value.
    """
    across, up, cells = _over_two(x, y, values)
    if min(cells.shape) < 2 or not np.any(np.isfinite(cells)):
        raise ArgumentError(f"contours need values over two by two points, not {cells.shape}")
    words, unit = unit_of(labels[2])
    scale, shown = prefix(float(np.nanmax(np.abs(cells))), unit)
    words = f"{words} [{shown}]" if unit else words
    told = words, onto.get("title", ""), _limit_in_words(cells, limit, labels[2])
    onto["title"] = _joined(*told)
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    if np.ptp(cells[np.isfinite(cells)]) > 0.0:
        color = line_style(0)["color"]
        lines = axes.contour(across, up, cells.T / scale, levels=12, colors=color, linewidths=0.9)
        axes.clabel(lines, fontsize=8)
    _draw_limit(axes, across, up, cells, limit, hatched=True)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    if not np.all(np.isfinite(cells)):
        from matplotlib.colors import ListedColormap

        missing = np.where(np.isfinite(cells), np.nan, 0.0)
        grey = ListedColormap([_MISSING])
        axes.pcolormesh(across, up, missing.T, shading="nearest", cmap=grey, zorder=0)
        axes.grid(visible=False)
    _name_missing(axes, cells)
    return drawn.finish()


def _joined(*parts: str) -> str:
    return ", ".join(part for part in parts if part)


def _name_missing(axes: Any, cells: Array) -> None:
    """Say in the legend that grey is what has no value."""
    if missing := int(np.count_nonzero(~np.isfinite(cells))):
        label = f"no result: {missing} of {cells.size}"
        axes.fill([], [], facecolor=_MISSING, edgecolor="0.5", label=label)


def _limit_in_words(cells: Array, limit: float | None, label: str) -> str:
    """Return a limit in the unit of a label, and whether nothing or everything exceeds it."""
    finite = cells[np.isfinite(cells)]
    if limit is None or not finite.size:
        return ""
    beyond = finite > limit
    where = " exceeded everywhere" if beyond.all() else "" if beyond.any() else " nowhere exceeded"
    known = " where there is a result" if where and finite.size < cells.size else ""
    return f"limit {amount(limit, unit_of(label)[1])}{where}{known}"


def _draw_limit(
    axes: Any, across: Array, up: Array, cells: Array, limit: float | None, hatched: bool = False
) -> None:
    """Draw a line where values reach a limit, if any does."""
    finite = cells[np.isfinite(cells)]
    if limit is None or min(cells.shape) < 2 or not finite.size:
        return
    low, high = float(finite.min()), float(finite.max())
    if low < limit <= high:
        color = line_style(1)["color"]
        axes.contour(across, up, cells.T, levels=[limit], colors=color, linewidths=2.2)
    if hatched and limit < high:
        axes.contourf(across, up, cells.T, levels=[limit, high], colors="none", hatches=["///"])


def _over_two(x: ArrayLike, y: ArrayLike, values: ArrayLike) -> tuple[Array, Array, Array]:
    across, up = abscissa("x", x), abscissa("y", y)
    cells = shaped("values", values, len(across), len(up))
    order, upwards = np.argsort(across), np.argsort(up)
    return across[order], up[upwards], cells[np.ix_(order, upwards)]


@in_look
def tornado(
    ranges: Mapping[str, ArrayLike],
    *,
    middle: float,
    label: str,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw what a result is at the ends of each parameter, and between them, the widest on top.

    Args:
        ranges: names of parameters to the result from their lower to their upper end `(N,)`; nan
            where there is none.
        middle: the result between them.
        label: of the result, with its unit.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: there is no parameter.
    """
    if not ranges:
        raise ArgumentError("a tornado diagram needs a parameter at least")
    along = {name: np.asarray(values, dtype=float) for name, values in ranges.items()}
    spans = {name: (np.nanmin(values), np.nanmax(values)) for name, values in along.items()}
    order = sorted(ranges, key=lambda name: np.ptp(spans[name]))
    drawn = sheet(size=(7.2, 1.6 + 0.42 * len(order)), **onto)
    (axes,) = drawn.panels
    names = [*map(plain, order)]
    for end, (name, hatch) in enumerate((("lower end", ""), ("upper end", "///"))):
        widths = [along[parameter][-end] - middle for parameter in order]
        color = line_style(end)["color"]
        style = {"facecolor": color if not hatch else "white", "edgecolor": color}
        axes.barh(names, widths, left=middle, height=0.6, hatch=hatch, label=name, **style)
    for name, parameter in zip(names, order, strict=True):
        lost = [
            end for end, place in (("lower", 0), ("upper", -1)) if np.isnan(along[parameter][place])
        ]
        if lost:
            text = f"no result at the {' and '.join(lost)} end"
            beside = {"xytext": (4, 0), "textcoords": "offset points", "va": "center"}
            axes.annotate(text, (middle, name), fontsize=SMALL, **beside)
    axes.hlines(names, *np.transpose([spans[name] for name in order]), color="black", linewidth=1.6)
    axes.axvline(middle, color="black", linewidth=0.9)
    axes.grid(visible=False, axis="y")
    axes.set(xlabel=label)
    return drawn.finish()


@in_look
def scatter(
    parameters: Mapping[str, ArrayLike],
    values: ArrayLike,
    *,
    label: str,
    limit: float | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw a result over each parameter, a point for each sample.

    Args:
        parameters: their names, with units, to values `(N,)`.
        values: of the result `(N,)`.
        label: of the result, with its unit.
        limit: value at which a line is drawn.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: there is no parameter, or shapes do not match.
    """
    if not parameters:
        raise ArgumentError("a scatter diagram needs a parameter at least")
    columns = min(len(parameters), 3)
    rows = -(-len(parameters) // columns)
    drawn = sheet(
        rows,
        columns,
        count=len(parameters),
        size=(1.2 + 2.6 * columns, 0.6 + 2.6 * rows),
        **onto,
    )
    panels = drawn.panels
    for index, (name, given) in enumerate(parameters.items()):
        at = abscissa(name, given)
        panels[index].plot(
            at, shaped(label, values, len(at)), ".", markersize=3, color=line_style(0)["color"]
        )
        panels[index].set_xlabel(wrapped(plain(name), drawn.figure.get_figwidth() / columns - 0.4))
        panels[index].locator_params(axis="x", nbins=3)  # More of them run into each other.
        _, unit = unit_of(name)
        if prefix(float(np.max(np.abs(at))), unit) == (1.0, unit):
            # A common power of ten at the end of the axis would stand on its label.
            panels[index].xaxis.set_major_formatter("{x:.3g}")
        if limit is not None:
            panels[index].axhline(limit, color=line_style(1)["color"], linewidth=1.2)
        if index % columns == 0:
            panels[index].set_ylabel(label)
        elif drawn.is_new:
            panels[index].sharey(panels[index - 1])
            panels[index].tick_params(labelleft=False)
    return drawn.finish()


@in_look
def parallel_coordinates(
    columns: Mapping[str, ArrayLike],
    *,
    limit: float | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw each case as a line over all parameters and results, the last of which colours it.

    Args:
        columns: names, with units, to values `(N,)`; two at least.
        limit: value of the last column beyond which a line is drawn dashed.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: fewer than two columns, or shapes that do not match.
    """
    names = list(columns)
    if len(names) < 2:
        raise ArgumentError("parallel coordinates need two columns at least")
    count = np.size(columns[names[0]])
    table = np.stack([shaped(name, columns[name], count) for name in names], axis=1)
    table = table[np.all(np.isfinite(table), axis=1)]
    if not len(table):
        raise ArgumentError("no case has numbers in all columns")
    low, span = table.min(axis=0), np.ptp(table, axis=0)
    scaled = np.where(span > 0.0, (table - low) / np.where(span > 0.0, span, 1.0), 0.5)
    drawn = sheet(size=(1.8 + 1.5 * len(names), 4.8), **onto)
    (axes,) = drawn.panels
    import matplotlib

    colours = matplotlib.colormaps[_COLOURS](scaled[:, -1])
    alpha = float(np.clip(30.0 / len(table), 0.05, 1.0))
    for index in np.argsort(table[:, -1]):
        beyond = limit is not None and table[index, -1] > limit
        axes.plot(
            scaled[index],
            color=colours[index],
            alpha=alpha,
            linewidth=1.0,
            linestyle="--" if beyond else "-",
        )
    labels = []
    for place, (name, least, most) in enumerate(zip(names, low, low + span, strict=True)):
        axes.axvline(place, color="0.35", linewidth=0.9)
        words, unit = unit_of(name)
        ends, unit = column([least, most], unit)
        labels.append(f"{words} [{unit}]" if unit else name)
        for height, text, side in ((0.0, ends[0], "top"), (1.0, ends[1], "bottom")):
            axes.text(place, height, text, ha="center", va=side, fontsize=SMALL)
    width = (drawn.figure.get_figwidth() - 0.6) / len(names)
    axes.set_xticks(range(len(names)), [wrapped(plain(label), width) for label in labels])
    axes.set_yticks([])
    axes.set_ylim(-0.08, 1.08)
    axes.grid(visible=False)
    axes.spines["left"].set_visible(False)
    words, unit = unit_of(names[-1])
    note = f"a line is a case; dark where {plain(words)} is small, bright where it is great"
    note += f", dashed beyond {amount(limit, unit)}" if limit is not None else ""
    return drawn.finish(note=note)
