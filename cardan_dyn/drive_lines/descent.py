"""Descent: a local minimum of the greatest of many smooth values.

The greatest value has kinks where two of them are equal, and its minima mostly lie there.
Sequential quadratic programming minimises a bound on all values instead, and sees no kinks.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array

_NEAR = 0.9
"""Bounds are laid on values above this fraction of the greatest, and on more of them after each
round: others cannot become the greatest within a step."""
_ROUNDS = 12
_REACH = 0.2
"""Greatest change of a variable in a round, a fraction of what makes values rise and fall again."""
_DIFFERENCE = 1e-6
"""Step of central differences: values are accurate to some 1e-14."""
_STILL = 1e-12
"""Gain of a round, relative to the value, below which it is rounding."""


def descended(
    values: Callable[[Array], Array], start: Array, low: Array, high: Array
) -> tuple[Array, float]:
    """Return where the greatest value is least near a start, and that value.

    Args:
        values: variables `(c, m)` of c candidates to values `(c, q)`, none negative. Variables are
            of the order 1, like angles.
        start: `(m,)` variables.
        low: `(m,)` their lower limits.
        high: `(m,)` their upper limits.
    """
    best, of_best = np.array(start), values(start[None])[0]
    chosen, reach = np.zeros(0, dtype=np.int64), _REACH
    for _ in range(_ROUNDS):
        least = float(of_best.max())
        if least <= np.finfo(float).tiny:
            break
        chosen = np.union1d(chosen, np.flatnonzero(of_best >= _NEAR * least))
        limits = np.maximum(best - reach, low), np.minimum(best + reach, high)
        found = _bounded(values, best, chosen, least, limits)
        of_found = values(found[None])[0]
        gain = least - float(of_found.max())
        if gain > 0.0:
            best, of_best = found, of_found
        if gain <= _STILL * least:
            # Either values without a bound have stopped it, or nothing but rounding is left.
            more = np.union1d(chosen, np.flatnonzero(of_found >= _NEAR * of_found.max()))
            if len(more) == len(chosen) and gain >= 0.0:
                break
            chosen, reach = more, reach / 4.0
    return best, float(of_best.max())


def _bounded(
    values: Callable[[Array], Array],
    start: Array,
    chosen: Array,
    scale: float,
    limits: tuple[Array, Array],
) -> Array:
    """Return the variables with the least bound on chosen values, within limits."""
    from scipy.optimize import minimize  # Imported here: only searches need it.

    low, high = limits

    def margins(x: Array) -> Array:
        return np.asarray(x[-1] - values(x[None, :-1])[0, chosen] / scale)

    def slopes(x: Array) -> Array:
        steps = _DIFFERENCE * np.eye(len(start))
        ahead, behind = np.minimum(x[:-1] + steps, high), np.maximum(x[:-1] - steps, low)
        both = values(np.concatenate([ahead, behind]))[:, chosen] / scale
        rise = both[: len(start)] - both[len(start) :]
        return np.column_stack([-(rise.T / np.sum(ahead - behind, axis=1)), np.ones(len(chosen))])

    result = minimize(
        lambda x: x[-1],
        np.append(start, 1.0),
        jac=lambda x: np.append(np.zeros(len(x) - 1), 1.0),
        bounds=[*zip(low, high, strict=True), (0.0, None)],
        constraints={"type": "ineq", "fun": margins, "jac": slopes},
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 60},
    )
    return np.clip(result.x[:-1], low, high)
