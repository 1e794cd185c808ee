"""Stability: what becomes of small disturbances of periodic motions.

M δq̈ + D δq̇ + K δq = 0 is integrated over one period of its coefficients by Gauss collocation of
order 16, whose elements are halved until the result stands; many motions together.

Source: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, II.7.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ....kit.arrays import NOTHING, ROUNDED, Array
from ....kit.errors import VibrationError
from ....kit.periodic import interpolation
from ..model.modes import averaged, modes
from ..model.motion_equation import LocalEquation
from .harmonic_balance import NUMBERS, Motions
from .search import MotionSearch

_STAGES = 8
"""Gauss points of an element: the method is of twice that order."""
_MOST_ELEMENTS = 50_000
"""Elements at the first try, of some 10 000 swings in a period, that memory and time allow."""
STABLE, FLIP, FOLD, COMBINATION = "stable", "instability", "fold", "combination"
FLUTTER, NONE = "flutter", "no motion"
_UNSTABLE = float(np.sqrt(ROUNDED))
"""Excess of a multiplier's size over 1 that is none of rounding: at a collision the latter parts
multipliers by its root. In a region that is entered at speed Ω₀, it is reached where
(Ω - Ω₀)/width is about its square."""


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
    fastest = np.sqrt(np.max(np.linalg.norm(matrix, axis=(2, 3)), axis=1, initial=1.0))
    # In an element, the fastest motion goes through a quarter of its swing.
    least = np.maximum(fastest * period / (0.5 * np.pi), matrix.shape[1] / 12.0)
    if np.max(least, initial=0.0) > _MOST_ELEMENTS:
        swings = float(np.max(fastest)) * period / (2.0 * np.pi)
        raise VibrationError(
            f"while the drive goes through a period of {period:.4g} rad, free coordinates swing "
            f"{swings:.1e} times, too often to be integrated: choose a greater speed"
        )
    result, greatest = np.empty(matrix[:, 0].shape), 0.0
    # Slow speeds take more elements than fast ones.
    steps = np.ceil(np.log2(np.maximum(least, 1.0)))
    for step in np.unique(steps).tolist():
        (index,) = np.nonzero(steps == step)
        elements = 2 ** int(step)
        result[index], change = _standing(matrix[index], period, elements)
        greatest = max(greatest, change)
    return result, greatest


def _standing(matrix: Array, period: float, elements: int) -> tuple[Array, float]:
    """Return what `monodromy` does, from a number of elements on."""
    found, change = _over_period(matrix, period, elements), np.inf
    while True:
        elements *= 2
        before, found = found, _over_period(matrix, period, elements)
        scale = np.maximum(np.max(np.abs(found), axis=(1, 2)), 1.0)
        last, change = change, float(np.max(np.max(np.abs(found - before), axis=(1, 2)) / scale))
        # The error is the change divided by 2^16; what shrinks no more is rounding.
        if not ROUNDED < change <= 0.5 * last:
            return found, change


def _over_period(matrix: Array, period: float, elements: int) -> Array:
    """Return the product of all elements' propagators `(S, m, m)`."""
    size, count, order, _ = matrix.shape
    points, _, _ = gauss(_STAGES)
    width = period / elements
    places = (width * (np.arange(elements)[:, None] + points)).ravel()
    weights = interpolation(places, count, period)
    each = max(1, NUMBERS // (elements * (_STAGES * order // 2) ** 2))
    result = np.empty((size, order, order))
    for first in range(0, size, each):
        # Of the state's two halves, the first one's rate is the second one.
        part = matrix[first : first + each, :, order // 2 :]
        values = weights @ part.reshape(len(part), count, -1)
        values = values.reshape(len(part), elements, _STAGES, order // 2, order)
        result[first : first + each] = _product(_propagators(values, width))
    return result


def _product(steps: Array) -> Array:
    """Return products `(S, m, m)` of matrices `(S, E, m, m)`, the first one on the right."""
    while steps.shape[1] > 1:
        pairs = steps.shape[1] // 2
        joined = steps[:, 1 : 2 * pairs : 2] @ steps[:, : 2 * pairs : 2]
        steps = np.concatenate([joined, steps[:, 2 * pairs :]], axis=1)
    return steps[:, 0]


def _propagators(values: Array, width: float) -> Array:
    """Return what elements of a width make of a state `(S, E, m, m)`.

    With y = (x, v), x' = v and v' = B x + C v, slopes of v alone are unknown: those of x follow.

    Args:
        values: (B, C) `(S, E, s, n, 2 n)` at the Gauss points.
        width: of an element.
    """
    *shape, stages, free, order = values.shape
    points, inner, outer = gauss(stages)
    twice = inner @ inner
    by_place, by_rate = values[..., :free], values[..., free:]
    # v' at point i is B (x + h c_i v + h² Σ (a²)_ij v'_j) + C (v + h Σ a_ij v'_j).
    system = np.empty((*shape, stages, free, stages, free))
    for i, j in np.ndindex(stages, stages):
        block = (-(width**2) * twice[i, j]) * by_place[..., i, :, :]
        block += (-width * inner[i, j]) * by_rate[..., i, :, :]
        system[..., i, :, j, :] = block
    own = np.arange(stages * free)
    system = system.reshape(*shape, stages * free, stages * free)
    system[..., own, own] += 1.0
    sides = values.copy()
    sides[..., free:] += width * points[:, None, None] * by_place
    slopes = np.linalg.solve(system, sides.reshape(*shape, stages * free, order))
    slopes = slopes.reshape(*shape, stages, free * order)
    # x grows by h v + h² Σ (b a)_j v'_j, v by h Σ b_j v'_j.
    ways = np.stack([width**2 * (outer @ inner), width * outer]) @ slopes
    result = ways.reshape(*shape, order, order)
    own = np.arange(free)
    result[..., own, free + own] += width
    return np.asarray(result + np.eye(order))


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
    rising = np.polynomial.legendre.legint(np.eye(stages), lbnd=-1.0)
    integrals = np.polynomial.legendre.legval(roots, rising).T
    return points, 0.5 * integrals @ lagrange, 0.5 * weights


class Stability(NamedTuple):
    """What becomes of small disturbances at S speeds; NaN where there is no motion.

    Attributes:
        change: greatest change of a monodromy matrix when its elements were halved last.
        multipliers: complex `(S, 2n)` over one period, the greatest first.
        liouville: `(S,)` the determinant by the integral of the damping.
        kind: `(S,)` names.
        coexisting: `(S,)` number of further motions that were found.
        decays: `(S,)` whether disturbances decay by more than what varies over a period can add.
        monodromy: `(S, 2n, 2n)` what a period makes of disturbances.
        average: `(S, 3, n, n)` mass, damping and stiffness, averaged over a period.
    """

    change: float
    multipliers: Array
    liouville: Array
    kind: Array
    coexisting: Array
    decays: Array
    monodromy: Array
    average: Array

    @classmethod
    def unknown(cls, size: int, free: int) -> Stability:
        """Return that of speeds at which nothing is known."""
        return cls(
            change=0.0,
            multipliers=np.full((size, 2 * free), np.nan + 0j),
            liouville=np.full(size, np.nan),
            kind=np.full(size, NONE, dtype="<U12"),
            coexisting=np.zeros(size, dtype=int),
            decays=np.zeros(size, dtype=bool),
            monodromy=np.full((size, 2 * free, 2 * free), np.nan),
            average=np.full((size, 3, free, free), np.nan),
        )

    @property
    def trace(self) -> Array:
        """`(S,)` of the monodromy matrix."""
        return np.asarray(np.trace(self.monodromy, axis1=1, axis2=2))

    @property
    def determinant(self) -> Array:
        """`(S,)` of the monodromy matrix."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.linalg.det(self.monodromy))

    @property
    def excess(self) -> Array:
        """`(S,)` size of the greatest multiplier less 1."""
        return np.asarray(np.abs(self.multipliers[:, 0]) - 1.0)

    @property
    def grows(self) -> Array:
        """`(S,)` whether disturbances grow."""
        return np.asarray((self.kind != STABLE) & (self.kind != NONE))


def stability(search: MotionSearch, speeds: Array) -> Stability:
    """Return what becomes of small disturbances of the smallest motion at each speed.

    Args:
        search: of the design.
        speeds: `(S,)`.
    """
    result = Stability.unknown(len(speeds), len(search.rotating.free))
    change = 0.0
    # What a search finds first may be one of several, and even one that no rig stays at.
    found_motions, result.coexisting[:] = search.smallest(speeds)
    for motions in found_motions:
        equation, index = motions.equation, motions.index
        speed = motions.course.speed
        matrix = first_order(equation, speed)
        period = motions.model.period
        result.decays[index] = _decays(matrix)
        found, changed = monodromy(matrix, period)
        change = max(change, changed)
        result.monodromy[index] = found
        result.average[index] = np.stack(averaged(equation), axis=1)
        result.multipliers[index], result.kind[index] = judged(
            found, result.average[index], changed
        )
        spur = np.mean(np.trace(matrix, axis1=2, axis2=3), axis=1)
        result.liouville[index] = np.exp(period * spur)
    return result._replace(change=change)


def judged(monodromy: Array, average: Array, change: float) -> tuple[Array, Array]:
    """Return multipliers `(S, 2n)`, the greatest first, and the names `(S,)` of what they mean.

    Args:
        monodromy: matrices `(S, 2n, 2n)`.
        average: mass, damping and stiffness `(S, 3, n, n)`, see `averaged`.
        change: what the matrices may be off by.
    """
    values = ranked_multipliers(monodromy)
    mean = modes(*np.moveaxis(average, 1, 0)).value
    grows = np.any(mean.real > _UNSTABLE * np.abs(mean), axis=1)
    return values, _kinds(values, grows, _excess_of_rounding(values, change))


def _decays(matrix: Array) -> Array:
    """Return whether all solutions of dy/ds = A y shrink, whatever the period, `(S,)`.

    In coordinates along the eigenvectors of the mean of A, sizes change at most at the rate of the
    greatest real part of its eigenvalues and the size of what is left of A.

    Args:
        matrix: A `(S, N, m, m)` over a period.
    """
    mean = np.mean(matrix, axis=1)
    values, vectors = np.linalg.eig(mean)
    with np.errstate(all="ignore"):
        is_regular = np.linalg.cond(vectors) < 1.0 / NOTHING
    found = np.zeros(len(matrix), dtype=bool)
    (index,) = np.nonzero(is_regular)
    basis = vectors[index, None]
    left = np.linalg.solve(basis, (matrix[index] - mean[index, None]) @ basis)
    sizes = np.max(np.linalg.norm(left, axis=(2, 3)), axis=1, initial=0.0)
    found[index] = np.max(values[index].real, axis=1) + sizes < 0.0
    return found


def ranked_multipliers(monodromy: Array) -> Array:
    """Return the eigenvalues `(S, m)` of matrices `(S, m, m)`, the greatest first."""
    values = np.linalg.eigvals(monodromy).astype(complex)
    rank = np.argsort(-np.abs(values), axis=1, kind="stable")
    return np.take_along_axis(values, rank, axis=1)


def stays(motions: Motions) -> Array:
    """Return whether small disturbances of motions decay, or do not grow `(S,)`."""
    matrix = first_order(motions.equation, motions.course.speed)
    found, change = monodromy(matrix, motions.model.period)
    values = ranked_multipliers(found)
    return np.asarray(np.abs(values[:, 0]) <= 1.0 + _excess_of_rounding(values, change))


def _excess_of_rounding(multipliers: Array, change: float) -> Array:
    """Return the excess `(S,)` over 1 that the size of multipliers `(S, m)` may have by rounding.

    Args:
        multipliers: the greatest first.
        change: of the monodromy matrices when they were refined last.
    """
    first, others = multipliers[:, :1], multipliers[:, 1:]
    gap = np.min(np.abs(others - first), axis=1)
    error = max(ROUNDED, change)
    # Where multipliers are far from each other, rounding hardly moves them.
    return np.clip(error / np.maximum(gap, error), NOTHING, _UNSTABLE)


def _kinds(multipliers: Array, grows: Array, excess: Array | float = _UNSTABLE) -> Array:
    """Return the names `(S,)` of what multipliers `(S, m)`, greatest first, mean.

    Args:
        multipliers: of a period.
        grows: `(S,)` whether the averaged equation is unstable itself.
        excess: `(S,)` of the greatest one's size over 1, from which on disturbances grow.
    """
    first = multipliers[:, 0]
    is_real = np.abs(first.imag) <= _UNSTABLE * np.abs(first)
    kinds = np.where(is_real, np.where(first.real > 0.0, FOLD, FLIP), COMBINATION)
    kinds = np.where(~is_real & grows, FLUTTER, kinds)
    return np.where(np.abs(first) > 1.0 + excess, kinds, STABLE)


def separation(multipliers: Array) -> Array:
    """Return the least distance `(S,)` of two multipliers `(S, m)` that differ; inf if none do.

    Those that are one up to rounding, as of a disc between equal springs, say nothing of others.
    """
    gaps = np.abs(multipliers[:, :, None] - multipliers[:, None, :])
    return np.asarray(np.min(np.where(gaps <= NOTHING, np.inf, gaps), axis=(1, 2)))
