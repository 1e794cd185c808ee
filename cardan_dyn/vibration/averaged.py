"""Averaged model: the linear equation with its mean coefficients, and its modes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .reduced_model import LocalEquation

_UNDAMPED = 1e-12
"""Damping ratio that counts as rounding."""
_REAL = 1e-9
"""Imaginary part of an eigenvalue, as a fraction of its size, that is rounding: of a double one it
is the root of eps."""
_ROUNDING = 16.0 * float(np.finfo(float).eps)
"""Error of an eigenvalue, as a fraction of the greatest."""


class Modes(NamedTuple):
    """Modes of S linear equations of n coordinates, by ascending frequency.

    Attributes:
        value: complex eigenvalues `(S, n)` [1/s], imaginary part not negative: those that swing,
            then real ones, of which the greater of each coordinate's pair is kept.
        shape: complex mode shapes `(S, n, n)`, a column for each, greatest entry 1.
    """

    value: Array
    shape: Array

    @property
    def frequency(self) -> Array:
        """Natural angular frequencies, damped `(S, n)` [rad/s]; 0 where a mode does not swing."""
        return np.asarray(self.value.imag)

    @property
    def log_decrement(self) -> Array:
        """Logarithm of the ratio of two swings that follow each other `(S, n)`."""
        swings = self.frequency > 0.0
        frequency = np.where(swings, self.frequency, 1.0)
        return np.where(swings, -2.0 * np.pi * self.value.real / frequency, np.nan)

    @property
    def amplification(self) -> Array:
        """Amplification factor Q = 1/(2ζ) `(S, n)`; infinite without damping, NaN for creeping."""
        size = np.abs(self.value)
        is_damped = -self.value.real > _UNDAMPED * size
        factor = size / np.where(is_damped, -2.0 * self.value.real, 1.0)
        # A real eigenvalue alone says nothing of ζ, for which the other one of its pair is needed.
        swings = self.frequency > 0.0
        return np.where(swings, np.where(is_damped, factor, np.inf), np.nan)


def averaged(equation: LocalEquation) -> tuple[Array, Array, Array]:
    """Return mass, damping and stiffness `(S, n, n)` of S motions, averaged over their period."""
    return tuple(
        np.mean(item, axis=1) for item in (equation.mass, equation.damping, equation.stiffness)
    )


def modes(mass: Array, damping: Array, stiffness: Array) -> Modes:
    """Return the modes of M ẍ + D ẋ + K x = 0, by the eigenvalues of its first-order form.

    Args:
        mass: M `(S, n, n)`, regular.
        damping: D, likewise.
        stiffness: K, likewise.
    """
    count, free, _ = mass.shape
    matrix = np.zeros((count, 2 * free, 2 * free))
    matrix[:, :free, free:] = np.eye(free)
    matrix[:, free:, :free] = -np.linalg.solve(mass, stiffness)
    matrix[:, free:, free:] = -np.linalg.solve(mass, damping)
    values, vectors = np.linalg.eig(matrix)
    size = np.abs(values)
    # One mode may be faster than another by far: rounding is that of the fastest.
    is_real = np.abs(values.imag) <= _REAL * size + _ROUNDING * np.max(size, axis=1, keepdims=True)
    # Of each complex pair the upper one, of each real pair the greater: there λ² M + λ D + K rises.
    x = vectors[:, :free]
    rise = 2.0 * values[:, None, :] * (mass @ x) + damping @ x
    is_greater = np.sum(x.conj() * rise, axis=1).real > 0.0
    rank = np.where(is_real, np.where(is_greater, 1.0, 2.0), np.where(values.imag > 0.0, 0.0, 3.0))
    key = np.where(is_real, -values.real, values.imag)
    order = np.lexsort((key, rank), axis=1)[:, :free]
    chosen = np.take_along_axis(values, order, axis=1)
    real = np.take_along_axis(is_real, order, axis=1)
    chosen = np.where(real, chosen.real + 0.0j, chosen)
    shapes = np.take_along_axis(vectors[:, :free], order[:, None, :], axis=2)
    largest = np.argmax(np.abs(shapes), axis=1)[:, None, :]
    return Modes(chosen, shapes / np.take_along_axis(shapes, largest, axis=1))
