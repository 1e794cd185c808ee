"""Placing: how a frame follows from the one before it, with all that no position changes.

Frames are `(4, 3, N)`: three axes and an origin in world axes. Which entries of a placement are
zero and about which axes joints turn is found once, so that few samples are placed in few steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array

_IDENTITY = np.eye(4)


class Offset(NamedTuple):
    """A constant placement in the frame of a motion, or in the world.

    Attributes:
        before: index of the motion, -1 for the world.
        transposed: `(4, 4)` transposed placement in the motion's frame; None if it is that frame.
        in_world: `(4, 3, 1)` the frame itself where it is placed in the world, else None.
    """

    before: int
    transposed: Array | None
    in_world: Array | None

    @staticmethod
    def of(before: int, placement: Array, corner: Array) -> Offset:
        """Return the offset of a placement.

        Args:
            before: see the attribute.
            placement: `(4, 4)`.
            corner: `(3,)` the point of the world that origins are counted from.
        """
        if before < 0:
            columns = placement[:3].T.copy()
            columns[3] -= corner
            return Offset(before, None, columns[:, :, None])
        same = np.array_equal(placement, _IDENTITY)
        return Offset(before, None if same else np.ascontiguousarray(placement.T), None)

    def frame(self, frames: Array | dict[int, Array]) -> Array:
        """Return the frame, `(4, 3, N)`, or `(4, 3, 1)` in the world.

        Args:
            frames: of the motions.
        """
        if self.in_world is not None:
            return self.in_world
        frame = frames[self.before]
        if self.transposed is None:
            return frame
        return np.asarray(np.matmul(self.transposed, frame.reshape(4, -1)).reshape(frame.shape))


class Turn:
    """A turn about an axis of the frame before it."""

    def __init__(self, axis: Array) -> None:
        """Keep what the axis `(3,)`, a unit vector in that frame, decides."""
        along = int(np.argmax(np.abs(axis)))
        self._along, self._second, self._third = along, (along + 1) % 3, (along + 2) % 3
        self._sign = float(axis[along])
        self._is_along = axis[self._second] == 0.0 and axis[self._third] == 0.0
        x, y, z = axis
        self._linear = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        self._quadratic = np.ascontiguousarray(self._linear @ self._linear)

    def write(self, frame: Array, start: Array, cosine: Array, sine: Array) -> None:
        """Write into `frame` what a frame `start` is after the turn.

        Args:
            frame: `(4, 3, N)` the result.
            start: `(4, 3, N)` or `(4, 3, 1)`.
            cosine: `(N,)` of the angle.
            sine: `(N,)` of the angle.
        """
        frame[3] = start[3]
        if self._is_along:
            if self._sign != 1.0:
                sine = sine * self._sign
            second, third = start[self._second], start[self._third]
            frame[self._along] = start[self._along]
            np.add(cosine * second, sine * third, out=frame[self._second])
            np.subtract(cosine * third, sine * second, out=frame[self._third])
            return
        # Rodrigues: R = 1 + sin K + (1 - cos) K², applied to the three axes of the frame.
        axes = start[:3].reshape(3, -1)
        linear = (self._linear @ axes).reshape(3, 3, -1)
        quadratic = (self._quadratic @ axes).reshape(3, 3, -1)
        # 1 - cos, without cancellation for small angles.
        versine = np.where(cosine > 0.0, sine**2 / (1.0 + np.abs(cosine)), 1.0 - cosine)
        frame[:3] = start[:3] + sine * linear + versine * quadratic


def rotations(q: Array) -> Array:
    """Return the rotations `(3, 3, N)` of unit quaternions `(4, N)`, x, y, z, w."""
    x, y, z, w = q
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
