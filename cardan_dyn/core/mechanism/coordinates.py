"""Coordinates: how rows of joint coordinates move, and what they are for Pinocchio."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import Array, quaternion_product
from .joints import Joint, NamedCoordinate, named_coordinates


class Moves(NamedTuple):
    """How rows of coordinates move when chosen velocity coordinates do.

    A step holds the displacements of the chosen velocity coordinates, in their order.

    Attributes:
        columns: `(k,)` columns of a row that are angles or slides.
        steps: `(k,)` indices of their displacements in a step.
        slides: indices of the displacements in a step that are lengths.
        quaternions: `(b, 4)` columns of a row that are the quaternions of balls.
        rotations: `(b, 3)` indices of the balls' rotation vectors in a step.
    """

    columns: Array
    steps: Array
    slides: Array
    quaternions: Array
    rotations: Array

    def apply(self, x: Array, step: Array) -> None:
        """Move rows in place, which spares a copy in every Newton step.

        Args:
            x: `(N, size)` rows; they are changed.
            step: `(N, k)` displacements [rad, m], of balls rotation vectors in the ball's frame.
        """
        x[:, self.columns] += step[:, self.steps]
        if len(self.quaternions):
            turns = _exponential(step[:, self.rotations])
            x[:, self.quaternions] = quaternion_product(x[:, self.quaternions], turns)


class _Kind(NamedTuple):
    """Where the parts of one kind are.

    Attributes:
        columns: their first columns in a row.
        velocities: their first velocity coordinates.
    """

    columns: Array
    velocities: Array


class Scalar(NamedTuple):
    """A coordinate that is one number: of a turn or a slide, not of a ball.

    Attributes:
        joint: name of its joint.
        column: its column in a row.
        rate: its velocity coordinate.
        slides: whether it is a slide [m]; else it is an angle [rad].
    """

    joint: str
    column: int
    rate: int
    slides: bool


class Coordinates:
    """Joint coordinates of many samples and what they are in Pinocchio's models.

    A sample is a row of one number per turning part of a joint (the angle [rad], which keeps count
    of turns), one per sliding part [m] and a unit quaternion (x, y, z, w) per ball. Velocities have
    Pinocchio's layout.

    Attributes:
        model: `pin.Model` of the mechanism.
        size: length of a row.
        starts: first column of each part.
        parts: the elementary parts of all joints, in Pinocchio's order.
        angle_columns: columns that are angles.
        scale: `(size,)` weights that compare slides with angles [1/m for slides].
        columns: joint name to its columns in a row.
        velocity_columns: joint name to its columns in a velocity.
        cardan: names of the joints whose balls are written as three turns.
        rate_scale: `(nv,)` lengths that compare what acts along slides with moments [m for slides].
        scalars: columns and velocity coordinates of all turns and slides.
        balls: first columns and first velocity coordinates of all balls.
    """

    def __init__(
        self,
        model: pinocchio.Model,
        joints: Collection[Joint],
        length: float,
        cardan: Collection[str] = (),
    ) -> None:
        """Lay out the coordinates.

        Args:
            model: of the tree.
            joints: all joints, those of loops included.
            length: characteristic length, which compares slides with angles [m].
            cardan: see the attribute.
        """
        self.model = model
        self.cardan = frozenset(cardan)
        self.columns: dict[str, slice] = {}
        self.velocity_columns: dict[str, slice] = {}
        self.size = 0
        ordered = sorted((joint for joint in joints if joint.parts), key=lambda joint: joint.id)
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
        self._joints = joints
        revolute, prismatic = self._of_kind("revolute"), self._of_kind("prismatic")
        self.balls = self._of_kind("spherical")
        self._quaternions = self.balls.columns[:, None] + np.arange(4)
        self._spins = self.balls.velocities[:, None] + np.arange(3)
        self.scalars = _Kind(
            *(np.concatenate(pair) for pair in zip(revolute, prismatic, strict=True))
        )
        self.angle_columns = revolute.columns
        self.scale = np.ones(self.size)
        self.scale[prismatic.columns] = 1.0 / length
        self.rate_scale = np.ones(model.nv)
        self.rate_scale[prismatic.velocities] = length

    @cached_property
    def drivable(self) -> dict[str, NamedCoordinate]:
        """All coordinates that scenes can drive and hold, by name."""
        return named_coordinates(self._joints)

    @cached_property
    def named(self) -> dict[str, Scalar]:
        """The turns and slides by their names, see `Joint.coordinates`."""
        is_turn_or_slide = {
            self.model.idx_vs[part.id] for part in self.parts if part.kind != "spherical"
        }
        result = {}
        for name, (joint, offset, slides) in self.drivable.items():
            rate = self.velocity_columns[joint].start + offset
            if rate in is_turn_or_slide:
                # No joint has anything but turns and slides before them, so both count alike.
                result[name] = Scalar(joint, self.columns[joint].start + offset, rate, slides)
        return result

    def names_of(self, rates: set[int]) -> list[str]:
        """Return the names of velocity coordinates, by which scenes can drive or hold them.

        Those of a ball are no rates of its angles, so any of them stands for all three. A
        coordinate whose name belongs to another joint is named by its own joint.
        """
        result, unnamed = [], set(rates)
        for name, item in self.drivable.items():
            span = self.velocity_columns[item.joint]
            if name in self.named:
                own = {self.named[name].rate}
            else:
                own = set(range(span.stop - 3, span.stop))
            if rates & own:
                result.append(name)
                unnamed -= own
        for joint, span in self.velocity_columns.items():
            if unnamed.intersection(range(span.start, span.stop)):
                result.append(joint)
        return result

    def columns_of(self, names: Iterable[str]) -> list[int]:
        """Return the columns of turns and slides in a row, by their names."""
        return [self.named[name].column for name in names]

    def rates_of(self, names: Iterable[str]) -> list[int]:
        """Return the velocity coordinates of turns, slides and joints with balls, by name."""
        result = []
        for name in names:
            if name in self.named:
                result.append(self.named[name].rate)
            else:
                span = self.velocity_columns[name]
                result += range(span.start, span.stop)
        return result

    def _of_kind(self, kind: str) -> _Kind:
        chosen = [
            (start, self.model.idx_vs[part.id])
            for part, start in zip(self.parts, self.starts, strict=True)
            if part.kind == kind
        ]
        return _Kind(*np.array(chosen, dtype=int).reshape(-1, 2).T.copy())

    def neutral(self) -> Array:
        """Return the `(size,)` row in which every joint is at zero."""
        row = np.zeros(self.size)
        row[self.balls.columns + 3] = 1.0
        return row

    def column_of(self, velocities: Array) -> Array:
        """Return the columns of rows that belong to velocity coordinates of turns and slides."""
        column_of = dict(zip(*map(np.ndarray.tolist, self.scalars[::-1]), strict=True))
        return np.array([column_of[velocity] for velocity in velocities.tolist()], dtype=int)

    def moves(self, velocities: Array) -> Moves:
        """Return how rows move along some velocity coordinates.

        Args:
            velocities: the coordinates; of a ball all three, in a row, or none.
        """
        step_of = {velocity: step for step, velocity in enumerate(velocities.tolist())}

        def chosen(kind: _Kind) -> list[tuple[int, int]]:
            return [
                (column, step_of[velocity])
                for column, velocity in zip(*map(np.ndarray.tolist, kind), strict=True)
                if velocity in step_of
            ]

        columns, steps = np.array(chosen(self.scalars), dtype=int).reshape(-1, 2).T.copy()
        angles = set(self.angle_columns.tolist())
        is_slide = [column not in angles for column in columns.tolist()]
        slides = steps[np.array(is_slide, dtype=bool)]
        balls = np.array(chosen(self.balls), dtype=int).reshape(-1, 2)
        quaternions, rotations = balls[:, :1] + np.arange(4), balls[:, 1:] + np.arange(3)
        return Moves(columns, steps, slides, quaternions, rotations)

    def displaced(self, x: Array, velocities: Array, step: Array) -> Array:
        """Return rows `(K, size)` after steps from one.

        Args:
            x: `(size,)`.
            velocities: `(k,)` coordinates that move; of a ball all three, in a row, or none.
            step: `(K, k)` displacements, of slides in lengths of the mechanism.
        """
        rows = x[None, :].repeat(len(step), axis=0)
        self.moves(velocities).apply(rows, step * self.rate_scale[velocities])
        return rows

    def columns_moved_by(self, velocities: Array) -> Array:
        """Return the columns of rows that change when velocity coordinates do, ascending."""
        moves = self.moves(velocities)
        return np.sort(np.concatenate([moves.columns, moves.quaternions.ravel()]))

    def apart(self, x: Array, first: Array) -> Array:
        """Return rows that tell how the joints stand beside another position of theirs.

        They do not depend on where joints count from, on whole turns, signs of quaternions or the
        unit of length. Of a turn or a ball that is turned by θ, they have the length 2 sin(θ/2).

        Args:
            x: `(N, size)`.
            first: `(size,)` the other position.
        """
        angles = (x - first)[:, self.angle_columns]
        taken = np.concatenate([self.angle_columns, self._quaternions.ravel()])
        slides = np.delete((x - first) * self.scale, taken, axis=1)
        back = first[self._quaternions] * [-1.0, -1.0, -1.0, 1.0]
        turned = quaternion_product(back, x[:, self._quaternions])
        balls = turned[..., :, None] * turned[..., None, :]
        balls[..., 3, 3] -= 1.0
        balls = np.sqrt(2.0) * balls.reshape(len(x), -1)
        return np.concatenate([np.cos(angles) - 1.0, np.sin(angles), slides, balls], axis=1)

    def derivative(self, x: Array, v: Array) -> Array:
        """Return `(N, size)` rates of the rows `x` for joint velocities `v (N, nv)`."""
        rates = np.zeros(x.shape)
        rates[:, self.scalars.columns] = v[:, self.scalars.velocities]
        if len(self._spins):
            spins = np.zeros((len(x), *self._quaternions.shape))
            np.multiply(v[:, self._spins], 0.5, out=spins[..., :3])
            rates[:, self._quaternions] = quaternion_product(x[:, self._quaternions], spins)
        return rates

    def velocity(self, x: Array, rates: Array) -> Array:
        """Return the joint velocities `(N, nv)` of which `rates (N, size)` are the derivative."""
        v = np.zeros((len(x), self.model.nv))
        v[:, self.scalars.velocities] = rates[:, self.scalars.columns]
        if len(self._spins):
            back = x[:, self._quaternions] * [-1.0, -1.0, -1.0, 1.0]
            turning = quaternion_product(back, rates[:, self._quaternions])
            v[:, self._spins] = 2.0 * turning[..., :3]
        return v

    def curvature(self, x: Array, v: Array, a: Array) -> Array:
        """Return second time derivatives `(N, size)` of the rows `x`.

        Args:
            x: `(N, size)`.
            v: joint velocities `(N, nv)`.
            a: joint accelerations `(N, nv)`.
        """
        result = self.derivative(x, a)
        if len(self._spins):
            squared = np.add.reduce(v[:, self._spins] ** 2, axis=2, keepdims=True)
            result[:, self._quaternions] -= 0.25 * squared * x[:, self._quaternions]
        return result

    def normalised(self, x: Array) -> Array:
        """Return `x` with its quaternions scaled to unit length, in place."""
        if len(self._quaternions):
            quaternions = x[:, self._quaternions]
            quaternions /= _lengths(quaternions)
            x[:, self._quaternions] = quaternions
        return x

    def configuration(self, x: Array) -> Array:
        """Return Pinocchio configurations `(N, nq)` of the mechanism's model."""
        q = np.empty((len(x), self.model.nq))
        for part, start in zip(self.parts, self.starts, strict=True):
            first, count = self.model.idx_qs[part.id], self.model.nqs[part.id]
            if part.kind == "revolute" and count == 2:
                # Pinocchio's joints without limits have the cosine and sine of their angle.
                q[:, first] = np.cos(x[:, start])
                q[:, first + 1] = np.sin(x[:, start])
            else:
                q[:, first : first + count] = x[:, start : start + count]
        return q


def _exponential(rotations: Array) -> Array:
    """Return unit quaternions `(…, 4)` of rotation vectors `(…, 3)`."""
    half = 0.5 * _lengths(rotations)
    return np.concatenate([0.5 * rotations * np.sinc(half / np.pi), np.cos(half)], axis=-1)


def _lengths(vectors: Array) -> Array:
    """Return the lengths `(…, 1)` of vectors `(…, k)`."""
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=-1, keepdims=True)))
