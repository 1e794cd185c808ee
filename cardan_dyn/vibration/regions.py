"""Regions: intervals of speed in which periodic motions are unstable, with their edges."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .motion_search import MotionSearch
from .stability import NONE, STABLE, Stability, separation, stability

_ROUNDS = 7
"""Rounds of the search for a region between two speeds, each four times as fine as the last."""
_PLACES = 9
"""Speeds at which an interval is looked at in each round, its ends among them."""
_GROWTH_ROUNDS = 6
"""Rounds of the search for the fastest growth, each three times as fine as the last."""
_EDGE = 1e-8
"""Width, as a fraction of the speed, of the interval in which an edge lies at last."""


class Region(NamedTuple):
    """An interval of speed in which the smallest periodic motion is unstable.

    Attributes:
        lower, upper: its edges [rad/s]; those of the search where it goes on beyond.
        kind: see `Floquet.kind`, where it grows fastest.
        growth: greatest growth rate found inside [1/s].
        speed: where that is [rad/s].
        is_closed: whether both edges lie inside the speeds that were searched.
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


def regions(search: MotionSearch, speeds: Array, known: Stability, period: float) -> list[Region]:
    """Return all regions that were found between speeds, ascending.

    Regions narrower than the steps of the speeds are looked for where two multipliers come near
    each other.

    Args:
        search: of the design.
        speeds: `(S,)` ascending, of one sign.
        known: what was found there.
        period: of the multipliers [rad].
    """
    speeds, excess, kind = _refined(search, speeds, known)
    unstable = (kind != STABLE) & (kind != NONE)
    growth = np.log1p(np.where(unstable, excess, 0.0)) * np.abs(speeds) / period
    changes = np.nonzero(unstable[1:] != unstable[:-1])[0]
    edges = _edges(search, speeds, unstable, changes)
    found = []
    bounds = [0, *(changes + 1).tolist(), len(speeds)]
    for first, last in pairwise(bounds):
        if not unstable[first]:
            continue
        lower = edges[first - 1] if first else float(speeds[0])
        upper = edges[last - 1] if last < len(speeds) else float(speeds[-1])
        best = first + int(np.argmax(growth[first:last]))
        # Beside the first and the last speed inside is an edge.
        before = lower if best == first else float(speeds[best - 1])
        after = upper if best == last - 1 else float(speeds[best + 1])
        known_best = float(growth[best]), float(speeds[best]), str(kind[best])
        peak, speed, of = _fastest(search, before, after, known_best)
        found.append(Region(lower, upper, of, peak, speed, bool(first and last < len(speeds))))
    return found


def _fastest(
    search: MotionSearch, lower: float, upper: float, best: tuple[float, float, str]
) -> tuple[float, float, str]:
    """Return the fastest growth between two speeds, where it is, and its kind.

    Args:
        search: of the design.
        lower: speed.
        upper: speed.
        best: the same of a speed between them.
    """
    for _ in range(_GROWTH_ROUNDS):
        places = np.linspace(lower, upper, _PLACES + 2)[1:-1]
        found = stability(search, places)
        is_unstable = (found.kind != STABLE) & (found.kind != NONE)
        size = np.where(is_unstable, found.excess, 0.0)
        growth = np.log1p(size) * np.abs(places) / search.period
        top = int(np.argmax(growth))
        if growth[top] > best[0]:
            best = float(growth[top]), float(places[top]), str(found.kind[top])
        width = 1.5 * (upper - lower) / (_PLACES + 1)
        lower, upper = max(lower, best[1] - width), min(upper, best[1] + width)
    return best


def _refined(search: MotionSearch, speeds: Array, known: Stability) -> tuple[Array, Array, Array]:
    """Return speeds, excess and kinds, with more speeds where multipliers nearly collide."""
    every = [(speeds, known.excess, known.kind)]
    gap = separation(known.multipliers)
    is_least = np.zeros(len(speeds), dtype=bool)
    if len(speeds) > 2:
        is_least[1:-1] = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] <= gap[2:])
    is_least &= (known.kind == STABLE) & ~known.decays
    at = np.nonzero(is_least)[0]
    lower, upper = speeds[at - 1], speeds[at + 1] if at.size else speeds[at]
    for _ in range(_ROUNDS):
        if not lower.size:
            break
        places = np.linspace(lower, upper, _PLACES, axis=1)
        found = stability(search, places.ravel())
        every.append((places.ravel(), found.excess, found.kind))
        gaps = separation(found.multipliers).reshape(places.shape)
        gaps = np.where(np.isnan(gaps), np.inf, gaps)
        is_new = np.any(
            ((found.kind != STABLE) & (found.kind != NONE)).reshape(places.shape), axis=1
        )
        best = np.clip(np.argmin(gaps, axis=1), 1, _PLACES - 2)
        rows = np.nonzero(~is_new)[0]
        lower, upper = places[rows, best[rows] - 1], places[rows, best[rows] + 1]
    joined = [np.concatenate(items) for items in zip(*every, strict=True)]
    order = np.unique(joined[0], return_index=True)[1]
    speeds, excess, kind = (item[order] for item in joined)
    is_there = kind != NONE
    return speeds[is_there], excess[is_there], kind[is_there]


def _edges(
    search: MotionSearch, speeds: Array, unstable: Array, changes: Array
) -> dict[int, float]:
    """Return where stability changes after speeds of given indices."""
    lower, upper = speeds[changes].copy(), speeds[changes + 1].copy()
    before = unstable[changes]
    while changes.size and np.any(upper - lower > _EDGE * np.abs(upper)):
        # Several places at a time, since all of them are solved together.
        places = np.linspace(lower, upper, _PLACES, axis=1)[:, 1:-1]
        found = stability(search, places.ravel())
        is_unstable = ((found.kind != STABLE) & (found.kind != NONE)).reshape(places.shape)
        differs = is_unstable != before[:, None]
        first = np.where(np.any(differs, axis=1), np.argmax(differs, axis=1), _PLACES - 2)
        every = np.column_stack([lower, places, upper])
        rows = np.arange(len(changes))
        lower, upper = every[rows, first], every[rows, first + 1]
    return {
        int(index): 0.5 * float(first + last)
        for index, first, last in zip(changes, lower, upper, strict=True)
    }
