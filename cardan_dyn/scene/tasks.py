"""Tasks: what of a mechanism moves as given other than its coordinates, and how it is followed.

A task is followed by massless slides and turns from the world that are driven, and closed onto the
link which it names: the mechanism with them is an ordinary one, whose loops decide the actuated
joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
import pinocchio

from ..core.description.description import (
    IDENTITY,
    Description,
    JointDescription,
    LinkDescription,
    LoopDescription,
)
from ..core.description.elements import unique
from ..core.mechanism.configuration import Configuration
from ..core.mechanism.mechanism import Mechanism
from ..core.results.prescribed import MotionResult
from ..kit.arrays import Array, cardan_angles, cardan_quaternion, quaternion_product
from ..kit.checks import text, vector
from ..kit.errors import ArgumentError, ModelError, choices
from ..kit.frozen import Record

_AXES, _ORIGIN = "xyz", (0.0, 0.0, 0.0)


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
        axis = _axes("AngleTask: axis", self.axis)
        if len(axis) > 1:
            raise ArgumentError(f"AngleTask: axis is {axis!r}, expected x, y or z")
        object.__setattr__(self, "axis", axis)


KINDS = (PointTask, PoseTask, AngleTask)
Task: TypeAlias = PointTask | PoseTask | AngleTask | str


def _axes(label: str, given: object) -> str:
    """Return axes, each of them once."""
    axes = text(label, given)
    if not axes or set(axes) - set(_AXES) or len(set(axes)) < len(axes):
        raise ArgumentError(f"{label} is {axes!r}, expected up to three of x, y, z")
    return axes


class Block(NamedTuple):
    """Drives that follow a task, of which `k` are given and others rest.

    Attributes:
        rows: names of the task's k rows.
        drives: names of the coordinates that are driven.
        start: `(k,)` rows in the configuration from which the coordinates count.
        turned: unit quaternion `(4,)` (x, y, z, w) of the link there, where the last three rows are
            a rotation vector; else None.
    """

    rows: tuple[str, ...]
    drives: tuple[str, ...]
    start: Array
    turned: Array | None = None

    def positions(self, given: Array, along_path: bool) -> Array:
        """Return positions `(…, d)` of the drives.

        Args:
            given: `(…, k)` of the rows.
            along_path: whether each sample is followed from the one before.
        """
        if self.turned is None:
            return np.asarray(given - self.start)
        angle = np.linalg.norm(given[..., 3:], axis=-1, keepdims=True)
        half = np.sinc(0.5 * angle / np.pi) * 0.5 * given[..., 3:]
        wanted = np.concatenate([half, np.cos(0.5 * angle)], axis=-1).reshape(-1, 4)
        back = self.turned * (-1.0, -1.0, -1.0, 1.0)
        turns = _turns(quaternion_product(wanted, back[None, :]), along_path)
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
        turned = quaternion_product(cardan_quaternion(columns[6:]), self.turned)
        turn = pinocchio.log3(pinocchio.Quaternion(turned).toRotationMatrix())
        return np.concatenate([columns[:3] + self.start[:3], turn])


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


def _turns(quaternions: Array, along_path: bool) -> Array:
    """Return angles `(N, 3)` of turns about x, the carried y, the carried z, of rotations `(N, 4)`.

    Of those that give a rotation they are the nearest to zero, or to the sample before.
    """
    first = cardan_angles(quaternions.T).T
    other = first * (1.0, -1.0, 1.0) + np.pi
    every = np.stack([first, other], axis=1)
    if not along_path:
        return _nearest(every, np.zeros(3))
    at, found = np.zeros(3), []
    for options in every:
        at = _nearest(options[None], at)[0]
        found.append(at)
    return np.array(found)


def _nearest(options: Array, to: Array) -> Array:
    """Return `(N, 3)` of angles `(N, 2, 3)`, up to whole turns, those nearest to others `(3,)`."""
    near = to + _within(options - to)
    best = np.abs(near - to).max(axis=-1).argmin(axis=-1)
    return np.asarray(near[np.arange(len(near)), best])


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
        body, frame = mechanism.link_frame(task.link)
        if body == 0:
            raise ModelError(
                f"a task of {task.link!r}, which is fixed to the world: name a link that moves; "
                f"links: {choices(mechanism.link_names)}",
                name=task.link,
            )
        chain = _Chain(described, task, start, taken)
        joints += chain.joints
        links += [LinkDescription(item.child) for item in chain.joints]
        loops.append(chain.loop)
        blocks.append(chain.block(mechanism.placements_at_zero[body - 1] * frame))
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


class _Chain:
    """Slides and turns from the world that carry the frame of a task, and what closes them.

    Attributes:
        joints: from the world on.
        loop: between the last of them and the task's link.
    """

    def __init__(
        self,
        described: Description,
        task: PointTask | PoseTask | AngleTask,
        start: Configuration,
        taken: set[str],
    ) -> None:
        """Make it.

        Args:
            described: the description to which it is added.
            task: what it follows.
            start: see `followers`.
            taken: names of everything in the description; its own join them.
        """
        self._task, self._taken = task, taken
        children = {item.child for item in described.joints}
        (self._last,) = (link.name for link in described.links if link.name not in children)
        self.joints: list[JointDescription] = []
        point = np.asarray(task.point if isinstance(task, PointTask) else np.zeros(3))
        self._at, self._rotation = start.point(task.link, point), start.orientation(task.link)
        self._given = (
            task.axes if isinstance(task, PointTask) else _AXES * isinstance(task, PoseTask)
        )
        origin = np.eye(4)
        origin[:3, 3] = self._at
        # What is given comes first; the other slides are passive.
        for axis in (*self._given, *(axis for axis in _AXES if axis not in self._given)):
            self._add("prismatic", axis, origin)
            origin = IDENTITY
        if isinstance(task, PoseTask):
            # The first three carry the angular velocity and stand at zero, where they do not lock.
            for axis in _AXES * 2:
                self._add("continuous", axis)
        elif isinstance(task, AngleTask):
            for axis in (task.axis, *(axis for axis in _AXES if axis != task.axis)):
                self._add("continuous", axis)
        before, after = np.eye(4), np.eye(4)
        before[:3, :3], after[:3, 3] = self._rotation, point
        link, frame = described.fixed_frames.get(task.link, (task.link, IDENTITY))
        axis = np.eye(3)[0]
        self.loop = LoopDescription(
            unique(f"{self.joints[0].name} follower", taken),
            "spherical" if isinstance(task, PointTask) else "fixed",
            *(self._last, link, before, frame @ after, axis, axis),
        )
        taken.add(self.loop.name)

    def _add(self, kind: str, axis: str, origin: Array = IDENTITY) -> None:
        """Add a joint about or along an axis, and a link behind it."""
        turn = "turn_" * (kind != "prismatic")
        name = unique(f"{self._task.link}.{turn}{axis}", self._taken)
        child = unique(f"{name} carriage", self._taken)
        self._taken |= {name, child}
        unit = np.eye(3)[_AXES.index(axis)]
        self.joints.append(JointDescription(name, kind, self._last, child, origin, unit, unit))
        self._last = child

    def block(self, zero: pinocchio.SE3) -> Block:
        """Return how it is driven; `zero` is the placement of the task's link at zero."""
        task, names = self._task, [item.name for item in self.joints]
        at = self._at[[_AXES.index(axis) for axis in self._given]]
        if isinstance(task, PoseTask):
            turned = pinocchio.Quaternion(self._rotation).coeffs()
            return Block(tuple(names[:6]), tuple(names), np.append(at, np.zeros(3)), turned)
        if isinstance(task, PointTask):
            return Block(given := tuple(names[: len(at)]), given, at)
        angle = _about(self._rotation @ zero.rotation.T, task.axis)
        return Block((names[3],), (names[3],), np.array([angle]))
