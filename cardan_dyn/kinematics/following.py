"""Following a path: closed positions for several drives, from sample to sample.

Samples of a path are closed one after the other as they are given: as many at once as an
extrapolation from the last one reaches safely, and by smaller steps where it does not reach even
the next one.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, as_text
from .all_groups import ClosedState, Kinematics
from .straight_lines import MOST_CORRECTIONS, along_lines, extrapolated, is_safe_step

_SMALLEST_BATCH, _LARGEST_BATCH = 8, 512
"""Samples tried at once: few where most of them would be thrown away, and not so many that arrays
become large. Between the two, a batch is twice as large as the last one was successful."""


def follow(kinematics: Kinematics, start: Array, columns: list[int], positions: Array) -> Array:
    """Return closed coordinates `(N, size)` at drive positions `(N, d)`.

    Args:
        kinematics: of the scene.
        start: `(size,)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: in the order in which they are followed [rad or m].

    Raises:
        AssemblyError: the loops cannot be closed on the way to a sample.
    """
    result = np.empty((len(positions), start.size))
    last, count, batch_size = start, 0, _SMALLEST_BATCH
    while count < len(positions):
        targets = positions[count : count + batch_size]
        state, is_safe = _one_step(kinematics, last, columns, targets)
        reached = len(targets) if np.all(is_safe) else int(np.argmin(is_safe))
        batch_size = min(max(2 * reached, _SMALLEST_BATCH), _LARGEST_BATCH)
        if reached:
            result[count : count + reached] = state.x[:reached]
        else:
            way = along_lines(kinematics, last[None, :], columns, targets[:1])
            if not way.is_there[0]:
                raise beyond_reach(
                    kinematics, columns, targets[0], way.x[0], way.residual[0], count
                )
            result[count], reached = way.x[0], 1
        count += reached
        last = result[count - 1]
    return result


def _one_step(
    kinematics: Kinematics, last: Array, columns: list[int], targets: Array
) -> tuple[ClosedState, Array]:
    """Close the loops at targets `(K, d)`, each in one step from closed coordinates `(size,)`.

    Returns:
        The states, and `(K,)` whether they are in the same assembly mode.
    """
    coordinates = kinematics.coordinates
    before = kinematics.evaluate(last[None, :])
    x = np.broadcast_to(last, (len(targets), last.size))
    step = targets - last[columns]
    with np.errstate(all="ignore"):  # Targets out of reach may overflow; they are not safe.
        v = kinematics.rates(before, step)
        a = kinematics.accelerations(before, v, np.zeros_like(step))
        guess, longest = extrapolated(coordinates, x, v, a)
        guess[:, columns] = targets
        state = kinematics.close(guess, most=MOST_CORRECTIONS)
        is_safe = is_safe_step(kinematics, state, before.inverses) & (longest >= 1.0)
    return state, is_safe


def beyond_reach(
    kinematics: Kinematics,
    columns: list[int],
    target: Array,
    nearest: Array,
    residual: float,
    sample: int,
) -> AssemblyError:
    """Return the error for drive positions that a straight line does not reach.

    Args:
        kinematics: that closed the loops.
        columns: columns of the drives in a row of coordinates.
        target: `(d,)` positions that were asked for [rad or m].
        nearest: `(size,)` closed coordinates where the line ended.
        residual: closure error of the step beyond.
        sample: index of the target.
    """
    from .gimbal_lock import gimbal_note  # Only errors need it.

    passives = [column for solver in kinematics.solvers for column in solver.group.passives]
    note = gimbal_note(kinematics.coordinates, nearest, passives)
    return AssemblyError(
        f"the loops cannot be closed at drive positions {as_text(target)}; on the way there the "
        f"nearest that were reached are {as_text(nearest[columns])}{note}",
        position=target.copy(),
        nearest=nearest[columns].copy(),
        residual=float(residual),
        sample=sample,
        hint=note,
    )
