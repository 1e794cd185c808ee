"""Roots: where functions pass through zero, each between two places, to rounding."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .arrays import EPS, Array
from .errors import AccuracyError

_STALLED = 8.0
"""Steps towards a root, in rounding of its place, of which a second one means that values are
nothing but rounding."""
_MOST_STEPS = 200
"""Steps after which a root must have been found: some 60 halvings are the most that it takes."""
_HALVINGS = 40
"""Of an interval, at which a function that starts at zero is looked at before it has fallen."""


def zero(value: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function falls to zero between two places, or `low` if it never rose.

    Args:
        value: positive at `low`, or soon after it; not positive at `high`, but for rounding.
        low: place.
        high: place.
    """
    from scipy.optimize import brentq  # Few scripts need it.

    if value(low) <= 0.0:
        # It may have risen for less than the way between them.
        nearer = (low + (high - low) * 0.5**k for k in range(1, _HALVINGS))
        risen = next((place for place in nearer if value(place) > 0.0), None)
        if risen is None:
            return low
        low = risen
    if value(high) > 0.0:
        return high
    return float(brentq(value, low, high, xtol=1e-300, rtol=4.0 * EPS))


def zeros(
    look: Callable[[Array, Array], Array], ends: tuple[Array, Array], values: tuple[Array, Array]
) -> Array:
    """Return where functions pass through zero between times, to rounding.

    Args:
        look: returns values at times, of the functions with some indices.
        ends: times `(N,)` between which they do.
        values: at them.

    Source: Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a
    nonlinear function without using derivatives, Adv. Eng. Software 28 (1997).
    """
    found = np.empty(len(ends[0]))
    (a, b), (at_a, at_b) = ends, values
    part, active = np.full(len(a), 0.5), np.arange(len(a))
    while active.size:
        new = a + part * (b - a)
        value = look(new, active)
        same = np.sign(value) == np.sign(at_a)
        # The last of them is a, the bracket from a to b, and c was left out of it.
        c, at_c = np.where(same, a, b), np.where(same, at_a, at_b)
        b, at_b = np.where(same, b, a), np.where(same, at_b, at_a)
        a, at_a = new, value
        best = np.where(np.abs(at_a) <= np.abs(at_b), a, b)
        least = 2.0 * np.spacing(np.abs(best))
        width = np.abs(b - a)
        is_found = (width <= 2.0 * least) | (at_a == 0.0) | (at_b == 0.0)
        found[active[is_found]] = best[is_found]
        kept = ~is_found
        active, least, width = active[kept], least[kept], width[kept]
        a, b, c, at_a, at_b, at_c = (item[kept] for item in (a, b, c, at_a, at_b, at_c))
        place, height = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
        is_smooth = (height**2 < place) & ((1.0 - height) ** 2 < 1.0 - place)
        part = np.full(len(a), 0.5)
        one, two, three = (item[is_smooth] for item in (at_a, at_b, at_c))
        ratio = ((c - a) / (b - a))[is_smooth]
        part[is_smooth] = one / (two - one) * three / (two - three) + ratio * one / (
            three - one
        ) * two / (three - two)
        part = np.clip(part, least / width, 1.0 - least / width)
    return found


def rising(
    function: Callable[[Array, Array], tuple[Array, Array]],
    low: Array,
    high: Array,
    *,
    first: Array | None = None,
    least: float = 1e-20,
    none: Array | float = 0.0,
) -> Array:
    """Return where functions rise through zero, each between two places `(N,)`.

    By Newton's method, halving the bracket wherever a step would leave it or gains too little.

    Args:
        function: returns values and slopes at places, of the functions with some indices.
        low: places at which they are not positive.
        high: places at which they are not negative.
        first: places to begin with `(N,)`; the middles if None.
        least: difference of places that counts as none, beside rounding.
        none: value that counts as zero, for all or each `(N,)`.

    Raises:
        AccuracyError: a function is not finite somewhere between.
    """
    low, high = low.copy(), high.copy()
    places, steps = (0.5 * (low + high) if first is None else first), high - low
    active, none = np.arange(len(low)), np.broadcast_to(none, low.shape)
    eps = 2.0 * EPS
    for _ in range(_MOST_STEPS):
        if not active.size:
            return places
        there = places[active]
        values, slopes = function(there, active)
        if not np.all(np.isfinite(values)):
            break
        below = values < 0.0
        low[active] = np.where(below, there, low[active])
        high[active] = np.where(below, high[active], there)
        with np.errstate(divide="ignore", invalid="ignore"):
            # Roots at an end are stepped over by rounding.
            after = there - values / slopes
            after = np.minimum(np.maximum(after, low[active]), high[active])
            step = np.abs(after - there)
            good = (step > 0.0) & (step <= 0.5 * np.abs(steps[active]))
        middle = 0.5 * (low[active] + high[active])
        # Two steps of rounding one after the other lead nowhere, however wide the bracket is.
        close = _STALLED * (least + eps * np.abs(there))
        stalls = (np.abs(values) <= close * slopes) & (np.abs(steps[active]) <= close)
        good |= stalls
        is_found = np.abs(values) <= none[active]
        after = np.where(is_found, there, np.where(good, after, middle))
        steps[active] = after - there
        places[active] = after
        is_done = np.abs(after - there) <= least + eps * np.abs(after)
        active = active[~(is_done | stalls)]
    raise AccuracyError(
        f"{active.size} of {len(low)} zeros were not found within {_MOST_STEPS} steps",
        residual=float(np.max(np.abs(steps[active]))),
    )
