"""Design of a cardan shaft: its critical speed and tube; life, rating and choice of its joints.

Three ratings of joints are not exchangeable: the rated torque T_D of `joint_life` is the torque of
5000 h at n beta = 300 degrees/min, the capacity factor L_C of `joint_life_from_capacity` is another
one, and a torque of `design_torque.selection_torque` belongs to a third. In lives, angles below
3 degrees count as 3 degrees. SI units and radians throughout, all arguments broadcast.

References:
    Catalogues of cardan shafts (GWB, Elbe); SAE Universal Joint and Driveshaft Design Manual
    AE-7; AISCO, universal joint sizing; DIN 808; JW Winco, determining the size of universal
    joints; S. Timoshenko: Strength of Materials; PSS.DriveshaftCalculations, Tube;
    H. Ch. Seherr-Thoss, F. Schmelz, E. Aucktor: Universal Joints and Driveshafts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import filled
from ._checks import (
    FloatArray,
    joint_angle,
    not_negative,
    positive,
    real,
    refuse,
    same_shape,
)

__all__ = [
    "EquivalentDuty",
    "critical_speed",
    "duty_cycle_life",
    "equivalent_duty",
    "joint_life",
    "joint_life_from_capacity",
    "mean_life",
    "precision_joint_factor",
    "precision_joint_torque",
    "required_capacity",
    "required_rated_torque",
    "shear_stress",
    "slip_force",
    "speed_is_permissible",
    "torsional_stiffness",
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


class EquivalentDuty(NamedTuple):
    """One torque [N m], speed [rad/s] and joint angle [rad] that wear a joint like a duty cycle."""

    torque: FloatArray
    speed: FloatArray
    beta: FloatArray


def required_rated_torque(
    torque: ArrayLike,
    speed: ArrayLike,
    beta: ArrayLike,
    life: ArrayLike,
    shock_factor: ArrayLike = 1.0,
) -> FloatArray:
    """Rated torque T_D that a joint needs for a life, T_D = T (L_h n beta K / 1.5e6)^0.3.

    Args:
        torque: T [N m], greater than 0.
        speed: speed of rotation [rad/s], greater than 0.
        beta: joint angle [rad], 0 <= beta < pi/2; below 3 degrees it counts as 3 degrees.
        life: L_h, B10 life that is asked for [h], greater than 0.
        shock_factor: K, greater than 0.

    Returns:
        T_D [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        AISCO, II, solved for T_c; inverse of `shaft_design.joint_life`.

    >>> round(float(required_rated_torque(1000.0, 1450 * np.pi / 30, np.radians(7), 2000.0)))
    2185
    """
    torque, life = positive("torque", torque), positive("life", life)
    shock = positive("shock_factor", shock_factor)
    n_beta = _n_beta(speed, beta, torque=torque, life=life, shock_factor=shock)
    return torque * (life * n_beta * shock / 1.5e6) ** 0.3


def required_capacity(
    torque: ArrayLike,
    speed: ArrayLike,
    beta: ArrayLike,
    life: ArrayLike,
    shock_factor: ArrayLike = 1.0,
) -> FloatArray:
    """Capacity factor L_C that a joint needs for a life, L_C = L_h n beta T^(10/3) K / 1e10.

    Args:
        torque: T [N m], greater than 0.
        speed: speed of rotation [rad/s], greater than 0.
        beta: joint angle [rad], 0 <= beta < pi/2; below 3 degrees it counts as 3 degrees.
        life: L_h, B10 life that is asked for [h], greater than 0.
        shock_factor: K, greater than 0.

    Returns:
        L_C, for T in kN m, in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Inverse of `shaft_design.joint_life_from_capacity`. PSS, which has the same form, counts
        angles below 3 degrees as they are.
    """
    torque, life = positive("torque", torque), positive("life", life)
    shock = positive("shock_factor", shock_factor)
    n_beta = _n_beta(speed, beta, torque=torque, life=life, shock_factor=shock)
    return life * n_beta * (torque / 1e3) ** (10.0 / 3.0) * shock / 1e10


def mean_life(life: ArrayLike, factor: ArrayLike = 5.0) -> FloatArray:
    """Mean life of joints, of which 90 % reach the B10 life.

    Args:
        life: B10 life [h], not negative.
        factor: mean over B10 life, greater than 0.

    Returns:
        The mean life [h], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        AISCO: the average is typically 5 times the B10 life.
    """
    life, factor = not_negative("life", life), positive("factor", factor)
    same_shape(life=life, factor=factor)
    return life * factor


def equivalent_duty(
    shares: ArrayLike, torques: ArrayLike, speeds: ArrayLike, betas: ArrayLike
) -> EquivalentDuty:
    """One steady condition with the life of a duty cycle.

    T_eq = (sum q n beta T^(10/3) / sum q n beta)^0.3, at the mean speed and at the angle at which
    n beta is the mean of n beta. `joint_life` of it is the life of `shaft_design.duty_cycle_life`.

    Args:
        shares: (..., k) shares q of the time, not negative, with sum 1 along the last axis.
        torques: (..., k) torques [N m]; 0 for idling, negative for coasting, which counts by its
            size, as if it loaded the same rollers.
        speeds: (..., k) speeds of rotation [rad/s], not negative; 0 at rest.
        betas: (..., k) joint angles [rad], each 0 <= beta < pi/2; below 3 degrees it counts as 3.

    Returns:
        torque, speed and beta, each of shape (...). Rows without torque or at rest do no damage,
        but their time counts.

    Raises:
        ValueError: an argument out of range, a cycle that never turns, a sum of shares other than
            1 (by 1e-9) or shapes that do not match.

    Source:
        AE-7 p. 31 and AISCO, III, as one condition; from the linear damage rule.
    """
    shares, torques = _shares(shares), np.abs(np.atleast_1d(real("torques", torques)))
    speeds = np.atleast_1d(not_negative("speeds", speeds))
    angles = np.maximum(np.atleast_1d(joint_angle("betas", betas)), np.radians(3.0))
    shape = same_shape(shares=shares, torques=torques, speeds=speeds, betas=angles)
    mean = np.sum(np.broadcast_to(shares * speeds, shape), axis=-1)
    refuse("mean of speeds", mean, mean <= 0.0, "(0, inf)")
    turned = np.broadcast_to(shares * speeds * angles, shape)
    n_beta = np.sum(turned, axis=-1)
    # Relative to the greatest torque, whose power cannot overflow.
    greatest = np.max(np.broadcast_to(torques, shape), axis=-1)
    unit = np.where(greatest > 0.0, greatest, 1.0)
    damage = np.sum(turned * (torques / unit[..., None]) ** (10.0 / 3.0), axis=-1)
    values = (unit * (damage / n_beta) ** 0.3, mean, n_beta / mean)
    return EquivalentDuty(*(filled(value, shape[:-1]) for value in values))


def precision_joint_factor(beta: ArrayLike, factors: Mapping[float, float]) -> FloatArray:
    """Factor k by which the torque of a precision joint is raised for its angle.

    Args:
        beta: joint angle [rad], from 0 to the last angle of the table.
        factors: k by the angle in degrees, such as `limits.DIN_808_FACTORS["plain"]`.

    Returns:
        k, linear between the angles of the table and that of the first below it, in the shape of
        `beta`.

    Raises:
        ValueError: beta out of range, or a table without angles.

    Source:
        DIN 808 by `limits.DIN_808_FACTORS`. Makers' charts differ by up to 20 % between the
        angles of the table.

    >>> from cardan_dyn.analytic.limits import DIN_808_FACTORS
    >>> round(float(precision_joint_factor(np.radians(30.0), DIN_808_FACTORS["plain"])), 9)
    2.2
    """
    beta = joint_angle("beta", beta)
    if not factors:
        raise ValueError(f"factors = {factors!r} is empty: one angle at least is valid")
    angles = np.array(sorted(factors))
    # A rounding of radians beyond the last angle still is this angle.
    refuse("beta", beta, np.degrees(beta) > angles[-1] * (1.0 + 1e-12), f"[0, {angles[-1]:g}] deg")
    return np.interp(np.degrees(beta), angles, [factors[angle] for angle in angles])


def precision_joint_torque(
    torque: ArrayLike,
    beta: ArrayLike,
    factors: Mapping[float, float],
    share: ArrayLike = 1.0,
) -> FloatArray:
    """Torque that a precision joint must bear by its data sheet, T k / share.

    Args:
        torque: T [N m], of any sign.
        beta: joint angle [rad], from 0 to the last angle of the table.
        factors: k by the angle in degrees, as in `precision_joint_factor`.
        share: of the torque of a single joint that the joint bears, greater than 0; 0.9 for a
            double joint.

    Returns:
        The size of the torque [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        DIN 808; JW Winco.
    """
    torque, share = np.abs(real("torque", torque)), positive("share", share)
    factor = precision_joint_factor(beta, factors)
    same_shape(torque=torque, beta=factor, share=share)
    return torque * factor / share


def shear_stress(
    torque: ArrayLike, outer_diameter: ArrayLike, inner_diameter: ArrayLike
) -> FloatArray:
    """Greatest shear stress of a tube under torque, tau = 16 T D / (pi (D^4 - d^4)).

    Args:
        torque: T [N m], of any sign.
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.

    Returns:
        The size of tau [Pa] at the outer surface, in the broadcast shape. Notches, welds and
        buckling of thin walls are not part of it.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        PSS, Tube; Saint-Venant's torsion.
    """
    torque = np.abs(real("torque", torque))
    polar, outer, _ = _polar_moment(outer_diameter, inner_diameter, torque=torque)
    return torque / polar * (outer / 2.0)


def torsional_stiffness(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    length: ArrayLike,
    shear_modulus: ArrayLike = 7.58423e10,
) -> FloatArray:
    """Torsional stiffness of a tube, c = pi G (D^4 - d^4) / (32 L).

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        length: L [m], greater than 0.
        shear_modulus: G [Pa], greater than 0; by default 11e6 psi.

    Returns:
        c [N m/rad], in the broadcast shape; forks, splines and flanges soften a shaft further.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        PSS, Tube, with its G of steel; Saint-Venant's torsion.
    """
    length, modulus = positive("length", length), positive("shear_modulus", shear_modulus)
    polar, _, _ = _polar_moment(
        outer_diameter, inner_diameter, length=length, shear_modulus=modulus
    )
    return modulus * polar / length


def _polar_moment(
    outer_diameter: ArrayLike, inner_diameter: ArrayLike, **others: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Polar moment of area and both diameters, checked."""
    outer = positive("outer_diameter", outer_diameter)
    inner = not_negative("inner_diameter", inner_diameter)
    same_shape(outer_diameter=outer, inner_diameter=inner, **others)
    full, wide = np.broadcast_arrays(inner, outer)
    refuse("inner_diameter", full, full >= wide, "[0, outer_diameter)")
    # D^4 - d^4 of thin walls without its difference.
    polar = np.pi / 32.0 * (outer - inner) * (outer + inner) * (outer**2 + inner**2)
    return polar, outer, inner
