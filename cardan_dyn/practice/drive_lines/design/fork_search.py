"""Fork search: fork offsets with the least greatest value where no closed form helps.

A grid over all offsets and differential evolution from its best candidates give starts in the
basins of the best minima, and sequential quadratic programming follows each of them down: the
greatest of many smooth values has kinks, and bounds on all of them have none. Offsets that can only
be taken in steps are all tried, up to a budget.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ....kit.arrays import BLOCK_SIZE, EPS, ROUNDED, Array

_BUDGET = 30_000
"""Candidates of a grid: some tenths of a second for forces of a line of five joints."""
_FINEST = 180
"""Most values of a free offset in a grid: 1°."""
_STARTS = 8
_POPULATION = 15
"""Candidates per free offset of differential evolution."""
_SAME = 0.02
"""Distance of offsets below which two minima are the same [rad]: squares are samples of curves, and
their greatest has ripples of the distance of samples."""
_NEAR = 0.9
"""Bounds are laid on values above this fraction of the greatest, and on more of them after each
round: others cannot become the greatest within a step."""
_ROUNDS = 12
_REACH = 0.2
"""Greatest change of a variable in a round, a fraction of what makes values rise and fall again."""


class Choice(NamedTuple):
    """Forks that were found, the best first.

    Attributes:
        offsets: `(c, m)` of lines that may be the best [rad].
        complete: whether one of them is proven to be it.
        method: how they were found, in words.
    """

    offsets: Array
    complete: bool
    method: str


Squares = Callable[[Array], Array]
"""Offsets `(c, m)` of c candidates to squares `(c, q)`, whose greatest counts; period π."""


def minima(
    squares: Squares, rough: Squares, allowed: Sequence[Array | None], count: int, given: Array
) -> Choice:
    """Return the least of the greatest square over offsets.

    Args:
        squares: what is minimised.
        rough: some of these squares, which tell where to look.
        allowed: for each offset its values [rad], or None if it is free.
        count: number of minima to return, if there are as many.
        given: `(m,)` offsets that are tried as well, if they are allowed.
    """
    free = np.array([values is None for values in allowed])
    candidates, is_all = _candidates(allowed, given)
    looked_at = squares if not free.any() and is_all else rough
    values = _greatest(looked_at, candidates)
    order = np.argsort(values, kind="stable")
    if not free.any():
        best = order[:count]
        if is_all:
            return Choice(candidates[best], True, f"all {len(candidates)} choices")
        found = [_exchanged(squares, allowed, candidates[i], float(values[i])) for i in best]
    else:
        near = candidates[order[: 100 * _STARTS]]
        starts = list(near[_apart(near, 1.5 * np.pi / _per_free(allowed), _STARTS)])
        starts.append(_evolved(rough, free, starts[0], candidates[order]))
        found = [_descended(squares, free, start) for start in starts]
    found.sort(key=lambda item: item[1])
    offsets = np.array([item[0] for item in found])
    rows = _apart(offsets, _SAME if free.any() else 0.0, count)
    method = f"search from the best of {len(candidates)} candidates"
    return Choice(offsets[rows], False, method)


def _greatest(squares: Squares, candidates: Array) -> Array:
    blocks = range(0, len(candidates), BLOCK_SIZE)
    return np.concatenate([squares(candidates[i : i + BLOCK_SIZE]).max(axis=1) for i in blocks])


def _evolved(rough: Squares, free: Array, start: Array, ordered: Array) -> Array:
    """Return what differential evolution makes of the best candidates; only free offsets change."""
    from scipy.optimize import differential_evolution  # Imported here: as below.

    like = ordered[(ordered[:, ~free] == start[~free]).all(axis=1)]
    population = like[: _POPULATION * int(free.sum())][:, free]

    def values(moved: Array) -> Array:
        offsets = np.tile(start, (moved.shape[1], 1))
        offsets[:, free] = moved.T
        return _greatest(rough, offsets)

    result = np.array(start)
    if len(population) >= 5:  # Differential evolution takes no fewer.
        result[free] = differential_evolution(
            values,
            [(-np.pi, np.pi)] * int(free.sum()),
            init=population,
            vectorized=True,
            updating="deferred",
            polish=False,
            seed=0,
        ).x
    return result


def _candidates(allowed: Sequence[Array | None], given: Array) -> tuple[Array, bool]:
    """Return a grid `(c, m)` over all offsets, or a part of it drawn by chance, and whether all."""
    number = _per_free(allowed)
    grid = np.arange(number) * (np.pi / number) - np.pi / 2
    lists = [grid if values is None else values for values in allowed]
    total = float(np.prod([float(len(values)) for values in lists]))
    if total <= _BUDGET:
        return np.array(list(itertools.product(*lists))), True
    draw = np.random.default_rng(0)
    drawn = np.stack([draw.choice(values, _BUDGET) for values in lists], axis=1)
    is_free = [values is None for values in allowed]
    drawn[0, is_free] = given[is_free]
    return drawn, False


def _per_free(allowed: Sequence[Array | None]) -> int:
    """Return how many values of each free offset the budget allows."""
    steps = float(np.prod([float(len(values)) for values in allowed if values is not None]))
    free = sum(values is None for values in allowed)
    return int(np.clip((_BUDGET / steps) ** (1.0 / max(free, 1)), 6, _FINEST))


def _between(a: Array, b: Array) -> float:
    """Return the greatest difference of offsets, which have period π [rad]."""
    return float(np.max(np.abs((a - b + np.pi / 2) % np.pi - np.pi / 2)))


def _apart(ordered: Array, spacing: float, most: int) -> list[int]:
    """Return the rows of the first candidates that are further from each other than a spacing."""
    chosen: list[int] = []
    for row, candidate in enumerate(ordered):
        if len(chosen) < most and all(
            _between(candidate, ordered[other]) > spacing for other in chosen
        ):
            chosen.append(row)
    return chosen


def _exchanged(
    squares: Squares, allowed: Sequence[Array | None], best: Array, least: float
) -> tuple[Array, float]:
    """Return the best line that taking one or two offsets anew leads to, again and again."""
    pairs = list(itertools.combinations_with_replacement(range(len(allowed)), 2))
    improved = True
    while improved:
        improved = False
        for pair in pairs:
            lists = [
                values if index in pair and values is not None else best[index : index + 1]
                for index, values in enumerate(allowed)
            ]
            tried = np.array(list(itertools.product(*lists)))
            values = squares(tried).max(axis=1)
            at = int(np.argmin(values))
            if values[at] < least * (1.0 - 1e-12):
                best, least, improved = tried[at], float(values[at]), True
    return best, least


def _descended(squares: Squares, free: Array, start: Array) -> tuple[Array, float]:
    """Return the local minimum below a start; only free offsets change."""

    def at(moved: Array) -> Array:
        offsets = np.tile(start, (len(moved), 1))
        offsets[:, free] = moved
        return squares(offsets)

    offsets, unlimited = np.array(start), np.full(int(free.sum()), np.inf)
    offsets[free], square = descended(at, start[free], -unlimited, unlimited)
    return offsets, square


def descended(
    values: Callable[[Array], Array], start: Array, low: Array, high: Array
) -> tuple[Array, float]:
    """Return where the greatest value is least near a start, and that value.

    Args:
        values: variables `(c, m)` of c candidates to values `(c, q)`, none negative. Variables are
            of the order 1, like angles.
        start: `(m,)` variables.
        low: `(m,)` their lower limits.
        high: `(m,)` their upper limits.
    """
    best, of_best = np.array(start), values(start[None])[0]
    chosen, reach = np.zeros(0, dtype=np.int64), _REACH
    for _ in range(_ROUNDS):
        least = float(of_best.max())
        if least <= np.finfo(float).tiny:
            break
        chosen = np.union1d(chosen, np.flatnonzero(of_best >= _NEAR * least))
        limits = np.maximum(best - reach, low), np.minimum(best + reach, high)
        found = _bounded(values, best, chosen, least, limits)
        of_found = values(found[None])[0]
        gain = least - float(of_found.max())
        if gain > 0.0:
            best, of_best = found, of_found
        if gain <= ROUNDED * least:
            # Either values without a bound have stopped it, or nothing but rounding is left.
            more = np.union1d(chosen, np.flatnonzero(of_found >= _NEAR * of_found.max()))
            if len(more) == len(chosen) and gain >= 0.0:
                break
            chosen, reach = more, reach / 4.0
    return best, float(of_best.max())


def _bounded(
    values: Callable[[Array], Array],
    start: Array,
    chosen: Array,
    scale: float,
    limits: tuple[Array, Array],
) -> Array:
    """Return the variables with the least bound on chosen values, within limits."""
    from scipy.optimize import minimize  # Imported here: only searches need it.

    low, high = limits

    def margins(x: Array) -> Array:
        return np.asarray(x[-1] - values(x[None, :-1])[0, chosen] / scale)

    def slopes(x: Array) -> Array:
        # Of central differences the cubic root of rounding errs least.
        steps = np.cbrt(EPS) * np.eye(len(start))
        ahead, behind = np.minimum(x[:-1] + steps, high), np.maximum(x[:-1] - steps, low)
        both = values(np.concatenate([ahead, behind]))[:, chosen] / scale
        rise = both[: len(start)] - both[len(start) :]
        return np.column_stack([-(rise.T / np.sum(ahead - behind, axis=1)), np.ones(len(chosen))])

    result = minimize(
        lambda x: x[-1],
        np.append(start, 1.0),
        jac=lambda x: np.append(np.zeros(len(x) - 1), 1.0),
        bounds=[*zip(low, high, strict=True), (0.0, None)],
        constraints={"type": "ineq", "fun": margins, "jac": slopes},
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 60},
    )
    return np.clip(result.x[:-1], low, high)
