"""BatchModel: Pinocchio's answers for many samples as arrays.

Reading `data.f` or `data.oMi` costs more than computing them. The batch is the same tree with every
joint replaced by a free-flyer that is moved like the original joint. Its `rnea` returns the whole
wrench of every joint as one array, and its joint Jacobian holds the placements of all bodies: the
six columns of a free-flyer are the action matrix of its placement. No `SE3`, `Motion` or `Force`
object is made per sample.
"""

from __future__ import annotations

import threading

import numpy as np
import pinocchio

from ..arrays import Array
from ..mechanism.mechanism import Mechanism


class BatchModel:
    """The free-flyer batch of some bodies of a mechanism and all their ancestors.

    Nothing in it changes: what Pinocchio writes into belongs to the thread that asks.

    Attributes:
        bodies: `(n,)` the bodies carried (0-based joints of the mechanism's model), in order.
        local: body to its place in `bodies`.
        origin: `(3,)` the point about which world-axes twists and wrenches are taken [m]. It lies
            near the loops, so that no digits are lost far from the world's origin.
        has_mass: whether any body has mass here.
        subspace: `(nv, 6)` unit twist of each velocity coordinate in its joint's frame.
        owner: `(nv,)` place in `bodies` of each coordinate's body, -1 if it is not carried.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        bodies: list[int],
        massive: set[int],
        origin: Array,
    ) -> None:
        """Build the batch.

        Args:
            mechanism: the mechanism.
            bodies: bodies carried, ancestors included, ascending.
            massive: those of them whose inertia is accounted for here.
            origin: see the attribute.
        """
        source, coordinates = mechanism.model, mechanism.coordinates
        self.bodies = np.array(bodies, dtype=int)
        self.local = {body: place for place, body in enumerate(bodies)}
        self.origin = origin
        self.model = pinocchio.Model()
        for body in bodies:
            index, parent = body + 1, source.parents[body + 1] - 1
            placement = source.jointPlacements[index].copy()
            if parent < 0:
                placement.translation = placement.translation - origin
            joint = self.model.addJoint(
                self.local[parent] + 1 if parent >= 0 else 0,
                pinocchio.JointModelFreeFlyer(),
                placement,
                source.names[index],
            )
            if body in massive and index not in mechanism.helpers:
                self.model.appendBodyToJoint(
                    joint, source.inertias[index], pinocchio.SE3.Identity()
                )
        self.model.gravity.linear = np.zeros(3)
        self._pulled = {(0.0, 0.0, 0.0): self.model}
        self._own = threading.local()
        inertias = list(self.model.inertias)[1:]
        self.mass = np.array([inertia.mass for inertia in inertias])
        self.has_mass = bool(np.any(self.mass > 0.0))
        self.parents = np.array(self.model.parents, dtype=int)[1:] - 1

        self.subspace = np.zeros((source.nv, 6))
        self.owner = np.full(source.nv, -1)
        rows: dict[str, list[tuple[int, int, int, Array]]] = {
            "revolute": [],
            "prismatic": [],
            "spherical": [],
        }
        for part, column in zip(coordinates.parts, coordinates.starts, strict=True):
            place = self.local.get(part.id - 1)
            if place is None:
                continue
            start = source.idx_vs[part.id]
            self.owner[start : start + part.nv] = place
            rows[part.kind].append((place, column, start, part.axis))
            if part.kind == "spherical":
                self.subspace[start : start + 3, 3:] = np.eye(3)
            else:
                self.subspace[start, 0 if part.kind == "prismatic" else 3 :][:3] = part.axis
        self._revolute, self._prismatic, self._spherical = map(_columns, rows.values())

    def __len__(self) -> int:
        return len(self.bodies)

    @property
    def data(self) -> pinocchio.Data:
        """What Pinocchio writes into, one for each thread."""
        if not hasattr(self._own, "data"):
            self._own.data = self.model.createData()
        return self._own.data

    def _under(self, gravity: Array) -> pinocchio.Model:
        """Return the model under some gravity `(3,)`; no model ever changes its own."""
        key = tuple(gravity.tolist())
        if key not in self._pulled:
            model = self.model.copy()
            model.gravity.linear = gravity
            self._pulled[key] = model
        return self._pulled[key]

    def configuration(self, x: Array) -> Array:
        """Return the batch model's configurations `(N, 7 n)` for coordinate rows `x (N, size)`."""
        q = np.zeros((len(x), len(self), 7))
        q[:, :, 6] = 1.0
        places, columns, _, axes = self._revolute
        if places.size:
            half = 0.5 * x[:, columns]
            q[:, places, 3:6] = np.sin(half)[:, :, None] * axes
            q[:, places, 6] = np.cos(half)
        places, columns, _, axes = self._prismatic
        if places.size:
            q[:, places, 0:3] = x[:, columns, None] * axes
        for place, column in zip(self._spherical[0], self._spherical[1], strict=True):
            q[:, place, 3:7] = x[:, column : column + 4]
        return q.reshape(len(x), -1)

    def velocity(self, v: Array) -> Array:
        """Return velocities (or accelerations) `(N, 6 n)` of the bodies for joint rates `(N, nv)`.

        The motion subspaces of all parts are constant in the joint frame, so rates of both orders
        are carried over alike.
        """
        result = np.zeros((len(v), len(self), 6))
        places, _, starts, axes = self._revolute
        result[:, places, 3:6] = v[:, starts, None] * axes
        places, _, starts, axes = self._prismatic
        result[:, places, 0:3] = v[:, starts, None] * axes
        for place, start in zip(self._spherical[0], self._spherical[2], strict=True):
            result[:, place, 3:6] = v[:, start : start + 3]
        return result.reshape(len(v), -1)

    def actions(self, q: Array) -> Array:
        """Return transposed action matrices `(N, 6 n, 6)` of all joints' placements.

        Row `6 j + i` of a sample is unit twist `i` of joint `j`'s frame, in world axes about
        `origin`. One call into Pinocchio per sample.
        """
        result = np.empty((len(q), 6 * len(self), 6))
        model, data, jacobians = self.model, self.data, pinocchio.computeJointJacobians
        columns = data.J.T
        for row, out in zip(q, result, strict=True):
            jacobians(model, data, row)
            out[:] = columns
        return result

    def inverse_dynamics(self, q: Array, v: Array, a: Array, gravity: Array) -> Array:
        """Return the wrench of every joint `(N, 6 n)` in its frame, loops left open.

        One call into Pinocchio per sample.

        Args:
            q: configurations `(N, 7 n)`.
            v: velocities `(N, 6 n)`.
            a: accelerations `(N, 6 n)`.
            gravity: `(3,)` [m/s²].
        """
        result = np.empty((len(q), 6 * len(self)))
        model, data, rnea = self._under(gravity), self.data, pinocchio.rnea
        for rows in zip(q, v, a, result, strict=True):
            rows[3][:] = rnea(model, data, rows[0], rows[1], rows[2])
        return result


