"""Harmonic balance: periodic motions of a scene, by collocation and Newton's method.

The motion is a Fourier sum with as many orders as the nodes of a period carry; the efforts vanish
at all nodes. Many speeds and guesses are solved together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....kit.arrays import EPS, ROUNDED, Array
from ....kit.periodic import MOST_NODES, TAIL, derivatives, next_size, resampled, tail
from ..model.motion_equation import Course, LocalEquation, MotionEquation

MOST_STEPS = 30
NUMBERS = 8_000_000
"""Numbers (64 MB) of equations that are solved at a time."""
_CUT = 1e3
"""Multiple of what is rounding, of the highest orders, from which on a motion lacks some."""


@dataclass(frozen=True, eq=False)
class Motions:
    """Periodic motions on the same nodes.

    Attributes:
        model: equation on these nodes.
        index: `(S,)` of the speed among those that were asked for.
        course: S motions.
        sign: `(S,)` of the determinant of their Jacobians.
    """

    model: MotionEquation
    index: Array
    course: Course
    sign: Array

    def part(self, chosen: Array | slice) -> Motions:
        """Return some of them, by a mask, indices or a slice."""
        course = self.course.part(chosen)
        return replace(self, index=self.index[chosen], course=course, sign=self.sign[chosen])

    @cached_property
    def equation(self) -> LocalEquation:
        """The equation of small changes along them."""
        return self.model.along(self.course)


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
        if size == 1:
            return np.full_like(efforts, np.nan)
        each = zip(matrix[:, None], efforts[:, None], strict=True)
        return np.concatenate([newton_steps(*one) for one in each])
    return np.asarray(np.swapaxes(steps.reshape(size, free, count), 1, 2))


def _least_step(matrix: Array, efforts: Array, units: Array) -> Array:
    """Return the least change of positions `(N, n)` that takes away efforts, in their units.

    Args:
        matrix: `(K, K)`, of a Jacobian that may be singular.
        efforts: `(N, n)`.
        units: of the coordinates `(n,)`.
    """
    sides = -efforts.T.reshape(-1, 1)
    if not np.all(np.isfinite(matrix)) or not np.all(np.isfinite(sides)):
        return np.full_like(efforts, np.nan)
    scaled, every, rows = in_units(matrix, units)
    step = np.linalg.lstsq(scaled, sides / rows, rcond=ROUNDED)[0][:, 0] * every
    return np.asarray(step.reshape(len(units), -1).T)


def in_units(matrix: Array, units: Array) -> tuple[Array, Array, Array]:
    """Return Jacobians `(…, K, K)` in units of coordinates `(K,)` and rows `(…, K, 1)`, and these.

    Args:
        matrix: see `jacobian`.
        units: of the coordinates `(n,)`.
    """
    every = np.repeat(units, matrix.shape[-1] // len(units))
    rows = np.max(np.abs(matrix * every), axis=-1, keepdims=True)
    rows = np.where(rows > 0.0, rows, 1.0)
    return matrix * every / rows, every, rows


def swings(q: Array, units: Array) -> Array:
    """Return how far motions `(S, N, n)` go from their means `(S,)`, in units of coordinates."""
    return np.asarray(np.max(np.abs(q - np.mean(q, axis=1, keepdims=True)) / units, axis=(1, 2)))


def solved(model: MotionEquation, speed: Array, guess: Array) -> tuple[Motions, Array]:
    """Return motions near guesses.

    Args:
        model: equation on the nodes of the guesses.
        speed: of the drive `(S,)` [rad/s].
        guess: `(S, N, n)`.

    Returns:
        One for each guess, and whether it is a solution no farther from its mean than is asked.
    """
    size, together = len(guess), max(1, NUMBERS // max(1, guess[:1].size ** 2))
    q, sign, converged = guess.copy(), np.zeros(size), np.zeros(size, dtype=bool)
    steps_left, before = np.full(size, MOST_STEPS), np.full(size, np.nan)
    while np.any(steps_left):
        index = np.nonzero(steps_left)[0][:together]
        steps_left[index] -= 1
        equation = model.along(course_of(q[index], speed[index], model.period))
        matrix = jacobian(equation, speed[index], model.period)
        step = newton_steps(matrix, equation.efforts)
        length = np.max(np.abs(step / model.units), axis=(1, 2))
        left = np.max(np.max(np.abs(equation.efforts), axis=1) / _scale(equation), axis=1)
        # Along what nothing holds rounding decides: there the motion stays where it is. It shows in
        # long steps for what is hardly left; elsewhere the least step is Newton's.
        unheld = ~(length <= np.where(left <= ROUNDED, ROUNDED, np.sqrt(ROUNDED)))
        for item in np.nonzero((left <= np.sqrt(ROUNDED)) & unheld)[0]:
            step[item] = _least_step(matrix[item], equation.efforts[item], model.units)
            length[item] = np.max(np.abs(step[item] / model.units))
        bad = ~np.isfinite(length)
        step[bad] = 0.0
        # No step goes farther than motions do.
        factor = model.most / np.where(bad, 1.0, np.maximum(length, model.most))
        q[index] += factor[:, None, None] * step
        way = swings(q[index], model.units)
        gone = bad | (way > 3.0 * model.most)
        # Steps that shrink by their squares tell how long the next one is.
        with np.errstate(over="ignore", invalid="ignore"):
            following = length * (length / before[index]) ** 2
        # Steps that short that shrink no more are rounding.
        is_near = length <= np.sqrt(ROUNDED)
        is_last = is_near & ((following <= EPS) | (length > 0.5 * before[index]))
        before[index] = length
        done = ((length <= ROUNDED) | is_last) & ~gone
        sign[index[done]] = np.linalg.slogdet(matrix[done])[0]
        converged[index[done]] = way[done] <= model.most
        steps_left[index[done | gone]] = 0
    course = course_of(q, speed, model.period)
    return Motions(model, np.arange(size), course, sign), converged


def _scale(equation: LocalEquation) -> Array:
    """Return sizes of efforts `(S, n)`, of which there are some."""
    return np.where(equation.scale > 0.0, equation.scale, 1.0)


def found_near(model: MotionEquation, speed: Array, guess: Array) -> list[Motions]:
    """Return motions with as many orders as they need, those on as many nodes in one.

    Args:
        model: equation on the least number of nodes.
        speed: of the drive `(S,)`.
        guess: `(S, N, n)`; on these nodes, or more. Near some there may be none.
    """
    count, index = max(model.count, guess.shape[1]), np.arange(len(speed))
    groups, before = [], np.full(len(speed), np.inf)
    while True:
        model, guess = model.on(count), resampled(guess, count, 1)
        found, there = solved(model, speed[index], guess)
        rough = _roughness(model, found.course.q)
        # Where more nodes bring nothing, rounding is what is left. Where there is more of it,
        # orders are missing that are not yet smaller than others.
        again = there & (rough > 1.0) & ((rough < 0.3 * before) | (rough > _CUT))
        if count >= MOST_NODES:
            again[:], there = False, there & (rough <= _CUT)
        if np.any(there & ~again):
            own = found.part(there & ~again)
            groups.append(replace(own, index=index[own.index]))
        if not np.any(again):
            return groups
        index, guess, before = index[again], found.course.q[again], rough[again]
        count = next_size(count + 1)


def lacks_orders(model: MotionEquation, q: Array) -> Array:
    """Return whether motions `(S, N, n)` have orders that their nodes do not carry."""
    return np.asarray(_roughness(model, q) > _CUT)


def _roughness(model: MotionEquation, q: Array) -> Array:
    """Return the highest orders of motions `(S, N, n)`, in units of what is rounding."""
    greatest = np.max(np.abs(q), axis=1)
    # Places are known to rounding of the units, however small a motion is.
    rounding = np.maximum(TAIL * greatest, EPS * model.units)
    return np.asarray(np.max(tail(q, 1) * greatest / rounding, axis=1))
