"""Checks of the arguments of public functions.

Every domain error is a ``ValueError`` that names the argument, the value and the valid
range. NaN is no error: it passes through and makes NaN in its own places only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def real(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` as an array of floats; refuse complex numbers and non-numbers."""
    array = np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{name} = {value!r} must be real numbers, not {array.dtype}")
    return array.astype(np.float64, copy=False)


def refuse(name: str, array: FloatArray, bad: NDArray[np.bool_], valid: str) -> None:
    """Raise a ValueError that names the first value that is bad."""
    if np.any(bad):
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        index = f"[{', '.join(map(str, where))}]" if where else ""
        raise ValueError(f"{name}{index} = {array[where]} is not in the valid range {valid}")


def finite(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` if it is not infinite anywhere."""
    array = real(name, value)
    refuse(name, array, np.isinf(array), "(-inf, inf)")
    return array


def joint_angle(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` if 0 <= value < pi/2 everywhere [rad]."""
    array = real(name, value)
    refuse(name, array, (array < 0.0) | (array >= np.pi / 2), "[0, pi/2) rad")
    return array


def projected_angle(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` if -pi/2 < value < pi/2 everywhere [rad]."""
    array = real(name, value)
    refuse(name, array, np.abs(array) >= np.pi / 2, "(-pi/2, pi/2) rad")
    return array


def positive(name: str, value: ArrayLike, *, unlimited: bool = False) -> FloatArray:
    """Return `value` if it is greater than zero and, unless `unlimited`, finite everywhere."""
    array = real(name, value)
    wrong = (array <= 0.0) | (np.isinf(array) & (not unlimited))
    refuse(name, array, wrong, "(0, inf]" if unlimited else "(0, inf)")
    return array


def fraction(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` if it is above zero and at most one everywhere."""
    array = real(name, value)
    refuse(name, array, (array <= 0.0) | (array > 1.0), "(0, 1]")
    return array


def not_negative(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` if it is zero or greater and finite everywhere."""
    array = real(name, value)
    refuse(name, array, (array < 0.0) | np.isinf(array), "[0, inf)")
    return array


def vector(name: str, value: ArrayLike) -> FloatArray:
    """Return `value` as unit vectors along its last axis of 3."""
    array = real(name, value)
    if array.shape[-1:] != (3,):
        raise ValueError(f"{name} of shape {array.shape} does not match the valid shape (..., 3)")
    greatest = np.max(np.abs(array), axis=-1)
    refuse(f"length of {name}", greatest, (greatest <= 0.0) | np.isinf(greatest), "(0, inf)")
    # A power of two, so that squares neither vanish nor overflow and no digit changes.
    _, exponent = np.frexp(greatest)
    array = np.ldexp(array, -exponent[..., None])
    return array / np.sqrt(np.sum(array * array, axis=-1))[..., None]


def same_shape(**arrays: FloatArray) -> tuple[int, ...]:
    """Return the shape that all arguments broadcast to."""
    try:
        return np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise ValueError(
            f"shapes of {shapes} do not match: valid are shapes that broadcast"
        ) from None
