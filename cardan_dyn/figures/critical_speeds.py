"""Critical speeds: Campbell diagrams, maps over stiffness, orders over speed, stability charts.

All take plain arrays in SI units and draw speeds of rotation in 1/min and frequencies in Hz.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from ..kit.arrays import Array
from ..kit.checks import numbers
from ..kit.errors import ArgumentError, choices
from ..kit.quantities import span
from .orders import LEAST_SHOWN
from .style import (
    GUIDE,
    NAME,
    PER_MINUTE,
    Abscissa,
    Axes,
    Figure,
    Onto,
    abscissa,
    in_look,
    plain,
    point_style,
    rows_of,
    shaped,
    sheet,
    speeds,
    width_of,
)

_FILLS = {
    "instability": ("#e8b08f", "///"),
    "fold": ("#9db9dc", "..."),
    "combination": ("#a9cfae", "xxx"),
    "flutter": ("#cdb4d6", "\\\\\\"),
    "no motion": ("#d9d9d9", ""),
}
"""Colour and hatch of each kind of interval: hatches tell them apart in a black-and-white print."""


@in_look
def campbell(
    speed: ArrayLike,
    frequency: ArrayLike,
    *,
    orders: float | Sequence[float] = (1, 2, 4),
    whirl: ArrayLike | None = None,
    critical: ArrayLike | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw natural frequencies over the speed of rotation, with the lines of orders.

    Args:
        speed: of rotation `(S,)` [rad/s].
        frequency: natural frequencies `(S, n)` [rad/s]; nan or 0 where a mode does not swing.
        orders: n of the lines n·|Ω|, one or several.
        whirl: direction of each mode `(S, n)`: above zero forward, below backward, zero neither;
            the side that most of a mode is on names its line.
        critical: `(C, 2)` speeds and frequencies of critical speeds [rad/s], drawn as points.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match, or orders that are no numbers.
    """
    at = speeds(speed)
    modes = shaped("frequency", frequency, len(at.values), "m")
    sides = np.zeros(modes.shape) if whirl is None else shaped("whirl", whirl, *modes.shape)
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    swinging = np.where(modes > 0.0, modes, np.nan) / (2.0 * np.pi)
    names = [f"mode {index + 1}{_direction(side)}" for index, side in enumerate(sides.T)]
    at.draw(axes, dict(zip(names, swinging.T, strict=True)))
    fastest = float(at.values[np.argmax(np.abs(at.values))])
    multiples = np.atleast_1d(numbers("orders", orders)).ravel()
    # Beyond the line of the highest order nothing crosses: there only what is lowest is shown.
    reach = float(np.max(multiples, initial=0.0)) * abs(fastest) / 60.0
    tops = np.nanmax(swinging, axis=0, initial=0.0)
    lows = np.nanmin(swinging, axis=0, initial=np.inf)
    within = (lows <= reach) | (lows == np.min(lows, initial=np.inf))
    top = 1.15 * float(np.max(tops[within], initial=0.0))
    for order in multiples.tolist():
        axes.plot(at.values, order * np.abs(at.values) / 60.0, **GUIDE)
        # n× stands at the fast end of an order's line, where it leaves the figure.
        share = min(1.0, 60.0 * top / (order * abs(fastest) or np.inf))
        at_end = share * fastest, share * order * abs(fastest) / 60.0
        lean, inwards = ("right", -1) if fastest > 0.0 else ("left", 1)
        offset = {"xytext": (4 * inwards, -4), "textcoords": "offset points"}
        axes.annotate(f"{order:g}×", at_end, ha=lean, va="top", **offset, **NAME)
    if critical is not None:
        places = np.asarray(critical, dtype=float).reshape(-1, 2) * [PER_MINUTE, 0.5 / np.pi]
        style = {**point_style(0), "color": "black", "zorder": 3}
        axes.plot(*places.T, **style, label="critical speed")
    drawn.over(at)
    if top:
        axes.set_ylim(0.0, top)
    axes.set_ylabel("natural frequency [Hz]")
    unknown = np.isnan(modes).all(axis=1)
    gaps = np.isnan(swinging[~unknown])
    beyond = [
        f"{name} at {span(float(low), float(most), 'Hz')}"
        for name, low, most in zip(names, lows, tops, strict=True)
        if top < low < np.inf
    ]
    notes = [f"above, where no order crosses: {', '.join(beyond)}"] if beyond else []
    if np.any(gaps.any(axis=0) & ~gaps.all(axis=0)):
        notes.append("gaps in lines: there the mode does not swing, it creeps or grows")
    if unknown.any():
        notes.append("gaps in all lines: there no motion is known")
    return drawn.finish(columns=3, note="; ".join(notes))


