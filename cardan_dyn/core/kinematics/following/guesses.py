"""Guesses: coordinates near closed ones, for any positions of a scene's drives.

Drives that move no group of loops together move their joints independently of each other: what one
of them moves is a function of its position alone. Only drives that meet in a group have to be
followed together.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import CardanError
from ....kit.frozen import frozen
from ...problem.problem import Problem
from ...problem.samples import Targets
from ..closing.all_groups import Kinematics

if TYPE_CHECKING:
    from ...mechanics.bodies import Tree
    from ...mechanics.sample import Roles
    from .branch import Branch
    from .drive_motion import DriveMotion
    from .joint_motion import JointMotion
    from .orders import Orders


class Guess(NamedTuple):
    """Coordinates near closed ones of N samples.

    Attributes:
        x: `(N, size)` coordinates, exact in the drives; a large correction means another assembly
            mode.
        turns: `(N, size)` whole turns that have to be added to the angles in `x`.
        is_there: `(N,)` whether samples are within reach; the coordinates of others mean nothing.
            None where all have to be.
        is_closed: whether the coordinates are closed up to rounding.
    """

    x: Array
    turns: Array
    is_there: Array | None = None
    is_closed: bool = False

    def of_samples(self, samples: slice | Array) -> Guess:
        """Return the guess of some samples, by their indices."""
        is_there = None if self.is_there is None else self.is_there[samples]
        return Guess(self.x[samples], self.turns[samples], is_there, self.is_closed)


class Guesses:
    """What is known of a scene all over its motion. Threads may share it."""

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        independent: Callable[[Array], Kinematics],
        at_start: Kinematics,
        start: Array,
        of_held: Problem,
        guesses_of: Callable[[Problem], Guesses],
        varied: int,
        in_turn: bool,
    ) -> None:
        """Begin without having followed anything.

        Args:
            problem: the drives, loads and wanted outputs of the scene.
            kinematics: solves the scene's groups, with all rows that open loops can reach.
            independent: returns the same with those that are independent over closed states.
            at_start: what it returned at the start: `kinematics` if no other state adds to it.
            start: `(size,)` closed coordinates at which the drives start.
            of_held: the problem, with all held joints at one position each.
            guesses_of: returns those of another problem, in its first assembly mode.
            varied: how many of the drives, the last ones, are held joints.
            in_turn: whether these move one after the other, see `JointMotion`.
        """
        self._problem, self._open, self._independent = problem, kinematics, independent
        self._at_start, self._start, self._varied = at_start, start, varied
        self._in_turn = in_turn
        self._of_held, self._guesses_of = of_held, guesses_of
        self._motionless = not kinematics.passives.size  # Nothing has to be followed then.
        self._columns = np.array(problem.mechanism.coordinates.columns_of(problem.independent))

    @cached_property
    def scouts(self) -> Array:
        """Closed coordinates `(S, size)` all over the motion; the start is the first one."""
        return self.scouts_of(len(self._columns))

    def scouts_of(self, drives: int) -> Array:
        """Return the same over the motion of so many drives, the first ones, alone."""
        from .scouts import scouts  # What is made only to be looked at needs none.

        if self._motionless:
            return self._start[None, :]
        kinematics = self._open.part(list(range(drives)), list(range(len(self._open.solvers))))
        return scouts(kinematics, self._start, self._problem.mechanism.kept)

    def orders(self, tree: Tree, roles: Roles) -> Orders:
        """Return the orders of elimination of the closure rows; arguments as of `Orders`.

        The first ones are chosen at closed configurations that are the same wherever a scene holds
        joints and starts, all over the motion of the drives from the description's zero, so that
        nothing depends on which scene asked first. Where drives or held joints cannot move from
        there, and where those orders do not serve, they are chosen over the scene's own motion.
        """
        from .orders import Orders  # What is made only to be looked at needs none.

        problem, kept, start = self._of_held, self._problem.mechanism.kept, self._start.tobytes()
        outputs = problem.outputs, problem.all_outputs, problem.element_bodies
        key: tuple[object, ...] = problem.independent, tuple(sorted(problem.held)), *outputs
        near = kept.of("scouts", key, self._scouts_from_zero)
        if not len(near):
            near, key = self.scouts, (*key, start)
        return Orders(near, lambda: self.scouts, key, start, tree, roles, kept)

    def _scouts_from_zero(self) -> Array:
        """Return closed coordinates `(S, size)` all over the motion of the drives from zero.

        There are none where these, or the held joints, cannot move from there.
        """
        problem = self._of_held
        moving = problem.driving(tuple(sorted(problem.held)))
        with suppress(CardanError):
            guesses = self._guesses_of(replace(moving, near=frozen({}), near_balls=frozen({})))
            return guesses.scouts_of(len(problem.independent))
        return np.zeros((0, len(self._start)))

    @cached_property
    def kinematics(self) -> Kinematics:
        """Closes the loops, with the rows that are independent over the motion.

        Raises:
            MobilityError: the drives do not decide the motion.
        """
        if self._at_start is self._open or self._motionless:
            return self._at_start
        return self._independent(self.scouts)

    @cached_property
    def branch(self) -> Branch | None:
        """The branch of the only drive; None if it moves nothing else."""
        from .branch import Branch  # Most scenes are swept without.

        if self._motionless:
            return None
        return Branch.shared(self._open, self._start, self._problem.mechanism.kept)

    def at(self, targets: Targets, along_path: bool = False, strict: bool = True) -> Guess:
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
        prescribed = targets.prescribed
        x = self._start[None, :].repeat(len(prescribed), axis=0)
        turns, is_there = np.zeros(x.shape), None
        if self._motionless:
            x[:, self._columns] = prescribed
            return Guess(x, turns)
        given = prescribed, x, turns, along_path, strict
        within = [part.write(*given) for part in self._parts]
        if not strict:
            is_there = np.logical_and.reduce(within)
        x[:, self._columns] = prescribed
        if np.count_nonzero(turns[:, self._columns]):
            turns[:, self._columns] = 0.0
        self._problem.mechanism.coordinates.normalised(x)
        return Guess(x, turns, is_there)

    @cached_property
    def _parts(self) -> list[DriveMotion | JointMotion]:
        """The parts of the motion that are independent of each other."""
        return [self._part(*part) for part in self._open.independent_parts()]

    def _part(self, drives: list[int], groups: list[int]) -> DriveMotion | JointMotion:
        common = self._problem, self._open.part(drives, groups), self._start, drives
        if len(drives) == 1:
            from .drive_motion import DriveMotion  # First guesses need it, scenes do not.

            return DriveMotion(*common, self._varied)
        from .joint_motion import JointMotion  # Most scenes have a single drive.

        def known() -> Kinematics:
            return self.kinematics.part(drives, groups)

        return JointMotion(*common, known, self.orders, self._varied, self._in_turn)
