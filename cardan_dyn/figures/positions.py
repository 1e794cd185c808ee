"""Positions: forks and cross of a universal joint, drawn from the placements of a sweep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError
from ..results.sweep import Sweep
from .style import Axes, Figure, axes_grid, line_style


def universal_joint_positions(
    turn: Sweep,
    samples: Sequence[int],
    titles: Sequence[str],
    *,
    shafts: tuple[str, str] = ("bearing_in", "bearing_out"),
    pins: tuple[str, str] = ("pin_in", "pin_out"),
    view: tuple[float, float] = (55.0, -70.0),
    moment: bool = True,
    title: str = "",
) -> Figure:
    """Draw forks, cross and moment of a universal joint in several positions.

    Args:
        turn: the sweep.
        samples: numbers of its positions; each has its own drawing.
        titles: of the drawings.
        shafts: joints about which input and output shaft turn.
        pins: joints between input shaft and cross, and cross and output shaft.
        view: elevation above the world's x-y plane and azimuth of the eye [deg]; (90, -90)
            looks straight onto the plane.
        moment: draw the direction of the moment that the cross passes on.
        title: of the figure.

    Raises:
        ModelError: a joint is unknown or was not asked for.
        ArgumentError: as many titles as samples are needed.
    """
    if len(samples) != len(titles):
        raise ArgumentError(f"{len(samples)} samples need as many titles, not {len(titles)}")
    figure, axes = axes_grid(
        1, len(samples), size=(3.3 * len(samples), 2.9 + 0.3 * bool(title)), projection="3d"
    )
    centre = turn.origin(pins[0])
    ahead = [_world_axis(turn, name) for name in shafts]
    arms = [_world_axis(turn, name) for name in pins]
    passed = turn.wrench(pins[1], "world").moment
    for place, sample, name in zip(np.atleast_1d(axes), samples, titles, strict=True):
        _shaft(place, centre[sample], -ahead[0][sample], arms[0][sample], 0, "I")
        _shaft(place, centre[sample], ahead[1][sample], arms[1][sample], 1, "II")
        for arm in arms:
            _line(place, centre[sample] + np.outer([-1.0, 1.0], arm[sample]), "black", 3.2, "-")
        size = float(np.linalg.norm(passed[sample]))
        if moment and size > 0.0:
            end = 1.9 * passed[sample] / size
            place.quiver(*centre[sample], *end, color="black", arrow_length_ratio=0.16, lw=1.2)
            aside = np.array([end[1], -end[0], 0.0])
            beside = 0.32 * aside / (np.linalg.norm(aside) or 1.0)
            place.text(*(centre[sample] + 0.97 * end + beside), "M", ha="center", va="center")
        place.set_title(name, y=0.95)
        place.set_axis_off()
        place.set_proj_type("ortho")
        place.view_init(*view)
        for limits in (place.set_xlim, place.set_ylim, place.set_zlim):
            limits(-2.2, 2.2)
        place.set_box_aspect((1.0, 1.0, 1.0), zoom=1.35)
    figure.suptitle(title, fontsize=11)
    return figure


def _shaft(axes: Axes, centre: Array, ahead: Array, arm: Array, number: int, name: str) -> None:
    """Draw a shaft that ends in a fork; lengths are in lengths of an arm of the cross."""
    style = line_style(number)
    heel = 1.15 * ahead
    fork = np.array([arm, arm + 0.75 * ahead, heel + 0.45 * arm, heel - 0.45 * arm])
    fork = np.concatenate([fork, [0.75 * ahead - arm, -arm]])
    _line(axes, centre + fork, style["color"], 2.4, "-")
    _line(axes, centre + np.outer([1.15, 2.1], ahead), style["color"], 5.0, "-")
    # The axis in the line style of its number, so that both shafts differ in black and white.
    _line(axes, centre + np.outer([0.0, 2.35], ahead), style["color"], 0.9, style["linestyle"])
    axes.text(*(centre + 2.6 * ahead), name, ha="center", va="center", weight="bold")


def _line(axes: Axes, points: Array, color: str, width: float, style: str) -> None:
    axes.plot(*points.T, color=color, linewidth=width, linestyle=style, solid_capstyle="round")


def _world_axis(turn: Sweep, joint: str) -> Array:
    """Return a joint's axis in the world `(N, 3)`."""
    axis = turn.rotation(joint) @ turn.mechanism.joint(joint).axis
    return np.broadcast_to(axis, (len(turn), 3))
