"""Angular accelerations by which a drive line of cardan shafts is judged.

The torsional acceleration excites the driven end, the inertia accelerations the shafts in
between: when the engine drives, each joint accelerates all shafts after it, when it brakes, all
shafts before it. Joints are given as in `analytic.drive_line`: `betas` and `phases` with the
joints along the last axis, phases of 0 and 90 degrees being the signs + and -.

Customary limits: torsional 300 to 400 rad/s^2, inertia 500 to 1000 rad/s^2.

References:
    SAE Universal Joint and Driveshaft Design Manual AE-7; VDI 2722.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from analytic._checks import FloatArray, not_negative, real, same_shape
from analytic.drive_line import _joints, _turn, residual_angle_approximate

__all__ = [
    "angular_acceleration",
    "inertia_coast_angle",
    "inertia_drive_angle",
    "n_beta_acceleration",
    "torsional_angle",
]


def torsional_angle(betas: ArrayLike, phases: ArrayLike) -> FloatArray:
    """Equivalent angle of the torsional excitation, theta^2 = |sum s_k beta_k^2|.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].

    Returns:
        theta [rad] of shape (...), the same as `drive_line.residual_angle_approximate`.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        SAE AE-7.
    """
    return residual_angle_approximate(betas, phases)


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


def _weighted(betas: FloatArray, phases: FloatArray, weights: FloatArray) -> FloatArray:
    return np.sqrt(np.abs(np.sum(weights * betas**2 * _turn(phases), axis=-1)))
