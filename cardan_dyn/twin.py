"""Twin: Pinocchio's answers for many samples as arrays.

Reading `data.f` or `data.oMi` costs more than computing them. The twin is the same tree with every
joint replaced by a free-flyer that is moved like the original joint. Its `rnea` returns the whole
wrench of every joint as one array, and its joint Jacobian holds the placements of all bodies: the
six columns of a free-flyer are the action matrix of its placement. No `SE3`, `Motion` or `Force`
object is made per sample.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from .mechanism import Joint, Mechanism

Array = np.ndarray


class Coordinates:
    """Joint coordinates of many samples and what they are in Pinocchio's models.

    A sample is a row of one number per turning part of a joint (the angle [rad], which keeps count
    of turns), one per sliding part [m] and a unit quaternion (x, y, z, w) per ball. Velocities have
    Pinocchio's layout.

    Attributes:
        size: numbers per row.
        parts: the elementary parts of all joints, in Pinocchio's order.
        columns: joint name to its columns in a row.
        velocities: joint name to its columns in a velocity.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.model = mechanism.model
        self.columns: dict[str, slice] = {}
        self.velocities: dict[str, slice] = {}
        self.size = 0
        ordered = sorted((joint for joint in mechanism.joints.values() if joint.parts), key=_place)
        self.parts = [part for joint in ordered for part in joint.parts]
        self._starts: list[int] = []
        for joint in ordered:
            first = self.size
            for part in joint.parts:
                self._starts.append(self.size)
                self.size += 4 if part.kind == "spherical" else 1
            start = self.model.idx_vs[joint.parts[0].index]
            self.columns[joint.name] = slice(first, self.size)
            self.velocities[joint.name] = slice(start, start + joint.size)

        def of_kind(kind: str) -> tuple[Array, Array, Array, Array]:
            chosen = [
                (part, start)
                for part, start in zip(self.parts, self._starts, strict=True)
                if part.kind == kind
            ]
            return (
                np.array([part.index - 1 for part, _ in chosen], dtype=int),
                np.array([start for _, start in chosen], dtype=int),
                np.array([self.model.idx_vs[part.index] for part, _ in chosen], dtype=int),
                np.array([part.axis for part, _ in chosen]).reshape(-1, 3),
            )

        self._revolute, self._prismatic, self._spherical = map(
            of_kind, ("revolute", "prismatic", "spherical")
        )
        self.scalar_columns = np.concatenate([self._revolute[1], self._prismatic[1]])
        self.scalar_velocities = np.concatenate([self._revolute[2], self._prismatic[2]])
        self.angle_columns = self._revolute[1]

    def neutral(self) -> Array:
        """Return the `(size,)` row in which every joint is at zero."""
        row = np.zeros(self.size)
        row[self._spherical[1] + 3] = 1.0
        return row

    def moved(self, x: Array, step: Array) -> Array:
        """Return rows moved by joint displacements `step (N, nv)` from `x (N, size)`."""
        result = x.copy()
        result[:, self.scalar_columns] += step[:, self.scalar_velocities]
        for column, start in zip(self._spherical[1], self._spherical[2], strict=True):
            turn = _exponential(step[:, start : start + 3])
            result[:, column : column + 4] = _product(x[:, column : column + 4], turn)
        return result

    def derivative(self, x: Array, v: Array) -> Array:
        """Return `(N, size)` rates of the rows `x` for joint velocities `v (N, nv)`."""
        rates = np.zeros_like(x)
        rates[:, self.scalar_columns] = v[:, self.scalar_velocities]
        for column, start in zip(self._spherical[1], self._spherical[2], strict=True):
            spin = np.zeros((len(x), 4))
            spin[:, :3] = 0.5 * v[:, start : start + 3]
            rates[:, column : column + 4] = _product(x[:, column : column + 4], spin)
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
        for part, start in zip(self.parts, self._starts, strict=True):
            at, count = self.model.idx_qs[part.index], self.model.nqs[part.index]
            if part.kind == "revolute" and count == 2:
                q[:, at] = np.cos(x[:, start])
                q[:, at + 1] = np.sin(x[:, start])
            else:
                q[:, at : at + count] = x[:, start : start + count]
        return q

    def twin_configuration(self, x: Array) -> Array:
        """Return configurations `(N, 7 n)` of the twin: translation and quaternion per joint."""
        q = np.zeros((len(x), len(self.parts), 7))
        q[:, :, 6] = 1.0
        rows, columns, _, axes = self._revolute
        if rows.size:
            half = 0.5 * x[:, columns]
            q[:, rows, 3:6] = np.sin(half)[:, :, None] * axes
            q[:, rows, 6] = np.cos(half)
        rows, columns, _, axes = self._prismatic
        if rows.size:
            q[:, rows, 0:3] = x[:, columns, None] * axes
        for row, column in zip(self._spherical[0], self._spherical[1], strict=True):
            q[:, row, 3:7] = x[:, column : column + 4]
        return q.reshape(len(x), -1)

    def twin_velocity(self, v: Array) -> Array:
        """Return twin velocities (or accelerations) `(N, 6 n)` for joint rates `v (N, nv)`.

        The motion subspaces of all supported joints are constant in the joint frame, so rates of
        both orders are carried over alike.
        """
        result = np.zeros((len(v), len(self.parts), 6))
        rows, _, starts, axes = self._revolute
        result[:, rows, 3:6] = v[:, starts, None] * axes
        rows, _, starts, axes = self._prismatic
        result[:, rows, 0:3] = v[:, starts, None] * axes
        for row, start in zip(self._spherical[0], self._spherical[2], strict=True):
            result[:, row, 3:6] = v[:, start : start + 3]
        return result.reshape(len(v), -1)


