"""Linear motions: what the linear equations about the mean of a motion make of it."""

from __future__ import annotations

import numpy as np

from ....kit.arrays import Array
from ....kit.periodic import amplitudes, orders_of, sampled
from ..model.modes import averaged
from ..model.motion_equation import Course, LocalEquation, MotionEquation
from .harmonic_balance import Motions, jacobian, newton_steps, solved


def at_mean(course: Course) -> Course:
    """Return motions in which the free coordinates rest at their means."""
    return _at_rest(np.mean(course.q, axis=1), course.speed, course.q.shape[1])


class _Means(MotionEquation):
    """The same equation of coordinates at rest: means over a period, at one node of it."""

    def along(self, course: Course) -> LocalEquation:
        """See `MotionEquation.along`."""
        found = super().along(_at_rest(course.q[:, 0], course.speed, self.count))
        every = found._asdict()
        scale = every.pop("scale")
        means = {name: np.mean(of, axis=1, keepdims=True) for name, of in every.items()}
        return LocalEquation(scale=scale, **means)


def resting(model: MotionEquation, start: Array, speed: Array) -> list[Motions]:
    """Return the places near a start `(n,)` at which mean efforts vanish at rest."""
    guess = np.tile(start, (len(speed), 1, 1))
    found, there = solved(_Means(**vars(model)), speed, guess)
    rest = _at_rest(found.course.q[:, 0], speed, model.count)
    every = Motions(model, found.index, rest, np.ones(len(speed)))
    return [every.part(there)] if np.any(there) else []


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
