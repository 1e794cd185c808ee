"""Forces on the support bearings of cardan shafts: of two joints at any position, of lines of more.

The shafts of a double shaft have the unit vectors e_1, e_2, e_3 along the power flow, in any
arrangement in space; the two joints lie the distance L apart. Crosses and the intermediate shaft
carry no mass, there is no friction, and the spline passes on no axial force. Then

    M_1 = T n_1 / (n_1 . e_1), moment of the input shaft on the intermediate shaft,
    M_2 = (M_1 . e_2) n_2 / (n_2 . e_2), moment of the intermediate shaft on the output shaft,
    P = (M_1 - M_2) x e_2 / L, force on the intermediate shaft at joint 1 (-P at joint 2),

with n_k normal to both pins of joint k. The input shaft carries (-P, -M_1), the output shaft
(+P, +M_2).

Shafts 0 to n of a line have the unit vectors e_0 ... e_n along the power flow; joint k connects
shafts k - 1 and k. Each intermediate shaft k = 1 ... n - 2 has one centre bearing, the last one,
k = n - 1, has none and slides in a spline that passes on no axial force. Nothing has mass, there
is no friction. With the moments M_k that joint k passes on, and l_k the length of shaft k,

    Q = (M_(n-1) - M_n) x e_(n-1) / l_(n-1), force on the last intermediate shaft at its front,
    C_k = [l_k Q - (M_k - M_(k+1)) x e_k] / c_k, across e_k, force of the centre bearing on shaft k,

and what is left of the forces across shaft k stands at joint k, where it is the next Q. Forces
along a shaft go on to the front. With n = 2 this is the double shaft.

The couples with which a joint bends its shafts at two positions are the sizes of the bending
moments of Grossmann and Thoma at 0 and 90 degrees. For the same formulas Dana speaks of a flange
fork at right angles to the drawing plane and Elbe of a fork in the plane of deflection, so that
here the pin of the driving fork tells the positions: in the plane of the shafts, or normal to it.
SI units and radians.

References:
    Catalogues of cardan shafts (Elbe and its technical annex 2, GWB), which print the two extreme
    positions; Dana industrial drive shafts catalogue, axial forces; E. Klein's catalogue, chapter
    7; Spicer DSAG-0200, centre bearing loading; for three and more joints own derivation from
    statics; H. Ch. Seherr-Thoss, F. Schmelz, E. Aucktor: Universal Joints and Driveshafts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import dot, filled, plane_normal
from ._arrays import length as length_of
from ._checks import (
    FloatArray,
    joint_angle,
    not_negative,
    positive,
    real,
    refuse,
    same_shape,
    vector,
)
from .compound_angle import angle_between, offset_between
from .shaft_design import slip_force

__all__ = [
    "ForkCouples",
    "LineSupportForces",
    "ShaftWrenches",
    "Spans",
    "SupportForces",
    "axial_force",
    "axial_support_forces",
    "double_shaft_wrenches",
    "fork_couples",
    "line_moments",
    "line_support_forces",
    "planar_support_forces",
    "shaft_axes",
    "support_forces",
]


class Spans(NamedTuple):
    """Distances of the support bearings [m], each greater than 0 and of shape (...).

    The near bearings B and E stand the distances b and e from their joint, the far bearings A and F
    another a and f further away.
    """

    a: ArrayLike
    b: ArrayLike
    e: ArrayLike
    f: ArrayLike


class ShaftWrenches(NamedTuple):
    """Moments passed on by both joints [N m] and force on the intermediate shaft [N]."""

    moment_1: FloatArray
    moment_2: FloatArray
    force: FloatArray


class SupportForces(NamedTuple):
    """Forces at the bearings [N]: far A and near B of the input, near E and far F of the output."""

    A: FloatArray
    B: FloatArray
    E: FloatArray
    F: FloatArray


def shaft_axes(beta_1: ArrayLike, beta_2: ArrayLike, plane_offset: ArrayLike = 0.0) -> FloatArray:
    """Unit vectors of the three shafts of an arrangement, the intermediate shaft along x.

    Args:
        beta_1: angle of joint 1 [rad], 0 <= beta_1 < pi/2.
        beta_2: angle of joint 2 [rad], 0 <= beta_2 < pi/2.
        plane_offset: angle from the bending plane of joint 1 to that of joint 2 about x [rad]:
            0 in Z, pi in W, anything else in a spatial arrangement.

    Returns:
        (..., 3, 3), one shaft a row, the broadcast shape in front.

    Raises:
        ValueError: a joint angle out of range or shapes that do not match.

    Source:
        Catalogue chapter 6.1 to 6.3.
    """
    beta_1, beta_2 = joint_angle("beta_1", beta_1), joint_angle("beta_2", beta_2)
    plane_offset = real("plane_offset", plane_offset)
    shape = same_shape(beta_1=beta_1, beta_2=beta_2, plane_offset=plane_offset)
    axes = np.zeros((*shape, 3, 3))
    axes[..., 0, 0], axes[..., 0, 1] = np.cos(beta_1), np.sin(beta_1)
    axes[..., 1, 0] = 1.0
    axes[..., 2, 0] = np.cos(beta_2)
    axes[..., 2, 1] = np.sin(beta_2) * np.cos(plane_offset)
    axes[..., 2, 2] = np.sin(beta_2) * np.sin(plane_offset)
    return axes


def double_shaft_wrenches(
    axes: ArrayLike,
    phi_1: ArrayLike,
    torque: ArrayLike,
    length: ArrayLike,
    fork_offset: ArrayLike | None = None,
) -> ShaftWrenches:
    """Moments and force that a double shaft passes on.

    Args:
        axes: (..., 3, 3) directions of input, intermediate and output shaft, one a row, along the
            power flow and of any length; neighbours must make an angle below 90 degrees.
        phi_1: (...) rotation of the input shaft [rad]; at 0 its pin lies in the plane of input and
            intermediate shaft.
        torque: (...) input torque T [N m].
        length: (...) distance L of the joints [m], greater than 0.
        fork_offset: (...) angle from the output fork of joint 1 to the input fork of joint 2,
            about the intermediate shaft in its sense of rotation [rad]. By default the
            correct one, `compound_angle.offset_between`: both forks pass through their
            bending planes at the same time.

    Returns:
        moment_1, moment_2 [N m] and force P [N], each (..., 3). Their errors are relative to the
        size of the moments, also where P is a small difference.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Statics of the intermediate shaft with the moment of Thoma 1920 in both joints.
    """
    shafts = vector("axes", axes)
    if shafts.ndim < 2 or shafts.shape[-2] != 3:
        raise ValueError(f"axes of shape {shafts.shape} does not match the valid shape (..., 3, 3)")
    e_1, e_2, e_3 = shafts[..., 0, :], shafts[..., 1, :], shafts[..., 2, :]
    for name, beta in (("joint 1", angle_between(e_1, e_2)), ("joint 2", angle_between(e_2, e_3))):
        refuse(f"angle of {name} in axes", beta, beta >= np.pi / 2, "[0, pi/2) rad")
    phi_1, torque, length = real("phi_1", phi_1), real("torque", torque), positive("length", length)
    offset = (
        offset_between(e_1, e_2, e_3) if fork_offset is None else real("fork_offset", fork_offset)
    )
    same_shape(axes=e_1[..., 0], phi_1=phi_1, torque=torque, length=length, fork_offset=offset)

    pin = _turned(_in_plane(e_1, e_2, e_3), e_1, phi_1)
    moment_1, pin = _through_joint(e_1, e_2, pin, torque)
    pin = _turned(pin, e_2, offset)
    moment_2, _ = _through_joint(e_2, e_3, pin, dot(moment_1, e_2))
    force = np.cross(moment_1 - moment_2, e_2) / length[..., None]
    return ShaftWrenches(*np.broadcast_arrays(moment_1, moment_2, force))


def support_forces(
    axes: ArrayLike,
    phi_1: ArrayLike,
    torque: ArrayLike,
    length: ArrayLike,
    spans: Spans,
    fork_offset: ArrayLike | None = None,
) -> SupportForces:
    """Forces that the end shafts exert on their support bearings.

    The greatest value of a turn need not be at one of the two extreme positions of
    `planar_support_forces`: at E and F it can be some percent above both. Sweep phi_1.

    Args:
        axes: (..., 3, 3) directions of the shafts, as in `double_shaft_wrenches`.
        phi_1: (...) rotation of the input shaft [rad].
        torque: (...) input torque T [N m].
        length: (...) distance L of the joints [m], greater than 0.
        spans: distances of the bearings.
        fork_offset: (...) angle between the forks, as in `double_shaft_wrenches`.

    Returns:
        A, B, E and F [N], each (..., 3) in the shape to which all arguments broadcast, across
        their shaft. What P has along an end shaft (its
        thrust bearing carries it) is not part of them.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Statics of the end shafts.
    """
    distances = _checked(spans)
    wrenches = double_shaft_wrenches(axes, phi_1, torque, length, fork_offset)
    shape = same_shape(force=wrenches.force[..., 0], **distances)
    a, b, e, f = (distance[..., None] for distance in distances.values())
    shafts = vector("axes", axes)
    e_1, e_3 = shafts[..., 0, :], shafts[..., 2, :]
    far_1, near_1 = _on_bearings(-wrenches.force, -wrenches.moment_1, -e_1, b, a)
    far_2, near_2 = _on_bearings(wrenches.force, wrenches.moment_2, e_3, e, f)
    forces = (far_1, near_1, near_2, far_2)
    return SupportForces(*(filled(force, (*shape, 3)) for force in forces))


def planar_support_forces(
    beta_1: ArrayLike,
    beta_2: ArrayLike,
    torque: ArrayLike,
    length: ArrayLike,
    spans: Spans,
    arrangement: str = "Z",
) -> tuple[SupportForces, SupportForces]:
    """Sizes of the support forces of Z and W arrangements in both extreme positions.

    Args:
        beta_1: angle of joint 1 [rad], 0 <= beta_1 < pi/2.
        beta_2: angle of joint 2 [rad], 0 <= beta_2 < pi/2.
        torque: input torque T [N m].
        length: distance L of the joints [m], greater than 0.
        spans: distances of the bearings.
        arrangement: "Z" or "W", both with the correct fork position.

    Returns:
        The forces [N] with the input pin in the plane of the shafts, and with the pin
        perpendicular to it; each in the broadcast shape. The former are 0 in a Z arrangement of
        equal angles, the latter do not depend on the arrangement.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Catalogues of cardan shafts: P = T cos beta_1 (tan beta_1 -+ tan beta_2) / L gives
        A = P b/a, B = P (a+b)/a, F = P e/f, E = P (e+f)/f; perpendicular,
        A = B = T tan beta_1 / a and E = F = T sin beta_2 / (f cos beta_1).
    """
    if arrangement not in ("Z", "W"):
        raise ValueError(f"arrangement = {arrangement!r} is not one of 'Z', 'W'")
    beta_1, beta_2 = joint_angle("beta_1", beta_1), joint_angle("beta_2", beta_2)
    torque, length = np.abs(real("torque", torque)), positive("length", length)
    distances = _checked(spans)
    shape = same_shape(beta_1=beta_1, beta_2=beta_2, torque=torque, length=length, **distances)
    a, b, e, f = distances.values()
    cos_1, cos_2 = np.cos(beta_1), np.cos(beta_2)
    # sin(x -+ y) = cos x cos y (tan x -+ tan y) without the difference of tangents
    bend = np.sin(beta_1 - beta_2 if arrangement == "Z" else beta_1 + beta_2)
    P = torque * np.abs(bend) / (cos_2 * length)
    input_, output = torque * np.sin(beta_1) / (cos_1 * a), torque * np.sin(beta_2) / (cos_1 * f)
    in_plane = (P * b / a, P * (a + b) / a, P * (e + f) / f, P * e / f)
    normal = (input_, input_, output, output)
    return (
        SupportForces(*(filled(force, shape) for force in in_plane)),
        SupportForces(*(filled(force, shape) for force in normal)),
    )


def _checked(spans: Spans) -> dict[str, FloatArray]:
    return {name: positive(name, value) for name, value in spans._asdict().items()}


def _in_plane(e_1: FloatArray, e_2: FloatArray, e_3: FloatArray) -> FloatArray:
    """Unit vector across e_1 in the plane of joint 1, or of joint 2 if joint 1 is straight."""
    normal = plane_normal(e_1, e_2)
    # All three in line: no plane is marked, and any will do.
    for other in (e_3, np.eye(3)[np.argmin(np.abs(e_1), axis=-1)]):
        normal = np.where(length_of(normal)[..., None] == 0.0, plane_normal(e_1, other), normal)
    across = np.cross(normal, e_1)
    return across / length_of(across)[..., None]


def _turned(across: FloatArray, axis: FloatArray, angle: FloatArray) -> FloatArray:
    """A vector normal to `axis`, turned about it."""
    return np.cos(angle)[..., None] * across + np.sin(angle)[..., None] * np.cross(axis, across)


def _through_joint(
    driving: FloatArray, driven: FloatArray, pin: FloatArray, torque: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Moment with this torque about `driving`, and the pin of the driven fork."""
    driven_pin = np.cross(driven, pin)
    driven_pin = driven_pin / length_of(driven_pin)[..., None]
    normal = np.cross(pin, driven_pin)
    return (torque / dot(normal, driving))[..., None] * normal, driven_pin


