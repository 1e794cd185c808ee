"""Polar diagrams: the curve that the end of a joint's force or moment draws over the turn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError, choices
from ..results.sweep import FRAMES, Sweep
from .style import Axes, Figure, axes_grid, curve_style, legend, line_style, names

_AXES_OF = {
    "parent": "axes fixed in the parent",
    "joint": "axes fixed in the child",
    "world": "world axes",
}
_UNITS = {"force": ("F", "N"), "moment": ("M", "N·m")}


def force_polar(
    turn: Sweep,
    joints: str | Sequence[str],
    frames: str | Sequence[str] = "parent",
    *,
    drive: str = "bearing_in",
    plane: str | None = None,
    title: str = "",
) -> Figure:
    """Draw the force in joints as polar diagrams, in the plane across the joint's axis.

    The curve joins the ends of the force vectors `(N, 3)` that the parent link exerts on the
    child link; the origin is a cross, the drive's angle is written at every quarter turn.

    Args:
        turn: the sweep.
        joints: one joint or several; each has its own diagram.
        frames: one or several of `parent` (for an end bearing these are fixed axes), `joint`
            (they turn with the child) and `world`.
        drive: joint whose angle is written at the curve.
        plane: `xy`, `yz` or `zx`, instead of the plane most nearly across the joint's axis.
        title: of the figure.

    Raises:
        ModelError: a joint is unknown or was not asked for.
        ArgumentError: unknown frame or plane.
    """
    return _diagrams(turn, joints, frames, "force", drive, plane, title)


def moment_polar(
    turn: Sweep,
    joints: str | Sequence[str],
    frames: str | Sequence[str] = "parent",
    *,
    drive: str = "bearing_in",
    plane: str | None = None,
    title: str = "",
) -> Figure:
    """Draw the moment in joints as polar diagrams: across the axis, the bending moment.

    Arguments and errors are those of `force_polar`.
    """
    return _diagrams(turn, joints, frames, "moment", drive, plane, title)


def forces_in_place(
    turn: Sweep,
    joints: Sequence[str],
    links: Iterable[Sequence[str | Sequence[float]]],
    *,
    size: float,
    plane: str = "xy",
    sample: int = 0,
    title: str = "",
) -> Figure:
    """Draw a mechanism with the polar diagram of the force at each joint, to one scale.

    Args:
        turn: the sweep.
        joints: those with a diagram, which is drawn at the joint's origin.
        links: lines to draw; each is a sequence of joint names, drawn through their origins, and
            of fixed points `(3,)` [m].
        size: length of the greatest force in the drawing [m].
        plane: of the drawing, in world axes.
        sample: number of the position in which the mechanism is drawn.
        title: of the figure.

    Raises:
        ModelError: a joint is unknown or was not asked for.
        ArgumentError: unknown plane.
    """
    columns = _columns(plane)
    forces = {name: turn.wrench(name, "world").force[:, columns] for name in joints}
    greatest = max(float(np.max(np.linalg.norm(force, axis=1))) for force in forces.values())
    figure, axes = axes_grid(size=(7.2, 7.0))
    for link in links:
        points = np.array(
            [turn.origin(item)[sample] if isinstance(item, str) else item for item in link]
        )
        axes.plot(*1e3 * points[:, columns].T, color="0.82", linewidth=7, solid_capstyle="round")
    for number, (name, force) in enumerate(forces.items()):
        place = turn.origin(name)[sample, columns]
        axes.plot(*1e3 * (place + size * force / greatest).T, **line_style(number), label=name)
        axes.plot(*1e3 * place, "o", color="black", markersize=5, markerfacecolor="white")
    axes.set_aspect("equal")
    axes.set_xlabel(f"{plane[0]} [mm]")
    axes.set_ylabel(f"{plane[1]} [mm]")
    _scale_bar(axes, 1e3 * size / greatest, greatest)
    axes.set_title(title)
    legend(figure, min(len(joints), 3))
    return figure


def _scale_bar(axes: Axes, length: float, greatest: float) -> None:
    """Draw a round force as a bar; `length` is that of 1 N in the axes' unit."""
    decade = 10.0 ** np.floor(np.log10(0.5 * greatest)) if greatest > 0.0 else 1.0
    force = decade * max(step for step in (1, 2, 5) if step * decade <= max(0.5 * greatest, decade))
    axes.margins(0.08)
    (left, _), (low, high) = axes.get_xlim(), axes.get_ylim()
    height = low - 0.06 * (high - low)
    bar = [left, left + force * length]
    axes.plot(bar, [height, height], color="black", marker="|", markersize=9)
    axes.annotate(f"{force:g} N", (bar[1], height), (6, 0), textcoords="offset points", va="center")


