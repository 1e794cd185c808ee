"""Batch model: placements and wrenches of some bodies of a mechanism, for many samples.

Pinocchio places the bodies, and computes the wrenches of their joints, with the coordinates of rows
as they are. A call takes as long as it computes, so that of few bodies a model has several copies,
each at a sample of its own. The memory of `pin.Data` grows with the third power of the coordinates,
so many bodies are a `LongChain`, whose recursions over the bodies hold all samples in their arrays.
"""

from __future__ import annotations

import threading
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ...arrays import Array, consecutive, cross
from ...mechanism.joints import Part
from ...mechanism.kept import MOST
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import joint_model
from ..loops.routes import Crossing, carried, carriers_of

_MOST_PLACED = 64
"""Coordinates up to which Pinocchio places the bodies of a long chain as well: its data take 8 MB
then, and some milliseconds to make."""
_MOST_BODIES = 32
"""Bodies up to which Pinocchio's data are made: those of wrenches take 3 MB then, 40 MB if all turn
on balls, and grow with the third power of the coordinates."""
_MOST_TOGETHER = 32
"""Coordinates up to which a model has copies of the bodies: its data take 1 MB then."""
_FEWEST_TOGETHER = 256
"""Samples from which on they are made: that takes as long as they save with so many."""
_ALL = slice(None)
_BEFORE, _AFTER = np.array([2, 0, 1]), np.array([1, 2, 0])
"""Axes before and after x, y and z in cyclic order: p_x is the entry (z, y) of [p]×, and so on."""
_CROSS = np.array(
    [[0, 0, 0, 0, 0, 1, 0, -1, 0], [0, 0, -1, 0, 0, 0, 1, 0, 0], [0, 1, 0, -1, 0, 0, 0, 0, 0.0]]
)
"""A vector p times it are the entries of [p]×ᵀ, by which a row c is multiplied for p × c."""

_ON_DIAGONAL = np.multiply.outer(np.eye(9), np.eye(2)).reshape(3, 3, 3, 3, 2, 2)
_ON_DIAGONAL = np.ascontiguousarray(_ON_DIAGONAL.transpose(0, 1, 4, 2, 5, 3)).reshape(9, 36)
"""The nine entries of a matrix times it are that matrix twice, on the diagonal of a larger one. One
product is faster than copies of three numbers at a time."""


class BaseMotion(NamedTuple):
    """How the body moves that carries a batch; spatial vectors, linear part first.

    Attributes:
        twist: `(N, 6)` of its joint's frame, in that frame.
        acceleration: `(N, 6)` likewise, less the acceleration of free fall: a base that accelerates
            against gravity loads the bodies as gravity does.
    """

    twist: Array
    acceleration: Array

    @staticmethod
    def against(gravity: Array, count: int) -> BaseMotion:
        """Return the motion `(N, 6)` from rest that is felt as gravity is.

        Args:
            gravity: `(N, 3)`, `(1, 3)` or `(3,)` [m/s²].
            count: N.
        """
        twist, acceleration = np.zeros((2, count, 6))
        acceleration[:, :3] = -gravity
        return BaseMotion(twist, acceleration)


