"""Crossing the play of a joint, and its characteristic number, after Dresig and Thuemmel.

Two masses m_11 and m_22 stand across one joint with the play 2 s and the contact stiffness c. Near
a reversal, the joint force of the rigid mechanism is a ramp, F = (F_0 / t_0) t. In stage 1, from
t = 0 to t_1, the masses cross the play; stage 2 is `analytic.impact`. Everything follows from
tau = omega t_1 with omega^2 = c / m. SI units, all arguments broadcast.

Equations (1) to (10) are lost in the surviving copy. Of what is needed here, the force (1) is
(m_phiq,phi - m_phiphi,q / 2) Omega^2 with the clearance coordinate q, (8) is the ramp, and for
(9), (10) see `analytic.contact_stiffness`.

Reference:
    H. Dresig, T. Thuemmel: Naeherungsweise Erfassung des Einflusses des Gelenkspiels auf die
    Gelenkkraefte in schnellaufenden Koppelgetrieben.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ._checks import FloatArray, not_negative, positive, same_shape

__all__ = [
    "contact_time",
    "force_ramp",
    "impact_speed",
    "natural_frequency",
    "reduced_mass",
    "tau",
    "tau_from_speed",
]


def reduced_mass(m_11: ArrayLike, m_22: ArrayLike) -> FloatArray:
    """Reduced mass m = m_11 m_22 / (m_11 + m_22).

    Args:
        m_11: mass on one side of the joint [kg], greater than 0.
        m_22: mass on the other side [kg], greater than 0.

    Returns:
        m [kg], in the broadcast shape.

    Raises:
        ValueError: a mass out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (17).

    >>> float(reduced_mass(3.0, 6.0))
    2.0
    """
    m_11, m_22 = positive("m_11", m_11), positive("m_22", m_22)
    same_shape(m_11=m_11, m_22=m_22)
    return m_11 * (m_22 / (m_11 + m_22))


def force_ramp(k_1: ArrayLike, speed: ArrayLike) -> FloatArray:
    """Slope of the rigid joint force at its reversal, F_0 / t_0 = k_1 Omega^3.

    Args:
        k_1: slope over the drive angle per Omega^2 [kg m/rad], greater than 0.
        speed: angular speed Omega of the drive [rad/s], greater than 0.

    Returns:
        F_0 / t_0 [N/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (30).
    """
    k_1, speed = positive("k_1", k_1), positive("speed", speed)
    same_shape(k_1=k_1, speed=speed)
    return k_1 * (speed * speed * speed)


def natural_frequency(mass: ArrayLike, stiffness: ArrayLike) -> FloatArray:
    """Angular frequency of the coupled masses, omega = sqrt(c / m).

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.

    Returns:
        omega [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (22).
    """
    mass, stiffness = positive("mass", mass), positive("stiffness", stiffness)
    same_shape(mass=mass, stiffness=stiffness)
    return np.sqrt(stiffness / mass)


def contact_time(mass: ArrayLike, half_clearance: ArrayLike, ramp: ArrayLike) -> FloatArray:
    """Time t_1 in the play, from rest.

    Args:
        mass: reduced mass m [kg], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.

    Returns:
        t_1 = cbrt(12 m s t_0 / F_0) [s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (15).
    """
    mass, ramp = positive("mass", mass), positive("ramp", ramp)
    half_clearance = not_negative("half_clearance", half_clearance)
    same_shape(mass=mass, half_clearance=half_clearance, ramp=ramp)
    return np.cbrt(12.0 * mass * half_clearance / ramp)


def impact_speed(mass: ArrayLike, half_clearance: ArrayLike, ramp: ArrayLike) -> FloatArray:
    """Speed v_1 of the impact, from rest.

    Args:
        mass: reduced mass m [kg], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.

    Returns:
        v_1 = cbrt(18 s^2 F_0 / (m t_0)) = 6 s / t_1 [m/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (16).
    """
    mass, ramp = positive("mass", mass), positive("ramp", ramp)
    half_clearance = not_negative("half_clearance", half_clearance)
    same_shape(mass=mass, half_clearance=half_clearance, ramp=ramp)
    return np.cbrt(18.0 * half_clearance**2 * ramp / mass)


def tau(
    mass: ArrayLike, stiffness: ArrayLike, half_clearance: ArrayLike, ramp: ArrayLike
) -> FloatArray:
    """Characteristic number tau = omega t_1, from rest.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.

    Returns:
        tau, in the broadcast shape; 0 without clearance.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (23) with (15) and (22).

    >>> round(float(tau(3.6, 1e7, 0.5e-4, 360e3)), 5)
    3.02853
    """
    omega = natural_frequency(mass, stiffness)
    half_clearance, ramp = not_negative("half_clearance", half_clearance), positive("ramp", ramp)
    same_shape(omega=omega, half_clearance=half_clearance, ramp=ramp)
    return omega * contact_time(mass, half_clearance, ramp)


def tau_from_speed(
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    k_1: ArrayLike,
    speed: ArrayLike,
) -> FloatArray:
    """Characteristic number tau as a function of the speed of the drive.

    tau^6 = 144 c^3 s^2 / (k_1^2 m Omega^6): speed counts most, mass least.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        k_1: slope of the rigid force over the drive angle per Omega^2 [kg m/rad], greater than 0.
        speed: angular speed Omega of the drive [rad/s], greater than 0.

    Returns:
        tau, in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dresig and Thuemmel (31).
    """
    return tau(mass, stiffness, half_clearance, force_ramp(k_1, speed))
