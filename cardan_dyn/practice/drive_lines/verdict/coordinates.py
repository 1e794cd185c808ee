"""Coordinates: where all joints of the closed chain stand, in closed form."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....kit.arrays import Array, quaternion_product
from ..line.data import LineData
from ..line.geometry import Zero, centring_places, standing
from ..line.supports import supports, turning_balls
from .variants import Adjustable

_X, _Y, _Z = range(3)


def coordinates(
    line: LineData, positions: Array, moved: Mapping[Adjustable, Array]
) -> dict[str, Array] | None:
    """Return where the joints stand that move with the line; others stand as in the data.

    None for shafts that are off their axes, where loops alone say it.

    Args:
        line: the line.
        positions: of the input shaft, in the shape of the samples [rad].
        moved: adjustable joints to positions that broadcast with it.
    """
    if not _is_in_place(moved):
        return None
    found, none = line.geometry, np.zeros(())

    def changed(kind: str, nominal: Array) -> list[Array]:
        return [value + moved.get(Adjustable(kind, k), none) for k, value in enumerate(nominal, 1)]

    fork_offsets = changed("fork_offset", line.fork_offsets)
    there = standing(
        changed("joint_angle", found.joint_angles),
        changed("joint_plane", found.plane_offsets),
        fork_offsets,
        positions + line.zero.rotations[0],
        line.even,
    )
    driving, driven, rotations = (
        np.moveaxis(now - zero, -1, 0) for now, zero in zip(there, line.zero, strict=True)
    )
    known = {}
    for k in range(1, line.count + 1):
        has_place = k == line.count or bool(line.shafts[k].bearings)
        known[f"pin_{k}_in"] = driving[k - 1]
        if line.even[k - 1]:
            known[f"pin_{k}_bend"] = 2.0 * driven[k - 1]
            known[f"pin_{k}_turn" if has_place else f"pin_{k}_out"] = driving[k - 1]
        else:
            known[f"pin_{k}_out"] = driven[k - 1]
        if has_place:
            known["bearing_out" if k == line.count else f"bearing_{k}"] = rotations[k]
        if line.shafts[k].spline is not None:
            known[f"slip_{k}"] = moved.get(Adjustable("shaft_length", k), none)
    known |= {
        item.joint: _turn(_X, rotations[item.shaft]) for item in turning_balls(supports(line))
    }
    for k in line.centred:
        known |= _centring(line, there, fork_offsets[k - 1], k)
    return known


def _is_in_place(moved: Mapping[Adjustable, Array]) -> bool:
    """Return whether designs leave shafts on their axes, and bearings on their shafts."""
    lengths = {joint.of: item for joint, item in moved.items() if joint.kind == "shaft_length"}
    tubes = {joint.of: item for joint, item in moved.items() if joint.kind == "tube_length"}
    follow = all(np.array_equal(item, lengths.get(k, np.zeros(1))) for k, item in tubes.items())
    return follow and not any(joint.misaligns for joint in moved)


def _centring(line: LineData, there: Zero, fork_offset: Array, k: int) -> dict[str, Array]:
    """Return where the joints in the centring of coupling piece k stand.

    The centring itself rests, on the axes of both shafts.
    """
    # From the rear fork before the piece to the piece, and from there to the shaft behind it.
    steps = [
        _product(_turn(_Y, there.driving[..., i]), _turn(_Z, there.driven[..., i]))
        for i in (k - 1, k)
    ]
    fork = np.broadcast_to(_turn(_X, np.pi / 2 + fork_offset), steps[1].shape)
    steps[1] = _product(fork, steps[1])
    kind, found = line.shafts[k].centring, line.geometry
    if kind is not None and kind.kind == "ball":
        behind = _product(*steps)
        return {f"centring_{k}": behind if kind.fixed_to == "rear" else _back(behind)}
    before, _ = centring_places(line.shafts, found, k)
    _, y, z = found.frames[k].T @ (before * found.directions[k - 1])
    turned, zero = there.rotations[..., k], line.zero.rotations[k]
    return {
        f"disc_slide_{k}_y": y * (np.cos(turned) - np.cos(zero))
        + z * (np.sin(turned) - np.sin(zero)),
        f"disc_slide_{k}_z": z * (np.cos(turned) - np.cos(zero))
        - y * (np.sin(turned) - np.sin(zero)),
        f"centring_front_{k}": _back(steps[0]),
        f"centring_{k}": steps[1],
    }


def _turn(axis: int, angle: Array) -> Array:
    """Return the quaternions `(…, 4)` of turns about an axis."""
    result = np.zeros((*angle.shape, 4))
    result[..., axis], result[..., 3] = np.sin(angle / 2.0), np.cos(angle / 2.0)
    return result


def _product(first: Array, second: Array) -> Array:
    """Return the quaternions `(…, 4)` of one rotation after another."""
    return quaternion_product(first.reshape(-1, 4), second.reshape(-1, 4)).reshape(first.shape)


def _back(quaternions: Array) -> Array:
    """Return the quaternions `(…, 4)` of the inverse rotations."""
    return quaternions * [-1.0, -1.0, -1.0, 1.0]