class BatchModel:
    """A batch of some bodies of a mechanism that hang from one body, their base.

    Everything is seen from the base, whose axes are those of its joint's frame: its motion matters
    to inertia alone. The base may be the world.

    It does not change after it is made: every thread has models and data of Pinocchio's of its own.

    Attributes:
        base: the base (0-based joint of the mechanism's model), -1 for the world.
        bodies: `(n,)` the bodies carried (likewise), each after what carries it.
        span: the same, as a slice if there are no gaps.
        index_of: body to its index in `bodies`.
        parents: `(n,)` index in `bodies` of what carries each body, -1 for the base. It is the
            body's parent, or carries that across closed loops.
        origin: `(3,)` the point of the base about which twists and wrenches are taken, in its axes
            [m]. It lies near the loops, so that no digits are lost far from the base's origin.
        mass: `(n,)` masses that are accounted for here [kg].
        has_mass: whether any of them is not zero.
        subspace: `(nv, 6)` unit twist of each velocity coordinate in its joint's frame.
        columns: columns of coordinate rows that place the bodies, body by body.
        moved_body: `(nv,)` index in `bodies` of the body that each velocity coordinate moves, -1
            if it is not carried.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        bodies: list[int],
        inertial_bodies: set[int],
        origin: Array,
        base: int = -1,
        crossed: tuple[Crossing, ...] = (),
    ) -> None:
        """Build the batch.

        Args:
            mechanism: the mechanism.
            bodies: bodies carried, with all between them and the base, each after what carries it.
            inertial_bodies: those of them whose inertia is accounted for here.
            origin: see the attribute.
            base: likewise.
            crossed: loops across which they hang from the base, see `Group`.
        """
        self.base = base
        self.bodies = np.array(bodies, dtype=int)
        self.span = consecutive(self.bodies)
        self.index_of = {body: index for index, body in enumerate(bodies)}
        self.origin = origin
        inertial_bodies = inertial_bodies - {index - 1 for index in mechanism.auxiliary_bodies}
        self._source, self._inertial_bodies = mechanism.model, inertial_bodies
        self._of_thread = threading.local()
        source = mechanism.model
        self.mass = np.array(
            [source.inertias[body + 1].mass if body in inertial_bodies else 0.0 for body in bodies]
        )
        self.has_mass = bool(np.any(self.mass > 0.0))
        self._carriers = carriers_of(mechanism, crossed)
        carriers = [self.place(source.parents[body + 1] - 1) for body in bodies]
        self.parents = np.array([index for index, _ in carriers], dtype=int)
        self._hangs_at = [
            placement if at is None else at * placement
            for placement, (_, at) in zip(
                (source.jointPlacements[body + 1] for body in bodies), carriers, strict=True
            )
        ]
        self._lay_out(mechanism)

    def _lay_out(self, mechanism: Mechanism) -> None:
        """Find where the coordinates of the bodies' joints are, and along what they move."""
        model, coordinates = mechanism.model, mechanism.coordinates
        placed: dict[int, tuple[Part, int]] = {}
        self.subspace = np.zeros((model.nv, 6))
        self.moved_body = np.full(model.nv, -1)
        rows: dict[str, list[tuple[int, int, int, Array]]] = {
            "revolute": [],
            "prismatic": [],
            "spherical": [],
        }
        for part, column in zip(coordinates.parts, coordinates.starts, strict=True):
            index = self.index_of.get(part.id - 1)
            if index is None:
                continue
            start = model.idx_vs[part.id]
            self.moved_body[start : start + part.nv] = index
            placed[index] = part, column
            rows[part.kind].append((index, column, start, part.axis))
            if part.kind == "spherical":
                self.subspace[start : start + 3, 3:] = np.eye(3)
            else:
                self.subspace[start, 0 if part.kind == "prismatic" else 3 :][:3] = part.axis
        self._revolute, self._prismatic = (
            _Joints.of(rows["revolute"]),
            _Joints.of(rows["prismatic"]),
        )
        self._balls = [(index, column, start) for index, column, start, _ in rows["spherical"]]
        parts = [placed[index] for index in range(len(self))]
        columns = [
            column + offset
            for part, column in parts
            for offset in range(4 if part.kind == "spherical" else 1)
        ]
        self.columns = consecutive(np.array(columns, dtype=int))
        self._rates = consecutive(np.flatnonzero(self.moved_body >= 0))
        self._parts = [part for part, _ in parts]
        self._freedoms = int(np.count_nonzero(self.moved_body >= 0))

    def _model(self, origin: Array, copies: int = 1, moves: bool = False) -> pinocchio.Model:
        """Return a model of the bodies and their joints, whose coordinates are those of rows.

        Args:
            origin: `(3,)` of the model, from that of the base [m].
            copies: number of copies, one after the other and each on a base of its own.
            moves: whether the base is a free-flyer.
        """
        model = pinocchio.Model()
        model.gravity.linear = np.zeros(3)
        for copy in range(copies):
            root = 0
            if moves:
                flyer = pinocchio.JointModelFreeFlyer()
                root = model.addJoint(0, flyer, pinocchio.SE3.Identity(), f"{copy}")
            joints: list[int] = []
            for index, (body, part) in enumerate(zip(self.index_of, self._parts, strict=True)):
                parent = int(self.parents[index])
                name = f"{copy} {self._source.names[body + 1]}"
                kind = joint_model(part.kind, part.axis)
                carrier = root if parent < 0 else joints[parent]
                joints.append(model.addJoint(carrier, kind, self._at_zero(index, origin), name))
                if body in self._inertial_bodies:
                    inertia = self._source.inertias[body + 1]
                    model.appendBodyToJoint(joints[-1], inertia, pinocchio.SE3.Identity())
        return model

    def _at_zero(self, index: int, origin: Array) -> pinocchio.SE3:
        """Return where a joint is at its zero: in what carries it, or from a point of the base."""
        placement = self._hangs_at[index].copy()
        if self.parents[index] < 0:
            placement.translation = placement.translation - origin
        return placement

    def __len__(self) -> int:
        return len(self.bodies)

    def place(self, body: int) -> tuple[int, pinocchio.SE3 | None]:
        """Return what carries a body (0-based) of the mechanism as a rigid body does.

        Returns:
            Its index in `bodies`, -1 for the base; and where the body is in it, a `pin.SE3`, None
            if both are the same.
        """
        body, at = carried(body, self._carriers)
        return self.index_of.get(body, -1), at

    def path(self, index: int) -> list[int]:
        """Return the indices in `bodies` from the base to a body, its own last."""
        path = []
        while index >= 0:
            path.append(index)
            index = int(self.parents[index])
        return path[::-1]

    def velocity(self, v: Array) -> Array:
        """Return velocities (or accelerations) `(N, 6 n)` of the bodies for joint rates `(N, nv)`.

        The motion subspaces of all parts are constant in the joint frame, so the same map holds
        for velocities and for accelerations.
        """
        result = np.zeros((len(v), len(self), 6))
        if self._revolute:
            bodies, _, starts, axes = self._revolute
            result[:, bodies, 3:6] = v[:, starts, None] * axes
        if self._prismatic:
            bodies, _, starts, axes = self._prismatic
            result[:, bodies, 0:3] = v[:, starts, None] * axes
        for body, _, start in self._balls:
            result[:, body, 3:6] = v[:, start : start + 3]
        return result.reshape(len(v), -1)

    def actions(self, x: Array) -> Array:
        """Return the actions of all joints, see `actions_of`, at coordinate rows `x (N, size)`."""
        return actions_of(self.placed(x))

    def placed(self, x: Array) -> Array:
        """Return the placements `(N, n, 12)` of all joints in the base's axes about `origin`.

        Rotations, column by column, and positions.

        Args:
            x: coordinate rows `(N, size)`.
        """
        count, bodies, forward = x.shape[0], self.parents.size, pinocchio.forwardKinematics
        placed = np.empty((count, bodies, 12))
        if count == 1 and bodies:
            # Loops over arrays take as long as all the rest.
            calls = self._calls_of(1, False)
            forward(calls.model, calls.data, x[0, self.columns])
            placed[0] = calls.placements
        elif bodies:
            rows = x[:, self.columns]
            for span, calls in self._calls(count):
                copies, model, data, placements, _ = calls
                given, found = rows[span], placed[span]
                if copies > 1:
                    given, found = calls.joined(given), calls.joined(found)
                for row, out in zip(given, found, strict=True):
                    forward(model, data, row)
                    out[:] = placements
        return placed

    def inverse_dynamics(
        self, base: BaseMotion, x: Array, v: Array, a: Array
    ) -> tuple[Array, Array]:
        """Return the wrench of every joint `(N, n, 6)` in its frame, loops left open.

        Args:
            base: how the base moves.
            x: coordinate rows `(N, size)`.
            v: joint velocities `(N, nv)`.
            a: joint accelerations `(N, nv)`.

        Returns:
            These wrenches, and the wrench `(N, 6)` that moves all of it: it acts on the base, in
            its frame, and is part of the wrench of its joint.
        """
        rest = np.zeros((len(x), 7))
        rest[:, 6] = 1.0
        q = np.concatenate([rest, x[:, self.columns]], axis=1)
        v = np.concatenate([base.twist, v[:, self._rates]], axis=1)
        a = np.concatenate([base.acceleration, a[:, self._rates]], axis=1)
        result = np.empty((len(x), 1 + len(self), 6))
        for span, calls in self._calls(len(x), moves=True):
            calls.inverse_dynamics(q[span], v[span], a[span], result[span])
        return result[:, 1:], result[:, 0]

    def kinetic_energy(self, x: Array, v: Array) -> Array:
        """Return kinetic energies `(N,)` [J] where the base rests.

        Args:
            x: coordinate rows `(N, size)`.
            v: joint velocities `(N, nv)`.
        """
        calls = self._calls_of(1, moves=False)
        of = calls.model, calls.data
        states = zip(x[:, self.columns], v[:, self._rates], strict=True)
        return np.array([pinocchio.computeKineticEnergy(*of, *state) for state in states])

    def moment_of_mass(self, x: Array) -> Array:
        """Return all masses times where their centres are `(N, 3)` [kg m], in the base's frame.

        Args:
            x: coordinate rows `(N, size)`.
        """
        if not self.has_mass:
            return np.zeros((len(x), 3))
        calls = self._calls_of(1, moves=False)
        of = calls.model, calls.data
        centres = [pinocchio.centerOfMass(*of, row).copy() for row in x[:, self.columns]]
        return self.mass.sum() * (np.array(centres).reshape(-1, 3) + self.origin)

    def _calls(self, count: int, moves: bool = False) -> list[tuple[slice, _Calls]]:
        """Return which of some samples this thread computes by which calls.

        A sample comes out as the same to the last bit, whichever it is.

        Args:
            count: number of samples.
            moves: whether the base is a free-flyer.
        """
        if count < _FEWEST_TOGETHER:
            return [(_ALL, self._calls_of(1, moves))]
        several = _MOST_TOGETHER // (self._freedoms + 6 * moves)
        if several < 2:
            return [(_ALL, self._calls_of(1, moves))]
        whole = count - count % several
        of_one = [(slice(whole, count), self._calls_of(1, moves))] if whole < count else []
        return [(slice(whole), self._calls_of(several, moves)), *of_one]

    def _calls_of(self, copies: int, moves: bool) -> _Calls:
        """Return this thread's calls for so many samples each."""
        known: dict[Any, _Calls] = self._of_thread.__dict__
        try:
            return known[copies, moves]
        except KeyError:
            model = self._model(np.zeros(3) if moves else self.origin, copies, moves)
            calls = known[copies, moves] = _Calls.of(model, copies)
            return calls


