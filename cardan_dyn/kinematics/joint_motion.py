"""Joint motion: what is known of the joints that several drives move together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, SingularConfigurationError
from ..problem.problem import Problem
from .all_groups import Kinematics
from .drive_motion import TURN, Followed, turns_freely
from .following import beyond_reach, follow
from .lattice import near_lattice, spacing_for
from .loop_system import LoopSystem
from .redundancy import STATES_STUDIED
from .straight_lines import Reached, along_lines
from .tolerances import CLOSURE_TOLERANCE


class _Turn(NamedTuple):
    """How a mechanism comes back to itself when a drive turns while the others rest at the start.

    Attributes:
        period: displacement of the drive [rad].
        windings: `(size,)` whole turns of all coordinates meanwhile.
    """

    period: float
    windings: Array


class JointMotion:
    """The motion of what several drives move together.

    The configuration at drive positions is the one to which the straight line of drive positions
    leads from the start. Before that, whole turns are taken off the drives that bring the mechanism
    back to itself when they turn alone, from the start.

    Attributes:
        groups: indices of the groups whose passives they move.
        states: closed coordinates `(K, size)` of some of the last positions.
        is_exact: see `DriveMotion`.
    """

    is_exact = False

    def __init__(
        self,
        problem: Problem,
        system: LoopSystem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        groups: list[int],
    ) -> None:
        """Begin at the start; arguments as of `DriveMotion`, with several drives."""
        self.groups = groups
        self.states = start[None, :]
        self._drives = drives
        self._names = tuple(problem.drives[index] for index in drives)
        self._kinematics = kinematics.part(drives, groups)
        self._start = start
        coordinates = problem.mechanism.coordinates
        self._drive_columns = coordinates.columns_of(self._names)
        self._columns = coordinates.columns_moved_by(self._kinematics.moved)
        # A slide counts as one radian when it moves by the mechanism's length.
        self._units = 1.0 / coordinates.scale[self._drive_columns]
        self._system = system
        self._turning = [
            index for index, name in enumerate(self._names) if turns_freely(problem.mechanism, name)
        ]
        self._turns: dict[int, _Turn | None] = {}

    @property
    def amplitudes(self) -> Array | None:
        """None: how far joints move is not known."""
        return None

    def more_states(self) -> Array:
        """Return no states `(0, size)` besides those that were followed."""
        return self.states[:0]

    def followed(self, positions: Array, along_path: bool = False) -> Followed:
        """Follow the motion to drive positions `(N, d)`, of all drives of the scene.

        Args:
            positions: [rad or m].
            along_path: whether every sample is followed from the one before it.

        Raises:
            AssemblyError: a position is out of reach.
        """
        own = positions[:, self._drives]
        turns = np.zeros((len(own), self._start.size))
        try:
            if along_path:
                x = follow(self._kinematics, self._start, self._drive_columns, own)
            else:
                x = self._along_lines(own, turns)
        except AssemblyError as error:
            from .reach import all_out_of_reach  # Imported here: only errors need it.

            raise all_out_of_reach(self._names, own, error) from error
        some = self._kinematics.close(x[:: 1 + len(x) // STATES_STUDIED])
        self.states = some.x[some.residual < CLOSURE_TOLERANCE]
        return Followed(np.stack([x, turns])[:, :, self._columns], True)

    def _along_lines(self, own: Array, turns: Array) -> Array:
        """Return closed coordinates `(N, size)` at positions `(N, d)` of these drives.

        Args:
            own: the positions.
            turns: `(N, size)` whole turns that the coordinates lack; changed.
        """
        asked, own = own, own.copy()
        for index in self._turning:
            column = self._drive_columns[index]
            ahead = own[:, index] - self._start[column]
            if not np.any(np.abs(ahead) > TURN):
                continue
            if index not in self._turns:
                self._turns[index] = self._turn_of(index)
            turn = self._turns[index]
            if turn is not None:
                periods = np.trunc(ahead / turn.period)
                own[:, index] -= periods * turn.period
                turns += periods[:, None] * turn.windings
        x = self._near_lattices(own)
        rest = np.nonzero(np.isnan(x[:, self._drive_columns[0]]))[0]
        reached = along_lines(self._kinematics, self._start, self._drive_columns, own[rest])
        if not np.all(reached.is_there):
            raise self._beyond(asked, own, rest, reached)
        x[rest] = reached.x
        return x

    def _turn_of(self, index: int) -> _Turn | None:
        """Return how the mechanism comes back to itself with a drive, None if it does not."""
        kinematics = self._kinematics.part([index], list(range(len(self.groups))))
        branch = self._system.branch(self._names[index], kinematics, self._start)
        try:
            branch.find_period()
        except (AssemblyError, SingularConfigurationError):
            return None
        return None if branch.period is None else _Turn(branch.period, branch.windings)

    def _beyond(self, asked: Array, own: Array, rest: Array, reached: Reached) -> AssemblyError:
        """Return the error for samples that straight lines do not reach.

        Args:
            asked: `(N, d)` positions.
            own: the same without whole turns.
            rest: samples whose lines were followed.
            reached: how far.
        """
        first, more = int(np.argmin(reached.is_there)), int(np.sum(~reached.is_there)) - 1
        sample, nearest = int(rest[first]), reached.x[first].copy()
        nearest[self._drive_columns] += asked[sample] - own[sample]
        error = beyond_reach(
            self._kinematics,
            self._drive_columns,
            asked[sample],
            nearest,
            reached.residual[first],
            sample,
        )
        if more:
            error.hint += f"; {more} other sample{'s are' if more > 1 else ' is'} out of reach too"
        return error

    def _near_lattices(self, own: Array) -> Array:
        """Return coordinates `(N, size)` near closed ones where lattices serve, NaN elsewhere.

        Args:
            own: `(N, d)` positions of these drives.
        """
        x = np.full((len(own), self._start.size), np.nan)
        rest, spacing = np.arange(len(own)), np.inf
        ahead = (own - self._start[self._drive_columns]) / self._units
        while rest.size and (found := spacing_for(ahead[rest], spacing)) is not None:
            spacing = found
            near = near_lattice(
                self._kinematics,
                self._start,
                self._drive_columns,
                own[rest],
                spacing * self._units,
            )
            x[rest[near.is_there]] = near.x[near.is_there]
            rest = rest[~near.is_there]
        return x

    def write(
        self, followed: Followed, positions: Array, x: Array, turns: Array, kinematics: Kinematics
    ) -> None:
        """Write closed coordinates into those of all joints, see `DriveMotion.write`."""
        x[:, self._columns], turns[:, self._columns] = followed.values
