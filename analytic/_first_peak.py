"""Flight across a play and first peak of the force, in angles omega times time.

Shared by `impact`, `peak_factor`, `peak_exponents` and `damped_impact`: all of it depends on the
characteristic number tau of the start at rest, on the start and on the damping ratio.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ._checks import FloatArray

Start = Literal["rest", "release"]

GREAT_TAU = 1e50
"""Beyond it, what depends on tau is what it tends to, to far more digits than a float has."""


class Flown(NamedTuple):
    """The way across the play.

    Attributes:
        angle: omega t_1.
        speed: v_1 c t_0 / F_0.
    """

    angle: FloatArray
    speed: FloatArray


def flown(tau: FloatArray, start: str, damping_ratio: FloatArray | float = 0.0) -> Flown:
    """Return the way across the play, which knows no damping from rest.

    Args:
        tau: characteristic number, not negative.
        start: "rest" or "release".
        damping_ratio: of the contact that is released, of a shape that fits tau's.

    Raises:
        ValueError: an unknown start.
    """
    if start not in ("rest", "release"):
        raise ValueError(f"start = {start!r} is not one of 'rest', 'release'")
    if start == "rest":
        return Flown(tau, tau * tau / 2.0)
    # Real root of z^3 + 6 z = tau^3 + 12 zeta.
    way = tau * tau * tau + 12.0 * damping_ratio
    angle = np.sqrt(8.0) * np.sinh(np.arcsinh(way / np.sqrt(32.0)) / 3.0)
    return Flown(angle, 1.0 + angle * angle / 2.0)


def first_peak(tau: FloatArray, start: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return omega t_1, theta_m and the part of the peak due to the clearance, without damping.

    Their sum is F_12max omega t_0 / F_0; the latter two are NaN where there is no peak.

    Args:
        tau: characteristic number, not negative.
        start: "rest" or "release".

    Raises:
        ValueError: an unknown start.
    """
    flight, speed = flown(tau, start)
    if start == "rest":
        return flight, 2.0 * np.arctan2(tau, tau - 2.0), speed
    edge = 2.0 * (np.sqrt(2.0) - 1.0)
    square = flight * flight
    product = (square + 2.0 + np.sqrt(8.0)) * (square - edge) / 4.0
    root = np.sqrt(np.where(product >= 0.0, product, np.nan))[()]
    return flight, np.arctan2(2.0, flight) + np.arctan2(root, -1.0), root
