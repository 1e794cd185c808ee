"""Long chain: the batch model of more bodies than `pin.Data` can hold.

Its memory grows with the third power of the coordinates: gigabytes for a hundred bodies. Beyond
some thirty, placements and wrenches come from recursions over the bodies, whose arrays hold all
samples.
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
                before, start = placed[parent]
                position = start + np.einsum("ijn,jn->in", before, position)
                rotation = np.einsum("ijn,jkn->ikn", before, rotation)
            placed.append((rotation, position))
            block = result[:, 6 * body : 6 * body + 6]
            columns = rotation.transpose(2, 1, 0)
            block[:, :3, :3] = block[:, 3:, 3:] = columns
            block[:, 3:, :3] = np.cross(position.T[:, None, :], columns)
        return result

    def inverse_dynamics(self, q: Array, v: Array, a: Array, gravity: Array) -> Array:
        """See `BatchModel.inverse_dynamics`; Newton and Euler's recursion."""
        count = len(q)
        rates, changes = (
            part.reshape(count, len(self), 2, 3).transpose(1, 2, 3, 0) for part in (v, a)
        )
        # Bodies that fall upwards feel what bodies at rest feel under gravity.
        still = np.zeros((2, 3, count))
        falling = still.copy()
        falling[0] = -gravity[:, None]
        relative = self._relative(q)
        twists: list[Array] = []
        accelerations: list[Array] = []
        wrenches: list[Array] = []
        for body, (placement, own) in enumerate(zip(relative, rates, strict=True)):
            parent = int(self.parents[body])
            twist = _into(placement, twists[parent] if parent >= 0 else still) + own
            change = _into(placement, accelerations[parent] if parent >= 0 else falling)
            change = change + changes[body] + _moved(twist, own)
            twists.append(twist)
            accelerations.append(change)
            wrenches.append(self._momentum_rate(body, twist, change))
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
            here = np.ascontiguousarray(q[:, 7 * body : 7 * body + 7].T)
            x, y, z, w = here[3:]
            turn = np.array(
                [
                    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
                    [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
                    [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
                ]
            )
            origin = self.model.jointPlacements[body + 1]
            position = origin.translation[:, None] + origin.rotation @ here[:3]
            result.append((np.einsum("ij,jkn->ikn", origin.rotation, turn), position))
        return result

    def _momentum_rate(self, body: int, twist: Array, change: Array) -> Array:
        """Return the wrench about a body's origin that its motion takes."""
        inertia = self.model.inertias[body + 1]
        if inertia.mass == 0.0:
            return np.zeros_like(twist)
        centre = inertia.lever[:, None] * np.ones(twist.shape[2])
        spin = twist[1]
        speed = twist[0] + cross(spin, centre)
        # The spatial acceleration lacks the centripetal part of that of a point.
        force = inertia.mass * (change[0] + cross(change[1], centre) + cross(spin, speed))
        momentum = inertia.inertia @ spin
        moment = inertia.inertia @ change[1] + cross(spin, momentum) + cross(centre, force)
        return np.stack([force, moment])


def _into(placement: tuple[Array, Array], twist: Array) -> Array:
    """Return a twist of the parent's frame in the child's."""
    rotation, position = placement
    linear = twist[0] + cross(twist[1], position)
    return np.einsum("jin,kjn->kin", rotation, np.stack([linear, twist[1]]))


def _moved(twist: Array, other: Array) -> Array:
    """Return by how much a twist that moves with another one changes."""
    linear = cross(twist[1], other[0]) + cross(twist[0], other[1])
    return np.stack([linear, cross(twist[1], other[1])])
