"""Ratings that a required life asks of a joint, and the one load that stands for a duty cycle.

The rated torque T_D of `shaft_design.joint_life` is the torque of 5000 h at n beta = 300
degrees/min; the capacity factor L_C of `shaft_design.joint_life_from_capacity` is another rating,
and a torque of `design_torque.selection_torque` belongs to a third. They are not exchangeable.
SI units and radians, all arguments broadcast. Angles below 3 degrees count as 3 degrees.

References:
    AISCO, universal joint sizing; AE-7 p. 31; catalogues of cardan shafts (GWB, Elbe).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import filled
from analytic._checks import (
    FloatArray,
    joint_angle,
    not_negative,
    positive,
    real,
    refuse,
    same_shape,
)
from analytic.shaft_design import _n_beta, _shares

__all__ = [
    "EquivalentDuty",
    "equivalent_duty",
    "mean_life",
    "required_capacity",
    "required_rated_torque",
]


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
