"""Torsion and bending of both shafts of a universal joint, after K. H. Grossmann (1939).

The moment vector of a massless, frictionless cross is normal to both pins. It swings about
shaft 1 by the angle psi_1 and about shaft 2 by psi_2. With D the torsion and B the bending
of a shaft, everything is referred to the input torque D_1.

Grossmann writes phi for the joint angle (here beta) and alpha_1, alpha_2 for the rotations
(here phi_1, phi_2). Rotations are counted from the position in which the pin axis of the input
fork lies in the plane of the shafts. Angles are in radians, all arguments broadcast, scalars
give NumPy floats, and an infinite rotation gives NaN.

Reference:
    K. H. Grossmann: Die Momente im Kreuzgelenk. Schweizerische Bauzeitung 113 (1939), no. 3.
    https://doi.org/10.5169/seals-50429
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _cross
from ._arrays import filled
from ._checks import FloatArray, joint_angle, real, same_shape

__all__ = [
    "Moments",
    "greatest_bending_2",
    "moment_size",
    "moments",
    "moments_from_output",
    "swing_angles",
    "swing_angles_from_output",
]


class Moments(NamedTuple):
    """Torsion (signed) and bending (size) of both shafts [N m]."""

    torsion_1: FloatArray
    bending_1: FloatArray
    torsion_2: FloatArray
    bending_2: FloatArray


def swing_angles(beta: ArrayLike, phi_1: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Angles between the moment vector and the two shafts, from the input rotation.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].

    Returns:
        psi_1 and psi_2 [rad], each in the broadcast shape and between -beta and beta;
        cos psi_1 cos psi_2 = cos beta.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Grossmann 1939 (2), (3) and (5).

    >>> psi_1, psi_2 = swing_angles(np.radians(50), np.pi / 2)
    >>> round(float(np.degrees(psi_1)), 9), abs(float(psi_2)) < 1e-15
    (50.0, True)
    """
    beta, phi_1 = joint_angle("beta", beta), real("phi_1", phi_1)
    same_shape(beta=beta, phi_1=phi_1)
    sine, cosine = np.sin(phi_1), np.cos(phi_1)
    sin_b, cos_b = np.sin(beta), np.cos(beta)
    root = np.sqrt(_cross.denominator(cos_b, sine, cosine))
    return np.arctan2(sin_b * sine, cos_b), np.arctan2(sin_b * cosine, root)


