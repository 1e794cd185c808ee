"""Idle rods: bodies that may spin about a line without any other body moving.

A rod with ball joints at both ends spins about the line between their centres; so does one whose
balls are written as three hinges each, with massless links between them, and a telescope of bodies
that slide on each other. Light bodies that hinges hold on one line, such as washers, do so too. No
loop decides such a spin, and no drive: it is decided by a rule, no turning about the line and no
moment about it. Rods are found from the geometry alone.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pinocchio

from ....kit.arrays import NOTHING, Array, cross
from ....kit.frozen import read_only
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import ancestors
from ...problem.problem import Problem
from .structure import Structure

_LIGHT = 1e-2
"""Part of the mechanism's mass up to which a body between hinges is a washer that nobody drives."""
_BALANCED = 0.02
"""Distance of a centre of mass from the line, as a fraction of the characteristic length, up to
which a body is a rod. Published robots have rods drawn askew by less; a body that hangs beside the
line is a pendulum, whose motion nobody may decide by a rule."""


class JointEdge(NamedTuple):
    """A joint as one of the two bodies that it connects sees it.

    Attributes:
        kind: see `Part.kind`.
        columns: its velocity coordinates.
        frame: placement of its frame in this body.
        axis: `(3,)` in its frame.
        other: the other body.
        other_frame: placement of its frame in the other body.
        neighbour: the other body where slides do not count as rigid.
    """

    kind: str
    columns: tuple[int, ...]
    frame: pinocchio.SE3
    axis: Array
    other: int
    other_frame: pinocchio.SE3
    neighbour: int


class _End(NamedTuple):
    """What holds one end of a body: a ball, or a hinge.

    Attributes:
        is_ball: whether it is one.
        point: `(3,)` centre of the ball, or a point on the hinge's axis, in the body.
        axis: `(3,)` of the hinge, in the body; of a ball that hinges make up, of the nearest of
            these, and zero of other balls.
        columns: its velocity coordinates, those of the nearest hinge first.
        neighbour: the body at its other side, see `JointEdge`.
    """

    is_ball: bool
    point: Array
    axis: Array
    columns: tuple[int, ...]
    neighbour: int

    def spun(self, line: Array) -> tuple[int, ...]:
        """Return the columns that move as the body spins about a line `(3,)`."""
        is_along = np.any(self.axis) and _are_parallel(self.axis, line)
        return self.columns[:1] if is_along else self.columns


class IdleRod(NamedTuple):
    """A body that may spin.

    Attributes:
        body: its index (0-based joint of the mechanism's model).
        columns: velocity coordinates of the joints at its ends, then those of a floating joint.
        line: `(3,)` direction of the line, in the frame of the body.
        frame: the body (0-based) relative to which it is decided how the rod turns, -1 for the
            world: the nearest one from which both bodies hang that hold the rod's ends, so that it
            makes no difference how the rod is written.
        ruled: those of the columns whose positions depend on how far the rod has spun.
    """

    body: int
    columns: tuple[int, ...]
    line: Array
    frame: int
    ruled: tuple[int, ...]


def idle_rods(mechanism: Mechanism, free: set[int]) -> tuple[IdleRod, ...]:
    """Return all bodies that may spin.

    Args:
        mechanism: the mechanism.
        free: velocity coordinates that are neither driven nor held.
    """
    return mechanism.kept.of("idle rods", frozenset(free), lambda: _found(mechanism, free))


def _found(mechanism: Mechanism, free: set[int]) -> tuple[IdleRod, ...]:
    """See `idle_rods`."""
    graph = JointGraph(mechanism, free)
    structure = Structure(mechanism)
    on_loops = {
        column for loop in range(len(mechanism.loops)) for column in structure.coordinates_on(loop)
    }
    rods = []
    for body in graph.edges:
        ends = [graph.end(body, edge) for edge in graph.edges[body]]
        line = graph.line(body, *ends) if body != graph.world and len(ends) == 2 else None
        if line is not None:
            held = [end for end in ends if end is not None]
            columns = tuple(column for end in held for column in end.columns)
            if not on_loops.issuperset(columns):
                continue  # What hangs in an open chain swings, and somebody has to drive it.
            frame = graph.common([end.neighbour for end in held])
            floating = graph.floating_columns(body)
            ruled = tuple(column for end in held for column in end.spun(line)) + floating
            rods.append(IdleRod(body - 1, columns + floating, read_only(line), frame, ruled))
    # The hinge along a rod without mass makes a ball with two at the rod's other end: a link there
    # that turns in it is how the rod itself spins.
    every = [set(rod.columns) for rod in rods]
    return tuple(
        rod for rod, own in zip(rods, every, strict=True) if not any(own < other for other in every)
    )


