"""Frames: where every joint and body of a description is, by plain forward kinematics.

Nothing here uses Pinocchio, groups, or the solution of a mechanism, so that the proof of a result
can rely on it: joint coordinates go in, placements in world axes come out, joint after joint from
the root.

Frames are `(4, 3, N)`: three axes and an origin in world axes.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array, cross

if TYPE_CHECKING:
    from ..description.description import (
        Description,
        JointDescription,
        JointOrLoop,
        LinkDescription,
        LoopDescription,
    )
    from .coordinates import Coordinates

_IDENTITY = np.eye(4)


class RigidBody(NamedTuple):
    """Links that fixed joints join to one body.

    Attributes:
        mass: [kg].
        centre: `(3,)` in the frame of the joint that moves it, or in the world [m].
        inertia: `(3, 3)` about the centre, in that frame [kg·m²].
    """

    mass: float
    centre: Array
    inertia: Array


class ElementaryMotion(NamedTuple):
    """An elementary motion of a joint: a turn or a slide along an axis, or a ball.

    Attributes:
        kind: `turn`, `slide` or `ball`.
        joint: index of its joint in `Frames`.
        axis: `(3,)` in the joint's frame.
        before: index of the motion that moves its frame, -1 for the world.
        placement: `(4, 4)` of its frame in that one.
        column: first column of its coordinates in a row `x`.
        rate: first column of its rates in a velocity.
    """

    kind: str
    joint: int
    axis: Array
    before: int
    placement: Array
    column: int
    rate: int

    @property
    def size(self) -> int:
        """Number of rates."""
        return 3 if self.kind == "ball" else 1


class Frames:
    """Joints and bodies of a description, and where they are.

    Attributes:
        joints: names: those of the tree from the root outwards, then the loops.
        bodies: the bodies; body `j` is what joint `j` of the tree moves.
        parents: per joint, the index of its parent's body, -1 for the world.
        children: per joint, the index of the body that it acts on; of a loop, its successor.
        ends: per loop, the `(4, 4)` placement of its frame in its successor.
        motions: elementary motions of all joints, those of a joint in a row.
        last: per joint, the index of its last motion, whose frame is the joint's; where it has
            none (a `fixed` loop), of the one that moves its predecessor.
        fixed_placement: per joint without motion, its `(4, 4)` placement in that frame.
        tree: how many joints the tree has; the loops follow them.
        links: link to the index of its body, -1 for the world, and its `(4, 4)` placement there.
        origins: joints that are lengths and angles of the description.
        corner: `(3,)` the point about which moments are taken, so that no digits are lost far from
            the world's origin.
    """

    def __init__(self, description: Description, coordinates: Coordinates) -> None:
        self.joints: list[str] = []
        self.parents: list[int] = []
        self.children: list[int] = []
        self.motions: list[ElementaryMotion] = []
        self.last: list[int] = []
        self.fixed_placement: dict[int, Array] = {}
        self._columns, self._rates = coordinates.columns, coordinates.velocity_columns
        self._cardan = coordinates.cardan
        self.links = self._add_tree(description)
        self._described = description
        self.origins = frozenset(description.origins)
        self.tree = len(self.joints)
        self.ends = [self._add_loop(loop) for loop in description.loops]
        self.bodies = self._bodies(description)
        self.corner = self._corner()

    @cached_property
    def link_frames(self) -> dict[str, tuple[int, Array]]:
        """The same as `links`, of these and of what is fixed in them.

        Those are `fixed` joints of the tree, and frames of the description. Of one name, links come
        first, then joints.
        """
        found = dict(self.links)
        for name, (link, place) in self._described.fixed_frames.items():
            body, placement = self.links[link]
            found.setdefault(name, (body, placement @ place))
        return found

    def _add_tree(self, description: Description) -> dict[str, tuple[int, Array]]:
        """Add the joints of the tree, depth first; return the links, see `links`."""
        links = {description.root: (-1, np.eye(4))}
        children: dict[str, list[JointDescription]] = {link.name: [] for link in description.links}
        for joint in description.joints:
            children[joint.parent].append(joint)
        pending = children[description.root][::-1]
        while pending:
            joint = pending.pop()
            body, placement = links[joint.parent]
            placement = placement @ joint.origin
            if joint.type == "fixed":
                links[joint.child] = body, placement @ joint.child_placement
            else:
                child = len(self.joints)
                self._add(joint.name, joint, body, child, placement)
                links[joint.child] = child, joint.child_placement
            pending.extend(children[joint.child][::-1])
        return links

    def _add_loop(self, loop: LoopDescription) -> Array:
        """Add the joint of a loop; return the `(4, 4)` placement of its frame in its successor."""
        body, placement = self.links[loop.predecessor]
        successor, end = self.links[loop.successor]
        self._add(loop.name, loop, body, successor, placement @ loop.predecessor_origin)
        return np.asarray(end @ loop.successor_origin)

    def _add(
        self,
        name: str,
        joint: JointOrLoop,
        body: int,
        child: int,
        placement: Array,
    ) -> None:
        index = len(self.joints)
        self.joints.append(name)
        self.parents.append(body)
        self.children.append(child)
        before = self.last[body] if body >= 0 else -1
        motions = _motions(joint.type, joint.axis, joint.axis_2)
        if name in self._cardan:
            motions = [turn for motion in motions for turn in _turns_for_ball(motion)]
        if not motions:
            self.fixed_placement[index] = placement
        else:
            column, rate = self._columns[name].start, self._rates[name].start
            for kind, axis in motions:
                motion = ElementaryMotion(kind, index, axis, before, placement, column, rate)
                self.motions.append(motion)
                before, placement = len(self.motions) - 1, _IDENTITY
                column += 4 if kind == "ball" else 1
                rate += motion.size
        self.last.append(before)

    def _bodies(self, description: Description) -> list[RigidBody]:
        described = {link.name: link for link in description.links}
        links_of: list[dict[str, Array]] = [{} for _ in range(self.tree)]
        for link, (body, placement) in self.links.items():
            if body >= 0:
                links_of[body][link] = placement
        return [merged(described, links) for links in links_of]

    def _corner(self) -> Array:
        """Return the middle of all joints that hang from the world."""
        points = [motion.placement[:3, 3] for motion in self.motions if motion.before < 0]
        points += [
            end[:3, 3]
            for end, child in zip(self.ends, self.children[self.tree :], strict=True)
            if child < 0
        ]
        return np.mean(points, axis=0) if points else np.zeros(3)

    def path(self, body: int) -> list[int]:
        """Return the tree joints from the root to a body."""
        path = []
        while body >= 0:
            path.append(body)
            body = self.parents[body]
        return path[::-1]

    def placed(self, x: Array, path: Iterable[int] | None = None) -> Array:
        """Return the frames of all motions at rows `x (N, size)`, `(M, 4, 3, N)`.

        Of a frame, the first three entries are its axes, the last one its origin about `corner`,
        in world axes.

        Args:
            x: the rows.
            path: indices of the motions that count, see `motions_to`; all of them if None. What is
                not written takes no memory.
        """
        frames = np.empty((len(self.motions), 4, 3, len(x)))
        for index in range(len(self.motions)) if path is None else path:
            motion = self.motions[index]
            start, frame = self.fixed_in(frames, motion.before, motion.placement), frames[index]
            frame[:] = start
            if motion.kind == "slide":
                frame[3] += np.einsum("i,ikn->kn", motion.axis, start[:3]) * x[:, motion.column]
            else:
                frame[:3] = _turned(start[:3], motion, x)
        return frames

    def fixed_in(self, frames: Array, motion: int, placement: Array) -> Array:
        """Return a frame that is fixed in that of a motion, `(4, 3, N)`, or `(4, 3, 1)`.

        Args:
            frames: see `placed`.
            motion: index of the motion, -1 for the world.
            placement: `(4, 4)` in its frame.
        """
        if motion < 0:
            columns = placement[:3].T.copy()
            columns[3] -= self.corner
            return np.asarray(columns[:, :, None])
        frame = frames[motion]
        if placement is _IDENTITY:
            return np.asarray(frame)
        return np.asarray((placement.T @ frame.reshape(4, -1)).reshape(frame.shape))

    def joint(self, x: Array, index: int) -> tuple[Array, Array]:
        """Return rotations `(N, 3, 3)` and origins `(N, 3)` of a joint's frame in the world.

        Args:
            x: `(N, size)` coordinates.
            index: of the joint.
        """
        frame = self._of_joint(self.placed(x, self.motions_to(self.last[index])), index)
        frame = np.broadcast_to(frame, (4, 3, len(x)))
        return np.ascontiguousarray(frame[:3].transpose(2, 1, 0)), frame[3].T + self.corner

    def _of_joint(self, frames: Array, index: int) -> Array:
        """Return the frame of a joint, see `fixed_in`."""
        placement = self.fixed_placement.get(index, _IDENTITY)
        return self.fixed_in(frames, self.last[index], placement)

    def motions_to(self, last: int) -> list[int]:
        """Return the motions from the world to one of them, whose index is last; none for -1."""
        path = []
        while last >= 0:
            path.append(last)
            last = self.motions[last].before
        return path[::-1]

    def turned(self, x: Array, index: int) -> Array:
        """Return rotations `(N, 3, 3)` from a joint's frame to where it is at coordinate zero.

        Args:
            x: `(N, size)` coordinates.
            index: of the joint.
        """
        axes = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, len(x)))
        for motion in self.motions:
            if motion.joint == index and motion.kind != "slide":
                axes = _turned(axes, motion, x)
        return np.ascontiguousarray(axes.transpose(2, 1, 0))

    def ended(self, frames: Array, loop: int) -> Array:
        """Return the frame of a loop's successor where the loop joins it, see `fixed_in`."""
        body = self.children[self.tree + loop]
        return self.fixed_in(frames, self.last[body] if body >= 0 else -1, self.ends[loop])

    def joint_frames(self, frames: Array) -> Array:
        """Return the frames of all joints `(J, 4, 3, N)`."""
        result = np.empty((len(self.joints), *frames.shape[1:]))
        for index, frame in enumerate(result):
            frame[:] = self._of_joint(frames, index)
        return result


