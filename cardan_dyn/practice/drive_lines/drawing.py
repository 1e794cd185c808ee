"""Drawing: a line in both its views, what an analysis of it found, and the catalogue's diagram."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...figures.style import (
    Abscissa,
    Axes,
    Figure,
    Into,
    Size,
    heading,
    in_look,
    line_style,
    over,
    plain,
    rows_of,
    sheet,
    width_of,
    wrapped,
)
from ...kit.arrays import NOTHING, Array
from ...kit.errors import ArgumentError
from ..formats.visuals import urdf_visual
from ..viewer.visuals import surface_of
from .line.files import units_of
from .line.supports import bearings_of
from .line.visuals import (
    cross_visuals,
    rear_fork_visuals,
    shaft_length,
    shaft_radius,
    shaft_visuals,
)
from .verdict.rows import HEADINGS, OPEN, VerdictRow
from .wording import Wording

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from .line.data import LineData

WIDTH = 6.8
"""Width of the arrangement on paper [inch]."""
_PANEL = 6.0
"""Width of its axes without their labels [inch]."""
_TALLEST = 3.0
"""Greatest height of a line in one view [inch]."""
SMALL = 8
"""Size of letters and bearings, and gap between labels and between them and the line [pt]."""
LINE_PITCH = 1.25
"""Distance of lines of text, relative to the size of the font."""
_LONGEST_NAME = 18
"""Letters of a name in one line."""


@in_look
def arrangement(
    line: LineData,
    *,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
    wording: Wording | None = None,
) -> Figure:
    """Draw a line at rest, seen from its right side and from above, to one scale.

    Shafts are drawn in the diameter of their tubes and crosses in their span, else in a size that
    goes with the line. Forks stand as they do while the pin of the input fork is horizontal.
    Splines have sleeves; bearings are triangles, filled where they are locating; joints of constant
    velocity are balls. Joints are told with their joint angles β and their bends in this view,
    shafts with their lengths in the side view and with their fork offsets in the plan view.

    Args:
        line: the line.
        title: of the figure; the name of the line unless given.
        ax: two axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].
        wording: language and units; English, and the units of most data, unless given.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: other than two axes.
    """
    wording = wording or Wording(units=units_of(line))
    unit = wording.measure("length").factor
    points = line_points(line) * unit
    parts = solids(line)
    extent = np.concatenate([points, *(part.points.reshape(-1, 3) * unit for part in parts)])
    low, high = extent.min(axis=0), extent.max(axis=0)
    long, *across = high - low
    # Units per inch, so that neither view is wider or taller than its room, some of it left beside.
    scale = max(1.08 * long / _PANEL, max(across) / _TALLEST)
    middle = (low + high) / 2.0
    xlim = middle[0] - scale * _PANEL / 2.0, middle[0] + scale * _PANEL / 2.0
    views = []
    for axis in (2, 1):
        above = _rows(_joint_labels(line, points, axis, wording), xlim, scale)
        below = _rows(_shaft_labels(line, points, axis, wording), xlim, scale)
        views.append((axis, above, below))
    heights = [
        (high[axis] - low[axis]) / scale + (_height(above) + _height(below) + 4 * SMALL) / 72.0
        for axis, above, below in views
    ]
    size = (WIDTH, sum(heights) + 1.2)
    drawn = sheet(2, size=size, share_x=True, ax=ax, figsize=figsize)
    if drawn.is_new:
        drawn.panels[0].get_gridspec().set_height_ratios(heights)
    from matplotlib.ticker import FuncFormatter

    # With the decimal sign of the language.
    ticks = FuncFormatter(lambda value, _: wording.given(value))
    length = wording.unit("length")
    for panel, (axis, above, below) in zip(drawn.panels, views, strict=True):
        _view(panel, line, parts, points, axis, unit, scale)
        name, side = ("side view", "up") if axis == 2 else ("plan view", "left")
        panel.set_ylabel(f"{wording(name)}\n{wording(side)}{length}")
        panel.set_xlim(*xlim)
        half = (high[axis] - low[axis]) / 2.0 + scale * SMALL / 72.0
        tops = middle[axis] + half, middle[axis] - half
        _write(panel, above, tops[0], scale, 1.0)
        _write(panel, below, tops[1], scale, -1.0)
        panel.set_ylim(
            tops[1] - scale * (_height(below) + SMALL) / 72.0,
            tops[0] + scale * (_height(above) + SMALL) / 72.0,
        )
        panel.set_aspect("equal")
        panel.xaxis.set_major_formatter(ticks)
        panel.yaxis.set_major_formatter(ticks)
    drawn.panels[-1].set_xlabel(wording("forward") + length)
    return drawn.finish(title or plain(line.name), 0)


def line_points(line: LineData) -> Array:
    """Return the ends of all shafts `(n + 2, 3)` [m]: both ends of the line and the joints between.

    An end shaft goes on to its farthest bearing, or by a stub.
    """
    found = line.geometry
    first = found.centres[0] - shaft_length(line, 0) * found.directions[0]
    last = found.centres[-1] + shaft_length(line, line.count) * found.directions[-1]
    return np.vstack([first, found.centres, last])


class _Label(NamedTuple):
    """A text at a place along the line [in units of the drawing], and what of the line it tells."""

    at: float
    text: str
    target: float


def _joint_labels(line: LineData, points: Array, axis: int, wording: Wording) -> list[_Label]:
    bends = line.geometry.views[:, 1 if axis == 2 else 0]
    return [
        _Label(
            point[0],
            f"β{k} = {_angle(line.joint_angles[k - 1], wording)}\n"
            + wording("here {angle}", angle=_angle(bends[k - 1], wording)),
            point[axis],
        )
        for k, point in enumerate(points[1:-1], 1)
    ]


def _shaft_labels(line: LineData, points: Array, axis: int, wording: Wording) -> list[_Label]:
    found = []
    for k, name in enumerate(line.shaft_names):
        middle = points[k : k + 2].mean(axis=0)
        text = "\n".join(textwrap.wrap(name, _LONGEST_NAME) or [name])
        length = float(line.geometry.lengths[k])
        if axis == 2 and np.isfinite(length):
            text += "\n" + wording.with_unit(wording.fixed(length, "length"), "length")
        elif axis == 1 and 0 < k < line.count:
            offset = _angle(line.fork_offsets[k - 1], wording)
            text += "\n" + wording("fork {angle}", angle=offset)
        found.append(_Label(middle[0], text, middle[axis]))
    return found


def _angle(angle: float, wording: Wording) -> str:
    return wording.with_unit(wording.fixed(float(angle), "angle"), "angle")


def _rows(labels: list[_Label], xlim: tuple[float, float], scale: float) -> list[list[_Label]]:
    """Return labels in rows, away from the line, in which none is over another."""
    gap, placed, spans = scale * SMALL / 72.0, [], []
    for label in labels:
        lines = plain(label.text).split("\n")
        half = scale * max(width_of(line, SMALL) for line in lines) / 2.0
        at = min(max(label.at, xlim[0] + half), max(xlim[1] - half, xlim[0] + half))
        placed.append(label._replace(at=at))
        spans.append((at - half, at + half + gap))
    rows = rows_of(spans)
    return [
        [label for label, its in zip(placed, rows, strict=True) if its == row]
        for row in range(max(rows, default=-1) + 1)
    ]


def _height(rows: list[list[_Label]]) -> float:
    """Return the height of rows of labels [pt]."""
    lines = (max(label.text.count("\n") + 1 for label in row) for row in rows)
    return sum(SMALL * LINE_PITCH * count + SMALL for count in lines)


def _write(panel: Axes, rows: list[list[_Label]], start: float, scale: float, way: float) -> None:
    """Write rows of labels from a height on upwards (1) or downwards (-1), led to their places."""
    for index, row in enumerate(rows):
        height = start + way * scale * _height(rows[:index]) / 72.0
        for label in row:
            panel.annotate(
                plain(label.text),
                (label.at, label.target),
                (label.at, height),
                ha="center",
                va="bottom" if way > 0.0 else "top",
                fontsize=SMALL,
                arrowprops={"arrowstyle": "-", "linewidth": 0.6, "color": "0.6", "shrinkB": 5},
                linespacing=LINE_PITCH,
                zorder=6,
            )


def _view(
    panel: Axes,
    line: LineData,
    parts: list[Solid],
    points: Array,
    axis: int,
    unit: float,
    scale: float,
) -> None:
    """Draw one view of the solids, those behind first, and the bearings."""
    chosen = [0, axis]
    # Seen from the right side, what lies to the left is behind; from above, what lies below.
    depth, nearness = (1, -1.0) if axis == 2 else (2, 1.0)
    for part in sorted(parts, key=lambda part: nearness * float(part.points[:, depth].mean())):
        panel.fill(
            *(hull(part.points[:, chosen]) * unit).T,
            facecolor=part.color,
            edgecolor="0.15",
            linewidth=0.6,
            zorder=2,
        )
    for k in range(len(points) - 1):
        ends = points[k : k + 2, chosen]
        panel.plot(*ends.T, color="0.35", linewidth=0.5, linestyle=(0, (8, 2, 1, 2)), zorder=4)
    for item in bearings_of(line):
        k, found = item.shaft, line.geometry
        place = found.centres[max(k - 1, 0)] + item.along * found.directions[k]
        panel.plot(
            place[0] * unit,
            (place[axis] - shaft_radius(line, k)) * unit - scale * SMALL / 2.0 / 72.0,
            marker="^",
            markersize=SMALL,
            color="black",
            markerfacecolor="black" if item.locating else "white",
            linestyle="none",
            zorder=5,
        )


class Solid(NamedTuple):
    """A convex part of the drawing: points `(p, 3)` [m] whose hull it is, and its colour."""

    points: Array
    color: str


def solids(line: LineData) -> list[Solid]:
    """Return what a line is drawn of: the visuals of its links, at rotation zero."""
    centres, axes, (front, rear) = line.geometry.centres, line.geometry.directions, fork_pins(line)
    shapes: list[Solid] = []
    for k, axis in enumerate(axes):
        color = _tint(line_style(k)["color"])
        pin = np.cross(front[k], axis) if k else rear[0]
        shapes += _placed(shaft_visuals(line, k), centres[max(k - 1, 0)], axis, pin, color)
        if 0 < k < line.count:
            shapes += _placed(rear_fork_visuals(line, k), centres[k], axis, rear[k], color)
        if k < line.count and not line.even[k]:
            normal = np.cross(rear[k], front[k + 1])
            shapes += _placed(cross_visuals(line, k + 1), centres[k], normal, rear[k], "0.85")
    return shapes


def _placed(visuals: list[Element], centre: Array, x: Array, y: Array, color: str) -> list[Solid]:
    """Return visuals of a link at a place, with its x and y axes."""
    rotation = np.stack([x, y, np.cross(x, y)])
    found = []
    for element in visuals:
        visual = urdf_visual({}, None, "", element)
        points, _ = surface_of(visual.kind, visual.size)
        points = points @ visual.placement[:3, :3].T + visual.placement[:3, 3]
        found.append(Solid(points @ rotation + centre, color))
    return found


def fork_pins(line: LineData) -> tuple[Array, Array]:
    """Return directions of the pins in the forks of all shafts at rotation zero, `(n + 1, 3)` each.

    First those of the forks at their fronts, then at their rears. The input shaft has no front
    fork, the output shaft no rear one: these are NaN.
    """
    frames, rotations = line.geometry.frames, line.zero.rotations
    front, rear = np.full((2, line.count + 1, 3), np.nan)
    for k in range(line.count + 1):
        # The pin of the front fork is along z, that of the input fork along y.
        angle = float(rotations[k]) + (np.pi / 2 if k else 0.0)
        offset = float(line.fork_offsets[k - 1]) if 0 < k < line.count else 0.0
        for pins, turn in ((front, angle), (rear, angle + offset)):
            pins[k] = frames[k] @ [0.0, np.cos(turn), np.sin(turn)]
    front[0], rear[-1] = np.nan, np.nan
    return front, rear


def hull(points: Array) -> Array:
    """Return the convex hull of points `(p, 2)`, counterclockwise; by Andrew's monotone chain."""
    listed = sorted({(float(x), float(y)) for x, y in points})

    def half(items: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in items:
            while len(chain) > 1:
                (x1, y1), (x2, y2) = chain[-2:]
                if (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1) > 0.0:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(listed) + half(list(reversed(listed))) or listed)


