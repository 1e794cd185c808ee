"""Loop geometry: the two ends of a loop, the joints between them, the axes of its equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, cross
from .batch_model import placement

_HALF_TURN = 1e-12
"""Four times the squared cosine of half an angle up to which a rotation counts as a half turn: it
is then within 1e-6 rad of one. A smaller square would lose its digits in rounding: of 1e-12, the
rounding of its terms, 1e-16, is already 1e-4."""


_UNROTATED = np.eye(3)
_BELOW_DIAGONAL, _ABOVE_DIAGONAL = np.array([7, 2, 3]), np.array([5, 6, 1])
"""Entries (z, y), (x, z), (y, x) of a matrix of nine numbers in a row, and their mirror images."""


class LoopEnd(NamedTuple):
    """One end of a loop, where it is welded.

    Attributes:
        body: index of the body in the batch model, -1 for the base.
        rotation, translation: `(3, 3)` and `(3,)` placement of the weld in that body; on the base,
            about the batch model's origin.
        is_rotated, is_shifted: whether they differ from the identity and from zero.
    """

    body: int
    rotation: Array
    translation: Array
    is_rotated: bool
    is_shifted: bool

    @staticmethod
    def of(body: int, rotation: Array, translation: Array) -> LoopEnd:
        """Return the end of a loop that is placed like this in a body."""
        is_rotated = bool((rotation != _UNROTATED).any())
        return LoopEnd(body, rotation, translation, is_rotated, bool(translation.any()))

    def placement_on_base(self, actions: Array) -> tuple[Array, Array]:
        """Return rotation `(3, 3, N)` and position `(3, N)` of the weld about the batch's origin.

        N is 1 for an end on the base.
        """
        if self.body < 0:
            return self.rotation[:, :, None], self.translation[:, None]
        rotation, position = placement(actions, self.body)
        if self.is_shifted:
            position = position + np.matmul(self.translation, rotation)
        if self.is_rotated:
            rotation = np.matmul(self.rotation.T, rotation)
        return rotation, position


class LoopPath(NamedTuple):
    """The moving coordinates of a loop, from the common ancestor outwards on both sides.

    Attributes:
        columns: `(k,)` their indices among the movable coordinates.
        signs: `(k, 1)` 1 on the predecessor's side, -1 on the successor's.
        carries: `(k, k)` 1 where the coordinate of the column moves the joint of the row's.
    """

    columns: Array
    signs: Array
    carries: Array

    @staticmethod
    def of(column_signs: Array, moved_bodies: Array) -> LoopPath:
        """Return the path of a loop.

        Args:
            column_signs: `(m,)` on which side of it each movable coordinate is, see
                `ClosureEquations`.
            moved_bodies: `(m,)` body that each of them moves.
        """
        sides = [np.nonzero(column_signs == side)[0] for side in (1.0, -1.0)]
        # The coordinates of a ball stay in their order, hence a stable sort.
        sorted_sides = [side[np.argsort(moved_bodies[side], kind="stable")] for side in sides]
        columns = np.concatenate(sorted_sides)
        bodies, signs = moved_bodies[columns], column_signs[columns]
        # On one side of a loop, a body with a smaller index carries all that follow.
        carries = (bodies[:, None] > bodies) & np.equal.outer(signs, signs)
        return LoopPath(columns, signs[:, None], carries.astype(float))

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return `(6, N)` accelerations, predecessor less successor, that rates alone cause.

        Args:
            twists: `(N, m, 6)` unit twists of the movable coordinates.
            rates: `(N, m)` of these coordinates.
        """
        joint = twists[:, self.columns] * rates[:, self.columns, None]
        joint = joint.transpose(2, 1, 0)
        carrier = np.matmul(self.carries, joint)
        joint = joint * self.signs
        # A joint's twist (v, ω) that moves with the twist (V, Ω) of its carrier changes by
        # (Ω × v + V × ω, Ω × ω). One call makes all three products.
        count = len(self.columns)
        products = cross(
            np.concatenate((carrier[3:], carrier[:3], carrier[3:]), axis=1),
            np.concatenate((joint[:3], joint[3:], joint[3:]), axis=1),
        )
        linear = products[:, : 2 * count].sum(axis=1)
        angular = products[:, 2 * count :].sum(axis=1)
        return np.concatenate((linear, angular))