def _motions(kind: str, axis: Array, axis_2: Array) -> list[tuple[str, Array]]:
    """Return the elementary motions of a joint type, in the order of its coordinates."""
    x, y, z = np.eye(3)
    if kind == "fixed":
        return []
    if kind in ("revolute", "continuous"):
        return [("turn", axis)]
    if kind == "prismatic":
        return [("slide", axis)]
    if kind == "cylindrical":
        return [("slide", axis), ("turn", axis)]
    if kind == "universal":
        return [("turn", axis), ("turn", axis_2)]
    if kind == "spherical":
        return [("ball", axis)]
    if kind == "floating":
        return [("slide", x), ("slide", y), ("slide", z), ("ball", x)]
    # A planar joint slides along its axis crossed with the frame axis that is farthest from it,
    # then along what completes a right-handed set, and turns about its axis; a loose one tilts
    # about both directions before it turns.
    sides = [x, y, z]
    first = np.cross(axis, sides[int(np.argmin(np.abs(axis)))])
    first = first / np.sqrt(first @ first)
    second = np.cross(axis, first)
    tilts = [("turn", first), ("turn", second)] if kind == "loose" else []
    return [("slide", first), ("slide", second), *tilts, ("turn", axis)]


def _turns_for_ball(motion: tuple[str, Array]) -> list[tuple[str, Array]]:
    """Return the turns by Cardan angles that a ball is written as; other motions as they are."""
    kind, _ = motion
    return [("turn", axis) for axis in np.eye(3)] if kind == "ball" else [motion]


