"""Zero: where a description's joints are at zero, and the joints of its loops with them.

Where a loop's two frames stand to each other while the tree is at zero is the author's choice: pins
may be turned about their axes, and balls in any way. That is a position of the loop's own joint,
not a loop that is open.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

import numpy as np
import pinocchio

from ..arrays import Array, cardan_angles
from .joints import Joint, Part

if TYPE_CHECKING:
    from ..description.description import Description
    from .coordinates import Coordinates
    from .frames import Frames

OPEN = 1e-3
"""Angle [rad] and part of the characteristic length by which loops may be open at zero without a
word: what is written with four digits."""
_ROUNDING = 1e-12
"""Distance of a coordinate from the one that fits [rad, or lengths of the mechanism] up to which it
stays: rotations written as angles leave some 1e-16 times the number of frames between them."""
_UNDECIDED = 1e-9
"""Length of the vector whose direction an angle is, at most 1, below which it has none."""


def zero_of(description: Description, coordinates: Coordinates) -> Array:
    """Return coordinates `(size,)` at which all joints are at zero, those of loops as well.

    Joints that mimic others are where their offsets say.
    """
    x = coordinates.neutral()
    mimics = [item for item in description.couplings if item.of_joints]
    for _ in mimics:  # A joint may mimic one that mimics another itself, further below.
        for item in mimics:
            mimicked = x[coordinates.columns[item.predecessor].start]
            x[coordinates.columns[item.successor].start] = item.ratio * mimicked + item.offset
    return x


def fitted(
    frames: Frames,
    joints: Mapping[str, Joint],
    coordinates: Coordinates,
    x: Array,
    fixed: Collection[int] = (),
) -> Array:
    """Return coordinates `(size,)` with the joints of loops where they fit the tree.

    Each is where the two ends of its loop are nearest to each other, with angles within half a turn
    of where they were. All other joints stay.

    Args:
        frames: of the description.
        joints: of the mechanism by name.
        coordinates: layout of coordinates.
        x: `(size,)` coordinates; kept as they are.
        fixed: velocity coordinates that stay; a loop whose joint has one of them stays altogether.
    """
    chosen = {
        index: coordinates.columns[name]
        for index, name in enumerate(frames.joints[frames.tree :])
        if name in coordinates.columns and not _has_any(coordinates.velocity_columns[name], fixed)
    }
    if not chosen:
        return x
    result, at_zero, neutral = x.copy(), x.copy(), coordinates.neutral()
    for columns in chosen.values():
        at_zero[columns] = neutral[columns]
    placed = frames.placed(at_zero[None, :])
    starts = frames.joint_frames(placed)
    for index, columns in chosen.items():
        start = starts[frames.tree + index, :, :, 0]
        end = frames.ended(placed, index)[:, :, 0]
        rotation, offset = start[:3] @ end[:3].T, start[:3] @ (end[3] - start[3])
        parts = joints[frames.joints[frames.tree + index]].parts
        values = _values(parts, rotation, offset, x[columns])
        away = (values - x[columns]) * coordinates.scale[columns]
        if np.max(np.abs(away)) > _ROUNDING:
            result[columns] = values
    return result


def open_loops(
    frames: Frames, coordinates: Coordinates, x: Array, length: float
) -> dict[str, tuple[float, float]]:
    """Return by what angle [rad] and distance [m] loops are open.

    Args:
        frames: of the description.
        coordinates: layout of coordinates.
        x: `(size,)` coordinates.
        length: characteristic length [m].

    Returns:
        Those of the loops that are open by more than `OPEN`, as an angle or as a part of the
        length.
    """
    placed = frames.placed(x[None, :])
    starts = frames.joint_frames(placed)
    found = {}
    for index, name in enumerate(frames.joints[frames.tree :]):
        start, end = starts[frames.tree + index, :, :, 0], frames.ended(placed, index)[:, :, 0]
        # Squared differences of the axes of two frames add up to 2 (2 sin φ/2)².
        sine = 0.5 * float(np.sqrt(0.5 * np.sum((end[:3] - start[:3]) ** 2)))
        angle = 2.0 * float(np.arcsin(min(sine, 1.0)))
        gap = float(np.linalg.norm(end[3] - start[3]))
        if max(angle, gap / length) > OPEN:
            found[name] = angle, gap
    return found


def _has_any(columns: slice, fixed: Collection[int]) -> bool:
    return any(columns.start <= column < columns.stop for column in fixed)


def _values(parts: tuple[Part, ...], rotation: Array, offset: Array, near: Array) -> Array:
    """Return the coordinates of a joint that come nearest to a displacement.

    Slides come before turns in every joint, and are at right angles to each other, so that they
    alone shift the joint's origin.
    """
    slides = [part.axis @ offset for part in parts if part.kind == "prismatic"]
    turning = [part for part in parts if part.kind != "prismatic"]
    before = near[len(slides) :]
    if not turning:
        return np.array(slides)
    if turning[0].kind == "spherical":
        quaternion = np.array(pinocchio.Quaternion(rotation).coeffs())
        return np.array([*slides, *(-quaternion if quaternion @ before < 0.0 else quaternion)])
    angles = _angles([part.axis for part in turning], rotation, before)
    away = np.remainder(angles - before, 2.0 * np.pi)
    away[away > np.pi + _UNDECIDED] -= (
        2.0 * np.pi
    )  # Rounding does not decide the way of half turns.
    return np.array([*slides, *(before + away)])


def _angles(axes: list[Array], rotation: Array, near: Array) -> Array:
    """Return the angles of turns about one, two or three axes that come nearest to a rotation.

    Several axes are at right angles to each other, three of them right-handed.
    """
    if len(axes) == 1:
        (axis,) = axes
        along = axis @ rotation @ axis
        vector = pinocchio.unSkew(0.5 * (rotation - rotation.T))
        pairs = [(axis @ vector, 0.5 * (np.trace(rotation) - along))]
    elif len(axes) == 2:
        # The first turn alone moves the second axis, the second turn alone brings the first back.
        first, second = axes
        third = np.cross(first, second)
        moved, back = rotation @ second, rotation.T @ first
        pairs = [(third @ moved, second @ moved), (third @ back, first @ back)]
    else:
        basis = np.stack(axes, axis=1)
        return cardan_angles(pinocchio.Quaternion(basis.T @ rotation @ basis).coeffs())
    return np.array(
        [
            np.arctan2(sine, cosine) if np.hypot(sine, cosine) > _UNDECIDED else before
            for (sine, cosine), before in zip(pairs, near, strict=True)
        ]
    )
