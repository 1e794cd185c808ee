"""Wrenches: joint wrenches in joint and world axes, and how their sizes are compared.

Arrays of wrenches are `(…, 2, 3, N)`: force [N], then moment [N·m].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .twists import cross

_LEAST_SQUARE, _GREATEST_SQUARE = 1e-200, 1e200
"""Squares of sizes between these are computed without loss.

Doubles overflow at 1.8e308 and lose digits below 2.2e-308; sums of three squares, and squares of
components that are a millionth of the greatest one, are still far from both.
"""


class JointWrenches(NamedTuple):
    """The wrenches of some joints on the bodies that those move.

    Attributes:
        in_joint_frames: `(J, 2, 3, N)` in the axes of the joint's frame, about its origin.
        in_world: `(J, 2, 3, N)` in world axes, about `Frames.corner`.
    """

    in_joint_frames: Array
    in_world: Array


def placed_in_world(wrenches: Array, joint_frames: Array) -> JointWrenches:
    """Return wrenches of joints together with what they are in the world.

    Args:
        wrenches: `(J, 2, 3, N)` in the frames of the joints.
        joint_frames: `(J, 4, 3, N)`, see `Frames.joint_frames`.
    """
    in_world = np.einsum("jkcn,jcin->jkin", wrenches, joint_frames[:, :3])
    in_world[:, 1] += cross(joint_frames[:, 3], in_world[:, 0])
    return JointWrenches(wrenches, in_world)


def taken_about(points: Array, wrenches: Array) -> Array:
    """Return wrenches `(B, 2, 3, N)`, overwritten by what they are about points `(B, 3, N)`."""
    wrenches[:, 1] -= cross(points, wrenches[:, 0])
    return wrenches


def greatest_size(wrenches: Array, length: float) -> Array:
    """Return `(N,)` the greatest size [N·m] of wrenches, see `greatest_sizes`."""
    return greatest_sizes(wrenches, length, len(wrenches))[0]


def greatest_sizes(wrenches: Array, length: float, first: int) -> tuple[Array, Array]:
    """Return the greatest sizes [N·m] of wrenches: of moments, and of forces times a length.

    Their squares may overflow: callers tell NumPy not to warn of it.

    Args:
        wrenches: `(B, 2, 3, N)`.
        length: that forces are multiplied with to compare them with moments [m].
        first: how many are a set of their own; the others are the second one.

    Returns:
        `(N,)` of either set; zero of a set of none.
    """
    squares = _squares(wrenches, length)
    return (
        _greatest(wrenches[:first], squares[:first], length),
        _greatest(wrenches[first:], squares[first:], length),
    )


def _greatest(wrenches: Array, squares: Array, length: float) -> Array:
    """Return `(N,)` the greatest size of wrenches with `_squares`."""
    if not len(wrenches):
        return np.zeros(wrenches.shape[-1])
    greatest = np.maximum.reduce(squares.reshape(-1, squares.shape[-1]), axis=0)
    lost = ~((greatest > _LEAST_SQUARE) & (greatest < _GREATEST_SQUARE))
    greatest = np.sqrt(greatest)
    if lost.any():
        # Squares overflow, or vanish, long before the wrenches do.
        parts = wrenches[..., lost]
        sizes = np.abs(parts).max(axis=(0, 1, 2))
        has_size = (sizes > 0.0) & (sizes < np.inf)
        scale = np.where(has_size, sizes, 1.0)
        whole = scale * np.sqrt(_squares(parts / scale, length).max(axis=(0, 1)))
        greatest[lost] = np.where(has_size, whole, sizes)
    return np.asarray(greatest)


def _squares(wrenches: Array, length: float) -> Array:
    """Return `(B, 2, N)` the squares of forces times a length, and of moments.

    They are infinite where squares overflow, and zero where they vanish.
    """
    squares = np.add.reduce(wrenches * wrenches, axis=2)
    squares[:, 0] *= length**2
    return np.asarray(squares)