def _on_bearings(
    force: FloatArray, moment: FloatArray, away: FloatArray, near: FloatArray, span: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Forces on the far and the near bearing of a shaft that leads away from its joint."""
    force = force - dot(force, away)[..., None] * away
    far = (np.cross(moment, away) - near * force) / span
    return far, force - far


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


def axial_force(
    torque: ArrayLike,
    beta: ArrayLike,
    radius: ArrayLike,
    friction: ArrayLike = 0.11,
    pressure: ArrayLike = 0.0,
    area: ArrayLike = 0.0,
) -> FloatArray:
    """Axial force of a spline: friction under torque, and grease pressed in.

    Args:
        torque: T [N m], of any sign.
        beta: joint angle [rad], 0 <= beta < pi/2.
        radius: mean radius of the spline [m], greater than 0.
        friction: coefficient of friction, not negative.
        pressure: of the lubricant [Pa], not negative; makers allow up to 15 bar.
        area: of the spline on which the lubricant acts [m^2], not negative.

    Returns:
        The size of the force [N], in the broadcast shape: `shaft_design.slip_force` plus pressure
        times area.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dana industrial drive shafts catalogue, p. 47.
    """
    slip = slip_force(torque, beta, radius, friction)
    pressure, area = not_negative("pressure", pressure), not_negative("area", area)
    same_shape(slip_force=slip, pressure=pressure, area=area)
    return slip + pressure * area


def axial_support_forces(
    force: ArrayLike, beta_1: ArrayLike, beta_2: ArrayLike, spans: Spans
) -> SupportForces:
    """Forces with which an axial force of the intermediate shaft loads the support bearings.

    Args:
        force: axial force F in the intermediate shaft [N], of any sign.
        beta_1: angle of joint 1 [rad], 0 <= beta_1 < pi/2.
        beta_2: angle of joint 2 [rad], 0 <= beta_2 < pi/2.
        spans: distances of the bearings.

    Returns:
        Sizes at A, B, E and F [N], each in the broadcast shape, in the plane of their joint: F sin
        beta times b/a, (a+b)/a, (e+f)/f and e/f. The thrust bearings carry F cos beta. They add to
        the forces of `support_forces` as vectors.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Klein 7.3; statics of the end shafts.
    """
    force = np.abs(real("force", force))
    beta_1, beta_2 = joint_angle("beta_1", beta_1), joint_angle("beta_2", beta_2)
    distances = _checked(spans)
    shape = same_shape(force=force, beta_1=beta_1, beta_2=beta_2, **distances)
    a, b, e, f = distances.values()
    front, rear = force * np.sin(beta_1), force * np.sin(beta_2)
    values = (front * b / a, front * (a + b) / a, rear * (e + f) / f, rear * e / f)
    return SupportForces(*(filled(value, shape) for value in values))


class ForkCouples(NamedTuple):
    """Bending couples of both shafts [N m], by the plane in which the driving pin lies."""

    input_in_plane: FloatArray
    output_in_plane: FloatArray
    input_normal: FloatArray
    output_normal: FloatArray


def fork_couples(beta: ArrayLike, torque: ArrayLike = 1.0) -> ForkCouples:
    """Bending couples of a joint at its two extreme positions.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        torque: torque T of the driving shaft [N m], of any sign.

    Returns:
        Driving pin in the plane of the shafts: 0 on the driving shaft, T sin beta on the driven;
        normal to it: T tan beta on the driving shaft, 0 on the driven. Sizes, each in the
        broadcast shape. T tan beta is the greatest couple of the driving shaft over a turn;
        T sin beta is exceeded in between above 45 degrees, `grossmann.greatest_bending_2`.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Klein chapter 7; Elbe, technical annex 2; Grossmann 1939 (6) and (8) at 0 and 90 degrees.

    >>> couples = fork_couples(np.radians(45.0), 100.0)
    >>> round(float(couples.output_in_plane), 4), round(float(couples.input_normal), 4)
    (70.7107, 100.0)
    """
    beta, torque = joint_angle("beta", beta), np.abs(real("torque", torque))
    shape = same_shape(beta=beta, torque=torque)
    # Zero times the torque, so that NaN stays NaN.
    none = 0.0 * torque * beta
    values = (none, torque * np.sin(beta), torque * np.tan(beta), none)
    return ForkCouples(*(filled(value, shape) for value in values))
