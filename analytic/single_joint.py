"""Motion of the single universal joint.

The input shaft turns by phi_1, the output shaft by phi_2, and their axes meet at the joint
angle beta. Both rotations are counted from one of two positions:

``zero="in_plane"`` (the default)
    The pin axis of the input fork lies in the plane of the two shafts. Thoma (1920) calls
    it Hauptlage A, Grossmann (1939) starts there; tan phi_2 = tan phi_1 / cos beta.
``zero="normal"``
    The pin axis of the input fork is normal to that plane. Weisbach and Herrmann count from
    there; tan phi_2 = cos beta tan phi_1.

All angles are in radians, all arguments broadcast, and scalars give a NumPy float. Results are
exact to rounding at every joint angle below 90 degrees and any number of turns, because
the double angle never appears: sin 2 phi is formed as 2 sin phi cos phi, and what tends
to zero at 90 degrees is a product with cos beta, not a difference. An infinite rotation
gives NaN (and NumPy's warning).

References:
    J. Weisbach, G. Herrmann: Lehrbuch der Ingenieur- und Maschinen-Mechanik, part 3,
    section 1, paragraphs 24 and 26.
    H. Ch. Seherr-Thoss, F. Schmelz, E. Aucktor: Universal Joints and Driveshafts.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _cross
from ._checks import FloatArray, joint_angle, real, same_shape

__all__ = [
    "acceleration_ratio",
    "equal_speed_angle",
    "greatest_acceleration",
    "greatest_acceleration_angle",
    "greatest_lead",
    "input_angle",
    "lead",
    "non_uniformity",
    "output_angle",
    "speed_ratio",
    "speed_ratio_range",
]

Zero = Literal["in_plane", "normal"]


def output_angle(beta: ArrayLike, phi_1: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """Rotation of the output shaft.

    phi_2 = phi_1 + lead, continuous over any number of turns: it agrees with phi_1 at every
    multiple of 90 degrees.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad], any finite value.
        zero: position from which both rotations are counted.

    Returns:
        phi_2 [rad], in the broadcast shape.

    Raises:
        ValueError: beta out of range, shapes that do not match, or an unknown zero.

    Source:
        Thoma 1920 (3), (4); Grossmann 1939 (1). Weisbach paragraph 26 for zero="normal".

    >>> round(float(np.degrees(output_angle(np.radians(30), np.radians(405)))), 4)
    409.1066
    """
    beta, phi_1 = _checked(beta, "phi_1", phi_1)
    return _cross.turned(beta, phi_1, _zero(zero))


def input_angle(beta: ArrayLike, phi_2: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """Rotation of the input shaft that belongs to a rotation of the output shaft.

    The inverse of `output_angle`. Seen from the output shaft, the joint is the same joint
    with the other zero of rotation.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_2: rotation of the output shaft [rad], any finite value.
        zero: position from which both rotations are counted.

    Returns:
        phi_1 [rad], in the broadcast shape.

    Raises:
        ValueError: beta out of range, shapes that do not match, or an unknown zero.

    Source:
        Grossmann 1939 (1), tan alpha_1 = cos phi tan alpha_2.
    """
    beta, phi_2 = _checked(beta, "phi_2", phi_2)
    return _cross.turned(beta, phi_2, "normal" if _zero(zero) == "in_plane" else "in_plane")


def lead(beta: ArrayLike, phi_1: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """Lead phi_2 - phi_1 of the output shaft over the input shaft, negative where it lags.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad], any finite value.
        zero: position from which both rotations are counted.

    Returns:
        phi_2 - phi_1 [rad], in the broadcast shape, with full relative accuracy also near
        its zeros at the multiples of 90 degrees.

    Raises:
        ValueError: beta out of range, shapes that do not match, or an unknown zero.

    Source:
        Difference of the two rotations in Thoma 1920 (4); its Fourier series is
        sum kappa^n sin(2 n phi_1) / n with kappa = tan^2(beta/2).
    """
    beta, phi_1 = _checked(beta, "phi_1", phi_1)
    return _cross.lead(np.cos(beta), _cross.versine(beta), *_cross.sine_cosine(phi_1, _zero(zero)))


def speed_ratio(beta: ArrayLike, phi_1: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """Ratio omega_2 / omega_1 = d phi_2 / d phi_1.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad], any finite value.
        zero: position from which the rotation is counted.

    Returns:
        The ratio, between cos beta and 1 / cos beta, in the broadcast shape.

    Raises:
        ValueError: beta out of range, shapes that do not match, or an unknown zero.

    Source:
        Weisbach paragraph 26, cos c / (1 - sin^2 alpha sin^2 c), for zero="normal".
    """
    beta, phi_1 = _checked(beta, "phi_1", phi_1)
    return _cross.speed_ratio(np.cos(beta), *_cross.sine_cosine(phi_1, _zero(zero)))


def acceleration_ratio(beta: ArrayLike, phi_1: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """Second derivative d^2 phi_2 / d phi_1^2.

    With input speed omega_1 and input acceleration epsilon_1, the output shaft accelerates
    with speed_ratio * epsilon_1 + acceleration_ratio * omega_1^2.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad], any finite value.
        zero: position from which the rotation is counted.

    Returns:
        The derivative [1/rad], in the broadcast shape, with full relative accuracy also
        near its zeros at the multiples of 90 degrees.

    Raises:
        ValueError: beta out of range, shapes that do not match, or an unknown zero.

    Source:
        Twofold differentiation of Thoma 1920 (4), which he asks for and does not print.
    """
    beta, phi_1 = _checked(beta, "phi_1", phi_1)
    sine, cosine = _cross.sine_cosine(phi_1, _zero(zero))
    return _cross.acceleration_ratio(np.cos(beta), np.sin(beta) ** 2, sine, cosine)


def greatest_lead(beta: ArrayLike) -> FloatArray:
    """Greatest lead of the output shaft, asin tan^2(beta/2).

    It is reached at `equal_speed_angle`, and the output shaft lags as much 90 degrees later.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.

    Returns:
        The lead [rad], in the shape of `beta`; 0 at beta = 0, tending to pi/2 at 90 degrees.

    Raises:
        ValueError: beta out of range.

    Source:
        Weisbach paragraph 26, worked example: difference alpha - beta.

    >>> round(float(np.degrees(greatest_lead(np.radians(30)))), 4)
    4.1172
    """
    beta = joint_angle("beta", beta)
    return np.arctan(np.sin(beta / 2) ** 2 / np.sqrt(np.cos(beta)))


def equal_speed_angle(beta: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """First rotation of the input shaft at which both shafts turn equally fast.

    The output shaft then stands at 90 degrees minus this angle. The other positions are
    180 degrees minus it, and both again half a turn later.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        zero: position from which the rotation is counted.

    Returns:
        phi_1 [rad] between 0 and pi/2, in the shape of `beta`. At beta = 0 the speeds are
        always equal; the limit pi/4 is returned.

    Raises:
        ValueError: beta out of range or an unknown zero.

    Source:
        Weisbach paragraph 26: tan alpha = sqrt(1 / cos c), for zero="normal".
    """
    root = np.sqrt(np.cos(joint_angle("beta", beta)))
    return np.arctan(root) if _zero(zero) == "in_plane" else np.arctan(1.0 / root)


def speed_ratio_range(beta: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Smallest and greatest speed ratio, cos beta and 1 / cos beta.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.

    Returns:
        The two ratios, each in the shape of `beta`.

    Raises:
        ValueError: beta out of range.

    Source:
        Weisbach paragraph 26.
    """
    smallest = np.cos(joint_angle("beta", beta))
    return smallest, 1.0 / smallest


