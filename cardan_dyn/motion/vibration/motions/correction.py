"""Correction: periodic motions of an interpolated model, held against the scene itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import AccuracyError, VibrationError
from ....kit.periodic import shifted
from ..model.efforts import FreeEfforts
from ..model.reduced_model import Course, LocalEquation, ReducedModel
from .harmonic_balance import course_of, jacobian, newton_steps
from .models import Motions

_STEPS = 3
"""Newton steps, each with the derivatives of the interpolated equation."""
_MOST_CONDITION = 1e12
"""Condition number of the equation's Jacobian from which on its motion may be anywhere: that of
stiff scenes with many orders is about 1e7."""
_LOOKED_AT = 3
"""Motions of a group that tell whether nothing holds a coordinate."""
_MOVED = 0.5
"""Share of the mean in what a singular equation leaves open, from which on it moves a motion."""
_WORST = 1e-7
"""Effort, as a fraction of its terms, that may be left along a motion: interpolation leaves about
1e-12, and orders beyond the nodes what their number allows."""


def corrected(efforts: FreeEfforts, motions: Motions) -> tuple[Motions, Array]:
    """Return motions after Newton steps on efforts that sweeps compute, and what is left.

    Args:
        efforts: of the scene.
        motions: S of them.

    Returns:
        the motions, and residuals `(S,)` at the nodes and between them: greatest effort along a
        free coordinate, as a fraction of the greatest sum of the sizes of its terms.

    Raises:
        VibrationError: a motion is not isolated.
        AccuracyError: the interpolated equation and the sweeps disagree.
    """
    model, course = motions.model, motions.course
    equation = model.equation(course)
    matrix = jacobian(equation, course.speed, model.period)
    scale = np.where(equation.scale > 0.0, equation.scale, 1.0)[:, None]
    _refuse_singular(_scaled(model, equation, course.speed), course.speed)
    left = along(efforts, model, course)
    best, least = course, np.max(np.abs(left) / scale, axis=(1, 2))
    for _ in range(_STEPS):
        step = newton_steps(matrix, left)
        course = course_of(course.q + step, course.speed, model.period)
        left = along(efforts, model, course)
        found = np.max(np.abs(left) / scale, axis=(1, 2))
        better = found < least
        best = Course(
            *(
                np.where(better.reshape(-1, *[1] * (new.ndim - 1)), new, old)
                for new, old in zip(course, best, strict=True)
            )
        )
        is_done = not np.any(found < 0.5 * least)
        least = np.minimum(least, found)
        if is_done:
            break
    between = np.max(np.abs(along(efforts, model, best, 0.5)) / scale, axis=(1, 2))
    residual = np.maximum(least, between)
    worst = float(np.max(residual))
    if not worst <= _WORST:
        raise AccuracyError(
            f"efforts do not vanish along the periodic motion: {worst:.1e} of them is left",
            residual=worst,
            tolerance=_WORST,
        )
    return replace(motions, course=best), residual


def refuse_unheld(found: list[Motions]) -> None:
    """Refuse motions whose free coordinates may be anywhere, since nothing holds one of them.

    A few motions of each group are looked at. At an undamped resonance the equation is singular as
    well, but what is left open there swings about the same mean.

    Args:
        found: groups of motions.

    Raises:
        VibrationError: all that are looked at may be moved as a whole.
    """
    for motions in found:
        size = len(motions.index)
        part = motions.part(np.unique(np.linspace(0, size - 1, _LOOKED_AT).astype(int)))
        model, course = part.model, part.course
        for matrix in _scaled(model, model.equation(course), course.speed):
            if _condition(matrix) < _MOST_CONDITION:
                return
            left_open = np.linalg.svd(matrix)[2][-1].reshape(len(model.half), -1)
            mean = np.mean(left_open, axis=1)
            if np.linalg.norm(mean) * np.sqrt(left_open.shape[1]) < _MOVED:
                return
    if found:
        raise VibrationError(
            "nothing holds a free coordinate, which then has no mean: give it a spring",
            speed=float(found[0].course.speed[0]),
        )


def _scaled(model: ReducedModel, equation: LocalEquation, speed: Array) -> Array:
    """Return the equation's Jacobian `(S, K, K)` in units of the ranges and of its rows."""
    count, free = equation.efforts.shape[1:]
    matrix = jacobian(equation, speed, model.period) * np.repeat(model.half, count)
    rows = np.max(np.abs(matrix).reshape(len(speed), free, -1), axis=2)
    rows = np.repeat(np.where(rows > 0.0, rows, 1.0), count, axis=1)
    return np.asarray(matrix / rows[:, :, None])


def _condition(matrix: Array) -> Array:
    """Return condition numbers of matrices `(..., K, K)`, not finite where they are singular."""
    with np.errstate(all="ignore"):
        return np.asarray(np.linalg.cond(matrix, 1))


def _refuse_singular(matrix: Array, speed: Array) -> None:
    """Refuse motions at which the Jacobian `(S, K, K)` of the equation is singular."""
    for condition, at in zip(_condition(matrix).tolist(), speed.tolist(), strict=True):
        if not condition < _MOST_CONDITION:
            raise VibrationError(
                f"the motion at {at:.12g} rad/s is not isolated: its equation is singular. Either "
                "two motions just meet there, or nothing holds a free coordinate, which then has "
                "no mean: give it a spring",
                speed=at,
            )


def along(efforts: FreeEfforts, model: ReducedModel, course: Course, shift: float = 0.0) -> Array:
    """Return efforts `(S, N, n)` that sweeps compute along motions.

    Args:
        efforts: of the scene.
        model: on the nodes of the motions.
        course: S motions.
        shift: of all nodes, as a fraction of their distance.
    """
    size, count, free = course.q.shape
    if shift:
        q, rate, bend = (shifted(item, shift, 1) for item in course[:3])
        course = Course(q, rate, bend, course.speed)
    drive = model.positions + shift * model.period / count
    position = np.concatenate([np.broadcast_to(drive[:, None], (size, count, 1)), course.q], axis=2)
    acceleration = np.concatenate([np.zeros((size, count, 1)), course.accelerations], axis=2)
    states = position, course.velocities, acceleration
    return efforts(*(item.reshape(-1, 1 + free) for item in states)).reshape(size, count, free)
