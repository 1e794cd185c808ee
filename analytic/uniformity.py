"""Uniformity of a drive line as makers judge it, and the angles that a limit allows.

Angles in radians, all arguments broadcast.

References:
    Catalogue of cardan shafts, chapter 6 (Klein), 6.4; Elbe, technical annex 3; engineersedge.com,
    vehicle driveline design; SAE Universal Joint and Driveshaft Design Manual AE-7.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import filled
from analytic._checks import FloatArray, joint_angle, not_negative, positive, same_shape
from analytic.drive_line import _joints, _turn

__all__ = [
    "AngleRange",
    "added_non_uniformity",
    "allowed_angle",
    "allowed_second_angle",
    "angle_of_non_uniformity",
]


class AngleRange(NamedTuple):
    """Least and greatest joint angle [rad]."""

    least: FloatArray
    greatest: FloatArray


def angle_of_non_uniformity(non_uniformity: ArrayLike) -> FloatArray:
    """Angle of a joint with this degree of non-uniformity, cos beta = (sqrt(U^2 + 4) - U) / 2.

    Args:
        non_uniformity: U = 1 / cos beta - cos beta, not negative.

    Returns:
        beta [rad], in the shape of `non_uniformity`.

    Raises:
        ValueError: an argument out of range.

    Source:
        Inverse of `single_joint.non_uniformity`.

    >>> round(float(np.degrees(angle_of_non_uniformity(0.0027))), 3)
    2.977
    """
    U = not_negative("non_uniformity", non_uniformity)
    cosine = 2.0 / (np.hypot(U, 2.0) + U)
    # sin^2 beta = U cos beta keeps the digits of small angles.
    return np.arctan2(np.sqrt(U * cosine), cosine)


def added_non_uniformity(betas: ArrayLike, phases: ArrayLike) -> FloatArray:
    """Degree of non-uniformity of a line as the sum of those of its joints, U = |sum +-U_k|.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad], as in `drive_line`; 0 and 90 degrees are + and -.

    Returns:
        U of shape (...). Of first order, as the sum of squares of `drive_line` is; the exact one
        is `single_joint.non_uniformity` of `drive_line.residual_angle`.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Elbe, technical annex 3.
    """
    betas, phases = _joints(betas, phases)
    return np.abs(np.sum(np.sin(betas) * np.tan(betas) * _turn(phases), axis=-1))


def allowed_angle(acceleration: ArrayLike, speed: ArrayLike) -> FloatArray:
    """Equivalent angle at which a line reaches an acceleration, beta = sqrt(epsilon) / omega.

    Args:
        acceleration: epsilon, greatest acceleration allowed [rad/s^2], not negative.
        speed: omega [rad/s], greater than 0.

    Returns:
        beta [rad], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Inverse of `drive_acceleration.angular_acceleration` for small angles.
    """
    epsilon, speed = not_negative("acceleration", acceleration), positive("speed", speed)
    same_shape(acceleration=epsilon, speed=speed)
    return np.sqrt(epsilon) / speed


def allowed_second_angle(
    beta_1: ArrayLike, acceleration: ArrayLike, speed: ArrayLike
) -> AngleRange:
    """Angles of the second joint of a shaft that keep a torsional acceleration.

    beta_2^2 = beta_1^2 -+ epsilon / omega^2, the joints with phases 90 degrees apart.

    Args:
        beta_1: angle of the first joint [rad], 0 <= beta_1 < pi/2.
        acceleration: epsilon, greatest acceleration allowed [rad/s^2], not negative.
        speed: omega [rad/s], greater than 0.

    Returns:
        Least and greatest beta_2 [rad], each in the broadcast shape; the least is 0 where no joint
        at all would keep the limit as well.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Inverse of `drive_acceleration.torsional_angle`; engineersedge.com tabulates the greatest
        for 400 rad/s^2.

    >>> greatest = allowed_second_angle(np.radians(9.0), 400.0, 1500 * np.pi / 30).greatest
    >>> round(float(np.degrees(greatest)), 1)
    11.6
    """
    beta_1 = joint_angle("beta_1", beta_1)
    spread = allowed_angle(acceleration, speed)
    shape = same_shape(beta_1=beta_1, limit=spread)
    least = np.sqrt(np.maximum((beta_1 - spread) * (beta_1 + spread), 0.0))
    return AngleRange(filled(least, shape), filled(np.hypot(beta_1, spread), shape))
