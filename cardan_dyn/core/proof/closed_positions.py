"""Closed positions: one whose loops are closed already is not left for another one.

Whether a loop is closed is judged by what its joint leaves no freedom: points that coincide, axes
that are the same line, planes that are the same. No coordinate of the loop is needed for that, so
that nothing of how these were found is relied on.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.errors import AccuracyError
from ..mechanism.frames import Frames
from .constraints import coupled_joints

if TYPE_CHECKING:
    from ..description.description import CouplingDescription, LoopDescription
    from ..mechanism.coordinates import Coordinates
    from ..mechanism.mechanism import Mechanism

_MOVED = 1e-2
"""Displacement of a body [rad, or a part of the characteristic length] that does not close a loop
which is open by no more than rounding, 1e-9, unless its condition number is ten million."""


def refuse_left(
    mechanism: Mechanism,
    loops: Iterable[int],
    couplings: Iterable[int],
    before: Array,
    after: Array,
) -> None:
    """Refuse a closed position that was found from another one, if that was closed itself.

    Args:
        mechanism: the mechanism.
        loops: indices of the loops that were to be closed.
        couplings: indices of the couplings that were to hold.
        before: `(size,)` coordinates from which it was found. Those of loops play no part, unless
            a coupling counts them.
        after: `(size,)` those that were found.

    Raises:
        AccuracyError: everything was closed before, and bodies were moved all the same.
    """
    coordinates, length = mechanism.coordinates, mechanism.characteristic_length
    away = np.abs(after - before) * coordinates.scale
    at_zero, neutral = before.copy(), coordinates.neutral()
    for loop in mechanism.loops:
        if loop.joint in coordinates.columns:
            own = coordinates.columns[loop.joint]
            away[own], at_zero[own] = 0.0, neutral[own]
    if np.max(away, initial=0.0) < _MOVED:
        return  # Without placing a body, since most positions are not left.
    description = mechanism.second_reading
    frames = Frames(description, coordinates)
    placed, found = frames.placed(at_zero[None, :]), frames.placed(after[None, :])
    bodies = [last for last in frames.last[: frames.tree] if last >= 0]
    moved = np.abs(found[bodies] - placed[bodies])
    moved[:, 3] /= length
    starts = frames.joint_frames(placed)
    deviations = [
        loop_deviation(
            description.loops[index],
            starts[frames.tree + index, :, :, 0],
            frames.ended(placed, index)[:, :, 0],
            length,
        )
        for index in loops
    ]
    deviations += [
        _slip(description.couplings[index], frames, coordinates, before) for index in couplings
    ]
    if np.max(moved) < _MOVED or max(deviations, default=np.inf) > NOTHING:
        return
    raise AccuracyError(
        f"{mechanism.name}: the loops are closed to {max(deviations):.1e} where a closed position "
        f"was looked for, and bodies were moved by {np.max(moved):.1e} all the same: please report "
        "it with the description",
        residual=float(np.max(moved)),
        tolerance=_MOVED,
        position=None,
    )


def loop_deviation(loop: LoopDescription, start: Array, end: Array, length: float) -> float:
    """Return how far a loop is from what its joint can make up for [rad, or part of the length].

    Args:
        loop: its description.
        start: `(4, 3)` its frame on the predecessor: three axes, then the origin, in world axes.
        end: `(4, 3)` likewise on the successor.
        length: characteristic length [m].
    """
    gap = (end[3] - start[3]) / length
    axis, other = loop.axis @ start[:3], loop.axis @ end[:3]
    turned = float(np.max(np.abs(end[:3] - start[:3])))
    tilted = float(np.max(np.abs(other - axis)))
    apart = float(np.max(np.abs(gap)))
    across = float(np.max(np.abs(np.cross(gap, axis))))
    along = abs(float(gap @ axis))
    if loop.type == "universal":
        return max(apart, abs(float(axis @ (loop.axis_2 @ end[:3]))))
    kept: dict[str, tuple[float, ...]] = {
        "fixed": (turned, apart),
        "revolute": (tilted, apart),
        "continuous": (tilted, apart),
        "prismatic": (turned, across),
        "cylindrical": (tilted, across),
        "planar": (tilted, along),
        "spherical": (apart,),
        "loose": (along,),
    }
    return max(kept[loop.type])


def _slip(
    coupling: CouplingDescription, frames: Frames, coordinates: Coordinates, x: Array
) -> float:
    """Return how far a coupling is from its ratio and offset, slides as they are [rad or m]."""
    first, second = (
        sum(float(x[coordinates.columns[name].start]) for name in names)
        for names in coupled_joints(coupling, frames)
    )
    bent = sum(value * first**power for power, value in enumerate(coupling.higher, 2))
    return abs(second - coupling.ratio * first - coupling.offset - bent)
