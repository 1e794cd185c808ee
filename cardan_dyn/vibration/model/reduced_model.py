"""Reduced model: the efforts of the free coordinates as interpolated functions.

Terms of the efforts are trigonometric in the position of the drive and polynomial in the free
coordinates within a range, so that their derivatives are those of polynomials.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from .efforts import Terms
from .periodic_grid import nodes, resampled
from .polynomials import Polynomials


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
        """Return the same on another number of nodes, not less."""
        coefficients, centre = (resampled(item, count) for item in (self.coefficients, self.centre))
        return replace(self, coefficients=coefficients, centre=centre)

    def terms(self, q: Array) -> Terms:
        """Return the terms at nodes, of free coordinates `(S, N, n)`; arrays `(S, N, …)`."""
        return self._terms(self.basis.values(self._inside(q)))

    def _inside(self, q: Array) -> Array:
        """Return places in the range `(N, S, n)` of free coordinates `(S, N, n)`."""
        return np.swapaxes((q - self.centre) / self.half, 0, 1)

    @cached_property
    def _columns(self) -> tuple[Array, Array]:
        """Coefficients `(N, K, P)` of the terms that differ, and which of them each term is.

        Many terms vanish, and mixed ones are there twice.
        """
        flat = self.coefficients.reshape(-1, self.coefficients.shape[-1])
        _, first, inverse = np.unique(flat, axis=1, return_index=True, return_inverse=True)
        return np.ascontiguousarray(np.swapaxes(self.coefficients[..., first], 1, 2)), inverse

    def _terms(self, values: Array) -> Terms:
        """Return terms `(S, N, …)` from polynomials or their gradients `(P, N, S)`."""
        coefficients, inverse = self._columns
        found = np.moveaxis(coefficients @ np.swapaxes(values, 0, 1), 2, 0)
        return Terms.of_flat(found[..., inverse], self.free)

    def equation(self, course: Course) -> LocalEquation:
        """Return efforts and their derivatives along motions at the nodes."""
        values, gradients = self.basis.with_gradients(self._inside(course.q))
        w, acceleration = course.velocities, course.accelerations
        terms = self._terms(values)
        spun = np.einsum("...ijk,...k->...ij", terms.quadratic, w)
        parts = _parts(terms, w, acceleration)
        scale = np.max(sum(np.abs(part) for part in parts), axis=-2)
        stiffness = np.empty(terms.mass.shape)
        for index in range(self.free):
            rates = self._terms(gradients[index] / self.half[index])
            stiffness[..., index] = sum(_parts(rates, w, acceleration))
        damping = 2.0 * spun[..., 1:] + terms.linear[..., 1:]
        # Inertia goes with the square of the speed, dampers go with it.
        pace = course.speed[:, None, None]
        slope = (2.0 * (parts[0] + parts[1]) + parts[2]) / pace
        return LocalEquation(
            np.asarray(sum(parts)), np.asarray(scale), terms.mass, damping, stiffness, slope
        )

    def efforts(self, course: Course) -> Array:
        """Return the efforts `(S, N, n)` along motions at the nodes."""
        parts = _parts(self.terms(course.q), course.velocities, course.accelerations)
        return np.asarray(sum(parts))


def _parts(terms: Terms, w: Array, acceleration: Array) -> tuple[Array, Array, Array, Array]:
    """Return what inertia, by accelerations and by speeds, dampers and springs add `(S, N, n)`."""
    return (
        np.einsum("...ij,...j->...i", terms.mass, acceleration),
        np.einsum("...ijk,...j,...k->...i", terms.quadratic, w, w, optimize=True),
        np.einsum("...ij,...j->...i", terms.linear, w),
        terms.static,
    )
