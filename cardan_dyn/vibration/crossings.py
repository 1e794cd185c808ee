"""Crossings: speeds at which an order meets a natural frequency, with the mode right there.

They are looked for in the modes about coordinates at rest, which are smooth functions of the speed
and cost next to nothing, so that a lattice of speeds can be fine. About a periodic motion, which
changes modes a little, a crossing is then found close to that one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import VibrationError
from .campbell import Campbell, campbell_of, followed, resting_campbell
from .motion_search import MotionSearch

_RATIO = 1.02
"""Of two speeds of the lattice that follow each other."""
_SLOW = 1e-3
"""Speed, as a fraction of the lowest natural frequency, at which modes are numbered."""
_ALIKE = 1e-6
"""Relative difference of two frequencies that are one at rest."""
_CLOSE = 0.05
"""Distance of a crossing about a motion from that about rest, as a fraction of the speed, from
which on the motion is no small change."""
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
        values: their eigenvalues `(n,)` [1/s].
        mode: its column there.
        whirl: its sense, see `Campbell.whirl`.
    """

    speed: float
    slope: float
    frequency: float
    decay: float
    shapes: Array
    values: Array
    mode: int
    whirl: float


def lattice(low: float, high: float) -> Array:
    """Return speeds `(S,)` between two, ascending, which are the same whatever the range."""
    first, last = sorted((abs(low), abs(high)))
    ends = np.log([first, last]) / np.log(_RATIO)
    speeds = _RATIO ** np.arange(np.ceil(ends[0]), np.floor(ends[1]) + 1.0)
    return np.unique(np.sign(high) * np.concatenate([[first], speeds, [last]]))


def numbered_campbell(
    search: MotionSearch, speeds: Array, aside: float = 0.0
) -> tuple[Campbell, Campbell]:
    """Return the modes about motions at speeds, and those about rest on the lattice.

    Both have the same numbers: by ascending frequency at next to no speed, backward before forward
    ones. The lattice begins there and goes on beyond the greatest speed.

    Args:
        search: of the scene.
        speeds: `(S,)` ascending, of one sense [rad/s].
        aside: how far beyond, as a fraction of the speed.

    Raises:
        VibrationError: see `campbell_of`.
    """
    found = campbell_of(search, speeds)
    first, last = sorted((abs(float(speeds[0])), abs(float(speeds[-1]))))
    sense = float(np.sign(speeds[-1]))
    begun = resting_campbell(search, sense * np.array([last, first])[:: -int(sense)]).frequency
    swings = begun[begun > 0.0]
    slow = min(first * (1.0 - aside), _SLOW * float(np.min(swings)) if swings.size else first)
    ends = sorted((sense * slow, sense * last * (1.0 + aside)))
    modes = _sorted_at_rest(resting_campbell(search, lattice(*ends)))
    return _numbered_alike(found, modes), modes


def _sorted_at_rest(found: Campbell) -> Campbell:
    """Return modes numbered by ascending frequency at their slowest speed."""
    rows = np.nonzero(np.all(np.isfinite(found.frequency), axis=1))[0]
    if not rows.size:
        return found
    row = int(rows[np.argmin(np.abs(found.speed[rows]))])
    frequency, whirl = found.frequency[row], np.round(found.whirl[row], 6)
    scale = _ALIKE * max(float(np.max(frequency)), 1e-300)
    return found.renumbered(np.lexsort((whirl, np.round(frequency / scale))))


def _numbered_alike(found: Campbell, modes: Campbell) -> Campbell:
    """Return a diagram with the numbers that its modes have in another one."""
    own, others = (
        np.nonzero(np.all(np.isfinite(item.frequency), axis=1))[0] for item in (found, modes)
    )
    if not own.size or not others.size:
        return found
    gaps = np.abs(found.speed[own][:, None] - modes.speed[others])
    at, near = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    row, of = int(own[at]), int(others[near])
    order = followed(modes.shape[of], _value(modes, of), found.shape[row], _value(found, row))
    return found.renumbered(order)


def crossings(search: MotionSearch, found: Campbell, order: float, mode: int) -> list[Crossing]:
    """Return where an order meets a mode about rest, ascending.

    Args:
        search: of the scene.
        found: its modes about rest at ascending speeds.
        order: cycles per revolution.
        mode: its column.
    """

    def modes_at(speeds: Array) -> Campbell:
        return resting_campbell(search, speeds)

    begun = [_interpolated(found, mode, *place) for place in between(found, order, mode)]
    return [
        _refined(modes_at, item, order, _interval(found.speed, item.speed)) or item
        for item in begun
    ]


def crossing_about_motion(search: MotionSearch, order: float, rest: Crossing) -> Crossing:
    """Return a crossing about the periodic motions close to one about rest; that one if none is."""

    def modes_at(speeds: Array) -> Campbell:
        return campbell_of(search, speeds)

    low, high = sorted(rest.speed * (1.0 + _CLOSE * np.array([-1.0, 1.0])))
    found = _refined(modes_at, rest, order, (low, high))
    return found if found is not None and low < found.speed < high else rest


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
    modes_at: Callable[[Array], Campbell],
    begin: Crossing,
    order: float,
    within: tuple[float, float],
) -> Crossing | None:
    """Return the crossing near another one, between two speeds; None without modes there."""
    at, slope = begin.speed, begin.slope
    for _ in range(_STEPS):
        beside = np.sort(at * (1.0 + _BESIDE * np.array([-1.0, 0.0, 1.0])))
        try:
            here = modes_at(beside)
        except VibrationError:
            return None
        if not np.all(np.isfinite(here.frequency)):
            return None
        columns = followed(begin.shapes, begin.values, here.shape[1], _value(here, 1))
        column = int(columns[begin.mode])
        gap = order * np.abs(beside) - here.frequency[:, column]
        slope = float((gap[2] - gap[0]) / (beside[2] - beside[0]))
        if abs(gap[1]) <= _MET * order * abs(at) or slope == 0.0:
            break
        at = min(max(at - float(gap[1]) / slope, within[0]), within[1])
    return Crossing(
        speed=at,
        slope=slope,
        frequency=float(here.frequency[1, column]),
        decay=float(here.decay[1, column]),
        shapes=here.shape[1],
        values=_value(here, 1),
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
    return Crossing(at, slope, frequency, decay, shapes, _value(found, row), mode, whirl)


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