def _diagrams(
    turn: Sweep,
    joints: str | Sequence[str],
    frames: str | Sequence[str],
    quantity: str,
    drive: str,
    plane: str | None,
    title: str,
) -> Figure:
    for frame in names(frames):
        if frame not in FRAMES:
            raise ArgumentError(f"frame {frame!r} is unknown; frames: {choices(FRAMES)}")
    shown = [(joint, frame) for joint in names(joints) for frame in names(frames)]
    columns = min(len(shown), 3 if len(shown) > 4 else 2)
    rows = -(-len(shown) // columns)
    figure, axes = axes_grid(rows, columns, size=(1.2 + 3.6 * columns, 0.8 + 3.7 * rows))
    places = [axes] if rows * columns == 1 else list(axes)
    angle = turn.motion.position(drive)
    for place, (joint, frame) in zip(places, shown, strict=False):
        wrench = turn.wrench(joint, frame)
        inside = plane or _across(turn.wrench(joint, frame).axis)
        letter, unit = _UNITS[quantity]
        _curve(place, angle, getattr(wrench, quantity)[:, _columns(inside)])
        place.set_title(f"{joint}\n{_AXES_OF[frame]}")
        place.set_xlabel(f"${letter}_{inside[0]}$ [{unit}]")
        place.set_ylabel(f"${letter}_{inside[1]}$ [{unit}]")
    for place in places[len(shown) :]:
        place.remove()
    figure.suptitle(title, fontsize=11)
    return figure


def _curve(axes: Axes, angle: Array, ends: Array) -> None:
    axes.plot(*ends.T, **curve_style(0, len(ends)))
    axes.plot(0.0, 0.0, "+", color="black", markersize=12, markeredgewidth=1.4)
    extent = float(np.max(np.abs(ends))) or 1.0
    middle = 0.5 * (np.min(ends, axis=0) + np.max(ends, axis=0))
    marks = _quarters(angle)
    axes.plot(*ends[list(marks)].T, "o", **{"color": line_style(0)["color"], "markersize": 5})
    written: list[tuple[Array, list[str]]] = []
    for index, degrees in marks.items():
        near = [
            labels for end, labels in written if np.max(np.abs(end - ends[index])) < 0.04 * extent
        ]
        if near:
            near[0].append(f"{degrees}°")
        else:
            written.append((ends[index], [f"{degrees}°"]))
    reach = ends - middle
    furthest = reach[int(np.argmax(np.linalg.norm(reach, axis=1)))]
    length = float(np.linalg.norm(furthest)) or 1.0
    aside = np.array([furthest[1], -furthest[0]]) / length if np.any(furthest) else np.ones(2)
    for end, labels in written:
        away = end - middle
        size = float(np.linalg.norm(away))
        # Beside a flat curve, beyond the ends of it and of a round one.
        away = (
            away / size if size > 0.5 * length else (1.0 if away @ aside >= 0.0 else -1.0) * aside
        )
        axes.annotate(
            ", ".join(labels),
            end,
            10 * away,
            textcoords="offset points",
            ha="left" if away[0] > 0.3 else "right" if away[0] < -0.3 else "center",
            va="bottom" if away[1] > 0.3 else "top" if away[1] < -0.3 else "center",
            fontsize=9,
        )
    # Room for what is written at the curve, which matplotlib does not count.
    low, high = (np.minimum(np.min(ends, axis=0), 0.0), np.maximum(np.max(ends, axis=0), 0.0))
    half = 0.5 * (float(np.max(high - low)) or 1.0) * 1.9
    for limits, centre in zip((axes.set_xlim, axes.set_ylim), 0.5 * (low + high), strict=True):
        limits(centre - half, centre + half)
    axes.set_aspect("equal")
    axes.locator_params(nbins=5)


def _quarters(angle: Array) -> dict[int, int]:
    """Return the samples nearest to the quarters of the first turn, and their degrees."""
    quarters = 90 * np.arange(4)
    found = {}
    for degrees in quarters.tolist():
        distance = np.abs(np.rad2deg(angle) - degrees)
        index = int(np.argmin(distance))
        if distance[index] < 3.0:
            found[index] = degrees
    return found


def _across(axis: Array) -> str:
    """Return the coordinate plane most nearly across an axis `(3,)` or axes `(N, 3)`."""
    mean = np.mean(np.abs(np.atleast_2d(axis)), axis=0)
    return ("yz", "zx", "xy")[int(np.argmax(mean))]


def _columns(plane: str) -> list[int]:
    if plane not in ("xy", "yz", "zx"):
        raise ArgumentError(f"plane {plane!r} is unknown; planes: xy, yz, zx")
    return ["xyz".index(letter) for letter in plane]
