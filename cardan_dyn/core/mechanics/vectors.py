"""Vectors: three scalars each; rotations: three of them, where the axes x, y and z are turned to.

A scalar is a float, an array with a number per sample, or a traced variable. The float 0.0 stands
for what is zero at all positions, and falls away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Scalar = Any
"""A float, an array `(N,)`, or a traced variable."""
Vector = Sequence[Scalar]
"""Three scalars."""
Rotation = Sequence[Vector]
"""Three vectors: the turned axes."""

ZERO: Vector = (0.0, 0.0, 0.0)
UNTURNED: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def added(first: Vector, second: Vector) -> Vector:
    """Return the sum of two vectors."""
    return first[0] + second[0], first[1] + second[1], first[2] + second[2]


def less(first: Vector, second: Vector) -> Vector:
    """Return the first vector less the second."""
    return first[0] - second[0], first[1] - second[1], first[2] - second[2]


def times(vector: Vector, factor: Scalar) -> Vector:
    """Return a vector times a scalar."""
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def cross(first: Vector, second: Vector) -> Vector:
    """Return the cross product of two vectors."""
    return (
        first[1] * second[2] - first[2] * second[1],
        first[2] * second[0] - first[0] * second[2],
        first[0] * second[1] - first[1] * second[0],
    )


def dot(first: Vector, second: Vector) -> Scalar:
    """Return the scalar product of two vectors."""
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


def turned(rotation: Rotation, vector: Vector) -> Vector:
    """Return a vector that a turned body carries, in the axes that the body was turned from."""
    x, y, z = rotation
    return added(added(times(x, vector[0]), times(y, vector[1])), times(z, vector[2]))


def seen(rotation: Rotation, vector: Vector) -> Vector:
    """Return a vector in the axes of a turned body."""
    return dot(rotation[0], vector), dot(rotation[1], vector), dot(rotation[2], vector)


def product(first: Rotation, second: Rotation) -> Rotation:
    """Return the second rotation followed by the first."""
    return turned(first, second[0]), turned(first, second[1]), turned(first, second[2])


def about_axis(rotation: Rotation, axis: int, sine: Scalar, cosine: Scalar) -> Rotation:
    """Return a rotation after a turn about one of its own axes (0, 1, 2)."""
    second, third = rotation[(axis + 1) % 3], rotation[(axis + 2) % 3]
    result = list(rotation)
    result[(axis + 1) % 3] = added(times(second, cosine), times(third, sine))
    result[(axis + 2) % 3] = less(times(third, cosine), times(second, sine))
    return result


def about(axis: Vector, sine: Scalar, cosine: Scalar) -> Rotation:
    """Return the rotation about a constant unit axis: c 1 + s [n]× + (1 - c) n nᵀ (Rodrigues)."""
    x, y, z = axis
    rest = 1.0 - cosine
    return (
        (cosine + rest * (x * x), rest * (x * y) + sine * z, rest * (x * z) - sine * y),
        (rest * (x * y) - sine * z, cosine + rest * (y * y), rest * (y * z) + sine * x),
        (rest * (x * z) + sine * y, rest * (y * z) - sine * x, cosine + rest * (z * z)),
    )


def of_quaternion(quaternion: Sequence[Scalar]) -> Rotation:
    """Return the rotation of a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz, wx, wy, wz = x * y, x * z, y * z, w * x, w * y, w * z
    return (
        (1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)),
        (2.0 * (xy - wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + wx)),
        (2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (xx + yy)),
    )
