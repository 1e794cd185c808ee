"""Guess cache: coordinates near closed ones, from what earlier calls learned about the motion.

Drives that move no group of loops together move their joints independently of each other: what one
of them moves is a function of its position alone. Only drives that meet in a group have to be
followed together.
"""

from __future__ import annotations

import threading
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...arrays import Array
from ...problem.problem import Problem
from ...problem.samples import Targets
from ..closing.all_groups import Kinematics
from ..diagnosis.mobility import STATES_STUDIED, Redundancy, RedundancyStudy

if TYPE_CHECKING:
    from .drive_motion import DriveMotion
    from .joint_motion import JointMotion


class Guess(NamedTuple):
    """Coordinates near closed ones of N samples, and what closes them.

    Attributes:
        x: `(N, size)` coordinates, exact in the drives.
        turns: `(N, size)` whole turns that have to be added to the angles in `x`.
        kinematics: solves the rows that are known to be independent.
        followed: whether `x` lies on a branch, so that a large correction means another mode.
        is_there: `(N,)` whether samples are within reach; the coordinates of others mean nothing.
            None where all have to be.
    """

    x: Array
    turns: Array
    kinematics: Kinematics
    followed: bool
    is_there: Array | None = None

    def of_samples(self, samples: slice | Array) -> Guess:
        """Return the guess of some samples, by their indices."""
        arrays = self.x[samples], self.turns[samples]
        is_there = None if self.is_there is None else self.is_there[samples]
        return Guess(*arrays, self.kinematics, self.followed, is_there)


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
        study: RedundancyStudy,
        start: Array,
        redundancy: Redundancy,
        motionless: bool,
        varied: int,
    ) -> None:
        """Make the cache.

        Args:
            problem: the drives, loads and wanted outputs of the scene.
            study: finds redundant rows.
            start: see the attribute.
            redundancy: redundant rows as known at the start.
            motionless: whether no passive joint is solved, so that nothing has to be learned.
            varied: how many of the drives, the last ones, are held joints.
        """
        self.start = start
        self._problem = problem
        self._study = study
        self._redundancy = redundancy
        self._motionless = motionless
        self._varied = varied
        self._columns = np.array(problem.mechanism.coordinates.columns_of(problem.independent))
        self._is_scouted = False
        self._lock = threading.RLock()

    @property
    def kinematics(self) -> Kinematics:
        """Solves the rows that are known to be independent so far."""
        return self._redundancy.kinematics

    def guesses(self, targets: Targets, along_path: bool = False, strict: bool = True) -> Guess:
        """Return coordinates near closed ones at targets.

        Args:
            targets: N samples.
            along_path: whether every sample is followed from the one before it, instead of along
                the straight line from the start.
            strict: whether all have to be within reach.

        Raises:
            AssemblyError: a position cannot be reached.
            MobilityError: the drives do not decide the motion.
            SingularConfigurationError: a dead point lies on the way.
        """
        with self._lock:
            if self._motionless:
                x, turns = self._at_start(targets)
                self._set_drives(x, targets)
                return Guess(x, turns, self.kinematics, False)
            if not self._is_scouted:
                self._scout(targets)
            followed, is_new, kinematics = [], False, self._redundancy.kinematics
            for part in self._parts:
                item = part.followed(targets, kinematics, along_path, strict)
                followed.append(item)
                is_new = is_new or item.is_new
            if is_new and not self._redundancy.settled:
                self._learn()
            is_there = None
            if not strict:
                is_there = followed[0].is_there
                for item in followed[1:]:
                    is_there = is_there & item.is_there
            x, turns = self._at_start(targets)
            for part in self._parts:
                # What was followed is let go as soon as it is written.
                part.write(followed.pop(0), targets, x, turns)
            self._set_drives(x, targets)
            if np.count_nonzero(turns[:, self._columns]):
                turns[:, self._columns] = 0.0
            self._problem.mechanism.coordinates.normalised(x)
            followed_alone = not self._has_joint_motion
            return Guess(x, turns, self.kinematics, followed_alone, is_there)

    def guesses_at(self, targets: Targets, x: Array, turns: Array) -> Guess:
        """Return the guess that consists of given coordinates, of a motion found by other means.

        Args:
            targets: N samples.
            x: `(N, size)` closed coordinates up to rounding, exact in the drives.
            turns: `(N, size)` whole turns that the angles in `x` lack.
        """
        with self._lock:
            if not self._motionless and not self._redundancy.settled:
                count = min(len(x), STATES_STUDIED)
                some = np.linspace(0, len(x) - 1, count).astype(int)
                self._redundancy = self._study.of_states(
                    np.concatenate([part.states for part in self._parts] + [x[some]])
                )
            return Guess(x, turns, self.kinematics, True)

    def _at_start(self, targets: Targets) -> tuple[Array, Array]:
        """Return coordinates `(N, size)` of the start, and no whole turns."""
        x = self.start[None, :].repeat(targets.size, axis=0)
        return x, np.zeros(x.shape)

    def _set_drives(self, x: Array, targets: Targets) -> None:
        """Write the prescribed positions into coordinates `(N, size)`."""
        count = targets.given.shape[-1]
        x[:, self._columns[:count]] = targets.positions
        if targets.held:
            designs, of = targets.designs, targets.design_of
            for column, values in zip(self._columns[count:], designs.T, strict=True):
                x[:, column] = values[of]

    def period(self) -> float | None:
        """Return the drive displacement [rad] after which the motion repeats, None if it does not.

        The scene has a single drive.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        from .drive_motion import DriveMotion

        with self._lock:
            (part,) = self._parts
            if not isinstance(part, DriveMotion):
                raise ValueError("a period is that of a single drive")
            if part.branch.period is None:
                part.branch.find_period()
                self._learn()
            return part.branch.period

    @cached_property
    def _parts(self) -> list[DriveMotion | JointMotion]:
        """The parts of the motion that are independent of each other."""
        return [self._part(*part) for part in self._study.open_kinematics.independent_parts()]

    @cached_property
    def _has_joint_motion(self) -> bool:
        """Whether drives meet in a group."""
        from .drive_motion import DriveMotion

        return not all(isinstance(part, DriveMotion) for part in self._parts)

    def _part(self, drives: list[int], groups: list[int]) -> DriveMotion | JointMotion:
        kinematics = self._study.open_kinematics
        common = self._problem, kinematics, self.start, drives, groups
        if len(drives) == 1:
            from .drive_motion import DriveMotion  # First guesses need it, scenes do not.

            return DriveMotion(*common, varied=self._varied)
        from .joint_motion import JointMotion  # Most scenes have a single drive.

        return JointMotion(*common, varied=self._varied)

    def _scout(self, targets: Targets) -> None:
        """Follow some samples of the first ones, to solve no redundant rows for all others."""
        if targets.size <= 2 * STATES_STUDIED:
            return
        from .drive_motion import DriveMotion

        self._is_scouted = True
        joint = [part for part in self._parts if not isinstance(part, DriveMotion)]
        if joint and not self._redundancy.settled:
            some = np.linspace(0, targets.size - 1, STATES_STUDIED).astype(int)
            scouts = targets.of_samples(some)
            for part in joint:
                part.followed(scouts, self._study.open_kinematics, strict=False)
            self._learn()

    def _learn(self) -> None:
        """Find redundant rows from all states seen so far, unless no state can add to them."""
        if self._redundancy.settled:
            return
        self._redundancy = self._study.of_states(
            np.concatenate([part.states for part in self._parts]),
            lambda: np.concatenate([part.more_states() for part in self._parts]),
        )
