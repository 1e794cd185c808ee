"""Tasks: what of a mechanism moves as given other than its coordinates, and how it is followed.

A task is followed by massless slides and turns from the world, or from another link, that are
driven, and closed onto the link which it names: the mechanism with them is an ordinary one, whose
loops decide the actuated joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce
from typing import NamedTuple, TypeAlias

import numpy as np
import pinocchio

from ..core.description.description import (
    IDENTITY,
    JointDescription,
    LinkDescription,
    LoopDescription,
)
from ..core.description.elements import unique
from ..core.mechanics.vectors import about, dot, product, times
from ..core.mechanism.configuration import Configuration
from ..core.mechanism.mechanism import Mechanism
from ..core.results.prescribed import MotionResult
from ..core.tape import Program, Trace, absolute, arctan2, cos, greater, select, sin, sqrt
from ..kit.arrays import EPS, ROUNDED, Array, cardan_quaternion, inverse
from ..kit.checks import text, vector
from ..kit.errors import ArgumentError, ModelError, choices
from ..kit.frozen import Record

_AXES, _ORIGIN, _UNTURNED = "xyz", (0.0, 0.0, 0.0), np.eye(3)


@dataclass(frozen=True, eq=False)
class PointTask(Record):
    """A point of a link moves as given, in world axes; the link may turn about it.

    Its rows are the point's coordinates [m], in the order of `axes`. They are called `link.x` and
    so on, `link.x_2` where there is one already.

    Attributes:
        link: name of a link; or else of a `fixed` joint, of a site of MJCF or a frame of SDF,
            which move with their link.
        point: `(3,)` from the origin of that, in its axes [m].
        axes: which coordinates are given: up to three of `x`, `y`, `z`.

    Raises:
        ArgumentError: the point is no `(3,)` of finite numbers, or there are no such axes.
    """

    link: str
    point: Sequence[float] | Array = _ORIGIN
    axes: str = _AXES

    def __post_init__(self) -> None:
        object.__setattr__(self, "link", text("PointTask: link", self.link))
        object.__setattr__(self, "point", vector("PointTask: point", self.point, 3))
        object.__setattr__(self, "axes", _axes("PointTask: axes", self.axes))
        super().__post_init__()


@dataclass(frozen=True, eq=False)
class PoseTask(Record):
    """A link moves and turns as given, in world axes.

    Its six rows are the position of the link's origin [m], and the rotation vector [rad] by which
    the world's axes are turned into the link's: the axis of that turn times its angle, which is the
    logarithm of the rotation. Speeds of the latter are the angular velocity in world axes [rad/s],
    not the rates of the rotation vector; accelerations are the angular acceleration.

    Attributes:
        link: see `PointTask`.

    Raises:
        ArgumentError: the name is no text.
    """

    link: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "link", text("PoseTask: link", self.link))


@dataclass(frozen=True, eq=False)
class AngleTask(Record):
    """A link that moves in a plane turns as given.

    Its row is the angle [rad] by which the link has turned about a world axis since the zero of the
    description, without whole turns.

    Attributes:
        link: see `PointTask`.
        axis: `x`, `y` or `z`, at right angles to the plane.

    Raises:
        ArgumentError: there is no such axis.
    """

    link: str
    axis: str = "z"

    def __post_init__(self) -> None:
        object.__setattr__(self, "link", text("AngleTask: link", self.link))
        object.__setattr__(self, "axis", _axis("AngleTask: axis", self.axis))


@dataclass(frozen=True, eq=False)
class DirectionTask(Record):
    """A direction of a link points as given; the link may turn about it.

    Its two rows are angles [rad] of a universal joint that carries the direction, and lies along an
    axis of the world, or of another link, at zero: about the axis that follows that one in the
    order x, y, z, x, y, and about the one after it, which the first carries. Of `along="z"`, a
    direction (sin b, -sin a cos b, cos a cos b) has the rows a and b, called `link.turn_x` and
    `link.turn_y`. Where b is a right angle, a says nothing: take an axis nearer to the direction.

    Attributes:
        link: see `PointTask`.
        direction: `(3,)` in its axes, of any length.
        along: `x`, `y` or `z`, the axis along which the direction lies at zero.
        other: name of the link whose axes count; the world's if empty.

    Raises:
        ArgumentError: the direction is no `(3,)` of finite numbers or zero, or there is no such
            axis.
    """

    link: str
    direction: Sequence[float] | Array
    along: str = "z"
    other: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "link", text("DirectionTask: link", self.link))
        direction = vector("DirectionTask: direction", self.direction, 3)
        if not (length := np.linalg.norm(direction)):
            raise ArgumentError("DirectionTask: direction is zero, which points nowhere")
        object.__setattr__(self, "direction", direction / length)
        object.__setattr__(self, "along", _axis("DirectionTask: along", self.along))
        object.__setattr__(self, "other", text("DirectionTask: other", self.other))
        super().__post_init__()


@dataclass(frozen=True, eq=False)
class DistanceTask(Record):
    """A point of a link is as far from a point of another as given.

    Its row is the distance [m], called `link.distance`. It is positive.

    Attributes:
        link: see `PointTask`.
        other: name of the other link, or of one that is fixed to the world.
        point: `(3,)` of the link, see `PointTask`.
        other_point: likewise of the other.

    Raises:
        ArgumentError: a point is no `(3,)` of finite numbers.
    """

    link: str
    other: str
    point: Sequence[float] | Array = _ORIGIN
    other_point: Sequence[float] | Array = _ORIGIN

    def __post_init__(self) -> None:
        for name in ("link", "other"):
            object.__setattr__(self, name, text(f"DistanceTask: {name}", getattr(self, name)))
        for name in ("point", "other_point"):
            value = vector(f"DistanceTask: {name}", getattr(self, name), 3)
            object.__setattr__(self, name, value)
        super().__post_init__()


_OnLink: TypeAlias = PointTask | PoseTask | AngleTask | DirectionTask | DistanceTask
Task: TypeAlias = _OnLink | str
KINDS = PointTask, PoseTask, AngleTask, DirectionTask, DistanceTask


def _axes(label: str, given: object) -> str:
    """Return axes, each of them once."""
    axes = text(label, given)
    if not axes or set(axes) - set(_AXES) or len(set(axes)) < len(axes):
        raise ArgumentError(f"{label} is {axes!r}, expected up to three of x, y, z")
    return axes


def _axis(label: str, given: object) -> str:
    """Return an axis."""
    axis = text(label, given)
    if axis not in tuple(_AXES):
        raise ArgumentError(f"{label} is {axis!r}, expected x, y or z")
    return axis


class Block(NamedTuple):
    """Drives that follow a task, of which `k` are given and others rest.

    Attributes:
        rows: names of the task's k rows.
        drives: names of the coordinates that are driven.
        start: `(k,)` rows in the configuration from which the coordinates count.
        turned: rotation `(3, 3)` of the link there, where the last three rows are a rotation
            vector; else None.
    """

    rows: tuple[str, ...]
    drives: tuple[str, ...]
    start: Array
    turned: Array | None = None

    def positions(self, given: Array, along_path: bool, other: bool = False) -> Array:
        """Return positions `(…, d)` of the drives.

        Args:
            given: `(…, k)` of the rows.
            along_path: whether each sample is followed from the one before.
            other: whether the other angles are wanted that give a rotation.
        """
        if self.turned is None:
            return np.asarray(given - self.start)
        vectors = given[..., 3:].reshape(-1, 3)
        rows = [vectors.T, self.turned.reshape(9, 1)]
        both = _turning().run_rows(rows, len(vectors)).T.reshape(-1, 2, 3)
        turns = _along(both) if along_path else both[:, int(other)]
        result = np.zeros((*given.shape[:-1], len(self.drives)))
        result[..., :3] = given[..., :3] - self.start[:3]
        result[..., 6:] = turns.reshape(*given.shape[:-1], 3)
        return result

    def rates(self, speeds: Array, accelerations: Array) -> tuple[Array, Array]:
        """Return speeds and accelerations `(…, d)` of the drives, of those `(…, k)` of the rows."""
        if self.turned is None:
            return speeds, accelerations
        shape = np.broadcast_shapes(speeds.shape, accelerations.shape)
        padded = np.zeros((2, *shape[:-1], len(self.drives)))
        padded[..., :6] = np.broadcast_to(speeds, shape), np.broadcast_to(accelerations, shape)
        # The turns that carry the angular velocity stand at zero, where the second is carried by
        # the first, and the third by both.
        x, y, z = np.moveaxis(padded[0, ..., 3:6], -1, 0)
        padded[1, ..., 3:6] -= np.stack([y * z, -x * z, x * y], axis=-1)
        return padded[0], padded[1]

    def rows_at(self, columns: Array) -> Array:
        """Return the rows `(k,)` at positions `(d,)` of the drives."""
        if self.turned is None:
            return np.asarray(columns + self.start)
        turn = pinocchio.Quaternion(cardan_quaternion(columns[6:])).toRotationMatrix()
        vector = pinocchio.log3(turn @ self.turned)
        return np.concatenate([columns[:3] + self.start[:3], vector])


def points_led(tasks: Iterable[Task]) -> dict[str, tuple[str, Array]]:
    """Return links of which tasks lead a point, to that point `(3,)`, as `points` of results."""
    return {
        task.link: (task.link, np.asarray(getattr(task, "point", (0.0, 0.0, 0.0))))
        for task in tasks
        if isinstance(task, (PointTask, PoseTask))
    }


def missed(tasks: Iterable[Task], rows: Array, result: MotionResult) -> float:
    """Return by how much a mechanism misses tasks: greatest angle [rad], or length of its own.

    Args:
        tasks: the tasks.
        rows: `(..., m)` what they ask for.
        result: how it moves, in the same shape of samples.
    """
    mechanism, worst, first = result.mechanism, [0.0], 0
    length = mechanism.characteristic_length
    for task in tasks:
        if isinstance(task, str):
            apart, count = result.motion.position(task) - rows[..., first], 1
            worst.append(np.abs(apart).max() / (length if mechanism.drivable[task].slides else 1.0))
        elif isinstance(task, AngleTask):
            body, frame = mechanism.link_frame(task.link)
            zero = (mechanism.placements_at_zero[body - 1] * frame).rotation
            turned = _about(result.orientation(task.link) @ zero.T, task.axis)
            apart, count = _within(turned - rows[..., first]), 1
            worst.append(np.abs(apart).max())
        elif isinstance(task, DirectionTask):
            points = result.orientation(task.link) @ task.direction
            if task.other:
                points = (points[..., None, :] @ result.orientation(task.other))[..., 0, :]
            a, b = np.moveaxis(rows[..., first : first + 2], -1, 0)
            asked = np.stack([np.sin(b), -np.sin(a) * np.cos(b), np.cos(a) * np.cos(b)], axis=-1)
            apart = points - np.roll(asked, _AXES.index(task.along) + 1, axis=-1)
            count = 2
            worst.append(np.abs(apart).max())
        elif isinstance(task, DistanceTask):
            ends = (task.link, task.point), (task.other, task.other_point)
            to, fro = (result.point(*end).position for end in ends)
            apart, count = np.linalg.norm(to - fro, axis=-1) - rows[..., first], 1
            worst.append(np.abs(apart).max() / length)
        else:
            axes = task.axes if isinstance(task, PointTask) else _AXES
            at = result.point(task.link, task.point if isinstance(task, PointTask) else _ORIGIN)
            count, columns = len(axes), [_AXES.index(axis) for axis in axes]
            apart = at.position[..., columns] - rows[..., first : first + count]
            worst.append(np.abs(apart).max() / length)
            if isinstance(task, PoseTask):
                vectors = rows[..., first + 3 : first + 6].reshape(-1, 3)
                turns = zip(at.orientation.reshape(-1, 3, 3), vectors, strict=True)
                # What is left of the identity: small angles do not vanish in rounding.
                worst += [
                    np.abs(turn.T @ pinocchio.exp3(by) - np.eye(3)).max() for turn, by in turns
                ]
                count = 6
        first += count
    return float(max(worst))


def _about(rotations: Array, axis: str) -> Array:
    """Return the angles `(...)` about a world axis of rotations `(..., 3, 3)` about it."""
    second, third = (_AXES.index(other) for other in _AXES.replace(axis, ""))
    if axis == "y":
        second, third = third, second
    return np.arctan2(
        rotations[..., third, second] - rotations[..., second, third],
        rotations[..., second, second] + rotations[..., third, third],
    )


@cache
def _turning() -> Program:
    """Return a program of the angles of turns about x, the carried y, the carried z.

    Both of each rotation without whole turns, first those nearest to zero. Inputs are a rotation
    vector, and row by row the rotation from which the turns lead to it.
    """
    with Trace() as trace:
        vector = [trace.input(axis, 0.1) for axis in _AXES]
        rows = [[trace.input(f"{i}{k}", 0.0, uniform=True) for k in range(3)] for i in range(3)]
        angle = sqrt(dot(vector, vector))
        axis = times(vector, select(angle, 1.0 / angle, 0.0))
        # The transpose of a rotation is its inverse.
        x, y, z = product(about(axis, sin(angle), cos(angle)), rows)
        cosine = sqrt(z[1] * z[1] + z[2] * z[2])
        # Of a middle turn by a right angle, rounding alone would tell the first one. Whatever that
        # is, the last one leads on to the rotation.
        turn = select(cosine - 8.0 * EPS, arctan2(-z[1], z[2]), 0.0)
        sine, cosine_of_turn = sin(turn), cos(turn)
        last = (sine * axis[2] + cosine_of_turn * axis[1] for axis in (x, y))
        first = [turn, arctan2(z[0], cosine), arctan2(*last)]
        half = [select(value, np.pi, -np.pi) for value in first]
        other = [first[0] - half[0], half[1] - first[1], first[2] - half[2]]
        far, farther = (reduce(greater, map(absolute, angles)) for angles in (first, other))
        pairs = list(zip(first, other, strict=True))
        near = [select(far - farther, b, a) for a, b in pairs]
        return Program(trace, [*near, *(select(far - farther, a, b) for a, b in pairs)])


def _along(both: Array) -> Array:
    """Return of `(N, 2, 3)` angles, up to whole turns, the `(N, 3)` nearest to the ones before."""
    at, found = np.zeros(3), []
    for options in both:
        near = at + _within(options - at)
        at = near[np.abs(near - at).max(axis=-1).argmin()]
        found.append(at)
    return np.array(found)


def _within(angles: Array) -> Array:
    """Return angles without whole turns."""
    return np.asarray(angles - 2.0 * np.pi * np.rint(angles / (2.0 * np.pi)))


def followers(
    mechanism: Mechanism, tasks: Iterable[Task], start: Configuration
) -> tuple[Mechanism, list[Block]]:
    """Return a mechanism with drives that follow tasks, and which drives these are.

    Args:
        mechanism: the mechanism that has the tasks.
        tasks: the tasks.
        start: where the added coordinates are zero.

    Raises:
        ModelError: no such link, or one that cannot move.
    """
    described = mechanism.base.description
    items = *described.links, *described.joints_and_loops, *described.couplings
    taken = {*(item.name for item in items), *described.fixed_frames}
    taken |= mechanism.drivable.keys() | mechanism.base.drivable.keys()
    links, joints, loops = [*described.links], [*described.joints], [*described.loops]
    blocks = []
    for task in tasks:
        if isinstance(task, str):
            blocks.append(Block((task,), (task,), np.zeros(1)))
            continue
        if mechanism.link_frame(task.link)[0] == 0:
            raise ModelError(
                f"a task of {task.link!r}, which is fixed to the world: name a link that moves; "
                f"links: {choices(mechanism.link_names)}",
                name=task.link,
            )
        chain = _Chain(mechanism, task, start, taken)
        joints += chain.joints
        links += [LinkDescription(item.child) for item in chain.joints]
        loops.append(chain.loop)
        blocks.append(chain.block)
    if len(loops) == len(described.loops):
        return mechanism, blocks
    extended = replace(
        described,
        links=tuple(links),
        joints=tuple(joints),
        order=(*described.order, *(item.name for item in joints[len(described.joints) :])),
        loops=tuple(loops),
        independent_joints=(),
        source=None,  # Its numbers are not those of a text.
        added="",
    )
    return Mechanism(extended), blocks


def _normal(mechanism: Mechanism, body: int) -> str:
    """Return the world axis at right angles to the plane in which a body moves, if there is one.

    It is told by the joints that carry the body from the world.
    """
    parts = {part.id: part for part in mechanism.coordinates.parts}
    possible = np.ones(3, dtype=bool)
    while body > 0:
        part = parts[body]
        along = np.abs(mechanism.placements_at_zero[body - 1].rotation @ part.axis)
        slides, is_ball = part.kind == "prismatic", part.kind == "spherical"
        possible &= not is_ball
        possible &= np.abs(along - (0.0 if slides else 1.0)) < ROUNDED
        body = mechanism.model.parents[body]
    return next((axis for axis, moves in zip(_AXES, possible, strict=True) if moves), "")


class _Chain:
    """What carries the frame of a task, from the world or another link, and what closes it.

    Attributes:
        joints: from the world or that link on.
        loop: between the last of them and the task's link.
        block: how it is driven.
    """

    def __init__(
        self, mechanism: Mechanism, task: _OnLink, start: Configuration, taken: set[str]
    ) -> None:
        """Make it.

        Args:
            mechanism: to which it is added.
            task: what it follows.
            start: see `followers`.
            taken: names of everything in the description; its own join them.

        Raises:
            ModelError: there is no such link, or a distance is zero at the start.
        """
        described = mechanism.base.description
        self._link, self._taken = task.link, taken
        self.joints: list[JointDescription] = []
        base, self._at = np.eye(4), np.eye(4)
        if other := getattr(task, "other", ""):
            mechanism.link_frame(other)  # It refuses what is none.
            base = _placed(start.orientation(other), start.point(other))
            self._last, self._at = described.fixed_frames.get(other, (other, np.eye(4)))
        else:
            self._last = described.root
        # Where the link is at the start, and where the last joint is, seen from what carries them.
        point = np.asarray(getattr(task, "point", _ORIGIN))
        place = _placed(start.orientation(task.link), start.point(task.link, point))
        place, self._reached = inverse(base) @ place, np.eye(4)
        body, frame = mechanism.link_frame(task.link)
        normal, closing, axis = _normal(mechanism, body), "fixed", np.eye(3)[0]
        if isinstance(task, PointTask):
            self.block = self._point(task, place, normal)
            closing = "continuous" if normal else "spherical"
            axis = place[_AXES.index(normal), :3] if normal else axis
        elif isinstance(task, PoseTask):
            self.block = self._pose(place)
        elif isinstance(task, AngleTask):
            zero = (mechanism.placements_at_zero[body - 1] * frame).rotation
            turned = float(_about(place[:3, :3] @ zero.T, task.axis))
            self.block = self._angle(task, place, turned, task.axis == normal)
        elif isinstance(task, DirectionTask):
            self.block = self._direction(task, place)
        else:
            least = ROUNDED * mechanism.characteristic_length
            self.block, closing = self._distance(task, place, least), "spherical"
        link, frame = described.fixed_frames.get(task.link, (task.link, IDENTITY))
        ends = inverse(self._reached) @ place, frame @ _placed(_UNTURNED, point)
        name = unique(f"{self.joints[0].name} follower", taken)
        self.loop = LoopDescription(name, closing, self._last, link, *ends, axis, axis)

    def _add(self, kind: str, axis: str, name: str) -> str:
        """Add a joint about or along an axis, and a link behind it; return its name."""
        name = unique(f"{self._link}.{name}", self._taken)
        child = unique(f"{name} carriage", self._taken)
        unit = np.eye(3)[_AXES.index(axis)]
        self.joints.append(JointDescription(name, kind, self._last, child, self._at, unit, unit))
        self._last, self._at = child, np.eye(4)
        return name

    def _go(self, rotation: Array, translation: Array) -> None:
        """Place what is added next."""
        way = _placed(rotation, translation)
        self._at, self._reached = self._at @ way, self._reached @ way

    def _slides(self, place: Array, axes: str) -> list[str]:
        """Add slides to where a link is."""
        self._go(_UNTURNED, place[:3, 3])
        return [self._add("prismatic", axis, axis) for axis in axes]

    def _turns(self, axes: str) -> list[str]:
        return [self._add("continuous", axis, f"turn_{axis}") for axis in axes]

    def _point(self, task: PointTask, place: Array, normal: str) -> Block:
        # What is given comes first, the others are passive. Out of a plane there are none.
        slides = self._slides(place, task.axes + _without(task.axes + normal))
        at = place[[_AXES.index(axis) for axis in task.axes], 3]
        return Block(given := tuple(slides[: len(at)]), given, at)

    def _pose(self, place: Array) -> Block:
        # The first three turns carry the angular velocity and stand at zero, where they do not
        # lock.
        names = (*self._slides(place, _AXES), *self._turns(_AXES * 2))
        start = np.append(place[:3, 3], np.zeros(3))
        return Block(names[:6], names, start, place[:3, :3])

    def _angle(self, task: AngleTask, place: Array, turned: float, in_plane: bool) -> Block:
        self._slides(place, _without(task.axis * in_plane))
        turn, *_ = self._turns(task.axis + _without(task.axis) * (not in_plane))
        return Block((turn,), (turn,), np.array([turned]))

    def _direction(self, task: DirectionTask, place: Array) -> Block:
        self._slides(place, _AXES)
        first, second, third = np.roll(np.eye(3), -_AXES.index(task.along) - 1, axis=0)
        x, y, z = place[:3, :3] @ task.direction @ np.stack([first, second, third], axis=1)
        start = np.array([np.arctan2(-y, z), np.arctan2(x, np.hypot(y, z))])
        names = []
        for axis, angle in zip((first, second), start, strict=True):
            self._go(pinocchio.exp3(angle * axis), np.zeros(3))
            names += self._turns(_AXES[axis.argmax()])
        self._turns(task.along)
        return Block(given := tuple(names), given, start)

    def _distance(self, task: DistanceTask, place: Array, least: float) -> Block:
        way = place[:3, 3] - task.other_point
        length = float(np.linalg.norm(way))
        if length <= least:
            raise ModelError(
                f"a task of the distance of {task.link!r} from {task.other!r}, which is zero where "
                "the scene starts and has no direction: begin elsewhere with near=",
                name=task.link,
            )
        along = way / length
        across = np.cross(along, np.eye(3)[np.abs(way).argmin()])
        across /= np.linalg.norm(across)
        turned = np.stack([along, across, np.cross(along, across)], axis=1)
        self._go(turned, np.asarray(task.other_point))
        self._add("spherical", "x", "distance foot")
        self._go(_UNTURNED, length * np.eye(3)[0])
        slide = self._add("prismatic", "x", "distance")
        return Block((slide,), (slide,), np.array([length]))


def _placed(rotation: Array, translation: Array) -> Array:
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = rotation, translation
    return placement


def _without(axes: str) -> str:
    """Return the other axes."""
    return "".join(axis for axis in _AXES if axis not in axes)
