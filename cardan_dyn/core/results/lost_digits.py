"""Lost digits: how much of the greatest wrenches is rounding, by the condition where they are.

Where wrenches vanish their condition number is great as well, and means nothing.
"""

from __future__ import annotations

import numpy as np

from ...kit.arrays import EPS, Array

WELL = 1e6
"""Condition number of the greatest wrenches up to which nothing has to be said: ten digits are
right."""
_MOST_DIGITS = 15


def lost_part(condition: Array, sizes: Array) -> float:
    """Return rounding of the greatest size as a part of it; infinite if that is not known.

    Args:
        condition: `(N,)` or `(1,)` of wrenches; NaN where they are not known.
        sizes: `(N,)` of wrenches, of any unit.
    """
    most = float(np.nanmax(sizes, initial=0.0))
    known = np.where(np.isnan(condition), np.inf, condition)
    lost = np.multiply(known, sizes, out=np.zeros_like(sizes), where=sizes > 0.0)
    return EPS * float(np.max(lost, initial=0.0)) / most if most else 0.0


def digits(part: float) -> int:
    """Return how many digits are right where a part is rounding."""
    return int(np.clip(-np.log10(max(part, EPS)), 0, _MOST_DIGITS))


def right(part: float) -> str:
    """Return the same in words."""
    return f"some {digits(part)} digits of the greatest wrenches are right"


def near_singular(part: float) -> str:
    """Return in words that wrenches grow without limit close by; empty if they do not."""
    is_near = part > WELL * EPS
    told = "close to a singular configuration, or loops nearly depend on each other"
    return f"{told}: {right(part)}" if is_near else ""
