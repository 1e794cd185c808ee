"""Torsional natural frequencies of a drive and the speeds they make dangerous.

A joint excites torsion at twice and, weakly, four times the speed of rotation, and its ratio makes
the stiffness and inertia of what stands behind it vary at twice the speed. SI units, all arguments
broadcast; those of `chain_frequencies` along all axes but the last.

References:
    Dana industrial drive shafts catalogue, critical torsional speed; A. J. Mazzei, R. A. Scott,
    J. Sound Vib. 1999; M. Zajicek, J. Dupal 2014.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, joint_angle, positive, real, refuse, same_shape

__all__ = [
    "ParametricZone",
    "TorsionalSpeeds",
    "chain_frequencies",
    "critical_speeds",
    "parametric_speed",
    "parametric_zone",
]


class TorsionalSpeeds(NamedTuple):
    """Speeds of rotation [rad/s] at which order 2 and order 4 meet a natural frequency."""

    order_2: FloatArray
    order_4: FloatArray


class ParametricZone(NamedTuple):
    """Speeds of rotation over natural frequency between which torsion grows without damping.

    `damping` is the damping ratio above which the zone closes.
    """

    least: FloatArray
    greatest: FloatArray
    damping: FloatArray


def chain_frequencies(inertias: ArrayLike, stiffnesses: ArrayLike) -> FloatArray:
    """Natural frequencies of inertias in a row with springs between them.

    Two inertias have one, omega^2 = c (J_1 + J_2) / (J_1 J_2).

    Args:
        inertias: J of n >= 2 inertias `(..., n)` [kg m^2], greater than 0; inf where the motion is
            prescribed.
        stiffnesses: torsional stiffness c of what lies between them `(..., n - 1)` [N m/rad],
            greater than 0.

    Returns:
        omega `(..., n - 1)` [rad/s] from the lowest on, without the turning of all together. Each
        is exact but for the rounding of the highest one. Each infinite inertia but one leaves an
        omega of 0, as nothing moves.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        The twists of the springs swing with M^-1 K in coordinates in which it is D^T D: D has
        1/sqrt(J c^-1) twice in each column, and its singular values are omega (textbooks of torsion
        in crankshafts); Dana leaves it to the builder of the machine to stay clear of it.

    >>> chain_frequencies([0.1, 0.2, 0.1], [2e4, 2e4]).round(2).tolist()
    [447.21, 632.46]
    """
    inertia = positive("inertias", inertias, unlimited=True)
    stiffness = positive("stiffnesses", stiffnesses)
    count = inertia.shape[-1] if np.ndim(inertia) else 0
    if count < 2 or np.shape(stiffness)[-1:] != (count - 1,):
        raise ValueError(
            f"stiffnesses of shape {np.shape(stiffness)} do not match inertias of shape "
            f"{np.shape(inertia)}: expected (..., n - 1) and (..., n) with n of 2 or more"
        )
    before, behind = (np.sqrt(stiffness / part) for part in (inertia[..., :-1], inertia[..., 1:]))
    unknown = np.isnan(before + behind).any(axis=-1, keepdims=True)
    difference = np.zeros((*before.shape[:-1], count, count - 1))
    at = np.arange(count - 1)
    difference[..., at, at] = np.where(unknown, 0.0, before)
    difference[..., at + 1, at] = np.where(unknown, 0.0, -behind)
    found = np.linalg.svd(difference, compute_uv=False)[..., ::-1]
    return np.where(unknown, np.nan, found)


def critical_speeds(frequency: ArrayLike) -> TorsionalSpeeds:
    """Speeds of rotation at which the joint's orders excite a natural frequency.

    Args:
        frequency: natural frequency omega_n [rad/s], greater than 0.

    Returns:
        omega_n / 2 and omega_n / 4 [rad/s], each in the shape of `frequency`.

    Raises:
        ValueError: an argument out of range.

    Source:
        n = 60 f / 2 and 60 f / 4 (AE-7); orders of the speed ratio, `single_joint`.
    """
    frequency = positive("frequency", frequency)
    return TorsionalSpeeds(frequency / 2.0, frequency / 4.0)


def parametric_speed(frequency: ArrayLike, zone: ArrayLike = 1) -> FloatArray:
    """Speed of rotation in the middle of a zone of parametric instability.

    Stiffness and inertia vary with 2 Omega, and are dangerous where 2 Omega = 2 omega_n / k.

    Args:
        frequency: natural frequency omega_n [rad/s], greater than 0.
        zone: k = 1, 2, 3, ...

    Returns:
        Omega = omega_n / k [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Mazzei and Scott 1999; Zajicek and Dupal 2014; Mathieu's equation.
    """
    frequency, zone = positive("frequency", frequency), real("zone", zone)
    wrong = (zone < 1.0) | np.isinf(zone) | ((zone != np.rint(zone)) & ~np.isnan(zone))
    refuse("zone", zone, wrong, "1, 2, 3, ...")
    same_shape(frequency=frequency, zone=zone)
    return frequency / zone


def parametric_zone(beta: ArrayLike, share: ArrayLike) -> ParametricZone:
    """First zone of parametric instability of a spring in front of a joint, for small angles.

    Omega / omega_n = 1 -+ a beta^2 / 4, with omega_n^2 = c / (J_1 + J_2) and a = J_2 / (J_1 + J_2).

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        share: a, inertia behind the joint over that on both its sides, from 0 to 1.

    Returns:
        Both ends of the zone and the damping ratio a beta^2 / 4 that closes it, each in the
        broadcast shape. Of first order in beta^2: at 15 degrees and a = 1/2 the ends are
        0.99116 and 1.00850, which this gives to 3e-4.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation: averaging of (J_1 + J_2 eta^2) theta'' + J_2 eta eta' theta'^2
        + c (theta - Omega t) = 0, linearised about its periodic motion. The ends at 15 degrees are
        those of its monodromy matrix.
    """
    beta, share = joint_angle("beta", beta), real("share", share)
    refuse("share", share, (share < 0.0) | (share > 1.0), "[0, 1]")
    shape = same_shape(beta=beta, share=share)
    half = share * beta**2 / 4.0
    return ParametricZone(*(filled(value, shape) for value in (1.0 - half, 1.0 + half, half)))
