"""Harmonic balance: periodic motions of a reduced model, by collocation and Newton's method.

The motion is a Fourier sum with as many orders as the nodes of a period carry; the efforts vanish
at all nodes. Many speeds and guesses are solved together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ....kit.periodic import MOST_NODES, TAIL, derivatives, next_size, resampled, tail
from ..model.reduced_model import Course, LocalEquation, ReducedModel

_MOST_STEPS = 30
CONVERGED = 1e-12
"""Step, as a fraction of the range, at which Newton's method has converged quadratically: the next
one would be rounding."""
ROUGHLY = 1e-6
"""The same in a rough model, whose motions are refined."""
_QUADRATIC, _NEXT = 1e-6, 1e-2
"""Step from which on the next one is foretold, and how long that may be, as a fraction of the step
at which Newton's method has converged."""
_SINGULAR_STEPS = 8
"""Steps after which motions without effort that still move are those of a singular Jacobian: the
singular values that count are..."""
_RANK = 1e-12
"""...greater than this share of the greatest."""
_LONGEST = 0.25
"""Longest step, as a fraction of the half range."""
_BEYOND = 1.02
"""Way from the middle, in half ranges, beyond which a motion has left the model."""
_NUMBERS = 2_000_000
"""Numbers (16 MB) of Jacobians that are solved at a time."""
_CUT = 1e3
"""Multiple of what is rounding, of the highest orders, from which on a motion lacks some."""
_ROUGH = 3e-13
"""Amplitude of the highest orders, in half ranges, that is rounding of the range."""


class Found(NamedTuple):
    """What Newton's method found from S guesses.

    Attributes:
        course: the motions.
        converged: `(S,)` whether they are solutions within the ranges of the model.
        sign: `(S,)` sign of the Jacobian's determinant, 0 where it is singular.
    """

    course: Course
    converged: Array
    sign: Array

    def part(self, chosen: Array | slice) -> Found:
        """Return some of it, by a mask or a slice."""
        course = Course(*(item[chosen] for item in self.course))
        return Found(course, self.converged[chosen], self.sign[chosen])


def course_of(q: Array, speed: Array, period: float) -> Course:
    """Return motions from their positions `(S, N, n)` at the nodes of a period."""
    first, second = derivatives(q.shape[1], period)
    return Course(q, first @ q, second @ q, speed)


def jacobian(equation: LocalEquation, speed: Array, period: float) -> Array:
    """Return derivatives `(S, n N, n N)` of the efforts at all nodes by positions at all nodes.

    Rows and columns go through the nodes of the first coordinate, then through those of the second.
    """
    size, count, free = equation.efforts.shape
    first, second = derivatives(count, period)
    mass, damping, stiffness = (
        item.transpose(0, 2, 3, 1) for item in (equation.mass, equation.damping, equation.stiffness)
    )
    rate = speed[:, None, None, None, None]
    matrix = np.empty((size, free, count, free, count))
    blocks, own = matrix.swapaxes(2, 3), np.arange(count)
    np.multiply(rate**2 * mass[..., None], second, out=blocks)
    blocks += rate * damping[..., None] * first
    blocks[..., own, own] += stiffness
    return matrix.reshape(size, free * count, free * count)


def newton_steps(matrix: Array, efforts: Array) -> Array:
    """Return the changes of positions `(S, N, n)` that take away efforts, by a Jacobian.

    They are not finite where it is singular.

    Args:
        matrix: see `jacobian`.
        efforts: `(S, N, n)`.
    """
    size, count, free = efforts.shape
    sides = -np.swapaxes(efforts, 1, 2).reshape(size, free * count, 1)
    try:
        steps = np.linalg.solve(matrix, sides)
    except np.linalg.LinAlgError:
        steps = np.full(sides.shape, np.nan)
        for index, (one, side) in enumerate(zip(matrix, sides, strict=True)):
            try:
                steps[index] = np.linalg.solve(one, side)
            except np.linalg.LinAlgError:
                continue
    return np.asarray(np.swapaxes(steps.reshape(size, free, count), 1, 2))


def _least_step(matrix: Array, efforts: Array, half: Array) -> Array:
    """Return the least change of positions `(N, n)` that takes away efforts, in ranges.

    Args:
        matrix: `(K, K)`, of a Jacobian that may be singular.
        efforts: `(N, n)`.
        half: half widths of the ranges `(n,)`.
    """
    count, free = efforts.shape
    units = np.repeat(half, count)
    rows = np.max(np.abs(matrix * units), axis=1, keepdims=True)
    rows[rows == 0.0] = 1.0
    if not np.all(np.isfinite(rows)) or not np.all(np.isfinite(efforts)):
        return np.full_like(efforts, np.nan)
    sides = -efforts.T.reshape(-1, 1) / rows
    step = np.linalg.lstsq(matrix * units / rows, sides, rcond=_RANK)[0][:, 0] * units
    return np.asarray(step.reshape(free, count).T)


