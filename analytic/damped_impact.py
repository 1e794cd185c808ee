"""Impact across a play with a damper beside the contact's spring, from its release on.

The equations of `impact` with a linear damper d: m x'' + d x' + c x = k (t_1 + t), x(0) = 0, where
k is the ramp F_0 / t_0 and the force across the contact is c x + d x'. With theta = omega t and
zeta = d / (2 sqrt(c m)) it depends on omega t_1 and zeta alone. Own derivation; for zeta = 0 it is
that of Dresig and Thuemmel (24) to (27).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._checks import FloatArray, positive, real, same_shape
from analytic.impact import PeakExponents, Start, exponents_of
from analytic.impact import reversal as undamped

__all__ = ["damped_peak", "peak_exponents"]

_POINTS = 721
_HALVINGS = 50


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

    The flight before it knows no damping. A damper that is strong has its greatest force at once,
    2 zeta omega m v_1; where the force rises for longer than half a swing it is that of the ramp.

    Args:
        mass: reduced mass m [kg], greater than 0.
        stiffness: contact stiffness c [N/m], greater than 0.
        half_clearance: s, half of the play [m], not negative.
        ramp: F_0 / t_0 [N/s], greater than 0.
        damping_ratio: zeta, from 0 to below 1.
        start: "rest" or "release", see `impact`.

    Returns:
        Forces in the broadcast shape; NaN where there is no peak.

    Raises:
        ValueError: an argument out of range.

    Source:
        Own derivation; without damping Dresig and Thuemmel (26), (27).

    >>> round(float(damped_peak(3.6, 1e7, 0.5e-4, 360e3, 0.0, start="rest")), 2)
    2181.89
    """
    zeta = _ratio(damping_ratio)
    found = undamped(mass, stiffness, half_clearance, ramp, start=start)
    omega = np.sqrt(real("stiffness", stiffness) / real("mass", mass))
    flight = omega * found.t_1
    unit = real("ramp", ramp) / omega
    begun = found.v_1 * real("stiffness", stiffness) / real("ramp", ramp)
    flight, begun, zeta, unit = np.broadcast_arrays(flight, begun, zeta, unit)
    return np.asarray(unit * _Contact(flight, begun, zeta).peak().force)


def peak_exponents(
    tau: ArrayLike, damping_ratio: ArrayLike, *, start: Start = "release"
) -> PeakExponents:
    """By which powers of its parameters the peak grows, the damping ratio staying as it is.

    At a peak the force does not change with time, so that its growth with tau is that of the force
    at the same angle: closed but for that angle.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        damping_ratio: zeta, from 0 to below 1.
        start: "rest" or "release", see `impact`.

    Returns:
        A `PeakExponents`, each field in the broadcast shape; NaN where there is no peak.

    Raises:
        ValueError: an argument out of range, shapes that do not match or an unknown start.

    Source:
        Own derivation; without damping `impact.peak_exponents`.

    >>> [round(float(value), 3) for value in peak_exponents(3.02853, 0.0)]
    [1.648, 0.549, 0.451, 0.275, 0.176]
    """
    tau, zeta = positive("tau", tau), _ratio(damping_ratio)
    same_shape(tau=tau, damping_ratio=zeta)
    # With mass, stiffness and ramp of 1 the half clearance is tau^3 / 12, and omega is 1.
    found = undamped(1.0, 1.0, tau * tau * tau / 12.0, 1.0, start=start)
    flight, begun, zeta = np.broadcast_arrays(found.t_1, found.v_1, zeta)
    contact = _Contact(flight, begun, zeta)
    peak = contact.peak()
    lengthens = flight
    if start == "release":
        square = flight * flight
        lengthens = flight * (square + 6.0) / (square + 2.0)
    return exponents_of(lengthens * contact.growth(peak.angle) / peak.force)


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
