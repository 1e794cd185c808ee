"""Polynomials: interpolation of functions of several coordinates in Chebyshev polynomials.

Products of Chebyshev polynomials, at as many points: of one coordinate the Chebyshev nodes; of
several, approximate Fekete points, which a pivoted QR factorisation of the
Vandermonde matrix chooses among candidates.

Source: Sommariva and Vianello, Computing approximate Fekete points by QR factorizations of
Vandermonde matrices, Computers & Mathematics with Applications 57 (2009).
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np

from ...arrays import Array

_MOST_CANDIDATES = 4000


class Polynomials:
    """Products of Chebyshev polynomials of n coordinates in [-1, 1].

    With degrees d_i, products of polynomials of degrees p_i with Σ p_i / d_i ≤ 1.

    Attributes:
        degrees: d `(n,)`, the greatest degree in each coordinate.
        powers: `(P, n)` degree of each factor.
        nodes: `(P, n)` points at which functions are interpolated.
    """

    def __init__(self, degrees: tuple[int, ...]) -> None:
        """Choose the points.

        Args:
            degrees: see the attribute; at least 1.
        """
        self.degrees = degrees
        self.powers = np.array(_powers(degrees))
        self.nodes = self._chosen()
        self._inverse = np.linalg.inv(self.values(self.nodes).T)

    def _chosen(self) -> Array:
        count = len(self.degrees)
        if count == 1:
            size = self.degrees[0] + 1
            return np.cos(np.pi * (np.arange(size) + 0.5) / size)[:, None]
        from scipy.linalg import qr  # Where one coordinate is free, nothing else needs it.

        grids = [np.cos(np.pi * np.arange(size + 2) / (size + 1)) for size in self.degrees]
        if np.prod([len(grid) for grid in grids]) <= _MOST_CANDIDATES:
            candidates = np.array(list(product(*grids)))
        else:
            # Without a pattern, denser towards the ends as Chebyshev nodes are.
            amount = max(4 * len(self.powers), _MOST_CANDIDATES // 4)
            roots = np.sqrt(np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37][:count]))
            candidates = np.cos(np.pi * (np.outer(np.arange(1, amount + 1), roots) % 1.0))
        _, _, order = qr(self.values(candidates), mode="economic", pivoting=True)
        return np.asarray(candidates[order[: len(self.powers)]])

    def coefficients(self, values: Array) -> Array:
        """Return coefficients `(..., P, F)` of functions from their values there at the nodes."""
        return np.asarray(self._inverse @ values)

    def values(self, points: Array) -> Array:
        """Return all polynomials `(P, ...)` at points `(..., n)`."""
        return self._product(self._factors(points, with_slopes=False)[0])

    def with_gradients(self, points: Array) -> tuple[Array, Array]:
        """Return all polynomials `(P, ...)` at points `(..., n)`, and gradients `(n, P, ...)`."""
        factors, slopes = self._factors(points)
        gradients = [
            self._product([*factors[:index], slopes[index], *factors[index + 1 :]])
            for index in range(len(factors))
        ]
        return self._product(factors), np.stack(gradients)

    def _product(self, factors: list[Array]) -> Array:
        """Return the products `(P, ...)` of rows of factors `(d + 1, ...)` of each coordinate."""
        result = factors[0][self.powers[:, 0]]
        for index, factor in enumerate(factors[1:], 1):
            result *= factor[self.powers[:, index]]
        return np.asarray(result)

    def _factors(
        self, points: Array, *, with_slopes: bool = True
    ) -> tuple[list[Array], list[Array]]:
        """Return Chebyshev polynomials `(d + 1, ...)` of each coordinate, and their derivatives."""
        every: tuple[list[Array], list[Array]] = [], []
        for index, degree in enumerate(self.degrees):
            x = points[..., index]
            values, slopes = np.ones((2, degree + 1, *x.shape), dtype=x.dtype)
            values[1], slopes[0] = x, 0.0
            for power in range(2, degree + 1):
                values[power] = 2.0 * x * values[power - 1] - values[power - 2]
            every[0].append(values)
            if with_slopes:
                for power in range(2, degree + 1):
                    slopes[power] = (
                        2.0 * values[power - 1] + 2.0 * x * slopes[power - 1] - slopes[power - 2]
                    )
                every[1].append(slopes)
        return every


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
