"""Series: many functions of one variable, known to rounding from a few hundred samples.

A periodic function sampled at equal steps has Fourier coefficients that fall off geometrically,
one on a range sampled at Chebyshev points likewise. Once they reach rounding, the series gives the
function everywhere: on uniform grids by FFT, elsewhere by interpolation of low degree in a table
that was made by FFT and is fine enough for it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..frozen import read_only

_DEGREE = 7
_ROUNDING = 4e-15
_FLAT = 0.25
"""From eighth to eighth of the orders, noise falls off by less, its greatest coefficients being
what they are. What has fallen to rounding from where it began falls off by ten and more."""
_SHORT = 16384  # Longer transforms leave the cache.
_FINENESS = 32  # Table steps per sample: the interpolation's error stays below rounding.
_CHUNK = 8192  # Positions looked up at a time, so that their weights stay in the cache.


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
    """Functions on a period or on a range; their samples cannot be written to.

    Attributes:
        values: `(C, M)` samples of C functions: at `origin + period k / M`, or at the Chebyshev
            points `middle + half cos(π k / (M - 1))` of a range.
        origin: where a period starts; the middle of a range.
        length: the period; half the range.
        periodic: whether it is a period.
    """

    values: Array
    origin: float
    length: float
    periodic: bool
    _tables: dict[int, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        read_only(self.values)

    def __reduce__(self) -> tuple[object, ...]:
        # Without the tables, which are 32 times as large and soon made again.
        return Series, (self.values, self.origin, self.length, self.periodic)

    @staticmethod
    def nodes(origin: float, length: float, periodic: bool, count: int) -> Array:
        """Return the positions `(M,)` of samples; those of `count` are among those of its double.

        A range has one sample more than `count`.
        """
        if periodic:
            return origin + length * np.arange(count) / count
        # Sines of the distance from the middle keep the points symmetric.
        return origin + length * np.sin(0.5 * np.pi * (count - 2.0 * np.arange(count + 1)) / count)

    def spectrum(self) -> Array:
        """Return sizes `(C, K)` of the coefficients by order, lowest first."""
        return np.asarray(np.abs(np.fft.rfft(self._circle(self.values), norm="forward")))

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
        starts = [(highest * part) // 8 + 1 for part in range(8)]
        eighths = np.maximum.reduceat(spectrum, starts, axis=1)
        second, third, last = np.maximum(eighths[:, 2::2], eighths[:, 3::2]).T
        with np.errstate(divide="ignore", invalid="ignore"):
            # Of two ways to measure it the slower one, lest a dip passes for a fast decay.
            fall = np.fmax(last / third, np.sqrt(last / second))
        fall = np.clip(np.nan_to_num(fall, nan=0.0), 0.0, 1.0)
        # By order; if they hardly fall off, the rest is taken to be as long as the series.
        factor = np.minimum(fall ** (4.0 / highest), 1.0 - 1.0 / highest)
        flat = eighths[:, 7] >= _FLAT * np.maximum(eighths[:, 5], eighths[:, 6])
        noise = flat & (last * np.sqrt(self.values.shape[1]) <= rounding)
        # An order stands for its positive and its negative wave, and is missing where it belongs
        # as much as it is wrong where the samples mistake it for a lower one.
        return np.where(noise, 0.0, 4.0 * last * fall * factor / (1.0 - factor))

    def summed(self, positions: Array) -> Array:
        """Return all functions at a few positions `(N,)` by summing the series, `(C, N)`."""
        coefficients = np.fft.rfft(self._circle(self.values), norm="forward")
        angle = 2.0 * np.pi * self._phase(positions)
        orders = np.arange(coefficients.shape[1])
        waves = np.exp(1j * np.multiply.outer(orders, angle))
        weights = np.full(len(orders), 2.0)
        weights[[0, -1]] = 1.0
        return np.asarray(((coefficients * weights) @ waves).real)

    def uniform(self, rows: Array, count: int) -> Array:
        """Return functions at `origin + period k / count`, `(len(rows), count)`, by FFT."""
        size = self.values.shape[1]
        spectrum = np.fft.rfft(self.values[rows])
        odd = np.sum(np.abs(spectrum[:, 1::2]), axis=1)
        if count % 2 == 0 and size % 4 == 0 and np.all(odd <= _ROUNDING * np.max(np.abs(spectrum))):
            # Twice the same within a period, as most of a Cardan joint is: half the work.
            half = Series(self.values[rows, : size // 2], self.origin, 0.5 * self.length, True)
            once = half.uniform(np.arange(len(rows)), count // 2)
            return np.concatenate([once, once], axis=1)
        if count < size:
            # Orders that a coarser grid cannot tell apart: take them from a finer one.
            factor = -(-size // count)
            return self.uniform(rows, factor * count)[:, ::factor]
        if count > size and size % 2 == 0:
            spectrum[:, -1] *= 0.5  # The highest order stands for both signs.
        parts = 1
        while count % (2 * parts) == 0 and count // (2 * parts) >= max(size, _SHORT):
            parts *= 2
        # Interleaved grids of a length that fits the cache, each turned to its place.
        result = np.empty((len(rows), count))
        orders = np.arange(spectrum.shape[1])
        spectrum = spectrum * (count / (size * parts))
        for part in range(parts):
            shifted = spectrum * np.exp(2j * np.pi * part / count * orders)
            result[:, part::parts] = np.fft.irfft(shifted, count // parts)
        return result

    def locate(self, positions: Array) -> Location:
        """Return where positions of any shape lie in the tables."""
        step = self._phase(positions.ravel()) * self._table_size()
        left = np.floor(step).astype(np.intp)
        return Location(positions.shape, left, _weights(step - left))

    def at(self, rows: Array, where: Location) -> Array:
        """Return functions at located positions, `(len(rows), *shape)`."""
        count = where.left.size
        result = np.empty((len(rows), count))
        tables = [self._table(int(row)) for row in rows]
        for start in range(0, count, _CHUNK):
            chunk = slice(start, min(start + _CHUNK, count))
            left = where.left[chunk]
            weights = [weight[chunk] for weight in where.weights]
            part = np.empty(len(left))
            for table, row in zip(tables, result, strict=True):
                total = row[chunk]
                # All steps are in the table; clipping spares the check.
                np.take(table, left, out=total, mode="clip")
                total *= weights[0]
                for offset in range(1, _DEGREE + 1):
                    np.take(table[offset:], left, out=part, mode="clip")
                    part *= weights[offset]
                    total += part
        return result.reshape(len(rows), *where.shape)

    def _phase(self, positions: Array) -> Array:
        """Return `(N,)` how far round the circle of samples positions are, 0 … 1."""
        if self.periodic:
            return _reduced(positions, self.origin, self.length)
        # Near the ends of a range the arc cosine alone would lose half of the digits.
        x = np.clip((positions - self.origin) / self.length, -1.0, 1.0)
        return np.asarray(np.arctan2(np.sqrt((1.0 - x) * (1.0 + x)), x) / (2.0 * np.pi))

    def _circle(self, values: Array) -> Array:
        """Return samples over a whole turn: a range is walked forth and back."""
        if self.periodic:
            return values
        return np.concatenate([values, values[:, -2:0:-1]], axis=1)

    def _table_size(self) -> int:
        count = self.values.shape[1]
        return _FINENESS * (count if self.periodic else 2 * (count - 1))

    def _table(self, row: int) -> Array:
        """Return a function at equal steps of phase, with what interpolation reads beyond."""
        if row not in self._tables:
            circle = Series(self._circle(self.values[[row]]), 0.0, 1.0, True)
            table = circle.uniform(np.array([0]), self._table_size())[0]
            before = _DEGREE // 2
            self._tables[row] = np.concatenate([table[-before:], table, table[: _DEGREE + 1]])
        return self._tables[row]


def _reduced(positions: Array, origin: float, period: float) -> Array:
    """Return phases 0 … 1 of positions in a period of whole turns, to rounding at any size.

    Beyond a period its remainder would carry the rounding of the period times the number of
    turns; sine and cosine are reduced exactly.
    """
    offset = positions - origin
    count = round(period / (2.0 * np.pi))
    if np.max(np.abs(offset), initial=0.0) > period and count >= 1:
        angle = np.arctan2(np.sin(positions), np.cos(positions))
        turns = np.rint((positions - angle) / (2.0 * np.pi))
        offset = angle + 2.0 * np.pi * (turns - count * np.floor(turns / count)) - origin
    phase = offset / period
    phase -= np.floor(phase)
    return np.where(phase < 1.0, phase, 0.0)


def _weights(t: Array) -> list[Array]:
    """Return Lagrange weights of the nodes 0 … 7 at 3 + t, 0 ≤ t < 1."""
    nodes = np.arange(_DEGREE + 1)
    place = t + _DEGREE // 2
    scale = [float(np.prod([j - m for m in nodes if m != j])) for j in nodes]
    before = [np.ones_like(t)]
    for m in nodes[:-1]:
        before.append(before[-1] * (place - m))
    after = np.ones_like(t)
    weights: list[Array] = [after] * (_DEGREE + 1)
    for j in nodes[::-1]:
        weights[j] = before[j] * after / scale[j]
        after = after * (place - j)
    return weights
