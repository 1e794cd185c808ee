"""Guess cache: coordinates near closed ones, from what is known of the motion, and learned once."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError
from ..problem.problem import Problem
from .all_groups import Kinematics
from .branch import Branch
from .following import follow
from .loop_system import LoopSystem
from .redundancy import STATES_STUDIED, Redundancy, RedundancyStudy

_MOST_TURNS = 1000
"""Turns of a drive that does not come back to itself: 16 nodes each, followed one by one."""
_SAMPLES_PER_NODE = 24
"""Samples that have to use a branch before it gets a node more: a node costs some 20 times as much
as the Newton step that it saves a sample."""


@dataclass(frozen=True, eq=False, repr=False)
class Guess:
    """Coordinates near closed ones, and what closes them.

    Attributes:
        x: `(N, size)` coordinates, exact in the drives.
        turns: `(N, size)` whole turns that their angles lack.
        kinematics: solves the rows that are known to be independent.
        followed: whether they lie on a branch that was followed before.
    """

    x: Array
    turns: Array
    kinematics: Kinematics
    followed: bool

    def __getitem__(self, samples: slice) -> Guess:
        return Guess(self.x[samples], self.turns[samples], self.kinematics, self.followed)


class GuessCache:
    """What was learned about the motion of a scene, kept for later calls.

    Calls from several threads learn one after the other, and none changes what another one has got.

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
            problem: what is solved.
            system: its loops.
            study: finds redundant rows.
            start: see the attribute.
            redundancy: what is known at the start.
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
        self._columns = [coordinates.columns[name].start for name in problem.drives]
        self._turns_freely = problem.mechanism.joints[problem.drives[0]].type == "continuous"
        self._branch: Branch | None = None
        self._samples_served = 0
        self._lock = threading.RLock()

    @property
    def kinematics(self) -> Kinematics:
        """Solves the rows that are known to be independent by now."""
        return self._redundancy.kinematics

    def guesses(self, positions: Array) -> Guess:
        """Return coordinates near closed ones for drive positions `(N, d)`.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        with self._lock:
            if self._motionless:
                return self._at_start(positions)
            if len(self._drives) > 1:
                return self._followed(positions)
            return self._interpolated(positions)

    def period(self) -> float | None:
        """Return the displacement after which the only drive is back where it was, if it is."""
        with self._lock:
            branch = self._own_branch()
            if branch.period is None:
                branch.find_period()
                self._learn(branch.states(), branch)
            return branch.period

    def _at_start(self, positions: Array) -> Guess:
        x = np.repeat(self.start[None, :], len(positions), axis=0)
        x[:, self._columns] = positions
        return Guess(x, np.zeros_like(x), self.kinematics, False)

    def _followed(self, positions: Array) -> Guess:
        """Follow several drives from sample to sample."""
        x = follow(self._study.open_kinematics, self.start, self._columns, positions)
        self._learn(x[:: 1 + len(x) // STATES_STUDIED])
        return Guess(x, np.zeros_like(x), self.kinematics, False)

    def _interpolated(self, positions: Array) -> Guess:
        """Interpolate along the branch of one drive."""
        known = self._branch.span if self._branch else None
        branch = self._own_branch()
        wanted = positions[:, 0]
        periods = self._covered(branch, wanted)
        if branch.span != known:
            self._learn(branch.states(), branch)
        self._samples_served += len(positions)
        branch.refine(self.kinematics, node_limit=self._samples_served // _SAMPLES_PER_NODE)
        x = branch.guess(wanted - periods * (branch.period or 0.0))
        x[:, self._columns] = positions
        turns = periods[:, None] * branch.windings
        turns[:, self._columns] = 0.0
        return Guess(x, turns, self.kinematics.with_amplitudes(branch.states()), True)

    def _own_branch(self) -> Branch:
        if self._branch is None:
            kinematics = self._study.open_kinematics
            self._branch = self._system.branch(self._drives[0], kinematics, self.start)
        return self._branch

    def _covered(self, branch: Branch, wanted: Array) -> Array:
        """Follow the branch over all wanted positions; return whole periods `(N,)` to take off."""
        low, high = float(np.min(wanted)), float(np.max(wanted))
        turn = 2.0 * np.pi
        far = self._turns_freely and (high - low >= turn or max(high, -low) > turn)
        if far and branch.period is None:
            branch.find_period()
        if branch.period is not None:
            return np.asarray(np.floor((wanted - branch.span[0]) / branch.period))
        if far and high - low > _MOST_TURNS * turn:
            raise AssemblyError(
                f"the mechanism does not repeat within a few turns of {self._drives[0]!r}, so "
                f"{(high - low) / turn:.0f} turns cannot be followed; sweep over at most "
                f"{_MOST_TURNS} turns",
                position=high,
                nearest=branch.span[1],
                residual=0.0,
            )
        branch.cover(low, high)
        return np.zeros(len(wanted))

    def _learn(self, states: Array, branch: Branch | None = None) -> None:
        if not self._redundancy.settled:
            self._redundancy = self._study.of_states(states, branch)
