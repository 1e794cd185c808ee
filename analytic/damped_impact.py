"""Impact across a play with a damper beside the contact's spring, from its release on.

The equations of `impact` with a linear damper d: m x'' + d x' + c x = k (t_1 + t), x(0) = 0, where
k is the ramp F_0 / t_0 and the force across the contact is c x + d x'. With theta = omega t and
zeta = d / (2 sqrt(c m)) it depends on omega t_1 and zeta alone. Own derivation; for zeta = 0 it is
that of Dresig and Thuemmel (24) to (27).

Where the flight starts, ``start="release"``, the default: a contact that unloads steadily along
the ramp lags behind it, x = (k / c) (t - d / c). Its force c x + d x' vanishes with the ramp's,
while its spring is still pressed by k d / c^2: the damper holds as much as the spring pushes, and
beyond it would pull. From there the way is longer than the play, the flight lasts longer and
the impact is faster than released by a spring alone: with z = omega t_1 the root of
z^3 + 6 z = tau^3 + 12 zeta, v_1 = (k / c) (1 + z^2 / 2). The peak is greater by that, with
zeta = 0.25 by 4.7 % at tau = 3, 1.35 % at 5 and 0.2 % at 10. From rest at the gap 0,
``start="rest"``, the flight knows no damping.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, positive, real, same_shape
from ._first_peak import Start, flown
from .clearance import natural_frequency
from .clearance import tau as tau_of
from .peak_exponents import PeakExponents, exponents_of

__all__ = ["Flight", "damped_peak", "flight", "peak_exponents"]

_POINTS = 721
_HALVINGS = 50


class Flight(NamedTuple):
    """The way across the play.

    Attributes:
        t_1: time from the change of sign of the force to the impact [s].
        v_1: speed of the impact [m/s].
    """

    t_1: FloatArray
    v_1: FloatArray


def flight(
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    damping_ratio: ArrayLike,
    *,
    start: Start = "release",
) -> Flight:
    """Time and speed of the flight across the play, from a contact with a damper.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        damping_ratio: zeta, from 0 to below 1.
        start: "rest" or "release", see the module's text.

    Returns:
        A `Flight`, each field in the broadcast shape. Released with damping, the flight is longer
        than 0 without play as well: the contact is still pressed where it begins.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Own derivation; from rest Dresig and Thuemmel (15), (16).

    >>> [round(float(value), 6) for value in flight(3.6, 1e7, 0.5e-4, 360e3, 0.25)]
    [0.001504, 0.149055]
    """
    tau, zeta, omega = _checked(mass, stiffness, half_clearance, ramp, damping_ratio)
    angle, begun = flown(tau, start, zeta)
    speed = begun * real("ramp", ramp) / real("stiffness", stiffness)
    shape = np.broadcast_shapes(np.shape(tau), np.shape(zeta))
    return Flight(filled(angle / omega, shape), filled(speed, shape))


def damped_peak(
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    damping_ratio: ArrayLike,
    *,
    start: Start = "release",
) -> FloatArray:
    """First greatest force across the contact after the impact [N].

    A damper that is strong has its greatest force at once, 2 zeta omega m v_1; where the force
    rises for longer than half a swing it is that of the ramp.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        damping_ratio: zeta, from 0 to below 1.
        start: "rest" or "release", see the module's text.

    Returns:
        Forces in the broadcast shape; NaN where there is no peak.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Own derivation; without damping Dresig and Thuemmel (26), (27).

    >>> round(float(damped_peak(3.6, 1e7, 0.5e-4, 360e3, 0.0, start="rest")), 2)
    2181.89
    """
    tau, zeta, omega = _checked(mass, stiffness, half_clearance, ramp, damping_ratio)
    unit = real("ramp", ramp) / omega
    angle, begun = flown(tau, start, zeta)
    angle, begun, zeta, unit = np.broadcast_arrays(angle, begun, zeta, unit)
    return np.asarray(unit * _Contact(angle, begun, zeta).peak().force)


def peak_exponents(
    tau: ArrayLike, damping_ratio: ArrayLike, *, start: Start = "release"
) -> PeakExponents:
    """By which powers of its parameters the peak grows, the damping ratio staying as it is.

    At a peak the force does not change with time, so that its growth with tau is that of the force
    at the same angle: closed but for that angle.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        damping_ratio: zeta, from 0 to below 1.
        start: "rest" or "release", see the module's text.

    Returns:
        A `PeakExponents`, each field in the broadcast shape; NaN where there is no peak.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Own derivation; without damping `analytic.peak_exponents`.

    >>> [round(float(value), 3) for value in peak_exponents(3.02853, 0.0)]
    [1.648, 0.549, 0.451, 0.275, 0.176]
    """
    tau, zeta = positive("tau", tau), _ratio(damping_ratio)
    same_shape(tau=tau, damping_ratio=zeta)
    angle, begun = flown(tau, start, zeta)
    angle, begun, zeta = np.broadcast_arrays(angle, begun, zeta)
    contact = _Contact(angle, begun, zeta)
    peak = contact.peak()
    lengthens = angle
    if start == "release":
        lengthens = tau * tau * tau / (angle * angle + 2.0)
    return exponents_of(lengthens * contact.growth(peak.angle) / peak.force)


def _checked(
    mass: ArrayLike,
    stiffness: ArrayLike,
    half_clearance: ArrayLike,
    ramp: ArrayLike,
    damping_ratio: ArrayLike,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Tau, zeta and omega of arguments, checked."""
    tau, zeta = tau_of(mass, stiffness, half_clearance, ramp), _ratio(damping_ratio)
    same_shape(joint=tau, damping_ratio=zeta)
    return tau, zeta, natural_frequency(mass, stiffness)