def merged(described: dict[str, LinkDescription], placements: dict[str, Array]) -> RigidBody:
    """Return links, placed in the frame of their body, as one body.

    Args:
        described: all links by name.
        placements: links of the body and their `(4, 4)` placements.
    """
    links = [
        (described[name], placement)
        for name, placement in placements.items()
        if not described[name].is_massless
    ]
    mass = float(sum(link.mass for link, _ in links))
    points = [placement[:3, :3] @ link.centre + placement[:3, 3] for link, placement in links]
    centre = np.zeros(3)
    for (link, _), point in zip(links, points, strict=True):
        if link.mass:
            centre = centre + link.mass / mass * point
    inertia = np.zeros((3, 3))
    for (link, placement), point in zip(links, points, strict=True):
        arm = point - centre
        rotated = placement[:3, :3] @ link.inertia @ placement[:3, :3].T
        inertia += rotated + link.mass * (arm @ arm * np.eye(3) - np.multiply.outer(arm, arm))
    return RigidBody(mass, centre, inertia)


def _turned(axes: Array, motion: ElementaryMotion, x: Array) -> Array:
    """Return axes `(3, 3, N)` after a turn or ball at rows `x (N, size)`, from those before it."""
    if motion.kind == "ball":
        turn = rotations(x[:, motion.column : motion.column + 4].T)
    else:
        along = np.multiply.outer(motion.axis, motion.axis)
        # Rodrigues: R = n nᵀ + (1 - n nᵀ) cos φ + n × sin φ; exact about an axis of the frame.
        across, crossed = np.eye(3) - along, cross(np.eye(3), motion.axis[:, None]).T
        angle = x[:, motion.column]
        turn = along[..., None] + np.multiply.outer(across, np.cos(angle))
        turn += np.multiply.outer(crossed, np.sin(angle))
    return np.einsum("ijn,ikn->jkn", turn, axes)


def rotations(q: Array) -> Array:
    """Return the rotations `(3, 3, N)` of unit quaternions `(4, N)`, x, y, z, w."""
    x, y, z, w = q
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
