"""By which powers of its parameters the peak after an impact grows, after Dresig and Thuemmel.

What one per cent more speed, slope, clearance, mass or stiffness makes of the peak of
`analytic.impact`;
``start`` says where the motion starts, see there. All arguments broadcast.

Reference:
    H. Dresig, T. Thuemmel: Naeherungsweise Erfassung des Einflusses des Gelenkspiels auf die
    Gelenkkraefte in schnellaufenden Koppelgetrieben.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._checks import FloatArray, positive, real
from ._first_peak import GREAT_TAU, Start, first_peak

__all__ = ["PeakExponents", "exponents_of", "peak_exponents"]


class PeakExponents(NamedTuple):
    """By which powers of its parameters a peak grows where they change a little.

    Each is the logarithmic derivative d ln F_12max / d ln p, the other parameters of this list
    staying as they are: one per cent more of p makes so many per cent more of the peak.

    Attributes:
        speed: of the drive, Omega, if the ramp is k_1 Omega^3 (30).
        slope: of the ramp F_0 / t_0, or of k_1.
        clearance: of 2 s, or of s.
        mass: reduced mass m.
        stiffness: of the contact, c.
    """

    speed: FloatArray
    slope: FloatArray
    clearance: FloatArray
    mass: FloatArray
    stiffness: FloatArray


def peak_exponents(tau: ArrayLike, *, start: Start = "rest") -> PeakExponents:
    """By which powers of its parameters the peak grows.

    With the peak as F_0 / (t_0 omega) g(tau), everything follows from e = d ln g / d ln tau: of the
    play e / 3, of the stiffness (e - 1) / 2, of the mass 1 / 2 - e / 6, of the slope 1 - e / 3 and
    of the speed 3 - e. From rest e = tau^3 (tau - 1) / ((tau^2 - 2 tau + 2) g): below tau = 1 more
    play makes the peak smaller.

    Args:
        tau: characteristic number of the start at rest, greater than 0.
        start: "rest" or "release", see `analytic.impact`.

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
    tau = np.minimum(positive("tau", tau), GREAT_TAU)
    flight, angle, root = first_peak(tau, start)
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
