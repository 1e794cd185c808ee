"""Task in time: how what follows a task moves as its rows do, and the other way round."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from ..kit.arrays import Array
from ..motion.simulation.continuity import States
from ..motion.simulation.prescribed_motion import Written
from ..motion.simulation.system import Motion
from .tasks import Block

_TERMS = range(10)
_OF_FIRST = Polynomial([(-1.0) ** k / math.factorial(2 * k + 2) for k in _TERMS])
_OF_SECOND = Polynomial([(-1.0) ** k / math.factorial(2 * k + 3) for k in _TERMS])
"""Series of (1 - cos r) / r² and (r - sin r) / r³ in r² up to 1."""


def drive_motions(block: Block, rows: Mapping[str, Motion]) -> dict[str, Motion]:
    """Return how the drives of a block move.

    Args:
        block: of a task.
        rows: its rows to how they move; of a rotation vector with its own rates.
    """
    motions = [rows[name] for name in block.rows]
    kinks = [getattr(motion, "kinks", ()) for motion in motions]
    at: list[Motion] = [*map(_Shifted, motions, block.start.tolist())]
    if block.turned is not None:
        pose = _Pose(block, motions)
        at = [_OfPose(pose, column) for column in range(len(block.drives))]
    kinks += [()] * (len(block.drives) - len(kinks))
    return {
        name: Written(f"motion[{name!r}]", (of_drive,), own)
        for name, of_drive, own in zip(block.drives, at, kinks, strict=True)
    }


def row_states(block: Block, drives: States) -> States:
    """Return how rows of a block move, of a rotation with its angular velocity and acceleration.

    Args:
        block: of a task.
        drives: how its drives move `(N, d)`.
    """
    if block.turned is None:
        return drives._replace(x=drives.x + block.start)
    x = np.array([block.rows_at(columns) for columns in drives.x])
    axes, rates = _axes(drives.x[:, 6:]), drives.v[:, 6:]
    v, a = (
        np.concatenate([part[:, :3], (axes @ part[:, 6:, None])[..., 0]], axis=-1)
        for part in (drives.v, drives.a)
    )
    a[:, 3:] += _carried(axes, rates)
    return States(x, v, a)


@dataclass(frozen=True)
class _Shifted:
    """How a drive moves that counts from where the scene starts."""

    motion: Motion
    start: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        position, speed, acceleration = self.motion(time)
        return position - self.start, speed, acceleration


class _Pose:
    """How the drives of a pose move: slides, turns that rest, and three Cardan angles."""

    def __init__(self, block: Block, motions: list[Motion]) -> None:
        self._block, self._motions = block, motions
        self._known: tuple[float, Array] = np.nan, np.zeros((3, 0))

    def at(self, time: float) -> Array:
        """Return positions, speeds and accelerations `(3, d)`, which every drive asks for."""
        known, found = self._known
        if time != known:
            rows = np.array([motion(time) for motion in self._motions]).T
            found = np.zeros((3, len(self._block.drives)))
            found[0] = self._block.positions(rows[0], along_path=False)
            found[1:, :3] = rows[1:, :3]
            spin, gain = _spin(*rows[:, 3:])
            axes = _axes(found[0, 6:])
            found[1, 6:] = np.linalg.solve(axes, spin)
            found[2, 6:] = np.linalg.solve(axes, gain - _carried(axes, found[1, 6:]))
            self._known = time, found
        return found


@dataclass(frozen=True)
class _OfPose:
    """How one drive of a pose moves."""

    pose: _Pose
    column: int

    def __call__(self, time: float) -> tuple[float, float, float]:
        position, speed, acceleration = self.pose.at(time)[:, self.column].tolist()
        return position, speed, acceleration


def _spin(vector: Array, rate: Array, bend: Array) -> tuple[Array, Array]:
    """Return angular velocity and acceleration `(3,)` of a rotation vector and its rates.

    Source: Bullo and Murray 1995, the derivative of the exponential map of rotations.
    """
    square = float(vector @ vector)
    if square < 1.0:
        first, second = _OF_FIRST(square), _OF_SECOND(square)
        by_first, by_second = _OF_FIRST.deriv()(square), _OF_SECOND.deriv()(square)
    else:
        angle = math.sqrt(square)
        first = (1.0 - math.cos(angle)) / square
        second = (angle - math.sin(angle)) / (angle * square)
        by_first = (math.sin(angle) / angle - 2.0 * first) / (2.0 * square)
        by_second = (first - 3.0 * second) / (2.0 * square)
    growth = 2.0 * float(vector @ rate)
    across, bent = np.cross(vector, rate), np.cross(vector, bend)
    twice = np.cross(vector, across)
    spin = rate + first * across + second * twice
    gain = bend + growth * (by_first * across + by_second * twice) + first * bent
    gain += second * (np.cross(rate, across) + np.cross(vector, bent))
    return spin, gain


def _axes(angles: Array) -> Array:
    """Return the axes `(..., 3, 3)`, as columns, about which Cardan angles `(..., 3)` turn."""
    (a, b), zero = np.moveaxis(angles[..., :2], -1, 0), np.zeros_like(angles[..., 0])
    x, y = (zero + 1.0, zero, zero), (zero, np.cos(a), np.sin(a))
    z = np.sin(b), -np.sin(a) * np.cos(b), np.cos(a) * np.cos(b)
    return np.stack([np.stack(axis, axis=-1) for axis in (x, y, z)], axis=-1)


def _carried(axes: Array, rates: Array) -> Array:
    """Return the angular acceleration `(..., 3)` of axes that carry each other, at even rates."""
    x, y, z = np.moveaxis(axes * rates[..., None, :], -1, 0)
    return np.asarray(np.cross(x, y) + np.cross(x + y, z))
