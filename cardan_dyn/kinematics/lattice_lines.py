"""Lattice lines: ways from the start to points of a lattice, from lattice point to lattice point.

Together they pass far more points than there are, so they are never all in memory: what has to be
known of each of them is found some lines at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array

_MOST_PASSED = 100_000
"""Points that the lines pass which are worked on at a time."""


class _Ways(NamedTuple):
    """Lines of L points, each as far as its end.

    Attributes:
        ends: `(L, d)` lattice points at which they end, in units of the spacing; the start is 0.
        lengths: `(L, k)` steps of each leg.
        legs: sets of drives that move one after the other.
        low: `(d,)` least coordinates of a point.
        factors: `(d,)` by which coordinates are multiplied in its key.
    """

    ends: Array
    lengths: Array
    legs: Sequence[list[int]]
    low: Array
    factors: Array

    @property
    def counts(self) -> Array:
        """Points on each line `(L,)`, both ends included; two where it leads nowhere."""
        return np.asarray(np.maximum(np.sum(self.lengths, axis=1), 1) + 1)

    def pieces(self) -> Iterator[slice]:
        """Yield lines that are worked on at a time."""
        of_piece = np.cumsum(self.counts) // _MOST_PASSED
        ends = np.nonzero(np.diff(of_piece, append=of_piece[-1:] + 1))[0] + 1
        begin = 0
        for end in ends.tolist():
            yield slice(begin, end)
            begin = end

    def passed(self, lines: slice) -> tuple[Array, Array]:
        """Return the keys `(K,)` of all points on lines, and where in them each line begins."""
        ends, lengths, counts = self.ends[lines], self.lengths[lines], self.counts[lines]
        begins = np.cumsum(counts) - counts
        line_of = np.repeat(np.arange(len(ends)), counts)
        count = np.arange(len(line_of)) - begins[line_of]
        on_lines = np.zeros((len(line_of), ends.shape[1]))
        for leg, length in zip(self.legs, lengths.T, strict=True):
            done = np.minimum(count, length[line_of])
            share = done / np.maximum(length, 1)[line_of]
            on_lines[:, leg] = np.rint(ends[line_of][:, leg] * share[:, None])
            count = count - done
        return _keys(on_lines, self.low, self.factors), begins

    def steps(self, keys: Array, lines: slice) -> tuple[Array, Array]:
        """Return the numbers `(S,)` of the steps of lines, and where in them each line begins.

        Args:
            keys: ascending, of all points on any line.
            lines: which.
        """
        passed, begins = self.passed(lines)
        point_of = np.searchsorted(keys, passed)
        is_first = np.zeros(len(passed), dtype=bool)
        is_first[begins] = True
        to = np.nonzero(~is_first)[0]
        return point_of[to - 1] * len(keys) + point_of[to], begins - np.arange(len(begins))


class LatticeLines(NamedTuple):
    """Lines from the start to lattice points.

    Attributes:
        points: `(M, d)` lattice points on any of them, in units of the spacing; the start is 0.
        first, second: `(E,)` points (indices) that a step leads between.
        ends: `(L,)` points (indices) at which the lines end.
        ways: their points.
        keys: `(M,)` of the points, ascending.
    """

    points: Array
    first: Array
    second: Array
    ends: Array
    ways: _Ways
    keys: Array

    def lead_there(self, is_good: Array) -> Array:
        """Return `(L,)` on which lines all steps are good, of which `(E,)` are."""
        numbers = self.first * len(self.keys) + self.second
        found = [
            np.logical_and.reduceat(is_good[np.searchsorted(numbers, steps)], begins)
            for steps, begins in (self.ways.steps(self.keys, k) for k in self.ways.pieces())
        ]
        return np.concatenate([np.zeros(0, dtype=bool), *found])


def lines_to(nearest: Array, legs: Sequence[list[int]]) -> tuple[LatticeLines, Array]:
    """Return lines to lattice points `(N, d)`, and `(N,)` the line (index) that leads to each.

    Args:
        nearest: the points.
        legs: sets of drives that move one after the other.
    """
    low, factors = _box(nearest)
    _, chosen, end_of = np.unique(
        _keys(nearest, low, factors), return_index=True, return_inverse=True
    )
    ends = nearest[chosen]
    lengths = np.stack([np.max(np.abs(ends[:, leg]), axis=1) for leg in legs], axis=1).astype(int)
    ways = _Ways(ends, lengths, legs, low, factors)
    keys = _united([ways.passed(lines)[0] for lines in ways.pieces()])
    numbers = _united([ways.steps(keys, lines)[0] for lines in ways.pieces()])
    return LatticeLines(
        points=_points(keys, low, factors),
        first=numbers // len(keys),
        second=numbers % len(keys),
        ends=np.searchsorted(keys, _keys(ends, low, factors)),
        ways=ways,
        keys=keys,
    ), end_of


def count_of(nearest: Array) -> int:
    """Return how many different lattice points there are among `(N, d)`."""
    return len(np.unique(_keys(nearest, *_box(nearest))))


def _united(sets: Sequence[Array]) -> Array:
    """Return the different ones of whole numbers, ascending."""
    return np.unique(np.concatenate([np.zeros(0, dtype=int), *map(np.unique, sets)]))


def _box(points: Array) -> tuple[Array, Array]:
    """Return the least coordinates of points `(N, d)` and the start, and factors of their keys."""
    low = np.min(points, axis=0, initial=0.0)
    spans = np.max(points, axis=0, initial=0.0) - low + 1.0
    return low, np.concatenate([[1.0], np.cumprod(spans[:-1])]).astype(np.int64)


def _keys(points: Array, low: Array, factors: Array) -> Array:
    """Return a whole number `(N,)` for each lattice point `(N, d)`, by its coordinates."""
    keys = np.zeros(len(points), dtype=np.int64)
    for column, least, factor in zip(points.T, low, factors, strict=True):
        keys += (column - least).astype(np.int64) * factor
    return keys


def _points(keys: Array, low: Array, factors: Array) -> Array:
    """Return the lattice points `(M, d)` of keys, see `_keys`."""
    points = np.empty((len(keys), len(low)))
    for column in range(len(low) - 1, -1, -1):
        points[:, column], keys = keys // factors[column] + low[column], keys % factors[column]
    return points
