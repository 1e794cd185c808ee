"""Arrangement: a drive line in its side view and in its plan view, with angles and forks."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..checks import described
from ..drive_lines.drive_line import DriveLine
from ..errors import ArgumentError
from .style import TITLE_SIZE, Axes, Figure, axes_grid, line_style

_SIZE = (8.4, 6.0)
_STUB = 0.22
"""Length of an end shaft that has none, relative to all intermediate shafts."""
_ROOM = 0.06
"""Room around the line, relative to its length."""
_NEAR = 0.12
"""Distance of joints up to which their labels would overlap, relative to the line's length."""
_SMALL = 8


def arrangement(line: DriveLine, *, title: str = "") -> Figure:
    """Draw a line at rest, seen from its right side and from above.

    Across the line the scale is larger than along it. Joints are circles with their joint angles β,
    and with their bends in this view; bearings are triangles; intermediate shafts are told with
    their fork offsets.

    Args:
        line: the line.
        title: of the figure; the name of the line unless given.

    Raises:
        ArgumentError: it is no drive line.
        MissingExtraError: matplotlib is not installed.
    """
    if not isinstance(line, DriveLine):
        raise ArgumentError(f"the line is {described(line)}, expected a DriveLine")
    points = line_points(line)
    figure, axes = axes_grid(2, size=_SIZE, share_x=True)
    for panel, axis, label in zip(
        axes, (2, 1), ("up, side view [m]", "left, plan view [m]"), strict=True
    ):
        _view(panel, line, points[:, [0, axis]], axis)
        panel.set_ylabel(label)
    axes[-1].set_xlabel("forward [m]")
    figure.suptitle(title or line.name, fontsize=TITLE_SIZE)
    return figure


def line_points(line: DriveLine) -> Array:
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


def _view(panel: Axes, line: DriveLine, points: Array, axis: int) -> None:
    """Draw one view: points `(n + 2, 2)`."""
    for k, name in enumerate(line.shaft_names):
        style = line_style(k)
        panel.plot(*points[k : k + 2].T, linewidth=3.0, color=style["color"], zorder=2)
        offset = "" if k in (0, line.count) else f"\nfork {_degrees(line.fork_offsets[k - 1])}"
        middle = points[k : k + 2].mean(axis=0)
        panel.annotate(
            name + offset,
            middle,
            xytext=(0, -26),
            textcoords="offset points",
            ha="center",
            fontsize=_SMALL,
            color=style["color"],
        )
    views = line.geometry.views[:, 1 if axis == 2 else 0]
    near, raised = _NEAR * float(np.ptp(points[:, 0])), False
    for k, centre in enumerate(points[1:-1]):
        # Labels of joints that are close to each other stand above one another.
        raised = k > 0 and not raised and centre[0] - points[k, 0] < near
        panel.plot(*centre, "o", markersize=9, mfc="white", mec="black", zorder=3)
        panel.annotate(
            f"β{k + 1} = {_degrees(line.joint_angles[k])}\nhere {_degrees(views[k])}",
            centre,
            xytext=(0, 38 if raised else 12),
            textcoords="offset points",
            ha="center",
            fontsize=_SMALL,
        )
    places = _bearings(line)[:, [0, axis]]
    panel.plot(*places.T, "^", markersize=8, color="0.25", zorder=3)
    length = float(np.ptp(points[:, 0]))
    panel.set_xlim(points[0, 0] - _ROOM * length, points[-1, 0] + _ROOM * length)
    panel.margins(y=0.6)
    panel.set_aspect("auto")


def _bearings(line: DriveLine) -> Array:
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
