"""Linear motions: what the linear equations about the mean of a motion make of it."""

from __future__ import annotations

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ....kit.periodic import amplitudes, orders_of, sampled
from ..model.modes import averaged
from ..model.motion_equation import Course, MotionEquation
from .harmonic_balance import MOST_STEPS, Motions, jacobian, newton_steps


def at_mean(course: Course) -> Course:
    """Return motions in which the free coordinates rest at their means."""
    return _at_rest(np.mean(course.q, axis=1), course.speed, course.q.shape[1])


def resting(model: MotionEquation, start: Array, speed: Array) -> list[Motions]:
    """Return the places near a start `(n,)` at which mean efforts vanish at rest."""
    q, there = np.tile(start, (len(speed), 1)), np.zeros(len(speed), dtype=bool)
    for _ in range(MOST_STEPS):
        equation = model.along(_at_rest(q, speed, model.count))
        stiffness, efforts = (np.mean(x, axis=1) for x in (equation.stiffness, equation.efforts))
        lost = ~np.all(np.isfinite(stiffness), axis=(1, 2))
        stiffness[lost], efforts[lost] = 0.0, 0.0
        step = -(np.linalg.pinv(stiffness, rcond=ROUNDED) @ efforts[..., None])[..., 0]
        length = np.max(np.abs(step) / model.units, axis=1)
        q += step * (model.most / np.maximum(length, model.most))[:, None]
        # Newton's method doubles digits.
        there = (length <= np.sqrt(ROUNDED)) & ~lost
        if np.all(there | lost):
            break
    (index,) = np.nonzero(there)
    rest = _at_rest(q[index], speed[index], model.count)
    return [Motions(model, index, rest, np.ones(len(index)))] if index.size else []


def _at_rest(q: Array, speed: Array, count: int) -> Course:
    """Return coordinates `(S, n)` at rest on a number of nodes."""
    still = np.repeat(q[:, None], count, axis=1)
    return Course(still, np.zeros_like(still), np.zeros_like(still), speed)


def linear_motions(motions: Motions) -> Array:
    """Return motions `(S, N, n)` by the linear equation with periodic coefficients.

    It is that about the mean of motions.
    """
    model, rest = motions.model, at_mean(motions.course)
    equation = model.along(rest)
    matrix = jacobian(equation, rest.speed, model.period)
    return np.asarray(rest.q + newton_steps(matrix, equation.efforts))


def averaged_motions(motions: Motions) -> Array:
    """Return motions `(S, N, n)` by the same equation with averaged coefficients."""
    rest = at_mean(motions.course)
    equation, count = motions.model.along(rest), rest.q.shape[1]
    mass, damping, stiffness = (item[:, None] for item in averaged(equation))
    turn = orders_of(count // 2 + 1, motions.model.period)
    pace = 1j * turn[None, :, None, None] * rest.speed[:, None, None, None]
    dynamic = pace**2 * mass + pace * damping + stiffness
    waves = np.linalg.solve(dynamic, -amplitudes(equation.efforts, 1)[..., None])[..., 0]
    return np.asarray(rest.q + sampled(waves, count, 1))
