"""Tree: Pinocchio's model of a description, with a joint for every loop.

Every joint is a chain of elementary parts (turn about an axis, slide along an axis, ball) through
massless bodies. So all joint types, and loops as well as tree joints, go through the same few
lines everywhere else.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ...kit.errors import ModelError
from ..description.bodies import Body, bodies_of
from ..description.description import elementary
from .joints import Part

if TYPE_CHECKING:
    from ..description.description import (
        Description,
        JointDescription,
        JointOrLoop,
        LinkDescription,
        LoopDescription,
    )


class TreeBuilder:
    """Builds the model of a description.

    Attributes:
        model: the tree with the joints of its loops, their armatures included.
        parts: joint name to its parts in the model; none for `fixed` joints and loops.
        links: link name to `(body in the model, pin.SE3 placement there)`.
    """

    def __init__(self, description: Description, cardan: Collection[str] = ()) -> None:
        """Build the model.

        Args:
            description: of the mechanism.
            cardan: names of the joints whose balls are written as three turns.
        """
        self._description = description
        self._cardan = cardan
        self._bodies = bodies_of(description)
        self._fixed = {item.child: item.name for item in description.joints if item.type == "fixed"}
        self._shares = self._count_shares()
        self.model = pinocchio.Model()
        self.model.name = description.name
        self.parts: dict[str, list[Part]] = {}
        self.links: dict[str, tuple[int, pinocchio.SE3]] = {}
        self._armature: list[float] = []
        self._build()
        self.model.armature = np.array(self._armature)

    def _build(self) -> None:
        """Add all joints, depth first.

        Loops cannot be appended at the end: Pinocchio's inertia matrix and constrained dynamics
        assume that the joints of a subtree follow each other, and are silently wrong otherwise.
        """
        root = self._bodies[self._description.root]
        index = {root: 0}
        self.model.inertias[0] = self._inertia(root)
        self._add_frames(root, 0)
        pending = _items_on(root)
        while pending:
            parent, item = pending.pop()
            if isinstance(item, Body):
                index[item] = self._add_body(item, index[parent])
                self._add_frames(item, index[item])
                pending += _items_on(item)
            elif item.type != "fixed":
                placement = parent.at(item.predecessor) @ item.predecessor_origin
                body = self._add(item, self._chain(item), index[parent], se3(placement))
                self.model.inertias[body] = self._loop_inertia(item)
            else:
                self.parts[item.name] = []

    def _add_body(self, body: Body, parent: int) -> int:
        joint = body.joint
        if joint is None:
            raise ValueError("only moving bodies are added")
        chain = self._chain(joint)
        index = self._add(joint, chain, parent, se3(body.placement))
        self.model.inertias[index] = _share(self._inertia(body), self._shares.get(body, 1))
        if len(chain) == 1:
            self._set_limits(joint, index)
        return index

    def _chain(self, joint: JointOrLoop) -> list[tuple[str, Array]]:
        return elementary(joint.type, joint.axis, joint.axis_2, joint.name in self._cardan)

    def _add(
        self,
        joint: JointOrLoop,
        chain: list[tuple[str, Array]],
        parent: int,
        placement: pinocchio.SE3,
    ) -> int:
        """Add the parts of a joint; the last one has the joint's name. Return the child body."""
        parts, name = [], joint.name
        rotors = joint.armature or (0.0,) * len(chain)
        if len(rotors) < len(chain):
            self._refuse_turns(joint)
            rotors = (*rotors[:-1], 0.0, 0.0, 0.0)
        for count, ((part, axis), rotor) in enumerate(zip(chain, rotors, strict=True), start=1):
            part_name = name if count == len(chain) else f"{name}:{count}"
            kind = joint.type if joint.type == "continuous" else part
            parent = self.model.addJoint(parent, joint_model(kind, axis), placement, part_name)
            parts.append(Part(part, axis, parent))
            self._armature += [rotor] * parts[-1].nv
            placement = pinocchio.SE3.Identity()
        self.parts[name] = parts
        return parent

    def _refuse_turns(self, joint: JointOrLoop) -> None:
        """Refuse the armature of a ball that is written as three turns.

        Raises:
            ModelError: it has one, which is about the axes of its child and not along these turns.
        """
        if joint.armature[-1]:
            inertia = f"{joint.armature[-1]:g} kg·m²"
            raise ModelError(
                f"{self._description.name}: joint {joint.name!r}: its ball has an armature, so "
                "that no scene can name its angles; where its parent stands still, the link that "
                f"it carries moves the same with {inertia} more in each of ixx, iyy and izz and "
                "none; else write three hinges in a row about x, y and z without any, and three "
                'more on the ground that <mimic> these with forces="none" and carry a link of 1 kg '
                f"in their centre, whose ixx, iyy and izz are {inertia} each"
            )

    def _add_frames(self, body: Body, index: int) -> None:
        """Add the frames that Pinocchio's readers would: of links, and of their joints."""
        kinds = pinocchio.FrameType
        if body.joint is not None:
            frame = pinocchio.SE3.Identity()
            self._add_frame(body.joint.name, index, frame, kinds.JOINT)
        for link, placement in body.links:
            frame = se3(placement)
            self.links[link.name] = index, frame
            fixed = self._fixed.get(link.name)
            if fixed is not None:
                self._add_frame(fixed, index, frame, kinds.FIXED_JOINT)
            self._add_frame(link.name, index, frame, kinds.BODY)

    def _add_frame(
        self, name: str, index: int, placement: pinocchio.SE3, kind: pinocchio.FrameType
    ) -> None:
        if not self.model.existFrame(name, kind):
            self.model.addFrame(pinocchio.Frame(name, index, placement, kind), False)

    def _inertia(self, body: Body) -> pinocchio.Inertia:
        """Return the inertia of all links of a body together."""
        total = pinocchio.Inertia.Zero()
        for link, placement in body.links:
            if not link.is_massless:
                total = total + placed_inertia(link, se3(placement))
        return total

    def _count_shares(self) -> dict[Body, int]:
        """Return among how many bodies of the model the successor of each loop is split."""
        shares: dict[Body, int] = {}
        for loop in self._description.loops:
            successor = self._bodies[loop.successor]
            if self._bodies[loop.predecessor] is successor:
                raise ModelError(
                    f"{self._description.name}: loop {loop.name!r} connects {loop.predecessor!r} "
                    f"and {loop.successor!r}, which fixed joints already make one body"
                )
            if loop.type != "fixed":
                shares[successor] = shares.get(successor, 1) + 1
        return shares

    def _loop_inertia(self, loop: LoopDescription) -> pinocchio.Inertia:
        """Return the inertia of the body that carries a loop's joint: a share of its successor's.

        A successor that is the world has none.
        """
        body = self._bodies[loop.successor]
        if body.joint is None:
            return pinocchio.Inertia.Zero()
        placement = se3(body.at(loop.successor) @ loop.successor_origin)
        return placement.actInv(_share(self._inertia(body), self._shares[body]))

    def _set_limits(self, joint: JointDescription, index: int) -> None:
        model, limits = self.model, joint.limits
        if model.joints[index].nq == 1:
            model.lowerPositionLimit[model.idx_qs[index]] = limits.lower
            model.upperPositionLimit[model.idx_qs[index]] = limits.upper
        rates = slice(model.idx_vs[index], model.idx_vs[index] + model.nvs[index])
        model.lowerVelocityLimit[rates] = -limits.velocity
        model.upperVelocityLimit[rates] = limits.velocity
        model.lowerEffortLimit[rates], model.upperEffortLimit[rates] = limits.efforts