def swing_angles_from_output(beta: ArrayLike, phi_2: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Angles between the moment vector and the two shafts, from the output rotation.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_2: rotation of the output shaft [rad].

    Returns:
        psi_1 and psi_2 [rad], each in the broadcast shape and between -beta and beta.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Grossmann 1939 (2) and (4).
    """
    beta, phi_2 = joint_angle("beta", beta), real("phi_2", phi_2)
    same_shape(beta=beta, phi_2=phi_2)
    sine, cosine = np.sin(phi_2), np.cos(phi_2)
    sin_b, cos_b = np.sin(beta), np.cos(beta)
    root = np.sqrt(_cross.denominator(cos_b, cosine, sine))
    return np.arctan2(sin_b * sine, root), np.arctan2(sin_b * cosine, cos_b)


def moments(beta: ArrayLike, phi_1: ArrayLike, torque: ArrayLike = 1.0) -> Moments:
    """Torsion and bending of both shafts at a rotation of the input shaft.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].
        torque: input torque D_1 [N m]; with the default 1 the results are ratios to it.

    Returns:
        torsion_1, bending_1, torsion_2 and bending_2 [N m], each in the broadcast shape.
        Torsions carry the sign of the torque, bendings are sizes and never negative. Towards
        90 degrees they grow without bound, with full relative accuracy.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Grossmann 1939 (6), (7) and (8), first forms.

    >>> round(float(moments(np.radians(50), 0.0).torsion_2), 6)
    0.642788
    """
    beta, phi_1 = joint_angle("beta", beta), real("phi_1", phi_1)
    torque = real("torque", torque)
    shape = same_shape(beta=beta, phi_1=phi_1, torque=torque)
    sine, cosine = np.sin(phi_1), np.cos(phi_1)
    sin_b, cos_b = np.sin(beta), np.cos(beta)
    square = _cross.denominator(cos_b, sine, cosine)
    scale = torque / cos_b
    bend = np.abs(scale) * sin_b
    return Moments(
        torsion_1=filled(torque, shape),
        bending_1=bend * np.abs(sine),
        torsion_2=scale * square,
        bending_2=bend * np.abs(cosine) * np.sqrt(square),
    )


def moments_from_output(beta: ArrayLike, phi_2: ArrayLike, torque: ArrayLike = 1.0) -> Moments:
    """Torsion and bending of both shafts at a rotation of the output shaft.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_2: rotation of the output shaft [rad].
        torque: input torque D_1 [N m]; with the default 1 the results are ratios to it.

    Returns:
        torsion_1, bending_1, torsion_2 and bending_2 [N m], each in the broadcast shape, as
        in `moments`.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Grossmann 1939 (7), second form, and (8), second form without the square root that is
        printed over its denominator by mistake; (6) with (1).
    """
    beta, phi_2 = joint_angle("beta", beta), real("phi_2", phi_2)
    torque = real("torque", torque)
    shape = same_shape(beta=beta, phi_2=phi_2, torque=torque)
    sine, cosine = np.sin(phi_2), np.cos(phi_2)
    sin_b, cos_b = np.sin(beta), np.cos(beta)
    square = _cross.denominator(cos_b, cosine, sine)
    bend = np.abs(torque) * sin_b
    return Moments(
        torsion_1=filled(torque, shape),
        bending_1=bend * np.abs(sine) / np.sqrt(square),
        torsion_2=torque * cos_b / square,
        bending_2=bend * np.abs(cosine) / square,
    )


def moment_size(beta: ArrayLike, phi_1: ArrayLike, torque: ArrayLike = 1.0) -> FloatArray:
    """Size M of the moment that the cross or ring passes on.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].
        torque: input torque D_1 [N m].

    Returns:
        M = |D_1| / cos psi_1 [N m], in the broadcast shape, between |D_1| and |D_1| / cos beta.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Grossmann 1939, D_1 = M cos psi_1, with (3).
    """
    beta, phi_1 = joint_angle("beta", beta), real("phi_1", phi_1)
    torque = real("torque", torque)
    same_shape(beta=beta, phi_1=phi_1, torque=torque)
    cos_b = np.cos(beta)
    return np.abs(torque) / cos_b * np.sqrt(_cross.denominator(cos_b, np.sin(phi_1), np.cos(phi_1)))


def greatest_bending_2(beta: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Greatest bending B_2 / D_1 of the output shaft, and where it is reached.

    Up to 45 degrees it is sin beta at phi_1 = 0. Beyond, it is 1 / (2 cos beta) at
    cos phi_1 = 1 / (sqrt 2 sin beta). The input shaft's greatest is always tan beta, at 90 degrees.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.

    Returns:
        The ratio and the first phi_1 >= 0 [rad], each in the shape of `beta`.

    Raises:
        ValueError: beta out of range.

    Source:
        Stationary point of Grossmann 1939 (8), first form.

    >>> ratio, phi_1 = greatest_bending_2(np.radians(50))
    >>> round(float(ratio), 6), round(float(np.degrees(phi_1)), 3)
    (0.777862, 22.622)
    """
    beta = joint_angle("beta", beta)
    beyond = -np.cos(2.0 * beta)
    ratio = np.where(beyond > 0.0, 0.5 / np.cos(beta), np.sin(beta))[()]
    return ratio, np.arctan(np.sqrt(np.maximum(beyond, 0.0)))
