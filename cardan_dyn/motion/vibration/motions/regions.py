"""Regions: intervals of speed in which disturbances of the smallest periodic motion grow.

What a period makes of disturbances is a smooth function of the speed as long as the motion is one:
between speeds at which that is known, polynomials tell it as exactly as it was integrated.
"""

from __future__ import annotations

from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, ROUNDED, Array
from ....kit.extremes import peak
from .search import MotionSearch
from .stability import NONE, STABLE, Stability, judged, separation, stability

_PLACES = 9
"""Speeds at which an interval is looked at in each round, its ends among them."""
_EDGE = 1e-8
"""Width, as a fraction of the speed, of the interval in which an edge lies at last."""
_NEIGHBOURS = 16
"""Known speeds through which a polynomial goes; with two of them fewer it tells its error,
and where that is rounding, nothing is integrated."""


class StabilityOverSpeed:
    """Tells the stability of the smallest motions at speeds, which it finds at few of them."""

    def __init__(self, search: MotionSearch, speeds: Array, known: Stability) -> None:
        """Begin with what is known.

        Args:
            search: of the design.
            speeds: `(S,)` ascending, of one sign.
            known: what was found there.
        """
        self._search, self._speeds, self._known = search, speeds, known
        self._free = known.average.shape[-1]

    @property
    def period(self) -> float:
        """Of the multipliers [rad]."""
        return self._search.model.period

    def at(self, speeds: Array) -> Stability:
        """Return the stability at speeds `(S,)` between the first and the last one known.

        Of speeds that polynomials tell, multipliers and kinds alone.
        """
        size = len(speeds)
        found = Stability.unknown(size, self._free)
        left = np.arange(size)
        while (left := left[~self._told(speeds, left, found)]).size:
            new = np.unique(speeds[left])
            # Of many, that in the middle between two known ones may let others be told.
            if len(new) > _NEIGHBOURS:
                after = np.searchsorted(self._speeds, new)
                middle = 0.5 * (self._speeds[after - 1] + self._speeds[after])
                order = np.lexsort((np.abs(new - middle), after))
                new = new[np.sort(order[np.unique(after[order], return_index=True)[1]])]
            self._keep(new, stability(self._search, new))
        return found

    def _keep(self, speeds: Array, new: Stability) -> None:
        """Keep what was found at speeds that were not known."""
        every = np.concatenate([self._speeds, speeds])
        order = np.argsort(every, kind="stable")
        both = zip(self._known[1:], new[1:], strict=True)
        self._speeds = every[order]
        change = max(self._known.change, new.change)
        self._known = Stability(change, *(np.concatenate(parts)[order] for parts in both))

    def _told(self, speeds: Array, rows: Array, found: Stability) -> Array:
        """Tell what is known at some speeds, or between; and return whether it is `(K,)`."""
        at = np.searchsorted(self._speeds, speeds[rows])
        after = np.minimum(at, len(self._speeds) - 1)
        told = self._speeds[after] == speeds[rows]
        for own, of in zip(found[1:], self._known[1:], strict=True):
            own[rows[told]] = of[after[told]]
        is_there, change = self._known.kind != NONE, self._known.change
        # Beside a speed without a motion nothing is sure.
        between = ~told & is_there[after] & is_there[np.maximum(at - 1, 0)]
        if np.count_nonzero(is_there) < _NEIGHBOURS or not np.any(between):
            return told
        (index,) = np.nonzero(between)
        known = self._known.monodromy[is_there], self._known.average[is_there]
        numbers = np.concatenate([item.reshape(len(item), -1) for item in known], axis=1)
        values, error = _interpolated(
            self._speeds[is_there], numbers, speeds[rows[index]], self._columns
        )
        is_sure = error <= max(ROUNDED, 2.0 * change)
        index, values = index[is_sure], values[is_sure]
        if index.size:
            change = max(change, float(np.max(error[is_sure])))
            parts = np.split(values, self._columns[:1], axis=1)
            matrices, average = (
                part.reshape(-1, *item.shape[1:]) for part, item in zip(parts, known, strict=True)
            )
            found.multipliers[rows[index]], found.kind[rows[index]] = judged(
                matrices, average, change
            )
        told[index] = True
        return told

    @property
    def _columns(self) -> tuple[int, ...]:
        """Numbers of columns that belong together: a monodromy matrix, three averages."""
        return 4 * self._free**2, *(self._free**2,) * 3


