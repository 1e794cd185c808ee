"""Fourier: functions of a position that repeat, up to a linear part, from equidistant samples."""

from __future__ import annotations

import numpy as np

from ..arrays import Array

_BLOCK = 1_000_000
"""Exponentials that are computed at a time, so that memory does not grow with the points."""


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
        self._exponents = 1j * frequency * np.arange(coefficients.shape[1])

    @staticmethod
    def of(samples: Array, period: float) -> Fourier:
        """Return the functions with samples `(c, N)` at 0, period / N, 2 period / N and so on."""
        count = samples.shape[1]
        coefficients = np.fft.rfft(samples, axis=1) / count
        coefficients[:, 1:] *= 2.0
        if count % 2 == 0:
            coefficients = coefficients[:, :-1]
        return Fourier(coefficients, 2.0 * np.pi / period)

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
        return np.einsum("ck,k->c", self.coefficients, waves).real + self.slope * position

    def __call__(self, positions: Array) -> Array:
        """Return the values `(c, N)` at positions `(N,)`."""
        size = max(1, _BLOCK // self.coefficients.shape[1])
        parts = []
        for first in range(0, len(positions), size):
            some = positions[first : first + size]
            waves = np.exp(1j * self.frequency * np.outer(self._harmonics, some))
            parts.append((self.coefficients @ waves).real + np.outer(self.slope, some))
        return np.concatenate(parts, axis=1)

    def on_grid(self, start: float, count: int) -> Array:
        """Return the values `(c, count)` over one period, at equidistant positions from `start`."""
        phases = np.exp(1j * self.frequency * start * self._harmonics)
        padded = np.zeros((len(self.coefficients), count // 2 + 1), dtype=complex)
        kept = min(self.coefficients.shape[1], (count + 1) // 2)
        padded[:, :kept] = (self.coefficients * phases)[:, :kept]
        padded[:, 1:] *= 0.5
        values = np.fft.irfft(padded, count, axis=1) * count
        period = 2.0 * np.pi / self.frequency
        return values + np.outer(self.slope, start + period / count * np.arange(count))

    def gained(self, start: float, ways: Array) -> Array:
        """Return by how much the values `(c, N)` at `start + ways` exceed those at `start`.

        Exact relative to the way where that is short, as no differences of values are.
        """
        half = 0.5 * self.frequency * np.outer(self._harmonics, ways)
        middle = np.exp(1j * self.frequency * start * self._harmonics)[:, None] * np.exp(1j * half)
        grown = (self.coefficients @ (2j * np.sin(half) * middle)).real
        return np.asarray(grown + np.outer(self.slope, ways))
