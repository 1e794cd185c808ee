"""Contact course: the force in a joint with clearance over a drive, beside that without."""

from __future__ import annotations

import numpy as np

from ....figures.style import (
    Axes,
    Figure,
    Into,
    Size,
    in_look,
    line_style,
    over,
    plain,
    point_style,
    sheet,
)
from ....kit.arrays import Array
from ....kit.checks import positive
from ..contact_simulation import ContactSimulation, finely
from ..scan_results import JointScan, Scan


@in_look
def contact_course(
    simulation: ContactSimulation,
    joint: str,
    *,
    scanned: Scan | None = None,
    turns: float = 1.0,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the force by which the wall presses the pin of a joint over the drive's position.

    Beside it, if they are given, the force of the mechanism without clearance, and the greatest
    force that is known after each reversal, at the position of its estimated impact.

    Args:
        simulation: from `clearance.simulate`.
        joint: with clearance, or one of its bearings.
        scanned: from `clearance.scan`, of the same mechanism and speed; none if None.
        turns: of the drive at the end of the simulation that are drawn; all if there are fewer.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ModelError: no such joint has clearance, or it was not scanned.
        ArgumentError: turns that are not positive, or a scan at another speed.

    Source:
        Dresig and Thümmel, Bild 6.
    """
    turns = positive("turns", turns)
    if scanned is not None:
        simulation.refuse_other_speed(scanned.speed)
    coarse = simulation[joint].position
    (kept,) = np.nonzero(np.abs(coarse - coarse[-1]) <= 2.0 * np.pi * turns)
    course = finely(simulation, joint, kept[0])
    position = course.position
    drawn = sheet(size=(7.2, 4.4), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    look = {**line_style(0), "linewidth": 1.0}
    axes.plot(np.rad2deg(position), course.force, **look, label="simulated, with clearance")
    if scanned is not None:
        _beside(axes, scanned.by_bearing().get(joint) or scanned[joint], scanned.speed, position)
    over(f"rotation of {simulation.drive}, all turns counted", position, "rad").name(axes)
    axes.set_ylabel(f"force in {plain(joint)} [N]")
    axes.set_ylim(bottom=0.0)
    return drawn.finish(title, 3)


def _beside(axes: Axes, joint: JointScan, speed: float, position: Array) -> None:
    """Draw the force without clearance, and the peaks of a scan."""
    rigid = np.linalg.norm(joint.force, axis=1)
    there = np.interp(position, joint.position, rigid, period=joint.period)
    axes.plot(np.rad2deg(position), there, **line_style(1), label="without clearance")
    low, high = float(np.min(position)), float(np.max(position))
    for item in joint.reversals:
        struck = item.position + speed * item.contact_time
        at = low + (struck - low) % joint.period
        while at <= high:
            axes.plot(np.rad2deg(at), item.peak, **point_style(1), label="peak of the scan")
            at += joint.period
