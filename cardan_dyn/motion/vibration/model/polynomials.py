"""Polynomials: interpolation of functions of several coordinates in Chebyshev polynomials.

Products of Chebyshev polynomials, at as many points: of one coordinate the Chebyshev nodes; of
several, points whose coordinates are those of a Leja sequence, numbered like the degrees of the
products. They need no search, and interpolate uniquely whichever degrees there are, as long as
none of the products of lower degrees is left out.

Source: Chkifa, Cohen and Schwab, High-dimensional adaptive sparse polynomial interpolation and
applications to parametric PDEs, Foundations of Computational Mathematics 14 (2014).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ....kit.arrays import Array

_CANDIDATES = 4
"""Places, per point of a Leja sequence, among which it is chosen."""
_USUAL = 128
"""Points up to which sequences of one length begin like those of others."""


class Polynomials:
    """Products of Chebyshev polynomials of n coordinates in [-1, 1].

    With degrees d_i, products of polynomials of degrees p_i with Σ p_i / d_i ≤ 1.

    Attributes:
        degrees: d `(n,)`, the greatest degree in each coordinate.
        powers: `(P, n)` degree of each factor; `names` has them as tuples.
        nodes: `(P, n)` points at which functions are interpolated.
    """

    def __init__(self, degrees: tuple[int, ...]) -> None:
        """Choose the points.

        Args:
            degrees: see the attribute; at least 1.
        """
        self.degrees = degrees
        self.names = _powers(degrees)
        self.powers = np.array(self.names)
        self.nodes = self._chosen()
        self._inverse = np.linalg.inv(self.values(self.nodes).T)

    def _chosen(self) -> Array:
        count = len(self.degrees)
        if count == 1:
            size = self.degrees[0] + 1
            return np.cos(np.pi * (np.arange(size) + 0.5) / size)[:, None]
        columns = [
            _leja(degree)[powers]
            for degree, powers in zip(self.degrees, self.powers.T, strict=True)
        ]
        return np.stack(columns, axis=1)

    def coefficients(self, values: Array) -> Array:
        """Return coefficients `(..., P, F)` of functions from their values there at the nodes."""
        return np.asarray(self._inverse @ values)

    def values(self, points: Array) -> Array:
        """Return all polynomials `(P, ...)` at points `(..., n)`."""
        (factors,) = self._chebyshev(points, kinds=1)
        result = factors[0][self.powers[:, 0]]
        for factor, powers in zip(factors[1:], self.powers.T[1:], strict=True):
            result *= factor[powers]
        return np.asarray(result)

    def with_gradients(self, points: Array) -> tuple[Array, Array]:
        """Return all polynomials `(P, ...)` at points `(..., n)`, and gradients `(n, P, ...)`."""
        factors, seconds = self._chebyshev(points, kinds=2)
        # The derivative of degree p of the first kind is p times degree p - 1 of the second.
        degrees = np.arange(1.0, factors.shape[1]).reshape(-1, *[1] * (points.ndim - 1))
        slopes = np.zeros_like(factors)
        np.multiply(degrees, seconds[:, :-1], out=slopes[:, 1:])
        shape = len(self.powers), *points.shape[:-1]
        gradients = np.empty((len(factors), *shape), dtype=points.dtype)
        values = np.ones(shape, dtype=points.dtype)
        # Forwards what comes before a factor, backwards what comes after it.
        for gradient, factor, powers in zip(gradients, factors, self.powers.T, strict=True):
            gradient[:] = values
            values *= factor[powers]
        behind: Array | float = 1.0
        for index in reversed(range(len(factors))):
            powers = self.powers[:, index]
            gradients[index] *= slopes[index][powers]
            gradients[index] *= behind
            behind = factors[index][powers] * behind if index else behind
        return values, gradients

    def _chebyshev(self, points: Array, kinds: int) -> Array:
        """Return Chebyshev polynomials `(kinds, n, d + 1, ...)` of each coordinate.

        Those of the first kind, and of the second one, up to d, the greatest degree of all.
        """
        x = np.moveaxis(points, -1, 0)
        found = np.ones((max(self.degrees) + 1, kinds, *x.shape), dtype=x.dtype)
        for kind in range(kinds):
            np.multiply(1.0 + kind, x, out=found[1, kind])
        twice = np.ascontiguousarray(2.0 * x)
        for power in range(2, len(found)):
            np.multiply(twice, found[power - 1], out=found[power])
            found[power] -= found[power - 2]
        return np.moveaxis(found, 0, 2)


@lru_cache(maxsize=64)
def _leja(degree: int) -> Array:
    """Return points `(d + 1,)` of which each is as far from those before it as can be.

    That is by the product of its distances, among places as dense towards ±1 as Chebyshev's.
    """
    # The same places for all usual degrees, so that sequences go on like shorter ones.
    size = _CANDIDATES * max(_USUAL, degree + 1)
    places = np.cos(np.pi / size * np.arange(size + 1))
    found = [1.0, -1.0, 0.0]
    distance = np.abs(places * (places**2 - 1.0))
    while len(found) <= degree:
        found.append(float(places[np.argmax(distance)]))
        distance *= np.abs(places - found[-1])
    return np.array(found[: degree + 1])


def _powers(degrees: tuple[int, ...], room: float = 1.0 + 1e-9) -> list[tuple[int, ...]]:
    """Return the degrees of all products whose shares of the greatest degrees fit in a room."""
    if not degrees:
        return [()]
    first, rest = degrees[0], degrees[1:]
    return [
        (power, *others)
        for power in range(int(room * first) + 1)
        for others in _powers(rest, room - power / first)
    ]


def size_of(degrees: tuple[int, ...]) -> int:
    """Return how many polynomials there are of given degrees."""
    return len(_powers(degrees))


@lru_cache(maxsize=64)
def polynomials(degrees: tuple[int, ...]) -> Polynomials:
    """Return the polynomials of given degrees, whose points are chosen once."""
    return Polynomials(degrees)
