"""Monodromy: what a period makes of small disturbances of periodic motions.

M δq̈ + D δq̇ + K δq = 0 is integrated over one period of its coefficients by Gauss collocation of
order 16, whose elements are halved until the result stands; many motions together.

Source: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, II.7.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..arrays import Array
from ..errors import VibrationError
from .periodic_grid import interpolation
from .reduced_model import LocalEquation

_STAGES = 8
"""Gauss points of an element: the method is of twice that order."""
_PHASE = 1.2
"""Greatest phase of the fastest motion in an element [rad] at the first try."""
_STANDS = 3e-14
"""Change of the result, as a fraction of its greatest number, at which elements are short enough:
the error is then that divided by 2^16, and rounding."""
_MOST_HALVINGS = 5
_MOST_ELEMENTS = 50_000
"""Elements at the first try, of some 10 000 swings in a period, that memory and time allow."""
_NUMBERS = 8_000_000
"""Numbers (64 MB) of the elements' equations that are solved at a time."""


def first_order(equation: LocalEquation, speed: Array) -> Array:
    """Return A `(S, N, 2n, 2n)` of dy/ds = A y with y = (δq, dδq/ds), s = |φ| the drive's way.

    Nodes are at equidistant ways from position 0 on, in the sense in which the drive turns, so that
    disturbances are followed forwards in time where the drive turns back as well.

    Args:
        equation: along S motions, at nodes of ascending positions.
        speed: of the drive `(S,)` [rad/s].
    """
    free, pace = equation.mass.shape[-1], np.abs(speed)[:, None, None, None]
    sides = np.concatenate([equation.stiffness / pace**2, equation.damping / pace], axis=-1)
    matrix = np.zeros((*equation.mass.shape[:2], 2 * free, 2 * free))
    matrix[..., :free, free:] = np.eye(free)
    matrix[..., free:, :] = -np.linalg.solve(equation.mass, sides)
    turns_back = speed < 0.0
    matrix[turns_back] = np.roll(matrix[turns_back][:, ::-1], 1, axis=1)
    return matrix


def monodromy(matrix: Array, period: float) -> tuple[Array, float]:
    """Return what one period makes of disturbances.

    Args:
        matrix: A `(S, N, m, m)` at the nodes of a period of the way, see `first_order`.
        period: of the coefficients [rad].

    Returns:
        `(S, m, m)`; and its greatest change when elements were halved last.

    Raises:
        VibrationError: the speed is next to none, so that a period takes too many elements.
    """
    fastest = np.sqrt(np.max(np.linalg.norm(matrix, axis=(2, 3)), initial=1.0))
    count = matrix.shape[1]
    elements = int(np.ceil(max(fastest * period / _PHASE, count / 12.0)))
    if elements > _MOST_ELEMENTS:
        swings = fastest * period / (2.0 * np.pi)
        raise VibrationError(
            f"while the drive goes through a period of {period:.4g} rad, free coordinates swing "
            f"{swings:.1e} times, too often to be integrated: choose a greater speed"
        )
    before = _over_period(matrix, period, elements)
    change = np.inf
    for _ in range(_MOST_HALVINGS):
        elements *= 2
        after = _over_period(matrix, period, elements)
        scale = np.maximum(np.max(np.abs(after), axis=(1, 2)), 1.0)
        change = float(np.max(np.max(np.abs(after - before), axis=(1, 2)) / scale))
        before = after
        if change <= _STANDS * elements:
            break
    return before, change


def _over_period(matrix: Array, period: float, elements: int) -> Array:
    """Return the product of all elements' propagators `(S, m, m)`."""
    size, count, order, _ = matrix.shape
    points, _, _ = gauss(_STAGES)
    width = period / elements
    places = (width * (np.arange(elements)[:, None] + points)).ravel()
    weights = interpolation(places, count, period)
    each = max(1, _NUMBERS // (elements * (_STAGES * order) ** 2))
    result = np.empty((size, order, order))
    for first in range(0, size, each):
        part = matrix[first : first + each]
        values = np.einsum("kn,snij->skij", weights, part, optimize=True)
        values = values.reshape(len(part), elements, _STAGES, order, order)
        steps = _propagators(values, width)
        total = steps[:, 0]
        for index in range(1, elements):
            total = steps[:, index] @ total
        result[first : first + each] = total
    return result


def _propagators(values: Array, width: float) -> Array:
    """Return what elements of a width make of a state `(S, E, m, m)`.

    Args:
        values: A `(S, E, s, m, m)` at the Gauss points.
        width: of an element.
    """
    *shape, stages, order, _ = values.shape
    _, inner, outer = gauss(stages)
    # Slopes k_i = A_i (y + h Σ a_ij k_j).
    system = -width * np.einsum("ij,seiab->seiajb", inner, values, optimize=True)
    system = system.reshape(*shape, stages * order, stages * order)
    own = np.arange(stages * order)
    system[..., own, own] += 1.0
    slopes = np.linalg.solve(system, values.reshape(*shape, stages * order, order))
    slopes = slopes.reshape(*shape, stages, order, order)
    return np.asarray(np.eye(order) + width * np.einsum("i,seiab->seab", outer, slopes))


@lru_cache(maxsize=8)
def gauss(stages: int) -> tuple[Array, Array, Array]:
    """Return points `(s,)`, inner weights `(s, s)` and weights `(s,)` of Gauss collocation."""
    roots, weights = np.polynomial.legendre.leggauss(stages)
    points = 0.5 * (1.0 + roots)
    # a_ij integrates Lagrange's polynomial j from 0 to point i; Legendre polynomials integrate
    # without cancellation.
    basis = np.polynomial.legendre.legvander(roots, stages - 1)
    norms = 2.0 / (2.0 * np.arange(stages) + 1.0)
    lagrange = (basis * weights[:, None] / norms).T
    integrals = np.stack(
        [
            np.polynomial.legendre.legval(
                roots, np.polynomial.legendre.legint(np.eye(stages)[order], lbnd=-1.0)
            )
            for order in range(stages)
        ],
        axis=1,
    )
    return points, 0.5 * integrals @ lagrange, 0.5 * weights
