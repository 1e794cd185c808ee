"""Positions: forks and cross of a universal joint, drawn from the placements of a sweep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..kit.arrays import Array
from ..kit.errors import ArgumentError
from .style import Axes, Figure, Into, Size, Swept, in_look, line_style, refuse_grid, sheet

# Sizes of the drawing, in lengths of an arm of the cross.
_SHOULDER, _HEEL, _HEEL_WIDTH = 0.75, 1.15, 0.45
"""A fork: distances of its shoulders and of its heel from the centre, half the heel's width."""
_SHAFT_END, _AXIS_END, _NAME = 2.1, 2.35, 2.6
"""Distances of the ends of a shaft and of its axis, and of its name, from the centre."""
_ARROW, _LETTER_GAP = 1.9, 0.32
"""Length of the arrow of the moment, and distance of its letter from it."""
_LETTER_AT = 0.97
"""Position of the letter along the arrow, as a fraction of its length: beside the head."""
_HALF_WIDTH, _ZOOM = 2.2, 1.35
"""Half the width of the drawn space, and the magnification with which it fills its panel."""


@in_look
def universal_joint_positions(
    turn: Swept,
    samples: Sequence[int],
    titles: Sequence[str],
    *,
    shafts: tuple[str, str] = ("bearing_in", "bearing_out"),
    pins: tuple[str, str] = ("pin_in", "pin_out"),
    view: tuple[float, float] = (55.0, -70.0),
    moment: bool = True,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw forks, cross and moment of a universal joint in several positions.

    Args:
        turn: the sweep, or a trajectory.
        samples: indices of its positions; each has its own drawing.
        titles: of the drawings.
        shafts: joints about which input and output shaft turn.
        pins: joints between input shaft and cross, and cross and output shaft.
        view: elevation above the world's x-y plane and azimuth of the eye [deg]; (90, -90)
            looks straight onto the plane.
        moment: draw the direction of the moment that the cross passes on.
        title: of the figure.
        ax: axes of three dimensions to be drawn into instead of a new figure, one for each sample.
        figsize: width and height of a new figure [inch].

    Raises:
        ModelError: a joint is unknown or not among the outputs.
        ArgumentError: as many titles as samples are needed; a sweep over several dimensions;
            another number of axes, or flat ones.
    """
    refuse_grid(turn)
    if len(samples) != len(titles):
        raise ArgumentError(f"{len(samples)} samples need as many titles, not {len(titles)}")
    drawn = sheet(
        1,
        len(samples),
        size=(3.3 * len(samples), 2.9 + 0.3 * bool(title)),
        ax=ax,
        figsize=figsize,
        projection="3d",
    )
    centre = turn.origin(pins[0])
    shaft_axes = [_world_axis(turn, name) for name in shafts]
    arms = [_world_axis(turn, name) for name in pins]
    moments = turn.wrench(pins[1], "world").moment
    for panel, sample, name in zip(drawn.panels, samples, titles, strict=True):
        _shaft(panel, centre[sample], -shaft_axes[0][sample], arms[0][sample], 0, "I")
        _shaft(panel, centre[sample], shaft_axes[1][sample], arms[1][sample], 1, "II")
        for arm in arms:
            _line(panel, centre[sample] + np.outer([-1.0, 1.0], arm[sample]), "black", 3.2, "-")
        if moment:
            _moment(panel, centre[sample], moments[sample])
        panel.set_title(name, y=0.95)
        panel.set_axis_off()
        panel.set_proj_type("ortho")
        panel.view_init(*view)
        for set_limits in (panel.set_xlim, panel.set_ylim, panel.set_zlim):
            set_limits(-_HALF_WIDTH, _HALF_WIDTH)
        panel.set_box_aspect((1.0, 1.0, 1.0), zoom=_ZOOM)
    return drawn.finish(title)


def _shaft(axes: Axes, centre: Array, ahead: Array, arm: Array, index: int, name: str) -> None:
    """Draw a shaft that ends in a fork.

    Args:
        axes: to draw on.
        centre: `(3,)` of the joint.
        ahead: `(3,)` unit vector from there along the shaft.
        arm: `(3,)` unit vector along the pin of the fork.
        index: of the line style.
        name: of the shaft.
    """
    style = line_style(index)
    shoulder, heel = _SHOULDER * ahead, _HEEL * ahead
    fork = np.array(
        [
            *(arm, shoulder + arm, heel + _HEEL_WIDTH * arm),
            *(heel - _HEEL_WIDTH * arm, shoulder - arm, -arm),
        ]
    )
    _line(axes, centre + fork, style["color"], 2.4, "-")
    _line(axes, centre + np.outer([_HEEL, _SHAFT_END], ahead), style["color"], 5.0, "-")
    # The axes of both shafts have different line styles, so that they differ in black and white.
    _line(axes, centre + np.outer([0.0, _AXIS_END], ahead), style["color"], 0.9, style["linestyle"])
    axes.text(*(centre + _NAME * ahead), name, ha="center", va="center", weight="bold")


def _moment(axes: Axes, centre: Array, moment: Array) -> None:
    """Draw the direction of a moment `(3,)` as an arrow with its letter; none if it is zero."""
    size = float(np.linalg.norm(moment))
    if not size > 0.0:
        return
    tip = _ARROW * moment / size
    axes.quiver(*centre, *tip, color="black", arrow_length_ratio=0.16, lw=1.2)
    across = np.array([tip[1], -tip[0], 0.0])
    beside = _LETTER_GAP * across / (np.linalg.norm(across) or 1.0)
    axes.text(*(centre + _LETTER_AT * tip + beside), "M", ha="center", va="center")


def _line(axes: Axes, points: Array, color: str, width: float, style: str) -> None:
    axes.plot(*points.T, color=color, linewidth=width, linestyle=style, solid_capstyle="round")


def _world_axis(turn: Swept, joint: str) -> Array:
    """Return a joint's axis in the world `(N, 3)`."""
    axis = turn.rotation(joint) @ turn.mechanism.joint(joint).axis
    return np.broadcast_to(axis, (len(turn), 3))
