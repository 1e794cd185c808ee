"""Polar diagrams: the curve that the end of a joint's force or moment draws over the turn."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Unpack

import numpy as np

from ..kit.arrays import NOTHING, Array
from ..kit.checks import names
from ..kit.errors import ArgumentError, choices
from ..kit.quantities import amount
from .style import (
    SMALL,
    Axes,
    Figure,
    Onto,
    Swept,
    curve_style,
    drive_of,
    in_look,
    line_style,
    plain,
    refuse_grid,
    sheet,
    wrapped,
)
from .wrenches import MARK, along, determined, sign_note, whole_of

_AXES_OF = {
    "parent": "axes fixed in the parent",
    "joint": "axes fixed in the child",
    "world": "world axes",
}
_UNITS = {"force": ("F", "N"), "moment": ("M", "N·m")}
_PLANES = ("xy", "yz", "xz", "zx", "yx", "zy")
"""Planes by the axes across and up; by itself z is up."""
_ROOM = 1.9
"""Width of the axes in widths of the curve: matplotlib does not make room for labels."""


@in_look
def force_polar(
    turn: Swept,
    joints: str | Sequence[str],
    frames: str | Sequence[str] = "parent",
    *,
    drive: str | None = None,
    plane: str | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw the force in joints as polar diagrams, in the plane across the joint's axis.

    The curve joins the ends of the force vectors `(N, 3)` that the parent link exerts on the
    child link; the origin is a cross, every quarter turn is labelled with the drive's angle, of
    one that slides both ends with its position. All diagrams have one scale. What is rounding
    beside the whole wrenches is a point at the origin. A star marks what statics leaves open.

    Args:
        turn: the sweep, or a trajectory.
        joints: one joint or several; each has its own diagram.
        frames: one or several of `parent` (for an end bearing these are fixed axes), `joint`
            (they turn with the child) and `world`.
        drive: joint whose angle is written at the curve; the first drive if not given.
        plane: the axes across and up, such as `zx`, instead of `xy`, `yz` or `xz`, which is most
            nearly across the joint's axis.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            one axes for each joint and frame.

    Raises:
        ModelError: a joint is unknown or not among the outputs.
        ArgumentError: unknown frame or plane, a sweep over several dimensions, or another number
            of axes.
    """
    return _diagrams(turn, joints, frames, "force", drive, plane, **onto)


