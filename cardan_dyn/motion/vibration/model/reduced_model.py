"""Reduced model: the efforts of the free coordinates as interpolated functions.

Terms of the efforts are trigonometric in the position of the drive and polynomial in the free
coordinates within a range, so that their derivatives are those of polynomials.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....kit.arrays import Array
from ....kit.periodic import nodes, resampled
from .efforts import Terms
from .polynomials import Polynomials

_NUMBERS = 500_000
"""Numbers of polynomials and their gradients that are computed at a time: they fit in a cache."""


class Course(NamedTuple):
    """Motions of n free coordinates at N nodes of one period, of S speeds.

    Attributes:
        q: `(S, N, n)` positions [rad or m].
        rate, bend: first and second derivatives by the drive's position, `(S, N, n)`.
        speed: `(S,)` of the drive [rad/s].
    """

    q: Array
    rate: Array
    bend: Array
    speed: Array

    @property
    def velocities(self) -> Array:
        """Speeds w `(S, N, 1 + n)` of drive and free coordinates."""
        drive = np.broadcast_to(self.speed[:, None, None], (*self.q.shape[:2], 1))
        return np.concatenate([drive, self.speed[:, None, None] * self.rate], axis=2)

    @property
    def accelerations(self) -> Array:
        """Accelerations `(S, N, n)` of the free coordinates."""
        return np.asarray(self.speed[:, None, None] ** 2 * self.bend)


class LocalEquation(NamedTuple):
    """Efforts along motions, and what small changes of these add to them.

    Attributes:
        efforts: `(S, N, n)`.
        scale: `(S, n)` greatest sum of the sizes of their terms.
        mass, damping, stiffness: `(S, N, n, n)` derivatives of the efforts by accelerations, speeds
            and positions of the free coordinates.
        slope: `(S, N, n)` derivatives of the efforts by the drive's speed, the course kept.
    """

    efforts: Array
    scale: Array
    mass: Array
    damping: Array
    stiffness: Array
    slope: Array


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """Interpolated terms of the efforts.

    Attributes:
        free: n, number of free coordinates.
        period: of the terms in the drive's position [rad], a divisor of the mechanism's.
        divisor: how many of them the mechanism's period holds.
        centre: middle of the ranges of the free coordinates at the nodes of one period `(N, n)`.
        half: half width of the ranges `(n,)`.
        basis: polynomials of the free coordinates, in units of `half` about `centre`.
        coefficients: `(N, P, F)` of all terms at the nodes of one period.
        error: greatest difference from terms at positions between the nodes, as a fraction of the
            greatest term of its kind.
    """

    free: int
    period: float
    divisor: int
    centre: Array
    half: Array
    basis: Polynomials
    coefficients: Array
    error: float

    @property
    def count(self) -> int:
        """Number of nodes of one period."""
        return len(self.coefficients)

    @property
    def positions(self) -> Array:
        """Positions of the drive at the nodes `(N,)` [rad]."""
        return nodes(self.count, self.period)

    def on(self, count: int) -> ReducedModel:
        """Return the same on another number of nodes, not less; what was made once is kept."""
        if count == self.count:
            return self
        if count not in self._others:
            coefficients, centre = (
                resampled(item, count) for item in (self.coefficients, self.centre)
            )
            self._others[count] = replace(self, coefficients=coefficients, centre=centre)
        return self._others[count]

    @cached_property
    def _others(self) -> dict[int, ReducedModel]:
        """The same on other numbers of nodes."""
        return {}

    @cached_property
    def _packed(self) -> _Packed:
        return _Packed(Terms.of_flat(self.coefficients, self.free))

    def _inside(self, q: Array) -> Array:
        """Return places in the range `(N, S, n)` of free coordinates `(S, N, n)`."""
        return np.swapaxes((q - self.centre) / self.half, 0, 1)

    def equation(self, course: Course) -> LocalEquation:
        """Return efforts and their derivatives along motions at the nodes."""
        each = max(1, _NUMBERS // (self.count * self.coefficients.shape[1] * (1 + self.free)))
        size = len(course.speed)
        if size > each:
            chunks = [
                self.equation(Course(*(item[first : first + each] for item in course)))
                for first in range(0, size, each)
            ]
            return LocalEquation(*(np.concatenate(items) for items in zip(*chunks, strict=True)))
        packed = self._packed
        values, gradients = self.basis.with_gradients(self._inside(course.q))
        terms, w = packed.terms(values), course.velocities.transpose(1, 2, 0)
        weights = packed.weights(w, course.accelerations.transpose(1, 2, 0))
        parts = packed.parts(terms, weights)
        # Inertia goes with the square of the speed, dampers go with it.
        slope = (2.0 * (parts[0] + parts[1]) + parts[2]) / course.speed
        stiffness = packed.stiffness(weights, gradients) / self.half[:, None]
        found = (
            np.sum(parts, axis=0),
            np.max(np.sum(np.abs(parts), axis=0), axis=0),
            packed.mass(terms),
            packed.damping(terms, w),
            stiffness,
            slope,
        )
        return LocalEquation(*map(_by_motions, found))

    def efforts(self, course: Course) -> Array:
        """Return the efforts `(S, N, n)` along motions at the nodes."""
        packed, values = self._packed, self.basis.values(self._inside(course.q))
        moves = (item.transpose(1, 2, 0) for item in (course.velocities, course.accelerations))
        parts = packed.parts(packed.terms(values), packed.weights(*moves))
        return _by_motions(np.sum(parts, axis=0))


def _by_motions(values: Array) -> Array:
    """Return values whose last axis is that of motions with this axis first."""
    return np.ascontiguousarray(values.transpose(-1, *range(values.ndim - 1)))


class _Packed:
    """Coefficients of the terms, each once, and those alone that do not vanish.

    A term belongs to one of G weights: accelerations, products of two speeds, speeds, 1. Motions
    are in the last axis.
    """

    def __init__(self, terms: Terms) -> None:
        """Take coefficients, arrays `(N, P, …)`."""
        free = terms.static.shape[-1]
        self._first, self._second = np.triu_indices(1 + free)
        double = np.where(self._first == self._second, 1.0, 2.0)
        every = [
            terms.mass,
            double * terms.quadratic[..., self._first, self._second],
            terms.linear,
            terms.static[..., None],
        ]
        ends = np.cumsum([0, *(item.shape[-1] for item in every)])
        columns = np.concatenate(every, axis=-1)
        is_kept = np.any(columns != 0.0, axis=(0, 1, 2))
        is_kept[ends[:-1]] = True  # So that there are terms of each kind.
        self._kept = np.nonzero(is_kept)[0]
        self._starts = np.searchsorted(self._kept, ends[:-1])
        self._masses = self._kept[: self._starts[1]]
        # (N, G, n, P)
        self._columns = np.ascontiguousarray(columns[..., self._kept].transpose(0, 3, 2, 1))
        # By how much speeds of free coordinates change weights, per unit of these speeds and of 1.
        slopes = np.zeros((int(ends[-1]), free, 2 + free))
        for pair, (i, j) in enumerate(zip(self._first, self._second, strict=True), int(ends[1])):
            for one, other in ((i, j), (j, i)):
                if one > 0:
                    slopes[pair, one - 1, other] += 1.0
        slopes[ends[2] + 1 : ends[3], :, -1] = np.eye(free)
        slopes = slopes[self._kept[self._starts[1] : self._starts[3]]]
        self._slopes = slopes.reshape(-1, 2 + free)

    def terms(self, values: Array) -> Array:
        """Return terms `(N, G, n, S)` from polynomials `(P, N, S)`."""
        count, size, free, _ = self._columns.shape
        flat = self._columns.reshape(count, size * free, -1)
        return (flat @ np.swapaxes(values, 0, 1)).reshape(count, size, free, -1)

    def weights(self, w: Array, acceleration: Array) -> Array:
        """Return weights `(N, G, S)` of speeds `(N, 1 + n, S)` and accelerations `(N, n, S)`."""
        squares = w[:, self._first] * w[:, self._second]
        every = [acceleration, squares, w, np.ones((len(w), 1, w.shape[2]))]
        return np.concatenate(every, axis=1)[:, self._kept]

    def parts(self, terms: Array, weights: Array) -> Array:
        """Return what inertia, by accelerations and by speeds, dampers and springs add.

        Returns:
            `(4, N, n, S)`.
        """
        added = np.add.reduceat(terms * weights[:, :, None], self._starts, axis=1)
        return np.swapaxes(added, 0, 1)

    def mass(self, terms: Array) -> Array:
        """Return derivatives `(N, n, n, S)` by accelerations."""
        count, _, free, size = terms.shape
        result = np.zeros((count, free, free, size))
        result[:, :, self._masses] = np.swapaxes(terms[:, : len(self._masses)], 1, 2)
        return result

    def damping(self, terms: Array, w: Array) -> Array:
        """Return derivatives `(N, n, n, S)` by speeds of the free coordinates."""
        count, _, free, size = terms.shape
        known = np.concatenate([w, np.ones((count, 1, size))], axis=1)
        slopes = (self._slopes @ known).reshape(count, -1, free, size)
        moved = terms[:, self._starts[1] : self._starts[3]]
        return np.einsum("ngis,ngjs->nijs", moved, slopes)

    def stiffness(self, weights: Array, gradients: Array) -> Array:
        """Return derivatives `(N, n, n, S)` by positions, from gradients `(n, P, N, S)`."""
        count, size, free, powers = self._columns.shape
        mixed = np.swapaxes(weights, 1, 2) @ self._columns.reshape(count, size, free * powers)
        # Copied into the order of the other factor: products of matrices as they lie are faster.
        slopes = np.ascontiguousarray(gradients.transpose(2, 3, 0, 1))
        each = mixed.reshape(count, -1, free, powers) @ np.swapaxes(slopes, 2, 3)
        return each.transpose(0, 2, 3, 1)
