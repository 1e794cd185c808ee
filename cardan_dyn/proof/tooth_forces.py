"""Tooth forces: what gears that mesh exert on each other, for the proof.

Where they touch follows from what they do: both move alike there, as seen from the link that
carries both. How much they exert follows from the power of their coupling's moment.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from .constraints import coupled_joints
from .twists import State, cross

if TYPE_CHECKING:
    from ..description.description import Description, Mesh
    from ..mechanism.frames import Frames


class MeshingGears(NamedTuple):
    """Two gears that mesh.

    Attributes:
        coupling: its index.
        joints: indices of the predecessor's and of the successor's joint.
        bodies: of the two gears, -1 for the world.
        senses: 1 where the gear is the joint's child, -1 where it is the parent.
        ratio: of the coupling.
        mesh: the teeth.
    """

    coupling: int
    joints: tuple[int, int]
    bodies: tuple[int, int]
    senses: tuple[int, int]
    ratio: float
    mesh: Mesh

    @staticmethod
    def of(description: Description, frames: Frames) -> list[MeshingGears]:
        """Return all gears of a description that mesh."""
        found = []
        for index, item in enumerate(description.couplings):
            if item.mesh is None:
                continue
            ((first,), (second,)) = coupled_joints(item, frames)
            joints = frames.joints.index(first), frames.joints.index(second)
            links = [{frames.parents[joint], frames.children[joint]} for joint in joints]
            bodies = tuple((own - links[1 - k]).pop() for k, own in enumerate(links))
            senses = [
                1 if frames.children[j] == b else -1 for j, b in zip(joints, bodies, strict=True)
            ]
            found.append(
                MeshingGears(
                    index,
                    joints,
                    (bodies[0], bodies[1]),
                    (senses[0], senses[1]),
                    item.ratio,
                    item.mesh,
                )
            )
        return found

    def wrench(self, state: State, frames: Frames, moment: Array) -> Array:
        """Return what the teeth exert on the successor's gear, and against the other one.

        Args:
            state: of the mechanism.
            frames: of the description.
            moment: of the coupling `(N,)`.

        Returns:
            `(2, 3, N)` in world axes about `Frames.corner`.
        """
        places = [state.joint_frames[joint] for joint in self.joints]
        axes = [
            np.einsum("c,cin->in", frames.motions[frames.last[joint]].axis, place[:3])
            for joint, place in zip(self.joints, places, strict=True)
        ]
        # Seen from the carrier, at unit rate of the predecessor's joint.
        spins = [
            sense * rate * axis
            for sense, rate, axis in zip(self.senses, (1.0, self.ratio), axes, strict=True)
        ]
        way = places[1][3] - places[0][3]
        height = np.sum(way * axes[0], axis=0)
        across = way - height * axes[0]
        distance = np.sqrt(np.sum(across**2, axis=0))
        relative = np.sum((spins[0] - spins[1]) * axes[0], axis=0)
        radius = -np.sum(spins[1] * axes[0], axis=0) * distance / relative
        outwards = across / distance
        along = 0.0 if self.mesh.along is None else self.mesh.along
        arms = radius * outwards, (radius - distance) * outwards
        point = places[0][3] + arms[0] + along * axes[0]
        tangent = cross(axes[0], outwards)
        # The moment acts along the successor's rate, which moves its gear's teeth at this speed.
        speed = np.sum(tangent * cross(self.senses[1] * axes[1], arms[1]), axis=0)
        force = moment / speed * tangent
        # No force along the teeth, which wind about the predecessor's axis.
        hand = np.tan(self.mesh.helix_angle) * np.sign(radius)
        force = force - hand * np.sum(force * tangent, axis=0) * axes[0]
        size = np.sqrt(np.sum(force**2, axis=0)) * np.tan(self.mesh.pressure_angle)
        inner = np.abs(radius) < np.abs(radius - distance)
        towards = np.where(inner, np.sign(radius), np.sign(distance - radius))
        force = force + size * towards * outwards
        return np.stack([force, cross(point, force)])
