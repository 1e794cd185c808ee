"""Forces on the bearings of lines of two and more joints, with centre bearings.

Shafts 0 to n have the unit vectors e_0 ... e_n along the power flow; joint k connects shafts k - 1
and k. Each intermediate shaft k = 1 ... n - 2 has one centre bearing, the last one, k = n - 1, has
none and slides in a spline that passes on no axial force. Nothing has mass, there is no friction.
With the moments M_k that joint k passes on, and l_k the length of shaft k,

    Q = (M_(n-1) - M_n) x e_(n-1) / l_(n-1), force on the last intermediate shaft at its front,
    C_k = [l_k Q - (M_k - M_(k+1)) x e_k] / c_k, across e_k, force of the centre bearing on shaft k,

and what is left of the forces across shaft k stands at joint k, where it is the next Q. Forces
along a shaft go on to the front. Torques and moments as in `support_forces`, which is n = 2.

References:
    E. Klein's catalogue of cardan shafts, 7.1 and 7.2; Spicer DSAG-0200, centre bearing loading;
    for three and more joints own derivation from statics.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import dot, filled
from analytic._checks import FloatArray, positive, real, refuse, same_shape, vector
from analytic.compound_angle import angle_between, offset_between
from analytic.support_forces import (
    Spans,
    _checked,
    _in_plane,
    _on_bearings,
    _through_joint,
    _turned,
)

__all__ = ["LineSupportForces", "line_moments", "line_support_forces"]


class LineSupportForces(NamedTuple):
    """Forces that the shafts exert on their bearings [N].

    A and B: far and near bearing of the input shaft; E and F: near and far bearing of the output
    shaft, each (..., 3); centres: (..., n - 2, 3), centre bearings in the order of their shafts.
    """

    A: FloatArray
    B: FloatArray
    centres: FloatArray
    E: FloatArray
    F: FloatArray


def line_moments(
    axes: ArrayLike,
    phi_1: ArrayLike,
    torque: ArrayLike,
    fork_offsets: ArrayLike | None = None,
) -> FloatArray:
    """Moments that the joints of a line pass on, each on the shaft behind it.

    Args:
        axes: (..., n + 1, 3) directions of the shafts along the power flow, of any length;
            neighbours must make an angle below 90 degrees.
        phi_1: (...) rotation of the input shaft [rad]; at 0 its pin lies in the plane of joint 1.
        torque: (...) input torque [N m].
        fork_offsets: (..., n - 1) angles from the output fork of each joint to the input fork of
            the next, about their shaft in its sense of rotation [rad]. By default those with
            which both forks pass through their bending planes at the same time.

    Returns:
        (..., n, 3) moments M_k [N m].

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Moment normal to both pins (Thoma 1920), joint by joint.
    """
    shafts, phi_1, torque, offsets, shape = _line(axes, phi_1, torque, fork_offsets)
    directions = [shafts[..., k, :] for k in range(shafts.shape[-2])]
    third = directions[2] if len(directions) > 2 else directions[1]
    pin = _turned(_in_plane(directions[0], directions[1], third), directions[0], phi_1)
    moments, passed = [], torque
    for k in range(1, len(directions)):
        moment, pin = _through_joint(directions[k - 1], directions[k], pin, passed)
        moments.append(np.broadcast_to(moment, (*shape, 3)))
        passed = dot(moment, directions[k])
        if k + 1 < len(directions):
            pin = _turned(pin, directions[k], offsets[..., k - 1])
    return np.stack(moments, axis=-2)


def line_support_forces(
    axes: ArrayLike,
    phi_1: ArrayLike,
    torque: ArrayLike,
    lengths: ArrayLike,
    centres: ArrayLike,
    spans: Spans,
    fork_offsets: ArrayLike | None = None,
) -> LineSupportForces:
    """Forces of a line of joints on the bearings of its shafts.

    Args:
        axes: (..., n + 1, 3) directions of the shafts, as in `line_moments`, n at least 2.
        phi_1: (...) rotation of the input shaft [rad].
        torque: (...) input torque [N m].
        lengths: (..., n - 1) distances of neighbouring joints [m], each greater than 0.
        centres: (..., n - 2) distances of the centre bearings behind the front joint of their
            shaft [m], each greater than 0; empty for n = 2. A bearing beyond the rear joint is
            allowed.
        spans: distances of the bearings of input and output shaft, each (...).
        fork_offsets: (..., n - 1) angles between forks, as in `line_moments`.

    Returns:
        The forces [N], each across its shaft; what stands along the end shafts is not part of them.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Statics of the module's text; for n = 2 the catalogues' table.
    """
    moments = line_moments(axes, phi_1, torque, fork_offsets)
    shafts, count = vector("axes", axes), moments.shape[-2]
    if count < 2:
        raise ValueError(f"axes mark {count} joint: at least 2 are valid")
    lengths, centres = positive("lengths", lengths), positive("centres", centres)
    for name, values, size in (("lengths", lengths, count - 1), ("centres", centres, count - 2)):
        if values.shape[-1:] != (size,):
            raise ValueError(f"{name} of shape {values.shape} does not match (..., {size})")
    distances = _checked(spans)
    shape = same_shape(
        line=moments[..., 0, 0],
        lengths=lengths[..., 0],
        centres=np.empty(centres.shape[:-1]),
        **distances,
    )
    a, b, e, f = (distance[..., None] for distance in distances.values())
    jump = moments[..., :-1, :] - moments[..., 1:, :]
    turning = np.cross(jump, shafts[..., 1:-1, :])
    front = turning[..., -1, :] / lengths[..., -1, None]
    far_2, near_2 = _on_bearings(front, moments[..., -1, :], shafts[..., -1, :], e, f)
    carried = []
    for k in range(count - 3, -1, -1):
        along = shafts[..., k + 1, :]
        across = front - dot(front, along)[..., None] * along
        bearing = lengths[..., k, None] * across - turning[..., k, :]
        bearing = bearing / centres[..., k, None]
        carried.append(np.broadcast_to(-bearing, (*shape, 3)))
        front = front - bearing
    far_1, near_1 = _on_bearings(-front, -moments[..., 0, :], -shafts[..., 0, :], b, a)
    middle = np.stack(carried[::-1], axis=-2) if carried else np.zeros((*shape, 0, 3))
    ends = [filled(force, (*shape, 3)) for force in (far_1, near_1, near_2, far_2)]
    return LineSupportForces(ends[0], ends[1], middle, ends[2], ends[3])


def _line(
    axes: ArrayLike, phi_1: ArrayLike, torque: ArrayLike, fork_offsets: ArrayLike | None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, tuple[int, ...]]:
    """Unit vectors, rotation, torque, fork offsets and the shape of lines, checked."""
    shafts = vector("axes", axes)
    if shafts.ndim < 2 or shafts.shape[-2] < 2:
        raise ValueError(
            f"axes of shape {shafts.shape} does not match the valid shape (..., n + 1, 3), n >= 1"
        )
    angles = angle_between(shafts[..., :-1, :], shafts[..., 1:, :])
    refuse("angles of the joints in axes", angles, angles >= np.pi / 2, "[0, pi/2) rad")
    phi_1, torque = real("phi_1", phi_1), real("torque", torque)
    between = shafts.shape[-2] - 2
    if fork_offsets is None:
        offsets = offset_between(shafts[..., :-2, :], shafts[..., 1:-1, :], shafts[..., 2:, :])
    else:
        offsets = real("fork_offsets", fork_offsets)
        if offsets.shape[-1:] != (between,):
            raise ValueError(
                f"fork_offsets of shape {offsets.shape} does not match the valid (..., {between})"
            )
    shape = same_shape(
        axes=shafts[..., 0, 0],
        phi_1=phi_1,
        torque=torque,
        fork_offsets=np.empty(np.shape(offsets)[:-1]),
    )
    return shafts, phi_1, torque, np.asarray(offsets), shape
