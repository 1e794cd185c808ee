"""Tooth forces: what meshing gears exert on each other, from axes and centres by plain geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from ..tape import Scalar, absolute, select, sqrt
from .constraints import coupled_joints
from .placing import Frame, constant
from .screws import Screw
from .vectors import add, combine, cross, dot, ratio, scale, subtract

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

    def wrench(self, frames: Frames, placed: Sequence[Frame], moment: Scalar) -> Screw:
        """Return what the teeth exert on the successor's gear, and against the other one.

        Args:
            frames: of the description.
            placed: frames of all motions.
            moment: of the coupling.
        """
        first, second = (placed[frames.last[joint]] for joint in self.joints)
        axis, axis_2 = (
            combine(frame.axes, constant(frames.motions[frames.last[joint]].axis))
            for frame, joint in zip((first, second), self.joints, strict=True)
        )
        # Seen from the carrier, at unit rate of the predecessor's joint.
        spin = scale(axis, float(self.senses[0]))
        spin_2 = scale(axis_2, self.senses[1] * self.ratio)
        way = subtract(second.origin, first.origin)
        across = subtract(way, scale(axis, dot(way, axis)))
        distance = sqrt(dot(across, across))
        radius = ratio(-dot(spin_2, axis) * distance, dot(subtract(spin, spin_2), axis))
        outwards = scale(across, ratio(1.0, distance))
        along = 0.0 if self.mesh.along is None else self.mesh.along
        point = add(first.origin, add(scale(outwards, radius), scale(axis, along)))
        tangent = cross(axis, outwards)
        # The moment acts along the successor's rate, which moves its gear's teeth at this speed.
        arm = scale(outwards, radius - distance)
        speed = dot(tangent, cross(scale(axis_2, float(self.senses[1])), arm))
        tangential = ratio(moment, speed)
        # No force along the teeth, which wind about the predecessor's axis.
        hand = math.tan(self.mesh.helix_angle) * _sign(radius)
        force = subtract(scale(tangent, tangential), scale(axis, hand * tangential))
        pressure = absolute(tangential) * sqrt(1.0 + hand * hand)
        pressure = pressure * math.tan(self.mesh.pressure_angle)
        # Away from the gear whose teeth point inwards.
        is_outside = absolute(radius) - absolute(radius - distance)
        towards = select(is_outside, _sign(distance - radius), _sign(radius))
        force = add(force, scale(outwards, pressure * towards))
        return force, cross(point, force)


def _sign(x: Scalar) -> Scalar:
    return select(x, 1.0, -1.0)
