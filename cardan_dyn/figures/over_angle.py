"""Over the angle: torsion, bending and forces of joints, speed ratio and angle error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Unpack

import numpy as np

from ..kit.arrays import Array
from ..kit.checks import names
from ..kit.errors import ArgumentError
from .orders import EVEN
from .style import (
    Abscissa,
    Figure,
    Onto,
    Swept,
    drive_of,
    in_look,
    over,
    sheet,
)
from .wrenches import along, wrench_panels


@in_look
def over_angle(
    turn: Swept,
    joints: str | Sequence[str],
    quantities: str | Sequence[str] = ("torsion", "bending"),
    *,
    drive: str | None = None,
    peaks: bool | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw torsion and bending of joints, or their forces, over the position of the drive.

    What is drawn is exerted by the parent link on the child link, at the joint origin. A star marks
    what statics leaves open.

    Args:
        turn: the sweep, or a trajectory.
        joints: one joint or several; each is a line.
        quantities: of `torsion`, `bending`, `axial`, `shear`; each has its own axes.
        drive: joint whose angle [°], or slide [m], is the abscissa; the first drive if not given.
        peaks: label the greatest and the least value of each line; nothing if False; the greater
            one by size, of few lines, if None.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            as many axes as there are quantities.

    Raises:
        ModelError: a joint is unknown, not among the outputs, or has no axis.
        ArgumentError: unknown quantity, a sweep over several dimensions, or another number of axes.
    """
    at = along(turn, drive_of(turn, drive))
    given = names("quantities", quantities)
    return wrench_panels(turn, names("joints", joints), at, given, peaks=peaks, **onto)


@in_look
def ratio_and_angle_error(
    turns: Mapping[str, Swept],
    *,
    output: str = "bearing_out",
    drive: str | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw speed ratio and angle error of an output, one line per sweep.

    The angle error is the lead of the output over the drive, output angle minus drive angle; a
    constant part of it is left out.

    Args:
        turns: label to sweep or trajectory, one at least. Each must cover whole turns for
            its mean lead to be left out.
        output: joint whose motion is shown.
        drive: the drive that it is compared with; the first drive of each sweep if not given.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            two axes.

    Raises:
        ModelError: unknown joint.
        ArgumentError: no sweep, one over several dimensions, `drive` is not a drive of one, or
            it slides; other than two axes.
    """
    if not turns:
        raise ArgumentError("there is no sweep to be drawn")
    drawn = sheet(2, size=(7.2, 6.0), share_x=True, **onto)
    (ratio, lead), first = drawn.panels, drawn.drawn()
    angles: list[Array] = []
    drives: list[str] = []
    for index, (label, turn) in enumerate(turns.items()):
        drives.append(drive_of(turn, drive))
        coordinate = turn.mechanism.drivable.get(drives[-1])
        if coordinate is not None and coordinate.slides:
            raise ArgumentError(
                f"drive {drives[-1]!r} slides; an angle error is that of joints that turn. See "
                "turn.motion.ratio and figures.over_angle"
            )
        angle = turn.motion.position(drives[-1])
        # What is whole turns apart is the same position, and drawn at it.
        start = angles[0][0] if angles else angle[0]
        angle = angle - 2.0 * np.pi * np.round((angle[0] - start) / (2.0 * np.pi))
        error = turn.motion.position(output) - angle
        at = Abscissa(np.rad2deg(angle), "")
        at.draw(ratio, {label: turn.motion.ratio(output, drives[-1])}, first + index)
        at.draw(lead, {label: np.rad2deg(error - _mean(error, angle))}, first + index)
        angles.append(angle)
    over(", ".join(dict.fromkeys(drives)), np.concatenate(angles), "rad").name(lead)
    ratio.set_ylabel("speed ratio ω₂/ω₁ [–]")
    lead.set_ylabel("angle error φ₂ − φ₁ [°]")
    return drawn.finish(columns=3)


def _mean(values: Array, angle: Array) -> float:
    """Return the mean of values `(N,)` over the angle, or over the samples where it turns back.

    The samples of a trajectory are not evenly spaced along the angle.
    """
    steps = np.diff(angle)
    is_uneven = len(steps) > 0 and np.ptp(steps) > EVEN * np.max(np.abs(steps))
    if is_uneven and (np.all(steps > 0.0) or np.all(steps < 0.0)):
        return float(np.trapezoid(values, angle) / np.sum(steps))
    # A whole turn ends where it starts, and the mean must not count this position twice.
    return float(np.mean(values[:-1] if len(values) > 1 else values))
