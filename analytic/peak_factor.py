"""Peak of the force after an impact across a play as a multiple of c s, after Dresig and Thuemmel.

The first peak of the force in the two-mass model of `analytic.impact` is F_12max = c s f(tau), of
the contact stiffness c, half the play s and the characteristic number tau of `analytic.clearance`
alone; ``start`` says where the motion starts, see `analytic.impact`. All arguments broadcast.

Reference:
    H. Dresig, T. Thuemmel: Naeherungsweise Erfassung des Einflusses des Gelenkspiels auf die
    Gelenkkraefte in schnellaufenden Koppelgetrieben.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ._checks import FloatArray, positive
from ._first_peak import GREAT_TAU, Start, first_peak

__all__ = ["peak_angle", "peak_factor", "peak_factor_limits", "peak_factor_linearised"]


def peak_angle(tau: ArrayLike, *, start: Start = "rest") -> FloatArray:
    """Angle theta_m = omega * time from impact to the first peak of the force.

    From rest it is 2 atan2(tau, tau - 2), which takes the right branch of the arc cosine in (27b)
    for every tau.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        start: "rest" or "release", see `analytic.impact`.

    Returns:
        theta_m [rad] between 0 and 2 pi, in the shape of `tau`. With start="release" NaN below
        tau = 1.8386, where there is no peak.

    Raises:
        ValueError: tau out of range or an unknown start.

    Source:
        Dresig and Thuemmel (27b), (27c); the stationary point of (26).
    """
    return first_peak(positive("tau", tau), start)[1]


def peak_factor(tau: ArrayLike, *, start: Start = "rest") -> FloatArray:
    """Factor f of the peak force F_12max = c s f(tau).

    From rest, f = 6/tau + 12/tau^2 + 24/tau^3 atan2(tau, tau - 2), exact for every tau.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        start: "rest" or "release", see `analytic.impact`.

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
        flight, angle, root = first_peak(np.minimum(tau, GREAT_TAU), start)
        return np.where(
            tau < GREAT_TAU,
            12.0 * (flight + angle + root) / np.minimum(tau, GREAT_TAU) ** 3,
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
    bounded = np.minimum(tau, GREAT_TAU)
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
