"""Periodic: real functions of period L, known by their values at equal steps of it.

N values at L j / N are those of Re Σ a_k exp(2πi k x / L), k = 0 … N // 2. The amplitude a_0 is the
mean, |a_k| half the way from peak to peak of an order. Of the highest order of an even number the
values show a cosine alone: it has no derivative, and `Fourier` leaves it out. Functions that are
differentiated are therefore known at an odd number of nodes.
"""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from .arrays import Array

_SIZES = (9, 15, 21, 31, 45, 63, 95, 127, 191, 255, 383, 511, 767, 1023)
"""Numbers of nodes that are tried, each some 1.5 times the one before."""
MOST_NODES = _SIZES[-1]
TAIL = 1e-13
"""Highest orders of a function, as a fraction of its greatest value, that count as rounding."""
_BLOCK = 1_000_000
"""Exponentials that are computed at a time, so that memory does not grow with the points."""
_PRODUCTS = 100_000
"""Products in a product of matrices, up to which libraries start no threads for it."""


def next_size(least: float) -> int:
    """Return the first number of nodes that is no less than another, or the greatest."""
    return next((size for size in _SIZES if size >= least), MOST_NODES)


def nodes(count: int, period: float) -> Array:
    """Return the nodes `(N,)` from 0."""
    return period / count * np.arange(count)


