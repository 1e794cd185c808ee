"""Following: closed positions for several drives, from sample to sample.

Several drives have no positions in order, along which a branch could be kept. So samples are
closed one after the other as they are given: as many at once as an extrapolation from the last
one reaches safely, and by smaller steps where it does not reach the next one.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, as_text
from .all_groups import ClosedState, Kinematics
from .tolerances import CLOSURE_TOLERANCE

_SAFE_STEP = 0.1  # How far an extrapolation may be off.
_FEWEST, _MOST = 8, 512  # Samples tried at once.
_SMALLEST_SHARE = 1e-9  # of the way to the next sample.


def follow(kinematics: Kinematics, start: Array, columns: list[int], positions: Array) -> Array:
    """Return closed coordinates `(N, size)` at drive positions `(N, d)`.

    Args:
        kinematics: of the scene.
        start: `(size,)` closed coordinates to begin at.
        columns: of the drives among the coordinates.
        positions: in the order in which they are followed.

    Raises:
        AssemblyError: the loops cannot be closed on the way to a sample.
    """
    result = np.empty((len(positions), start.size))
    last, done, tried = start, 0, _FEWEST
    while done < len(positions):
        targets = positions[done : done + tried]
        found, safe = _reached(kinematics, last, columns, targets)
        count = len(targets) if np.all(safe) else int(np.argmin(safe))
        tried = min(max(2 * count, _FEWEST), _MOST)
        if count:
            result[done : done + count] = found.x[:count]
        else:
            result[done] = _towards(kinematics, last, columns, targets[0])
            count = 1
        done += count
        last = result[done - 1]
    return result


def _reached(
    kinematics: Kinematics, last: Array, columns: list[int], targets: Array
) -> tuple[ClosedState, Array]:
    """Close the loops at targets `(K, d)` from closed coordinates `(size,)`.

    Returns:
        What was found, and `(K,)` whether it is the way on from there.
    """
    coordinates = kinematics.coordinates
    here = kinematics.evaluate(np.repeat(last[None, :], len(targets), axis=0))
    step = targets - last[columns]
    with np.errstate(all="ignore"):  # What is out of reach is not used.
        v = kinematics.rates(here, step)
        a = kinematics.accelerations(here, v, np.zeros_like(step))
        way = coordinates.derivative(here.x, v) + 0.5 * coordinates.curvature(here.x, v, a)
        guess = here.x + way
        guess[:, columns] = targets
        found = kinematics.close(guess, most=6)
        safe = (found.residual < CLOSURE_TOLERANCE) & (found.correction < _SAFE_STEP)
        safe &= kinematics.same_side(found, here.inverses)
    return found, safe


def _towards(kinematics: Kinematics, last: Array, columns: list[int], target: Array) -> Array:
    """Return closed coordinates `(size,)` at a target `(d,)`, by as many steps as it takes.

    All drives move along the straight line from where they are.
    """
    share = 0.5
    while True:
        left = target - last[columns]
        to = target if share == 1.0 else last[columns] + share * left
        found, safe = _reached(kinematics, last, columns, to[None, :])
        if safe[0]:
            last = found.x[0]
            if share == 1.0:
                return last
            share = min(1.0, 2.0 * share)
            continue
        share *= 0.5
        if share < _SMALLEST_SHARE:
            raise AssemblyError(
                f"the loops cannot be closed at drive positions {as_text(target)}; on the way "
                f"there the nearest that were reached are {as_text(last[columns])}",
                position=target.copy(),
                nearest=last[columns].copy(),
                residual=float(found.residual[0]),
            )