class UnitTwists:
    """Unit twists of chosen velocity coordinates of a batch."""

    def __init__(self, batch: BatchModel, coordinates: Array) -> None:
        self._units = batch.subspace[coordinates]
        self._owners = batch.owner[coordinates]
        # Along an axis of its frame, a unit twist is a row of the action up to its sign.
        self._plain = bool(np.all(np.count_nonzero(self._units, axis=1) == 1))
        self._rows = 6 * self._owners + np.argmax(np.abs(self._units), axis=1)
        self._signs = self._units.sum(axis=1)[:, None]

    def of(self, actions: Array) -> Array:
        """Return `(N, k, 6)` in world axes about the batch model's origin."""
        if self._plain:
            return np.asarray(actions[:, self._rows] * self._signs)
        result = np.empty((len(actions), len(self._units), 6))
        for column, (unit, owner) in enumerate(zip(self._units, self._owners, strict=True)):
            np.matmul(unit, actions[:, 6 * owner : 6 * owner + 6], out=result[:, column])
        return result


def placement(actions: Array, joint: int) -> tuple[Array, Array]:
    """Return rotation `(3, 3, N)` and position `(3, N)` of a joint's frame from its actions."""
    block = actions[:, 6 * joint : 6 * joint + 6, :3].transpose(2, 1, 0)
    rotation = np.ascontiguousarray(block[:, :3])
    return rotation, positions(rotation, block[:, 3:])


def positions(rotation: Array, moment: Array) -> Array:
    """Return positions `(3, ..., N)` from rotations and their moments `(3, ..., 3, N)`.

    The moment of a rotation R at p is M = [p]× R, so M Rᵀ = [p]× holds the position.
    """
    return np.asarray(np.einsum("x...in,x...in->x...n", moment[_BEFORE], rotation[_AFTER]))


_BEFORE, _AFTER = [2, 0, 1], [1, 2, 0]


def _columns(rows: list[tuple[int, int, int, Array]]) -> tuple[Array, Array, Array, Array]:
    """Return places, columns of rows, velocity coordinates and axes as arrays."""
    places, columns, starts, axes = zip(*rows, strict=True) if rows else ((), (), (), ())
    return (
        np.array(places, dtype=int),
        np.array(columns, dtype=int),
        np.array(starts, dtype=int),
        np.array(axes).reshape(-1, 3),
    )
