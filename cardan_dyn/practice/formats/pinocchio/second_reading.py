"""Second reading of a `pin.Model`: its numbers, read once more for the proof.

They are taken from where Pinocchio puts bodies in its neutral configuration, from its Jacobian and
from the dynamic parameters of its inertias. Joints of several parts, and those that mimic others,
keep what was read first.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio

from ....core.description.description import (
    Description,
    JointDescription,
    LinkDescription,
    LoopDescription,
    at_last_parts,
    kinds_of,
)
from ....kit.arrays import Array
from ..renumbered import link_of, placed_at
from .source import SourceModel

_SEVERAL = ("Composite", "Translation", "Mimic", "H")
"""What joints of several parts, and what follows others, are called behind `JointModel`."""


def reread(description: Description, source: SourceModel) -> Description:
    """Return a description with the numbers of the model that it was read from.

    Its links are the bodies in the order of the model's joints, then those between parts of joints.
    """
    bodies = source.model.njoints
    links, between = description.links[:bodies], description.links[bodies:]
    read = _Placed(source.model, [link.name for link in links])
    return replace(
        description,
        links=(*(read.link(*item) for item in enumerate(links)), *between),
        joints=tuple(map(read.joint, description.joints)),
        loops=tuple(
            read.loop(*item) for item in zip(description.loops, source.constraints, strict=True)
        ),
    )


class _Placed:
    """A model in its neutral configuration.

    Attributes:
        model: the model.
        joints: `(4, 4)` placements of the joints in the world.
        links: those of the links that they carry, by name.
    """

    def __init__(self, model: pinocchio.Model, links: list[str]) -> None:
        data, neutral = model.createData(), pinocchio.neutral(model)
        pinocchio.framesForwardKinematics(model, data, neutral)
        jacobian = np.array(pinocchio.computeJointJacobians(model, data, neutral))
        self._jacobian = jacobian.reshape(6, -1)  # A single column comes without its axis.
        self.model = model
        self.joints = [np.array(data.oMi[index].homogeneous) for index in range(model.njoints)]
        bodies: dict[int, Array] = {}
        for frame, place in zip(model.frames, data.oMf, strict=True):
            if frame.type == pinocchio.FrameType.BODY:
                bodies.setdefault(frame.parentJoint, np.array(place.homogeneous))
        self.links = {
            name: bodies.get(index, joint)
            for index, (name, joint) in enumerate(zip(links, self.joints, strict=True))
        }
        light = pinocchio.Model(model)
        for index in range(light.njoints):
            light.inertias[index] = pinocchio.Inertia.Zero()
        light.armature += model.rotorInertia * model.rotorGearRatio**2
        # What efforts accelerate where no body has mass.
        self._armature = pinocchio.rnea(
            light, light.createData(), neutral, np.zeros(model.nv), np.ones(model.nv)
        )

    def link(self, index: int, link: LinkDescription) -> LinkDescription:
        """Return a link with its mass, from moments about the joint."""
        parameters = np.array(self.model.inertias[index].toDynamicParameters())
        frame = np.linalg.solve(self.links[link.name], self.joints[index])
        return link_of(link.name, parameters, frame)

    def joint(self, joint: JointDescription) -> JointDescription:
        """Return a joint with its placements and axes."""
        model = self.model
        index = model.getJointId(joint.name)
        if index == model.njoints:
            return joint  # It is a part of one.
        kind = model.joints[index].shortname().removeprefix("JointModel")
        if kind.startswith(_SEVERAL):
            return joint
        frame, axes = self.joints[index], ()
        if joint.type in ("revolute", "continuous", "prismatic", "universal"):
            rates = model.idx_vs[index] + np.arange(model.nvs[index])
            part = self._jacobian[:3] if joint.type == "prismatic" else self._jacobian[3:]
            axes = (frame[:3, :3].T @ part[:, rates]).T
        rotors = self._armature[model.idx_vs[index] :][: len(kinds_of(joint.type))]
        placed = placed_at(joint, [frame], self.links, *axes)
        return replace(placed, armature=at_last_parts(rotors.tolist(), joint.type))

    def loop(
        self, loop: LoopDescription, constraint: tuple[int, Array, int, Array]
    ) -> LoopDescription:
        """Return a loop with its placements."""
        first, before, second, behind = constraint
        ends = self.joints[first] @ before, self.joints[second] @ behind
        return placed_at(loop, ends, self.links)
