"""Bending planes: the catalogue's diagram of compound angles and fork offset (Bild 18)."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..drive_lines.arrangements import GraphicalMethod
from .style import Axes, Figure, axes_grid, legend, line_style

_RING_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Distances of the rings [°]."""
_MOST_RINGS = 5
_ROOM = 1.18
"""Half the width of the diagram in lengths of the longer line, so that labels have room."""
_ARC = 0.55
"""Radius of the arc of the fork offset in lengths of the shorter line."""
_LEAST_ARC = np.deg2rad(1.0)
"""Fork offset from which on there is an arc: a shorter one is hidden by its arrow."""
_STRAIGHT = 1e-9
"""Angle up to which a joint has no bending plane that could be drawn [°]."""


def bending_planes(found: GraphicalMethod) -> Figure:
    """Draw the bends of both joints as the catalogue does, H to the right and V up.

    The bend of joint 1 is a dashed line, that of joint 2 a solid line; their lengths are the drawn
    angles, those in brackets the joint angles by the printed formula. Bending planes go on beyond
    the middle, as forks do: the arc is the fork offset, from the plane of joint 1 to that of joint
    2, seen along the power flow.

    Args:
        found: from `drive_lines.arrangements.graphical_method`.

    Raises:
        MissingExtraError: matplotlib is not installed.

    Source:
        Catalogue 6.3, Bild 18.
    """
    figure, axes = axes_grid(size=(6.4, 6.6))
    h, v = np.rad2deg(found.beta_h), np.rad2deg(found.beta_v)
    lengths = np.hypot(h, v)
    size = _ROOM * max(float(lengths.max()), _STRAIGHT)
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
    axes.set_title(f"Bending planes seen along the power flow, fork offset {offset:.2f}°")
    legend(figure)
    return figure


def _rings(axes: Axes, size: float) -> None:
    """Draw rings of equal joint angle, and both axes."""
    step = next((s for s in _RING_STEPS if size / s <= _MOST_RINGS), _RING_STEPS[-1])
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    for radius in np.arange(step, size, step):
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color="0.85", linewidth=0.8)
    axes.axhline(0.0, color="0.3", linewidth=0.9)
    axes.axvline(0.0, color="0.3", linewidth=0.9)


def _arc(axes: Axes, found: GraphicalMethod, radius: float) -> None:
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
