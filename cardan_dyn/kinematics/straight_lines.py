"""Straight lines: closed positions that several drives lead to along straight lines from the start.

Positions of several drives have no order along which a branch could be kept. What configuration a
position means is therefore defined by the straight line of drive positions from the start to it,
whatever other samples there are. All samples advance together, each with steps of its own length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.coordinates import Coordinates
from .all_groups import ClosedState, Kinematics
from .tolerances import CLOSURE_TOLERANCE

SAFE_STEP = 0.1
"""Error [rad] up to which an extrapolation is taken to end in the same assembly mode. It may be
greater than `SAFE_CORRECTION`, since nothing is interpolated between these samples, and every step
is also checked for a change of side of a singular configuration."""
_LONGEST_WAY = 1.0
"""Greatest displacement [rad] of a coordinate in a step, by each of its first two derivatives. Of
longer steps some end by accident near other solutions, often whole turns of a joint away."""
MOST_CORRECTIONS = 6
"""Greatest number of Newton steps per sample. Convergence is quadratic: from a safe extrapolation
about four steps reach rounding. What needs more is tried again from nearer by."""
_AIM = 0.03
"""Error [rad] that steps are chosen for. Extrapolations of second order are off by the third power
of the step, so that a step is a third shorter than one that is just safe, and few are in vain."""
_LONGER, _SHORTER = 4.0, 0.1
"""Greatest and smallest ratio of a step to the one before it."""
_SMALLEST_SHARE = 1e-9
"""Share of the remaining way to a sample that is tried last, before the sample counts as out of
reach."""
BLOCK_SIZE = 768
"""Greatest number of samples that advance together, so that their arrays stay in the cache."""


class Reached(NamedTuple):
    """How far straight lines were followed.

    Attributes:
        x: `(N, size)` closed coordinates at the end of each line, or where it could not go on.
        is_there: `(N,)` whether that is the end.
        residual: `(N,)` closure error of the last step that was tried, where it is not.
    """

    x: Array
    is_there: Array
    residual: Array


def along_lines(
    kinematics: Kinematics, start: Array, columns: list[int], positions: Array
) -> Reached:
    """Follow the straight lines from a start to drive positions `(N, d)`.

    Args:
        kinematics: of the drives and the groups that they move.
        start: `(size,)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: [rad or m].
    """
    blocks = [
        _block_along_lines(kinematics, start, columns, positions[first : first + BLOCK_SIZE])
        for first in range(0, max(len(positions), 1), BLOCK_SIZE)
    ]
    return Reached(*map(np.concatenate, zip(*blocks, strict=True)))


def _block_along_lines(
    kinematics: Kinematics, start: Array, columns: list[int], positions: Array
) -> Reached:
    """Follow some straight lines, see `along_lines`; all steps of a round are one set of arrays."""
    count, coordinates = len(positions), kinematics.coordinates
    way = positions - start[columns]
    x = np.repeat(start[None, :], count, axis=0)
    share, step, residual = np.zeros(count), np.ones(count), np.zeros(count)
    with np.errstate(all="ignore"):  # Steps out of reach may overflow; they are not safe.
        before = kinematics.evaluate(start[None, :])
        v, a = _derivatives(kinematics, before, way)
        _, longest = extrapolated(coordinates, x, v, a)
        inverses = [np.repeat(inverse, count, axis=0) for inverse in before.inverses]
        active = np.arange(count)
        while active.size:
            remaining = 1.0 - share[active]
            length = np.minimum(np.minimum(step[active], longest[active]), remaining)
            is_last = length == remaining
            rates, curvatures = length[:, None] * v[active], length[:, None] ** 2 * a[active]
            guess, _ = extrapolated(coordinates, x[active], rates, curvatures)
            to = np.where(is_last, 1.0, share[active] + length)
            aim = start[columns] + to[:, None] * way[active]
            guess[:, columns] = np.where(is_last[:, None], positions[active], aim)
            state = kinematics.close(guess, most=MOST_CORRECTIONS)
            is_safe = is_safe_step(kinematics, state, [inverse[active] for inverse in inverses])
            step[active] = length * _ratios(state.correction, is_safe)
            residual[active] = state.residual
            done = active[is_safe]
            x[done], share[done] = state.x[is_safe], to[is_safe]
            for inverse, new in zip(inverses, state.inverses, strict=True):
                inverse[done] = new[is_safe]
            new_v, new_a = _derivatives(kinematics, state, way[active])
            v[done], a[done] = new_v[is_safe], new_a[is_safe]
            longest[done] = extrapolated(coordinates, x[done], v[done], a[done])[1]
            # Written so that what is not a number stops as well.
            goes_on = step[active] >= _SMALLEST_SHARE * (1.0 - share[active])
            active = active[(share[active] < 1.0) & goes_on]
    return Reached(x, share == 1.0, residual)


def extrapolated(coordinates: Coordinates, x: Array, v: Array, a: Array) -> tuple[Array, Array]:
    """Return rows `(N, size)` after unit time, and `(N,)` after what time at most they may be used.

    Args:
        coordinates: layout of the rows.
        x: `(N, size)` rows before.
        v: joint velocities `(N, nv)`.
        a: joint accelerations `(N, nv)`.
    """
    first, second = coordinates.derivative(x, v), 0.5 * coordinates.curvature(x, v, a)
    fastest, most_bent = (
        np.max(np.abs(way) * coordinates.scale, axis=1, initial=0.0) for way in (first, second)
    )
    with np.errstate(divide="ignore"):
        longest = np.minimum(_LONGEST_WAY / fastest, np.sqrt(_LONGEST_WAY / most_bent))
    return x + (first + second), longest


def is_safe_step(kinematics: Kinematics, state: ClosedState, inverses: list[Array]) -> Array:
    """Return `(N,)` whether closed states are in the assembly mode that a step began in.

    Args:
        kinematics: that closed them.
        state: after the step.
        inverses: of every group's closure equations before it.
    """
    is_safe = (state.residual < CLOSURE_TOLERANCE) & (state.correction < SAFE_STEP)
    return np.asarray(is_safe & kinematics.same_side(state, inverses))


def _derivatives(kinematics: Kinematics, state: ClosedState, way: Array) -> tuple[Array, Array]:
    """Return joint rates and accelerations `(N, nv)` when drives move by `way (N, d)` in unit time.

    Args:
        kinematics: of the drives.
        state: N closed positions, or a single one.
        way: what the drives move by.
    """
    v = kinematics.rates(state, way)
    return v, kinematics.accelerations(state, v, np.zeros_like(way))


def _ratios(correction: Array, is_safe: Array) -> Array:
    """Return `(N,)` how much longer the next steps are than those with these errors `(N,)`."""
    ratios = np.cbrt(_AIM / np.maximum(correction, 1e-6))
    ratios = np.where(np.isfinite(ratios), np.clip(ratios, _SHORTER, _LONGER), _SHORTER)
    return np.where(is_safe, ratios, np.minimum(ratios, 0.5))