@in_look
def critical_speed_map(
    stiffness: ArrayLike,
    speeds: Mapping[str, ArrayLike],
    *,
    operating: tuple[float, float] | None = None,
    label: str = "bearing stiffness [N/m]",
    **onto: Unpack[Onto],
) -> Figure:
    """Draw critical speeds over the stiffness of a support, both logarithmic.

    Args:
        stiffness: `(S,)`, greater than 0.
        speeds: of each curve by its name `(S,)` [rad/s]; inf or nan where there is none.
        operating: range of speeds of the machine [rad/s], drawn as a band.
        label: of the abscissa, with its unit.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    at = Abscissa(abscissa("stiffness", stiffness), label, "range")
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    lines = {name: np.asarray(values, dtype=float) for name, values in speeds.items()}
    at.draw(axes, {k: np.where(np.isfinite(v), v * PER_MINUTE, np.nan) for k, v in lines.items()})
    axes.loglog()
    if operating is not None:
        low, high = (end * PER_MINUTE for end in operating)
        axes.axhspan(low, high, color="0.9", zorder=0, label="operating range")
    drawn.over(at)
    axes.set_ylabel("critical speed [1/min]")
    return drawn.finish(columns=3)


@in_look
def orders_over_speed(
    speed: ArrayLike,
    amplitudes: Mapping[str, ArrayLike],
    *,
    unit: str,
    phases: Mapping[str, ArrayLike] | None = None,
    critical: Mapping[str, float] | None = None,
    peaks: Mapping[str, ArrayLike] | None = None,
    logarithmic: bool = True,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw amplitudes of orders over the speed of rotation, with their phases below.

    On a logarithmic scale, curves below a millionth of the greatest are left out as rounding.
    Points are drawn where a table of critical speeds has them, also beside the curves: where a
    resonance leans over, several motions belong to a speed, and curves show one of them.

    Args:
        speed: of rotation `(S,)` [rad/s].
        amplitudes: of each curve by its name `(S,)`.
        unit: of the amplitudes.
        phases: of curves with these names `(S,)` [rad].
        critical: names of critical speeds to where they are [rad/s].
        peaks: points by their names `(C, 2)`: speeds [rad/s] and amplitudes; of those beyond the
            speeds, none is drawn.
        logarithmic: amplitudes on a logarithmic scale.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: shapes that do not match.
    """
    at, given = speeds(speed), phases or {}
    drawn = sheet(2 if given else 1, share_x=True, **onto)
    above, below = drawn.panels[0], drawn.panels[-1]
    lines = {name: shaped(name, values, len(at.values)) for name, values in amplitudes.items()}
    sizes = {name: float(np.nanmax(np.abs(line), initial=0.0)) for name, line in lines.items()}
    greatest = max(sizes.values(), default=0.0)
    least = LEAST_SHOWN * greatest if logarithmic else 0.0
    kept = [name for name, size in sizes.items() if size >= least]
    for index, name in enumerate(kept):
        at.draw(above, {name: lines[name]}, index)
        if name in given:
            phase = np.unwrap(shaped(name, given[name], len(at.values)))
            at.draw(below, {name: np.rad2deg(phase)}, index, label="")
    places = {name: place * PER_MINUTE for name, place in (critical or {}).items()}
    # Axes fill about three quarters of a figure.
    inch = float(np.ptp(at.values) or 1.0) / (0.75 * drawn.figure.get_figwidth())
    ordered = sorted((place, name) for name, place in places.items())
    halves = [0.55 * inch * width_of(plain(name)) for _, name in ordered]
    rows = rows_of(
        (place - half, place + half) for (place, _), half in zip(ordered, halves, strict=True)
    )
    for (place, name), row in zip(ordered, rows, strict=True):
        for panel in drawn.panels:
            panel.axvline(place, **GUIDE, linestyle=":")
        offset = {"xytext": (0, 3 + 11 * row), "textcoords": "offset points"}
        at_top = {"xy": (place, 1.0), "xycoords": ("data", "axes fraction"), "ha": "center"}
        above.annotate(plain(name), **at_top, **offset, **NAME)
    for index, (name, points) in enumerate((peaks or {}).items()):
        found = np.asarray(points, dtype=float).reshape(-1, 2) * [PER_MINUTE, 1.0]
        found = found[(found[:, 0] >= np.min(at.values)) & (found[:, 0] <= np.max(at.values))]
        if len(found):
            style = {**point_style(index), "color": "black", "zorder": 3}
            above.plot(*found.T, **style, label=plain(name))
    if logarithmic and greatest:
        above.set_yscale("log")
        above.set_ylim(bottom=max(above.get_ylim()[0], least))
    above.set_ylabel(f"amplitude [{unit}]")
    if given:
        below.set_ylabel("phase [°]")
    drawn.over(at)
    return drawn.finish(columns=3)


