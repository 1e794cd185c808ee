"""Drive motion: what is known of the joints that a single drive moves, wherever others are."""

from __future__ import annotations

import numpy as np

from ....kit.arrays import LARGE_BLOCK, Array, blocks
from ....kit.errors import AssemblyError, CardanError, SingularConfigurationError
from ....kit.threads import in_threads
from ...mechanism.mechanism import Mechanism
from ...problem.problem import Problem
from ..closing.all_groups import Kinematics
from .branch import TURN, Branch

MOST_TURNS = 1000
"""Greatest number of turns over which a drive that does not repeat is followed: each turn costs at
least eight nodes, which are followed one by one."""
_TURN_PARTS = 6.28125, float.fromhex("0x1.fb54442dp-10"), 2.1561211432632476e-14
"""One turn as a sum of parts: whole multiples of the first two are exact up to a million."""


def turns_freely(mechanism: Mechanism, drive: str) -> bool:
    """Return whether a drive may turn without limits of its own."""
    item = mechanism.coordinates.named[drive]
    # URDF's `revolute` joints have limits; no other type that turns has.
    return not item.slides and mechanism.joints[item.joint].type != "revolute"


def turned_back(angles: Array, periods: Array, period: Array | float) -> Array:
    """Return angles less whole periods, exact but for the rounding of what is left.

    After a hundred turns, the rounding of a product would be 1e-13 rad, a thousand times as much
    as that of the guess at the angle that is left.

    Args:
        angles: `(N,)` [rad].
        periods: how many to take off each `(N,)`.
        period: of all or of each, whole turns [rad].
    """
    turns = periods * np.rint(period / TURN)
    if not np.count_nonzero(turns):
        return angles
    for part in _TURN_PARTS:
        angles = angles - turns * part
    return angles


class DriveMotion:
    """The branch along one drive, followed as far as samples have asked for.

    Attributes:
        branch: it; all joints that the drive does not move stay where they start.
    """

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        varied: int = 0,
    ) -> None:
        """Begin at the start.

        Args:
            problem: of the scene.
            kinematics: of the drive and the groups that it moves, with all rows that open loops can
                reach.
            start: `(size,)` closed coordinates.
            drives: index of the drive.
            varied: how many of the problem's drives, the last ones, are held joints.
        """
        (self._index,) = drives
        self._role = "held joint" if self._index >= len(problem.independent) - varied else "drive"
        self._drive, self._mechanism = problem.independent[self._index], problem.mechanism
        self.branch = Branch.shared(kinematics, start, problem.mechanism.kept)
        self._start = self.branch.start

    def write(
        self,
        prescribed: Array,
        x: Array,
        turns: Array,
        along_path: bool = False,
        strict: bool = True,
    ) -> Array:
        """Follow the branch to positions of the scene's drives, and write what it moves.

        Args:
            prescribed: `(N, d)` positions of the scene's drives [rad or m].
            x: `(N, size)` coordinates near closed ones; changed.
            turns: `(N, size)` whole turns that they lack; changed.
            along_path: for a single drive, all ways to a position are along the same branch.
            strict: whether all have to be within reach.

        Returns:
            `(N,)` which samples are within reach; the coordinates of others mean nothing.

        Raises:
            AssemblyError, SingularConfigurationError: a position is out of reach.
        """
        branch, positions = self.branch, prescribed[:, self._index]
        low, high = float(positions.min()), float(positions.max())
        period = self._period(positions, low, high)
        periods, is_there = np.zeros(len(positions)), np.ones(len(positions), dtype=bool)
        if period is not None:
            periods = np.floor((positions - self._start) / period + 0.5)
        elif strict:
            try:
                branch.cover(low, high)
            except (AssemblyError, SingularConfigurationError) as error:
                raise self._beyond(positions, error) from error
        else:
            low, high = branch.reached(low, high)
            is_there = (low <= positions) & (positions <= high)
            positions = np.where(is_there, positions, self._start)
        columns = branch.columns

        def write(block: slice) -> None:
            where, every = positions[block], periods[block]
            # Zeros that are never written take no memory.
            if np.count_nonzero(every):
                where = turned_back(where, every, branch.period or 0.0)
                turns[block, columns] = every[:, None] * branch.windings[columns]
            x[block, columns] = branch.values(where, columns)

        in_threads(write, blocks(len(positions), LARGE_BLOCK))
        return is_there

    def _period(self, positions: Array, low: float, high: float) -> float | None:
        """Return the period by which drive positions are turned back; None if by none.

        Args:
            positions: `(N,)`.
            low: the least of them.
            high: the greatest of them.

        Raises:
            AssemblyError: positions lie very many turns away, and the mechanism does not repeat.
        """
        if not turns_freely(self._mechanism, self._drive):
            return None
        farthest = high if high - self._start > self._start - low else low
        ahead = abs(farthest - self._start)
        try:
            # Positions that are nearer to the start than half a period are taken as they are.
            repeats = self.branch.find_period(ahead)
        except (AssemblyError, SingularConfigurationError):
            return None  # The samples may lie on this side of what stops it.
        if repeats:
            return self.branch.period
        if ahead > MOST_TURNS * TURN:
            raise AssemblyError(
                f"the mechanism does not repeat within a few turns of {self._drive!r}, so "
                f"{ahead / TURN:.0f} turns cannot be followed; sweep over at most "
                f"{MOST_TURNS} turns",
                position=farthest,
                nearest=self._start + float(np.copysign(MOST_TURNS * TURN, farthest)),
                residual=0.0,
                sample=int(np.argmax(positions == farthest)),
            )
        return None

    def _beyond(
        self, targets: Array, error: AssemblyError | SingularConfigurationError
    ) -> CardanError:
        """Return the error for the first of some drive positions `(N,)` that is out of reach."""
        from ..diagnosis.reach import nearest_of, out_of_reach  # Only errors need it.

        low, high = self.branch.reach
        # Samples may lie beyond both ends; the error is that of one of them.
        sign = -1.0 if nearest_of(error) < self._start else 1.0
        beyond = sign * targets > sign * (low if sign < 0.0 else high)
        # An end is known to some digits only: a sample that is refused may seem to lie before it.
        sample = int(np.argmax(beyond if np.any(beyond) else sign * targets))
        slides = self._mechanism.coordinates.named[self._drive].slides
        asked = self._role, self._drive, float(targets[sample]), slides
        return out_of_reach(*asked, error, sample, (low, high))
