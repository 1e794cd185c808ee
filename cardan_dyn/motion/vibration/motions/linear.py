"""Linear motions: what the linear equations about the mean of a motion make of it."""

from __future__ import annotations

import numpy as np

from ....kit.arrays import Array
from ....kit.periodic import amplitudes, orders_of, sampled
from ..model.modes import averaged
from ..model.reduced_model import Course, ReducedModel
from .harmonic_balance import jacobian, newton_steps
from .models import Motions

_STEPS = 30
_PLACED = 1e-10
"""Newton step, as a fraction of the range, at which a place is found."""


def at_mean(course: Course) -> Course:
    """Return motions in which the free coordinates rest at their means."""
    return _at_rest(np.mean(course.q, axis=1), course.speed, course.q.shape[1])


def resting(model: ReducedModel, centre: Array, speed: Array) -> list[Motions]:
    """Return the places near a centre `(n,)` at which mean efforts vanish at rest."""
    q, there = np.tile(centre, (len(speed), 1)), np.zeros(len(speed), dtype=bool)
    for _ in range(_STEPS):
        equation = model.equation(_at_rest(q, speed, model.count))
        stiffness, efforts = (np.mean(x, axis=1) for x in (equation.stiffness, equation.efforts))
        step = -(np.linalg.pinv(stiffness) @ efforts[..., None])[..., 0]
        q = np.clip(q + step, centre - model.half, centre + model.half)
        there = np.max(np.abs(step / model.half), axis=1) <= _PLACED
        if np.all(there):
            break
    (index,) = np.nonzero(there)
    rest = _at_rest(q[index], speed[index], model.count)
    return [Motions(model, index, rest, np.ones(len(index)), model)] if index.size else []


def _at_rest(q: Array, speed: Array, count: int) -> Course:
    """Return coordinates `(S, n)` at rest on a number of nodes."""
    still = np.repeat(q[:, None], count, axis=1)
    return Course(still, np.zeros_like(still), np.zeros_like(still), speed)


def linear_motions(motions: Motions) -> Array:
    """Return motions `(S, N, n)` by the linear equation with periodic coefficients.

    It is that about the mean of motions.
    """
    return linear_about(motions.middle, np.mean(motions.course.q, axis=1), motions.course.speed)


def linear_about(model: ReducedModel, q: Array, speed: Array) -> Array:
    """Return motions `(S, N, n)` by the linear equation about coordinates `(S, n)` at rest."""
    rest = _at_rest(q, speed, model.count)
    equation = model.equation(rest)
    matrix = jacobian(equation, speed, model.period)
    return np.asarray(rest.q + newton_steps(matrix, equation.efforts))


def averaged_motions(motions: Motions) -> Array:
    """Return motions `(S, N, n)` by the same equation with averaged coefficients."""
    rest = at_mean(motions.course)
    equation, count = motions.middle.equation(rest), rest.q.shape[1]
    mass, damping, stiffness = (item[:, None] for item in averaged(equation))
    turn = orders_of(count // 2 + 1, motions.middle.period)
    pace = 1j * turn[None, :, None, None] * rest.speed[:, None, None, None]
    dynamic = pace**2 * mass + pace * damping + stiffness
    waves = np.linalg.solve(dynamic, -amplitudes(equation.efforts, 1)[..., None])[..., 0]
    return np.asarray(rest.q + sampled(waves, count, 1))
