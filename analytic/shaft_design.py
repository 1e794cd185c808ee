"""Design checks of a cardan shaft: critical speed, joint life and spline force.

SI units and radians throughout, all arguments broadcast.

References:
    Catalogues of cardan shafts (GWB, Elbe); SAE Universal Joint and Driveshaft Design Manual
    AE-7; H. Ch. Seherr-Thoss, F. Schmelz, E. Aucktor: Universal Joints and Driveshafts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analytic._checks import (
    FloatArray,
    joint_angle,
    not_negative,
    positive,
    real,
    refuse,
    same_shape,
)

__all__ = [
    "critical_speed",
    "duty_cycle_life",
    "joint_life",
    "joint_life_from_capacity",
    "slip_force",
    "speed_is_permissible",
]

_SUM_TOLERANCE = 1e-9
"""By how much the sum of shares of time may differ from 1: far more than the rounding of many
shares, and less than the digits with which shares are known."""


def critical_speed(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    length: ArrayLike,
    modulus: ArrayLike = 2.1e11,
    density: ArrayLike = 7850.0,
) -> FloatArray:
    """First critical bending speed of a tube supported simply at both ends.

    omega = pi^2 / (4 L^2) sqrt(E / rho) sqrt(D^2 + d^2). For steel, with n in 1/min and lengths
    in mm, n = 1.2187e8 sqrt(D^2 + d^2) / L^2.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D; 0 for a solid shaft.
        length: L between the joints [m], greater than 0.
        modulus: Young's modulus E [Pa], greater than 0.
        density: rho [kg/m^3], greater than 0.

    Returns:
        omega [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Euler-Bernoulli beam. Elbe prints 1.21e8 for 1.2187e8; AE-7 prints 4.705e6 for inches,
        which is 1.195e8 for mm.

    >>> omega = critical_speed(0.1, 0.094, 1.5)
    >>> round(float(omega * 30 / np.pi))
    7434
    """
    outer, inner = (
        positive("outer_diameter", outer_diameter),
        not_negative("inner_diameter", inner_diameter),
    )
    length, modulus = positive("length", length), positive("modulus", modulus)
    density = positive("density", density)
    same_shape(
        outer_diameter=outer, inner_diameter=inner, length=length, modulus=modulus, density=density
    )
    inner_full, outer_full = np.broadcast_arrays(inner, outer)
    refuse("inner_diameter", inner_full, inner_full >= outer_full, "[0, outer_diameter)")
    return np.square(np.pi / (2.0 * length)) * np.sqrt(modulus / density) * np.hypot(outer, inner)


def speed_is_permissible(
    speed: ArrayLike,
    critical: ArrayLike,
    share: ArrayLike = 0.75,
    half_critical: tuple[float, float] = (0.42, 0.58),
) -> NDArray[np.bool_]:
    """Whether a speed is below 0.75 of the critical speed and not between 0.42 and 0.58 of it.

    The second order of the joints excites bending at half the critical speed, noticeably from
    joint angles of some 3 degrees on (Dana).

    Args:
        speed: speed of rotation, in the unit of `critical`, not negative.
        critical: critical speed, greater than 0.
        share: greatest share of the critical speed, greater than 0; makers state 0.65 (industrial)
            to 0.75, see `limits.LIMITS`.
        half_critical: shares of the critical speed between which it must not be.

    Returns:
        True or False, in the broadcast shape; False where an argument is NaN.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Catalogue practice; the half-critical speed is Thoma's omega_n / 2 (1920).
    """
    speed, critical = not_negative("speed", speed), positive("critical", critical)
    share = positive("share", share)
    same_shape(speed=speed, critical=critical, share=share)
    ratio, (low, high) = speed / critical, half_critical
    return (ratio <= share) & ~((ratio >= low) & (ratio <= high))


def joint_life(
    speed: ArrayLike,
    beta: ArrayLike,
    torque: ArrayLike,
    rated_torque: ArrayLike,
    shock_factor: ArrayLike = 1.0,
) -> FloatArray:
    """Life of the bearings of a joint, from its rated torque.

    L_h = 1.5e6 / (n beta K) (T_D / T)^(10/3), n in 1/min, beta in degrees.

    Args:
        speed: speed of rotation [rad/s], greater than 0.
        beta: joint angle [rad], 0 <= beta < pi/2; below 3 degrees it counts as 3 degrees.
        torque: T [N m], greater than 0.
        rated_torque: T_D [N m], the torque of 5000 h at n beta = 300, greater than 0.
        shock_factor: K, greater than 0; it divides the life as in `joint_life_from_capacity`, of
            which this is the same form, L_C = 1.5e-4 T_D^(10/3) with T_D in kN m.

    Returns:
        The life [h], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Catalogues of cardan shafts.

    >>> float(np.round(joint_life(100 * np.pi / 30, np.radians(3), 800.0, 800.0), 6))
    5000.0
    """
    torque, rated = positive("torque", torque), positive("rated_torque", rated_torque)
    shock = positive("shock_factor", shock_factor)
    n_beta = _n_beta(speed, beta, torque=torque, rated_torque=rated, shock_factor=shock)
    return 1.5e6 / (n_beta * shock) * np.power(rated / torque, 10.0 / 3.0)


def joint_life_from_capacity(
    speed: ArrayLike,
    beta: ArrayLike,
    torque: ArrayLike,
    capacity: ArrayLike,
    shock_factor: ArrayLike = 1.0,
) -> FloatArray:
    """Life of the bearings of a joint, from its capacity factor.

    L_h = L_C 1e10 / (n beta T^(10/3) K), n in 1/min, beta in degrees, T in kN m.

    Args:
        speed: speed of rotation [rad/s], greater than 0.
        beta: joint angle [rad], 0 <= beta < pi/2; below 3 degrees it counts as 3 degrees.
        torque: T [N m], greater than 0.
        capacity: capacity factor L_C of the joint, from its catalogue, greater than 0.
        shock_factor: K, greater than 0.

    Returns:
        The life [h], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Catalogue of GWB.
    """
    torque, capacity = positive("torque", torque), positive("capacity", capacity)
    shock = positive("shock_factor", shock_factor)
    n_beta = _n_beta(speed, beta, torque=torque, capacity=capacity, shock_factor=shock)
    return capacity * 1e10 / (n_beta * np.power(torque / 1e3, 10.0 / 3.0) * shock)


def duty_cycle_life(shares: ArrayLike, lives: ArrayLike) -> FloatArray:
    """Life under a duty cycle, 1 / sum(q_i / L_i).

    Args:
        shares: (..., n) shares q_i of the time, not negative, with sum 1 along the last axis.
        lives: (..., n) lives L_i under each condition alone, greater than 0; inf is allowed.

    Returns:
        The life of shape (...), in the unit of `lives`.

    Raises:
        ValueError: an argument out of range, a sum other than 1 (by 1e-9) or shapes that do not
            match.

    Source:
        Linear damage rule (Palmgren, Miner) of the catalogues.
    """
    shares, lives = _shares(shares), np.atleast_1d(positive("lives", lives, unlimited=True))
    same_shape(shares=shares, lives=lives)
    with np.errstate(divide="ignore"):
        return 1.0 / np.sum(shares / lives, axis=-1)


def slip_force(
    torque: ArrayLike, beta: ArrayLike, radius: ArrayLike, friction: ArrayLike = 0.11
) -> FloatArray:
    """Axial force with which a spline resists sliding under torque, T mu cos beta / r_m.

    Args:
        torque: T [N m], of any sign.
        beta: joint angle [rad], 0 <= beta < pi/2.
        radius: mean radius r_m of the spline [m], greater than 0.
        friction: coefficient mu, not negative; about 0.11 for greased steel and 0.08 for coated
            splines.

    Returns:
        The size of the force [N], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Catalogues of cardan shafts.
    """
    torque, beta = real("torque", torque), joint_angle("beta", beta)
    radius, friction = positive("radius", radius), not_negative("friction", friction)
    same_shape(torque=torque, beta=beta, radius=radius, friction=friction)
    return np.abs(torque) * friction * np.cos(beta) / radius


def _shares(shares: ArrayLike) -> FloatArray:
    """Shares of time with sum 1 along the last axis."""
    shares = np.atleast_1d(not_negative("shares", shares))
    total = np.sum(shares, axis=-1)
    refuse(
        "sum of shares", total, np.abs(total - 1.0) > _SUM_TOLERANCE, f"1 within {_SUM_TOLERANCE:g}"
    )
    return shares


def _n_beta(speed: ArrayLike, beta: ArrayLike, **others: FloatArray) -> FloatArray:
    """Speed times angle in degrees per minute, the angle at least 3 degrees."""
    speed, beta = positive("speed", speed), joint_angle("beta", beta)
    same_shape(speed=speed, beta=beta, **others)
    return speed * (30.0 / np.pi) * np.maximum(np.degrees(beta), 3.0)