def _items_on(body: Body) -> list[tuple[Body, Body | LoopDescription]]:
    """Return a body with each child, then with each loop, the first ones last."""
    items: list[Body | LoopDescription] = [*body.children, *body.loops]
    return [(body, item) for item in reversed(items)]


def artificial_inertia(description: Description, length: float) -> pinocchio.Inertia:
    """Return the inertia of a body that only carries a loop's joint to the world.

    It does not move. Inertia of the size of the other links' keeps the inertia matrix regular.

    Args:
        description: of the mechanism.
        length: characteristic length [m].
    """
    masses = [link.mass for link in description.links if link.mass > 0.0]
    mass = float(np.mean(masses)) if masses else 1.0
    return pinocchio.Inertia(mass, np.zeros(3), mass * length**2 * np.eye(3))


def se3(matrix: Array) -> pinocchio.SE3:
    """Return a `(4, 4)` placement as Pinocchio's type."""
    return pinocchio.SE3(matrix)


_ALIGNED = {
    "revolute": ("JointModelRX", "JointModelRY", "JointModelRZ"),
    "prismatic": ("JointModelPX", "JointModelPY", "JointModelPZ"),
    "continuous": ("JointModelRUBX", "JointModelRUBY", "JointModelRUBZ"),
}


def joint_model(kind: str, axis: Array) -> pinocchio.JointModel:
    """Return the joint that Pinocchio's own reader would take.

    A `continuous` one turns without end: its configuration is a cosine and a sine.
    """
    if kind == "spherical":
        return pinocchio.JointModelSpherical()
    components = axis.tolist()
    if sorted(components) == [0.0, 0.0, 1.0]:
        return getattr(pinocchio, _ALIGNED[kind][components.index(1.0)])()
    if kind == "prismatic":
        return pinocchio.JointModelPrismaticUnaligned(axis)
    if kind == "revolute":
        return pinocchio.JointModelRevoluteUnaligned(axis)
    # The bindings give no way to set the axis of such a joint; the reader does.
    xyz = " ".join(map(repr, components))
    model = pinocchio.buildModelFromXML(
        '<robot name="robot"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
        f'<parent link="a"/><child link="b"/><axis xyz="{xyz}"/></joint></robot>'
    )
    return model.joints[1]


def _inertia(mass: float, centre: Array, tensor: Array) -> pinocchio.Inertia:
    """Return an inertia, also one that no body can have, which the constructor would refuse."""
    inertia = pinocchio.Inertia.Zero()
    inertia.mass, inertia.lever, inertia.inertia = mass, centre, 0.5 * (tensor + tensor.T)
    return inertia


def placed_inertia(link: LinkDescription, placement: pinocchio.SE3) -> pinocchio.Inertia:
    """Return the inertia of a link that is placed in a frame, in that frame."""
    return placement.act(_inertia(link.mass, link.centre, link.inertia))


def _share(whole: pinocchio.Inertia, parts: int) -> pinocchio.Inertia:
    """Return the inertia of one of several equal parts at the same place."""
    return _inertia(whole.mass / parts, whole.lever, whole.inertia / parts)


def ancestors(model: pinocchio.Model, index: int) -> list[int]:
    """Return the bodies (0-based) from the root to the body of a joint index, its own last."""
    path = []
    while index > 0:
        path.append(index - 1)
        index = model.parents[index]
    return path[::-1]
