"""Coordinates: how rows of joint coordinates move, and what they are for Pinocchio."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array, quaternion_product
from .joints import Joint


class Moves(NamedTuple):
    """Displacements along chosen velocity coordinates.

    Attributes:
        columns, steps: columns of a row that change by the numbers in these places of a step.
        slides: places of steps that are lengths.
        balls: column of a quaternion and place of the rotation vector that turns it.
    """

    columns: Array
    steps: Array
    slides: Array
    balls: list[tuple[int, int]]

    def apply(self, x: Array, step: Array) -> None:
        """Move rows `x (N, size)` by displacements `step (N, k)`, in place."""
        x[:, self.columns] += step[:, self.steps]
        for column, start in self.balls:
            turn = _exponential(step[:, start : start + 3])
            x[:, column : column + 4] = quaternion_product(x[:, column : column + 4], turn)


class Coordinates:
    """Joint coordinates of many samples and what they are in Pinocchio's models.

    A sample is a row of one number per turning part of a joint (the angle [rad], which keeps count
    of turns), one per sliding part [m] and a unit quaternion (x, y, z, w) per ball. Velocities have
    Pinocchio's layout.

    Attributes:
        size: numbers per row.
        starts: first column of each part.
        parts: the elementary parts of all joints, in Pinocchio's order.
        angle_columns: columns that are angles.
        scale: `(size,)` weights that compare slides with angles [1/m for slides].
        columns: joint name to its columns in a row.
        velocity_columns: joint name to its columns in a velocity.
    """

    def __init__(self, model: pinocchio.Model, joints: Iterable[Joint], length: float) -> None:
        """Lay out the coordinates.

        Args:
            model: of the tree.
            joints: all joints, those of loops included.
            length: characteristic length, which compares slides with angles [m].
        """
        self.model = model
        self.columns: dict[str, slice] = {}
        self.velocity_columns: dict[str, slice] = {}
        self.size = 0
        ordered = sorted((joint for joint in joints if joint.parts), key=_place)
        self.parts = [part for joint in ordered for part in joint.parts]
        self.starts: list[int] = []
        for joint in ordered:
            first = self.size
            for part in joint.parts:
                self.starts.append(self.size)
                self.size += 4 if part.kind == "spherical" else 1
            start = self.model.idx_vs[joint.parts[0].id]
            self.columns[joint.name] = slice(first, self.size)
            self.velocity_columns[joint.name] = slice(start, start + joint.nv)

        def of_kind(kind: str) -> tuple[Array, Array, Array]:
            chosen = [
                (part, start)
                for part, start in zip(self.parts, self.starts, strict=True)
                if part.kind == kind
            ]
            return (
                np.array([part.id - 1 for part, _ in chosen], dtype=int),
                np.array([start for _, start in chosen], dtype=int),
                np.array([self.model.idx_vs[part.id] for part, _ in chosen], dtype=int),
            )

        revolute, prismatic, self._spherical = map(of_kind, ("revolute", "prismatic", "spherical"))
        self._scalar_columns = np.concatenate([revolute[1], prismatic[1]])
        self._scalar_velocities = np.concatenate([revolute[2], prismatic[2]])
        self.angle_columns = revolute[1]
        self.scale = np.ones(self.size)
        self.scale[prismatic[1]] = 1.0 / length

    def neutral(self) -> Array:
        """Return the `(size,)` row in which every joint is at zero."""
        row = np.zeros(self.size)
        row[self._spherical[1] + 3] = 1.0
        return row

    def column_of(self, velocities: Array) -> Array:
        """Return the columns of rows that belong to velocity coordinates of turns and slides."""
        places = dict(
            zip(self._scalar_velocities.tolist(), self._scalar_columns.tolist(), strict=True)
        )
        return np.array([places[int(column)] for column in velocities], dtype=int)

    def moves(self, velocities: Array) -> Moves:
        """Return how rows move along some velocity coordinates, whole joints of them."""
        places = {int(column): k for k, column in enumerate(velocities)}
        scalars = [
            (column, places[int(start)])
            for column, start in zip(self._scalar_columns, self._scalar_velocities, strict=True)
            if int(start) in places
        ]
        balls = [
            (int(column), places[int(start)])
            for column, start in zip(self._spherical[1], self._spherical[2], strict=True)
            if int(start) in places
        ]
        columns, steps = zip(*scalars, strict=True) if scalars else ((), ())
        angles = set(self.angle_columns.tolist())
        slides = [step for column, step in scalars if int(column) not in angles]
        return Moves(
            np.array(columns, dtype=int),
            np.array(steps, dtype=int),
            np.array(slides, dtype=int),
            balls,
        )

    def shape(self, x: Array) -> Array:
        """Return rows that are equal for equal positions, whatever their turns and signs."""
        columns = np.delete(np.arange(self.size), self.angle_columns)
        rest = x[:, columns]
        for column in self._spherical[1]:
            place = int(np.nonzero(columns == column)[0][0])
            block = rest[:, place : place + 4]
            largest = np.argmax(np.abs(block), axis=1)[:, None]
            block *= np.sign(np.take_along_axis(block, largest, axis=1))
        angles = x[:, self.angle_columns]
        return np.concatenate([np.cos(angles), np.sin(angles), rest], axis=1)

    def derivative(self, x: Array, v: Array) -> Array:
        """Return `(N, size)` rates of the rows `x` for joint velocities `v (N, nv)`."""
        rates = np.zeros_like(x)
        rates[:, self._scalar_columns] = v[:, self._scalar_velocities]
        for column, start in zip(self._spherical[1], self._spherical[2], strict=True):
            spin = np.zeros((len(x), 4))
            spin[:, :3] = 0.5 * v[:, start : start + 3]
            rates[:, column : column + 4] = quaternion_product(x[:, column : column + 4], spin)
        return rates

    def curvature(self, x: Array, v: Array, a: Array) -> Array:
        """Return second time derivatives `(N, size)` of the rows `x`."""
        result = self.derivative(x, a)
        for column, start in zip(self._spherical[1], self._spherical[2], strict=True):
            squared = np.sum(v[:, start : start + 3] ** 2, axis=1, keepdims=True)
            result[:, column : column + 4] -= 0.25 * squared * x[:, column : column + 4]
        return result

    def normalised(self, x: Array) -> Array:
        """Return `x` with its quaternions scaled to unit length, in place."""
        for column in self._spherical[1]:
            quaternion = x[:, column : column + 4]
            quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
        return x

    def configuration(self, x: Array) -> Array:
        """Return Pinocchio configurations `(N, nq)` of the mechanism's model."""
        q = np.empty((len(x), self.model.nq))
        for part, start in zip(self.parts, self.starts, strict=True):
            at, count = self.model.idx_qs[part.id], self.model.nqs[part.id]
            if part.kind == "revolute" and count == 2:
                q[:, at] = np.cos(x[:, start])
                q[:, at + 1] = np.sin(x[:, start])
            else:
                q[:, at : at + count] = x[:, start : start + count]
        return q


def _place(joint: Joint) -> int:
    return joint.id


def _exponential(rotation: Array) -> Array:
    """Return unit quaternions `(N, 4)` of rotation vectors `(N, 3)`."""
    half = 0.5 * np.linalg.norm(rotation, axis=1, keepdims=True)
    return np.concatenate([0.5 * rotation * np.sinc(half / np.pi), np.cos(half)], axis=1)
