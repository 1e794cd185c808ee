"""Critical bending speeds by makers' constants, lengths they allow, and elastic centre bearings.

`shaft_design.critical_speed` is the beam itself. SI units, all arguments broadcast.

References:
    AE-7 p. 267; Elbe and Dana catalogues; S. Timoshenko: Vibration Problems in Engineering.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from analytic._checks import FloatArray, not_negative, positive, refuse, same_shape
from analytic.shaft_design import critical_speed

__all__ = [
    "critical_speed_by_constant",
    "elastic_bearing_factor",
    "greatest_length",
    "on_elastic_bearing",
]

_BISECTIONS = 60
"""Halvings of (0, pi): beyond the digits of a float."""


def critical_speed_by_constant(
    outer_diameter: ArrayLike, inner_diameter: ArrayLike, length: ArrayLike, constant: ArrayLike
) -> FloatArray:
    """First critical bending speed by a maker's constant, omega = C sqrt(D^2 + d^2) / L^2.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        length: L between the joints [m], greater than 0.
        constant: C [rad m/s], greater than 0; `limits.CRITICAL_CONSTANTS` has those of makers.

    Returns:
        omega [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        AE-7 p. 267, Elbe, IMS, which differ in C.

    >>> from analytic.limits import CRITICAL_CONSTANTS
    >>> tube = np.array([3.5, 3.26, 60.0]) * 0.0254
    >>> speed = critical_speed_by_constant(*tube, CRITICAL_CONSTANTS["ae_7"].value)
    >>> round(float(speed * 30 / np.pi))
    6251
    """
    length, constant = positive("length", length), positive("constant", constant)
    size = _size(outer_diameter, inner_diameter, length=length, constant=constant)
    return constant * size / length**2


def greatest_length(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    speed: ArrayLike,
    constant: ArrayLike,
    share: ArrayLike = 0.75,
) -> FloatArray:
    """Greatest length at which a speed is this share of the critical one.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        speed: greatest speed of rotation [rad/s], greater than 0.
        constant: C [rad m/s], greater than 0, as in `critical_speed_by_constant`.
        share: of the critical speed, greater than 0.

    Returns:
        L = sqrt(share C sqrt(D^2 + d^2) / omega) [m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Inverse of `critical_speed_by_constant`; shares as in `limits.LIMITS`.
    """
    speed, constant = positive("speed", speed), positive("constant", constant)
    share = positive("share", share)
    size = _size(outer_diameter, inner_diameter, speed=speed, constant=constant, share=share)
    return np.sqrt(share * constant * size / speed)


def elastic_bearing_factor(softness: ArrayLike) -> FloatArray:
    """Critical speed of a tube with one end on an elastic bearing, over that with rigid ends.

    With z^4 = mu omega^2 L^4 / (E I), the boundary conditions (no moment at either end, the
    bearing's force at one) give z^3 (coth z - cot z) = 2 k L^3 / (E I); the factor is (z / pi)^2.

    Args:
        softness: E I / (k L^3), stiffness of the beam over that of the bearing, not negative; 0 is
            rigid.

    Returns:
        The factor, at most 1, in the shape of `softness`. For a soft bearing it tends to the rod
        that swings about the other end, sqrt(3 / softness) / pi^2.

    Raises:
        ValueError: an argument out of range.

    Source:
        Euler-Bernoulli beam; Dana states that elastic bearings lower the critical speed. The
        bearing carries no mass of its own here.
    """
    softness = not_negative("softness", softness)
    low, high = np.zeros_like(softness), np.full_like(softness, np.pi)
    # The left side rises from 0 at z = 0 to infinity at pi.
    for _ in range(_BISECTIONS):
        z = (low + high) / 2.0
        below = softness * _bearing_number(z) < 1.0
        low, high = np.where(below, z, low), np.where(below, high, z)
    z = np.where(softness == 0.0, np.pi, np.where(np.isnan(softness), np.nan, (low + high) / 2.0))
    return ((z / np.pi) ** 2)[()]


def on_elastic_bearing(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    length: ArrayLike,
    stiffness: ArrayLike,
    modulus: ArrayLike = 2.1e11,
    density: ArrayLike = 7850.0,
) -> FloatArray:
    """First critical bending speed of a tube with one end on an elastic centre bearing.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        length: L from the joint to the bearing [m], greater than 0.
        stiffness: k of the bearing and its bracket across the shaft [N/m], greater than 0.
        modulus: Young's modulus E [Pa], greater than 0.
        density: rho [kg/m^3], greater than 0.

    Returns:
        omega [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        `shaft_design.critical_speed` and `elastic_bearing_factor`.
    """
    stiffness = positive("stiffness", stiffness)
    rigid = critical_speed(outer_diameter, inner_diameter, length, modulus, density)
    same_shape(shaft=rigid, stiffness=stiffness)
    outer, inner, length, modulus = (
        np.asarray(value, dtype=float)
        for value in (outer_diameter, inner_diameter, length, modulus)
    )
    bending = modulus * (np.pi / 64.0) * (outer - inner) * (outer + inner) * (outer**2 + inner**2)
    return rigid * elastic_bearing_factor(bending / (stiffness * length**3))


def _bearing_number(z: FloatArray) -> FloatArray:
    """z^3 (coth z - cot z) / 2, by its series for small z, where the difference cancels."""
    small = np.minimum(z, 0.05)
    # coth z - cot z = 2 (z/3 + 2 z^5/945 + ...)
    series = small**4 / 3.0 * (1.0 + 2.0 * small**4 / 315.0)
    large = np.maximum(z, 0.05)
    return np.where(z < 0.05, series, large**3 * (1.0 / np.tanh(large) - 1.0 / np.tan(large)) / 2.0)


def _size(outer_diameter: ArrayLike, inner_diameter: ArrayLike, **others: FloatArray) -> FloatArray:
    """Root of D^2 + d^2, checked."""
    outer = positive("outer_diameter", outer_diameter)
    inner = not_negative("inner_diameter", inner_diameter)
    same_shape(outer_diameter=outer, inner_diameter=inner, **others)
    full, wide = np.broadcast_arrays(inner, outer)
    refuse("inner_diameter", full, full >= wide, "[0, outer_diameter)")
    return np.hypot(outer, inner)
