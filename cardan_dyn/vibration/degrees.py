"""Degrees: which polynomials the terms of the efforts need within a range."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, generic
from .polynomials import polynomials, size_of
from .term_samples import TermSamples

_GOOD_ERROR = 1e-10
"""Error from which on rounding may be what is left, so that higher degrees bring nothing."""
_LINE_DEGREES = (6, 20, 44, 92)
"""Degrees that are tried along a line, whose Chebyshev coefficients tell which one is enough."""
_FACTORS = (1.0, 1.25, 1.5625, 1.953125)
"""By how much the degrees of several coordinates together exceed those of each alone."""
_MOST_POLYNOMIALS = 500
"""More polynomials would take minutes to be sampled."""
_CHECKS = 24
"""Places of the range at which polynomials are compared with the terms."""


def needed_degrees(
    samples: TermSamples, drive: Array, centre: Array, half: Array, wanted: float
) -> tuple[tuple[int, ...], float]:
    """Return degrees in each free coordinate, and the error that they leave.

    Args:
        samples: of the terms.
        drive: some positions of the drive `(K,)`.
        centre: middles of the ranges there `(K, n)`.
        half: half widths of the ranges `(n,)`.
        wanted: error at which degrees are enough; if it cannot be had, the least is returned.
    """
    lines = [_along(samples, drive, centre, half, index, wanted) for index in range(len(half))]
    single, error = tuple(degree for degree, _ in lines), max(error for _, error in lines)
    if len(half) == 1:
        return single, error
    # Where no term depends on two coordinates, the degrees of each alone are enough.
    more = [
        tuple(int(np.ceil(factor * max(degree, 2))) for degree in single) for factor in _FACTORS
    ]
    best, least = single, np.inf
    for degrees in dict.fromkeys([single, *more]):
        if size_of(degrees) > _MOST_POLYNOMIALS:
            break
        error = _error(samples, drive, centre, half, degrees)
        is_rounding = error > 0.5 * least and least < _GOOD_ERROR
        if error < least:
            best, least = degrees, error
        if error <= wanted or is_rounding:
            break
    return best, least


def _along(
    samples: TermSamples, drive: Array, centre: Array, half: Array, index: int, wanted: float
) -> tuple[int, float]:
    """Return degree and error of the terms in one free coordinate, the others elsewhere."""
    inside = generic(len(drive), len(half))
    inside[:, index] = 0.0
    way = half * np.eye(len(half))[index]
    degree, least = 1, np.inf
    for size in _LINE_DEGREES:
        basis = polynomials((size,))
        terms = samples.about(drive, centre + half * inside, basis.nodes * way)
        sizes = np.max(np.abs(basis.coefficients(terms / samples.kinds(terms))), axis=(0, 2))
        rounding = float(np.max(sizes[-max(2, size // 4) :]))
        if rounding > 0.1 * least and least < _GOOD_ERROR:
            break
        least = rounding
        above = np.nonzero(sizes > max(0.3 * wanted, 2.0 * rounding))[0]
        degree = max(1, int(np.max(above, initial=0)))
        if rounding <= 0.3 * wanted:
            break
    return degree, least


def _error(
    samples: TermSamples, drive: Array, centre: Array, half: Array, degrees: tuple[int, ...]
) -> float:
    """Return the error of polynomials of given degrees."""
    inside = generic(_CHECKS, len(half))
    basis = polynomials(degrees)
    exact, terms = (samples.about(drive, centre, half * ways) for ways in (inside, basis.nodes))
    found = basis.values(inside).T @ basis.coefficients(terms)
    return float(np.max(np.abs(found - exact) / samples.kinds(exact)))
