"""Crossings: speeds at which an order meets a natural frequency, with the mode right there.

Between the speeds of a Campbell diagram they are interpolated; modes at such a place and close
beside it then tell where it is, since frequencies may bend and dampings change from one speed of
a coarse diagram to the next.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import VibrationError
from .campbell import Campbell, campbell_of, followed
from .motion_search import MotionSearch

_BESIDE = 1e-4
"""Distance of two speeds between which slopes are taken, as a fraction of the speed."""
_MET = 1e-10
"""Gap between order and frequency, as a fraction of it, at which they meet."""
_STEPS = 8


class Crossing(NamedTuple):
    """A speed at which an order meets a mode's frequency.

    Attributes:
        speed: of the drive [rad/s].
        slope: by how much order times speed grows faster than the frequency, per rad/s.
        frequency, decay: of the mode there [rad/s, 1/s].
        shapes: of all modes `(n, n)`, a column for each.
        mode: its column there.
        whirl: its sense, see `Campbell.whirl`.
    """

    speed: float
    slope: float
    frequency: float
    decay: float
    shapes: Array
    mode: int
    whirl: float


def crossings(search: MotionSearch, found: Campbell, order: float, mode: int) -> list[Crossing]:
    """Return where an order meets a mode, ascending.

    Args:
        search: of the scene.
        found: its modes at ascending speeds.
        order: cycles per revolution.
        mode: its column.
    """
    return [
        _refined(search, found, order, mode, place) or _interpolated(found, mode, *place)
        for place in between(found, order, mode)
    ]


def between(found: Campbell, order: float, mode: int) -> list[tuple[float, float]]:
    """Return where an order meets a mode's frequency, interpolated, with the slopes of the gap."""
    # Speeds without a motion lie at undamped resonances: their neighbours tell where.
    is_there = np.isfinite(found.frequency[:, mode])
    speed = found.speed[is_there]
    gap = order * np.abs(speed) - found.frequency[is_there, mode]
    # A crossing at one of the speeds belongs to the interval that begins there, or to the last.
    is_met = (gap[:-1] == 0.0) | (gap[:-1] * gap[1:] < 0.0)
    is_met[-1:] |= gap[-1:] == 0.0
    places = np.nonzero(is_met)[0]
    slopes = np.diff(gap)[places] / np.diff(speed)[places]
    at = speed[places] - gap[places] / np.where(slopes == 0.0, 1.0, slopes)
    return list(zip(at.tolist(), slopes.tolist(), strict=True))


def _refined(
    search: MotionSearch, found: Campbell, order: float, mode: int, place: tuple[float, float]
) -> Crossing | None:
    """Return the crossing near an interpolated one; None without a motion there."""
    at, slope = place
    row = _nearest(found, mode, at)
    low, high = _interval(found.speed, at)
    for _ in range(_STEPS):
        beside = np.sort(at * (1.0 + _BESIDE * np.array([-1.0, 0.0, 1.0])))
        try:
            here = campbell_of(search, beside)
        except VibrationError:
            return None
        if not np.all(np.isfinite(here.frequency)):
            return None
        columns = followed(found.shape[row], _value(found, row), here.shape[1], _value(here, 1))
        column = int(columns[mode])
        gap = order * np.abs(beside) - here.frequency[:, column]
        slope = float((gap[2] - gap[0]) / (beside[2] - beside[0]))
        if abs(gap[1]) <= _MET * order * abs(at) or slope == 0.0:
            break
        at = min(max(at - float(gap[1]) / slope, low), high)
    return Crossing(
        speed=at,
        slope=slope,
        frequency=float(here.frequency[1, column]),
        decay=float(here.decay[1, column]),
        shapes=here.shape[1],
        mode=column,
        whirl=float(here.whirl[1, column]),
    )


def _interpolated(found: Campbell, mode: int, at: float, slope: float) -> Crossing:
    """Return a crossing by the modes of the diagram beside it."""
    is_there, row = np.isfinite(found.frequency[:, mode]), _nearest(found, mode, at)
    frequency, decay = (
        float(np.interp(at, found.speed[is_there], values[is_there, mode]))
        for values in (found.frequency, found.decay)
    )
    shapes, whirl = found.shape[row], float(found.whirl[row, mode])
    return Crossing(at, slope, frequency, decay, shapes, mode, whirl)


def _nearest(found: Campbell, mode: int, at: float) -> int:
    """Return the row of a diagram, with a motion, that is next to a speed."""
    is_there = np.isfinite(found.frequency[:, mode])
    return int(np.argmin(np.where(is_there, np.abs(found.speed - at), np.inf)))


def _interval(speeds: Array, at: float) -> tuple[float, float]:
    """Return the speeds on both sides of one, of ascending ones."""
    right = int(np.clip(np.searchsorted(speeds, at), 1, len(speeds) - 1))
    return float(speeds[right - 1]), float(speeds[right])


def _value(found: Campbell, row: int) -> Array:
    """Return the eigenvalues `(n,)` of a row [1/s]."""
    return np.asarray(found.decay[row] + 1j * found.frequency[row])
