"""How evenly a drive line turns, as makers judge it, and the angles and speeds that a limit allows.

The torsional acceleration excites the driven end, with the equivalent angle
`drive_line.residual_angle_approximate`, the inertia accelerations the shafts in between: when the
engine drives, each joint accelerates all shafts after it, when it brakes, all shafts before it.
Joints are given as in `analytic.drive_line`: `betas` and `phases` with the joints along the last
axis, phases of 0 and 90 degrees being the signs + and -. Angles in radians, all arguments
broadcast.

Customary limits: torsional 300 to 400 rad/s^2, inertia 500 to 1000 rad/s^2.

References:
    Catalogue of cardan shafts, chapter 6 (Klein), 6.4; Elbe, technical annex 3; engineersedge.com,
    vehicle driveline design; SAE Universal Joint and Driveshaft Design Manual AE-7; VDI 2722.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, joint_angle, not_negative, positive, real, same_shape
from .drive_line import _joints, _turn

__all__ = [
    "AngleRange",
    "added_non_uniformity",
    "allowed_angle",
    "allowed_second_angle",
    "angle_of_non_uniformity",
    "angular_acceleration",
    "greatest_speed",
    "inertia_coast_angle",
    "inertia_drive_angle",
    "mass_acceleration_moment",
    "n_beta_acceleration",
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
        Inverse of `uniformity.angular_acceleration` for small angles.
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
        Inverse of `drive_line.residual_angle_approximate`; engineersedge.com tabulates the greatest
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


def inertia_drive_angle(betas: ArrayLike, phases: ArrayLike) -> FloatArray:
    """Equivalent angle of the inertia excitation in drive, theta^2 = |sum (n-k) s_k beta_k^2|.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].

    Returns:
        theta [rad] of shape (...); 0 for one joint, which has no shaft in between.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        SAE AE-7.

    >>> theta = inertia_drive_angle(np.radians([4.0, 4.0]), [0.0, np.pi / 2])
    >>> round(float(np.degrees(theta)), 12)
    4.0
    """
    betas, phases = _joints(betas, phases)
    return _weighted(betas, phases, np.arange(betas.shape[-1] - 1.0, -1.0, -1.0))


def inertia_coast_angle(betas: ArrayLike, phases: ArrayLike) -> FloatArray:
    """Equivalent angle of the inertia excitation in coast, theta^2 = |sum (k-1) s_k beta_k^2|.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].

    Returns:
        theta [rad] of shape (...); 0 for one joint, which has no shaft in between.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        SAE AE-7.
    """
    betas, phases = _joints(betas, phases)
    return _weighted(betas, phases, np.arange(float(betas.shape[-1])))


def angular_acceleration(
    theta: ArrayLike, speed: ArrayLike, *, small_angle: bool = False
) -> FloatArray:
    """Peak angular acceleration that belongs to an equivalent angle, omega^2 sin^2 theta.

    Args:
        theta: equivalent angle [rad], not negative.
        speed: angular speed of the input shaft [rad/s].
        small_angle: take omega^2 theta^2 instead, as some do.

    Returns:
        The acceleration [rad/s^2], in the broadcast shape. Both forms are of first order and fall
        short of omega^2 times `single_joint.greatest_acceleration`: at 10 degrees by 1.5 and
        0.5 %, at 20 degrees by 6.4 and 2.5 %.

    Raises:
        ValueError: theta negative or infinite or shapes that do not match.

    Source:
        SAE AE-7.
    """
    theta, speed = not_negative("theta", theta), real("speed", speed)
    same_shape(theta=theta, speed=speed)
    return (speed * (theta if small_angle else np.sin(theta))) ** 2


def n_beta_acceleration(speed_rpm: ArrayLike, beta_deg: ArrayLike) -> FloatArray:
    """Peak angular acceleration of a joint by the rule n * beta.

    omega^2 beta^2 = 3.3405e-6 (n beta)^2 with n in revolutions per minute and beta in degrees.

    Args:
        speed_rpm: speed of rotation [1/min].
        beta_deg: joint angle [deg], not negative.

    Returns:
        The acceleration [rad/s^2], in the broadcast shape.

    Raises:
        ValueError: beta_deg negative or infinite or shapes that do not match.

    Source:
        Rule of thumb of cardan shaft catalogues, which limit the product n * beta.

    >>> round(float(n_beta_acceleration(1000.0, 10.0)), 2)
    334.05
    """
    speed_rpm, beta_deg = real("speed_rpm", speed_rpm), not_negative("beta_deg", beta_deg)
    same_shape(speed_rpm=speed_rpm, beta_deg=beta_deg)
    return (speed_rpm * beta_deg * (np.pi / 30.0 * np.pi / 180.0)) ** 2


def greatest_speed(beta: ArrayLike, speed: ArrayLike, n_beta: ArrayLike) -> FloatArray:
    """Greatest speed of a joint by its limits of speed and of speed times angle.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        speed: greatest speed of the size [rad/s], greater than 0.
        n_beta: greatest product of speed and angle [rad^2/s], greater than 0; both of a size are
            in `limits.JOINT_SIZES`.

    Returns:
        The lesser of `speed` and n_beta / beta [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dana commercial drive shafts catalogue, influence of speed and deflection angle.
    """
    beta, speed = joint_angle("beta", beta), positive("speed", speed)
    n_beta = positive("n_beta", n_beta)
    same_shape(beta=beta, speed=speed, n_beta=n_beta)
    # The greater of both reciprocals: a straight joint has no limit of its angle.
    return 1.0 / np.maximum(1.0 / speed, beta / n_beta)


def mass_acceleration_moment(inertia: ArrayLike, beta: ArrayLike, speed: ArrayLike) -> FloatArray:
    """Greatest moment that accelerates the middle part of a shaft, M = J_2 epsilon_2.

    Args:
        inertia: J_2 of the middle part about its axis [kg m^2], not negative.
        beta: joint angle [rad], 0 <= beta < pi/2.
        speed: angular speed of the input shaft [rad/s].

    Returns:
        M = J_2 omega^2 beta^2 [N m], in the broadcast shape; of first order, see
        `angular_acceleration`.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dana industrial drive shafts catalogue p. 41, with the acceleration of the rule n * beta.
    """
    inertia, beta = not_negative("inertia", inertia), joint_angle("beta", beta)
    acceleration = angular_acceleration(beta, speed, small_angle=True)
    same_shape(inertia=inertia, acceleration=acceleration)
    return inertia * acceleration


def _weighted(betas: FloatArray, phases: FloatArray, weights: FloatArray) -> FloatArray:
    return np.sqrt(np.abs(np.sum(weights * betas**2 * _turn(phases), axis=-1)))
