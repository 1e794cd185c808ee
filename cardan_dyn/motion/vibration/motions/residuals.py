"""Residuals: what sweeps find left of efforts along motions, and motions that nothing holds."""

from __future__ import annotations

import numpy as np

from ....kit.arrays import NOTHING, ROUNDED, Array
from ....kit.errors import AccuracyError, VibrationError
from ....kit.periodic import shifted
from ..model.efforts import with_drive
from ..model.motion_equation import Course
from .harmonic_balance import Motions, in_units, jacobian

_WORST = 1e-7
"""Effort, as a fraction of its terms, that may be left along a motion: orders beyond the nodes
leave what their number allows."""


def residuals(motions: Motions) -> Array:
    """Return residuals `(S,)` at the nodes of motions and between them.

    They are the greatest effort along a free coordinate that sweeps find, as a fraction of the
    greatest sum of the sizes of its terms.

    Args:
        motions: S of them.

    Raises:
        VibrationError: a motion is not isolated.
        AccuracyError: efforts do not vanish.
    """
    _refuse_singular(_scaled(motions), motions.course.speed)
    return efforts_left(motions)


def efforts_left(motions: Motions) -> Array:
    """Return residuals `(S,)` of motions that need not be isolated, see `residuals`.

    Raises:
        AccuracyError: efforts do not vanish.
    """
    equation, speed, units = motions.equation, motions.course.speed, motions.model.units
    # Of a motion that vanishes, efforts are rounding of what a motion of size 1 would need.
    pace = np.abs(speed)[:, None, None, None]
    of_unit = np.abs(equation.stiffness) + pace**2 * np.abs(equation.mass)
    least = NOTHING * np.max(of_unit @ units, axis=1)
    scale = (equation.scale + least)[:, None]
    scale = np.where(scale > 0.0, scale, 1.0)
    left = [np.max(np.abs(_along(motions, shift)) / scale, axis=(1, 2)) for shift in (0.0, 0.5)]
    residual = np.max(left, axis=0)
    worst = float(np.max(residual))
    if not worst <= _WORST:
        raise AccuracyError(
            f"efforts do not vanish along the periodic motion: {worst:.1e} of them is left; where "
            "the law of an element has a corner, efforts are no smooth functions: round it",
            residual=worst,
            tolerance=_WORST,
        )
    return np.asarray(residual)


def refuse_unheld(found: list[Motions]) -> None:
    """Refuse motions whose free coordinates may be anywhere, since nothing holds one of them.

    At an undamped resonance the equation is singular as well, but what is left open there swings
    about the same mean.

    Args:
        found: groups of motions.

    Raises:
        VibrationError: all of them may be moved as a whole.
    """
    for motions in found:
        for row in range(len(motions.index)):
            (matrix,) = _scaled(motions.part(slice(row, row + 1)))
            if _condition(matrix) < 1.0 / ROUNDED:
                return
            left_open = np.linalg.svd(matrix)[2][-1].reshape(motions.course.q.shape[2], -1)
            # Of its square, which is 1, less than half moves it as a whole.
            if np.sum(np.mean(left_open, axis=1) ** 2) * left_open.shape[1] < 0.5:
                return
    if found:
        raise VibrationError(
            "nothing holds a free coordinate, which then has no mean: give it a spring",
            speed=float(found[0].course.speed[0]),
        )


def _scaled(motions: Motions) -> Array:
    """Return the equation's Jacobian `(S, K, K)` in units of the coordinates and of its rows."""
    model = motions.model
    matrix = jacobian(motions.equation, motions.course.speed, model.period)
    return in_units(matrix, model.units)[0]


def _condition(matrix: Array) -> Array:
    """Return condition numbers of matrices `(..., K, K)`, not finite where they are singular."""
    with np.errstate(all="ignore"):
        return np.asarray(np.linalg.cond(matrix, 1))


def _refuse_singular(matrix: Array, speed: Array) -> None:
    """Refuse motions at which the Jacobian `(S, K, K)` of the equation is singular."""
    for condition, at in zip(_condition(matrix).tolist(), speed.tolist(), strict=True):
        if not condition < 1.0 / ROUNDED:
            raise VibrationError(
                f"the motion at {at:.12g} rad/s is not isolated: its equation is singular. Either "
                "two motions just meet there, or nothing holds a free coordinate, which then has "
                "no mean: give it a spring",
                speed=at,
            )


def _along(motions: Motions, shift: float) -> Array:
    """Return efforts `(S, N, n)` that sweeps compute along motions.

    Args:
        motions: S of them.
        shift: of all nodes, as a fraction of their distance.
    """
    model, course = motions.model, motions.course
    q, rate, bend = (shifted(item, shift, 1) for item in course[:3])
    moved = Course(q, rate, bend, course.speed)
    place = with_drive(model.positions + shift * model.period / model.count, q)
    return model.efforts(place, moved.velocities, moved.accelerations)[..., 1:]
