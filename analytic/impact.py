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

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import filled
from analytic._checks import FloatArray, positive, real, same_shape
from analytic.clearance import natural_frequency
from analytic.clearance import tau as tau_of

__all__ = [
    "PeakExponents",
    "Reversal",
    "contact_force",
    "exciting_force",
    "exponents_of",
    "peak_angle",
    "peak_exponents",
    "peak_factor",
    "peak_factor_limits",
    "peak_factor_linearised",
    "reversal",
]

_GREAT_TAU = 1e50
"""Beyond it the factor is 6 / tau to far more digits than a float has."""

Start = Literal["rest", "release"]


class Reversal(NamedTuple):
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


class PeakExponents(NamedTuple):
    """By which powers of its parameters a peak grows where they change a little.

    Each is the logarithmic derivative d ln F_12max / d ln p, the other parameters of this list
    staying as they are: one per cent more of p makes so many per cent more of the peak.

    Attributes:
        speed: of the drive, Omega, if the ramp is k_1 Omega^3 (30).
        slope: of the ramp F_0 / t_0, or of k_1.
        play: of 2 s, or of s.
        mass: reduced mass m.
        stiffness: of the contact, c.
    """

    speed: FloatArray
    slope: FloatArray
    play: FloatArray
    mass: FloatArray
    stiffness: FloatArray


def peak_angle(tau: ArrayLike, *, start: Start = "rest") -> FloatArray:
    """Angle theta_m = omega * time from impact to the first peak of the force.

    From rest it is 2 atan2(tau, tau - 2), which takes the right branch of the arc cosine in (27b)
    for every tau.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        theta_m [rad] between 0 and 2 pi, in the shape of `tau`. With start="release" NaN below
        tau = 1.8386, where there is no peak.

    Raises:
        ValueError: tau out of range or an unknown start.

    Source:
        Dresig and Thuemmel (27b), (27c); the stationary point of (26).
    """
    return _peak(positive("tau", tau), start)[1]


def peak_factor(tau: ArrayLike, *, start: Start = "rest") -> FloatArray:
    """Factor f of the peak force F_12max = c s f(tau).

    From rest, f = 6/tau + 12/tau^2 + 24/tau^3 atan2(tau, tau - 2), exact for every tau.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        f, in the shape of `tau`; inf where it is beyond floats, below tau = 1e-102. With
        start="release" NaN below tau = 1.8386.

    Raises:
        ValueError: tau out of range or an unknown start.

    Source:
        Dresig and Thuemmel (36), which takes the wrong branch below tau = 2.

    >>> round(float(peak_factor(1.0)), 4)
    74.5487
    """
    tau = positive("tau", tau)
    # Powers one by one: the cube of tau over- and underflows long before the factor does.
    with np.errstate(over="ignore", invalid="ignore"):
        if start == "rest":
            arc = 2.0 * np.arctan2(tau, tau - 2.0)
            return (6.0 + 12.0 * (1.0 + arc / tau) / tau) / tau
        flight, angle, root = _peak(np.minimum(tau, _GREAT_TAU), start)
        return np.where(
            tau < _GREAT_TAU,
            12.0 * (flight + angle + root) / np.minimum(tau, _GREAT_TAU) ** 3,
            6.0 / tau,
        )[()]


def peak_factor_linearised(tau: ArrayLike) -> FloatArray:
    """Factor f from rest with the arc cosine linearised.

    It is 8.0 % too small at tau = 2, 1.2 % at tau = 3.03 and 0.1 % at tau = 5.

    Args:
        tau: characteristic number, greater than 0; of use above 2.

    Returns:
        f, in the shape of `tau`.

    Raises:
        ValueError: tau out of range.

    Source:
        Dresig and Thuemmel (29) divided by c s.
    """
    tau = positive("tau", tau)
    # The quotient is 2 / tau to rounding long before its powers overflow.
    bounded = np.minimum(tau, _GREAT_TAU)
    quotient = (2.0 * bounded**3 + 2.0 * bounded**2 - 4.0) / (bounded**4 + 4.0)
    with np.errstate(over="ignore"):
        return (6.0 + 12.0 * (1.0 + (np.pi / 2 + quotient) / tau) / tau) / tau