def rods_by_name(mechanism: Mechanism, free: set[int]) -> list[tuple[str, ...]]:
    """Return the joints at the ends of every idle rod by name; see `idle_rods`."""
    owner = {
        column: name
        for name, columns in mechanism.coordinates.velocity_columns.items()
        for column in range(columns.start, columns.stop)
    }
    return [
        tuple(dict.fromkeys(owner[column] for column in rod.columns))
        for rod in idle_rods(mechanism, free)
    ]


def rods_of(problem: Problem) -> list[tuple[str, ...]]:
    """Return the same of every rod that may spin while a scene moves."""
    return rods_by_name(problem.mechanism, set(problem.passive_columns.tolist()))


class JointGraph:
    """Rigid bodies, welds included, and the joints between them.

    Attributes:
        edges: body to its joints.
        world: the body that stands still.
        tolerance: distance up to which points are the same [m].
    """

    def __init__(self, mechanism: Mechanism, free: set[int]) -> None:
        model = mechanism.model
        # A coupling would hold a spin that it counts.
        self._free = free - {
            column
            for coupling in mechanism.couplings
            for column in (*coupling.predecessor_columns, *coupling.successor_columns)
        }
        self.tolerance = NOTHING * mechanism.characteristic_length
        floating = {
            part.id
            for joint in mechanism.joints.values()
            if joint.type == "floating"
            for part in joint.parts
        }
        slides = {
            part.id
            for part in mechanism.coordinates.parts
            if part.kind == "prismatic"
            and not (part.id in floating and model.idx_vs[part.id] in free)
        }
        self._placed = _rigid_bodies(mechanism, slides)
        apart = [body for body, _ in _rigid_bodies(mechanism, set())]
        self._model = model
        self._links_of: dict[int, list[int]] = {}
        carrying = {
            loop.predecessor for loop in mechanism.loops if mechanism.joints[loop.joint].parts
        }
        for index, leader in enumerate(apart):
            if index not in carrying:
                self._links_of.setdefault(leader, []).append(index)
        self.world = self._placed[0][0]
        self.edges: dict[int, list[JointEdge]] = {body: [] for body, _ in self._placed}
        self._mass = sum(float(inertia.mass) for inertia in model.inertias)
        self._balance_tolerance = _BALANCED * mechanism.characteristic_length
        self._masses = dict.fromkeys(self.edges, 0.0)
        self._mass_moments = {body: np.zeros(3) for body in self.edges}
        for index, inertia in enumerate(model.inertias):
            if index not in mechanism.auxiliary_bodies and inertia.mass > 0.0:
                body, pose = self._placed[index]
                self._masses[body] += inertia.mass
                self._mass_moments[body] += inertia.mass * pose.act(inertia.lever)
        # A floating joint holds nothing; its rod hangs between the loops that end on it.
        self._floating = {
            self._placed[joint.id][0]: tuple(range(columns.start, columns.stop))
            for name, columns in mechanism.coordinates.velocity_columns.items()
            if (joint := mechanism.joints[name]).type == "floating"
        }
        for part in mechanism.coordinates.parts:
            above_body = model.parents[part.id]
            parent, parent_pose = self._placed[above_body]
            child, child_pose = self._placed[part.id]
            columns = tuple(range(model.idx_vs[part.id], model.idx_vs[part.id] + part.nv))
            if parent == child or part.id in floating:
                continue
            above = parent_pose * model.jointPlacements[part.id]
            self.edges[parent].append(
                JointEdge(part.kind, columns, above, part.axis, child, child_pose, apart[part.id])
            )
            self.edges[child].append(
                JointEdge(
                    part.kind, columns, child_pose, part.axis, parent, above, apart[above_body]
                )
            )

    def end(self, body: int, edge: JointEdge) -> _End | None:
        """Return what holds a body at one of its joints; None if it is neither ball nor hinge.

        Hinges that follow each other with massless links between them may make up a ball.
        """
        pose, edge_there = pinocchio.SE3.Identity(), edge
        lines: list[tuple[Array, Array]] = []
        columns: list[int] = []
        current = body
        while set(edge_there.columns) <= self._free and edge_there.kind != "prismatic":
            frame = pose * edge_there.frame
            point = np.array(frame.translation)
            if edge_there.kind == "spherical":
                if lines:
                    break
                return _End(True, point, np.zeros(3), edge_there.columns, edge_there.neighbour)
            lines.append((point, frame.rotation @ edge_there.axis))
            columns += edge_there.columns
            centre = common_point(lines, self.tolerance)
            if centre is None:
                break
            if len(lines) == 3:
                return _End(True, centre, lines[0][1], tuple(columns), edge_there.neighbour)
            following = self._beyond(current, edge_there)
            if following is None:
                break
            pose, current, edge_there = (
                frame * edge_there.other_frame.inverse(),
                edge_there.other,
                following,
            )
        if not lines:
            return None
        return _End(False, *lines[0], edge.columns, edge.neighbour)

    def common(self, bodies: list[int]) -> int:
        """Return the nearest body (0-based) from which others hang, or that is one of them.

        Args:
            bodies: as `JointEdge.neighbour` has them.
        """
        paths = []
        for body in bodies:
            links = self._links_of.get(body, [body])
            paths.append(min((ancestors(self._model, link) for link in links), key=len))
        return max(set(paths[0]).intersection(*paths[1:]), default=-1)

    def line(self, body: int, first: _End | None, second: _End | None) -> Array | None:
        """Return the direction `(3,)` about which a body that is held by two ends is free to spin.

        It is in the frame of the body; None if the body is not free.
        """
        if first is None or second is None or first.neighbour == second.neighbour:
            # In two bearings of the same body, it is a shaft, which somebody has to drive.
            return None
        # Of a floating joint the turns follow three slides.
        if not self._free.issuperset(self.floating_columns(body)[3:]):
            return None
        offset = second.point - first.point
        if first.is_ball and second.is_ball:
            size = float(np.linalg.norm(offset))
            if size > self.tolerance and self._is_balanced(body, first.point, offset / size):
                return np.asarray(offset / size)
            return None
        hinge = second if first.is_ball else first
        if not (first.is_ball or second.is_ball or _are_parallel(first.axis, second.axis)):
            return None
        # A body with mass that turns on hinges is a rotor or a door, and somebody has to drive it.
        if self._masses[body] > _LIGHT * self._mass:
            return None
        is_line = float(np.linalg.norm(cross(hinge.axis, offset))) < self.tolerance
        is_free = is_line and self._is_balanced(body, hinge.point, hinge.axis)
        return hinge.axis if is_free else None

    def _is_balanced(self, body: int, point: Array, axis: Array) -> bool:
        """Return whether the centre of mass of a body lies on a line, or nearly so."""
        mass = self._masses[body]
        if not mass:
            return True
        centre = self._mass_moments[body] / mass
        return bool(np.linalg.norm(cross(axis, centre - point)) < self._balance_tolerance)

    def floating_columns(self, body: int) -> tuple[int, ...]:
        """Return the velocity coordinates of the floating joint of a body; none without one."""
        return self._floating.get(body, ())

    def _beyond(self, body: int, edge: JointEdge) -> JointEdge | None:
        """Return the other joint of the massless link beyond one; None if there is no such link."""
        other = edge.other
        if other in (self.world, body) or self._masses[other] or len(self.edges[other]) != 2:
            return None
        return next(item for item in self.edges[other] if item.columns != edge.columns)


