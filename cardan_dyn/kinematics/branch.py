"""Branch: one assembly mode of the mechanism, followed along its drive.

A branch keeps closed positions with their first and second derivatives as nodes and interpolates
between them. Its guesses are so near that Newton's method cannot change the assembly mode.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, SingularConfigurationError
from .all_groups import Kinematics
from .branch_end import LOWER, UPPER
from .branch_follower import BranchFollower
from .branch_refinement import EXACT_CORRECTION, SAFE_GUESS_CORRECTION, halved
from .branch_table import table_of
from .correctors import FullClosure, OneNewtonStep, proven

_UNLIMITED = 2**62
"""More nodes than a scene ever asks for: guesses are exact to rounding, and no node is missing."""
_TURNS_TRIED = 12
"""Turns of the drive after which a mechanism is tried for repetition. Velocity ratios of small
whole numbers repeat within them. A turn costs 11 to 13 nodes, measured on the bundled universal
joint, four-bar, needle drive and double shaft."""
_PERIOD_TOLERANCE = 1e-7
"""Greatest difference [rad or m] between coordinates one period apart. It is far above the closure
tolerance, and far below any motion that a mechanism would miss its start by on purpose."""


class Branch:
    """One assembly mode of the mechanism, followed along its drive.

    Attributes:
        kinematics: solves the branch.
        unit: drive displacement that counts as one radian: 1 for angles, a length for slides.
        period: drive displacement after which every body is where it was; None if not known.
        windings: `(size,)` whole turns of every coordinate in one period.
    """

    def __init__(
        self, kinematics: Kinematics, start: Array, drive_column: int, unit: float
    ) -> None:
        """Make a branch that is known at one position.

        Args:
            kinematics: solves the branch; it has one drive.
            start: `(size,)` closed coordinates.
            drive_column: column of the drive in a row of coordinates.
            unit: see the attribute.
        """
        self.kinematics = kinematics
        self.unit = unit
        self.period: float | None = None
        self.windings = np.zeros(start.size)
        self._start = float(start[drive_column])
        self._table = table_of(kinematics, kinematics.evaluate(start[None, :]), drive_column)
        self._states_of, self._states = self._table, self._table.states
        self._ends = (LOWER, UPPER)
        # Number of nodes that it was last refined to; zero while guesses need not be safe.
        self._refined_to = 0

    @property
    def span(self) -> tuple[float, float]:
        """Drive positions between which the branch is known."""
        return self._table.span

    def cover(self, low: float, high: float) -> None:
        """Follow the branch until it spans drive positions `low` to `high`.

        What was reached is kept when an error is raised, and so is the error: another attempt
        from nearer by could step over what has stopped this one.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        known_low, known_high = self.span
        if low >= known_low and high <= known_high:
            return
        for end, target in zip(self._ends, (low, high), strict=True):
            if end.error is not None and end.is_before(target, self._table):
                raise copy(end.error)
        was_safe = self._refined_to > 0 or self._table.size == 1
        self._refined_to = 0
        quick = BranchFollower(self.kinematics, self.unit, OneNewtonStep())
        followed = quick.follow(self._table, low, high)
        if followed.refused is None:
            table = proven(self.kinematics, followed.table, known_low, known_high)
            if table is not None:
                self._table = table
                self._refined_to = table.size if was_safe else 0
                return
        careful = BranchFollower(self.kinematics, self.unit, FullClosure())
        self._table, refused = careful.follow(self._table, low, high)
        if refused is not None and refused.error is not None:
            lower, upper = self._ends
            self._ends = (refused, upper) if refused.node == LOWER.node else (lower, refused)
            raise copy(refused.error)

    def find_period(self) -> bool:
        """Follow the branch over whole turns of the drive until it repeats, if it does.

        Returns:
            Whether it repeats; `period` and `windings` are set then.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        for turns in range(1, _TURNS_TRIED + 1):
            period = turns * 2.0 * np.pi
            low, high = self.span
            missing = period - (high - low)
            if missing > 0.0:
                self.cover(low - 0.5 * missing, high + 0.5 * missing)
            low = self.span[0]
            ends = self.guess(np.array([low, low + period]))
            if missing < 0.0:
                # The second position lies between nodes, where a guess is not closed.
                ends = self.kinematics.close(ends).x
            displacement = ends[1] - ends[0]
            # How far idle rods have turned about their lines says nothing about the motion.
            displacement[self.kinematics.idle_columns] = 0.0
            windings = np.zeros(displacement.size)
            angles = self.kinematics.coordinates.angle_columns
            windings[angles] = np.round(displacement[angles] / (2.0 * np.pi))
            whole_turns = 2.0 * np.pi * windings
            if np.allclose(displacement, whole_turns, rtol=0.0, atol=_PERIOD_TOLERANCE):
                self.period, self.windings = period, windings
                return True
        return False

    def refine(self, kinematics: Kinematics, node_limit: int) -> None:
        """Halve intervals until guesses are exact to rounding, or there are `node_limit` nodes.

        Guesses are made safe in any case, even with more nodes. Nothing is done before the limit
        has doubled since the last call: every call tries each interval again.

        Args:
            kinematics: with the rows that are known to be independent.
            node_limit: number of nodes from which on safe guesses suffice.

        Raises:
            SingularConfigurationError: the branch cannot be resolved.
        """
        if node_limit < 2 * self._refined_to:
            return
        self._refined_to = node_limit
        is_open = np.ones(self._table.size - 1, dtype=bool)
        while np.any(is_open):
            to_rounding = self._table.size < node_limit
            allowed = EXACT_CORRECTION if to_rounding else SAFE_GUESS_CORRECTION
            self._table, is_open = halved(self._table, kinematics, is_open, allowed)
            if to_rounding and not np.any(is_open):
                self._refined_to = _UNLIMITED

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Args:
            positions: `(N,)` drive positions within the span.
        """
        return self._table.guess(positions)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch, see `BranchTable.values`."""
        return self._table.values(positions, columns)

    def states(self) -> Array:
        """Return closed coordinates `(K, size)` at positions distributed over the branch.

        They are the same object until the branch gets other nodes.
        """
        if self._states_of is not self._table:
            self._states_of, self._states = self._table, self._table.states
        return self._states

    def limit(self, target: float) -> float:
        """Return how far towards `target` the branch can be followed from its start.

        Args:
            target: drive position, not that of the start.

        Returns:
            The drive position where the branch ends; ±inf, with the sign of the direction from the
            start, if it leads all the way.
        """
        try:
            self.cover(min(target, self.span[0]), max(target, self.span[1]))
        except AssemblyError as error:
            return float(error.details["nearest"])  # type: ignore[arg-type]
        except SingularConfigurationError as error:
            return float(error.details["position"])  # type: ignore[arg-type]
        return float(np.copysign(np.inf, target - self._start))