def amplitudes(values: Array, axis: int = 0) -> Array:
    """Return complex amplitudes `(N // 2 + 1)` of orders 0, 1, … along the axis of N values."""
    waves = np.moveaxis(np.fft.rfft(values, axis=axis, norm="forward"), axis, 0)
    waves[1 : (values.shape[axis] + 1) // 2] *= 2.0
    return np.moveaxis(waves, 0, axis)


def sampled(waves: Array, count: int, axis: int = 0) -> Array:
    """Return values at a number of nodes of functions with amplitudes along an axis.

    Orders that the nodes cannot tell from lower ones are left out.
    """
    spectrum = 0.5 * np.moveaxis(waves, axis, -1)[..., : count // 2 + 1]
    spectrum[..., 0] *= 2.0
    if 2 * (spectrum.shape[-1] - 1) == count:
        spectrum[..., -1] *= 2.0
    return np.moveaxis(np.fft.irfft(spectrum, count, norm="forward"), -1, axis)


def resampled(values: Array, count: int, axis: int = 0) -> Array:
    """Return values at N nodes as values at another number of nodes, see `sampled`."""
    if values.shape[axis] == count:
        return values
    return sampled(amplitudes(values, axis), count, axis)


def shifted(values: Array, part: float, axis: int = 0) -> Array:
    """Return values `part` of a step behind an odd number of nodes."""
    waves, count = np.moveaxis(amplitudes(values, axis), axis, -1), values.shape[axis]
    turned = waves * np.exp(2j * np.pi * part / count * np.arange(waves.shape[-1]))
    return np.moveaxis(sampled(turned, count, -1), -1, axis)


@lru_cache(maxsize=64)
def derivatives(count: int, period: float) -> tuple[Array, Array]:
    """Return matrices `(N, N)` that take values at N nodes to first and second derivatives."""
    waves, rate = amplitudes(np.eye(count)), 1j * orders_of(count // 2 + 1, period)[:, None]
    return sampled(rate * waves, count), sampled(rate**2 * waves, count)


def orders_of(count: int, period: float) -> Array:
    """Return the first orders `(K,)` of a period [rad]: 0, 2π/L, …, cycles per revolution."""
    return 2.0 * np.pi / period * np.arange(count)


def highest(values: Array, axis: int = 0) -> Array:
    """Return the greatest amplitude of the highest eighth of the orders."""
    sizes = np.moveaxis(np.abs(amplitudes(values, axis)), axis, 0)
    return np.asarray(np.max(sizes[-max(2, len(sizes) // 8) :], axis=0))


def tail(values: Array, axis: int = 0) -> Array:
    """Return the greatest of the highest eighth of the orders, as a fraction of the greatest value.

    Functions that vanish have none.
    """
    greatest = np.max(np.abs(values), axis=axis)
    return np.asarray(highest(values, axis) / np.where(greatest > 0.0, greatest, 1.0))


def interpolation(points: Array, count: int, period: float) -> Array:
    """Return the matrix `(K, N)` that takes values at N nodes to values at K points."""
    half = np.pi / period * (np.asarray(points)[:, None] - nodes(count, period))
    below = count * np.sin(half)
    near = np.abs(np.sin(half)) < 1e-15
    kernel = np.sin(count * half) / np.where(near, 1.0, below)
    # At a node half is a multiple of π, where an odd kernel is +1.
    return np.where(near, 1.0, kernel)


class Fourier:
    """Real functions `slope · φ + Σ c_k exp(i k w φ)`, their derivatives and integrals.

    Attributes:
        coefficients: complex `(c, K)`, those of the harmonics 0 to K - 1; all but the first count
            twice.
        slope: `(c,)` linear parts.
        frequency: w [1/rad].
    """

    def __init__(self, coefficients: Array, frequency: float, slope: Array | None = None) -> None:
        self.coefficients = coefficients
        self.frequency = frequency
        self.slope = np.zeros(len(coefficients)) if slope is None else slope

    @cached_property
    def _every(self) -> int:
        """Of functions that repeat within the period, which harmonics are not nothing."""
        (there,) = np.nonzero(np.any(self.coefficients[:, 1:], axis=0))
        return int(np.gcd.reduce(there + 1)) or 1

    @cached_property
    def _own(self) -> Array:
        """Coefficients of these harmonics."""
        return np.asarray(self.coefficients[:, :: self._every])

    @cached_property
    def _own_frequency(self) -> float:
        return self._every * self.frequency

    @cached_property
    def _exponents(self) -> Array:
        return np.asarray(1j * self._own_frequency * np.arange(self._own.shape[1]))

    @staticmethod
    def of(samples: Array, period: float) -> Fourier:
        """Return the functions with samples `(c, N)` at 0, period / N, 2 period / N and so on."""
        waves = amplitudes(samples, 1)[:, : (samples.shape[1] + 1) // 2]
        return Fourier(waves, 2.0 * np.pi / period)

    def tail(self) -> Array:
        """Return `(c,)` the greatest of the last quarter of coefficients, relative to all."""
        sizes = np.abs(self.coefficients)
        last = sizes[:, (3 * sizes.shape[1]) // 4 :]
        greatest = np.max(sizes, axis=1)
        return np.asarray(
            np.max(last, axis=1, initial=0.0) / np.where(greatest > 0.0, greatest, 1.0)
        )

    def shortened(self, tolerance: float) -> Fourier:
        """Return the same without the last harmonics, which are below a fraction of the first."""
        sizes = np.max(np.abs(self.coefficients), axis=0)
        kept = np.nonzero(sizes > tolerance * np.max(sizes))[0]
        count = int(kept[-1]) + 1 if kept.size else 1
        return Fourier(self.coefficients[:, :count], self.frequency, self.slope)

    @property
    def _harmonics(self) -> Array:
        return np.arange(self.coefficients.shape[1])

    def derivative(self) -> Fourier:
        """Return the derivatives."""
        factor = 1j * self.frequency * self._harmonics
        coefficients = self.coefficients * factor
        coefficients[:, 0] = self.slope
        return Fourier(coefficients, self.frequency)

    def integral(self) -> Fourier:
        """Return integrals; the functions have no linear part."""
        factor = 1j * self.frequency * np.maximum(self._harmonics, 1)
        coefficients = self.coefficients / factor
        coefficients[:, 0] = 0.0
        return Fourier(coefficients, self.frequency, self.coefficients[:, 0].real)

    def at(self, position: float) -> Array:
        """Return the values `(c,)` at one position."""
        waves = np.exp(self._exponents * position)
        # Not by a matrix product: for one of this size, libraries start threads.
        return np.einsum("ck,k->c", self._own, waves).real + self.slope * position

    def __call__(self, positions: Array) -> Array:
        """Return the values `(c, N)` at positions `(N,)`."""
        return np.concatenate(
            [self._values(some) + np.outer(self.slope, some) for some in self._blocks(positions)],
            axis=1,
        )

    def _values(self, positions: Array) -> Array:
        """Return the real parts `(c, N)` of the sums of harmonics at positions `(N,)`.

        Sums over fine waves are the coefficients of a polynomial in the coarse one.
        """
        own, frequency = self._own, self._own_frequency
        rows, count = own.shape
        fine = int(np.ceil(np.sqrt(count)))
        coarse = -(-count // fine)
        padded = np.zeros((rows, coarse * fine), dtype=complex)
        padded[:, :count] = own
        padded = padded.reshape(rows * coarse, fine)
        result = np.empty((rows, len(positions)))
        size = max(1, _PRODUCTS // padded.size)
        for first in range(0, len(positions), size):
            span = slice(first, first + size)
            base = _multiples(np.exp(1j * frequency * positions[span]), fine + 1)
            sums = (padded @ base[:fine]).reshape(rows, coarse, -1)
            values = sums[:, -1]
            for index in range(coarse - 2, -1, -1):
                values = values * base[fine] + sums[:, index]
            result[:, span] = values.real
        return result

    def _summed(self, waves: Array) -> Array:
        """Return the real parts `(c, N)` of the sums of harmonics `(K, N)`."""
        # Not by a matrix product: for one of this size, libraries start threads.
        return np.einsum("ck,kn->cn", self._own, waves).real

    def _blocks(self, *values: Array) -> list[Any]:
        """Return parts of one array `(N,)`, or tuples of parts of several."""
        size = max(1, _BLOCK // self._own.shape[1])
        spans = [slice(first, first + size) for first in range(0, len(values[0]), size)]
        if len(values) == 1:
            return [values[0][span] for span in spans]
        return [tuple(item[span] for item in values) for span in spans]

    def _waves(self, positions: Array) -> Array:
        """Return exp(i k w φ) `(K, N)` at positions `(N,)`.

        Products of coarse and fine waves: a product takes a tenth of the time of an exponential.
        """
        count, frequency = self._own.shape[1], self._own_frequency
        fine = int(np.ceil(np.sqrt(count)))
        coarse = -(-count // fine)
        base = np.exp(1j * frequency * np.outer(np.arange(fine), positions))
        steps = np.exp(1j * frequency * fine * np.outer(np.arange(coarse), positions))
        return np.asarray((steps[:, None] * base).reshape(coarse * fine, -1)[:count])

    def on_grid(self, start: float, count: int) -> Array:
        """Return the values `(c, count)` over one period, at equidistant positions from `start`."""
        phases = np.exp(1j * self.frequency * start * self._harmonics)
        values = sampled(self.coefficients * phases, count, 1)
        period = 2.0 * np.pi / self.frequency
        return values + np.outer(self.slope, start + period / count * np.arange(count))

    def gained(self, starts: Array, ways: Array) -> Array:
        """Return by how much the values `(c, N)` at `starts + ways` exceed those at `starts`.

        Exact relative to the way where that is short, as no differences of values are.

        Args:
            starts: positions `(N,)`.
            ways: `(N,)`.
        """
        parts = []
        for start, way in self._blocks(starts, ways):
            half = 0.5 * self._own_frequency * np.outer(np.arange(self._own.shape[1]), way)
            waves = self._waves(start + 0.5 * way) * (2j * np.sin(half))
            parts.append(self._summed(waves) + np.outer(self.slope, way))
        return np.concatenate(parts, axis=1)

    def bent(self, starts: Array, ways: Array) -> Array:
        """Return by how much the values `(c, N)` at `starts + ways` exceed tangents at `starts`.

        Exact relative to the square of the way where that is short: beside an extremum, `gained`
        has but the digits that are left of its slope.

        Args:
            starts: positions `(N,)`.
            ways: `(N,)`.
        """
        parts = []
        for start, way in self._blocks(starts, ways):
            angles = self._own_frequency * np.outer(np.arange(self._own.shape[1]), way)
            grown = -2.0 * np.sin(0.5 * angles) ** 2 + 1j * _sine_less_angle(angles)
            parts.append(self._summed(self._waves(start) * grown))
        return np.concatenate(parts, axis=1)


def _multiples(waves: Array, count: int) -> Array:
    """Return the powers 0, 1, … of exponentials `(N,)` as `(count, N)`.

    Each is a product of two of half its power: it is off by as many roundings as its phase is.
    """
    result = np.empty((count, len(waves)), dtype=complex)
    result[0] = 1.0
    result[1:2] = waves
    known = 2
    while known < count:
        more = min(known - 1, count - known)
        np.multiply(result[1 : 1 + more], result[known - 1], out=result[known : known + more])
        known += more
    return result


def _sine_less_angle(angles: Array) -> Array:
    """Return sin x - x, exact relative to itself however small x is."""
    square = angles * angles
    series = np.zeros_like(angles)
    # Down from the power of 17: the next is below rounding for the angles that it is used for.
    for power in range(17, 1, -2):
        series = (1.0 - series) * square / (power * (power - 1))
    return np.where(np.abs(angles) < 1.0, -angles * series, np.sin(angles) - angles)
