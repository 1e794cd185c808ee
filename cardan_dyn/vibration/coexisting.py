"""Coexisting motions: further periodic motions at the same speed, near forced resonances.

Where a motion is large, its range is searched from guesses of many amplitudes and phases along the
modes that resonate. A thorough search does so at neighbouring speeds as well, and follows what it
finds there to the speed that was asked for, step by step.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ..arrays import Array
from .averaged import modes
from .harmonic_balance import Found, resolved, solved
from .linear_motions import linear_motions
from .motion_search import Motions, MotionSearch
from .periodic_grid import resampled
from .reduced_model import Course, ReducedModel

_WINDOW = 0.2
"""Relative distance from a forced resonance within which other motions are searched."""
_MOST_ORDER = 12
_LARGE = 5e-3
"""Amplitude, in units of the coordinates, from which on a motion is large enough for others."""
_BENT = 3e-3
"""Distance from the linear motion, as a fraction of a motion's size, from which on others are
searched."""
_SPREAD = 8.0
"""How many times larger than a motion others are searched."""
_SHARES = (0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9)
_MORE_SHARES = (0.05, 0.15, 0.28, 0.42, 0.6, 0.8, 1.0)
_PHASES, _MORE_PHASES = (0.0, 0.25, 0.5, 0.75), (0.08, 0.17, 0.33, 0.42, 0.58, 0.67, 0.83, 0.92)
"""Guesses: amplitudes as shares of the range, phases as shares of a turn; those of a thorough
search besides."""
_AROUND = (0.02,)
"""Relative distances of neighbouring speeds, the farthest first."""
_SAME = 1e-6
"""Difference of two motions, as a fraction of their range, at which they are the same."""


class _Known:
    """What was found at each of some speeds, without repetitions."""

    def __init__(self, half: Array) -> None:
        self._half = half
        self._of: dict[tuple[int, int], list[Array]] = {}
        self.found: list[tuple[tuple[int, int], ReducedModel, Course, float]] = []

    def at(self, key: tuple[int, int]) -> list[Array]:
        """Return the motions `(N, n)` at a speed."""
        return self._of.setdefault(key, [])

    def add(
        self, keys: list[tuple[int, int]], groups: list[tuple[ReducedModel, Array, Found]]
    ) -> None:
        """Add those of groups of motions that are new at the speeds of their guesses."""
        for model, index, found in groups:
            for item in np.nonzero(found.converged)[0].tolist():
                q, key = found.course.q[item], keys[int(index[item])]
                if all(_gap(q, other, self._half) > _SAME for other in self.at(key)):
                    self.at(key).append(q)
                    course = Course(*(part[item : item + 1] for part in found.course))
                    self.found.append((key, model, course, float(found.sign[item])))


def coexisting(
    search: MotionSearch, motions: Motions, *, is_thorough: bool = False
) -> list[Motions]:
    """Return further motions at the same speeds, near forced resonances.

    Args:
        search: that found the motions.
        motions: one for each speed.
        is_thorough: whether neighbouring speeds are searched as well.
    """
    middle = np.mean(motions.course.q, axis=1)
    size = np.max(np.abs(motions.course.q - middle[:, None]) / search.rotating.units, axis=(1, 2))
    linear, _ = linear_motions(motions)
    bent = np.max(np.abs(linear - motions.course.q) / search.rotating.units, axis=(1, 2))
    # Where the linear equation gives the same motion, nothing bends its resonance back.
    size = np.where(bent > _BENT * size, size, 0.0)
    resonances = _resonances(motions)
    near = [index for index in range(len(size)) if size[index] > _LARGE and resonances[index]]
    if not near:
        return []
    wanted = _SPREAD * float(np.max(size[near]))
    model = search.widest(np.mean(middle[near], axis=0), wanted)
    known = _Known(model.half)
    for index in near:
        known.at((index, 0)).append(motions.course.q[index])
    steps = len(_AROUND) if is_thorough else 0
    guesses: list[Array] = []
    keys: list[tuple[int, int]] = []
    shares = list(product(_SHARES, _PHASES))
    if is_thorough:
        shares += product((*_SHARES, *_MORE_SHARES), _MORE_PHASES)
        shares += product(_MORE_SHARES, _PHASES)
    for index in near:
        own = [
            guess
            for order, shape in resonances[index]
            for guess in _guesses(model, order, shape, middle[index], shares)
        ]
        for step in range(-steps, steps + 1):
            guesses += own
            keys += [(index, step)] * len(own)
    _solve(model, motions, known, keys, guesses)
    # From the farthest speeds inwards: what exists at one of them begins the search at the next.
    for step in range(steps, 0, -1):
        pairs = [
            ((index, side * (step - 1)), q)
            for index in near
            for side in (-1, 1)
            for q in known.at((index, side * step))
        ]
        if pairs:
            _solve(model, motions, known, [key for key, _ in pairs], [q for _, q in pairs])
    return [
        Motions(fine, motions.index[[key[0]]], course, np.array([sign]))
        for key, fine, course, sign in known.found
        if key[1] == 0
    ]


def smallest(search: MotionSearch, speeds: Array) -> tuple[list[Motions], Array]:
    """Return the smallest motion that is found at each speed, and how many others there are `(S,)`.

    Args:
        search: of the scene; it keeps which speeds have none.
        speeds: `(S,)` [rad/s].
    """
    counts, chosen = np.zeros(len(speeds), dtype=int), []
    for motions in search.primary(speeds):
        others = coexisting(search, motions)
        sizes = dict(zip(motions.index.tolist(), _sizes(motions).tolist(), strict=True))
        better: dict[int, Motions] = {}
        for other in others:
            (index,), (size,) = other.index.tolist(), _sizes(other).tolist()
            counts[index] += 1
            if size < sizes[index]:
                sizes[index], better[index] = size, other
        chosen.append(motions.part(~np.isin(motions.index, list(better))))
        chosen += better.values()
    return [item for item in chosen if len(item.index)], counts


def _sizes(motions: Motions) -> Array:
    """Return how far motions go from their means `(S,)`."""
    q = motions.course.q
    return np.max(np.abs(q - np.mean(q, axis=1, keepdims=True)), axis=(1, 2))


def _solve(
    model: ReducedModel,
    motions: Motions,
    known: _Known,
    keys: list[tuple[int, int]],
    guesses: list[Array],
) -> None:
    """Add what guesses `(N, n)` lead to at the speeds of keys to what is known there."""
    count = max(model.count, *(len(guess) for guess in guesses))
    speed = np.array([motions.course.speed[index] * _ratio(step) for index, step in keys])
    stacked = np.array([resampled(guess, count) for guess in guesses])
    rough = solved(model.on(count), speed, stacked)
    # Many guesses lead to the same motion, of which one is resolved.
    first = _Known(model.half)
    first.add(keys, [(model, np.arange(len(keys)), rough)])
    if first.found:
        chosen = [key for key, *_ in first.found]
        q = np.concatenate([course.q for _, _, course, _ in first.found])
        places = np.concatenate([course.speed for _, _, course, _ in first.found])
        known.add(chosen, resolved(model, places, q))


def _ratio(step: int) -> float:
    """Return the ratio of a neighbouring speed, by its number from the speed itself."""
    return 1.0 + float(np.sign(step)) * _AROUND[-abs(step)] if step else 1.0


def _guesses(
    model: ReducedModel,
    order: int,
    shape: Array,
    middle: Array,
    shares: list[tuple[float, float]],
) -> list[Array]:
    """Return guesses `(N, n)` that swing in a mode at an order, of given sizes and phases."""
    phase = order * 2.0 * np.pi / model.period * model.positions
    scaled = shape / np.max(np.abs(shape) / model.half)
    return [
        middle + share * (np.exp(1j * (phase + 2.0 * np.pi * turn))[:, None] * scaled).real
        for share, turn in shares
    ]


def _resonances(motions: Motions) -> list[list[tuple[int, Array]]]:
    """Return for each motion the orders and mode shapes that are near a forced resonance."""
    equation = motions.model.equation(motions.course)
    found = modes(
        *(np.mean(item, axis=1) for item in (equation.mass, equation.damping, equation.stiffness))
    )
    base = np.abs(motions.course.speed) * 2.0 * np.pi / motions.model.period
    ratio = found.frequency / base[:, None]
    orders = np.rint(ratio)
    near = (orders >= 1) & (orders <= _MOST_ORDER)
    near &= np.abs(ratio - orders) <= _WINDOW * np.maximum(orders, 1.0)
    return [
        [
            (int(orders[index, mode]), found.shape[index, :, mode])
            for mode in np.nonzero(near[index])[0]
        ]
        for index in range(len(ratio))
    ]


def _gap(first: Array, second: Array, half: Array) -> float:
    """Return the greatest difference of two motions `(N, n)`, which may differ in their nodes."""
    count = max(len(first), len(second))
    return float(np.max(np.abs(resampled(first, count) - resampled(second, count)) / half))
