"""Long chain: the batch model of more bodies than `pin.Data` can hold.

The memory of `pin.Data` grows with the third power of the coordinates: gigabytes for a hundred
bodies. For many bodies, placements and wrenches therefore come from recursions over the bodies,
whose arrays hold all samples.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, cross
from .batch_model import BatchModel


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

    def inverse_dynamics(self, q: Array, v: Array, a: Array, gravity: Array) -> Array:
        """See `BatchModel.inverse_dynamics`; Newton and Euler's recursion."""
        count = len(q)
        joint_twists, joint_accelerations = (
            rates.reshape(count, len(self), 2, 3).transpose(1, 2, 3, 0) for rates in (v, a)
        )
        world_twist = np.zeros((2, 3, count))
        # A world that accelerates against gravity loads the bodies as gravity does.
        world_acceleration = world_twist.copy()
        world_acceleration[0] = -gravity[:, None]
        relative = self._relative(q)
        twists: list[Array] = []
        accelerations: list[Array] = []
        wrenches: list[Array] = []
        for body, (placement, joint_twist) in enumerate(zip(relative, joint_twists, strict=True)):
            parent = int(self.parents[body])
            twist = twists[parent] if parent >= 0 else world_twist
            twist = _in_child(placement, twist) + joint_twist
            acceleration = accelerations[parent] if parent >= 0 else world_acceleration
            acceleration = _in_child(placement, acceleration)
            acceleration = acceleration + joint_accelerations[body]
            acceleration = acceleration + _motion_product(twist, joint_twist)
            twists.append(twist)
            accelerations.append(acceleration)
            wrenches.append(self._momentum_rate(body, twist, acceleration))
        for body in range(len(self) - 1, -1, -1):
            parent = int(self.parents[body])
            if parent >= 0:
                rotation, position = relative[body]
                force, moment = np.einsum("ijn,kjn->kin", rotation, wrenches[body])
                wrenches[parent][0] += force
                wrenches[parent][1] += moment + cross(position, force)
        return np.ascontiguousarray(np.array(wrenches).transpose(3, 0, 1, 2)).reshape(count, -1)

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
