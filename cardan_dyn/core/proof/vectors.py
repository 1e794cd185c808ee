"""Vectors: 3-vectors of scalars of any kind, and the few products of them that mechanics needs.

Scalars are floats, arrays of all samples `(N,)` or traced variables, see `tape`. What is known to
be zero or one while the text runs costs nothing: vectors that are `ZERO`, factors that are floats.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from ..tape import Scalar, absolute, greater, sqrt

Vector: TypeAlias = tuple[Scalar, Scalar, Scalar]

ZERO: Vector = (0.0, 0.0, 0.0)
_LEAST_SIZE = 1e-300
"""Added to what is divided by, so that nothing is divided by zero: next to the least double,
2e-308, numbers have too few digits to agree in."""


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    if a is ZERO:
        return b
    if b is ZERO:
        return a
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    if b is ZERO:
        return a
    if a is ZERO:
        return -b[0], -b[1], -b[2]
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(a: Vector, factor: Scalar) -> Vector:
    """Return a vector times a scalar."""
    if type(factor) is float:
        if factor == 0.0 or a is ZERO:
            return ZERO
        if factor == 1.0:
            return a
    return ZERO if a is ZERO else (a[0] * factor, a[1] * factor, a[2] * factor)


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    if a is ZERO or b is ZERO:
        return ZERO
    (a_x, a_y, a_z), (b_x, b_y, b_z) = a, b
    return a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


def dot(a: Vector, b: Vector) -> Scalar:
    """Return a · b."""
    if a is ZERO or b is ZERO:
        return 0.0
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def combine(axes: Iterable[Vector], factors: Iterable[Scalar]) -> Vector:
    """Return the sum of axes times factors: a vector in the axes in which these are given."""
    result = ZERO
    for axis, factor in zip(axes, factors, strict=True):
        if axis is ZERO:
            continue
        x, y, z = axis
        if type(factor) is not float or factor not in (0.0, 1.0):
            x, y, z = x * factor, y * factor, z * factor
        elif factor == 0.0:
            continue
        result = (x, y, z) if result is ZERO else (result[0] + x, result[1] + y, result[2] + z)
    return result


def component(a: Vector, axis: Vector) -> Scalar:
    """Return the component of a vector along a constant axis that is given in the same axes."""
    result: Scalar = 0.0
    for own, constant in zip(a, axis, strict=True):
        if constant:
            part = own if constant == 1.0 else own * constant
            result = result + part if type(result) is not float or result else part
    return result


def components(axes: tuple[Vector, Vector, Vector], a: Vector) -> Vector:
    """Return the components of a vector along three axes."""
    return ZERO if a is ZERO else (dot(axes[0], a), dot(axes[1], a), dot(axes[2], a))


def times(a: Scalar, factor: Scalar) -> Scalar:
    """Return a scalar times another, which often is a constant of 0, 1 or -1."""
    if not isinstance(factor, float):
        return a * factor
    if factor == 1.0:
        return a
    return -a if factor == -1.0 else a * factor if factor else 0.0


def total(values: Iterable[Scalar]) -> Scalar:
    """Return the sum."""
    result: Scalar = 0.0
    for value in values:
        if type(value) is not float or value != 0.0:
            result = value if type(result) is float and result == 0.0 else result + value
    return result


def norm(a: Vector) -> Scalar:
    """Return |a|, infinite where squares overflow."""
    return 0.0 if a is ZERO else sqrt(dot(a, a))


def greatest(values: Iterable[Scalar]) -> Scalar:
    """Return the greatest absolute value; 0 of none, NaN if one is NaN."""
    number, other = 0.0, None
    for value in values:
        if type(value) is float:
            size = -value if value < 0.0 else value
            if size > number or size != size:
                number = size
        else:
            other = absolute(value) if other is None else greater(other, absolute(value))
    if other is None:
        return number
    return greater(other, number) if number else other


def greatest_norm(vectors: Iterable[Vector]) -> Scalar:
    """Return the greatest |a|, also where squares would overflow or vanish, as `hypot` does."""
    given = [a for a in vectors if a is not ZERO]
    if not given:
        return 0.0
    size = greatest([component for a in given for component in a]) + _LEAST_SIZE
    unit = 1.0 / size
    parts = [scale(a, unit) for a in given]
    return size * sqrt(greatest([dot(part, part) for part in parts]))


def ratio(numerator: Scalar, denominator: Scalar) -> Scalar:
    """Return a quotient: zero for the numerator zero, very great if only the denominator is."""
    return numerator / (denominator + _LEAST_SIZE)
