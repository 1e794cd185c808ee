"""Bearing axes: along, to the left and upwards at each bearing, in each design of a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Array
from .geometry import Geometry, leftwards


def bearing_axes(
    found: Geometry, held: Mapping[str, Array], places: Sequence[tuple[int, float]]
) -> Array:
    """Return rotations from the axes of each bearing's place to along, left and up.

    Joint angles and planes turn the places of all shafts behind them. Misalignments do not: a
    bearing's axes are those of its housing.

    Args:
        found: geometry of the line.
        held: adjustable joints to their positions `(D, 1)`, which count from the data.
        places: shaft of each bearing, and how far its place is turned about it in the data [rad].

    Returns:
        `(D, m, 3, 3)`, or `(1, m, 3, 3)` if no design turns them.
    """
    frames = found.frames[:, None]
    if any(name.startswith(("joint_angle_", "joint_plane_")) for name in held):
        frames = _frames(found, held)
    axes = []
    for shaft, turned in places:
        housings = [leftwards(frame[:, 0]) for frame in frames[shaft]]
        left = np.array(housings)
        along = frames[shaft][:, :, 0]
        axes.append(np.stack([along, left, np.cross(along, left)], axis=1) @ frames[shaft])
        axes[-1] = axes[-1] @ _about(0, np.array([turned]))
    return np.stack(axes, axis=1)


def _frames(found: Geometry, held: Mapping[str, Array]) -> Array:
    """Return the frames of all shafts in each design `(n + 1, D, 3, 3)`; see `Geometry`."""
    count = max(len(values) for values in held.values())
    frames = [np.broadcast_to(found.frames[0], (count, 3, 3))]
    nominal = zip(found.plane_offsets, found.joint_angles, strict=True)
    for k, (plane, angle) in enumerate(nominal, 1):
        planes = plane + held.get(f"joint_plane_{k}", np.zeros((count, 1)))[:, 0]
        angles = angle + held.get(f"joint_angle_{k}", np.zeros((count, 1)))[:, 0]
        frames.append(frames[-1] @ _about(0, planes) @ _about(2, angles))
    return np.stack(frames)


def _about(axis: int, angles: Array) -> Array:
    """Return rotations `(D, 3, 3)` about x (0) or z (2)."""
    result = np.zeros((len(angles), 3, 3))
    one, two = (axis + 1) % 3, (axis + 2) % 3
    result[:, axis, axis] = 1.0
    result[:, one, one] = result[:, two, two] = np.cos(angles)
    result[:, two, one], result[:, one, two] = np.sin(angles), -np.sin(angles)
    return result
