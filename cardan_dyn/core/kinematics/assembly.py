"""Assembly: closed positions of a scene for any positions of its drives."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array, blocks
from ...kit.errors import ArgumentError, MobilityError, choices
from ..problem.problem import FIRST_MODE, Problem
from ..problem.samples import Targets
from .closing.all_groups import ClosedState, Kinematics
from .division import Division
from .following.guesses import Guess, Guesses
from .loop_system import LoopSystem
from .loops.idle_rods import rods_of
from .start import states_to_start
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION

if TYPE_CHECKING:
    from ..mechanics.bodies import Tree
    from ..mechanics.sample import Roles
    from .assembly_modes import AssemblyModes
    from .following.orders import Orders


class Assembly:
    """Assembles a mechanism with given drives and held joints.

    Attributes:
        groups: all groups of the scene.
        needed: which of the groups the outputs need.
        decided: velocity coordinates of the passive joints that the needed groups decide.
        start: `(size,)` closed coordinates at the held positions, where the drives start.
        begun: the same before the held joints came to their positions.

    Raises:
        ArgumentError: there is no such assembly mode.
        AssemblyError: the loops cannot be closed at the held positions.
        MobilityError: the drives do not match the mobility.
        SingularConfigurationError: the scene starts in a dead point of its drives.
    """

    def __init__(
        self,
        problem: Problem,
        varied: tuple[str, ...] = (),
        like: Assembly | None = None,
        tells: bool = True,
        in_turn: bool = False,
    ) -> None:
        """Assemble a mechanism.

        Args:
            problem: its drives, held joints and start.
            varied: held joints whose positions differ from sample to sample. They are drives here.
            like: assembly of the same problem without them, whose start is taken.
            tells: see `states_to_start`; scenes tell, what they look at besides does not.
            in_turn: whether varied joints move one after the other, see `JointMotion`.
        """
        of_held, self._problem = problem, problem.driving(varied)
        problem = self._problem
        system = LoopSystem(problem.mechanism, problem.held)
        self._of_open_loops = whole = Division.of_open_loops(problem, system)
        states = states_to_start(whole, tells) if like is None else [like.start]
        self.start: Array = states[-1]
        self.begun: Array = states[0] if like is None else like.begun
        self._first_mode = self.start
        division = whole.around(self.start)
        # The start itself may be singular; judge the rank from all states on the way to it.
        known = division.independent(np.array(states))
        division.refuse_locked(known, self.start)
        if problem.branch != FIRST_MODE and like is None:
            self.start = self._mode_called(problem.branch)
            division = whole.around(self.start)
            known = division.independent(self.start[None, :])
        self.groups, self.needed, self.decided = division.groups, division.needed, division.decided
        self._at: Mapping[str, Array] | None = None
        common = division.kinematics, division.independent, known, self.start
        self._guesses = Guesses(problem, *common, of_held, _guesses_of, len(varied), in_turn)

    @property
    def kinematics(self) -> Kinematics:
        """Closes the loops for the scene's drives, with the rows independent over the motion.

        Raises:
            MobilityError: the drives do not decide the motion.
        """
        return self._guesses.kinematics

    def orders(self, tree: Tree, roles: Roles) -> Orders:
        """Return the orders of elimination of the closure rows, see `Guesses.orders`."""
        return self._guesses.orders(tree, roles)

    def at_design(self, positions: Mapping[str, float]) -> Assembly:
        """Return the same with all varied held joints at one position each, for all samples.

        Both share what is known of all positions.
        """
        design = copy(self)
        design._at = {name: np.array(value) for name, value in positions.items()}
        return design

    def _with_design(self, targets: Targets) -> Targets:
        return targets if self._at is None else targets.held_at(self._at)

    def guesses(self, targets: Targets, along_path: bool = False) -> Guess:
        """Return coordinates near closed ones at targets.

        Arguments as of `Guesses.at`.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        return self._guesses.at(self._with_design(targets), along_path)

    def close(self, guess: Guess, positions: Array, first: int = 0) -> ClosedState:
        """Close the loops at guesses for drive positions `(N, d)`.

        Args:
            guess: N samples.
            positions: of the drives, for messages.
            first: index of the first sample in the sweep, likewise.

        Raises:
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        state = self.kinematics.close(guess.x, guess.turns, settles=True)
        is_closed = _is_closed(state)
        if np.count_nonzero(is_closed) < len(is_closed):
            from .diagnosis.reach import open_at  # Imported here: only errors need it.

            bad = int(np.argmin(is_closed))
            rods = [] if state.correction[bad] > SAFE_CORRECTION else rods_of(self._problem)
            raise open_at(positions[bad], state, bad, first + bad, next(iter(rods), ()))
        worst = int(state.condition.argmax())
        if state.condition[worst] > SINGULAR_CONDITION:
            from .diagnosis.reach import singular_at  # Imported here: only errors need it.

            at = positions[worst], state, worst, first + worst
            raise singular_at(self.kinematics, self.start, *at)
        return state

    def reachable(self, targets: Targets) -> Array:
        """Return `(N,)` which targets the loops can be closed at, on the way from the start.

        What `guesses` and `close` refuse is not reachable.

        Raises:
            MobilityError: the drives do not decide the motion.
        """
        guess = self._guesses.at(self._with_design(targets), strict=False)
        is_there = np.ones(targets.size, dtype=bool)
        if guess.is_there is not None:
            is_there &= guess.is_there
        for span in blocks(len(is_there)):
            block = guess.of_samples(span)
            with np.errstate(all="ignore"):  # What is out of reach may overflow.
                state = self.kinematics.close(block.x, block.turns)
                is_good = _is_closed(state) & (state.condition <= SINGULAR_CONDITION)
            is_there[span] &= is_good
        return is_there

    def period(self) -> float | None:
        """Return the drive displacement [rad] after which the motion repeats, None if it does not.

        The scene has a single drive.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        if self._problem.mechanism.drivable[self._problem.independent[0]].slides:
            return None
        branch = self._guesses.branch
        if branch is None:
            return 2.0 * np.pi
        branch.find_period()
        return branch.period

    def motion_range(self) -> tuple[float, float]:
        """Return the limits of the only drive [rad or m], ±inf where it has none."""
        branch = self._guesses.branch
        return (-np.inf, np.inf) if branch is None else branch.reach

    @cached_property
    def modes(self) -> AssemblyModes:
        """The assembly modes with the drives where the description's own mode starts.

        Those of all loops, so that a name means the same mode whatever the outputs are; but of the
        solved loops only where nothing decides the motion of others.
        """
        from .assembly_modes import assembly_modes  # Most scenes need no other mode.

        # What was proven around the start need not hold in other modes.
        division = self._of_open_loops
        if len(division.needed.motion) < len(division.groups):
            try:
                return self.with_all_loops(FIRST_MODE).modes
            except MobilityError:
                pass
        return assembly_modes(
            self._problem.mechanism,
            division.kinematics.with_open_reductions(self._first_mode),
            division.decided,
            self._first_mode,
            {name for rod in rods_of(self._problem) for name in rod},
        )

    def with_all_loops(self, branch: str) -> Assembly:
        """Return the assembly in which outputs leave out no loop, in some assembly mode.

        Raises:
            CardanError: as for a scene that has all joints as outputs.
        """
        joints = tuple(self._problem.mechanism.joints)
        return Assembly(replace(self._problem, outputs=joints, all_outputs=True, branch=branch))

    def _mode_called(self, name: str) -> Array:
        """Return closed coordinates `(size,)` of an assembly mode, by its name."""
        from .assembly_modes import mode_name

        modes = self.modes
        named = modes.named()
        if name not in named:
            poses = [mode_name(pose) for pose in range(len(modes.poses))]
            more = len(named) - len(poses)
            variants = f", and {more} variants of them" if more else ""
            raise ArgumentError(
                f"branch {name!r} does not exist; branches: {choices(poses, name)}{variants}"
            )
        return named[name]


def _guesses_of(problem: Problem) -> Guesses:
    return Assembly(replace(problem, branch=FIRST_MODE), tells=False)._guesses


def _is_closed(state: ClosedState) -> Array:
    """Return `(N,)` whether loops are closed, in the assembly mode in which guesses were."""
    # At singular positions, which are refused as such, rounding decides how far guesses are off.
    strays = (state.correction > SAFE_CORRECTION) & (state.condition <= SINGULAR_CONDITION)
    # What is not a number counts as near; its residual is judged.
    return (state.residual < CLOSURE_TOLERANCE) & ~strays
