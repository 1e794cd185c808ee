"""Guess cache: coordinates near closed ones, from what earlier calls learned about the motion."""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, CardanError, SingularConfigurationError
from ..problem.problem import Problem
from .all_groups import Kinematics
from .branch import Branch
from .following import follow
from .loop_system import LoopSystem
from .redundancy import STATES_STUDIED, Redundancy, RedundancyStudy

_MOST_TURNS = 1000
"""Greatest number of turns over which a drive that does not repeat is followed: each turn costs at
least eight nodes, which are followed one by one."""
_SAMPLES_PER_NODE = 24
"""Samples that have to use a branch before it gets one more node. On the bundled universal joint,
four-bar and double shaft a node took 14 to 18 µs and the Newton step that a finer branch saves took
4 to 6 µs per sample: at this rate nodes cost less than a fifth of what they can save."""
_TURN = 2.0 * np.pi
"""One turn of the drive [rad]. Sweeps over more than that look for a period."""


class Guess(NamedTuple):
    """Coordinates near closed ones of N samples, and what closes them.

    Attributes:
        x: `(N, size)` coordinates, exact in the drives.
        turns: `(N, size)` whole turns that have to be added to the angles in `x`.
        kinematics: solves the rows that are known to be independent.
        followed: whether `x` lies on a branch, so that a large correction means another mode.
    """

    x: Array
    turns: Array
    kinematics: Kinematics
    followed: bool

    def block(self, samples: slice) -> Guess:
        """Return the guess of some samples."""
        return Guess(self.x[samples], self.turns[samples], self.kinematics, self.followed)


