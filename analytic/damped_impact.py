"""Impact across a play with a damper beside the contact's spring, from its release on.

The equations of `impact` with a linear damper d: m x'' + d x' + c x = k (t_1 + t), x(0) = 0, where
k is the ramp F_0 / t_0 and the force across the contact is c x + d x'. With theta = omega t and
zeta = d / (2 sqrt(c m)) it depends on omega t_1 and zeta alone. Own derivation; for zeta = 0 it is
that of Dresig and Thuemmel (24) to (27).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from analytic._checks import FloatArray, real
from analytic.impact import Start
from analytic.impact import reversal as undamped

__all__ = ["damped_peak"]

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
    zeta = real("damping_ratio", damping_ratio)
    if np.any((zeta < 0.0) | (zeta >= 1.0)):
        raise ValueError("damping_ratio lies from 0 to below 1")
    found = undamped(mass, stiffness, half_clearance, ramp, start=start)
    omega = np.sqrt(real("stiffness", stiffness) / real("mass", mass))
    flight = omega * found.t_1
    unit = real("ramp", ramp) / omega
    begun = found.v_1 * real("stiffness", stiffness) / real("ramp", ramp)
    flight, begun, zeta, unit = np.broadcast_arrays(flight, begun, zeta, unit)
    root = np.sqrt((1.0 - zeta) * (1.0 + zeta))
    # Beside theta + flight the force is exp(-zeta theta) (p cos(root theta) + q sin(root theta)).
    cosine = 2.0 * zeta - flight
    sine = (begun - 1.0 + zeta * cosine) / root
    p = cosine + 2.0 * zeta * (root * sine - zeta * cosine)
    q = sine - 2.0 * zeta * (zeta * sine + root * cosine)
    rate_p, rate_q = root * q - zeta * p, -zeta * q - root * p

    def rate(theta: FloatArray) -> FloatArray:
        turned = root * theta
        swing = rate_p * np.cos(turned) + rate_q * np.sin(turned)
        return np.asarray(1.0 + np.exp(-zeta * theta) * swing)

    thetas = np.linspace(0.0, 2.0 * np.pi, _POINTS).reshape(-1, *(1,) * flight.ndim) / root
    rates = rate(thetas)
    falls = (rates[1:] < 0.0) & (rates[:-1] >= 0.0)
    index = np.argmax(falls, axis=0)
    low = np.take_along_axis(thetas + 0.0 * rates, index[None], axis=0)[0]
    high = low + thetas[1] - thetas[0]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_before = rate(middle) >= 0.0
        low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
    theta = 0.5 * (low + high)
    swing = p * np.cos(root * theta) + q * np.sin(root * theta)
    force = flight + theta + np.exp(-zeta * theta) * swing
    has_peak = np.any(falls, axis=0)
    at_once = np.where(rates[0] < 0.0, flight + p, -np.inf)
    peak = np.maximum(np.where(has_peak, force, -np.inf), at_once)
    return np.asarray(unit * np.where(np.isfinite(peak), peak, np.nan))
