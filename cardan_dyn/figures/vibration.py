"""Vibration: free coordinates over a revolution, over their orbits and over a change of speed.

All take plain arrays in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from ..kit.arrays import NOTHING
from .critical_speeds import interval_style
from .style import (
    GUIDE,
    PER_MINUTE,
    Abscissa,
    Figure,
    Onto,
    abscissa,
    in_look,
    line_style,
    over,
    plain,
    point_style,
    shaped,
    sheet,
    speeds,
)


@in_look
def over_revolution(
    position: ArrayLike,
    values: ArrayLike,
    names: Sequence[str],
    *,
    unit: str = "rad, m",
    **onto: Unpack[Onto],
) -> Figure:
    """Draw coordinates over a revolution of the drive.

    Args:
        position: of the drive `(P,)` [rad].
        values: `(P, n)` [rad, or m of slides].
        names: of the coordinates, n.
        unit: of the coordinates.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = _positions(position)
    courses = shaped("values", values, len(at.values), len(names))
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    at.draw(axes, dict(zip(names, courses.T, strict=True)))
    drawn.over(at)
    axes.set_ylabel(f"free coordinates [{unit}]")
    return drawn.finish(columns=4)


@in_look
def coefficients(
    position: ArrayLike,
    matrices: Mapping[str, ArrayLike],
    names: Sequence[str],
    **onto: Unpack[Onto],
) -> Figure:
    """Draw the entries of matrices over the position of the drive, an axes for each matrix.

    Entries that are rounding beside the others of their matrix are left out.

    Args:
        position: of the drive `(N,)` [rad].
        matrices: by name, with its unit `(N, n, n)`.
        names: of the n coordinates.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            one axes for each matrix.

    Raises:
        ArgumentError: shapes that do not match, or another number of axes.
    """
    at, size = _positions(position), len(names)
    count = len(matrices)
    drawn = sheet(count, size=(7.2, 1.4 + 2.4 * count), share_x=True, **onto)
    for panel, (what, given) in zip(drawn.panels, matrices.items(), strict=True):
        values = shaped(what, given, len(at.values), size, size)
        least = NOTHING * float(np.max(np.abs(values), initial=0.0))
        for index, entry in enumerate(values.reshape(len(values), -1).T):
            if np.max(np.abs(entry)) > least:
                both = dict.fromkeys(names[place] for place in divmod(index, size))
                at.draw(panel, {", ".join(both): entry}, index)
        panel.set_ylabel(what)
    drawn.over(at)
    return drawn.finish(columns=3)


@in_look
def orbits(
    paths: Mapping[str, ArrayLike],
    *,
    labels: tuple[str, str],
    **onto: Unpack[Onto],
) -> Figure:
    """Draw paths of two transverse coordinates with equal scales; a dot marks where each begins.

    Args:
        paths: by name `(N, 2)`.
        labels: of both axes, with their units.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: a path is no curve in a plane.
    """
    drawn = sheet(size=(5.6, 5.6), **onto)
    (axes,) = drawn.panels
    for index, (name, given) in enumerate(paths.items()):
        path = shaped(name, given, "N", 2)
        axes.plot(path[:, 0], path[:, 1], **line_style(index), label=plain(name))
        axes.plot(*path[:1].T, **{**point_style(index), "marker": "o"})
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=5)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    return drawn.finish(columns=2)


@in_look
def run_up(
    speed: ArrayLike,
    values: ArrayLike,
    *,
    unit: str,
    predicted: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw a coordinate while the speed of rotation changes, beside what was predicted.

    Args:
        speed: of rotation at each sample `(N,)` [rad/s].
        values: of the coordinate `(N,)`.
        unit: of the coordinate.
        predicted: curves by name, as speeds `(S,)` [rad/s] and amplitudes `(S,)`; each is drawn
            to both sides.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = speeds(speed, "")
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    course = shaped("values", values, len(at.values))
    axes.plot(at.values, course, color="0.6", linewidth=0.7, label="simulated")
    for index, (name, (places, heights)) in enumerate((predicted or {}).items()):
        curve = speeds(places, "").draw(axes, {name: heights}, index)[0]
        axes.plot(curve.get_xdata(), -curve.get_ydata(), **line_style(index))
    drawn.over(at)
    axes.set_ylabel(f"free coordinate [{unit}]")
    return drawn.finish(columns=3)


@in_look
def torque_over_speed(
    speed: ArrayLike,
    torque: ArrayLike,
    *,
    available: ArrayLike | None = None,
    barriers: Sequence[tuple[float, float]] = (),
    held: float | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw the mean torque that motions absorb over speed, beside what a drive has.

    Args:
        speed: of rotation `(S,)` [rad/s].
        torque: absorbed `(S,)` [N·m].
        available: of the drive `(S,)`, if it is driven by a torque.
        barriers: speeds and torques of resonances, each marked.
        held: speed at which the drive stays, if it does.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = speeds(speed, "")
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    at.draw(axes, {"absorbed": shaped("torque", torque, len(at.values))})
    if available is not None:
        at.draw(axes, {"of the drive": shaped("available", available, len(at.values))}, 1)
    for index, (place, height) in enumerate(barriers):
        label = "" if index else "barrier"
        axes.plot(place * PER_MINUTE, height, **point_style(2), label=label or None)
    if held is not None:
        axes.axvline(held * PER_MINUTE, **GUIDE, linestyle=":", label="held")
    drawn.over(at)
    axes.set_ylabel("mean torque [N·m]")
    return drawn.finish(columns=4)


@in_look
def multipliers(
    speed: ArrayLike,
    sizes: ArrayLike,
    *,
    intervals: Sequence[tuple[float, float, str]] = (),
    **onto: Unpack[Onto],
) -> Figure:
    """Draw the sizes of Floquet multipliers over the speed of rotation; above 1, motions grow.

    Args:
        speed: of rotation `(S,)` [rad/s].
        sizes: `(S, m)`.
        intervals: least and greatest speed of instabilities [rad/s], and their kinds, as
            `stability_chart` has them: narrow ones lie between two of the speeds.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = speeds(speed)
    every = shaped("sizes", sizes, len(at.values), "m")
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    at.draw(axes, {f"multiplier {index}": size for index, size in enumerate(every.T, 1)})
    for lower, upper, kind in intervals:
        across = np.array([lower, upper]) * PER_MINUTE
        axes.axvspan(*across, zorder=0, **interval_style(axes, kind))
        for edge in across.tolist():
            axes.axvline(edge, color="0.25", linewidth=0.7)
    axes.axhline(1.0, **GUIDE, linestyle=":")
    drawn.over(at)
    axes.set_ylabel("size of multipliers")
    return drawn.finish(columns=4)


def _positions(position: ArrayLike) -> Abscissa:
    return over("position of the drive", abscissa("position", position), "rad")
