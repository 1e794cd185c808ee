"""Impact in a joint with clearance and its peak force, after Dresig and Thuemmel.

Stage 2 of the model of `analytic.clearance`: the masses have crossed the play and are coupled by
the contact stiffness, while the ramp goes on. The first peak of the force counts.

Where the motion starts. The paper lets the masses separate at rest (13), ``start="rest"``, the
default. A contact that unloads along the ramp separates with the speed v_0 = (F_0 / t_0) / c, which
is 2 / tau^2 of v_1: ``start="release"``. The peak is then lower, by 24 % at tau = 2 and 2 % at
tau = 10, and below tau = 1.8386 there is none: the force follows the ramp without turning back.
SI units, all arguments broadcast.

Reference:
    H. Dresig, T. Thuemmel: Naeherungsweise Erfassung des Einflusses des Gelenkspiels auf die
    Gelenkkraefte in schnellaufenden Koppelgetrieben.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, real, same_shape
from ._first_peak import Flown, Start, first_peak, flown
from .clearance import natural_frequency
from .clearance import tau as tau_of

__all__ = ["GapCrossing", "Start", "contact_force", "exciting_force", "reversal"]


class GapCrossing(NamedTuple):
    """What happens at one reversal of the force.

    Attributes:
        t_1: time in the play [s].
        v_1: speed of the impact [m/s].
        tau: omega t_1 of the start at rest.
        theta_m: omega times the time from impact to peak [rad].
        peak: F_12max [N] (27).
        rigid: F_s1, value of the ramp at the time of the peak [N] (33).
        added: F_s2, what the clearance adds to it [N] (34).
    """

    t_1: FloatArray
    v_1: FloatArray
    tau: FloatArray
    theta_m: FloatArray
    peak: FloatArray
    rigid: FloatArray
    added: FloatArray


def reversal(
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    *,
    start: Start = "rest",
) -> GapCrossing:
    """Times, speeds and forces of one reversal.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        A `GapCrossing`, each field in the broadcast shape. Without clearance and from rest, the
        peak is 2 pi ramp / omega. With start="release", what belongs to the peak is NaN below
        tau = 1.8386.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Dresig and Thuemmel (14) to (17), (27) and (32) to (34).

    >>> round(float(reversal(3.6, 1e7, 0.5e-4, 360e3).peak), 2)
    2181.89
    """
    tau_0 = tau_of(mass, stiffness, half_clearance, ramp)
    omega, ramp = natural_frequency(mass, stiffness), real("ramp", ramp)
    flight, angle, root = first_peak(tau_0, start)
    unit = ramp / omega
    values = (
        flight / omega,
        flown(tau_0, start).speed * ramp / real("stiffness", stiffness),
        tau_0,
        angle,
        unit * (flight + angle + root),
        unit * (flight + angle),
        unit * root,
    )
    return GapCrossing(*(filled(value, tau_0.shape) for value in values))


def exciting_force(
    time: ArrayLike,
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    *,
    start: Start = "rest",
) -> FloatArray:
    """Joint force of the rigid mechanism, counted in time from the impact.

    Args:
        time: time since the impact [s]; negative before it.
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        F [N] = ramp * (t_1 + time), in the broadcast shape.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Dresig and Thuemmel (24).
    """
    time, way, omega, ramp = _stage_2(time, mass, stiffness, half_clearance, ramp, start)
    return ramp * (way.angle / omega + time)


def contact_force(
    time: ArrayLike,
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    *,
    start: Start = "rest",
) -> FloatArray:
    """Force F_12 in the joint with clearance, counted in time from the impact.

    Args:
        time: time since the impact [s]; before it, the force is 0.
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        F_12 [N], in the broadcast shape. It holds while the masses stay coupled, up to its first
        return to zero; beyond, the formula goes on with a spring that also pulls.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Dresig and Thuemmel (26).
    """
    time, way, omega, ramp = _stage_2(time, mass, stiffness, half_clearance, ramp, start)
    theta = omega * np.maximum(time, 0.0)
    ramp_part = 2.0 * way.angle * np.sin(theta / 2.0) ** 2 + _angle_minus_sine(theta)
    return ramp / omega * (ramp_part + way.speed * np.sin(theta))


def _stage_2(
    time: ArrayLike,
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    start: str,
) -> tuple[FloatArray, Flown, FloatArray, FloatArray]:
    """Return time, the way across the play, omega and ramp, checked."""
    time, number = real("time", time), tau_of(mass, stiffness, half_clearance, ramp)
    same_shape(time=time, joint=number)
    omega = natural_frequency(mass, stiffness)
    return time, flown(number, start), omega, real("ramp", ramp)


def _angle_minus_sine(theta: FloatArray) -> FloatArray:
    """Theta - sin theta, by its series where the difference would cancel."""
    small = np.minimum(theta, 1.0)
    square, series = small * small, np.ones_like(small)
    for k in range(9, 1, -1):
        series = 1.0 - square / ((2 * k) * (2 * k + 1)) * series
    return np.where(theta < 1.0, small * square / 6.0 * series, theta - np.sin(theta))[()]
