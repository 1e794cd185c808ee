"""Model again: the numbers of a `pin.Model`, read once more for the proof.

They are taken from where Pinocchio puts bodies in its neutral configuration, from its Jacobian and
from the dynamic parameters of its inertias. Joints of several parts keep what was read first.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio

from ...kit.arrays import Array
from .description import (
    Description,
    JointDescription,
    LinkDescription,
    LoopDescription,
    SourceModel,
)


def reread_model(description: Description, given: SourceModel) -> Description:
    """Return a description with the numbers of the model that it was read from."""
    return _Numbers(*given).of(description)


class _Numbers:
    def __init__(self, model: pinocchio.Model, constraints: tuple[Any, ...]) -> None:
        self._model, self._constraints = model, constraints
        data = model.createData()
        neutral = pinocchio.neutral(model)
        pinocchio.framesForwardKinematics(model, data, neutral)
        self._jacobian = np.array(pinocchio.computeJointJacobians(model, data, neutral))
        self._joints = {name: index for index, name in enumerate(model.names)}
        self._placed = [np.array(data.oMi[index].homogeneous) for index in range(model.njoints)]
        self._links: dict[str, tuple[int, Array]] = {}
        for index, frame in enumerate(model.frames):
            if frame.type == pinocchio.FrameType.BODY:
                place = np.array(data.oMf[index].homogeneous)
                self._links.setdefault(frame.name, (frame.parentJoint, place))

    def _knows(self, link: str) -> bool:
        """Return whether a link is a body of the model, and not between parts of a joint."""
        return link in self._links or link.removesuffix("_link") in self._joints

    def _link_at(self, name: str) -> tuple[int, Array]:
        """Return the joint that moves a link, and where the link is in the world."""
        if name not in self._links:
            index = self._joints[name.removesuffix("_link")]
            return index, self._placed[index]
        return self._links[name]

    def of(self, description: Description) -> Description:
        """Return a description with these numbers."""
        return replace(
            description,
            links=tuple(
                self._link(link) if self._knows(link.name) else link for link in description.links
            ),
            joints=tuple(
                self._joint(joint)
                if self._knows(joint.parent) and self._knows(joint.child)
                else joint
                for joint in description.joints
            ),
            loops=tuple(
                self._loop(*item) for item in zip(description.loops, self._constraints, strict=True)
            ),
        )

    def _link(self, link: LinkDescription) -> LinkDescription:
        index, place = self._link_at(link.name)
        mass, *values = self._model.inertias[index].toDynamicParameters()
        if mass == 0.0:
            return LinkDescription(link.name)
        first = np.array(values[:3])
        xx, xy, yy, xz, yz, zz = values[3:]
        about_joint = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        centre = first / mass
        about_centre = about_joint - (centre @ first) * np.eye(3) + np.outer(centre, first)
        to_link = np.linalg.inv(place) @ self._placed[index]
        turn = to_link[:3, :3]
        return replace(
            link,
            mass=float(mass),
            centre=turn @ centre + to_link[:3, 3],
            inertia=np.einsum("ij,jk,lk->il", turn, about_centre, turn),
        )

    def _joint(self, joint: JointDescription) -> JointDescription:
        index = self._joints[joint.name]
        if self._model.joints[index].shortname() == "JointModelMimic":
            return joint  # In the neutral configuration it stands where its offset puts it.
        frame = self._placed[index]
        axis, axis_2 = joint.axis, joint.axis_2
        if joint.type in ("revolute", "continuous", "prismatic", "universal"):
            rates = self._model.idx_vs[index] + np.arange(self._model.nvs[index])
            slides = joint.type == "prismatic"
            part = self._jacobian[:3] if slides else self._jacobian[3:]
            axes = (frame[:3, :3].T @ part[:, rates]).T
            axis, axis_2 = axes[0], axes[-1]
        return replace(
            joint,
            origin=np.linalg.solve(self._link_at(joint.parent)[1], frame),
            child_placement=np.linalg.solve(frame, self._link_at(joint.child)[1]),
            axis=axis,
            axis_2=axis_2,
        )

    def _loop(self, loop: LoopDescription, constraint: Any) -> LoopDescription:
        constraint = constraint.extract() if hasattr(constraint, "extract") else constraint
        before = self._placed[constraint.joint1_id] @ constraint.joint1_placement.homogeneous
        behind = self._placed[constraint.joint2_id] @ constraint.joint2_placement.homogeneous
        return replace(
            loop,
            predecessor_origin=np.linalg.solve(self._link_at(loop.predecessor)[1], before),
            successor_origin=np.linalg.solve(self._link_at(loop.successor)[1], behind),
        )
