"""Frames: where every joint and body of a description is, by plain forward kinematics.

Nothing here uses Pinocchio, groups, or the solution of a mechanism, so that the proof of a result
can rely on it: joint coordinates go in, placements in world axes come out, joint after joint from
the root.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array

if TYPE_CHECKING:
    from ..description.description import (
        Description,
        JointDescription,
        LinkDescription,
        LoopDescription,
    )
    from .coordinates import Coordinates

_IDENTITY = np.eye(4)


class Body(NamedTuple):
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
        self.tree = len(self.joints)
        self.ends = [self._add_loop(loop) for loop in description.loops]
        self.bodies = self._bodies(description)
        self.corner = self._corner()

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
        joint: JointDescription | LoopDescription,
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
                before, placement = len(self.motions) - 1, np.eye(4)
                column += 4 if kind == "ball" else 1
                rate += motion.size
        self.last.append(before)

    def _bodies(self, description: Description) -> list[Body]:
        """Return the moving bodies, each from its links."""
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

    def placed(self, x: Array) -> Array:
        """Return the frames of all motions at rows `x (N, size)`, `(M, 4, 3, N)`.

        Of a frame, the first three entries are its axes, the last one its origin about `corner`,
        in world axes.
        """
        result = np.empty((len(self.motions), 4, 3, len(x)))
        turning = [index for index, motion in enumerate(self.motions) if motion.kind == "turn"]
        angles = np.ascontiguousarray(x[:, [self.motions[index].column for index in turning]].T)
        turns = dict(zip(turning, zip(np.cos(angles), np.sin(angles), strict=True), strict=True))
        for index in range(len(self.motions)):
            self._place(result, index, x, turns.get(index))
        return result

    def joint(self, x: Array, index: int) -> tuple[Array, Array]:
        """Return rotations `(N, 3, 3)` and origins `(N, 3)` of a joint's frame in the world.

        Args:
            x: `(N, size)` coordinates.
            index: of the joint.
        """
        last = self.last[index]
        path = [last] if last >= 0 else []
        while path and self.motions[path[-1]].before >= 0:
            path.append(self.motions[path[-1]].before)
        frames: dict[int, Array] = {}
        for motion in reversed(path):
            angle = x[:, self.motions[motion].column]
            frames[motion] = np.empty((4, 3, len(x)))
            self._place(frames, motion, x, (np.cos(angle), np.sin(angle)))
        frame = self._moved(frames, last, self.fixed_placement.get(index, _IDENTITY), len(x))
        origin = frame[3].T + self.corner
        return np.ascontiguousarray(frame[:3].transpose(2, 1, 0)), origin

    def _place(
        self,
        frames: Array | dict[int, Array],
        index: int,
        x: Array,
        turn: tuple[Array, Array] | None,
    ) -> None:
        """Write the frame of a motion into `frames`, which spares a copy of it.

        Args:
            frames: those of the motions before it are known.
            index: of the motion.
            x: `(N, size)` coordinates.
            turn: cosines and sines of a turn's angle.
        """
        motion, frame = self.motions[index], frames[index]
        start = self._moved(frames, motion.before, motion.placement, len(x))
        if motion.kind == "turn" and turn is not None:
            _turn(frame, start, motion.axis, *turn)
        elif motion.kind == "ball":
            frame[3] = start[3]
            q = np.ascontiguousarray(x[:, motion.column : motion.column + 4].T)
            frame[:3] = np.einsum("ijn,ikn->jkn", _rotation(q), start[:3])
        else:
            frame[:3] = start[:3]
            direction = motion.axis @ start[:3].reshape(3, -1)
            frame[3] = start[3] + direction.reshape(3, -1) * x[:, motion.column]

    def ended(self, frames: Array, loop: int) -> Array:
        """Return the frame of a loop's successor where the loop joins it, `(4, 3, N)`."""
        body = self.children[self.tree + loop]
        motion = self.last[body] if body >= 0 else -1
        return self._moved(frames, motion, self.ends[loop], frames.shape[-1])

    def joint_frames(self, frames: Array) -> Array:
        """Return the frames of all joints `(J, 4, 3, N)`."""
        if not self.fixed_placement and self.last == list(range(len(frames))):
            return frames
        result = np.empty((len(self.joints), *frames.shape[1:]))
        for index, last in enumerate(self.last):
            if index in self.fixed_placement:
                placement = self.fixed_placement[index]
                result[index] = self._moved(frames, last, placement, frames.shape[-1])
            else:
                result[index] = frames[last]
        return result

    def _moved(
        self, frames: Array | dict[int, Array], motion: int, placement: Array, count: int
    ) -> Array:
        """Return a placement in the frame of a motion as a frame in the world, `(4, 3, N)`.

        Args:
            frames: of the motions.
            motion: index of the motion, -1 for the world.
            placement: `(4, 4)`.
            count: number of samples N.
        """
        if motion < 0:
            columns = placement[:3].T.copy()
            columns[3] -= self.corner
            return np.repeat(columns[:, :, None], count, axis=2)
        frame = frames[motion]
        if np.array_equal(placement, _IDENTITY):
            return frame
        return np.asarray((placement.T @ frame.reshape(4, -1)).reshape(frame.shape))


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
    # then along what completes a right-handed set, and turns about its axis.
    sides = [x, y, z]
    first = np.cross(axis, sides[int(np.argmin(np.abs(axis)))])
    first = first / np.sqrt(first @ first)
    return [("slide", first), ("slide", np.cross(axis, first)), ("turn", axis)]


