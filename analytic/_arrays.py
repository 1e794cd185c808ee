"""Small helpers on arrays and on vectors along their last axis."""

from __future__ import annotations

import numpy as np

from ._checks import FloatArray


def filled(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return `values` in this shape, as an array that can be written to or as a scalar."""
    return np.array(np.broadcast_to(values, shape))[()]


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar products of vectors along the last axis."""
    return np.sum(a * b, axis=-1)


def length(vectors: FloatArray) -> FloatArray:
    """Return the lengths of vectors along the last axis."""
    return np.sqrt(dot(vectors, vectors))


def plane_normal(axis_1: FloatArray, axis_2: FloatArray) -> FloatArray:
    """Return the cross product of unit vectors, zero if they are parallel to rounding."""
    normal = np.cross(axis_1, axis_2)
    straight = length(normal) <= 4.0 * np.finfo(float).eps
    return np.where(straight[..., None], 0.0, normal)
