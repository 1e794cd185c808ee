"""Condensed: of the residuals of many samples, the few that decide what is said of all of them.

The residuals of a sweep are relative to its greatest wrench, which is known with the last sample.
Each sample's is a quotient that falls as this wrench grows; most are smaller than another sample's
however great it becomes, and need not be kept until then.
"""

from __future__ import annotations

import numpy as np

from ...kit.arrays import Array
from .residuals import CHECK_ROUNDING, Residuals


def condensed(residuals: Residuals) -> Residuals:
    """Return residuals of a few samples that say the same as those of all, beside any others.

    The same are `balance`, `power`, `rate` and the greatest loop error.

    Args:
        residuals: of N samples, all of them numbers.
    """
    scale = np.maximum(residuals.wrench, residuals.applied)
    greatest = float(np.max(scale))
    imbalance = residuals.imbalance + CHECK_ROUNDING * residuals.inertia
    # Of samples whose wrenches cancel, it may not be the greatest wrench that counts.
    cancelled = residuals.cancelled(greatest)
    flow = residuals.power_scale + (greatest + residuals.inertia) * residuals.speed_scale
    others = np.nonzero(~cancelled & (residuals.power_imbalance > 0.0))[0]
    power = residuals.of_samples(others)
    quotients = power.power_scale, power.speed_scale, power.power_imbalance
    kept = [
        np.nonzero(cancelled & ((imbalance > 0.0) | (residuals.power_imbalance > 0.0)))[0],
        others[_greatest_quotients(*quotients, greatest)],
    ]
    each = (
        *(residuals.loop_error, residuals.rate_error, scale, residuals.inertia, flow),
        np.where(cancelled, 0.0, imbalance),
    )
    kept.append(np.array([int(np.argmax(values)) for values in each]))
    return residuals.of_samples(np.array(sorted(set(np.concatenate(kept).tolist()))))


def _greatest_quotients(offset: Array, slope: Array, error: Array, first: float) -> Array:
    """Return which of N quotients error / (offset + g slope) are the greatest for some g ≥ first.

    Their inverses are straight lines, offset / error + g slope / error: those on the lower side of
    all of them are found one after the other, each where it crosses the one before. Errors are
    positive. Of rounding, some ten are.
    """
    if not len(error):
        return np.zeros(0, dtype=int)
    with np.errstate(all="ignore"):
        at, rise = offset / error, slope / error
    rest = np.arange(len(error))
    lowest = int(np.lexsort((rise, at + first * rise))[0])
    found = [lowest]
    while (rest := rest[rise[rest] < rise[lowest]]).size:
        with np.errstate(all="ignore"):
            crossing = (at[rest] - at[lowest]) / (rise[lowest] - rise[rest])
        lowest = int(rest[np.lexsort((rise[rest], crossing))[0]])
        found.append(lowest)
    return np.array(found)
