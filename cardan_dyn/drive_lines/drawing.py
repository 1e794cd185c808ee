"""Drawing: a line in both its views, what an analysis of it found, and the catalogue's diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError
from ..figures.style import (
    Axes,
    Figure,
    Into,
    Size,
    angle_axis,
    curve_style,
    in_look,
    line_style,
    sheet,
    wrapped,
)

if TYPE_CHECKING:
    from .line.data import LineData

_SIZE = (8.4, 6.0)
_STUB = 0.22
"""Length of an end shaft that has none, relative to all intermediate shafts."""
_ROOM = 0.06
"""Room around the line, relative to its length."""
_FLATTEST = 0.04
"""Least height of a view, relative to the line's length."""
_FIRST, _ROW = 0.12, 0.38
"""Distance of the first row of labels from the line, and height of a row, relative to the height of
the line in its view."""
_LETTER, _FILLED = 0.6, 0.82
"""Mean width of a letter in font sizes, and part of a figure's width that its axes fill."""
_SMALL = 8


@in_look
def arrangement(
    line: LineData, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw a line at rest, seen from its right side and from above.

    Across the line the scale is larger than along it. Joints are circles with their joint angles β,
    and with their bends in this view; bearings are triangles; intermediate shafts are told with
    their fork offsets.

    Args:
        line: the line.
        title: of the figure; the name of the line unless given.
        ax: two axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: other than two axes.
    """
    points = line_points(line)
    drawn = sheet(2, size=_SIZE, share_x=True, ax=ax, figsize=figsize)
    height = max(
        float(np.ptp(points[:, 1:], axis=0).max()), _FLATTEST * float(np.ptp(points[:, 0]))
    )
    for panel, axis, label in zip(
        drawn.panels, (2, 1), ("up, side view [m]", "left, plan view [m]"), strict=True
    ):
        _view(panel, line, points[:, [0, axis]], axis, height)
        panel.set_ylabel(label)
    drawn.panels[-1].set_xlabel("forward [m]")
    return drawn.finish(title or line.name)


def line_points(line: LineData) -> Array:
    """Return the ends of all shafts `(n + 2, 3)` [m]: both ends of the line and the joints between.

    An end shaft goes on to its farthest bearing, or by a stub.
    """
    found = line.geometry
    inner = found.lengths[1:-1]
    stub = _STUB * float(inner.sum()) if inner.size else 1.0
    ends = []
    for end in (0, -1):
        length = float(found.lengths[end])
        places = [item.distance for item in line.shafts[end].bearings]
        ends.append(length if np.isfinite(length) else 1.15 * max(places, default=stub / 1.15))
    first = found.centres[0] - ends[0] * found.directions[0]
    last = found.centres[-1] + ends[1] * found.directions[-1]
    return np.vstack([first, found.centres, last])


def _view(panel: Axes, line: LineData, points: Array, axis: int, height: float) -> None:
    """Draw one view: points `(n + 2, 2)`, in axes as high as the line and its labels."""
    length = float(np.ptp(points[:, 0]))
    middle = 0.5 * float(points[:, 1].min() + points[:, 1].max())
    shafts = []
    for k, name in enumerate(line.shaft_names):
        style = line_style(k)
        panel.plot(*points[k : k + 2].T, linewidth=3.0, color=style["color"], zorder=2)
        offset = "" if k in (0, line.count) else f"\nfork {_degrees(line.fork_offsets[k - 1])}"
        shafts.append((points[k : k + 2].mean(axis=0), name + offset, style["color"]))
    views = line.geometry.views[:, 1 if axis == 2 else 0]
    joints = []
    for k, centre in enumerate(points[1:-1]):
        panel.plot(*centre, "o", markersize=9, mfc="white", mec="black", zorder=3)
        text = f"β{k + 1} = {_degrees(line.joint_angles[k])}\nhere {_degrees(views[k])}"
        joints.append((centre, text, "black"))
    places = _bearings(line)[:, [0, axis]]
    panel.plot(*places.T, "^", markersize=8, color="0.25", zorder=3)
    panel.set_xlim(points[0, 0] - _ROOM * length, points[-1, 0] + _ROOM * length)
    low, high = middle - 0.5 * height, middle + 0.5 * height
    above, below = (
        _in_rows(panel, items, side, (low, high), (1.0 + 2.0 * _ROOM) * length)
        for items, side in ((joints, 1.0), (shafts, -1.0))
    )
    panel.set_ylim(low - below * height, high + above * height)
    panel.set_aspect("auto")


def _in_rows(
    panel: Axes,
    items: list[tuple[Array, str, Any]],
    side: float,
    ends: tuple[float, float],
    length: float,
) -> float:
    """Write labels above (`side` 1) or below a line, in rows in which none covers another one.

    Returns:
        Height of all rows, relative to that of the line.
    """
    height = ends[1] - ends[0]
    letter = _LETTER * _SMALL / (72.0 * _FILLED * float(panel.figure.get_figwidth())) * length
    filled: list[float] = []
    for point, text, color in sorted(items, key=lambda item: float(item[0][0])):
        half = 0.5 * letter * max(map(len, text.split("\n")))
        start = float(point[0]) - half
        row = next((row for row, end in enumerate(filled) if end <= start), len(filled))
        filled[row : row + 1] = [start + 2.0 * half + letter]
        foot = ends[1] if side > 0.0 else ends[0]
        at = foot + side * (_FIRST + _ROW * row) * height
        panel.annotate(
            text,
            point,
            xytext=(point[0], at),
            ha="center",
            va="bottom" if side > 0.0 else "top",
            fontsize=_SMALL,
            color=color,
            arrowprops={"arrowstyle": "-", "color": "0.75", "linewidth": 0.7, "shrinkA": 1},
            zorder=1,
        )
    return _FIRST + _ROW * max(len(filled), 1)


def _bearings(line: LineData) -> Array:
    """Return the places of all bearings `(m, 3)` [m]."""
    found = line.geometry
    places = np.zeros((0, 3))
    for k, shaft in enumerate(line.shafts):
        for item in shaft.bearings:
            along = -item.distance if k == 0 else item.distance
            place = found.centres[max(k - 1, 0)] + along * found.directions[k]
            places = np.vstack([places, place])
    return places


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.2f}°".replace("-0.00", "0.00")


@in_look
def over_angle(
    analysis: Any, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw what an analysis of a drive line found over the rotation of the input shaft.

    From above: the angle error of every shaft behind a joint, its speed ratio, the bending moments
    before and behind each joint, and the bearings' forces across their shafts, with inertia
    and weight.

    Args:
        analysis: without variants.
        title: of the figure; the name of the line unless given.
        ax: four axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: the analysis is of many designs, or other than four axes.
    """
    if len(analysis.shape) != 1:
        raise ArgumentError("the analysis is of many designs, expected one of a single line")
    angle, forces = np.rad2deg(analysis.position), analysis.total
    panels: list[tuple[str, list[tuple[str, Array]]]] = [
        ("angle error [°]", _columns(analysis.shafts, np.rad2deg(analysis.angle_error), first=1)),
        ("speed ratio [–]", _columns(analysis.shafts, analysis.ratio, first=1)),
        (
            "bending [N·m]",
            [
                *_columns([f"before {name}" for name in analysis.joints], forces.bending_in),
                *_columns([f"behind {name}" for name in analysis.joints], forces.bending_out),
            ],
        ),
        ("bearing force [N]", _columns(analysis.bearings, forces.bearing_radial)),
    ]
    drawn = sheet(len(panels), size=(7.6, 9.6), share_x=True, ax=ax, figsize=figsize)
    for panel, (label, curves) in zip(drawn.panels, panels, strict=True):
        for index, (name, values) in enumerate(curves):
            panel.plot(angle, values, **curve_style(index, len(angle)), label=name)
        panel.set_ylabel(label)
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.legend(fontsize=_SMALL, loc="center left", bbox_to_anchor=(1.0, 0.5))
    angle_axis(drawn.panels[-1], "rotation of the input shaft [°]", analysis.position)
    opened = "; ".join(analysis.indeterminate)
    note = f"forces of bearings are not all determined by statics: {opened}" if opened else ""
    return drawn.finish(title or analysis.name, 0, note)


def _columns(
    names: tuple[str, ...] | list[str], values: Array, first: int = 0
) -> list[tuple[str, Array]]:
    return [(name, values[:, index]) for index, name in enumerate(names) if index >= first]


_MOST_ROOM = 100.0
"""Room to a limit that bars show at most [%]: what is further from its limit is not looked at."""
_BAR = 0.32
"""Height of the figure per bar [inch]."""


@in_look
def margins(
    verdict: Any, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw how much room the values of a verdict have to their limits, the least on top.

    Bars to the left, which are hatched, miss their limits. Bars end at 100 %; the number says how
    far they go.

    Args:
        verdict: of a line.
        title: of the figure; the name of the line and the counts of its rows unless given.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: no row has a limit and a value, or more than one axes.
    """
    rows = sorted((row for row in verdict.rows if row.margin is not None), key=lambda r: r.margin)
    if not rows:
        raise ArgumentError("no row of the verdict has a value and a limit, so that none has room")
    drawn = sheet(size=(8.4, 1.6 + _BAR * len(rows)), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    for place, row in enumerate(rows):
        percent = 100.0 * float(row.margin)
        missed = percent < 0.0
        color = line_style(1 if missed else 0)["color"]
        length = float(np.clip(percent, -_MOST_ROOM, _MOST_ROOM))
        look = {"facecolor": "white" if missed else color, "hatch": "///" if missed else ""}
        axes.barh(place, length, 0.6, edgecolor=color, **look)
        axes.annotate(
            f"{percent:+.0f} %",
            (length, place),
            (-4 if missed else 4, 0),
            textcoords="offset points",
            ha="right" if missed else "left",
            va="center",
            fontsize=_SMALL,
        )
    names = [f"{row.quantity}, {row.where}" if row.where else row.quantity for row in rows]
    axes.set_yticks(range(len(rows)), [wrapped(name, 3.2, _SMALL) for name in names])
    axes.tick_params(axis="y", labelsize=_SMALL)
    axes.axvline(0.0, color="black", linewidth=0.9)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    least = min(0.0, 100.0 * float(rows[0].margin))
    axes.set_xlim(max(least, -_MOST_ROOM) - 22.0 * (least < 0.0), _MOST_ROOM + 22.0)
    axes.set_xlabel("room to the limit, as a part of it [%]")
    axes.grid(visible=False, axis="y")
    return drawn.finish(title or f"{verdict.line}: {verdict.summary}")


_RING_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Distances of the rings [°]."""
_MOST_RINGS = 5
_DIAGRAM_ROOM = 1.18
"""Half the width of the diagram in lengths of the longer line, so that labels have room."""
_ARC = 0.55
"""Radius of the arc of the fork offset in lengths of the shorter line."""
_LEAST_ARC = np.deg2rad(1.0)
"""Fork offset from which on there is an arc: a shorter one is hidden by its arrow."""
_STRAIGHT = 1e-9
"""Angle up to which a joint has no bending plane that could be drawn [°]."""


@in_look
def bending_planes(
    found: Any, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw the bends of both joints as the catalogue does, H to the right and V up.

    The bend of joint 1 is a dashed line, that of joint 2 a solid line; their lengths are the drawn
    angles, those in brackets the joint angles by the printed formula. Bending planes go on beyond
    the middle, as forks do: the arc is the fork offset, from the plane of joint 1 to that of joint
    2, seen along the power flow.

    Args:
        found: from `drive_lines.arrangements.graphical_method`.
        title: of the figure; what it shows unless given.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: more than one axes.

    Source:
        Catalogue 6.3, Bild 18.
    """
    drawn = sheet(size=(6.4, 6.6), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    h, v = np.rad2deg(found.beta_h), np.rad2deg(found.beta_v)
    lengths = np.hypot(h, v)
    size = _DIAGRAM_ROOM * max(float(lengths.max()), _STRAIGHT)
    _rings(axes, size)
    for joint, dashes in ((0, "--"), (1, "-")):
        style = line_style(joint) | {"linestyle": dashes}
        tip = np.array([h[joint], v[joint]])
        exact = float(np.rad2deg(found.joint_angles[joint]))
        label = f"joint {joint + 1}: {lengths[joint]:.2f}° (β = {exact:.2f}°)"
        axes.plot([0.0, tip[0]], [0.0, tip[1]], linewidth=2.4, label=label, **style)
        axes.plot(*tip, "o", markersize=5, color=style["color"])
        axes.plot([0.0, tip[0], tip[0]], [tip[1], tip[1], 0.0], color="0.6", linewidth=0.8)
        if lengths[joint] > _STRAIGHT:
            plane = np.outer(tip / lengths[joint], (-size, size))
            axes.plot(*plane, color=style["color"], linewidth=0.7, linestyle=(0, (1, 2)))
            _label(axes, str(joint + 1), tip, 14)
    axes.grid(visible=False)
    if lengths.min() > _STRAIGHT and abs(found.fork_offset) > _LEAST_ARC:
        _arc(axes, found, _ARC * float(lengths.min()))
    axes.set(
        xlim=(-size, size),
        ylim=(-size, size),
        aspect="equal",
        xlabel=r"to the right: plan view $β_\mathrm{H}$ [°]",
        ylabel=r"up: side view $β_\mathrm{V}$ [°]",
    )
    offset = float(np.rad2deg(found.fork_offset))
    told = f"Bending planes seen along the power flow, fork offset {offset:.2f}°"
    return drawn.finish(title or told)


def _rings(axes: Axes, size: float) -> None:
    """Draw rings of equal joint angle, and both axes."""
    step = next((s for s in _RING_STEPS if size / s <= _MOST_RINGS), _RING_STEPS[-1])
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    for radius in np.arange(step, size, step):
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color="0.85", linewidth=0.8)
    axes.axhline(0.0, color="0.3", linewidth=0.9)
    axes.axvline(0.0, color="0.3", linewidth=0.9)


def _arc(axes: Axes, found: Any, radius: float) -> None:
    """Draw the fork offset as an arc with an arrow at its end."""
    ends = found.directions[0] + np.array([0.0, found.fork_offset])
    turn = np.linspace(ends[0], ends[1], 91)
    points = radius * np.stack([np.sin(turn), np.cos(turn)])
    axes.plot(*points[:, :-3], color="black", linewidth=1.2)
    arrow = {"arrowstyle": "-|>", "color": "black"}
    axes.annotate("", points[:, -1], points[:, -6], arrowprops=arrow)
    middle = points[:, len(turn) // 2]
    _label(axes, f"{abs(np.rad2deg(found.fork_offset)):.1f}°", middle, 18)


def _label(axes: Axes, text: str, at: Array, gap: float) -> None:
    """Write a label further out than a point, by a gap [pt]."""
    out = at / np.linalg.norm(at)
    axes.annotate(
        text,
        at,
        gap * out,
        textcoords="offset points",
        ha="center",
        va="center",
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"},
    )
