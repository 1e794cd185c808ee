"""Vectors with their first and second time derivatives, by the product and chain rules.

They give speeds and accelerations of frames from their geometry alone: write down where the axes
of a body point, and `spin` tells how the body turns. Nothing here knows the package under test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


def dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1, keepdims=True)


@dataclass(frozen=True)
class Jet:
    """Vectors `(N, 3)` with first and second derivative."""

    value: Array
    first: Array
    second: Array

    @classmethod
    def constant(cls, vectors: Array) -> Jet:
        return cls(vectors, np.zeros_like(vectors), np.zeros_like(vectors))

    @classmethod
    def carried(cls, arms: Array, omega: Array, alpha: Array) -> Jet:
        """Vectors fixed in a body that turns with ω and α."""
        first = np.cross(omega, arms)
        return cls(arms, first, np.cross(alpha, arms) + np.cross(omega, first))

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.value + other.value, self.first + other.first, self.second + other.second)

    def __sub__(self, other: Jet) -> Jet:
        return self + other * -1.0

    def __mul__(self, factor: float) -> Jet:
        return Jet(factor * self.value, factor * self.first, factor * self.second)

    def cross(self, other: Jet) -> Jet:
        return Jet(
            np.cross(self.value, other.value),
            np.cross(self.first, other.value) + np.cross(self.value, other.first),
            np.cross(self.second, other.value)
            + 2.0 * np.cross(self.first, other.first)
            + np.cross(self.value, other.second),
        )

    def length(self) -> tuple[Array, Array, Array]:
        """Return the length `(N, 1)` with its derivatives."""
        size = np.sqrt(dot(self.value, self.value))
        first = dot(self.value, self.first) / size
        product = dot(self.first, self.first) + dot(self.value, self.second)
        return size, first, (product - first**2) / size

    def unit(self) -> Jet:
        size, size_1, size_2 = self.length()
        value = self.value / size
        first = (self.first - size_1 * value) / size
        return Jet(value, first, (self.second - size_2 * value - 2.0 * size_1 * first) / size)


def spin(frame: tuple[Jet, Jet, Jet]) -> tuple[Array, Array]:
    """Return ω and α `(N, 3)` of a body from its three orthonormal axes.

    Every axis obeys r' = ω × r, hence ω = ½ Σ r × r' and α = ½ Σ r × r''.
    """
    omega = sum(0.5 * np.cross(axis.value, axis.first) for axis in frame)
    alpha = sum(0.5 * np.cross(axis.value, axis.second) for axis in frame)
    return np.asarray(omega), np.asarray(alpha)