def _turns_for_ball(motion: tuple[str, Array]) -> list[tuple[str, Array]]:
    """Return the turns by Cardan angles that a ball is written as; other motions as they are."""
    kind, _ = motion
    return [("turn", axis) for axis in np.eye(3)] if kind == "ball" else [motion]


def _turn(frame: Array, start: Array, axis: Array, cosine: Array, sine: Array) -> None:
    """Write into `frame` what a frame `start` is after a turn about an axis of its own.

    Args:
        frame: `(4, 3, N)` the result.
        start: `(4, 3, N)`.
        axis: `(3,)` unit vector in that frame.
        cosine: `(N,)` of the angle.
        sine: `(N,)` of the angle.
    """
    along = int(np.argmax(np.abs(axis)))
    second, third = (along + 1) % 3, (along + 2) % 3
    frame[3] = start[3]
    if axis[second] == 0.0 and axis[third] == 0.0:
        sine = sine * axis[along]
        frame[along] = start[along]
        frame[second] = cosine * start[second] + sine * start[third]
        frame[third] = cosine * start[third] - sine * start[second]
        return
    # Rodrigues: R = 1 + sin K + (1 - cos) K², applied to the three axes of the frame.
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    axes = start[:3].reshape(3, -1)
    linear = (cross.T @ axes).reshape(3, 3, -1)
    quadratic = ((cross @ cross).T @ axes).reshape(3, 3, -1)
    # 1 - cos, without cancellation for small angles.
    versine = np.where(cosine > 0.0, sine**2 / (1.0 + np.abs(cosine)), 1.0 - cosine)
    frame[:3] = start[:3] + sine * linear + versine * quadratic


def _rotation(q: Array) -> Array:
    """Return the rotations `(3, 3, N)` of unit quaternions `(4, N)`, x, y, z, w."""
    x, y, z, w = q
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def merged(described: dict[str, LinkDescription], placements: dict[str, Array]) -> Body:
    """Return links, placed in the frame of their body, as one body.

    Args:
        described: all links by name.
        placements: links of the body and their `(4, 4)` placements.
    """
    links = [
        (described[name], placement)
        for name, placement in placements.items()
        if described[name].mass
    ]
    mass = float(sum(link.mass for link, _ in links))
    points = [placement[:3, :3] @ link.centre + placement[:3, 3] for link, placement in links]
    centre = np.zeros(3)
    for (link, _), point in zip(links, points, strict=True):
        centre = centre + link.mass / mass * point
    inertia = np.zeros((3, 3))
    for (link, placement), point in zip(links, points, strict=True):
        arm = point - centre
        rotated = placement[:3, :3] @ link.inertia @ placement[:3, :3].T
        inertia += rotated + link.mass * (arm @ arm * np.eye(3) - np.multiply.outer(arm, arm))
    return Body(mass, centre, inertia)