@in_look
def stability_chart(
    angle: ArrayLike,
    intervals: Sequence[Sequence[tuple[float, float, str]]],
    *,
    ends: tuple[float, float],
    joint: str = "joint angle",
    slides: bool = False,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw where a mechanism is unstable over its speed and joint angle.

    Each interval is drawn half way to the angles beside its own, with its edges as lines, so that
    the narrowest is seen.

    Args:
        angle: joint angles `(B,)`, rising [rad], or positions of a slide [m].
        intervals: of each angle: least and greatest speed [rad/s], and its kind: `instability`,
            `fold`, `combination`, `flutter` or `no motion`.
        ends: of the speeds that were looked at [rad/s].
        joint: what the ordinate is called.
        slides: whether it is that of a slide.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: numbers of angles that do not match, or another kind.
    """
    angles = abscissa("angle", angle)
    if len(angles) < 2 or len(intervals) != len(angles):
        raise ArgumentError(
            f"a chart needs two angles, and intervals of each: {len(angles)} angles, "
            f"{len(intervals)} lists of intervals"
        )
    drawn = sheet(**onto)
    (axes,) = drawn.panels
    up = angles if slides else np.rad2deg(angles)
    between = np.concatenate([up[:1], 0.5 * (up[1:] + up[:-1]), up[-1:]])
    for low, high, row in zip(between[:-1], between[1:], intervals, strict=True):
        for lower, upper, kind in row:
            across = np.array([lower, upper]) * PER_MINUTE
            axes.fill_between(across, low, high, **interval_style(axes, kind))
            axes.vlines(across, low, high, color="0.25", linewidth=0.7)
    if not any(intervals):
        axes.text(0.5, 0.5, "stable everywhere", transform=axes.transAxes, ha="center", **NAME)
    axes.set_xlim(*speeds(ends).values)
    axes.set_ylim(up[0], up[-1])
    axes.grid(visible=False)
    axes.set(xlabel=speeds(ends).label, ylabel=f"{plain(joint)} [{'m' if slides else '°'}]")
    return drawn.finish(columns=4)


def interval_style(axes: Axes, kind: str) -> dict[str, Any]:
    """Return how an interval of a kind is filled, with its name if it is the first in the axes.

    Raises:
        ArgumentError: no such kind.
    """
    if kind not in _FILLS:
        raise ArgumentError(f"{kind!r} is no kind of interval; kinds: {choices(_FILLS, kind)}")
    color, hatch = _FILLS[kind]
    named = axes.get_legend_handles_labels()[1]
    look = {"facecolor": color, "edgecolor": "0.35", "hatch": hatch, "linewidth": 0.0}
    return {**look, "label": None if kind in named else kind}


def _direction(sides: Array) -> str:
    """Return how a mode whirls, for its name."""
    total = float(np.sum(np.sign(np.nan_to_num(sides))))
    return ", forward" if total > 0.0 else ", backward" if total < 0.0 else ""
