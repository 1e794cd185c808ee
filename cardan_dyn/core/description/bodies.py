"""Bodies: links of a description that fixed joints make one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...kit.arrays import Array
from .description import Description, JointDescription, LinkDescription, LoopDescription


class Body:
    """Links that fixed joints join to one body, in the frame of the joint that moves them.

    Attributes:
        joint: that joint; None for the body that is fixed to the world.
        parent: the body that carries it; None of the same.
        placement: `(4, 4)` of the joint in the parent.
        links: those that it consists of, and their `(4, 4)` placements.
        children: bodies that move on this one, in the order of their joints.
        loops: loops whose predecessor is one of the links.
    """

    def __init__(
        self,
        joint: JointDescription | None = None,
        parent: Body | None = None,
        placement: Array | None = None,
    ) -> None:
        self.joint, self.parent = joint, parent
        self.placement = np.eye(4) if placement is None else placement
        self.links: list[tuple[LinkDescription, Array]] = []
        self.children: list[Body] = []
        self.loops: list[LoopDescription] = []

    @property
    def mass(self) -> float:
        """The mass of its links together [kg]."""
        return sum(link.mass for link, _ in self.links)

    def at(self, link: str) -> Array:
        """Return the `(4, 4)` placement of one of its links."""
        return next(placement for own, placement in self.links if own.name == link)

    def path(self) -> Iterator[Body]:
        """Yield it and those that carry it, without the one that stands still."""
        body: Body | None = self
        while body is not None and body.parent is not None:
            yield body
            body = body.parent


def bodies_of(description: Description) -> dict[str, Body]:
    """Return link to its body; children have the order in which Pinocchio takes their joints."""
    position = {name: index for index, name in enumerate(description.order)}
    links = {link.name: link for link in description.links}
    joints: dict[str, list[JointDescription]] = {name: [] for name in links}
    for joint in sorted(description.joints, key=lambda joint: position[joint.name]):
        joints[joint.parent].append(joint)
    root = Body()
    root.links.append((links[description.root], np.eye(4)))
    bodies, placed = {description.root: root}, {description.root: np.eye(4)}
    pending = joints[description.root][::-1]
    while pending:
        joint = pending.pop()
        body, placement = bodies[joint.parent], placed[joint.parent] @ joint.origin
        at = joint.child_placement
        if joint.type == "fixed":
            at = placement @ at
        else:
            child = Body(joint, body, placement)
            body.children.append(child)
            body = child
        bodies[joint.child], placed[joint.child] = body, at
        body.links.append((links[joint.child], at))
        pending.extend(reversed(joints[joint.child]))
    for loop in description.loops:
        bodies[loop.predecessor].loops.append(loop)
    return bodies