class GuessCache:
    """Keeps what was learned about the motion of a scene for later calls.

    Threads may share it: they learn one after the other, and results that a thread holds do not
    change.

    Attributes:
        start: `(size,)` closed coordinates at which the drives start.
    """

    def __init__(
        self,
        problem: Problem,
        system: LoopSystem,
        study: RedundancyStudy,
        start: Array,
        redundancy: Redundancy,
        motionless: bool,
    ) -> None:
        """Make the cache.

        Args:
            problem: the drives, loads and wanted outputs of the scene.
            system: its loops.
            study: finds redundant rows.
            start: see the attribute.
            redundancy: redundant rows as known at the start.
            motionless: whether no passive joint is solved, so that nothing has to be learned.
        """
        self.start = start
        self._drives = problem.drives
        self._system = system
        self._study = study
        self._redundancy = redundancy
        self._motionless = motionless
        coordinates = problem.mechanism.coordinates
        self._size = coordinates.size
        self._columns = coordinates.columns_of(problem.drives)
        drive = coordinates.named[problem.drives[0]]
        self._length = problem.mechanism.characteristic_length
        self._slides = drive.slides
        # URDF's `revolute` joints have limits; no other type that turns has.
        is_limited = problem.mechanism.joints[drive.joint].type == "revolute"
        self._turns_freely = not (drive.slides or is_limited)
        self._branch: Branch | None = None
        self._samples_served = 0
        self._lock = threading.RLock()

    @property
    def kinematics(self) -> Kinematics:
        """Solves the rows that are known to be independent so far."""
        return self._redundancy.kinematics

    def guesses(self, positions: Array) -> Guess:
        """Return coordinates near closed ones for drive positions `(N, d)` [rad or m].

        Raises:
            AssemblyError: a position cannot be reached.
            MobilityError: the drives do not decide the motion.
            SingularConfigurationError: a dead point lies on the way.
        """
        with self._lock:
            if self._motionless:
                return self._at_start(positions)
            if len(self._drives) > 1:
                return self._followed(positions)
            return self._interpolated(positions)

    def period(self) -> float | None:
        """Return the drive displacement [rad] after which the motion repeats, None if it does not.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        with self._lock:
            branch = self._get_branch()
            if branch.period is None:
                branch.find_period()
                self._learn(branch.states(), branch)
            return branch.period

    def _at_start(self, positions: Array) -> Guess:
        x = np.repeat(self.start[None, :], len(positions), axis=0)
        x[:, self._columns] = positions
        return Guess(x, np.zeros_like(x), self.kinematics, False)

    def _followed(self, positions: Array) -> Guess:
        """Return guesses for several drives, followed from sample to sample."""
        try:
            x = follow(self._study.open_kinematics, self.start, self._columns, positions)
        except AssemblyError as error:
            from .reach import all_out_of_reach  # Imported here: only errors need it.

            raise all_out_of_reach(self._drives, positions, error) from error
        self._learn(x[:: 1 + len(x) // STATES_STUDIED])
        return Guess(x, np.zeros_like(x), self.kinematics, False)

    def _interpolated(self, positions: Array) -> Guess:
        """Return guesses for one drive, interpolated on its branch."""
        known_span = self._branch.span if self._branch else None
        branch = self._get_branch()
        targets = positions[:, 0]
        periods = self._cover(branch, targets)
        if branch.span != known_span:
            self._learn(branch.states(), branch)
        self._samples_served += len(positions)
        branch.refine(self.kinematics, node_limit=self._samples_served // _SAMPLES_PER_NODE)
        x = branch.guess(targets - periods * (branch.period or 0.0))
        x[:, self._columns] = positions
        turns = periods[:, None] * branch.windings
        turns[:, self._columns] = 0.0
        return Guess(x, turns, self.kinematics.with_amplitudes(branch.states()), True)

    def _get_branch(self) -> Branch:
        """Return the branch of the only drive, made by the first call."""
        if self._branch is None:
            kinematics = self._study.open_kinematics
            self._branch = self._system.branch(self._drives[0], kinematics, self.start)
        return self._branch

    def _cover(self, branch: Branch, targets: Array) -> Array:
        """Follow the branch over drive positions `(N,)`.

        Returns:
            `(N,)` whole periods to subtract from the positions, so that they lie on the branch.

        Raises:
            AssemblyError, SingularConfigurationError: a position is out of reach.
        """
        low, high = float(np.min(targets)), float(np.max(targets))
        leaves_turn = high - low >= _TURN or max(high, -low) > _TURN
        is_far = self._turns_freely and leaves_turn
        turns_through = True
        if is_far and branch.period is None:
            try:
                branch.find_period()
            except (AssemblyError, SingularConfigurationError):
                turns_through = False  # The samples may lie on this side of what stops it.
        if branch.period is not None:
            return np.asarray(np.floor((targets - branch.span[0]) / branch.period))
        if is_far and turns_through and high - low > _MOST_TURNS * _TURN:
            raise AssemblyError(
                f"the mechanism does not repeat within a few turns of {self._drives[0]!r}, so "
                f"{(high - low) / _TURN:.0f} turns cannot be followed; sweep over at most "
                f"{_MOST_TURNS} turns",
                position=high,
                nearest=branch.span[1],
                residual=0.0,
                sample=int(np.argmax(targets)),
            )
        try:
            branch.cover(low, high)
        except (AssemblyError, SingularConfigurationError) as error:
            raise self._beyond(branch, targets, error) from error
        return np.zeros(len(targets))

    def _beyond(self, branch: Branch, targets: Array, error: CardanError) -> CardanError:
        """Return the error for the first of some drive positions `(N,)` that is out of reach."""
        from .reach import Aim, out_of_reach, reach_of  # Imported here: only errors need it.

        start = float(self.start[self._columns[0]])
        low, high = reach_of(branch, start, self._slides, self._length)
        nearest = error.details["nearest" if isinstance(error, AssemblyError) else "position"]
        # Samples may lie beyond both ends; the error is that of one of them.
        sign = -1.0 if nearest < start else 1.0  # type: ignore[operator]
        beyond = sign * targets > sign * (low if sign < 0.0 else high)
        # An end is known to some digits only: a sample that is refused may seem to lie before it.
        sample = int(np.argmax(beyond if np.any(beyond) else sign * targets))
        who = f"drive {self._drives[0]!r} cannot be brought to"
        aim = Aim(who, float(targets[sample]), self._slides, sample)
        return out_of_reach(aim, error, (low, high))

    def _learn(self, states: Array, branch: Branch | None = None) -> None:
        """Find redundant rows from closed states `(K, size)`, unless no state can add to them."""
        if not self._redundancy.settled:
            self._redundancy = self._study.of_states(states, branch)
