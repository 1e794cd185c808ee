"""Series: many functions of one variable, known to rounding from a few hundred samples.

A periodic function sampled at equal steps has Fourier coefficients that fall off geometrically,
one on a range sampled at Chebyshev points likewise. Once they reach rounding, the series gives the
function everywhere: on uniform grids by FFT, elsewhere by interpolation of low degree in a table
that was made by FFT and is fine enough for it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import accumulate

import numpy as np

from ...kit.arrays import EPS, LARGE_BLOCK, Array, blocks
from ...kit.frozen import read_only
from .domain import Domain

_DEGREE = 7
"""Degree of the interpolation in a table."""
_FINENESS = 32
"""Table steps per sample: the interpolation misses the highest order by (π/32)⁸ · 43 / 8! = 1e-11
of its coefficient, which is itself near rounding, and lower ones by less than rounding."""


@dataclass(frozen=True, eq=False)
class Location:
    """Positions as steps in the tables of a series.

    Attributes:
        shape: of the positions.
        left: first table step that each one reads.
        weights: of the steps that it reads.
    """

    shape: tuple[int, ...]
    left: Array
    weights: list[Array]


@dataclass(frozen=True, eq=False)
class Series:
    """Functions on a domain; their samples cannot be written to.

    Attributes:
        values: `(C, M)` samples of C functions at `domain.nodes`.
        domain: a period or a range.
    """

    values: Array
    domain: Domain
    _tables: dict[int, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        read_only(self.values)

    def __reduce__(self) -> tuple[object, ...]:
        # Without the tables, which are 32 times as large and soon made again.
        return Series, (self.values, self.domain)

    def spectrum(self) -> Array:
        """Return sizes `(C, K)` of the coefficients by order, lowest first."""
        return np.asarray(np.abs(self._coefficients()))

    def remainder(self, rounding: Array) -> Array:
        """Return `(C,)` the greatest error that the orders beyond the last one can make.

        They are taken to fall off as the coefficients do over the last three quarters of the
        orders, each represented by its greatest one: single ones may be zero, as every other one
        of a Cardan joint is. What lies beyond is added up, since near the end of a range, or at a
        peak, all of it has the same sign.

        Args:
            rounding: `(C,)` of the samples. Where it explains the last coefficients and they no
                longer fall off, there is nothing beyond them but more of it.
        """
        spectrum = self.spectrum()
        highest = spectrum.shape[1] - 1
        starts = [(highest * eighth) // 8 + 1 for eighth in range(8)]
        eighths = np.maximum.reduceat(spectrum, starts, axis=1)
        second, third, last = np.maximum(eighths[:, 2::2], eighths[:, 3::2]).T
        with np.errstate(divide="ignore", invalid="ignore"):
            # The slower of two measures: from a bump in the spectrum alone it would seem fast.
            decay = np.fmax(last / third, np.sqrt(last / second))
        decay = np.clip(np.nan_to_num(decay, nan=0.0), 0.0, 1.0)
        # From one order to the next, of which a quarter has `highest / 4`. If coefficients hardly
        # fall off, as many are taken to be missing as there are.
        factor = np.minimum(decay ** (4.0 / highest), 1.0 - 1.0 / highest)
        # Noise is of one size; what falls to rounding decreases by a factor of ten and more.
        is_flat = 4.0 * eighths[:, 7] >= np.maximum(eighths[:, 5], eighths[:, 6])
        is_noise = is_flat & (last * np.sqrt(self.values.shape[1]) <= rounding)
        missing = last * decay * factor / (1.0 - factor)
        # An order is two waves, the positive and the negative one. Each of them is missing from the
        # sum, and the samples wrongly add it to a lower order.
        return np.where(is_noise, 0.0, 4.0 * missing)

    def summed(self, positions: Array) -> Array:
        """Return all functions at a few positions `(N,)` by summing the series, `(C, N)`."""
        coefficients = self._coefficients()
        angle = 2.0 * np.pi * self.domain.phase(positions)
        orders = np.arange(coefficients.shape[1])
        waves = np.exp(1j * np.multiply.outer(orders, angle))
        weights = np.full(len(orders), 2.0)
        # The lowest and the highest order have one wave instead of two.
        weights[[0, -1]] = 1.0
        return np.asarray(((coefficients * weights) @ waves).real)

    def uniform(self, rows: Array, count: int) -> Array:
        """Return functions at `origin + period k / count`, `(len(rows), count)`, by FFT.

        Args:
            rows: indices of the functions.
            count: number of equal steps of the period.
        """
        return _on_grid(self.values[rows], count)

    def locate(self, positions: Array) -> Location:
        """Return where positions of any shape lie in the tables."""
        step = self.domain.phase(positions.ravel()) * self._table_size()
        left = np.floor(step).astype(np.intp)
        return Location(positions.shape, left, _lagrange_weights(step - left))

    def at(self, rows: Array, location: Location) -> Array:
        """Return functions at located positions, `(len(rows), *shape)`."""
        count = location.left.size
        result = np.empty((len(rows), count))
        tables = [self._table(int(row)) for row in rows]
        for chunk in blocks(count, LARGE_BLOCK):  # Whose weights stay in the cache.
            left = location.left[chunk]
            weights = [weight[chunk] for weight in location.weights]
            term = np.empty(len(left))
            for table, values in zip(tables, result, strict=True):
                total = values[chunk]
                # All indices lie in the table; NumPy clips them faster than it checks them.
                table.take(left, out=total, mode="clip")
                total *= weights[0]
                for offset in range(1, _DEGREE + 1):
                    table[offset:].take(left, out=term, mode="clip")
                    term *= weights[offset]
                    total += term
        return result.reshape(len(rows), *location.shape)

    def _coefficients(self) -> Array:
        """Return the complex Fourier coefficients `(C, K)` over a circle."""
        return np.asarray(np.fft.rfft(self.domain.on_circle(self.values), norm="forward"))

    def _table_size(self) -> int:
        """Number of table steps: a circle of samples, each divided further."""
        steps = self.domain.steps(self.values.shape[1])
        return _FINENESS * (steps if self.domain.periodic else 2 * steps)

    def _table(self, row: int) -> Array:
        """Return a function at equal steps of phase, with what interpolation reads beyond."""
        if row not in self._tables:
            table = _on_grid(self.domain.on_circle(self.values[[row]]), self._table_size())[0]
            before = _DEGREE // 2
            self._tables[row] = np.concatenate([table[-before:], table, table[: _DEGREE + 1]])
        return self._tables[row]


def _on_grid(samples: Array, count: int) -> Array:
    """Return functions at `count` equal steps of a period, from samples `(C, M)` at M of them."""
    size = samples.shape[1]
    spectrum = np.fft.rfft(samples)
    if count % 2 == 0 and size % 4 == 0 and _repeats_in_half(spectrum):
        once = _on_grid(samples[:, : size // 2], count // 2)  # Half the work.
        return np.concatenate([once, once], axis=1)
    if count < size:
        # A coarser grid cannot tell the higher orders from lower ones, so that they cannot be cut
        # off by a shorter transform.
        factor = -(-size // count)
        return _on_grid(samples, factor * count)[:, ::factor]
    if count > size and size % 2 == 0:
        # The highest order of an even number of samples stands for a positive and a negative wave.
        # On a finer grid these are two, of which the spectrum holds one: half of it.
        spectrum[:, -1] *= 0.5
    # Several transforms that fit the cache, whose positions alternate.
    grids = 1
    while count % (2 * grids) == 0 and count // (2 * grids) >= max(size, 2 * LARGE_BLOCK):
        grids *= 2
    result = np.empty((len(spectrum), count))
    orders = np.arange(spectrum.shape[1])
    scaled = spectrum * (count / (size * grids))
    for grid in range(grids):
        # Each grid begins one position later than the one before.
        shifted = scaled * np.exp(2j * np.pi * grid / count * orders)
        result[:, grid::grids] = np.fft.irfft(shifted, count // grids)
    return result


def _repeats_in_half(spectrum: Array) -> bool:
    """Return whether all functions are the same in both halves of a period.

    Most wrenches of a Cardan joint are: it turns over after half a turn.
    """
    sizes = np.abs(spectrum)
    # A transform makes some eps for each of its halvings.
    rounding = 2.0 * EPS * math.log2(2 * spectrum.shape[1]) * np.max(sizes)
    return bool(np.all(np.sum(sizes[:, 1::2], axis=1) <= rounding))


def _lagrange_weights(t: Array) -> list[Array]:
    """Return Lagrange weights of the nodes 0 … 7 at 3 + t, 0 ≤ t < 1."""
    position = t + _DEGREE // 2
    distances = [position - node for node in range(_DEGREE + 1)]
    # Products of the distances from all nodes before, and after, each node.
    before = [*accumulate(distances[:-1], np.multiply, initial=np.ones_like(t))]
    after = [*accumulate(distances[:0:-1], np.multiply, initial=np.ones_like(t))][::-1]
    # Products of the distances of each node from all others.
    denominators = [
        math.factorial(node) * math.factorial(_DEGREE - node) * (-1) ** (_DEGREE - node)
        for node in range(_DEGREE + 1)
    ]
    return [
        first * second / denominator
        for first, second, denominator in zip(before, after, denominators, strict=True)
    ]
