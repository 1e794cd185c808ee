"""Differences: derivatives of functions of which only values are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .arrays import EPS, Array

_STEP = float(EPS**0.2)
"""Step, in units of a variable: its fourth power, the error of the formula, is then as great as
rounding by the step."""
_ROUNDED = 4.0 * EPS
"""Rounding of what some ten operations lead to, beside it."""


def displacements(units: Array) -> Array:
    """Return displacements `(4 n, n)` of n variables at which `slopes` takes values.

    Args:
        units: `(n,)` of the variables, in which they change a function by about its own size.
    """
    steps = _STEP * np.array([-2.0, -1.0, 1.0, 2.0])
    return np.multiply.outer(steps, np.diag(units)).reshape(-1, len(units))


def slopes(values: Array, units: Array) -> Array:
    """Return derivatives `(…, n)` by n variables, by central differences of fourth order.

    Args:
        values: `(4 n, …)` at `displacements` from the place where derivatives are taken.
        units: `(n,)` of the variables.
    """
    far_back, back, ahead, far_ahead = values.reshape(4, len(units), *values.shape[1:])
    rise = 8.0 * (ahead - back) - (far_ahead - far_back)
    return rise.transpose(*range(1, rise.ndim), 0) / (12.0 * _STEP * units)


def kinks(values: Array, middle: Array, units: Array) -> Array:
    """Return what kinks add to derivatives `(…, n)`, in the place itself or beside it.

    Third and fourth differences, which smooth functions have of the third and fourth power of the
    step alone.

    Args:
        values: see `slopes`.
        middle: `(…)` at the place where derivatives are taken.
        units: `(n,)` of the variables.
    """
    far_back, back, ahead, far_ahead = values.reshape(4, len(units), *values.shape[1:]) - middle
    odd = np.abs(far_ahead - far_back - 2.0 * (ahead - back))
    even = np.abs(far_ahead + far_back - 4.0 * (ahead + back))
    most = np.maximum(odd, even)
    return most.transpose(*range(1, most.ndim), 0) / (12.0 * _STEP * units)


def slope(values: Callable[[Array], Array], variables: Array | float = 1.0) -> Array:
    """Return derivatives `(k, n)` by one variable at 0, by steps that suit each of them.

    Steps are halved as long as what rounds by finer ones is below how far two derivatives differ
    and what rounds in them. Those are taken of which both are least: near a kink, or where a number
    changes within less than a step, what is on this side of it.

    Args:
        values: returns k numbers of n samples at each of some places, `(len(places), k, n)`.
        variables: `(n,)` sizes of what these places are added to, which rounds as well.
    """
    step = _STEP
    middle, *ends = values(step * np.array([0.0, 2.0, -2.0, 1.0, -1.0, 0.5, -0.5]))
    size = np.abs(middle)
    far, near, nearer = (ahead - back for ahead, back in zip(ends[::2], ends[1::2], strict=True))
    found = best = (8.0 * near - far) / (12.0 * step)
    least, apart = np.full(found.shape, np.inf), np.zeros(found.shape)
    while True:
        step *= 0.5
        far, near = near, nearer
        before, found = found, (8.0 * near - far) / (12.0 * step)
        last, apart = apart, np.abs(found - before)
        # What rounds are the numbers and the variables.
        sizes = (size + variables * np.abs(found)).max(axis=-1, keepdims=True, initial=0.0)
        rounded = _ROUNDED * sizes / step
        # The formula's error falls to a sixteenth, but two may agree by chance.
        off = np.maximum(apart, last) / 15.0 + rounded
        best, least = np.where(off < least, found, best), np.minimum(off, least)
        if step <= np.sqrt(EPS) or np.all(least <= 2.0 * rounded):
            return np.asarray(best)
        ahead, back = values(step * np.array([0.5, -0.5]))
        nearer = ahead - back
