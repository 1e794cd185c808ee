"""Rigid groups: links that fixed joints make one body, for the writer of MJCF."""

from __future__ import annotations

import numpy as np

from ...arrays import Array, inverse
from ...errors import ModelError
from ..description import Description, JointDescription, LinkDescription, LoopDescription
from .inertia import Mass, total


class RigidGroups:
    """The groups of links of a description that move as one body."""

    def __init__(self, description: Description) -> None:
        self._links = {link.name: link for link in description.links}
        self._carriers = {joint.child: joint for joint in description.joints}
        self._root = description.root
        self._first: dict[str, str] = {}
        self._placements: dict[str, Array] = {}
        for name in self._links:
            self._place(name)
        self._members: dict[str, list[LinkDescription]] = {}
        for link in description.links:
            self._members.setdefault(self._first[link.name], []).append(link)
        self._shares: dict[str, int] = {}
        for loop in description.loops:
            if loop.type not in ("spherical", "fixed"):
                first = self._first[loop.successor]
                self._shares[first] = self._shares.get(first, 1) + 1

    def _place(self, name: str) -> None:
        """Find the first link of the group of a link, and the placement of the link there."""
        path = []
        while name not in self._first:
            joint = self._carriers.get(name)
            if joint is None or joint.type != "fixed":
                self._first[name], self._placements[name] = name, np.eye(4)
                break
            path.append(joint)
            name = joint.parent
        for joint in reversed(path):
            self._first[joint.child] = self._first[joint.parent]
            placement = self._placements[joint.parent] @ joint.origin @ joint.child_placement
            self._placements[joint.child] = placement

    def link(self, name: str) -> LinkDescription:
        """Return a link by name."""
        return self._links[name]

    def placement(self, link: str) -> Array:
        """Return the `(4, 4)` placement of a link in the first link of its group."""
        return self._placements[link]

    def is_fixed(self, link: str) -> bool:
        """Return whether a link stands still."""
        return self._first[link] == self._root

    def members(self, link: str) -> list[LinkDescription]:
        """Return all links that move as one with a link."""
        return self._members[self._first[link]]

    def mass(self, link: str) -> float:
        """Return the mass [kg] of all links that move as one with a link."""
        return sum(item.mass for item in self.members(link))

    def shares(self, link: str) -> int:
        """Return among how many bodies the inertia of a link's group is split."""
        return 1 if self.is_fixed(link) else self._shares.get(self._first[link], 1)

    def helper(self, loop: LoopDescription, name: str) -> LinkDescription:
        """Return the mass of the body that carries a loop's joint, in the joint's frame.

        It is a share of its successor's. A successor that stands still has none that counts: a
        mass of the size of the others keeps the model regular and is held by the weld alone.
        """
        if self.is_fixed(loop.successor):
            masses = [link.mass for link in self._links.values() if link.mass > 0.0]
            mass = float(np.mean(masses)) if masses else 1.0
            return LinkDescription(name, mass, np.zeros(3), mass * np.eye(3))
        frame = self._placements[loop.successor] @ loop.successor_origin
        parts = []
        for link in self.members(loop.successor):
            placement = inverse(frame) @ self._placements[link.name]
            turn = placement[:3, :3]
            centre = turn @ link.centre + placement[:3, 3]
            parts.append(Mass(link.mass, centre, turn @ link.inertia @ turn.T))
        whole, count = total(parts), self.shares(loop.successor)
        if whole is None:
            raise ModelError(
                f"loop {loop.name!r}: its successor {loop.successor!r} moves and has no mass, "
                "which MuJoCo does not accept; give it one"
            )
        return LinkDescription(name, whole.mass / count, whole.centre, whole.inertia / count)

    def path(self, link: str) -> list[JointDescription]:
        """Return the moving joints from a link to the root."""
        joints = []
        while link in self._carriers:
            joint = self._carriers[link]
            if joint.type != "fixed":
                joints.append(joint)
            link = joint.parent
        return joints
