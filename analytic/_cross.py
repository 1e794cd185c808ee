"""Motion of the cross, in the forms that keep their digits.

The public functions check their arguments and call these, with sine and cosine of a rotation
counted from the position with the input pin in the plane of the shafts. All but the
acceleration also take complex rotations, for derivatives by the complex step.
"""

from __future__ import annotations

import numpy as np

from ._checks import FloatArray


def sine_cosine(phi: FloatArray, zero: str) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine of the rotation counted from the position in the plane."""
    if zero == "normal":
        return np.cos(phi), -np.sin(phi)
    return np.sin(phi), np.cos(phi)


def versine(beta: FloatArray) -> FloatArray:
    """1 - cos beta."""
    return 2.0 * np.sin(beta / 2) ** 2


def denominator(cosine: FloatArray, sin_phi: FloatArray, cos_phi: FloatArray) -> FloatArray:
    """cos^2 beta cos^2 phi + sin^2 phi, a sum of squares: it cannot cancel."""
    return (cosine * cos_phi) ** 2 + sin_phi**2


def denominator_and_error(
    cosine: FloatArray, sin_phi: FloatArray, cos_phi: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The denominator and the relative error of its rounding, which its powers would multiply."""
    along, along_error = _product(cosine, cos_phi)
    square, square_error = _product(along, along)
    other, other_error = _product(sin_phi, sin_phi)
    total = square + other
    sum_error = (np.maximum(square, other) - total) + np.minimum(square, other)
    return total, (sum_error + square_error + other_error + 2.0 * along * along_error) / total


def _product(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Product and the exact error of its rounding (Dekker 1971)."""
    product = a * b
    (a_high, a_low), (b_high, b_low) = _halves(a), _halves(b)
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


def _halves(a: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Leading and trailing half of the digits (Veltkamp)."""
    shifted = (2.0**27 + 1.0) * a
    high = shifted - (shifted - a)
    return high, a - high


def lead(
    cosine: FloatArray, versine: FloatArray, sin_phi: FloatArray, cos_phi: FloatArray
) -> FloatArray:
    """Lead of the output shaft."""
    # cos beta cos^2 phi + sin^2 phi is 1 - kappa cos 2 phi without its difference.
    return np.arctan(versine * sin_phi * cos_phi / (cosine * cos_phi**2 + sin_phi**2))


def turned(beta: FloatArray, phi: FloatArray, zero: str) -> FloatArray:
    """Rotation of the output shaft."""
    cosine = np.cos(beta)
    total = phi + lead(cosine, versine(beta), *sine_cosine(phi, zero))
    if zero == "in_plane":
        return total
    # Counted from the normal position, the lag nearly cancels a small rotation at great beta.
    first_quarter = np.arctan2(cosine * np.sin(phi), np.cos(phi))
    return np.where(np.abs(phi) < np.pi / 2, first_quarter, total)[()]


def speed_ratio(cosine: FloatArray, sin_phi: FloatArray, cos_phi: FloatArray) -> FloatArray:
    """First derivative of the output rotation."""
    return cosine / denominator(cosine, sin_phi, cos_phi)


def acceleration_ratio(
    cosine: FloatArray, sine_squared: FloatArray, sin_phi: FloatArray, cos_phi: FloatArray
) -> FloatArray:
    """Second derivative of the output rotation."""
    numerator = -2.0 * cosine * sine_squared * sin_phi * cos_phi
    base, error = denominator_and_error(cosine, sin_phi, cos_phi)
    return numerator / base**2 * (1.0 - 2.0 * error)