class _Calls(NamedTuple):
    """Calls into Pinocchio, each for as many samples as its model has copies of the bodies.

    Attributes:
        copies: their number.
        model: of the copies.
        data: what Pinocchio writes into.
        placements: view `(j, 12)` of those of all joints: a rotation, column by column, and a
            position, as they follow each other in memory. Reading them joint by joint would take
            longer than Pinocchio does.
        forces: view `(j, 6)` of the wrenches of all joints.
    """

    copies: int
    model: pinocchio.Model
    data: pinocchio.Data
    placements: Array
    forces: Array

    @staticmethod
    def of(model: pinocchio.Model, copies: int) -> _Calls:
        """Return the calls for a model."""
        data, joints = model.createData(), model.njoints - 1
        placements = [placement.rotation for placement in list(data.oMi)[:2]]
        forces = [force.linear for force in list(data.f)[:2]]
        return _Calls(
            copies, model, data, _view(placements, (joints, 12)), _view(forces, (joints, 6))
        )

    def joined(self, values: Array) -> Array:
        """Return values `(N, k, ...)` of samples as those of calls, `(N / copies, copies k, ...)`.

        They share their memory where those of a sample follow on those of the one before it.
        """
        count, size, *rest = values.shape
        return values.reshape(count // self.copies, self.copies * size, *rest)

    def inverse_dynamics(self, q: Array, v: Array, a: Array, result: Array) -> None:
        """Compute the wrenches of all joints.

        Args:
            q: coordinates `(N, k)`.
            v: velocities `(N, k)`.
            a: accelerations `(N, k)`.
            result: `(N, k, 6)` what they are written into.
        """
        copies, model, data, _, forces = self
        rnea = pinocchio.rnea
        if copies > 1:
            q, v, a, result = (self.joined(values) for values in (q, v, a, result))
        for own, speeds, accelerations, out in zip(q, v, a, result, strict=True):
            rnea(model, data, own, speeds, accelerations)
            out[:] = forces


def _view(first_two: list[Array], shape: tuple[int, int]) -> Array:
    """Return a view of what data hold of all joints but the first one, which is the world."""
    world, first = (int(array.__array_interface__["data"][0]) for array in first_two)
    strides = (first - world, 8)
    return np.lib.stride_tricks.as_strided(first_two[1], shape, strides, writeable=False)


def batch_model(
    mechanism: Mechanism,
    bodies: list[int],
    inertial_bodies: set[int],
    origin: Array,
    base: int = -1,
    crossed: tuple[Crossing, ...] = (),
) -> BatchModel:
    """Return the model of some bodies; of many, one that does without Pinocchio's data.

    All who ask a mechanism share it. Arguments as of `BatchModel`.
    """
    kind = LongChain if len(bodies) > _MOST_BODIES else BatchModel
    key = tuple(bodies), frozenset(inertial_bodies), origin.tobytes(), base, crossed
    given = mechanism, bodies, inertial_bodies, origin, base, crossed
    # A scene has as many of them as bodies at most: those of one fit in any case.
    return mechanism.kept.of("batch", key, lambda: kind(*given), MOST + mechanism.model.njoints)


def actions_of(placed: Array) -> Array:
    """Return transposed action matrices `(N, 6 n, 6)` of joints' placements.

    Row `6 j + i` of a sample is unit twist `i` of joint `j`'s frame, in the base's axes about the
    batch model's origin.

    Args:
        placed: `(N, n, 12)`, see `BatchModel.placed`.
    """
    count, bodies, _ = placed.shape
    columns = placed[:, :, :9].reshape(count, bodies, 3, 3)
    result = (columns.reshape(-1, 9) @ _ON_DIAGONAL).reshape(count, bodies, 6, 6)
    crossed = (placed[:, :, 9:] @ _CROSS).reshape(columns.shape)
    np.matmul(columns, crossed, out=result[:, :, 3:, :3])
    return result.reshape(count, 6 * bodies, 6)


class UnitTwists:
    """Unit twists of chosen velocity coordinates of a batch."""

    def __init__(self, batch: BatchModel, coordinates: Array) -> None:
        self._units = batch.subspace[coordinates]
        self._bodies = batch.moved_body[coordinates]
        # Along an axis of its frame, a unit twist is a row of the action up to its sign.
        self._along_axes = bool(np.all(np.count_nonzero(self._units, axis=1) == 1))
        self._rows = 6 * self._bodies + np.argmax(np.abs(self._units), axis=1)
        self._signs = self._units.sum(axis=1)[:, None]

    def of(self, actions: Array) -> Array:
        """Return `(N, k, 6)` in the base's axes about the batch model's origin."""
        if self._along_axes:
            twists: Array = actions[:, self._rows] * self._signs
            return twists
        result = np.empty((len(actions), len(self._units), 6))
        for column, (unit, body) in enumerate(zip(self._units, self._bodies, strict=True)):
            np.matmul(unit, actions[:, 6 * body : 6 * body + 6], out=result[:, column])
        return result


def placed_by(actions: Array) -> Array:
    """Return the placements `(N, n, 12)` whose `actions_of` are given."""
    blocks = actions.reshape(len(actions), -1, 6, 6)[:, :, :, :3]
    rotations = blocks[:, :, :3]
    shifts = positions(rotations.transpose(3, 1, 2, 0), blocks[:, :, 3:].transpose(3, 1, 2, 0))
    return np.concatenate([rotations.reshape(*blocks.shape[:2], 9), shifts.T], axis=2)


def placement(actions: Array, index: int) -> tuple[Array, Array]:
    """Return rotation `(3, 3, N)` and position `(3, N)` of a joint's frame from its actions.

    Args:
        actions: see `actions_of`.
        index: of the joint's body in the batch model.
    """
    block = actions[:, 6 * index : 6 * index + 6, :3].transpose(2, 1, 0)
    rotation = np.ascontiguousarray(block[:, :3])
    return rotation, positions(rotation, block[:, 3:])


def positions(rotation: Array, moment: Array) -> Array:
    """Return positions `(3, ..., N)` from rotations and their moments `(3, ..., 3, N)`.

    The moment of a rotation R at p is M = [p]× R, so M Rᵀ = [p]× holds the position.
    """
    products = moment.take(_BEFORE, 0)
    products *= rotation.take(_AFTER, 0)
    return np.asarray(np.add.reduce(products, axis=-2))


class _Joints(NamedTuple):
    """The turns, or the slides, of a batch.

    Attributes:
        bodies: `(k,)` indices of the bodies that they move, in the batch model; as a slice where
            they are without gaps, like the following.
        columns: `(k,)` their columns in coordinate rows.
        starts: `(k,)` their velocity coordinates.
        axes: `(k, 3)` their axes in the joint frames.
    """

    bodies: slice | Array
    columns: slice | Array
    starts: slice | Array
    axes: Array

    @staticmethod
    def of(rows: list[tuple[int, int, int, Array]]) -> _Joints | None:
        """Return joints, each given by its body, column, velocity coordinate and axis, if any."""
        if not rows:
            return None
        indices = np.array([row[:3] for row in rows]).T
        bodies, columns, starts = map(consecutive, indices)
        return _Joints(bodies, columns, starts, np.array([axis for *_, axis in rows]))


class LongChain(BatchModel):
    """A batch whose placements and wrenches come from recursions over its bodies.

    In these, placements are `(3, 3, N)` and `(3, N)` in the parent's frame, twists and wrenches
    `(2, 3, N)`: linear and angular part, force and moment.
    """

    def placed(self, x: Array) -> Array:
        """See `BatchModel.placed`."""
        if self._freedoms <= _MOST_PLACED:
            return super().placed(x)
        placed: list[tuple[Array, Array]] = []
        for body, (rotation, position) in enumerate(self._relative(self.configuration(x))):
            parent = int(self.parents[body])
            if parent >= 0:
                parent_rotation, parent_position = placed[parent]
                position = parent_position + np.einsum("ijn,jn->in", parent_rotation, position)
                rotation = np.einsum("ijn,jkn->ikn", parent_rotation, rotation)
            placed.append((rotation, position))
        columns, positions = (np.stack(items).T for items in zip(*placed, strict=True))
        rows = columns.transpose(0, 3, 1, 2).reshape(*positions.shape[::2], 9)
        return np.concatenate([rows, positions.transpose(0, 2, 1)], axis=2)

    def inverse_dynamics(
        self, base: BaseMotion, x: Array, v: Array, a: Array
    ) -> tuple[Array, Array]:
        """See `BatchModel.inverse_dynamics`."""
        origin = self.origin[:, None] * np.ones(len(x))
        twist, acceleration = (
            vectors.T.reshape(2, 3, -1) for vectors in (base.twist, base.acceleration)
        )
        at_origin = [
            np.stack([linear + cross(angular, origin), angular])
            for linear, angular in (twist, acceleration)
        ]
        q, v, a = self.configuration(x), self.velocity(v), self.velocity(a)
        wrenches, (force, moment) = self._newton_euler(q, v, a, *at_origin)
        moment = moment + cross(origin, force)
        return wrenches, np.concatenate([force, moment]).T

    def configuration(self, x: Array) -> Array:
        """Return the placements `(N, 7 n)` of the bodies for coordinate rows `x (N, size)`."""
        q = np.zeros((len(x), len(self), 7))
        q[:, :, 6] = 1.0
        if self._revolute:
            bodies, columns, _, axes = self._revolute
            half = 0.5 * x[:, columns]
            q[:, bodies, 3:6] = np.sin(half)[:, :, None] * axes
            q[:, bodies, 6] = np.cos(half)
        if self._prismatic:
            bodies, columns, _, axes = self._prismatic
            q[:, bodies, 0:3] = x[:, columns, None] * axes
        for body, column, _ in self._balls:
            q[:, body, 3:7] = x[:, column : column + 4]
        return q.reshape(len(x), -1)

    def kinetic_energy(self, x: Array, v: Array) -> Array:
        """See `BatchModel.kinetic_energy`."""
        count = len(x)
        rates = self.velocity(v).reshape(count, len(self), 2, 3).transpose(1, 2, 3, 0)
        result, twists = np.zeros(count), {-1: np.zeros((2, 3, count))}
        for body, placement in enumerate(self._relative(self.configuration(x))):
            twist = _in_child(placement, twists[int(self.parents[body])]) + rates[body]
            twists[body] = twist
            if self.mass[body] > 0.0:
                inertia, spin = self._inertia_of(body), twist[1]
                speed = twist[0] + cross(spin, inertia.lever[:, None] * np.ones(count))
                result += 0.5 * inertia.mass * np.add.reduce(speed * speed)
                result += 0.5 * np.add.reduce(spin * (inertia.inertia @ spin))
        return result

    def moment_of_mass(self, x: Array) -> Array:
        """See `BatchModel.moment_of_mass`."""
        actions, result = self.actions(x), np.zeros((3, len(x)))
        for body in np.flatnonzero(self.mass > 0.0).tolist():
            rotation, position = placement(actions, body)
            inertia = self._inertia_of(body)
            centre = position + np.einsum("ikn,k->in", rotation, inertia.lever)
            result += inertia.mass * (centre + self.origin[:, None])
        return result.T

    def _inertia_of(self, body: int) -> pinocchio.Inertia:
        """Return the inertia of a body, given by its index in `bodies`."""
        return self._source.inertias[int(self.bodies[body]) + 1]

    def _newton_euler(
        self, q: Array, v: Array, a: Array, base_twist: Array, base_acceleration: Array
    ) -> tuple[Array, Array]:
        """Return the wrench of every joint `(N, n, 6)`, and of the base `(2, 3, N)` at the origin.

        With q `(N, 7 n)`, v `(N, 6 n)`, a `(N, 6 n)`, base_twist `(2, 3, N)`.
        """
        count = len(q)
        joint_twists, joint_accelerations = (
            rates.reshape(count, len(self), 2, 3).transpose(1, 2, 3, 0) for rates in (v, a)
        )
        relative = self._relative(q)
        # By body; -1 is the base.
        twists, accelerations = {-1: base_twist}, {-1: base_acceleration}
        wrenches = {-1: np.zeros_like(base_twist)}
        for body, (placement, joint_twist) in enumerate(zip(relative, joint_twists, strict=True)):
            parent = int(self.parents[body])
            twist = _in_child(placement, twists[parent]) + joint_twist
            acceleration = _in_child(placement, accelerations[parent])
            acceleration = acceleration + joint_accelerations[body]
            acceleration = acceleration + _motion_product(twist, joint_twist)
            twists[body], accelerations[body] = twist, acceleration
            wrenches[body] = self._momentum_rate(body, twist, acceleration)
        for body in range(len(self) - 1, -1, -1):
            wrench_of_parent = wrenches[int(self.parents[body])]
            rotation, position = relative[body]
            force, moment = np.einsum("ijn,kjn->kin", rotation, wrenches[body])
            wrench_of_parent[0] += force
            wrench_of_parent[1] += moment + cross(position, force)
        of_joints = np.array([wrenches[body] for body in range(len(self))]).transpose(3, 0, 1, 2)
        return np.ascontiguousarray(of_joints).reshape(count, -1, 6), wrenches[-1]

    def _relative(self, q: Array) -> list[tuple[Array, Array]]:
        """Return the placements of all bodies in their parents."""
        result = []
        for body in range(len(self)):
            free_flyer = np.ascontiguousarray(q[:, 7 * body : 7 * body + 7].T)
            x, y, z, w = free_flyer[3:]
            rotation = np.array(
                [
                    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
                    [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
                    [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
                ]
            )
            origin = self._at_zero(body, self.origin)
            position = origin.translation[:, None] + origin.rotation @ free_flyer[:3]
            result.append((np.einsum("ij,jkn->ikn", origin.rotation, rotation), position))
        return result

    def _momentum_rate(self, body: int, twist: Array, acceleration: Array) -> Array:
        """Return the wrench about a body's origin that its motion needs."""
        if self.mass[body] == 0.0:
            return np.zeros_like(twist)
        inertia = self._inertia_of(body)
        centre = inertia.lever[:, None] * np.ones(twist.shape[2])
        spin = twist[1]
        speed = twist[0] + cross(spin, centre)
        # A spatial acceleration lacks the term ω × v that the acceleration of a point has.
        linear, angular = acceleration
        force = inertia.mass * (linear + cross(angular, centre) + cross(spin, speed))
        momentum = inertia.inertia @ spin
        moment = inertia.inertia @ angular + cross(spin, momentum) + cross(centre, force)
        return np.stack([force, moment])


def _in_child(placement: tuple[Array, Array], twist: Array) -> Array:
    """Return a twist in the parent's frame as one in the child's frame."""
    rotation, position = placement
    linear = twist[0] + cross(twist[1], position)
    return np.einsum("jin,kjn->kin", rotation, np.stack([linear, twist[1]]))


def _motion_product(twist: Array, other: Array) -> Array:
    """Return the spatial cross product: the rate of a twist `other` that moves with `twist`."""
    linear = cross(twist[1], other[0]) + cross(twist[0], other[1])
    return np.stack([linear, cross(twist[1], other[1])])
