"""Loop geometry: the two ends of a loop, the joints between them, the axes of its equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, cross
from .batch_model import placement


class LoopEnd(NamedTuple):
    """One end of a loop, where it is welded.

    Attributes:
        body: number of the joint that moves the body (0-based), -1 for the world.
        rotation, translation: constant placement of the weld in that body.
        turned, moved: whether they are more than the identity.
    """

    body: int
    rotation: Array
    translation: Array
    turned: bool
    moved: bool

    @staticmethod
    def of(body: int, rotation: Array, translation: Array) -> LoopEnd:
        """Return the end of a loop that is placed like this in a body."""
        turned, moved = bool(np.any(rotation != np.eye(3))), bool(np.any(translation))
        return LoopEnd(body, rotation, translation, turned, moved)

    def place(self, actions: Array) -> tuple[Array, Array]:
        """Return rotation `(3, 3, N)` and position `(3, N)` of the weld, N = 1 in the world."""
        if self.body < 0:
            return self.rotation[:, :, None], self.translation[:, None]
        rotation, position = placement(actions, self.body)
        if self.moved:
            position = position + np.einsum("ikn,k->in", rotation, self.translation)
        if self.turned:
            rotation = np.einsum("ikn,kj->ijn", rotation, self.rotation)
        return rotation, position


class LoopPath(NamedTuple):
    """The moving coordinates of a loop, from the common ancestor outwards on both sides.

    Attributes:
        columns: their places among the moving coordinates.
        signs: `(k, 1)` 1 on the predecessor's side, -1 on the successor's.
        before: `(k, k)` 1 where the second one moves the joint of the first.
    """

    columns: Array
    signs: Array
    before: Array

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return `(6, N)` accelerations, predecessor less successor, that rates alone cause."""
        own = twists[:, self.columns] * rates[:, self.columns, None]
        own = own.transpose(2, 1, 0)
        carried = np.matmul(self.before, own)
        own = own * self.signs
        # Of a twist (v, w) carried with another one: linear w × v + v × w, angular w × w.
        count = len(self.columns)
        parts = cross(
            np.concatenate((carried[3:], carried[:3], carried[3:]), axis=1),
            np.concatenate((own[:3], own[3:], own[3:]), axis=1),
        )
        linear, angular = parts[:, : 2 * count].sum(axis=1), parts[:, 2 * count :].sum(axis=1)
        return np.concatenate((linear, angular))


class LoopAxes(NamedTuple):
    """The axes in which a loop's rows are chosen.

    Attributes:
        body: place in the batch model of the body that carries the loop, -1 for the world.
        point: `(3,)` point in that body about which twists are taken there.
    """

    body: int
    point: Array

    def matrices(self, actions: Array) -> Array:
        """Return `(N, 6, 6)` matrices: a twist (a row, in world axes) times them is one here.

        Times a wrench here (a column), they give the wrench in world axes.
        """
        rotation, position = placement(actions, self.body)
        point = position + np.einsum("ikn,k->in", rotation, self.point)
        columns = rotation.transpose(2, 0, 1)
        result = np.zeros((len(actions), 6, 6))
        result[:, :3, :3] = result[:, 3:, 3:] = columns
        result[:, 3:, :3] = np.cross(point.T[:, :, None], columns, axis=1)
        return result


def rotations_between(first: Array, second: Array) -> Array:
    """Return the rotations `(3, N)` that take second frames to first ones, both `(3, 3, N)`.

    Along the axis, twice the sine of half the angle: the angle itself where it is small.
    """
    # The cross products of corresponding axes sum up to the axis times twice the sine.
    vector = cross(second, first).sum(axis=1)
    product = first * second
    # The trace of the rotation and one more are four times the squared cosine of half the angle.
    square = product.reshape(9, -1).sum(axis=0) + 1.0
    if not square.min() > 1e-12:
        return _half_turns(vector, square, first, second)
    vector /= np.sqrt(square)
    return np.asarray(vector)


def _half_turns(vector: Array, square: Array, first: Array, second: Array) -> Array:
    """Return rotations some of which are half turns, whose axis the products do not tell."""
    half = ~(square > 1e-12)
    vector /= np.sqrt(np.where(half, 1.0, square))
    for sample in np.nonzero(half)[0]:
        one, other = (part[:, :, sample % part.shape[2]] for part in (first, second))
        columns = one @ other.T + np.eye(3)
        axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
        vector[:, sample] = 2.0 * axis / np.linalg.norm(axis)
    return vector
