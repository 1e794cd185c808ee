"""Linear motions: what the linear equations about the mean of a motion make of it."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .averaged import averaged
from .harmonic_balance import jacobian, newton_steps
from .motion_search import Motions
from .periodic_grid import orders_of
from .reduced_model import Course


def resting(course: Course) -> Course:
    """Return motions in which the free coordinates rest at their means."""
    q = np.repeat(np.mean(course.q, axis=1, keepdims=True), course.q.shape[1], axis=1)
    return Course(q, np.zeros_like(q), np.zeros_like(q), course.speed)


def linear_motions(motions: Motions) -> tuple[Array, Array]:
    """Return motions `(S, N, n)` by the linear equation about the mean of motions.

    Returns:
        with periodic coefficients, and with averaged ones.
    """
    model, course = motions.middle, motions.course
    rest = resting(course)
    equation = model.equation(rest)
    count = course.q.shape[1]
    matrix = jacobian(equation, course.speed, model.period)
    linear = rest.q + newton_steps(matrix, equation.efforts)
    mass, damping, stiffness = (item[:, None] for item in averaged(equation))
    turn = orders_of(count // 2 + 1, model.period)
    pace = 1j * turn[None, :, None, None] * course.speed[:, None, None, None]
    dynamic = pace**2 * mass + pace * damping + stiffness
    spectrum = np.linalg.solve(dynamic, -np.fft.rfft(equation.efforts, axis=1)[..., None])[..., 0]
    return linear, rest.q + np.fft.irfft(spectrum, count, axis=1)
