"""Stability: multipliers of periodic motions at many speeds of one design, and what they mean."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .averaged import averaged, modes
from .coexisting import smallest
from .monodromy import first_order, monodromy
from .motion_search import Motions, MotionSearch

STABLE, FLIP, FOLD, COMBINATION = "stable", "instability", "fold", "combination"
FLUTTER, NONE = "flutter", "no motion"
_UNSTABLE = 1e-6
"""Excess of a multiplier's size over 1 that is none of rounding: at a collision the latter parts
multipliers by its root, some 1e-7. In a region that is entered at speed Ω₀, it is reached where
(Ω - Ω₀)/width is about its square."""
_MOST_CONDITION = 1e8
"""Of eigenvectors that serve as coordinates."""
_CAUTION = 10.0
"""By how much their errors may exceed the change at the last refinement."""
_SURELY = 1e-9
"""The same where multipliers are far from each other, so that rounding hardly moves them."""
_ROUNDING = 1e-12
"""Error of multipliers far from each other; near each other it is divided by their distance."""
_ONE = 1e-9
"""Distance at which two multipliers are one."""
_REAL = 1e-6
"""Imaginary part of a multiplier, as a fraction of its size, that counts as rounding."""


class Stability(NamedTuple):
    """What becomes of small disturbances at S speeds; NaN where there is no motion.

    Attributes:
        multipliers: complex `(S, 2n)` over one period, the greatest first.
        trace, determinant: `(S,)` of the monodromy matrix.
        liouville: `(S,)` the determinant by the integral of the damping.
        kind: `(S,)` names.
        coexisting: `(S,)` number of further motions that were found.
        decays: `(S,)` whether disturbances decay by more than what varies over a period can add.
        change: greatest change of a monodromy matrix when its elements were halved last.
    """

    multipliers: Array
    trace: Array
    determinant: Array
    liouville: Array
    kind: Array
    coexisting: Array
    decays: Array
    change: float

    @property
    def excess(self) -> Array:
        """`(S,)` size of the greatest multiplier less 1."""
        return np.asarray(np.abs(self.multipliers[:, 0]) - 1.0)


def stability(search: MotionSearch, speeds: Array) -> Stability:
    """Return what becomes of small disturbances of the smallest motion at each speed.

    Args:
        search: of the design.
        speeds: `(S,)`.
    """
    size, order = len(speeds), 2 * len(search.rotating.free)
    result = Stability(
        multipliers=np.full((size, order), np.nan + 0j),
        trace=np.full(size, np.nan),
        determinant=np.full(size, np.nan),
        liouville=np.full(size, np.nan),
        kind=np.full(size, NONE, dtype="<U12"),
        coexisting=np.zeros(size, dtype=int),
        decays=np.zeros(size, dtype=bool),
        change=0.0,
    )
    change = 0.0
    # What a search finds first may be one of several, and even one that no rig stays at.
    found_motions, result.coexisting[:] = smallest(search, speeds)
    for motions in found_motions:
        equation, index = motions.model.equation(motions.course), motions.index
        speed = motions.course.speed
        matrix = first_order(equation, speed)
        period = motions.model.period
        result.decays[index] = _decays(matrix)
        found, changed = monodromy(matrix, period)
        change = max(change, changed)
        values = ranked_multipliers(found)
        result.multipliers[index] = values
        result.trace[index] = np.trace(found, axis1=1, axis2=2)
        result.determinant[index] = np.linalg.det(found)
        spur = np.mean(np.trace(matrix, axis1=2, axis2=3), axis=1)
        result.liouville[index] = np.exp(period * spur)
        mean = modes(*averaged(equation)).value
        grows = np.any(mean.real > _UNSTABLE * np.abs(mean), axis=1)
        result.kind[index] = _kinds(values, grows, _excess_of_rounding(values, changed))
    return result._replace(change=change)


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
        is_regular = np.linalg.cond(vectors) < _MOST_CONDITION
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
    matrix = first_order(motions.model.equation(motions.course), motions.course.speed)
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
    error = max(_ROUNDING, _CAUTION * change)
    return np.clip(error / np.maximum(gap, error), _SURELY, _UNSTABLE)


def _kinds(multipliers: Array, grows: Array, excess: Array | float = _UNSTABLE) -> Array:
    """Return the names `(S,)` of what multipliers `(S, m)`, greatest first, mean.

    Args:
        multipliers: of a period.
        grows: `(S,)` whether the averaged equation is unstable itself.
        excess: `(S,)` of the greatest one's size over 1, from which on disturbances grow.
    """
    first = multipliers[:, 0]
    is_real = np.abs(first.imag) <= _REAL * np.abs(first)
    kinds = np.where(is_real, np.where(first.real > 0.0, FOLD, FLIP), COMBINATION)
    kinds = np.where(~is_real & grows, FLUTTER, kinds)
    return np.where(np.abs(first) > 1.0 + excess, kinds, STABLE)


def separation(multipliers: Array) -> Array:
    """Return the least distance `(S,)` of two multipliers `(S, m)` that differ; inf if none do.

    Those that are one up to rounding, as of a disc between equal springs, say nothing of others.
    """
    gaps = np.abs(multipliers[:, :, None] - multipliers[:, None, :])
    return np.asarray(np.min(np.where(gaps <= _ONE, np.inf, gaps), axis=(1, 2)))
