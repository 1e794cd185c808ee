"""Restitution: of contacts whose damper grows with their spring's force, and of linear ones.

A contact of the force F = k δⁿ (1 + h δ̇ / v₀), touched by a free mass at the speed v₀, sends it
back at e v₀ with h (1 + e) = ln[(1 + h) / (1 - h e)], whatever its mass, k and n.
"""

from __future__ import annotations

import math

_SERIES_BELOW = 0.25
"""Arguments below which a series takes the place of a difference that loses digits."""
_TERMS = 40
"""Of either series: the last is below rounding there."""
_MOST_STEPS = 100
"""Of Newton's method on convex functions, which takes some ten at most."""


def restitution_of_loss(loss: float) -> float:
    """Return e of a loss factor h.

    Args:
        loss: h, not negative.

    Returns:
        Between 0, which is not reached, and 1, to a few units of rounding.

    Source:
        Energy of a free impact: m v dv / dδ = -k δⁿ (1 + h v / v₀), integrated from v₀ to -e v₀.
    """
    # With y = ln(1 - h e) the condition is h - ln(1 + h) = exp(y) - 1 - y: convex in y, and the
    # start is on the side from which Newton's method does not overshoot.
    wanted = _less_logarithm(loss)
    if wanted == 0.0:
        return 1.0
    y = -(math.sqrt(2.0 * wanted) + wanted)
    for _ in range(_MOST_STEPS):
        change = (_exponential_rest(y) - wanted) / math.expm1(y)
        y -= change
        if abs(change) <= 1e-16 * abs(y):
            break
    return min(-math.expm1(y) / loss, 1.0)


def loss_of_restitution(restitution: float) -> float:
    """Return the loss factor h with which a restitution is met exactly.

    Args:
        restitution: e, above 0 and up to 1.

    Returns:
        From 0 at e = 1 on; about 1 / e where e is small.

    Source:
        As `restitution_of_loss`.
    """
    from scipy.optimize import brentq

    e = restitution
    if e >= 1.0:
        return 0.0

    def difference(y: float) -> float:
        if y == 0.0:
            return 0.5 * (1.0 - e) * (1.0 + e) / e**2
        # Over y², so that the root y = 0 of any restitution is left out.
        return (_less_logarithm(-math.expm1(y) / e) - _exponential_rest(y)) / y**2

    lowest = -2.0 * (1.0 + 1.0 / e)
    return -math.expm1(brentq(difference, lowest, 0.0, xtol=1e-300, rtol=1e-15)) / e


def restitution_of_damping_ratio(ratio: float) -> float:
    """Return e of a spring beside a damper which part where their force vanishes.

    Args:
        ratio: ζ = d / (2 √(c m)), not negative.

    Returns:
        exp(-2 ζ arccos(ζ) / √(1 - ζ²)), continued beyond ζ = 1.

    Source:
        The force c δ + d δ̇ of δ = sin(√(1 - ζ²) ω t) exp(-ζ ω t) vanishes at √(1 - ζ²) ω t =
        2 arccos ζ.
    """
    root = math.sqrt(abs(1.0 - ratio) * (1.0 + ratio))
    if root == 0.0:
        return math.exp(-2.0 * ratio)
    angle = math.atan2(root, ratio) if ratio < 1.0 else math.asinh(root)
    return math.exp(-2.0 * ratio * angle / root)


def _less_logarithm(x: float) -> float:
    """Return x - ln(1 + x)."""
    if abs(x) > _SERIES_BELOW:
        return x - math.log1p(x)
    total = 0.0
    for k in range(_TERMS, 1, -1):
        total = 1.0 / k - x * total
    return x * x * total


def _exponential_rest(y: float) -> float:
    """Return exp(y) - 1 - y."""
    if abs(y) > _SERIES_BELOW:
        return math.expm1(y) - y
    total = 1.0
    for k in range(_TERMS, 2, -1):
        total = 1.0 + y / k * total
    return 0.5 * y * y * total
