"""Branch: one assembly mode of the mechanism, followed along its drive.

From its start a branch leads to both sides along two `Lines`. Where their steps end are its first
nodes; between them others are put, at parts of each step, so many that one Newton step closes what
is interpolated. All of them follow from the mechanism and the start alone, whatever was asked for:
a guess is the same whenever it is asked for, and scenes whose branches begin alike share one.
"""

from __future__ import annotations

import math
import threading
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, Array, consecutive
from ....kit.errors import AssemblyError, SingularConfigurationError
from ...mechanism.kept import Kept
from ..closing.all_groups import Kinematics
from ..tolerances import MOVES
from .lines import LEAST_LEAD, Lines, Rows, quintic

_TURNS_TRIED = 12
"""Turns of the drive after which a mechanism is tried for repetition. Velocity ratios of small
whole numbers repeat within them."""
_REACH_OF_SLIDE = 10.0
"""Characteristic lengths over which a sliding drive is followed to each side of the start before
its range counts as unlimited there. A slide that loops limit moves by about the lengths of their
links."""
TURN = math.tau
"""One turn of the drive [rad]."""
_SIGNS = np.array([-1.0, 1.0])
"""Of the two sides of a start, in their order."""


class _Table(NamedTuple):
    """What a branch is interpolated by.

    Attributes:
        rows: of the K nodes in ascending order, with derivatives with respect to the drive.
        positions: `(K,)` of the drive.
        curves: polynomials `(6, K - 1, size)` between neighbouring nodes.
    """

    rows: Rows
    positions: Array
    curves: Array


