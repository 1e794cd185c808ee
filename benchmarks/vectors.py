"""Vectors and rotations in numbers of any precision."""

from __future__ import annotations

from mpmath import mp, mpf

Vector = list[mpf]
Matrix = list[list[mpf]]


def identity() -> Matrix:
    """Return the identity."""
    return [[mpf(i == k) for k in range(3)] for i in range(3)]


def about(axis: Vector, angle: mpf) -> Matrix:
    """Rotation about a unit axis (Rodrigues)."""
    sine, cosine = mp.sin(angle), mp.cos(angle)
    x, y, z = axis
    skew = [[mpf(0), -z, y], [z, mpf(0), -x], [-y, x, mpf(0)]]
    return [
        [cosine * (i == k) + sine * skew[i][k] + (1 - cosine) * axis[i] * axis[k] for k in range(3)]
        for i in range(3)
    ]


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product a b."""
    return [[sum(a[i][j] * b[j][k] for j in range(3)) for k in range(3)] for i in range(3)]


def flip(a: Matrix) -> Matrix:
    """Return the transposed matrix."""
    return [list(row) for row in zip(*a, strict=True)]


def turn(a: Matrix, v: Vector) -> Vector:
    """Return a v."""
    return [dot(row, v) for row in a]


def combined(a: Matrix, b: Matrix, c: Matrix, w: tuple[int, int, int], over: mpf) -> Matrix:
    """Return (w₀ a + w₁ b + w₂ c) / over."""
    return [
        [(w[0] * a[i][k] + w[1] * b[i][k] + w[2] * c[i][k]) / over for k in range(3)]
        for i in range(3)
    ]


def axial(a: Matrix) -> Vector:
    """Return the vector of the antisymmetric part: of Ṙ Rᵀ the spin, of R̈ Rᵀ its rate."""
    return [(a[2][1] - a[1][2]) / 2, (a[0][2] - a[2][0]) / 2, (a[1][0] - a[0][1]) / 2]


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return [x + y for x, y in zip(a, b, strict=True)]


def dot(a: Vector, b: Vector) -> mpf:
    """Return the scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), mpf(0))


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