def _tint(color: str) -> Any:
    """Return a colour mixed with white."""
    from matplotlib.colors import to_rgb

    return tuple(0.55 + 0.45 * part for part in to_rgb(color))


@in_look
def over_angle(
    analysis: Any, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw what an analysis of a drive line found over the rotation of the input shaft.

    From above: the angle error of every shaft behind a joint, its speed ratio, the bending moments
    before and behind each joint, and the bearings' forces across their shafts, with inertia
    and weight, in the units of most data of the line.

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
    wording = Wording(units=analysis.units)
    torque, force = (wording.measure(name).factor for name in ("torque", "force"))
    shafts = analysis.shafts[1:]
    sides = [f"{side} {name}" for side in ("before", "behind") for name in analysis.joints]
    panels: list[tuple[str, Sequence[str], Array]] = [
        ("angle error [°]", shafts, np.rad2deg(analysis.angle_error[:, 1:])),
        ("speed ratio [–]", shafts, analysis.ratio[:, 1:]),
        (
            f"bending{wording.unit('torque')}",
            sides,
            torque * np.hstack([forces.bending_in, forces.bending_out]),
        ),
        (
            f"bearing force{wording.unit('force')}",
            analysis.bearings,
            force * forces.bearing_radial,
        ),
    ]
    drawn = sheet(len(panels), size=(7.6, 9.6), share_x=True, ax=ax, figsize=figsize)
    for panel, (label, names, values) in zip(drawn.panels, panels, strict=True):
        Abscissa(angle, "").draw(panel, dict(zip(names, values.T, strict=True)))
        panel.set_ylabel(label)
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.legend(fontsize=SMALL, loc="center left", bbox_to_anchor=(1.0, 0.5))
    over("rotation of the input shaft", analysis.position, "rad").name(drawn.panels[-1])
    return drawn.finish(title or plain(analysis.name), 0, open_note(analysis))


def open_note(analysis: Any) -> str:
    """Return what statics leaves open in a line, for a figure of its forces; empty if nothing."""
    opened = "; ".join(analysis.indeterminate)
    return f"not all forces are determined by statics: {opened}" if opened else ""


@in_look
def margins(
    verdict: Any, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw how much room the values of a verdict have to their limits, the least on top.

    Bars to the left, which are hatched, miss their limits; of open rows nobody can tell. Bars end
    at 100 %; the number says how far they go.

    Args:
        verdict: of a line.
        title: of the figure; the name of the line and the counts of its rows unless given.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: no row has a limit and a value, or more than one axes.
    """
    rows = sorted((row for row in verdict.rows if row.margin is not None), key=_room)
    if not rows:
        raise ArgumentError("no row of the verdict has a value and a limit, so that none has room")
    drawn = sheet(size=(8.4, 1.6 + 0.32 * len(rows)), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    for place, row in enumerate(rows):
        room = _room(row)
        missed = room < 0.0
        color = line_style(1 if missed else 0)["color"]
        length = 100.0 * min(max(room, -1.0), 1.0)
        look = {"facecolor": "white" if missed else color, "hatch": "///" if missed else ""}
        axes.barh(place, length, 0.6, edgecolor=color, **look)
        if 1.0 < abs(room) < np.inf:
            cut = {"facecolor": "white", "edgecolor": "none", "pad": 0.3}
            middle = {"ha": "center", "va": "center", "fontsize": SMALL}
            axes.text(0.94 * length, place, "//", bbox=cut, **middle)
        axes.annotate(
            row.texts(verdict.units)[HEADINGS.index("margin")],
            (length, place),
            (-4 if missed else 4, 0),
            textcoords="offset points",
            ha="right" if missed else "left",
            va="center",
            fontsize=SMALL,
        )
    names = [
        ", ".join(filter(None, [row.quantity, row.where, "open" * (row.status == OPEN)]))
        for row in rows
    ]
    axes.set_yticks(range(len(rows)), [wrapped(plain(name), 3.2, SMALL) for name in names])
    axes.tick_params(axis="y", labelsize=SMALL)
    axes.axvline(0.0, color="black", linewidth=0.9)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    least = min(_room(rows[0]), 0.0)
    axes.set_xlim(100.0 * max(least, -1.0) - 22.0 * (least < 0.0), 122.0)
    axes.set_xlabel("room to the limit, as a part of it [%]; bars with // go on")
    axes.grid(visible=False, axis="y")
    title = title or f"{plain(verdict.line)}: {verdict.summary}"
    if drawn.is_new:  # Across the whole figure: its axes begin behind the names of the bars.
        heading(drawn.figure, title)
        title = ""
    return drawn.finish(title)


def _room(row: VerdictRow) -> float:
    """Return the room to a limit as a part of it; from a limit of 0 any room is infinite."""
    margin = float(row.margin or 0.0)
    if row.limit is not None and row.limit.value == 0.0 and margin:
        return float(np.copysign(np.inf, margin))
    return margin


_DIAGRAM_ROOM = 1.18
"""Half the width of the diagram in lengths of the longer line, so that labels have room."""
_ARC = 0.55
"""Radius of the arc of the fork offset in lengths of the shorter line."""
_LEAST_ARC = np.deg2rad(1.0)
"""Fork offset from which on there is an arc: a shorter one is hidden by its arrow."""


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
    size = _DIAGRAM_ROOM * max(float(lengths.max()), NOTHING)
    _rings(axes, size)
    for joint, dashes in ((0, "--"), (1, "-")):
        style = line_style(joint) | {"linestyle": dashes}
        tip = np.array([h[joint], v[joint]])
        exact = float(np.rad2deg(found.joint_angles[joint]))
        label = f"joint {joint + 1}: {lengths[joint]:.2f}° (β = {exact:.2f}°)"
        axes.plot([0.0, tip[0]], [0.0, tip[1]], linewidth=2.4, label=label, **style)
        axes.plot(*tip, "o", markersize=5, color=style["color"])
        axes.plot([0.0, tip[0], tip[0]], [tip[1], tip[1], 0.0], color="0.6", linewidth=0.8)
        if lengths[joint] > NOTHING:
            plane = np.outer(tip / lengths[joint], (-size, size))
            axes.plot(*plane, color=style["color"], linewidth=0.7, linestyle=(0, (1, 2)))
            _label(axes, str(joint + 1), tip, 14)
    axes.grid(visible=False)
    if lengths.min() > NOTHING and abs(found.fork_offset) > _LEAST_ARC:
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
    from matplotlib.ticker import MaxNLocator

    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    radii = np.asarray(MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(0.0, size))
    for radius in radii[(radii > 0.0) & (radii < size)]:
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
