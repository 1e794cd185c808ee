"""Extremes: where functions are greatest, between the places at which they are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .arrays import ROUNDED, Array
from .periodic import amplitudes, sampled
from .roots import rising

_FINER = 4
"""Times as many positions as samples between which a greatest value is looked for. Samples that
decide a function have the harmonics that matter far below the highest one that they can have."""


def turns(at: Array, values: Array, rates: Array) -> tuple[Array, Array]:
    """Return where functions turn between samples, or the first of two, and what they are there.

    By cubics through values and rates, where the rates' chord is zero: since functions are flat
    there, their error is of fourth order in the distance of the samples.

    Args:
        at: places `(N,)` of the samples.
        values: `(N, …)`.
        rates: derivatives by the place, `(N, …)`.

    Returns:
        Places and values, `(N - 1, …)`.
    """
    first, step = (item.reshape(-1, *[1] * (values.ndim - 1)) for item in (at[:-1], np.diff(at)))
    before, after = rates[:-1], rates[1:]
    is_turn = before * after < 0.0
    part = np.where(is_turn, before / np.where(is_turn, before - after, 1.0), 0.0)
    left = 1.0 - part
    found = left**2 * ((1.0 + 2.0 * part) * values[:-1] + step * part * before)
    found += part**2 * ((1.0 + 2.0 * left) * values[1:] - step * left * after)
    return np.asarray(first + part * step), found


def greatest(values: Array) -> tuple[Array, Array]:
    """Return the greatest values `(k,)` of smooth functions, to rounding, and where; 0 of none.

    Args:
        values: `(P, k)` the functions at equal steps of a period, which determine them.

    Returns:
        Values, and places from 0 to 1, the period.
    """
    count, columns = values.shape
    if not values.size:
        return np.zeros(columns), np.zeros(columns)
    waves = amplitudes(values)
    factors = 2j * np.pi * np.arange(len(waves))[:, None]
    fine = np.arange(_FINER * count + 1) / (_FINER * count)
    known, rates = (
        np.concatenate([item, item[:1]])
        for item in (sampled(waves, _FINER * count), sampled(factors * waves, _FINER * count))
    )
    places, tops = turns(fine, known, rates)
    best, top = values.argmax(axis=0), values.max(axis=0)
    (index,) = np.nonzero(np.ptp(values, axis=0))
    low = tops[:, index].argmax(axis=0)

    def turned(at: Array, chosen: Array) -> Array:
        return np.asarray(waves[:, chosen] * np.exp(factors * at))

    def falling(at: Array, chosen: Array) -> tuple[Array, Array]:
        there = factors * turned(at, index[chosen])
        return -there.real.sum(axis=0), -(factors * there).real.sum(axis=0)

    at = rising(falling, fine[low], fine[low + 1], first=places[low, index])
    reached = turned(at, index).real.sum(axis=0)
    place = best / count
    place[index] = np.where(reached > top[index], at, place[index])
    top[index] = np.maximum(reached, top[index])
    return top, place


def peak(
    function: Callable[[float], float],
    low: float,
    high: float,
    known: tuple[float, float] = (np.nan, -np.inf),
) -> tuple[float, float]:
    """Return where a function is greatest that has one peak between two places, and its value.

    The place to the root of rounding, as a part of the distance: within it the function is flat.

    Args:
        function: of a place.
        low: place.
        high: place, which may as well be the lower one.
        known: a place and the value there, which are returned if nothing greater is found.
    """
    from scipy.optimize import minimize_scalar  # Few scripts need it.

    def fallen(part: float) -> float:
        return -function(low + float(part) * (high - low))

    options = {"xatol": float(np.sqrt(ROUNDED))}
    found = minimize_scalar(fallen, bounds=(0.0, 1.0), method="bounded", options=options)
    at = low + float(found.x) * (high - low), -float(found.fun)
    return at if at[1] > known[1] else known