def _interpolated(
    known: Array, rows: Array, speeds: Array, columns: tuple[int, ...]
) -> tuple[Array, Array]:
    """Return what polynomials in 1/speed make of known rows, and how sure they are `(S,)`.

    Args:
        known: speeds `(K,)`, ascending.
        rows: of numbers `(K, F)` there.
        speeds: `(S,)` between them.
        columns: numbers of columns that have one size.
    """
    best, least = np.zeros((len(speeds), rows.shape[1])), np.full(len(speeds), np.inf)
    after = np.searchsorted(known, speeds)
    ends = np.cumsum(columns)[:-1]
    _, mass, _, stiffness = (np.max(np.abs(part)) for part in np.split(rows, ends, axis=1))
    # Dampers may be none: what they do is measured in what the other two do.
    others = mass, np.sqrt(mass * stiffness) + 1e-300, stiffness + 1e-300
    # Beside a speed at which one motion gives way to another, neighbours are on one side.
    for below in (_NEIGHBOURS // 2, _NEIGHBOURS - 1, 1):
        (open_,) = np.nonzero(least > ROUNDED)
        first = np.clip(after[open_] - below, 0, len(known) - _NEIGHBOURS)
        near = first[:, None] + np.arange(_NEIGHBOURS)
        places, at, taken = known[near], speeds[open_], rows[near]
        weights, fewer = _lagrange(places, at), _lagrange(places[:, 1:-1], at)
        values = np.einsum("sk,skf->sf", weights, taken)
        gap = np.abs(values - np.einsum("sk,skf->sf", fewer, taken[:, 1:-1]))
        error = EPS * np.sum(np.abs(weights), axis=1)
        greatest = np.maximum(np.max(np.abs(values[:, : ends[0]]), axis=1), 1.0)
        for part, size in zip(np.split(gap, ends, axis=1), (greatest, *others), strict=True):
            error = np.maximum(error, np.max(part, axis=1) / size)
        better = error < least[open_]
        best[open_[better]], least[open_[better]] = values[better], error[better]
    return best, least


def _lagrange(places: Array, at: Array) -> Array:
    """Return weights `(S, k)` of values at speeds `(S, k)`, of polynomials in 1/speed at `(S,)`.

    Edges are found to rounding, so that two speeds may be neighbours among floating-point numbers.
    Their difference is exact and not zero, as that of their reciprocals may be.
    """
    gaps = places[:, :, None] - places[:, None, :]
    ways = np.repeat((at[:, None] - places)[:, None, :], places.shape[1], axis=1)
    ratios = np.repeat((places / at[:, None])[:, :, None], places.shape[1], axis=2)
    own = np.arange(places.shape[1])
    gaps[:, own, own] = ways[:, own, own] = ratios[:, own, own] = 1.0
    return np.asarray(np.prod(ways / gaps * ratios, axis=2))


class Region(NamedTuple):
    """An interval of speed in which the smallest periodic motion is unstable.

    Attributes:
        lower, upper: its edges [rad/s]; the last speed that was looked at where it goes on beyond,
            or where there is no motion beyond.
        kind: see `Floquet.kind`, where it grows fastest.
        growth: greatest growth rate found inside [1/s].
        speed: where that is [rad/s].
        is_closed: whether motions are stable beyond both edges; if not, it may go on, and the
            growth may be greater there.
    """

    lower: float
    upper: float
    kind: str
    growth: float
    speed: float
    is_closed: bool

    @property
    def width(self) -> float:
        """Of the interval [rad/s]."""
        return self.upper - self.lower


def regions(over: StabilityOverSpeed, speeds: Array, known: Stability) -> list[Region]:
    """Return all regions that were found between speeds, ascending.

    Regions narrower than the steps of the speeds are looked for where two multipliers come near
    each other.

    Args:
        over: of the design.
        speeds: `(S,)` ascending, of one sign.
        known: what was found there.
    """

    def growth_at(speed: float) -> float:
        there = over.at(np.array([speed]))
        return float(rate(np.where(there.grows[0], there.excess[0], 0.0), speed))

    def rate(excess: Array, speed: Array | float) -> Array:
        return np.asarray(np.log1p(excess) * np.abs(speed) / over.period)

    speeds, excess, kind = _refined(over, speeds, known)
    is_there = kind != NONE
    unstable = (kind != STABLE) & is_there
    growth = rate(np.where(unstable, excess, 0.0), speeds)
    changes = np.nonzero(unstable[1:] != unstable[:-1])[0]
    edges = _edges(over, speeds, unstable, changes[is_there[changes] & is_there[changes + 1]])
    found = []
    bounds = [0, *(changes + 1).tolist(), len(speeds)]
    for first, last in pairwise(bounds):
        if not np.any(unstable[first:last]):
            continue
        # What lies beyond an end, or beyond a speed without a motion, is not known.
        lower = edges.get(first - 1, float(speeds[first]))
        upper = edges.get(last - 1, float(speeds[last - 1]))
        # Beside the first and the last speed inside is an edge.
        places = np.concatenate([[lower], speeds[first:last], [upper]])
        beside = np.concatenate([[0.0], growth[first:last], [0.0]])
        # Of two speeds that grow faster than those beside them, either may be next to the fastest.
        tops = np.nonzero((beside[1:-1] >= beside[:-2]) & (beside[1:-1] >= beside[2:]))[0]
        fastest = (
            peak(growth_at, places[top], places[top + 2], (places[top + 1], beside[top + 1]))
            for top in tops.tolist()
        )
        speed, most = max(fastest, key=itemgetter(1))
        of = str(over.at(np.array([speed])).kind[0])
        is_closed = first - 1 in edges and last - 1 in edges
        found.append(Region(lower, upper, of, float(most), float(speed), is_closed))
    return found


def _refined(
    over: StabilityOverSpeed, speeds: Array, known: Stability
) -> tuple[Array, Array, Array]:
    """Return speeds, excess and kinds, with more speeds where multipliers nearly collide."""
    every = [(speeds, known.excess, known.kind)]
    gap = separation(known.multipliers)
    is_least = np.zeros(len(speeds), dtype=bool)
    if len(speeds) > 2:
        is_least[1:-1] = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] <= gap[2:])
    is_least &= (known.kind == STABLE) & ~known.decays
    at = np.nonzero(is_least)[0]
    lower, upper = speeds[at - 1], speeds[at + 1] if at.size else speeds[at]
    while lower.size:
        places = np.linspace(lower, upper, _PLACES, axis=1)
        found = over.at(places.ravel())
        every.append((places.ravel(), found.excess, found.kind))
        gaps = np.nan_to_num(separation(found.multipliers).reshape(places.shape), nan=np.inf)
        best = np.clip(np.argmin(gaps, axis=1), 1, _PLACES - 2)
        # In narrower intervals nothing grows by more than rounding.
        is_open = ~np.any(found.grows.reshape(places.shape), axis=1)
        (rows,) = np.nonzero(is_open & (upper - lower > np.sqrt(ROUNDED) * np.abs(upper)))
        lower, upper = places[rows, best[rows] - 1], places[rows, best[rows] + 1]
    speeds, excess, kind = (np.concatenate(items) for items in zip(*every, strict=True))
    order = np.unique(speeds, return_index=True)[1]
    return speeds[order], excess[order], kind[order]


def _edges(
    over: StabilityOverSpeed, speeds: Array, unstable: Array, changes: Array
) -> dict[int, float]:
    """Return where stability changes after speeds of given indices."""
    lower, upper = speeds[changes], speeds[changes + 1]
    before, rows = unstable[changes, None], np.arange(len(changes))
    while changes.size and np.any(upper - lower > _EDGE * np.abs(upper)):
        # Several places at a time, since all of them are solved together.
        places = np.linspace(lower, upper, _PLACES, axis=1)
        grows = over.at(places[:, 1:-1].ravel()).grows.reshape(len(changes), -1)
        first = np.argmax(np.column_stack([grows != before, rows >= 0]), axis=1)
        lower, upper = places[rows, first], places[rows, first + 1]
    return {
        int(index): 0.5 * float(first + last)
        for index, first, last in zip(changes, lower, upper, strict=True)
    }