def peak_factor_limits(tau: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Limits of the factor f from rest, for small and for great tau.

    Args:
        tau: characteristic number, greater than 0.

    Returns:
        24 pi / tau^3, the ramp of a joint without play, and 6 / tau, the impact alone; each in the
        shape of `tau`. f is always above the latter.

    Raises:
        ValueError: tau out of range.

    Source:
        Limits of Dresig and Thuemmel (36).
    """
    tau = positive("tau", tau)
    with np.errstate(over="ignore"):
        return 24.0 * np.pi / tau / tau / tau, 6.0 / tau


def reversal(
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    *,
    start: Start = "rest",
) -> Reversal:
    """Times, speeds and forces of one reversal.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        A `Reversal`, each field in the broadcast shape. Without clearance and from rest, the
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
    flight, angle, root = _peak(tau_0, start)
    unit = ramp / omega
    speed = flight * flight / 2.0 + (1.0 if start == "release" else 0.0)
    values = (
        flight / omega,
        speed * ramp / real("stiffness", stiffness),
        tau_0,
        angle,
        unit * (flight + angle + root),
        unit * (flight + angle),
        unit * root,
    )
    return Reversal(*(filled(value, tau_0.shape) for value in values))


def peak_exponents(tau: ArrayLike, *, start: Start = "rest") -> PeakExponents:
    """By which powers of its parameters the peak grows.

    With the peak as F_0 / (t_0 omega) g(tau), everything follows from e = d ln g / d ln tau: of the
    play e / 3, of the stiffness (e - 1) / 2, of the mass 1 / 2 - e / 6, of the slope 1 - e / 3 and
    of the speed 3 - e. From rest e = tau^3 (tau - 1) / ((tau^2 - 2 tau + 2) g): below tau = 1 more
    play makes the peak smaller.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        start: "rest" or "release", see the module's text.

    Returns:
        A `PeakExponents`, each field in the shape of `tau`. With start="release" NaN below
        tau = 1.8386, where there is no peak.

    Raises:
        ValueError: tau out of range or an unknown start.

    Source:
        Own derivation from Dresig and Thuemmel (22), (23), (26) and (30).

    >>> [round(float(value), 3) for value in peak_exponents(3.02853)]
    [1.909, 0.636, 0.364, 0.318, 0.045]
    """
    # Beyond, both are to far more digits than a float has what they tend to.
    tau = np.minimum(positive("tau", tau), _GREAT_TAU)
    flight, angle, root = _peak(tau, start)
    whole = flight + angle + root
    if start == "rest":
        quotient = tau * tau / ((tau - 1.0) ** 2 + 1.0)
        growth = quotient * tau * (tau - 1.0) / whole
    else:
        square = flight * flight
        growth = (square + 6.0) / (square + 4.0) * (flight + 2.0 * root) / whole
    return exponents_of(growth)


def exponents_of(growth: ArrayLike) -> PeakExponents:
    """Exponents of a peak F_0 / (t_0 omega) g(tau).

    Args:
        growth: e = d ln g / d ln tau.

    Returns:
        A `PeakExponents`, each field in the shape of `growth`.

    Raises:
        ValueError: no real numbers.

    Source:
        Chain rule through Dresig and Thuemmel (15), (22), (23), (30).
    """
    e = real("growth", growth)
    return PeakExponents(3.0 - e, 1.0 - e / 3.0, e / 3.0, 0.5 - e / 6.0, 0.5 * (e - 1.0))


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
    time, flight, omega, ramp = _stage_2(time, mass, stiffness, half_clearance, ramp, start)
    return ramp * (flight / omega + time)


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
    time, flight, omega, ramp = _stage_2(time, mass, stiffness, half_clearance, ramp, start)
    theta = omega * np.maximum(time, 0.0)
    impact_part = flight * flight / 2.0 + (1.0 if start == "release" else 0.0)
    ramp_part = 2.0 * flight * np.sin(theta / 2.0) ** 2 + _angle_minus_sine(theta)
    return ramp / omega * (ramp_part + impact_part * np.sin(theta))


def _flight(tau: FloatArray, start: str) -> FloatArray:
    """Omega times the time in the play."""
    if start not in ("rest", "release"):
        raise ValueError(f"start = {start!r} is not one of 'rest', 'release'")
    if start == "rest":
        return tau
    # Real root of x^3 + 6 x = tau^3.
    return np.sqrt(8.0) * np.sinh(np.arcsinh(tau * tau * tau / np.sqrt(32.0)) / 3.0)


def _peak(tau: FloatArray, start: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Omega t_1, theta_m and the part due to the clearance, whose sum is F_12max omega / ramp."""
    flight = _flight(tau, start)
    square = flight * flight
    if start == "rest":
        return flight, 2.0 * np.arctan2(tau, tau - 2.0), square / 2.0
    edge = 2.0 * (np.sqrt(2.0) - 1.0)
    product = (square + 2.0 + np.sqrt(8.0)) * (square - edge) / 4.0
    root = np.sqrt(np.where(product >= 0.0, product, np.nan))[()]
    return flight, np.arctan2(2.0, flight) + np.arctan2(root, -1.0), root


def _stage_2(
    time: ArrayLike,
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    start: str,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Checked time, omega t_1, omega and ramp."""
    time, number = real("time", time), tau_of(mass, stiffness, half_clearance, ramp)
    same_shape(time=time, joint=number)
    omega = natural_frequency(mass, stiffness)
    return time, _flight(number, start), omega, real("ramp", ramp)


def _angle_minus_sine(theta: FloatArray) -> FloatArray:
    """Theta - sin theta, by its series where the difference would cancel."""
    small = np.minimum(theta, 1.0)
    square, series = small * small, np.ones_like(small)
    for k in range(9, 1, -1):
        series = 1.0 - square / ((2 * k) * (2 * k + 1)) * series
    return np.where(theta < 1.0, small * square / 6.0 * series, theta - np.sin(theta))[()]
