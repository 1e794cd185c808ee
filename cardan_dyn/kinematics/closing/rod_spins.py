"""Rod spins: how idle rods turn about their lines, as arithmetic of one sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...arrays import Array
from ...mechanics.bodies import Tree
from ...mechanics.elimination import Row
from ...mechanics.placements import Motion, Placed, placed
from ...mechanics.vectors import (
    Scalar,
    Vector,
    added,
    cross,
    dot,
    less,
    seen,
    times,
    turned,
)
from ...tape import arctan2, greater
from ..loops.idle_rods import IdleRod


class RodSpins:
    """The k idle rods of a group, each of which may turn about a line that is fixed in it."""

    def __init__(
        self,
        tree: Tree,
        rods: Sequence[IdleRod],
        index_of: Mapping[int, int],
        zero: Mapping[int, Scalar],
    ) -> None:
        """Find where the rods are at the description's zero.

        Args:
            tree: of the group.
            rods: the k rods.
            index_of: body of the mechanism to its index in the tree. What is not in the tree
                carries it.
            zero: coordinates of the description's zero, by columns.
        """
        self._tree = tree
        # The rod, its frame, and the line's direction in it.
        self._rods: list[tuple[int, int, Vector]] = [
            (index_of[rod.body], index_of.get(rod.frame, -1), rod.line.tolist()) for rod in rods
        ]
        # Seen from the frame, the line and a vector across it at zero; and the latter in the rod.
        self._at_zero: list[tuple[Vector, Vector, Vector]] = []
        at = placed(tree, zero) if rods else None
        for rod, frame, line in self._rods:
            assert at is not None
            across = _across(np.array(line)).tolist()
            seen_at_zero = (_from(at, frame, turned(at.rotations[rod], v)) for v in (line, across))
            self._at_zero.append((*seen_at_zero, across))

    def __len__(self) -> int:
        return len(self._rods)

    def rows(self, at: Placed) -> list[Row]:
        """Return how fast each rod turns about its line per unit of coordinates.

        It does so relative to its frame: what moves both alike makes no difference.
        """
        result: list[Row] = []
        for rod, frame, line in self._rods:
            along, row = turned(at.rotations[rod], line), dict[int, Scalar]()
            own, others = self._tree.path(rod), self._tree.path(frame)
            for path, opposite, sign in ((own, others, 1.0), (others, own, -1.0)):
                for body in (self._tree.bodies[index] for index in path if index not in opposite):
                    if body.kind != "prismatic":
                        row |= {rate: sign * dot(at.directions[rate], along) for rate in body.rates}
            result.append(row)
        return result

    def drifts(self, at: Placed, motion: Motion) -> list[Scalar]:
        """Return accelerations about the lines that rates alone cause."""
        result = []
        for rod, frame, line in self._rods:
            along = turned(at.rotations[rod], line)
            # The line l of a rod that spins by ω while its frame does by Ω changes by ω × l, so
            # that of l · (ω - Ω) by the former l · (Ω × ω) less.
            change = less(motion.spin_rate(rod), motion.spin_rate(frame))
            change = less(change, cross(motion.spin(frame), motion.spin(rod)))
            result.append(dot(change, along))
        return result

    def turned(self, at: Placed) -> list[Scalar]:
        """Return angles [rad] of the rods about their lines from where they settle.

        There a rod is turned from its orientation at the description's zero, as seen from its
        frame, by the least rotation that takes its line to where it is.
        """
        result = []
        for (rod, frame, line), (start, across, side) in zip(
            self._rods, self._at_zero, strict=True
        ):
            now, found = (_from(at, frame, turned(at.rotations[rod], v)) for v in (line, side))
            # A vector across the line, turned by the least rotation. At half a turn there is none;
            # nearby, the result turns fast.
            axis = cross(start, now)
            once = cross(axis, across)
            scale = greater(1.0 + dot(start, now), float(np.finfo(float).tiny))
            settled = added(added(across, once), times(cross(axis, once), 1.0 / scale))
            result.append(arctan2(dot(now, cross(settled, found)), dot(settled, found)))
        return result


def _across(line: Array) -> Array:
    """Return a unit vector `(3,)` across a line, near the axis that is farthest from it."""
    side = np.eye(3)[np.argmin(np.abs(line))]
    side -= (side @ line) * line
    return np.asarray(side / np.linalg.norm(side))


def _from(at: Placed, frame: int, vector: Vector) -> Vector:
    """Return a vector as seen from a body."""
    return vector if frame < 0 else seen(at.rotations[frame], vector)
