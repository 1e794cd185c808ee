"""Panels: how great functions of one variable become between the positions at which they are known.

A range is cut into panels. On each of them every function is a polynomial through its values at
Chebyshev points, and how far that is off is measured: by its last coefficients, and at whatever
else is known within. Panels that may hold something greater than what is known are halved until
they do not, or until what is left is rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from ...kit.arrays import BLOCK_SIZE, NOTHING, Array, blocks
from ...kit.extremes import greatest as greatest_of_period

DEGREE = 8
"""Of the polynomials."""
MOST = 60_000
"""Positions that are asked for at most."""
_NODES = np.cos(np.pi * np.arange(DEGREE, -1, -1) / DEGREE)
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, DEGREE))


class Known(NamedTuple):
    """Functions where they are known.

    Attributes:
        at: `(N,)` positions, in any order.
        values: `(N, F)` functions there.
    """

    at: Array
    values: Array


class Tolerance(NamedTuple):
    """What does not count.

    Attributes:
        enough: `(F,)` error of a function that suffices.
        rounding: `(F,)` of its values; where it is a square, of their roots.
        squared: `(F,)` which are squares, up to their sign.
    """

    enough: Array
    rounding: Array
    squared: Array

    def of(self, size: Array) -> Array:
        """Return what does not count `(..., F)` where functions have these sizes."""
        rounding = self.rounding * np.where(self.squared, 2.0 * np.sqrt(size), 1.0)
        return np.asarray(np.maximum(self.enough, rounding))


class _Panels(NamedTuple):
    """Parts of the range.

    Attributes:
        ends: `(P, 2)` of each.
        values: `(P, 9, F)` at its Chebyshev points.
        top: `(P, F)` greatest values of the polynomials through them.
        at: `(P, F)` where these are.
        error: `(P, F)` measured.
        small: `(P, F)` errors that do not count.
        asked: `(P, F)` whether the function is known at `at`.
    """

    ends: Array
    values: Array
    top: Array
    at: Array
    error: Array
    small: Array
    asked: Array

    def only(self, which: Array) -> _Panels:
        """Return some of them."""
        return _Panels(*(part[which] for part in self))

    @classmethod
    def joined(cls, several: list[_Panels]) -> _Panels:
        """Return all of several."""
        return cls(*map(np.concatenate, zip(*several, strict=True)))


def greatest(
    ask: Callable[[Array], Array],
    ends: tuple[float, float],
    count: int,
    known: Known,
    tolerance: Tolerance,
) -> tuple[Known, Array]:
    """Return functions wherever they were asked for, and by how much they may exceed all of that.

    Args:
        ask: returns `(N, F)` functions at positions `(N,)`.
        ends: of the range.
        count: of panels to begin with.
        known: what is known beforehand.
        tolerance: what does not count.

    Returns:
        All that is known; `(F,)` measured errors of the greatest values of that.
    """
    edges, given = np.linspace(*ends, count + 1), len(known.at)
    # Functions that jump within so little have come as close to the jump on both sides.
    least = NOTHING * (ends[1] - ends[0])
    cut = np.stack([edges[:-1], edges[1:]], axis=1)
    before = np.full((count, known.values.shape[1]), -np.inf)
    settled: list[_Panels] = []
    while True:
        places = cut.mean(axis=1)[:, None] + 0.5 * np.ptp(cut, axis=1)[:, None] * _NODES
        places[:, 0], places[:, -1] = cut.T
        known, values = _asked(ask, known, places)
        parts = blocks(len(cut), BLOCK_SIZE // DEGREE)
        new = [_fitted(cut[part], values[part], known, tolerance) for part in parts]
        panels = _Panels.joined([*settled, *new])
        wide = np.ptp(panels.ends, axis=1) > least
        if not np.ptp(cut[0]) > least:
            # What is closed counts by its values alone. By how much they exceed those of the panel
            # twice as wide is their error: next to nothing beside a jump, as much as they are where
            # functions grow without limit.
            top = values.max(axis=1)
            panels.top[-len(cut) :], panels.error[-len(cut) :] = top, np.maximum(top - before, 0.0)
        while True:
            best = known.values.max(axis=0)
            reach = panels.top + panels.error
            exceeds = reach > best + tolerance.of(np.abs(best))
            split = np.any(exceeds & (panels.error > panels.small), axis=1) & wide
            varies = np.ptp(known.values, axis=0) > tolerance.of(np.abs(best))
            peaks = (reach > best - panels.small) & ~panels.asked & wide[:, None] & varies
            if split.any() or not peaks.any() or len(known.at) - given > MOST:
                break
            rows, columns = np.nonzero(peaks)
            known, there = _asked(ask, known, panels.at[peaks])
            missed = np.abs(there[np.arange(len(rows)), columns] - panels.top[peaks])
            panels.error[peaks] = np.maximum(panels.error[peaks], missed)
            panels.asked[peaks] = True
        if not split.any() or len(known.at) - given > MOST:
            return known, np.maximum(np.max(reach, axis=0) - best, 0.0)
        halved, settled = panels.only(split), [panels.only(~split)]
        low, high, middle = *halved.ends.T, halved.ends.mean(axis=1)
        cut = np.concatenate([np.stack([low, middle], 1), np.stack([middle, high], 1)])
        before = np.tile(halved.values.max(axis=1), (2, 1))


def _asked(ask: Callable[[Array], Array], known: Known, at: Array) -> tuple[Known, Array]:
    """Return what is known now, and functions `(..., F)` at positions of any shape."""
    distinct, back = np.unique(at, return_inverse=True)
    values = ask(distinct)
    more = Known(np.concatenate([known.at, distinct]), np.concatenate([known.values, values]))
    return more, values[back.reshape(at.shape)]


def _fitted(ends: Array, values: Array, known: Known, tolerance: Tolerance) -> _Panels:
    """Return panels with polynomials through values `(P, 9, F)`."""
    coefficients = np.einsum("ij,pjf->ipf", _TO_COEFFICIENTS, values)
    error = 2.0 * np.abs(coefficients[-2:]).max(axis=0)
    middle, half = ends.mean(axis=1), 0.5 * np.ptp(ends, axis=1)
    for row, (low, high) in enumerate(ends):
        inside = (known.at > low) & (known.at < high)
        powers = chebyshev.chebvander((known.at[inside] - middle[row]) / half[row], DEGREE)
        missed = np.abs(powers @ coefficients[:, row] - known.values[inside])
        error[row] = np.maximum(error[row], missed.max(axis=0, initial=0.0))
    # Over Chebyshev's circle they are periodic, the same on both of its halves.
    circle = np.concatenate([values, values[:, -2:0:-1]], axis=1)
    found = greatest_of_period(np.moveaxis(circle, 1, 0).reshape(2 * DEGREE, -1))
    top, turn = (item.reshape(error.shape) for item in found)
    at = middle[:, None] - half[:, None] * np.cos(2.0 * np.pi * turn)
    return _Panels(
        ends,
        values,
        top,
        np.clip(at, ends[:, :1], ends[:, 1:]),
        error,
        tolerance.of(np.abs(values).max(axis=1)),
        np.zeros(error.shape, dtype=bool),
    )