def _rigid_bodies(mechanism: Mechanism, slides: set[int]) -> list[tuple[int, pinocchio.SE3]]:
    """Return for every body of the model the rigid body that it belongs to, and its place there.

    Slides, by the indices of their bodies, count as rigid: spins are motions in which they rest,
    whatever decides them. Hinges do not, since how they are turned decides where the lines are.
    """
    model, count = mechanism.model, mechanism.model.njoints
    welded: list[list[tuple[int, pinocchio.SE3]]] = [[] for _ in range(count)]
    for loop in mechanism.loops:
        placement = loop.predecessor_placement * loop.successor_placement.inverse()
        welded[loop.predecessor].append((loop.successor, placement))
        welded[loop.successor].append((loop.predecessor, placement.inverse()))
    for body in slides:
        parent, placement = model.parents[body], model.jointPlacements[body]
        welded[parent].append((body, placement))
        welded[body].append((parent, placement.inverse()))
    placed: dict[int, tuple[int, pinocchio.SE3]] = {}
    for body in range(count):
        if body in placed:
            continue
        placed[body] = body, pinocchio.SE3.Identity()
        waiting = [body]
        while waiting:
            current = waiting.pop()
            for other, placement in welded[current]:
                if other not in placed:
                    placed[other] = body, placed[current][1] * placement
                    waiting.append(other)
    return [placed[body] for body in range(count)]


def _are_parallel(first: Array, second: Array) -> bool:
    """Return whether two unit vectors `(3,)` have the same line: what ten digits say."""
    return float(np.linalg.norm(cross(first, second))) < NOTHING


def common_point(lines: list[tuple[Array, Array]], tolerance: float) -> Array | None:
    """Return the point `(3,)` that lines (point, direction) have in common; None without one."""
    if len(lines) == 1:
        return lines[0][0]
    if any(_are_parallel(first[1], second[1]) for first, second in pairwise(lines)):
        return None
    # The sum of squared distances from all lines is least where it has no slope.
    projectors = [np.eye(3) - np.outer(axis, axis) for _, axis in lines]
    slope = sum(projector @ point for projector, (point, _) in zip(projectors, lines, strict=True))
    centre = np.linalg.solve(sum(projectors), slope)
    distances = [
        np.linalg.norm(projector @ (centre - point))
        for projector, (point, _) in zip(projectors, lines, strict=True)
    ]
    return centre if max(distances) < tolerance else None
