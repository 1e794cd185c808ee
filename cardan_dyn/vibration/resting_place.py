"""Resting place: where free coordinates stand in the mean while the drive turns."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import CardanError
from .efforts import FreeEfforts

_POSITIONS = 24
_STEP = 1e-4
"""Step of differences, in units of the coordinates."""
_LONGEST = 0.5
"""Longest step of Newton's method, in units of the coordinates."""
_MOST_STEPS = 40
_PLACED = 1e-3
"""Step, in units of the coordinates, at which the place is good enough to begin with."""


def resting_place(efforts: FreeEfforts, start: Array, speeds: Array, units: Array) -> Array:
    """Return places `(n,)` at which mean efforts vanish; the start if none is met.

    Args:
        efforts: of the scene; their means are those over a revolution of the drive.
        start: places of the free coordinates to begin with `(n,)`.
        speeds: of the drive; the median one counts.
        units: of the coordinates `(n,)`.
    """
    speed, free = float(np.median(speeds)), len(start)
    drive = 2.0 * np.pi / _POSITIONS * np.arange(_POSITIONS)
    ways = np.vstack([np.zeros(free), _STEP * np.diag(units)])

    def mean_efforts(places: Array) -> Array:
        q = np.repeat(places, _POSITIONS, axis=0)
        positions = np.column_stack([np.tile(drive, len(places)), q])
        still = np.zeros_like(positions)
        rates = still.copy()
        rates[:, 0] = speed
        return efforts(positions, rates, still).reshape(len(places), _POSITIONS, free).mean(axis=1)

    place = start.copy()
    try:
        for _ in range(_MOST_STEPS):
            values = mean_efforts(place + ways)
            slopes = (values[1:] - values[0]).T / (_STEP * units)
            step = np.linalg.solve(slopes, -values[0])
            length = float(np.max(np.abs(step) / units))
            place = place + step * min(1.0, _LONGEST / length if length else 1.0)
            if length <= _PLACED:
                return place
    except (CardanError, np.linalg.LinAlgError):
        pass  # Nothing holds a coordinate, or the way leaves what the mechanism can do.
    return start