class Twin:
    """The free-flyer twin of a mechanism.

    Attributes:
        origin: `(3,)` the point about which world-axes twists and wrenches are taken [m]. It lies
            near the loops, so that no digits are lost far from the world's origin.
        subspace: `(nv, 6)` unit twist of each velocity coordinate in its joint's frame.
        owner: `(nv,)` number of the joint (0-based, in Pinocchio's order) of each coordinate.
    """

    def __init__(self, mechanism: Mechanism, gravity: Array) -> None:
        source = mechanism.model
        self.joint_count = source.njoints - 1
        self.origin = _origin(mechanism)
        self.model = pinocchio.Model()
        self.model.gravity.linear = gravity
        for index in range(1, source.njoints):
            placement = source.jointPlacements[index].copy()
            if source.parents[index] == 0:
                placement.translation = placement.translation - self.origin
            name = source.names[index]
            joint = self.model.addJoint(
                source.parents[index], pinocchio.JointModelFreeFlyer(), placement, name
            )
            if index not in mechanism.helpers:
                self.model.appendBodyToJoint(
                    joint, source.inertias[index], pinocchio.SE3.Identity()
                )
        self.data = self.model.createData()

        self.subspace = np.zeros((source.nv, 6))
        self.owner = np.zeros(source.nv, dtype=int)
        for joint in mechanism.joints.values():
            for part in joint.parts:
                start = source.idx_vs[part.index]
                self.owner[start : start + part.size] = part.index - 1
                if part.kind == "spherical":
                    self.subspace[start : start + 3, 3:] = np.eye(3)
                else:
                    self.subspace[start, 0 if part.kind == "prismatic" else 3 :][:3] = part.axis

    def actions(self, q: Array) -> Array:
        """Return transposed action matrices `(N, 6 n, 6)` of all joints' placements.

        Row `6 j + i` of a sample is unit twist `i` of joint `j`'s frame, in world axes about
        `origin`. One call into Pinocchio per sample.
        """
        result = np.empty((len(q), 6 * self.joint_count, 6))
        model, data, jacobians = self.model, self.data, pinocchio.computeJointJacobians
        columns = data.J.T
        for row, out in zip(q, result, strict=True):
            jacobians(model, data, row)
            out[:] = columns
        return result

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """Return the wrench of every joint `(N, 6 n)` in its frame, loops left open.

        One call into Pinocchio per sample.
        """
        result = np.empty((len(q), 6 * self.joint_count))
        model, data, rnea = self.model, self.data, pinocchio.rnea
        for rows in zip(q, v, a, result, strict=True):
            rows[3][:] = rnea(model, data, rows[0], rows[1], rows[2])
        return result

    def twists(self, actions: Array, coordinates: Array) -> Array:
        """Return unit twists `(N, k, 6)` of velocity coordinates, in world axes about `origin`."""
        result = np.empty((len(actions), len(coordinates), 6))
        for column, coordinate in enumerate(coordinates):
            rows = actions[:, 6 * self.owner[coordinate] : 6 * self.owner[coordinate] + 6]
            unit = self.subspace[coordinate]
            (axes,) = np.nonzero(unit)
            if len(axes) == 1:
                np.multiply(rows[:, axes[0]], unit[axes[0]], out=result[:, column])
            else:
                np.matmul(unit, rows, out=result[:, column])
        return result


def placement(actions: Array, joint: int) -> tuple[Array, Array]:
    """Return rotation `(3, 3, N)` and position `(3, N)` of a joint's frame from its actions."""
    block = actions[:, 6 * joint : 6 * joint + 6, :3].transpose(2, 1, 0)
    rotation = np.ascontiguousarray(block[:, :3])
    moment = np.ascontiguousarray(block[:, 3:])
    # Column i of `moment` is p × r_i with r_i column i of the rotation; Σ r_i × (p × r_i) = 2 p.
    return rotation, 0.5 * cross(rotation, moment).sum(axis=1)


def cross(a: Array, b: Array) -> Array:
    """Return the cross product along the first axis, which `np.cross` does several times slower."""
    return np.stack(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )


def _place(joint: Joint) -> int:
    return joint.index


def _origin(mechanism: Mechanism) -> Array:
    """Return the mean origin of the loops' joints with every joint at zero."""
    if not mechanism.loops:
        return np.zeros(3)
    model = mechanism.model
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    points = [
        (data.oMi[loop.predecessor] * loop.predecessor_placement).translation
        for loop in mechanism.loops
    ]
    return np.asarray(np.mean(points, axis=0))


def _product(a: Array, b: Array) -> Array:
    """Return quaternion products (x, y, z, w) along the last axis."""
    av, aw, bv, bw = a[:, :3], a[:, 3:], b[:, :3], b[:, 3:]
    vector = aw * bv + bw * av + np.cross(av, bv)
    scalar = aw * bw - np.sum(av * bv, axis=1, keepdims=True)
    return np.concatenate([vector, scalar], axis=1)


def _exponential(rotation: Array) -> Array:
    """Return unit quaternions `(N, 4)` of rotation vectors `(N, 3)`."""
    half = 0.5 * np.linalg.norm(rotation, axis=1, keepdims=True)
    return np.concatenate([0.5 * rotation * np.sinc(half / np.pi), np.cos(half)], axis=1)