class Branch:
    """One assembly mode of the mechanism, followed along its drive. Threads may share it.

    Attributes:
        kinematics: solves the branch.
        columns: of a row of coordinates that change along it, see `consecutive`.
        start: drive position where it begins.
        unit: drive displacement that counts as one radian: 1 for angles, a length for slides.
        period: drive displacement after which every body is where it was; None if not known.
        windings: `(size,)` whole turns of every coordinate in one period.
    """

    def __init__(self, kinematics: Kinematics, start: Array) -> None:
        """Make a branch that is known at one position.

        Args:
            kinematics: solves the branch; it has one drive.
            start: `(size,)` closed coordinates.
        """
        coordinates = kinematics.coordinates
        (self._column,) = coordinates.column_of(kinematics.drives).tolist()
        self.kinematics = kinematics
        self.columns = consecutive(coordinates.columns_moved_by(kinematics.moved))
        self.unit = float(coordinates.rate_scale[kinematics.drives[0]])
        self.period: float | None = None
        self.windings = np.zeros(start.size)
        self.start = float(start[self._column])
        self._start = start
        # A polynomial of the drive, which grows steeply, does not repeat: no turn is tried.
        grows = self._column in kinematics.curving_columns
        self._turns_tried = _TURNS_TRIED if grows else 0
        ends = self.start + self.unit * _SIGNS[:, None]
        self._lines = Lines(kinematics, start[None, :], [self._column], ends, leads=True)
        self._known = self._tabled(self._lines.rows.of([1]))
        # Of each side, where steps end behind what stands in the table.
        self._ahead: tuple[list[Rows], list[Rows]] = [], []
        self._lock = threading.RLock()

    @staticmethod
    def shared(kinematics: Kinematics, start: Array, kept: Kept) -> Branch:
        """Return the branch that all scenes of a mechanism have whose branches begin alike.

        Args:
            kinematics: as of `Branch`.
            start: likewise.
            kept: of the mechanism.
        """
        key = kinematics.key, start.tobytes()
        return kept.of("branch", key, lambda: Branch(kinematics, start))

    @property
    def span(self) -> tuple[float, float]:
        """Drive positions of the first and the last node."""
        low, high = self._lines.rows.x[:, self._column].tolist()
        return low, high

    def states(self, way: float, most: float = np.inf) -> Array:
        """Return closed coordinates `(K, size)` of the nodes at most so far from the start.

        The branch is followed there, as far as it leads; nodes ascend with the drive.

        Args:
            way: of the drive [rad or m].
            most: how far any joint may be from the start, too [rad, or lengths of the mechanism].
        """
        with self._lock:
            self._lead(np.full(2, np.nextafter(way / self.unit, np.inf)), most)
            rows = self._table.rows.x
        ways = np.abs(rows - self._start) * self.kinematics.coordinates.scale
        near = np.abs(rows[:, self._column] - self.start) <= way
        return np.asarray(rows[near & (np.max(ways, axis=1) <= most)])

    @property
    def _table(self) -> _Table:
        with self._lock:
            below, above = self._ahead
            if below or above:
                self._known = self._tabled(_joined(*below[::-1], self._known.rows, *above))
                self._ahead = [], []
            return self._known

    def _tabled(self, rows: Rows) -> _Table:
        """Return a table with nodes in ascending order, and others between them as needed."""
        kinematics, column = self.kinematics, self._column
        serves = np.zeros(len(rows.x), dtype=bool)  # What follows a node, as was seen between.
        while True:
            positions = rows.x[:, column].copy()
            way = np.diff(positions)
            curves = rows.of(slice(-1)).quintics(way / self.unit, rows.of(slice(1, None)))
            scale = kinematics.coordinates.scale
            # What is interpolated is off by a hundredth of the fifth coefficient at most; a step of
            # Newton's method leaves its square, which is to be rounding.
            fifth = np.max(np.abs(curves[5]) * scale, axis=1, initial=0.0) / (100.0 * EPS**0.5)
            # What does not become smaller by parts is left to whoever closes guesses.
            is_long = (fifth > 1.0) & (way > LEAST_LEAD * self.unit)
            (long,) = np.nonzero(is_long & ~serves[:-1])
            if not long.size:
                for values in rows:
                    values.setflags(write=False)
                return _Table(rows, positions, curves)
            parts = np.ceil(fifth[long] ** 0.2).astype(int)
            share = np.concatenate([np.arange(1, count) / count for count in parts.tolist()])
            behind = np.cumsum(parts - 1) - (parts - 1)
            inside = long.repeat(parts - 1)
            between = quintic(curves, inside, share)
            between[:, column] = positions[inside] + share * way[inside]
            state = kinematics.close(between)
            new = Rows.along(kinematics, state, np.full((len(inside), 1), self.unit))
            # Idle rods stay turned about their lines as they are guessed, which leaves a fifth
            # coefficient however near nodes are: what had not to be corrected serves.
            serves[long] = np.maximum.reduceat(state.correction, behind) < EPS**0.5
            rows, serves = _joined(rows, new), np.concatenate([serves, serves[inside]])
            order = np.argsort(rows.x[:, column], kind="stable")
            rows, serves = rows.of(order), serves[order]

    def cover(self, low: float, high: float) -> None:
        """Follow the branch until it leads to drive positions `low` and `high`.

        What was reached is kept when an error is raised.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        for side, (target, end) in enumerate(
            zip((low, high), self.reached(low, high), strict=True)
        ):
            if _SIGNS[side] * (target - end) > 0.0:
                from ..diagnosis.reach import beyond_branch  # Imported here: only errors need it.

                nearest, _ = self._limit_at(side)
                at_end = abs(target - nearest) < LEAST_LEAD * self.unit
                nodes = self._table.rows.x
                nodes = nodes[_SIGNS[side] * (nodes[:, self._column] - self.start) >= 0.0]
                nodes = nodes if side else nodes[::-1]
                raise beyond_branch(self.kinematics, self._column, target, nearest, nodes, at_end)

    def reached(self, low: float, high: float) -> tuple[float, float]:
        """Follow the branch towards drive positions `low` and `high` as far as it leads.

        Positions between the last node and a dead point lie on the branch as well.

        Returns:
            Where it ends on either side; ±inf where it leads as far as was asked for.
        """
        # Nodes lie beyond, so that what lies between two of them does not depend on what was asked.
        ways = np.array([self.start - low, high - self.start]) / self.unit
        until = np.where(ways > 0.0, np.nextafter(ways, np.inf), -1.0)
        ends = _SIGNS * np.inf
        with self._lock:
            self._lead(until)
            for side in (self._lines.share < until).nonzero()[0].tolist():
                limit, is_dead_point = self._limit_at(side)
                ends[side] = self.span[side]
                if is_dead_point:
                    before = limit - _SIGNS[side] * LEAST_LEAD * self.unit
                    ends[side] = sorted((before, ends[side]))[side]
        return float(ends[0]), float(ends[1])

    def _lead(self, until: Array, most: float = np.inf) -> None:
        """Follow both sides to shares `(2,)`, or `most`, or beyond; note where steps end."""
        while (going := self._lines.going(until, most)).size:
            for side in self._lines.advance(going).tolist():
                row = self._lines.rows.of([side])
                self._ahead[side].append(row._replace(first=_SIGNS[side] * row.first))

    def _limit_at(self, side: int) -> tuple[float, bool]:
        """Return the drive position at which a side ends, and whether that is a dead point.

        Near a dead point passive joints move like the square root of the distance that remains,
        which gives that distance from the first two derivatives. Where assembly modes meet, the
        margin falls to zero in proportion to it; near a dead point that tells of a farther place.
        """
        lines, scale = self._lines, self.kinematics.coordinates.scale
        slope, half_curvature = (values[side] * scale for values in lines.rows[1:])
        steepest = int(np.argmax(np.abs(slope)))
        # A steep curve without curvature leads to no limit; its quotient, an infinity, is refused.
        with np.errstate(all="ignore"):
            of_root = float(slope[steepest] / (4.0 * half_curvature[steepest]))
        is_dead_point = 0.0 < of_root < lines.left[side]
        remaining = of_root if is_dead_point else float(lines.left[side])
        # The last steps before a limit are far shorter, so one that lies farther away than the root
        # of the shortest step is a wrong estimate.
        if not remaining < EPS**0.25:
            remaining, is_dead_point = 0.0, False
        position = self.span[side]
        return float(position + _SIGNS[side] * remaining * self.unit), is_dead_point

    def find_period(self, within: float = np.inf) -> bool:
        """Follow the branch over whole turns of the drive until it repeats, if it does.

        Args:
            within: half of a period that counts is less [rad].

        Returns:
            Whether it repeats; `period` and `windings` are set then.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        with self._lock:
            while self.period is None and self._turns_tried < _TURNS_TRIED:
                half = 0.5 * TURN * (self._turns_tried + 1)
                if half >= within:
                    break
                ends = self.start + half * _SIGNS
                self.cover(*ends.tolist())
                closed = self.kinematics.close(self.guess(ends)).x
                is_back, windings = whole_turns(self.kinematics, closed[:1], closed[1:])
                self._turns_tried += 1
                if is_back[0]:
                    self.period, self.windings = 2.0 * half, windings[0]
                elif np.any(windings[:, self.kinematics.curving_columns]):
                    self._turns_tried = _TURNS_TRIED  # Nor does a polynomial of what goes round.
            return self.period is not None

    def at(self, position: float) -> Array:
        """Return closed coordinates `(size,)` at a drive position; errors as of `cover`."""
        self.cover(position, position)
        closed: Array = self.kinematics.close(self.guess(np.array([position]))).x[0]
        return closed

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Args:
            positions: `(N,)` drive positions that it was followed to.
        """
        rows = self.values(positions, slice(None))
        rows[:, self._column] = positions
        return self.kinematics.coordinates.normalised(rows)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch; see `guess`.

        Args:
            positions: `(N,)` drive positions.
            columns: of a row; quaternions come without their unit length.
        """
        table = self._table
        if len(table.positions) == 1:
            return np.repeat(table.rows.x[:, columns], len(positions), axis=0)
        left = table.positions[1:-1].searchsorted(positions, side="right")
        low, high = table.positions[left], table.positions[left + 1]
        # What little there is between the last node and a dead point is closed from that node.
        share = ((positions - low) / (high - low)).clip(0.0, 1.0)
        return quintic(table.curves[:, :, columns], left, share)

    @cached_property
    def reach(self) -> tuple[float, float]:
        """The limits of the drive [rad or m], ±inf where it has none."""
        way = _REACH_OF_SLIDE * self.unit
        if self._column in self.kinematics.coordinates.angle_columns:
            try:
                if self.find_period():
                    return -np.inf, np.inf
            except (AssemblyError, SingularConfigurationError):
                pass  # It does not turn through; the limits say how far it goes.
            # Limits lie within a turn of each other, and the start less than a turn from them.
            way = 2.0 * TURN
        return self.limit(self.start - way), self.limit(self.start + way)

    def limit(self, target: float) -> float:
        """Return how far towards `target` the branch can be followed from its start.

        Args:
            target: drive position, not that of the start.

        Returns:
            The drive position where the branch ends; ±inf, with the sign of the direction from the
            start, if it leads all the way.
        """
        side = int(target > self.start)
        if _SIGNS[side] * (target - self.reached(target, target)[side]) > 0.0:
            return self._limit_at(side)[0]
        return float(_SIGNS[side] * np.inf)


def whole_turns(kinematics: Kinematics, first: Array, last: Array) -> tuple[Array, Array]:
    """Return `(N,)` whether rows are the same but for whole turns, and these turns `(N, size)`."""
    layout, windings = kinematics.coordinates, np.zeros_like(first)
    angles = layout.angle_columns
    windings[:, angles] = np.rint((last - first)[:, angles] / TURN)
    missed = np.abs(last - first - TURN * windings) * layout.scale
    for column in layout.balls.columns.tolist():
        # A quaternion and its negative are the same rotation.
        ball = slice(column, column + 4)
        missed[:, ball] = np.minimum(missed[:, ball], np.abs(last + first)[:, ball])
    # How far idle rods have turned about their lines says nothing about the motion.
    missed[:, kinematics.idle_columns] = 0.0
    is_back = np.max(missed, axis=1, initial=0.0) < MOVES
    return is_back & ~np.any(windings[:, kinematics.curving_columns], axis=1), windings


def _joined(*rows: Rows) -> Rows:
    """Return rows one behind the other."""
    return Rows(*map(np.concatenate, zip(*rows, strict=True)))
