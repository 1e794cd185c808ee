"""Second reading of a `pin.Model`: its numbers, read once more for the proof.

They are taken from where Pinocchio puts bodies in its neutral configuration, from its Jacobian and
from the dynamic parameters of its inertias. Joints of several parts, and those that mimic others,
keep what was read first.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio

from ....kit.arrays import Array
from ..description import (
    Description,
    JointDescription,
    LinkDescription,
    LoopDescription,
    SourceModel,
    at_last_parts,
    kinds_of,
)

_SEVERAL = ("Composite", "Translation", "Mimic", "H")
"""What joints of several parts, and what follows others, are called behind `JointModel`."""


def reread(description: Description, given: SourceModel) -> Description:
    """Return a description with the numbers of the model that it was read from.

    Its links are the bodies in the order of the model's joints, then those between parts of joints.
    """
    read, bodies = _Placed(given.model), given.model.njoints
    links, between = description.links[:bodies], description.links[bodies:]
    return replace(
        description,
        links=(*(read.link(*item) for item in enumerate(links)), *between),
        joints=tuple(map(read.joint, description.joints)),
        loops=tuple(
            read.loop(*item) for item in zip(description.loops, given.constraints, strict=True)
        ),
    )


class _Placed:
    """A model in its neutral configuration.

    Attributes:
        model: the model.
        joints: `(4, 4)` placements of the joints in the world.
        links: those of the links that they carry.
    """

    def __init__(self, model: pinocchio.Model) -> None:
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
        self.links = [bodies.get(index, joint) for index, joint in enumerate(self.joints)]
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
        mass, *values = self.model.inertias[index].toDynamicParameters()
        first = np.array(values[:3])
        xx, xy, yy, xz, yz, zz = values[3:]
        about_joint = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        centre = first / mass if mass else first
        about_centre = about_joint - (centre @ first) * np.eye(3) + np.outer(centre, first)
        to_link = np.linalg.solve(self.links[index], self.joints[index])
        turn = to_link[:3, :3]
        return replace(
            link,
            mass=float(mass),
            centre=turn @ centre + to_link[:3, 3],
            inertia=np.einsum("ij,jk,lk->il", turn, about_centre, turn),
        )

    def joint(self, joint: JointDescription) -> JointDescription:
        """Return a joint with its placements and axes."""
        model = self.model
        index = model.getJointId(joint.name)
        if index == model.njoints:
            return joint  # It is a part of one.
        kind = model.joints[index].shortname().removeprefix("JointModel")
        if kind.startswith(_SEVERAL):
            return joint
        frame, axis, axis_2 = self.joints[index], joint.axis, joint.axis_2
        if joint.type in ("revolute", "continuous", "prismatic", "universal"):
            rates = model.idx_vs[index] + np.arange(model.nvs[index])
            slides = joint.type == "prismatic"
            part = self._jacobian[:3] if slides else self._jacobian[3:]
            axes = (frame[:3, :3].T @ part[:, rates]).T
            axis, axis_2 = axes[0], axes[-1]
        rotors = self._armature[model.idx_vs[index] :][: len(kinds_of(joint.type))]
        return replace(
            joint,
            origin=np.linalg.solve(self.links[model.parents[index]], frame),
            child_placement=np.linalg.solve(frame, self.links[index]),
            axis=axis,
            axis_2=axis_2,
            armature=at_last_parts(rotors.tolist(), joint.type),
        )

    def loop(
        self, loop: LoopDescription, constraint: tuple[int, Array, int, Array]
    ) -> LoopDescription:
        """Return a loop with its placements."""
        first, before, second, behind = constraint
        return replace(
            loop,
            predecessor_origin=np.linalg.solve(self.links[first], self.joints[first] @ before),
            successor_origin=np.linalg.solve(self.links[second], self.joints[second] @ behind),
        )