class LoopAxes(NamedTuple):
    """The axes in which a loop's rows are chosen.

    Attributes:
        body: index in the batch model of the body that carries the loop, -1 for the base.
        point: `(3,)` point in that body about which twists are taken there.
    """

    body: int
    point: Array

    def matrices(self, actions: Array) -> Array:
        """Return `(N, 6, 6)` matrices between these axes and the base's about the batch's origin.

        A twist in the base's axes (a row) times them is that twist in these axes. They times a
        wrench in these axes (a column) are that wrench in the base's axes.
        """
        rotation, position = placement(actions, self.body)
        point = position + np.matmul(self.point, rotation)
        columns = rotation.transpose(2, 0, 1)
        result = np.zeros((len(actions), 6, 6))
        result[:, :3, :3] = result[:, 3:, 3:] = columns
        result[:, 3:, :3] = np.cross(point.T[:, :, None], columns, axis=1)
        return result


def gap_between(ends: tuple[LoopEnd, LoopEnd], actions: Array) -> tuple[Array, Array, Array]:
    """Return how far a loop is from closed.

    Args:
        ends: of the loop, the predecessor's first.
        actions: see `BatchModel.actions`.

    Returns:
        Vectors `(3, N)`: from the successor's weld to the predecessor's [m], the rotation between
        them (see `rotations_between`), and the point halfway from the batch model's origin [m].
    """
    (rotation_1, position_1), (rotation_2, position_2) = (
        end.placement_on_base(actions) for end in ends
    )
    turn = rotations_between(rotation_1, rotation_2)
    return position_1 - position_2, turn, 0.5 * (position_1 + position_2)


def rotations_between(first: Array, second: Array) -> Array:
    """Return the rotations `(3, N)` that take second frames to first ones, both `(3, 3, N)`.

    Along the axis, twice the sine of half the angle: the angle itself where it is small.
    """
    # Constant frames on the base leave a product of matrices, which is the fastest.
    if second.shape[2] == 1:
        relative = np.matmul(second[:, :, 0], first)
    elif first.shape[2] == 1:
        relative = np.matmul(first[:, :, 0], second).transpose(1, 0, 2)
    else:
        relative = np.add.reduce(first[:, None] * second, axis=2)
    relative = relative.reshape(9, -1)
    # Of a rotation R, the differences R[k, j] - R[j, k] are the axis times twice the sine.
    vector = relative.take(_BELOW_DIAGONAL, 0)
    vector -= relative.take(_ABOVE_DIAGONAL, 0)
    # Its trace plus one is four times the squared cosine of half the angle.
    square = relative[0] + relative[4] + relative[8] + 1.0
    if not square.min() > _HALF_TURN:
        return _with_half_turns(vector, square, first, second)
    vector /= np.sqrt(square)
    return np.asarray(vector)


def _with_half_turns(sines: Array, square: Array, first: Array, second: Array) -> Array:
    """Return rotations, some of which are half turns: their sines vanish and show no axis.

    Args:
        sines: `(3, N)` axes times twice the sines of the angles.
        square: `(N,)` four times the squared cosines of half the angles.
        first: `(3, 3, N)` or `(3, 3, 1)`.
        second: likewise.
    """
    is_half = ~(square > _HALF_TURN)
    result = sines / np.sqrt(np.where(is_half, 1.0, square))
    for sample in np.nonzero(is_half)[0]:
        to, start = (frames[:, :, sample % frames.shape[2]] for frames in (first, second))
        # R + 1 = 2 n nᵀ for a half turn about n; its longest column gives n most accurately.
        columns = to @ start.T + np.eye(3)
        axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
        result[:, sample] = 2.0 * axis / np.linalg.norm(axis)
    return result
