"""Long chain: the batch model of more bodies than `pin.Data` can hold.

The memory of `pin.Data` grows with the third power of the coordinates: gigabytes for a hundred
bodies. For many bodies, placements and wrenches therefore come from recursions over the bodies,
whose arrays hold all samples.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, cross
from .batch_model import BaseMotion, BatchModel


class LongChain(BatchModel):
    """A batch whose placements and wrenches come from recursions over its bodies.

    In these, placements are `(3, 3, N)` and `(3, N)` in the parent's frame, twists and wrenches
    `(2, 3, N)`: linear and angular part, force and moment.
    """

    def actions(self, q: Array) -> Array:
        """See `BatchModel.actions`."""
        count = len(q)
        result = np.zeros((count, 6 * len(self), 6))
        placed: list[tuple[Array, Array]] = []
        for body, (rotation, position) in enumerate(self._relative(q)):
            parent = int(self.parents[body])
            if parent >= 0:
                parent_rotation, parent_position = placed[parent]
                position = parent_position + np.einsum("ijn,jn->in", parent_rotation, position)
                rotation = np.einsum("ijn,jkn->ikn", parent_rotation, rotation)
            placed.append((rotation, position))
            block = result[:, 6 * body : 6 * body + 6]
            columns = rotation.transpose(2, 1, 0)
            block[:, :3, :3] = block[:, 3:, 3:] = columns
            block[:, 3:, :3] = np.cross(position.T[:, None, :], columns)
        return result

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """See `BatchModel.inverse_dynamics`."""
        rest = np.zeros((2, 3, len(q)))
        return self._newton_euler(q, v, a, rest, rest)[0]

    def inverse_dynamics_on(
        self, base: BaseMotion, q: Array, v: Array, a: Array
    ) -> tuple[Array, Array]:
        """See `BatchModel.inverse_dynamics_on`."""
        origin = self.origin[:, None] * np.ones(len(q))
        twist, acceleration = (
            vectors.T.reshape(2, 3, -1) for vectors in (base.twist, base.acceleration)
        )
        at_origin = [
            np.stack([linear + cross(angular, origin), angular])
            for linear, angular in (twist, acceleration)
        ]
        wrenches, (force, moment) = self._newton_euler(q, v, a, *at_origin)
        moment = moment + cross(origin, force)
        return wrenches, np.concatenate([force, moment]).T

    def _newton_euler(
        self, q: Array, v: Array, a: Array, base_twist: Array, base_acceleration: Array
    ) -> tuple[Array, Array]:
        """Return the wrench of every joint `(N, 6 n)`, and of the base `(2, 3, N)` at the origin.

        Args:
            q: configurations `(N, 7 n)`.
            v: velocities `(N, 6 n)`.
            a: accelerations `(N, 6 n)`.
            base_twist: `(2, 3, N)` of the base at the origin, in its axes.
            base_acceleration: likewise, less that of free fall.
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
        return np.ascontiguousarray(of_joints).reshape(count, -1), wrenches[-1]

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
            origin = self.model.jointPlacements[body + 1]
            position = origin.translation[:, None] + origin.rotation @ free_flyer[:3]
            result.append((np.einsum("ij,jkn->ikn", origin.rotation, rotation), position))
        return result

    def _momentum_rate(self, body: int, twist: Array, acceleration: Array) -> Array:
        """Return the wrench about a body's origin that its motion needs.

        Args:
            body: index of the body.
            twist: of its frame, in its frame.
            acceleration: spatial acceleration of its frame, in its frame.
        """
        inertia = self.model.inertias[body + 1]
        if inertia.mass == 0.0:
            return np.zeros_like(twist)
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
    """Return a twist in the parent's frame as one in the child's frame.

    Args:
        placement: rotation and position of the child in the parent.
        twist: linear and angular part.
    """
    rotation, position = placement
    linear = twist[0] + cross(twist[1], position)
    return np.einsum("jin,kjn->kin", rotation, np.stack([linear, twist[1]]))


def _motion_product(twist: Array, other: Array) -> Array:
    """Return the spatial cross product: the rate of a twist `other` that moves with `twist`."""
    linear = cross(twist[1], other[0]) + cross(twist[0], other[1])
    return np.stack([linear, cross(twist[1], other[1])])
