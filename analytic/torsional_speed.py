"""Torsional natural frequency of a drive and the speeds it makes dangerous.

A joint excites torsion at twice and, weakly, four times the speed of rotation, and its ratio makes
the stiffness and inertia of what stands behind it vary at twice the speed. SI units, all arguments
broadcast.

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
    "critical_speeds",
    "parametric_speed",
    "parametric_zone",
    "two_inertia_frequency",
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


def two_inertia_frequency(
    inertia_1: ArrayLike, inertia_2: ArrayLike, stiffness: ArrayLike
) -> FloatArray:
    """Natural frequency of two inertias on a shaft, omega^2 = c (J_1 + J_2) / (J_1 J_2).

    Args:
        inertia_1: J_1 at one end [kg m^2], greater than 0; inf where the motion is prescribed.
        inertia_2: J_2 at the other end [kg m^2], greater than 0; inf likewise.
        stiffness: torsional stiffness c [N m/rad], greater than 0.

    Returns:
        omega [rad/s], 2 pi f, in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        f = sqrt(c (J_1 + J_2) / (J_1 J_2)) / (2 pi) of two inertias (textbooks); Dana leaves it to
        the builder of the machine to stay clear of it.
    """
    first = positive("inertia_1", inertia_1, unlimited=True)
    second = positive("inertia_2", inertia_2, unlimited=True)
    stiffness = positive("stiffness", stiffness)
    same_shape(inertia_1=first, inertia_2=second, stiffness=stiffness)
    return np.sqrt(stiffness * (1.0 / first + 1.0 / second))


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
