"""Vibration: free coordinates over a revolution, over their orbits and over a change of speed.

All take plain arrays in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..kit.arrays import NOTHING
from ..kit.errors import ArgumentError
from .critical_speeds import interval_style
from .style import (
    PER_MINUTE,
    SPEED,
    Figure,
    Into,
    Size,
    abscissa,
    angle_axis,
    curve_style,
    in_look,
    line_style,
    ordinate,
    ordinates,
    plain,
    point_style,
    sheet,
)


@in_look
def over_revolution(
    position: ArrayLike,
    values: ArrayLike,
    names: Sequence[str],
    *,
    unit: str = "rad, m",
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw coordinates over a revolution of the drive.

    Args:
        position: of the drive `(P,)` [rad].
        values: `(P, n)` [rad, or m of slides].
        names: of the coordinates, n.
        unit: of the coordinates.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = abscissa("position", position)
    courses = ordinates("values", values, at, len(names))
    drawn = sheet(ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    for index, name in enumerate(names):
        axes.plot(
            np.rad2deg(at), courses[:, index], **curve_style(index, len(at)), label=plain(name)
        )
    angle_axis(axes, "position of the drive [°]", at)
    axes.set_ylabel(f"free coordinates [{unit}]")
    return drawn.finish(title, 4)


@in_look
def coefficients(
    position: ArrayLike,
    matrices: Mapping[str, ArrayLike],
    names: Sequence[str],
    *,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the entries of matrices over the position of the drive, an axes for each matrix.

    Entries that are rounding beside the others of their matrix are left out.

    Args:
        position: of the drive `(N,)` [rad].
        matrices: by name, with its unit `(N, n, n)`.
        names: of the n coordinates.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure, one for each matrix.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: shapes that do not match, or another number of axes.
    """
    at, size = abscissa("position", position), len(names)
    count = len(matrices)
    drawn = sheet(count, size=(7.2, 1.4 + 2.4 * count), share_x=True, ax=ax, figsize=figsize)
    panels = drawn.panels
    for panel, (what, given) in zip(panels, matrices.items(), strict=True):
        values = np.asarray(given, dtype=float)
        if values.shape != (len(at), size, size):
            raise ArgumentError(
                f"{what} has shape {values.shape}, expected {(len(at), size, size)}"
            )
        least = NOTHING * float(np.max(np.abs(values), initial=0.0))
        for index in range(size * size):
            row, column = divmod(index, size)
            if np.max(np.abs(values[:, row, column])) <= least:
                continue
            entry = names[row] if row == column else f"{names[row]}, {names[column]}"
            style = curve_style(index, len(at))
            panel.plot(np.rad2deg(at), values[:, row, column], **style, label=plain(entry))
        panel.set_ylabel(what)
    angle_axis(panels[-1], "position of the drive [°]", at)
    return drawn.finish(title, 3)


@in_look
def orbits(
    paths: Mapping[str, ArrayLike],
    *,
    labels: tuple[str, str],
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw paths of two transverse coordinates with equal scales; a dot marks where each begins.

    Args:
        paths: by name `(N, 2)`.
        labels: of both axes, with their units.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: a path is no curve in a plane.
    """
    drawn = sheet(size=(5.6, 5.6), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    for index, (name, given) in enumerate(paths.items()):
        path = np.asarray(given, dtype=float)
        if path.ndim != 2 or path.shape[1] != 2 or not len(path):
            raise ArgumentError(f"path {name!r} has shape {path.shape}, expected (N, 2)")
        axes.plot(path[:, 0], path[:, 1], **line_style(index), label=plain(name))
        axes.plot(*path[:1].T, **{**point_style(index), "marker": "o"})
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=5)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    return drawn.finish(title, 2)


@in_look
def run_up(
    speed: ArrayLike,
    values: ArrayLike,
    *,
    unit: str,
    predicted: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw a coordinate while the speed of rotation changes, beside what was predicted.

    Args:
        speed: of rotation at each sample `(N,)` [rad/s].
        values: of the coordinate `(N,)`.
        unit: of the coordinate.
        predicted: curves by name, as speeds `(S,)` [rad/s] and amplitudes `(S,)`; each is drawn
            to both sides.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = np.asarray(speed, dtype=float)
    course = ordinate("values", values, at)
    drawn = sheet(ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    axes.plot(at * PER_MINUTE, course, color="0.6", linewidth=0.7, label="simulated")
    for index, (name, (places, heights)) in enumerate((predicted or {}).items()):
        speeds = np.asarray(places, dtype=float)
        height = ordinate(name, heights, speeds)
        for sign, text in ((1.0, name), (-1.0, None)):
            axes.plot(speeds * PER_MINUTE, sign * height, **line_style(index), label=text)
    axes.set(xlabel=SPEED, ylabel=f"free coordinate [{unit}]")
    return drawn.finish(title, 3)


@in_look
def torque_over_speed(
    speed: ArrayLike,
    torque: ArrayLike,
    *,
    available: ArrayLike | None = None,
    barriers: Sequence[tuple[float, float]] = (),
    held: float | None = None,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the mean torque that motions absorb over speed, beside what a drive has.

    Args:
        speed: of rotation `(S,)` [rad/s].
        torque: absorbed `(S,)` [N·m].
        available: of the drive `(S,)`, if it is driven by a torque.
        barriers: speeds and torques of resonances, each marked.
        held: speed at which the drive stays, if it does.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = np.asarray(speed, dtype=float)
    drawn = sheet(ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    axes.plot(at * PER_MINUTE, ordinate("torque", torque, at), **line_style(0), label="absorbed")
    if available is not None:
        given = ordinate("available", available, at)
        axes.plot(at * PER_MINUTE, given, **line_style(1), label="of the drive")
    for index, (place, height) in enumerate(barriers):
        label = "" if index else "barrier"
        axes.plot(place * PER_MINUTE, height, **point_style(2), label=label or None)
    if held is not None:
        axes.axvline(held * PER_MINUTE, color="0.55", linewidth=0.9, linestyle=":", label="held")
    axes.set_xlabel("speed [1/min]")
    axes.set_ylabel("mean torque [N·m]")
    return drawn.finish(title, 4)


@in_look
def multipliers(
    speed: ArrayLike,
    sizes: ArrayLike,
    *,
    intervals: Sequence[tuple[float, float, str]] = (),
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the sizes of Floquet multipliers over the speed of rotation; above 1, motions grow.

    Args:
        speed: of rotation `(S,)` [rad/s].
        sizes: `(S, m)`.
        intervals: least and greatest speed of instabilities [rad/s], and their kinds, as
            `stability_chart` has them: narrow ones lie between two of the speeds.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = abscissa("speed", speed)
    every = ordinates("sizes", sizes, at)
    drawn = sheet(ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    for index in range(every.shape[1]):
        style = curve_style(index, len(at))
        axes.plot(at * PER_MINUTE, every[:, index], **style, label=f"multiplier {index + 1}")
    for lower, upper, kind in intervals:
        across = np.array([lower, upper]) * PER_MINUTE
        axes.axvspan(*across, zorder=0, **interval_style(axes, kind))
        for edge in across.tolist():
            axes.axvline(edge, color="0.25", linewidth=0.7)
    axes.axhline(1.0, color="0.55", linewidth=0.9, linestyle=":")
    axes.set(xlabel=SPEED, ylabel="size of multipliers")
    return drawn.finish(title, 4)
