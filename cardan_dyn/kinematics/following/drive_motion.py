"""Drive motion: what is known of the joints that a single drive moves, wherever others are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import LARGE_BLOCK, Array, blocks, consecutive
from ...errors import AssemblyError, CardanError, SingularConfigurationError
from ...mechanism.mechanism import Mechanism
from ...problem.problem import Problem
from ...problem.samples import Targets
from ...threads import in_threads
from ..closing.all_groups import Kinematics
from ..diagnosis.mobility import STATES_STUDIED
from ..tolerances import CLOSURE_TOLERANCE
from .branch import SAMPLES_PER_CALL, TURN, TURN_PARTS, Branch

_MOST_TURNS = 1000
"""Greatest number of turns over which a drive that does not repeat is followed: each turn costs at
least eight nodes, which are followed one by one."""
_SAMPLES_PER_NODE = 8
"""Samples that have to use a branch before it gets one more node. On the bundled universal joint,
four-bar and double shaft a node took 14 to 18 µs and the Newton step that a finer branch saves took
4 to 6 µs per sample: at this rate nodes cost less than half of what steps have taken so far, and
scripts that ask for one position at a time soon have exact guesses as well."""
_MARGINS = (0.0, 1e-12, 1e-9, 1e-6)
"""Distances [rad, or lengths of the mechanism] from the ends of a drive's range from which on its
positions count as out of reach, tried one after the other, since ends are known to some digits."""


class Followed(NamedTuple):
    """What following to drive positions found.

    Attributes:
        values: whole periods `(N, 1)` to take off the positions of a single drive; or coordinates
            `(N, size)`, of which those that several drives move count, and the whole turns that
            they lack.
        is_new: whether anything was seen of the motion that was not known before.
        is_there: `(N,)` whether samples are within reach; the values of others mean nothing.
        left: `(N,)` error of the coordinates as far as a step tells, see `GroupState.left`; None
            if none was taken.
    """

    values: tuple[Array, ...]
    is_new: bool
    is_there: Array
    left: Array | None = None


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
    for part in TURN_PARTS:
        angles = angles - turns * part
    return angles


class DriveMotion:
    """The branch along one drive, followed as far as samples have asked for.

    Attributes:
        branch: it; all joints that the drive does not move stay where they start.
        groups: indices of the groups whose passives it moves.
        is_exact: guesses are so near that a large correction means another assembly mode.
    """

    is_exact = True

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        groups: list[int],
        varied: int = 0,
    ) -> None:
        """Begin at the start.

        Args:
            problem: of the scene.
            kinematics: solves the scene's groups, with all rows that open loops can reach.
            start: `(size,)` closed coordinates.
            drives: index of the drive.
            groups: see the attribute.
            varied: how many of the problem's drives, the last ones, are held joints.
        """
        (self._index,) = drives
        self._role = "held joint" if self._index >= len(problem.independent) - varied else "drive"
        self._drive = drive = problem.independent[self._index]
        self.groups = groups
        self._kinematics = kinematics.part(drives, groups)
        self._begun_at, self._kept = start, problem.mechanism.kept
        self.branch = self._begun()
        coordinates = problem.mechanism.coordinates
        self._columns = consecutive(coordinates.columns_moved_by(self._kinematics.moved))
        item = coordinates.named[drive]
        self._start = float(start[item.column])
        self._length = problem.mechanism.characteristic_length
        self._slides = item.slides
        self._turns_freely = turns_freely(problem.mechanism, drive)
        self._samples_served = 0
        self._is_studied = False

    def _begun(self) -> Branch:
        """Return the branch as it is where it begins."""
        return Branch(self._kinematics, self._begun_at, self._kept)

    @property
    def states(self) -> Array:
        """Closed coordinates `(K, size)` at positions distributed over the branch."""
        return self.branch.states()

    @property
    def amplitudes(self) -> Array:
        """States `(K, size)` that show how far joints move."""
        return self.branch.states()

    def more_states(self) -> Array:
        """Return closed coordinates `(M, size)` besides `states`, so that there are many enough."""
        states = self.states
        if len(states) >= STATES_STUDIED:
            return states[:0]
        positions = np.linspace(*self.branch.span, STATES_STUDIED)
        between = self._kinematics.close(self.branch.guess(positions))
        return between.x[between.residual < CLOSURE_TOLERANCE]

    def followed(
        self,
        targets: Targets,
        kinematics: Kinematics,
        along_path: bool = False,
        strict: bool = True,
    ) -> Followed:
        """Follow the branch to targets of the scene.

        Args:
            targets: N samples.
            kinematics: of the scene; the branch knows all rows that open loops can reach.
            along_path: for a single drive, all ways to a position are along the same branch.
            strict: whether all have to be within reach.

        Raises:
            AssemblyError, SingularConfigurationError: a position is out of reach.
        """
        span = self.branch.span
        positions = self._positions(targets)
        periods, is_there = np.zeros(len(positions)), np.ones(len(positions), dtype=bool)
        if strict:
            periods = self._cover(positions)
        else:
            is_there = self._within_reach(positions)
            if np.any(is_there):
                periods[is_there] = self._cover(positions[is_there])
        is_new = not self._is_studied or self.branch.span != span
        self._is_studied = True
        return Followed((periods[:, None],), is_new, is_there)

    def write(
        self, followed: Followed, targets: Targets, x: Array, turns: Array, kinematics: Kinematics
    ) -> None:
        """Write coordinates near closed ones, and their whole turns, into those of all joints.

        Args:
            followed: to these targets.
            targets: N samples.
            x: `(N, size)` coordinates; changed.
            turns: `(N, size)` whole turns that they lack; changed.
            kinematics: of the scene, with the rows that are known to be independent.
        """
        self._samples_served += max(targets.size, SAMPLES_PER_CALL)
        branch = self.branch
        node_limit = self._samples_served // _SAMPLES_PER_NODE
        if branch.may_refine(node_limit):
            branch.refine(kinematics.part([self._index], self.groups), node_limit)
        position, (every,) = self._positions(targets), followed.values

        def write(block: slice) -> None:
            periods = every[block]
            where, is_there = position[block], followed.is_there[block]
            if np.count_nonzero(is_there) < len(is_there):
                where = np.where(is_there, where, self._start)
            # Zeros that are never written take no memory.
            if np.count_nonzero(periods):
                where = turned_back(where, periods[:, 0], branch.period or 0.0)
                turns[block, self._columns] = periods * branch.windings[self._columns]
            x[block, self._columns] = branch.values(where, self._columns)

        in_threads(write, blocks(targets.size, LARGE_BLOCK))

    def _positions(self, targets: Targets) -> Array:
        """Return the drive's positions `(N,)` at targets of the scene."""
        drives = targets.given.shape[-1]
        if self._index < drives:
            return targets.positions[:, self._index]
        return targets.designs[:, self._index - drives][targets.design_of]

    def _cover(self, targets: Array) -> Array:
        """Follow the branch over drive positions `(N,)`.

        Returns:
            `(N,)` whole periods to subtract from the positions, so that they lie on the branch.

        Raises:
            AssemblyError, SingularConfigurationError: a position is out of reach.
        """
        try:
            return self._covered(self.branch, targets)
        except (AssemblyError, SingularConfigurationError):
            pass
        # What stops a branch, and where, depends on the steps that it took: on those of earlier
        # calls as well. What is told is what the way from the start to these positions meets.
        branch = self._begun()
        try:
            periods = self._covered(branch, targets)
        except (AssemblyError, SingularConfigurationError) as error:
            raise self._beyond(targets, error) from error
        self.branch = branch
        return periods

    def _covered(self, branch: Branch, targets: Array) -> Array:
        """See `_cover`; errors are those of the branch."""
        low, high = float(targets.min()), float(targets.max())
        # Sweeps over more than a turn look for a period.
        leaves_turn = high - low >= TURN or max(high, -low) > TURN
        is_far = self._turns_freely and leaves_turn
        turns_through = True
        if is_far and branch.period is None:
            try:
                branch.find_period()
            except (AssemblyError, SingularConfigurationError):
                turns_through = False  # The samples may lie on this side of what stops it.
        if branch.period is not None:
            return np.asarray(np.floor((targets - branch.span[0]) / branch.period))
        if is_far and turns_through and high - low > _MOST_TURNS * TURN:
            raise AssemblyError(
                f"the mechanism does not repeat within a few turns of {self._drive!r}, so "
                f"{(high - low) / TURN:.0f} turns cannot be followed; sweep over at most "
                f"{_MOST_TURNS} turns",
                position=high,
                nearest=low + _MOST_TURNS * TURN,
                residual=0.0,
                sample=int(np.argmax(targets)),
            )
        branch.cover(low, high)
        return np.zeros(len(targets))

    def _within_reach(self, targets: Array) -> Array:
        """Return `(N,)` which drive positions the branch leads to, all of them followed."""
        is_there = np.ones(len(targets), dtype=bool)
        for margin in _MARGINS:
            try:
                if np.any(is_there):
                    self._cover(targets[is_there])
                return is_there
            except (AssemblyError, SingularConfigurationError) as error:
                if error.reach is None:
                    raise
                low, high = error.reach
                unit = self._length if self._slides else 1.0
                is_there = (targets >= low + margin * unit) & (targets <= high - margin * unit)
        if np.any(is_there):
            self._cover(targets[is_there])
        return is_there

    def _beyond(
        self, targets: Array, error: AssemblyError | SingularConfigurationError
    ) -> CardanError:
        """Return the error for the first of some drive positions `(N,)` that is out of reach."""
        from .reach import Aim, nearest_of, out_of_reach, reach_of  # Only errors need it.

        if error.sample is not None:
            return error
        low, high = reach_of(self._begun(), self._start, self._slides, self._length)
        # Samples may lie beyond both ends; the error is that of one of them.
        sign = -1.0 if float(nearest_of(error)) < self._start else 1.0  # type: ignore[arg-type]
        beyond = sign * targets > sign * (low if sign < 0.0 else high)
        # An end is known to some digits only: a sample that is refused may seem to lie before it.
        sample = int(np.argmax(beyond if np.any(beyond) else sign * targets))
        who = f"{self._role} {self._drive!r} cannot be brought to"
        aim = Aim(who, float(targets[sample]), self._slides, sample)
        return out_of_reach(aim, error, (low, high))
