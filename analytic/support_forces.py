"""Forces on the support bearings of a double cardan shaft, at any position.

The shafts have the unit vectors e_1, e_2, e_3 along the power flow, in any arrangement in space;
the two joints lie the distance L apart. Crosses and the intermediate shaft carry no mass, there
is no friction, and the spline passes on no axial force. Then

    M_1 = T n_1 / (n_1 . e_1), moment of the input shaft on the intermediate shaft,
    M_2 = (M_1 . e_2) n_2 / (n_2 . e_2), moment of the intermediate shaft on the output shaft,
    P = (M_1 - M_2) x e_2 / L, force on the intermediate shaft at joint 1 (-P at joint 2),

with n_k normal to both pins of joint k. The input shaft carries (-P, -M_1), the output shaft
(+P, +M_2).

References:
    Catalogues of cardan shafts (Elbe, GWB), which print the two extreme positions;
    H. Ch. Seherr-Thoss, F. Schmelz, E. Aucktor: Universal Joints and Driveshafts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import dot, filled, plane_normal
from analytic._arrays import length as length_of
from analytic._checks import FloatArray, joint_angle, positive, real, refuse, same_shape, vector
from analytic.compound_angle import angle_between, offset_between

__all__ = [
    "ShaftWrenches",
    "Spans",
    "SupportForces",
    "double_shaft_wrenches",
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
