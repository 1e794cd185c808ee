"""Coexisting motions: further periodic motions at the same speed, near forced resonances.

Where a motion is large, its range is searched from guesses of many amplitudes and phases along the
modes that resonate. A thorough search does so at neighbouring speeds as well, and follows what it
finds there to the speed that was asked for, step by step.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from ...arrays import Array
from ..model.build import ROUGH
from ..model.modes import averaged, modes
from ..model.periodic_grid import next_size, resampled
from ..model.reduced_model import ReducedModel
from .harmonic_balance import ROUGHLY, solved
from .linear import linear_motions
from .search import Motions, MotionSearch

_WINDOW = 0.2
"""Relative distance from a forced resonance within which other motions are searched."""
_MOST_ORDER = 12
_MULTIPLES, _NODES = 8, 9
"""Nodes of a search, by the order of the resonance: a multiple of it, and some."""
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
_ROUGHLY_SAME = 1e-3
"""The same where models are rough."""
_Key = tuple[int, int]
"""Index of a speed, and number of a neighbouring one from the speed itself."""


class _Known:
    """Motions at some speeds, without repetitions."""

    def __init__(self, half: Array, same: float) -> None:
        self._half, self._same = half, same
        self._of: dict[_Key, list[tuple[Array, float]]] = {}

    def at(self, key: _Key) -> list[tuple[Array, float]]:
        """Return the motions `(N, n)` at a speed, with their signs."""
        return self._of.setdefault(key, [])

    def gap(self, first: Array, second: Array) -> float:
        """Return the greatest difference of two motions, as a fraction of the range."""
        return _gap(first, second, self._half)

    def add(self, key: _Key, q: Array, sign: float) -> bool:
        """Add a motion, and return whether it is new. Those of other signs are others."""
        is_new = all(
            sign != other or self.gap(q, known) > self._same for known, other in self.at(key)
        )
        if is_new:
            self.at(key).append((q, sign))
        return is_new


def coexisting(
    search: MotionSearch, motions: Motions, *, is_thorough: bool = False
) -> list[Motions]:
    """Return further motions at the same speeds, near forced resonances.

    Args:
        search: that found the motions.
        motions: one for each speed.
        is_thorough: whether neighbouring speeds and the widest range are searched as well. Without,
            they are where what was found cannot be all, since motions come in pairs of opposite
            signs.
    """
    middle = np.mean(motions.course.q, axis=1)
    size = _sizes(motions, search.rotating.units)
    linear, _ = linear_motions(motions)
    bent = np.max(np.abs(linear - motions.course.q) / search.rotating.units, axis=(1, 2))
    # Where the linear equation gives the same motion, nothing bends its resonance back.
    size = np.where(bent > _BENT * size, size, 0.0)
    resonances = _resonances(motions)
    # A motion of sign -1 is never alone.
    is_large = (size > _LARGE) | (motions.sign < 0.0)
    near = [index for index in range(len(size)) if is_large[index] and resonances[index]]
    if not near:
        return []
    centre = np.mean(middle[near], axis=0)
    rough = search.widest(centre, _SPREAD * float(np.max(size[near])), ROUGH)
    known = _Known(rough.half, _ROUGHLY_SAME)
    for index in near:
        known.add((index, 0), motions.course.q[index], float(motions.sign[index]))
    _search(rough, motions, resonances, near, known, is_thorough)
    again = near
    if not is_thorough:
        again = [index for index in near if sum(sign for _, sign in known.at((index, 0))) != 1.0]
        if again:
            _search(rough, motions, resonances, again, known, is_thorough=True)
    if again:
        wide = search.widest(centre, search.max_amplitude, ROUGH)
        if np.any(wide.half > rough.half):
            _search(wide, motions, resonances, again, known, is_thorough=True)
    return _refined(search, motions, [(index, known.at((index, 0))[1:]) for index in near])


def _search(
    rough: ReducedModel,
    motions: Motions,
    resonances: list[list[tuple[int, Array]]],
    near: list[int],
    known: _Known,
    is_thorough: bool,
) -> None:
    """Add what guesses lead to in a rough model.

    Args:
        rough: a wide model.
        motions: one for each speed.
        resonances: of each, see `_resonances`.
        near: indices of the motions beside which others are searched.
        known: what was found; others are added.
        is_thorough: whether neighbouring speeds are searched as well.
    """
    steps = len(_AROUND) if is_thorough else 0
    shares = list(product(_SHARES, _PHASES))
    if is_thorough:
        shares += product((*_SHARES, *_MORE_SHARES), _MORE_PHASES)
        shares += product(_MORE_SHARES, _PHASES)
    keys: list[_Key] = []
    guesses: list[Array] = []
    for index in near:
        # Motions near a resonance have multiples of its order.
        orders = max(order for order, _ in resonances[index])
        model = rough.on(max(rough.count, next_size(_MULTIPLES * orders + _NODES)))
        middle = np.mean(motions.course.q[index], axis=0)
        own = [
            guess
            for order, shape in resonances[index]
            for guess in _guesses(model, order, shape, middle, shares)
        ]
        for step in range(-steps, steps + 1):
            guesses += own
            keys += [(index, step)] * len(own)
    _solve(rough, motions, known, keys, guesses)
    # From the farthest speeds inwards: what exists at one of them begins the search at the next.
    for step in range(steps, 0, -1):
        pairs = [
            ((index, side * (step - 1)), q)
            for index in near
            for side in (-1, 1)
            for q, _ in known.at((index, side * step))
        ]
        _solve(rough, motions, known, [key for key, _ in pairs], [q for _, q in pairs])


def _solve(
    rough: ReducedModel, motions: Motions, known: _Known, keys: list[_Key], guesses: list[Array]
) -> None:
    """Add what guesses `(N, n)` lead to at the speeds of keys to what is known there."""
    counts = np.array([len(guess) for guess in guesses])
    for count in np.unique(counts).tolist():
        index = np.nonzero(counts == count)[0].tolist()
        speed = np.array([motions.course.speed[keys[i][0]] * _ratio(keys[i][1]) for i in index])
        found = solved(rough.on(count), speed, np.stack([guesses[i] for i in index]), ROUGHLY)
        for item in np.nonzero(found.converged)[0].tolist():
            known.add(keys[index[item]], found.course.q[item], float(found.sign[item]))


def _refined(
    search: MotionSearch, motions: Motions, rough: list[tuple[int, list[tuple[Array, float]]]]
) -> list[Motions]:
    """Return those of rough motions, of each index, that are motions and not yet known."""
    known = _Known(search.rotating.units, _SAME)
    result: list[Motions] = []

    def add(items: list[tuple[int, Array]]) -> None:
        if not items:
            return
        count = max(len(q) for _, q in items)
        found = search.refined(
            motions.course.speed,
            np.array([index for index, _ in items]),
            np.stack([resampled(q, count) for _, q in items]),
        )
        for group in found:
            for item, index in enumerate(group.index.tolist()):
                if known.add((index, 0), group.course.q[item], float(group.sign[item])):
                    one = group.part(slice(item, item + 1))
                    result.append(replace(one, index=motions.index[[index]]))

    for index, _ in rough:
        known.add((index, 0), motions.course.q[index], float(motions.sign[index]))
    add([(index, q) for index, every in rough for q, _ in every])
    # Near a fold, both of a close pair may lead to one of them: the other is as far from it as
    # they are from each other.
    add([(i, q) for i, every in rough for q in _others(known.at((i, 0)), every, known)])
    return result


def _others(
    fine: list[tuple[Array, float]], rough: list[tuple[Array, float]], known: _Known
) -> list[Array]:
    """Return guesses of those of rough motions that are missing among fine ones, by their pairs."""
    guesses = []
    for sign in (1.0, -1.0):
        mine, others = ([q for q, of in rough if of == side] for side in (sign, -sign))
        pairs = [q for q, of in fine if of == -sign]
        if not others or not pairs or len(mine) <= sum(of == sign for _, of in fine):
            continue
        for q in mine:
            twin = min(others, key=lambda other: known.gap(q, other))
            pair = min(pairs, key=lambda other: known.gap(twin, other))
            count = max(len(item) for item in (q, twin, pair))
            own, beside, there = (resampled(item, count) for item in (q, twin, pair))
            guesses.append(there + own - beside)
    return guesses


def smallest(search: MotionSearch, speeds: Array) -> tuple[list[Motions], Array]:
    """Return the smallest motion that is found at each speed, and how many others there are `(S,)`.

    Args:
        search: of the scene; it keeps which speeds have none.
        speeds: `(S,)` [rad/s].
    """
    counts, chosen, units = np.zeros(len(speeds), dtype=int), [], search.rotating.units
    for motions in search.primary(speeds):
        others = coexisting(search, motions)
        sizes = dict(zip(motions.index.tolist(), _sizes(motions, units).tolist(), strict=True))
        better: dict[int, Motions] = {}
        for other in others:
            (index,), (size,) = other.index.tolist(), _sizes(other, units).tolist()
            counts[index] += 1
            if size < sizes[index]:
                sizes[index], better[index] = size, other
        chosen.append(motions.part(~np.isin(motions.index, list(better))))
        chosen += better.values()
    return [item for item in chosen if len(item.index)], counts


def _sizes(motions: Motions, units: Array) -> Array:
    """Return how far motions go from their means `(S,)`, in units of the coordinates `(n,)`."""
    q = motions.course.q
    return np.asarray(np.max(np.abs(q - np.mean(q, axis=1, keepdims=True)) / units, axis=(1, 2)))


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
    found = modes(*averaged(equation))
    base = np.abs(motions.course.speed) * 2.0 * np.pi / motions.model.period
    ratio = found.frequency / base[:, None]
    orders = np.rint(ratio)
    near = (orders >= 1) & (orders <= _MOST_ORDER)
    # What is about a motion of sign -1 says little of where the others have their resonance.
    window = np.where(motions.sign < 0.0, 1.0, _WINDOW)[:, None]
    near &= np.abs(ratio - orders) <= window * np.maximum(orders, 1.0)
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