def _ratio(damping_ratio: ArrayLike) -> FloatArray:
    """Damping ratio, checked."""
    zeta = real("damping_ratio", damping_ratio)
    if np.any((zeta < 0.0) | (zeta >= 1.0)):
        raise ValueError("damping_ratio lies from 0 to below 1")
    return zeta


class _Peak(NamedTuple):
    """The first greatest force over F_0 / (t_0 omega), NaN if none, and omega times its time."""

    force: FloatArray
    angle: FloatArray


class _Contact:
    """Force over F_0 / (t_0 omega) as a function of theta = omega times the time since the impact.

    Beside theta + flight it is exp(-zeta theta) (p cos(root theta) + q sin(root theta)).
    """

    def __init__(self, flight: FloatArray, begun: FloatArray, zeta: FloatArray) -> None:
        """Make the force.

        Args:
            flight: omega t_1.
            begun: v_1 c t_0 / F_0.
            zeta: damping ratio, of the same shape.
        """
        self.flight, self.zeta = flight, zeta
        self.root = np.sqrt((1.0 - zeta) * (1.0 + zeta))
        cosine = 2.0 * zeta - flight
        self.p, self.q = self._damped(cosine, (begun - 1.0 + zeta * cosine) / self.root)

    def _damped(self, cosine: FloatArray, sine: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return p and q of the force that belong to parts of the contact's deflection."""
        zeta, root = self.zeta, self.root
        return (
            cosine + 2.0 * zeta * (root * sine - zeta * cosine),
            sine - 2.0 * zeta * (zeta * sine + root * cosine),
        )

    def _swing(self, theta: FloatArray, p: FloatArray, q: FloatArray) -> FloatArray:
        turned = self.root * theta
        wave = p * np.cos(turned) + q * np.sin(turned)
        return np.asarray(np.exp(-self.zeta * theta) * wave)

    def rate(self, theta: FloatArray) -> FloatArray:
        """Return the derivative of the force."""
        p, q = self.root * self.q - self.zeta * self.p, -self.zeta * self.q - self.root * self.p
        return np.asarray(1.0 + self._swing(theta, p, q))

    def growth(self, theta: FloatArray) -> FloatArray:
        """Return the derivative of the force by the flight, which `begun` follows as its square."""
        p, q = self._damped(-np.ones_like(self.flight), (self.flight - self.zeta) / self.root)
        return np.asarray(1.0 + self._swing(theta, p, q))

    def peak(self) -> _Peak:
        """Return the first greatest force."""
        turn = np.linspace(0.0, 2.0 * np.pi, _POINTS).reshape(-1, *(1,) * self.flight.ndim)
        thetas = turn / self.root
        rates = self.rate(thetas)
        falls = (rates[1:] < 0.0) & (rates[:-1] >= 0.0)
        index = np.argmax(falls, axis=0)
        low = np.take_along_axis(thetas + 0.0 * rates, index[None], axis=0)[0]
        high = low + thetas[1] - thetas[0]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            is_before = self.rate(middle) >= 0.0
            low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
        theta = 0.5 * (low + high)
        force = self.flight + theta + self._swing(theta, self.p, self.q)
        force = np.where(np.any(falls, axis=0), force, -np.inf)
        at_once = np.where(rates[0] < 0.0, self.flight + self.p, -np.inf)
        greatest = np.maximum(force, at_once)
        return _Peak(
            np.where(np.isfinite(greatest), greatest, np.nan),
            np.where(at_once > force, 0.0, theta),
        )