def solved(model: ReducedModel, speed: Array, guess: Array, converged: float = CONVERGED) -> Found:
    """Return motions near guesses.

    Args:
        model: on the nodes of the guesses.
        speed: of the drive `(S,)` [rad/s].
        guess: `(S, N, n)`.
        converged: step, as a fraction of the range, after which no other follows.
    """
    count, free = guess.shape[1:]
    each = max(1, _NUMBERS // (count * free) ** 2)
    parts = [
        _solved(model, speed[first : first + each], guess[first : first + each], converged)
        for first in range(0, max(len(speed), 1), each)
    ]
    course = Course(
        *(np.concatenate(items) for items in zip(*(p.course for p in parts), strict=True))
    )
    return Found(
        course,
        np.concatenate([part.converged for part in parts]),
        np.concatenate([part.sign for part in parts]),
    )


def _solved(model: ReducedModel, speed: Array, guess: Array, threshold: float) -> Found:
    size = len(guess)
    q, sign = guess.copy(), np.zeros(size)
    converged, active = np.zeros(size, dtype=bool), np.ones(size, dtype=bool)
    before = np.full(size, np.inf)
    for count in range(_MOST_STEPS):
        index = np.nonzero(active)[0]
        if not index.size:
            break
        course = course_of(q[index], speed[index], model.period)
        equation = model.equation(course)
        matrix = jacobian(equation, speed[index], model.period)
        step = newton_steps(matrix, equation.efforts)
        length = np.max(np.abs(step / model.half), axis=(1, 2))
        if count >= _SINGULAR_STEPS:
            # Along what nothing holds rounding decides: there the motion stays where it is.
            left = np.max(np.max(np.abs(equation.efforts), axis=1) / equation.scale, axis=1)
            for item in np.nonzero((left <= ROUNDED) & ~(length <= threshold))[0]:
                step[item] = _least_step(matrix[item], equation.efforts[item], model.half)
                length[item] = np.max(np.abs(step[item] / model.half))
        bad = ~np.isfinite(length)
        factor = _LONGEST / np.where(bad, 1.0, np.maximum(length, _LONGEST))
        step[bad] = 0.0
        q[index] += np.where(bad, 0.0, factor)[:, None, None] * step
        way = np.max(np.abs((q[index] - model.centre) / model.half), axis=(1, 2))
        gone = bad | (way > 3.0)
        # Steps that shrink by their squares tell how long the next one is.
        with np.errstate(over="ignore", invalid="ignore"):
            following = length * (length / before[index]) ** 2
        is_last = (length <= _QUADRATIC) & (following <= _NEXT * threshold)
        before[index] = length
        done = ((length <= threshold) | is_last) & ~gone
        sign[index[done]] = np.linalg.slogdet(matrix[done])[0]
        converged[index[done & (way <= _BEYOND)]] = True
        active[index[done | gone]] = False
    # Where steps have stopped short of the threshold at rounding, the last one tells.
    course = course_of(q, speed, model.period)
    if np.any(active):
        index = np.nonzero(active)[0]
        equation = model.equation(Course(*(item[index] for item in course)))
        left = np.max(np.abs(equation.efforts), axis=1) / equation.scale
        way = np.max(np.abs((q[index] - model.centre) / model.half), axis=(1, 2))
        is_there = (np.max(left, axis=1) <= ROUNDED) & (way <= _BEYOND)
        converged[index[is_there]] = True
        matrix = jacobian(equation, speed[index], model.period)
        sign[index] = np.linalg.slogdet(matrix)[0]
    return Found(course, converged, sign)


def resolved(
    model: ReducedModel, speed: Array, guess: Array
) -> list[tuple[ReducedModel, Array, Found]]:
    """Return motions with as many orders as they need.

    Args:
        model: reduced model.
        speed: of the drive `(S,)`.
        guess: `(S, N, n)`; on the nodes of the model, or more.

    Returns:
        groups of the guesses that need the same number of nodes: the model on these, indices of
        the guesses, and what was found.
    """
    count, index = max(model.count, guess.shape[1]), np.arange(len(speed))
    groups = []
    before = np.full(len(speed), np.inf)
    while True:
        model, guess = model.on(count), resampled(guess, count, 1)
        found = solved(model, speed[index], guess)
        q = found.course.q
        rough = _roughness(model, q)
        # Where more nodes bring nothing, rounding is what is left, or the error of the model. Where
        # there is more of it, orders are missing that are not yet smaller than others.
        is_cut = _is_cut(model, rough)
        again = found.converged & (rough > 1.0) & ((rough < 0.3 * before) | is_cut)
        if count >= MOST_NODES:
            again[:] = False
            found.converged[is_cut] = False
        if not np.all(again):
            groups.append((model, index[~again], found.part(~again)))
        if not np.any(again):
            return groups
        index, guess, before = index[again], q[again], rough[again]
        count = next_size(count + 1)


def lacks_orders(model: ReducedModel, q: Array) -> Array:
    """Return whether motions `(S, N, n)` have orders that their nodes do not carry."""
    return _is_cut(model, _roughness(model, q))


def _roughness(model: ReducedModel, q: Array) -> Array:
    """Return the highest orders of motions `(S, N, n)`, in units of what is rounding."""
    greatest = np.max(np.abs(q), axis=1)
    rounding = np.maximum(TAIL * greatest, _ROUGH * model.half)
    return np.asarray(np.max(tail(q, 1) * greatest / rounding, axis=1))


def _is_cut(model: ReducedModel, rough: Array) -> Array:
    return np.asarray(rough > max(_CUT, _CUT * model.error / TAIL))
