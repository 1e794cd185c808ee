"""Energy: work as the integral of power."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...kit.arrays import Array


def gained(power: Callable[[Array], Array], steps: Array, times: Array, is_nothing: bool) -> Array:
    """Return the work `(N,)` done between time 0 and some times.

    Args:
        power: at times `(K,)` [W].
        steps: times between which it is smooth `(S,)`, from 0.
        times: `(N,)` within them.
        is_nothing: whether there is no power.
    """
    if is_nothing:
        return np.zeros(len(times))
    indices = np.clip(np.searchsorted(steps, times, side="right") - 1, 0, max(len(steps) - 2, 0))
    starts = np.concatenate([steps[:-1], steps[indices]])
    ends = np.concatenate([steps[1:], times])
    # Exact for degree 15, while steps are interpolated by polynomials of degree 7.
    nodes, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * (ends - starts)
    is_long = half > 0.0  # Times that are ends of steps have nothing left.
    if not np.any(is_long):
        return np.zeros(len(times))
    points = starts[is_long, None] + half[is_long, None] * (1.0 + nodes)
    values = power(points.ravel()).reshape(points.shape)
    pieces = np.zeros(len(half))
    pieces[is_long] = half[is_long] * (values @ weights)
    whole = np.concatenate([[0.0], np.cumsum(pieces[: len(steps) - 1])])
    return np.asarray(whole[indices] + pieces[len(steps) - 1 :])