def non_uniformity(beta: ArrayLike) -> FloatArray:
    """Degree of non-uniformity U, greatest minus smallest speed ratio.

    U = 1 / cos beta - cos beta, formed as sin beta tan beta, which keeps all digits at small
    angles.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.

    Returns:
        U in the shape of `beta`, 0 at beta = 0 and without bound towards 90 degrees.

    Raises:
        ValueError: beta out of range.

    Source:
        Weisbach paragraph 26, worked example.

    >>> round(float(non_uniformity(np.radians(30))), 5)
    0.28868
    """
    beta = joint_angle("beta", beta)
    return np.sin(beta) * np.tan(beta)


def greatest_acceleration_angle(beta: ArrayLike, *, zero: Zero = "in_plane") -> FloatArray:
    """First rotation phi_1 > 0 at which the output shaft accelerates or brakes most.

    With the default zero it brakes there, and accelerates as much at minus this angle; with
    the other zero it is the other way round.

    tan^2 phi_1 = 2 cos^2 beta / (3 sin^2 beta + sqrt(9 sin^4 beta + 4 cos^2 beta)), the exact
    stationary point. The common textbook form cos 2 phi_1 = 2 sin^2 beta / (2 - sin^2 beta)
    is an approximation for small angles: the acceleration there is 1.6 % too small at 45 degrees,
    and beyond 54.7 degrees it has no solution.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        zero: position from which the rotation is counted.

    Returns:
        phi_1 [rad] between 0 and pi/2, in the shape of `beta`; pi/4 in the limit beta = 0.

    Raises:
        ValueError: beta out of range or an unknown zero.

    Source:
        Zero of the third derivative of Thoma 1920 (4).
    """
    tangent = _greatest_acceleration_tangent(joint_angle("beta", beta))
    return np.arctan(tangent) if _zero(zero) == "in_plane" else np.arctan(1.0 / tangent)


def greatest_acceleration(beta: ArrayLike) -> FloatArray:
    """Greatest absolute value of d^2 phi_2 / d phi_1^2 over a turn.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.

    Returns:
        The value [1/rad] in the shape of `beta`; close to beta^2 for small angles.

    Raises:
        ValueError: beta out of range.

    Source:
        `acceleration_ratio` at `greatest_acceleration_angle`.
    """
    beta = joint_angle("beta", beta)
    cosine, sine = np.cos(beta), np.sin(beta)
    tangent = _greatest_acceleration_tangent(beta)
    square = tangent**2
    return 2.0 * cosine * sine**2 * tangent * (1.0 + square) / (cosine**2 + square) ** 2


def _checked(beta: ArrayLike, name: str, phi: ArrayLike) -> tuple[FloatArray, FloatArray]:
    angle, rotation = joint_angle("beta", beta), real(name, phi)
    same_shape(**{"beta": angle, name: rotation})
    return angle, rotation


def _zero(zero: str) -> str:
    if zero not in ("in_plane", "normal"):
        raise ValueError(f"zero = {zero!r} is not one of 'in_plane', 'normal'")
    return zero


def _greatest_acceleration_tangent(beta: FloatArray) -> FloatArray:
    cosine, triple = np.cos(beta), 3.0 * np.sin(beta) ** 2
    return cosine * np.sqrt(2.0 / (triple + np.hypot(triple, 2.0 * cosine)))
