"""Pin bearings: forces of a universal joint's bearings with and without clearance."""

from __future__ import annotations

import numpy as np

from ....figures.style import (
    Figure,
    Into,
    Size,
    curve_style,
    in_look,
    line_style,
    over,
    plain,
    sheet,
)
from ....kit.errors import ArgumentError
from ..scan_maps import ScanMap
from ..scan_results import JointScan


@in_look
def pin_forces(
    scanned: JointScan, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw what open bearings carry without clearance over the drive's angle, and the peaks.

    A point stands where the force swings round, as high as the greatest force of all that is known
    until the next reversal; it is hollow where the sides would not strike.

    Args:
        scanned: a joint of `clearance.scan`.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].
    """
    drawn = sheet(size=(7.2, 4.2), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    angle = np.rad2deg(scanned.position)
    for index, (name, bearing) in enumerate(scanned.by_bearing().items()):
        sizes = np.linalg.norm(bearing.force, axis=1)
        axes.plot(angle, sizes, label=plain(name), **curve_style(index, len(angle)))
    color = line_style(len(scanned.bearings))["color"]
    for struck, label in ((True, "peak with clearance"), (False, "peak without an impact")):
        some = [item for item in scanned.reversals if item.strikes is struck]
        if some:
            axes.plot(
                np.rad2deg([item.position for item in some]),
                [item.peak for item in some],
                linestyle="",
                marker="D",
                color=color,
                markerfacecolor=color if struck else "white",
                clip_on=False,
                zorder=3,
                label=label,
            )
    axes.set_ylabel("force across the pin [N]")
    over("drive", scanned.position, "rad").name(axes)
    return drawn.finish(title, 3)


@in_look
def pin_peaks(
    mapped: ScanMap, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw the greatest bearing force over speed, a line for each design, with and without it.

    Args:
        mapped: from `clearance.scan_map`.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: there is one speed only, which makes no line.
    """
    if len(mapped.speed) < 2:
        raise ArgumentError("there is one speed only; map several of them to draw a line")
    drawn = sheet(size=(7.2, 4.6), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    order = np.argsort(mapped.speed)
    speed = mapped.speed[order]
    (first, *_) = mapped.held
    for index, value in enumerate(mapped.held[first]):
        style = curve_style(index, len(speed))
        is_angle = mapped.units[first] == "rad"
        size = f"{np.rad2deg(value):.3g}°" if is_angle else f"{value:.4g} m"
        label = f"{plain(first)} {size}"
        axes.plot(speed, mapped.peak[index, order], label=f"{label}, with clearance", **style)
        thin = {**style, "linewidth": 0.8, "marker": ""}
        axes.plot(speed, mapped.rigid_peak[index, order], label=f"{label}, no clearance", **thin)
    axes.set_xlabel("speed of the drive [rad/s]")
    axes.set_ylabel("greatest force of a bearing [N]")
    return drawn.finish(title, 2)