@in_look
def moment_polar(
    turn: Swept,
    joints: str | Sequence[str],
    frames: str | Sequence[str] = "parent",
    *,
    drive: str | None = None,
    plane: str | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw the moment in joints as polar diagrams: across the axis, the bending moment.

    Arguments and errors are those of `force_polar`.
    """
    return _diagrams(turn, joints, frames, "moment", drive, plane, **onto)


@in_look
def forces_in_place(
    turn: Swept,
    joints: Sequence[str],
    links: Iterable[Sequence[str | Sequence[float]]],
    *,
    size: float,
    plane: str = "xy",
    sample: int = 0,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw a mechanism with the polar diagram of the force at each joint, to one scale.

    Args:
        turn: the sweep, or a trajectory.
        joints: those with a diagram, which is drawn at the joint's origin.
        links: lines to draw; each is a sequence of joint names, drawn through their origins, and
            of fixed points `(3,)` [m].
        size: length of the greatest force in the drawing [m].
        plane: of the drawing, in world axes.
        sample: index of the position in which the mechanism is drawn.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ModelError: a joint is unknown or not among the outputs.
        ArgumentError: unknown plane, a sweep over several dimensions, or more than one axes.
    """
    refuse_grid(turn)
    columns = columns_of(plane)
    wrenches = {name: turn.wrench(name, "world") for name in names("joints", joints)}
    forces = {name: wrench.force[:, columns] for name, wrench in wrenches.items()}
    opened = [name for name, wrench in wrenches.items() if not determined(wrench, "force", columns)]
    greatest = max(
        (float(np.max(np.linalg.norm(force, axis=1))) for force in forces.values()), default=0.0
    )
    # Without any force the diagrams shrink to their origins, and there is no scale to be shown.
    length = size / greatest if greatest > 0.0 else 0.0
    drawn = sheet(size=(7.2, 7.0), **onto)
    (axes,) = drawn.panels
    for link in links:
        points = np.array(
            [turn.origin(item)[sample] if isinstance(item, str) else item for item in link]
        )
        axes.plot(*1e3 * points[:, columns].T, color="0.82", linewidth=7, solid_capstyle="round")
    for index, (name, force) in enumerate(forces.items()):
        origin = turn.origin(name)[sample, columns]
        axes.plot(
            *1e3 * (origin + length * force).T,
            **line_style(index),
            label=plain(name) + MARK * (name in opened),
        )
        axes.plot(*1e3 * origin, "o", color="black", markersize=5, markerfacecolor="white")
    axes.set_aspect("equal")
    axes.set_xlabel(f"{plane[0]} [mm]")
    axes.set_ylabel(f"{plane[1]} [mm]")
    if greatest > 0.0:
        _scale_bar(axes, 1e3 * length, greatest)
    return drawn.finish(columns=3, note=sign_note(turn, opened))


def _scale_bar(axes: Axes, length: float, greatest: float) -> None:
    """Draw a round force as a bar; `length` is that of 1 N in the axes' unit."""
    limit = 0.5 * greatest
    decade = 10.0 ** np.floor(np.log10(limit))
    force = decade * max(step for step in (1, 2, 5) if step * decade <= max(limit, decade))
    axes.margins(0.08)
    left, (low, high) = axes.get_xlim()[0], axes.get_ylim()
    height, end = low - 0.06 * (high - low), left + force * length
    axes.plot([left, end], [height, height], color="black", marker="|", markersize=9)
    offset = {"xytext": (6, 0), "textcoords": "offset points"}
    axes.annotate(amount(force, "N"), (end, height), va="center", **offset)


def _diagrams(
    turn: Swept,
    joints: str | Sequence[str],
    frames: str | Sequence[str],
    quantity: str,
    drive: str | None,
    plane: str | None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw a force or a moment, `quantity`, with one diagram per joint and frame."""
    shown = [*product(names("joints", joints), names("frames", frames))]
    if not shown:
        raise ArgumentError("name a joint and axes whose diagram is drawn")
    columns = min(len(shown), 3 if len(shown) > 4 else 2)
    rows = -(-len(shown) // columns)
    drawn = sheet(
        rows,
        columns,
        count=len(shown),
        size=(1.2 + 3.6 * columns, 0.8 + 3.7 * rows),
        **onto,
    )
    at = along(turn, drive_of(turn, drive))
    marked = _ends(at.values) if at.unit == "m" else _quarters(np.deg2rad(at.values))
    letter, unit = _UNITS[quantity]
    wrenches = [turn.wrench(joint, frame) for joint, frame in shown]
    whole = whole_of(wrenches, turn.mechanism.characteristic_length)[unit]
    curves, opened = [], list[str]()
    for wrench in wrenches:
        in_plane = plane or across(wrench.axis if wrench.has_axis else np.eye(3)[2])
        ends = getattr(wrench, quantity)[:, columns_of(in_plane)]
        is_rounding = np.max(np.abs(ends), initial=0.0) <= NOTHING * whole
        chosen = not determined(wrench, quantity, columns_of(in_plane))
        opened += [wrench.joint] * chosen
        curves.append((in_plane, 0.0 * ends if is_rounding else ends, MARK * chosen))
    # One scale for all of them: diagrams of one figure are compared by their sizes.
    half = max((reach(ends) for _, ends, _ in curves), default=0.0) or 0.5 * _ROOM * (whole or 1.0)
    width = drawn.figure.get_figwidth() / columns - 0.4
    for panel, (joint, frame), (in_plane, ends, mark) in zip(
        drawn.panels, shown, curves, strict=True
    ):
        diagram(panel, marked, ends, half)
        panel.set_title(wrapped(f"{plain(joint)}{mark}\n{_AXES_OF[frame]}", width))
        panel.set_xlabel(f"${letter}_{in_plane[0]}$ [{unit}]")
        panel.set_ylabel(f"${letter}_{in_plane[1]}$ [{unit}]")
    return drawn.finish(note=sign_note(turn, opened))


def reach(ends: Array) -> float:
    """Return half the width of axes that show a curve `(N, 2)`, its origin and labels."""
    low, high = np.minimum(np.min(ends, axis=0), 0.0), np.maximum(np.max(ends, axis=0), 0.0)
    return 0.5 * float(np.max(high - low)) * _ROOM


def diagram(
    axes: Axes, at: Array | Mapping[int, str], ends: Array, half: float | None = None
) -> None:
    """Draw a curve about its origin, labelled with the drive's angles.

    Args:
        axes: to draw on.
        at: angles of the drive `(N,)` [rad], of which quarters of a turn are labelled; or samples
            to their labels.
        ends: of the vectors `(N, 2)`.
        half: the width of the axes, if not as large as the curve needs.
    """
    half = half or reach(ends) or 1.0
    centre = 0.5 * (np.minimum(np.min(ends, axis=0), 0.0) + np.maximum(np.max(ends, axis=0), 0.0))
    limits = np.stack([centre - half, centre + half], axis=1)
    if axes.get_lines():  # What was drawn before stays in sight.
        former = np.array([axes.get_xlim(), axes.get_ylim()])
        limits[:, 0] = np.minimum(limits[:, 0], former.min(axis=1))
        limits[:, 1] = np.maximum(limits[:, 1], former.max(axis=1))
    axes.plot(*ends.T, **curve_style(0, len(ends)))
    axes.plot(0.0, 0.0, "+", color="black", markersize=12, markeredgewidth=1.4)
    labels = at if isinstance(at, Mapping) else _quarters(at)
    axes.plot(*ends[list(labels)].T, "o", color=line_style(0)["color"], markersize=5)
    _annotate(axes, ends, labels, half / _ROOM)
    axes.set(xlim=limits[0], ylim=limits[1])
    axes.set_aspect("equal")
    axes.locator_params(nbins=5)


def _annotate(axes: Axes, ends: Array, labels: Mapping[int, str], size: float) -> None:
    """Write labels at samples of a curve `(N, 2)`, on the side on which it is not.

    Points that coincide, beside the curve or the `size` that axes show, share one.
    """
    extent = max(float(np.max(np.abs(ends))), size)
    groups: dict[int, list[str]] = {}
    for index, label in labels.items():
        gaps = {other: np.max(np.abs(ends[other] - ends[index])) for other in groups}
        same = next((other for other, gap in gaps.items() if gap < 0.04 * extent), index)
        groups.setdefault(same, []).append(label)
    arms = ends - 0.5 * (np.min(ends, axis=0) + np.max(ends, axis=0))
    lengths = np.linalg.norm(arms, axis=1)
    farthest, most = arms[np.argmax(lengths)], float(np.max(lengths))
    # Across the greatest extent of the curve: beside its flanks if it is flat.
    aside = np.array([farthest[1], -farthest[0]]) / most if most else np.ones(2)
    for index, words in groups.items():
        outward = aside if arms[index] @ aside >= 0.0 else -aside
        if lengths[index] > 0.5 * most:
            outward = arms[index] / lengths[index]
        # What is to the side or above by less stands in the middle.
        right, up = (1 + int(np.sign(part) * (abs(part) > 0.3)) for part in outward)
        axes.annotate(
            ", ".join(words),
            ends[index],
            10.0 * outward,
            textcoords="offset points",
            ha=("right", "center", "left")[right],
            va=("top", "center", "bottom")[up],
            fontsize=SMALL,
        )


def _quarters(angle: Array) -> dict[int, str]:
    """Return the samples nearest to four quarters of a turn, from 0° if possible, and labels."""
    degrees = np.rad2deg(angle)
    # Some degrees beside it, a sample is still called by it.
    least, most = np.ceil((degrees.min() - 3.0) / 90.0), np.floor((degrees.max() + 3.0) / 90.0)
    quarters = 90.0 * (max(least, min(0.0, most - 3.0)) + np.arange(4))
    away = {f"{quarter:.0f}°": np.abs(degrees - quarter) for quarter in quarters}
    return {int(np.argmin(gap)): label for label, gap in away.items() if gap.min() < 3.0}


def _ends(position: Array) -> dict[int, str]:
    """Return the first and the last sample of a drive that slides, and their labels."""
    places, size = dict.fromkeys((0, len(position) - 1)), float(np.abs(position).max())
    return {index: amount(float(position[index]), "m", 3, size) for index in places}


def across(axis: Array) -> str:
    """Return the coordinate plane most nearly across an axis `(3,)` or axes `(N, 3)`."""
    mean = np.mean(np.abs(np.atleast_2d(axis)), axis=0)
    return ("yz", "xz", "xy")[int(np.argmax(mean))]


def columns_of(plane: str) -> list[int]:
    """Return the indices of both coordinates of a plane."""
    if plane not in _PLANES:
        raise ArgumentError(f"plane {plane!r} is unknown; planes: {choices(_PLANES)}")
    return ["xyz".index(letter) for letter in plane]
