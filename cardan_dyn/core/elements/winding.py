"""Winding: how far two frames of a mechanism are turned relative to each other, turns counted.

A rotation itself does not say how often it was wound; the coordinates of the joints between both
frames do, as far as it is less than half a turn at the description's zero: of half a turn there,
nothing says in which sense it is. Where all of these joints turn about one direction, the rotation
is the sum of their angles, over any number of turns. Where they turn about several, a sum of turns
has no meaning beyond half a turn: as angles and axes come back to the same rotation in different
ways, their rotation vector is followed from the description's zero along a straight line, and must
not leave half a turn on it. Balls count no turns. A way between both frames without balls is taken
where there is one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array, quaternion_product
from ..mechanism.joints import Part
from ..mechanism.mechanism import Mechanism
from .rotation_vectors import quaternion, rotation_vector

GREATEST_ANGLE = 3.1
"""Rotation [rad] up to which a rotation vector is a smooth function of it; at pi it jumps."""
_PARALLEL = 1e-6
"""Sine of the angle between axes up to which they are parallel: rounding of the numbers given."""
_STEP = 1.0
"""Greatest turn [rad] between two points at which a rotation is looked at on its way from zero. One
that has left half a turn has to turn once more to come back from the other side."""


class _Edge(NamedTuple):
    """A way from one body to another, over an elementary part or a weld.

    Attributes:
        body: to which it leads.
        before: `(3, 3)` rotation of the part's frame in the body from which it leads.
        part: the part; None for a weld.
        sign: -1 where it leads from what the part moves to what carries it.
        column: first of the part's coordinates in a row.
        after: `(3, 3)` rotation of the body to which it leads, in the part's frame.
    """

    body: int
    before: Array
    part: Part | None
    sign: float
    column: int
    after: Array


class _Way(NamedTuple):
    """A way between two bodies on which all turns have one direction.

    Attributes:
        columns: of the coordinates that turn.
        signs: `(k,)` in which they add up to the turn about the axis.
        axis: `(3,)` in the body from which it leads.
        rotation: `(3, 3)` of the body to which it leads, where the coordinates are zero.
    """

    columns: list[int]
    signs: list[float]
    axis: Array | None
    rotation: Array


class Winding:
    """How far a frame is turned relative to another one."""

    def __init__(
        self, mechanism: Mechanism, first: tuple[int, Array], second: tuple[int, Array]
    ) -> None:
        """Find what turns them.

        Args:
            mechanism: the mechanism.
            first: body of the first frame in `Mechanism.model`, and its `(3, 3)` rotation there.
            second: likewise of the other frame.
        """
        edges = _edges(mechanism)
        self._zero = mechanism.zero
        self._sums = [
            item
            for way in _of_one_direction(edges, first[0], second[0])
            if (item := _sum_of(way, first[1], second[1], self._zero)) is not None
        ]
        path = None if self._sums else _without_balls(edges, first[0], second[0])
        self._path = path
        self._ends = first[1].T, second[1]
        self._turning, self._least = np.zeros(0, dtype=int), np.inf
        if path is not None:
            turns = [edge for edge in path if edge.part and edge.part.kind == "revolute"]
            self._turning = np.array([edge.column for edge in turns], dtype=int)
            zero = self._ends[0]
            for edge in path:
                zero = zero @ edge.before @ edge.after
            zero = rotation_vector((zero @ self._ends[1])[None])
            self._least = float(np.linalg.norm(zero))

    def turns(self, x: Array, rotation: Array) -> tuple[Array, Array]:
        """Return rotation vectors `(N, 3)` in the axes of the first frame, and where they are lost.

        Args:
            x: `(N, size)` coordinates; angles count whole turns.
            rotation: `(N, 3, 3)` of the second frame relative to the first.

        Returns:
            The rotation vectors, and `(N,)` whether nothing says how often the second frame is
            wound.
        """
        turn = rotation_vector(rotation)
        for columns, signs, axis, start in self._sums:
            angle = start + (x - self._zero)[:, columns] @ signs
            if np.all(np.isfinite(angle)):
                if abs(start) > GREATEST_ANGLE:
                    return turn, np.ones(len(x), dtype=bool)
                # What turns by less has its own rounding, and that of closing loops, beside it.
                far = np.abs(angle) > GREATEST_ANGLE
                turn[far] = angle[far, None] * axis
                return turn, np.zeros(len(x), dtype=bool)
        lost = np.einsum("ni,ni->n", turn, turn) > GREATEST_ANGLE**2
        if self._path is not None:
            lost |= self._left(self._path, x)
        return turn, lost

    def is_short(self, x: Array) -> bool:
        """Return whether the shortest rotation vector is the one at coordinates `x (size,)`."""
        for columns, signs, _, start in self._sums:
            angle = float(start + (x - self._zero)[columns] @ signs)
            return max(abs(start), abs(angle)) <= GREATEST_ANGLE
        # No rotation leads farther than the sum of its turns, from where all of them are zero.
        turned = np.maximum(np.abs(x), np.abs(self._zero))[self._turning]
        return self._path is None or bool(self._least + np.sum(turned) <= GREATEST_ANGLE)

    def _left(self, path: list[_Edge], x: Array) -> Array:
        """Return `(N,)` whether a rotation leaves half a turn on a straight line from zero.

        Unit quaternions tell rotations by less than half a turn from those by more, up to two
        turns: the scalar part changes its sign at half a turn.
        """
        moved = x - self._zero
        turning = [
            edge.column for edge in path if edge.part is not None and edge.part.kind == "revolute"
        ]
        sums = np.sum(np.abs(moved[:, turning]), axis=1)
        greatest = float(np.max(sums, initial=0.0))
        if not np.isfinite(greatest):
            return np.zeros(len(x), dtype=bool)
        steps = np.linspace(0.0, 1.0, int(np.ceil(greatest / _STEP)) + 2)
        result = quaternion(self._ends[0])[None]
        for edge in path:
            result = quaternion_product(result, quaternion(edge.before)[None])
            if edge.part is not None and edge.part.kind == "revolute":
                angle = self._zero[edge.column] + steps[:, None] * moved[:, edge.column]
                half = 0.5 * edge.sign * angle.reshape(-1, 1)
                turned = np.concatenate([np.sin(half) * edge.part.axis, np.cos(half)], axis=1)
                result = quaternion_product(*np.broadcast_arrays(result, turned))
            result = quaternion_product(result, quaternion(edge.after)[None])
        result = quaternion_product(result, quaternion(self._ends[1])[None])
        scalar = (
            np.broadcast_to(result[:, 3], len(steps) * len(x))
            if len(result) == 1
            else (result[:, 3])
        )
        scalar = scalar.reshape(len(steps), len(x))
        left = np.any(scalar * np.where(scalar[0] < 0.0, -1.0, 1.0) < 0.0, axis=0)
        return np.asarray(left | (np.abs(scalar[0]) < np.cos(0.5 * GREATEST_ANGLE)))


def _edges(mechanism: Mechanism) -> dict[int, list[_Edge]]:
    """Return the ways that lead from each body, those of the tree first."""
    model, coordinates = mechanism.model, mechanism.coordinates
    edges: dict[int, list[_Edge]] = {body: [] for body in range(model.njoints)}
    for part, column in zip(coordinates.parts, coordinates.starts, strict=True):
        parent, placed = model.parents[part.id], model.jointPlacements[part.id].rotation
        edges[parent].append(_Edge(part.id, placed, part, 1.0, column, np.eye(3)))
        edges[part.id].append(_Edge(parent, np.eye(3), part, -1.0, column, placed.T))
    for loop in mechanism.loops:
        one, other = loop.predecessor_placement.rotation, loop.successor_placement.rotation
        edges[loop.predecessor].append(_Edge(loop.successor, one, None, 1.0, 0, other.T))
        edges[loop.successor].append(_Edge(loop.predecessor, other, None, 1.0, 0, one.T))
    return edges


def _of_one_direction(edges: dict[int, list[_Edge]], start: int, goal: int) -> Iterator[_Way]:
    """Yield ways from one body to another, the shortest first, of each direction one."""
    waiting = deque([(start, _Way([], [], None, np.eye(3)))])
    seen: list[tuple[int, Array | None]] = [(start, None)]
    while waiting:
        body, way = waiting.popleft()
        if body == goal:
            yield way
            continue
        for edge in edges[body]:
            rotation = way.rotation @ edge.before
            longer = way
            if edge.part is not None and edge.part.kind == "spherical":
                continue
            if edge.part is not None and edge.part.kind == "revolute":
                axis = rotation @ edge.part.axis
                common = axis if way.axis is None else way.axis
                if np.linalg.norm(np.cross(axis, common)) > _PARALLEL:
                    continue
                signs = [*way.signs, edge.sign * float(np.sign(axis @ common))]
                longer = _Way([*way.columns, edge.column], signs, common, rotation)
            if any(
                edge.body == other and _same(longer.axis, axis_there) for other, axis_there in seen
            ):
                continue
            seen.append((edge.body, longer.axis))
            waiting.append((edge.body, longer._replace(rotation=rotation @ edge.after)))


def _same(one: Array | None, other: Array | None) -> bool:
    """Return whether two directions, or none, are the same."""
    if one is None or other is None:
        return one is other
    return bool(np.linalg.norm(np.cross(one, other)) <= _PARALLEL)


def _sum_of(
    way: _Way, first: Array, second: Array, zero: Array
) -> tuple[list[int], Array, Array, float] | None:
    """Return how the turn of a frame adds up; None if it is not one about the way's axis.

    That is columns, signs, the axis `(3,)` in the first frame, and the angle at the description's
    `zero` [rad], less than half a turn. `first` and `second` turn the frames in their bodies.
    """
    if way.axis is None:
        return None
    whole, axis = first.T @ way.rotation @ second, first.T @ way.axis
    if np.linalg.norm(whole @ axis - axis) > _PARALLEL:
        return None
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    turned = whole @ across
    signs = np.array(way.signs)
    angle = np.arctan2(axis @ np.cross(across, turned), across @ turned) + zero[way.columns] @ signs
    return way.columns, signs, axis, float(np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi)


def _without_balls(edges: dict[int, list[_Edge]], start: int, goal: int) -> list[_Edge] | None:
    """Return the shortest way from one body to another on which no part is a ball."""
    waiting, paths = deque([start]), {start: list[_Edge]()}
    while waiting:
        body = waiting.popleft()
        for edge in edges[body]:
            is_ball = edge.part is not None and edge.part.kind == "spherical"
            if not is_ball and edge.body not in paths:
                paths[edge.body] = [*paths[body], edge]
                waiting.append(edge.body)
    return paths.get(goal)
