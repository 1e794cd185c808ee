"""Placing: where all joints of a description are, one after the other from the root outwards.

Vectors are in world axes; points are counted from `Frames.corner`, so that no digits are lost far
from the world's origin.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias, cast

import numpy as np

from ...kit.arrays import Array
from ..mechanism.frames import ElementaryMotion, Frames
from ..tape import Scalar, cos, sin
from .vectors import ZERO, Vector, add, combine, scale, times

Axes: TypeAlias = tuple[Vector, Vector, Vector]
WORLD_AXES: Axes = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class Frame(NamedTuple):
    """Three axes of unit length, at right angles, and an origin [m]."""

    axes: Axes
    origin: Vector


class Fixed(NamedTuple):
    """A frame that is fixed in that of a motion, or in the world.

    Attributes:
        motion: index of the motion, -1 for the world.
        axes: in that frame; None if they are its own.
        origin: likewise [m].
    """

    motion: int
    axes: Axes | None
    origin: Vector

    @staticmethod
    def of(motion: int, placement: Array) -> Fixed:
        """Return the frame with a `(4, 4)` placement."""
        x, y, z, origin = (constant(column) for column in placement[:3].T)
        axes = x, y, z
        return Fixed(motion, None if axes == WORLD_AXES else axes, origin)

    def on(self, carrier: Frame) -> Frame:
        """Return the frame where the one is that carries it."""
        axes, origin = carrier
        if self.axes is not None:
            x, y, z = self.axes
            axes = combine(axes, x), combine(axes, y), combine(axes, z)
        elif self.origin is ZERO:
            return carrier
        return Frame(axes, add(origin, combine(carrier.axes, self.origin)))


class Placing:
    """The frames of a description.

    Attributes:
        frames: what they are.
        joints: of each joint, in the frame of its last motion.
        loop_ends: of each loop, in its successor.
    """

    def __init__(self, frames: Frames) -> None:
        self.frames = frames
        self._world = Frame(WORLD_AXES, constant(-frames.corner))
        self._starts = [Fixed.of(item.before, item.placement) for item in frames.motions]
        self._axes = [constant(item.axis) for item in frames.motions]
        self.joints = [
            Fixed.of(last, frames.fixed_placement.get(joint, np.eye(4)))
            for joint, last in enumerate(frames.last)
        ]
        self.loop_ends = [
            Fixed.of(frames.last[body] if body >= 0 else -1, end)
            for body, end in zip(frames.children[frames.tree :], frames.ends, strict=True)
        ]

    def placed(self, x: Sequence[Scalar]) -> list[Frame]:
        """Return the frames of all motions at coordinates."""
        placed: list[Frame] = []
        for motion, start, axis in zip(self.frames.motions, self._starts, self._axes, strict=True):
            placed.append(_moved(self.at(placed, start), motion, axis, x))
        return placed

    def at(self, placed: Sequence[Frame], fixed: Fixed) -> Frame:
        """Return a fixed frame, with the frames of the motions placed."""
        return fixed.on(self._world if fixed.motion < 0 else placed[fixed.motion])

    def joint_frames(self, placed: Sequence[Frame]) -> list[Frame]:
        """Return the frames of all joints."""
        return [self.at(placed, joint) for joint in self.joints]


def constant(vector: Array) -> Vector:
    """Return a vector `(3,)` of numbers."""
    x, y, z = vector.tolist()
    return (x, y, z) if x or y or z else ZERO


def stacked(vectors: Sequence[Vector], count: int) -> Array:
    """Return k vectors of that many samples as an array `(k, 3, N)`."""
    result = np.empty((len(vectors), 3, count))
    for row, vector in zip(result, vectors, strict=True):
        row[0], row[1], row[2] = vector
    return result


def _moved(start: Frame, motion: ElementaryMotion, axis: Vector, x: Sequence[Scalar]) -> Frame:
    """Return where a motion brings a frame, from where it is at zero."""
    axes, origin = start
    if motion.kind == "slide":
        return Frame(axes, add(origin, scale(combine(axes, axis), x[motion.column])))
    if motion.kind == "turn":
        return Frame(_turned(axes, axis, x[motion.column]), origin)
    x_axis, y_axis, z_axis = _rotation(*x[motion.column : motion.column + 4])
    return Frame((combine(axes, x_axis), combine(axes, y_axis), combine(axes, z_axis)), origin)


def _turned(axes: Axes, axis: Vector, angle: Scalar) -> Axes:
    """Return axes after a turn about `axis`, which is given in them.

    Rodrigues: e' = e cos φ + n × e sin φ + n (n · e) (1 - cos φ); Siciliano et al. (2009),
    chapter 2.
    """
    sine, cosine = sin(angle), cos(angle)
    turned = []
    for k, own in enumerate(axes):
        if axis[k] in (1.0, -1.0):
            turned.append(own)
            continue
        i, j = (k + 1) % 3, (k + 2) % 3
        sines = times(sine, axis[j]), times(sine, -axis[i])
        moved = combine((own, axes[i], axes[j]), (cosine, *sines))
        if axis[k]:
            moved = add(moved, scale(combine(axes, axis), (1.0 - cosine) * axis[k]))
        turned.append(moved)
    return cast("Axes", tuple(turned))


def _rotation(x: Scalar, y: Scalar, z: Scalar, w: Scalar) -> Axes:
    """Return what a unit quaternion turns x, y and z to; Siciliano et al. (2009), chapter 2."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)),
        (2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)),
        (2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)),
    )
