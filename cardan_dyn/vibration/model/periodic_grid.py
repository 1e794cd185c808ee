"""Periodic grid: functions of period L at an odd number of equidistant nodes; Fourier sums.

With an odd number, derivatives lose no wave: the highest order of an even number has none.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...arrays import Array

_SIZES = (9, 15, 21, 31, 45, 63, 95, 127, 191, 255, 383, 511, 767, 1023)
"""Numbers of nodes that are tried, each some 1.5 times the one before."""
MOST_NODES = _SIZES[-1]
TAIL = 1e-13
"""Highest orders of a function, as a fraction of its greatest value, that count as rounding."""


def next_size(least: float) -> int:
    """Return the first number of nodes that is no less than another, or the greatest."""
    return next((size for size in _SIZES if size >= least), MOST_NODES)


def nodes(count: int, period: float) -> Array:
    """Return the nodes `(N,)` from 0."""
    return period / count * np.arange(count)


@lru_cache(maxsize=64)
def derivatives(count: int, period: float) -> tuple[Array, Array]:
    """Return matrices `(N, N)` that take values to their first and second derivatives."""
    orders = 2j * np.pi / period * np.fft.fftfreq(count, 1.0 / count)
    waves = np.fft.fft(np.eye(count), axis=0)
    first, second = (np.fft.ifft(orders[:, None] ** power * waves, axis=0).real for power in (1, 2))
    return first, second


def resampled(values: Array, count: int, axis: int = 0) -> Array:
    """Return values at N nodes as values at another odd number of nodes.

    With fewer nodes, the highest orders are left out.
    """
    size = values.shape[axis]
    if size == count:
        return values
    spectrum = np.moveaxis(np.fft.rfft(values, axis=axis), axis, -1)
    padded = np.zeros((*spectrum.shape[:-1], count // 2 + 1), dtype=complex)
    kept = min(spectrum.shape[-1], padded.shape[-1])
    padded[..., :kept] = spectrum[..., :kept]
    return np.moveaxis(np.fft.irfft(padded, count, axis=-1) * (count / size), -1, axis)


def orders_of(count: int, period: float) -> Array:
    """Return the first orders `(K,)` of a period [rad]: 0, 2π/L, …, cycles per revolution."""
    return 2.0 * np.pi / period * np.arange(count)


def amplitudes(values: Array, axis: int = 0) -> Array:
    """Return complex amplitudes of orders 0, 1, … (N - 1)/2: Re Σ a_k exp(2πi k x / L)."""
    spectrum = np.fft.rfft(values, axis=axis) / values.shape[axis]
    doubled = np.moveaxis(spectrum, axis, 0)
    doubled[1:] *= 2.0
    return np.moveaxis(doubled, 0, axis)


def tail(values: Array, axis: int = 0) -> Array:
    """Return the greatest of the highest eighth of the orders, as a fraction of the greatest value.

    Functions that vanish have none.
    """
    spectrum = np.moveaxis(np.abs(amplitudes(values, axis)), axis, 0)
    greatest = np.max(np.abs(values), axis=axis)
    highest = np.max(spectrum[-max(2, len(spectrum) // 8) :], axis=0)
    return np.asarray(highest / np.where(greatest > 0.0, greatest, 1.0))


def interpolation(points: Array, count: int, period: float) -> Array:
    """Return the matrix `(K, N)` that takes values at N nodes to values at K points."""
    half = np.pi / period * (np.asarray(points)[:, None] - nodes(count, period))
    below = count * np.sin(half)
    near = np.abs(np.sin(half)) < 1e-15
    kernel = np.sin(count * half) / np.where(near, 1.0, below)
    # At a node half is a multiple of π, where an odd kernel is +1.
    return np.where(near, 1.0, kernel)


def turning_values(at: Array, values: Array, rates: Array) -> Array:
    """Return values `(N - 1, …)` where functions turn between samples, or at the first of two.

    By cubics through values and rates, where the rates' chord is zero: since functions are flat
    there, their error is of fourth order in the distance of the samples.

    Args:
        at: places `(N,)` of the samples.
        values: `(N, …)`.
        rates: derivatives by the place, `(N, …)`.
    """
    step = np.diff(at).reshape(-1, *[1] * (values.ndim - 1))
    before, after = rates[:-1], rates[1:]
    turns = before * after < 0.0
    part = np.where(turns, before / np.where(turns, before - after, 1.0), 0.0)
    left = 1.0 - part
    first = left**2 * ((1.0 + 2.0 * part) * values[:-1] + step * part * before)
    return np.asarray(first + part**2 * ((1.0 + 2.0 * left) * values[1:] - step * left * after))
