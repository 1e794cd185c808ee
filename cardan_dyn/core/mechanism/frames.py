"""Frames: where every joint and body of a description is, by plain forward kinematics.

Nothing here uses Pinocchio, groups, or the solution of a mechanism, so that the proof of a result
can rely on it: joint coordinates go in, placements in world axes come out, joint after joint from
the root.

Frames are `(4, 3, N)`: three axes and an origin in world axes. Which entries of a placement are
zero and about which axes joints turn is found once, so that few samples are placed in few steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array

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
_FIRST, _SECOND = np.array([[5, 1, 2, 1, 0, 6, 2, 6, 0], [10, 11, 7, 11, 10, 3, 7, 3, 5]])
"""The two products of components (x, y, z, w) of a unit quaternion, 4 i + j, that an entry of its
rotation is a sum of, row by row: y y + z z, x y - z w, x z + y w, and so on."""
_SECOND_SIGNS = np.array([1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0])
_TWICE = np.array([-2.0, 2.0, 2.0, 2.0, -2.0, 2.0, 2.0, 2.0, -2.0])
"""Their signs in it, and the factor on the sum, to which one is added on the diagonal."""


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
        loop_ends: the same as offsets.
        motions: elementary motions of all joints, those of a joint in a row.
        starts: per motion, the offset of its frame where its coordinate is zero.
        last: per joint, the index of its last motion, whose frame is the joint's; where it has
            none (a `fixed` loop), of the one that moves its predecessor.
        fixed_placement: per joint without motion, its `(4, 4)` placement in that frame.
        fixed: the same as offsets.
        alike: the motions in sets that are placed together, in an order in which each comes after
            those that carry it.
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
        self._described = description
        self.tree = len(self.joints)
        self.ends = [self._add_loop(loop) for loop in description.loops]
        self.bodies = self._bodies(description)
        self.corner = self._corner()
        self._lay_out()

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

    def _lay_out(self) -> None:
        """Find what placing the frames needs and no position changes."""
        self.starts = [self._offset(motion.before, motion.placement) for motion in self.motions]
        self.alike = [Alike.of(places, self.motions, self.starts) for places in self._places()]
        self.fixed = {
            joint: self._offset(self.last[joint], placement)
            for joint, placement in self.fixed_placement.items()
        }
        bodies = self.children[self.tree :]
        lasts = [self.last[body] if body >= 0 else -1 for body in bodies]
        self.loop_ends = list(map(self._offset, lasts, self.ends))
        self._are_motions = not self.fixed and self.last == list(range(len(self.motions)))
        # Sines and cosines of all turns are computed at once; per set, which of them are its own.
        columns: list[int] = []
        signs: list[Array] = []
        self._own_turns: list[slice | None] = []
        for alike in self.alike:
            if alike.turn is None:
                self._own_turns.append(None)
                continue
            self._own_turns.append(slice(len(columns), len(columns) + len(alike.columns)))
            columns += alike.columns.tolist()
            signs += [alike.turn.signs] * len(alike.columns)
        self._turned = np.array(columns, dtype=int)
        self._turn_signs = np.array(signs).reshape(-1, 2, 1, 1)

    def _places(self) -> list[list[int]]:
        """Return the motions (index) that are placed together, those after which others come first.

        They are alike on several legs of a robot: as far from the world, in equal steps.
        """
        depth: list[int] = []
        kinds: dict[tuple[object, ...], list[int]] = {}
        for index, (motion, start) in enumerate(zip(self.motions, self.starts, strict=True)):
            depth.append(depth[motion.before] + 1 if motion.before >= 0 else 0)
            axis = tuple(motion.axis.tolist()) if motion.kind == "turn" else ()
            key = motion.kind, axis, motion.before < 0, start.transposed is None
            kinds.setdefault((depth[-1], *key), []).append(index)
        places: list[list[int]] = []
        for found in kinds.values():
            places.append([])
            for index in found:
                longer = [*places[-1], index]
                before = [self.motions[k].before for k in longer]
                if stepped(longer) is None or (before[0] >= 0 and stepped(before) is None):
                    places.append([index])
                else:
                    places[-1] = longer
        places.sort(key=lambda indices: depth[indices[0]])
        return places

    def _offset(self, motion: int, placement: Array) -> Offset:
        """Return a `(4, 4)` placement in the frame of a motion, -1 for the world."""
        return Offset.of(motion, placement, self.corner)

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
                before, placement = len(self.motions) - 1, np.eye(4)
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

    def placed(self, x: Array) -> Array:
        """Return the frames of all motions at rows `x (N, size)`, `(M, 4, 3, N)`.

        Of a frame, the first three entries are its axes, the last one its origin about `corner`,
        in world axes.
        """
        result = np.empty((len(self.motions), 4, 3, len(x)))
        angles = x.T.take(self._turned, 0)[:, None, None]
        cosines, sines = np.cos(angles), np.sin(angles) * self._turn_signs
        for alike, own in zip(self.alike, self._own_turns, strict=True):
            if own is None:
                alike.place(result, x)
            else:
                alike.place_turned(result, cosines[own], sines[own])
        return result

    def joint(self, x: Array, index: int) -> tuple[Array, Array]:
        """Return rotations `(N, 3, 3)` and origins `(N, 3)` of a joint's frame in the world.

        Args:
            x: `(N, size)` coordinates.
            index: of the joint.
        """
        last = self.last[index]
        frames = self.placed_along(x, self.motions_to(last))
        offset = self._offset(last, self.fixed_placement.get(index, _IDENTITY))
        frame = np.broadcast_to(offset.frame(frames), (4, 3, len(x)))
        origin = frame[3].T + self.corner
        return np.ascontiguousarray(frame[:3].transpose(2, 1, 0)), origin

    def motions_to(self, last: int) -> list[int]:
        """Return the motions from the world to one of them, whose index is last; none for -1."""
        path = []
        while last >= 0:
            path.append(last)
            last = self.motions[last].before
        return path[::-1]

    def placed_along(self, x: Array, path: list[int]) -> Array:
        """Return the frames of all motions at rows `x (N, size)`, of which those of a path count.

        See `placed`. What is not written takes no memory.
        """
        frames = np.empty((len(self.motions), 4, 3, len(x)))
        for motion in path:
            Alike.of([motion], self.motions, self.starts).place(frames, x)
        return frames

    def turned(self, x: Array, index: int) -> Array:
        """Return rotations `(N, 3, 3)` from a joint's frame to where it is at coordinate zero.

        Args:
            x: `(N, size)` coordinates.
            index: of the joint.
        """
        frame = np.broadcast_to(np.eye(4, 3)[:, :, None], (4, 3, len(x)))
        for motion in self.motions:
            if motion.joint != index or motion.kind == "slide":
                continue
            start, frame = frame, np.empty((4, 3, len(x)))
            if motion.kind == "turn":
                angle = x[:, motion.column]
                Turn(motion.axis).write(frame, start, np.cos(angle), np.sin(angle))
            else:
                q = np.ascontiguousarray(x[:, motion.column : motion.column + 4].T)
                frame[:3] = np.einsum("ijn,ikn->jkn", rotations(q), start[:3])
        return np.ascontiguousarray(frame[:3].transpose(2, 1, 0))

    def ended(self, frames: Array, loop: int) -> Array:
        """Return the frame of a loop's successor where the loop joins it.

        It is `(4, 3, N)`, or `(4, 3, 1)` in the world.
        """
        return self.loop_ends[loop].frame(frames)

    def joint_frames(self, frames: Array) -> Array:
        """Return the frames of all joints `(J, 4, 3, N)`."""
        if self._are_motions:
            return frames
        result = np.empty((len(self.joints), *frames.shape[1:]))
        for index, last in enumerate(self.last):
            result[index] = self.fixed[index].frame(frames) if index in self.fixed else frames[last]
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


class Offset(NamedTuple):
    """A constant placement in the frame of a motion, or in the world.

    Attributes:
        before: index of the motion, -1 for the world.
        transposed: `(4, 4)` transposed placement in the motion's frame; None if it is that frame.
        in_world: `(4, 3, 1)` the frame itself where it is placed in the world, else None.
    """

    before: int
    transposed: Array | None
    in_world: Array | None

    @staticmethod
    def of(before: int, placement: Array, corner: Array) -> Offset:
        """Return the offset of a placement.

        Args:
            before: see the attribute.
            placement: `(4, 4)`.
            corner: `(3,)` the point of the world that origins are counted from.
        """
        if before < 0:
            columns = placement[:3].T.copy()
            columns[3] -= corner
            return Offset(before, None, columns[:, :, None])
        same = np.array_equal(placement, _IDENTITY)
        return Offset(before, None if same else np.ascontiguousarray(placement.T), None)

    def frame(self, frames: Array | Mapping[int, Array]) -> Array:
        """Return the frame, `(4, 3, N)`, or `(4, 3, 1)` in the world.

        Args:
            frames: of the motions.
        """
        if self.in_world is not None:
            return self.in_world
        frame = frames[self.before]
        if self.transposed is None:
            return frame
        return np.asarray(np.matmul(self.transposed, frame.reshape(4, -1)).reshape(frame.shape))


class Offsets(NamedTuple):
    """The k offsets of several frames, of which either all are in the world or none is.

    Attributes:
        before: indices of the motions, as a slice if they are in equal steps; None for the world.
        placed: their transposed placements `(k, 4, 4)`, None if they are the motions' frames; in
            the world, the frames themselves `(k, 4, 3, 1)`.
    """

    before: slice | Array | None
    placed: Array | None

    @staticmethod
    def of(offsets: Sequence[Offset]) -> Offsets:
        """Return some offsets as one."""
        if offsets[0].in_world is not None:
            return Offsets(None, np.array([offset.in_world for offset in offsets]))
        before = [offset.before for offset in offsets]
        given = [offset.transposed for offset in offsets]
        placed = None
        if any(matrix is not None for matrix in given):
            placed = np.array([_IDENTITY if matrix is None else matrix for matrix in given])
        return Offsets(in_steps(before), placed)

    def frames(self, frames: Array) -> Array:
        """Return the frames `(k, 4, 3, N)`, or `(k, 4, 3, 1)` in the world; see `Offset.frame`."""
        if self.before is None:
            return self.placed  # type: ignore[return-value]
        before = frames[self.before]
        if self.placed is None:
            return before
        return np.matmul(self.placed, before.reshape(len(before), 4, -1)).reshape(before.shape)


_ACROSS = (
    (slice(1, 3), slice(2, 0, -1)),
    (slice(2, None, -2), slice(0, 3, 2)),
    (slice(0, 2), slice(1, None, -1)),
)
"""Rows y and z, z and x, x and y of a frame, and the same the other way round."""


class Turn:
    """A turn about an axis of the frame before it.

    Attributes:
        signs: `(2, 1, 1)` with which the sine counts for the two axes across that of the turn.
    """

    def __init__(self, axis: Array) -> None:
        """Keep what the axis `(3,)`, a unit vector in that frame, decides."""
        along = int(np.argmax(np.abs(axis)))
        self._is_along = np.count_nonzero(axis) == 1
        # The two axes after the one of the turn, in cyclic order, and in the opposite one.
        self._across: slice = _ACROSS[along][0]
        self._back: slice = _ACROSS[along][1]
        self.signs = np.array([[[1.0]], [[-1.0]]]) * float(axis[along])
        if not self._is_along:
            self.signs = np.ones((2, 1, 1))
        x, y, z = axis
        self._linear = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        self._quadratic = np.ascontiguousarray(self._linear @ self._linear)

    def write(self, frame: Array, start: Array, cosine: Array, sine: Array) -> None:
        """Write into `frame` what a frame `start` is after the turn.

        Args:
            frame: `(…, 4, 3, N)` the result.
            start: `(…, 4, 3, N)` or `(…, 4, 3, 1)`.
            cosine: of the angle, `(N,)` or `(…, 1, 1, N)`.
            sine: of the angle, likewise.
        """
        self.write_signed(frame, start, cosine, sine * self.signs)

    def write_signed(self, frame: Array, start: Array, cosine: Array, sines: Array) -> None:
        """See `write`; with sines `(…, 2, 1, N)` that are multiplied with `signs` already."""
        if self._is_along:
            frame[:] = start
            across = frame[..., self._across, :, :]
            across *= cosine
            across += start[..., self._back, :, :] * sines
            return
        sine = sines[..., :1, :, :]
        frame[..., 3, :, :] = start[..., 3, :, :]
        # Rodrigues: R = 1 + sin K + (1 - cos) K², applied to the three axes of the frame.
        axes = start[..., :3, :, :]
        flat = axes.reshape(*axes.shape[:-2], -1)
        linear = (self._linear @ flat).reshape(axes.shape)
        quadratic = (self._quadratic @ flat).reshape(axes.shape)
        # 1 - cos, without cancellation for small angles.
        versine = np.where(cosine > 0.0, sine**2 / (1.0 + np.abs(cosine)), 1.0 - cosine)
        frame[..., :3, :, :] = axes + sine * linear + versine * quadratic


class Alike:
    """Elementary motions of one kind that are placed together, k in all.

    Attributes:
        own: their indices; steps from one to the next are equal.
        before: likewise, of the motions that move their frames; None for the world.
        turn: what turns about their axis are; None of slides and balls.
        columns: `(k,)` their columns in coordinate rows; of balls `(4, k)`.
    """

    def __init__(
        self,
        own: slice,
        before: slice | None,
        motions: list[ElementaryMotion],
        starts: list[Offset],
    ) -> None:
        """Keep what their axes and columns decide; attributes as of the class."""
        self.own, self.before = own, before
        self._is_ball = motions[0].kind == "ball"
        self.turn = Turn(motions[0].axis) if motions[0].kind == "turn" else None
        self._axes = np.array([motion.axis for motion in motions])[:, None]
        columns = np.array([motion.column for motion in motions])
        self.columns = columns + np.arange(4)[:, None] if self._is_ball else columns
        self._start = Offsets.of(starts)

    @staticmethod
    def of(indices: list[int], motions: list[ElementaryMotion], starts: list[Offset]) -> Alike:
        """Return some motions, given by their indices, with the offsets of all motions' frames."""
        chosen, offsets = [motions[k] for k in indices], [starts[k] for k in indices]
        own, before = stepped(indices), stepped([motion.before for motion in chosen])
        assert own is not None
        is_on_ground = chosen[0].before < 0
        return Alike(own, None if is_on_ground else before, chosen, offsets)

    def place(self, frames: Array, x: Array) -> None:
        """Write their frames into `(M, 4, 3, N)`, in which those before them are.

        Args:
            frames: of all motions.
            x: `(N, size)` coordinates.
        """
        moved = x.T.take(self.columns, 0)
        if self.turn is not None:
            angles = moved[:, None, None]
            self.place_turned(frames, np.cos(angles), np.sin(angles) * self.turn.signs)
            return
        frame, start = frames[self.own], self._start.frames(frames)
        if self._is_ball:
            frame[:, 3] = start[:, 3]
            np.einsum("ijbn,bikn->bjkn", rotations(moved), start[:, :3], out=frame[:, :3])
        else:
            frame[:, :3] = start[:, :3]
            axes = start[:, :3].reshape(len(start), 3, -1)
            direction = np.matmul(self._axes, axes).reshape(len(start), 3, -1)
            frame[:, 3] = start[:, 3] + direction * moved[:, None]

    def place_turned(self, frames: Array, cosines: Array, sines: Array) -> None:
        """Write the frames of turns, see `place` and `Turn.write_signed`.

        Args:
            frames: of all motions.
            cosines: of their angles, `(k, 1, 1, N)`.
            sines: of their angles, with signs, `(k, 2, 1, N)`.
        """
        assert self.turn is not None
        start = self._start.frames(frames)
        self.turn.write_signed(frames[self.own], start, cosines, sines)


def stepped(indices: list[int]) -> slice | None:
    """Return indices from 0 on, ascending in equal steps, as a slice; None if they are not."""
    step = indices[1] - indices[0] if len(indices) > 1 else 1
    span = range(indices[0], indices[-1] + 1, step) if step > 0 else range(0)
    return slice(span.start, span.stop, step) if list(span) == indices else None


def in_steps(indices: list[int]) -> slice | Array:
    """Return indices as a slice if they are in equal steps, since slices make no copies."""
    span = stepped(indices)
    return np.array(indices) if span is None else span


def rotations(q: Array) -> Array:
    """Return the rotations `(3, 3, …)` of unit quaternions `(4, …)`, x, y, z, w."""
    more = [1] * (q.ndim - 1)
    products = (q[:, None] * q).reshape(16, *q.shape[1:])
    sums = products.take(_FIRST, 0)
    sums += products.take(_SECOND, 0) * _SECOND_SIGNS.reshape(9, *more)
    sums *= _TWICE.reshape(9, *more)
    sums[::4] += 1.0
    return np.asarray(sums.reshape(3, 3, *q.shape[1:]))
