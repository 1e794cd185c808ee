"""Linear motions: what the linear equations about the mean of a motion make of it."""

from __future__ import annotations

import numpy as np

from ...arrays import Array
from ..model.modes import averaged
from ..model.periodic_grid import orders_of
from ..model.reduced_model import Course
from .harmonic_balance import jacobian, newton_steps
from .search import Motions, MotionSearch

_STEPS = 30
_PLACED = 1e-10
"""Newton step, as a fraction of the range, at which a place is found."""
_ROOM = 2.0
"""Range in which places are looked for, as a multiple of what some of them are apart."""


def resting(course: Course) -> Course:
    """Return motions in which the free coordinates rest at their means."""
    q = np.repeat(np.mean(course.q, axis=1, keepdims=True), course.q.shape[1], axis=1)
    return Course(q, np.zeros_like(q), np.zeros_like(q), course.speed)


def resting_motions(search: MotionSearch, speeds: Array) -> list[Motions]:
    """Return the places at which mean efforts vanish while the free coordinates rest.

    They are motions of the equation without what forces it, and thus have neither resonances nor
    others beside them. Speeds without such a place within the range of the search are left out.

    Args:
        search: of the scene.
        speeds: `(S,)` [rad/s].
    """
    units = search.rotating.units
    known = search.primary(speeds[[0, len(speeds) // 2, -1]], carry=False)
    means = [np.mean(motions.course.q, axis=1) for motions in known]
    start = search.rotating.start[None, 1:]
    places = np.concatenate(means) if means else start
    centre = np.median(places, axis=0)
    spread = float(np.max(np.abs(places - centre) / units))
    model = search.widest(centre, _ROOM * spread)
    q, there = np.tile(centre, (len(speeds), 1)), np.zeros(len(speeds), dtype=bool)
    for _ in range(_STEPS):
        equation = model.equation(_at_rest(q, speeds, model.count))
        stiffness, efforts = (np.mean(x, axis=1) for x in (equation.stiffness, equation.efforts))
        step = -(np.linalg.pinv(stiffness) @ efforts[..., None])[..., 0]
        q = np.clip(q + step, centre - model.half, centre + model.half)
        there = np.max(np.abs(step / model.half), axis=1) <= _PLACED
        if np.all(there):
            break
    (index,) = np.nonzero(there)
    rest = _at_rest(q[index], speeds[index], model.count)
    return [Motions(model, index, rest, np.ones(len(index)), model)] if index.size else []


def _at_rest(q: Array, speeds: Array, count: int) -> Course:
    """Return coordinates `(S, n)` at rest on a number of nodes."""
    still = np.repeat(q[:, None], count, axis=1)
    return Course(still, np.zeros_like(still), np.zeros_like(still), speeds)


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
