"""Assembly: closed positions of a scene for any positions of its drives.

The mechanism is moved from the description's zero position to the start of the scene step by step,
since a jump could end in another assembly mode: first the joints of `start` and then the held
joints are brought to their positions one after the other, at last the drives move.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array, blocks
from ..errors import (
    ArgumentError,
    AssemblyError,
    CardanError,
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ..mechanism.kept import Kept
from ..problem.problem import Problem
from ..problem.samples import Targets
from .closing.all_groups import ClosedState, Kinematics
from .diagnosis.mobility import Redundancy, RedundancyStudy
from .following.guesses import Guess, Guesses
from .loop_system import LoopSystem
from .loops.groups import Group
from .loops.idle_rods import rods_by_name
from .loops.needs import Needs, columns_of, needs, needs_of_finer
from .start_search import StartSearch
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION

if TYPE_CHECKING:
    from ..mechanics.bodies import Tree
    from ..mechanics.sample import Roles
    from .assembly_modes import AssemblyModes
    from .following.orders import Orders


_FIRST_MODE = "A"
"""Name of the assembly mode that the description's zero leads to, see `mode_name`."""


class _Division(NamedTuple):
    """The loops of a scene, divided into groups.

    Attributes:
        groups: all groups.
        needed: which of them the outputs need.
        decided: velocity coordinates of the passive joints that these decide.
        kinematics: solves all their rows.
    """

    groups: list[Group]
    needed: Needs
    decided: Array
    kinematics: Kinematics

    @staticmethod
    def of_open_loops(problem: Problem, system: LoopSystem) -> _Division:
        """Return the division that the equations of open loops show."""
        groups = system.groups(problem.independent, problem.passive_columns)
        wanted, acting = problem.wanted_bodies, problem.element_bodies
        needed = needs(problem.mechanism, groups, wanted, acting)
        return _Division.into(groups, needed, problem, system)

    @staticmethod
    def into(groups: list[Group], needed: Needs, problem: Problem, system: LoopSystem) -> _Division:
        """Return the division into groups of which some are needed."""
        moving = [groups[index] for index in needed.motion]
        kinematics = system.kinematics(problem.independent, moving)
        return _Division(groups, needed, columns_of(moving), kinematics)

    def finer(self, problem: Problem, system: LoopSystem, state: Array) -> _Division:
        """Return the finest division that is proven around a closed state `(size,)`."""
        drives, passives = problem.independent, problem.passive_columns
        finer = system.finer(self.groups, drives, passives, self.needed.motion, state)
        if finer is self.groups:
            return self
        wanted = problem.wanted_bodies, problem.element_bodies
        needed = needs_of_finer(problem.mechanism, finer, self.groups, self.needed, *wanted)
        return self.into(finer, needed, problem, system)

    def study(self, problem: Problem, state: Array) -> RedundancyStudy:
        """Return the study of redundant rows, of those that open loops can reach.

        With state `(size,)`.
        """
        kinematics = self.kinematics.with_open_reductions(state)
        return RedundancyStudy(problem, self.groups, self.needed, kinematics)


class _Motion:
    """What is known all over the motion of a scene, found when it is asked for."""

    def __init__(
        self,
        study: RedundancyStudy,
        at_start: Redundancy,
        start: Array,
        motionless: bool,
        kept: Kept,
    ) -> None:
        """Begin with what is known at the start.

        Args:
            study: of redundant rows.
            at_start: the redundant rows at the start.
            start: `(size,)` closed coordinates.
            motionless: whether loops decide nothing.
            kept: of the mechanism.
        """
        self._study, self._at_start, self._kept = study, at_start, kept
        self._start, self._motionless = start, motionless

    @cached_property
    def scouts(self) -> Array:
        """Closed coordinates `(S, size)` all over the motion; the start is the first one."""
        from .following.scouts import scouts  # What is made only to be looked at needs none.

        if self._motionless:
            return self._start[None, :]
        return scouts(self._study.open_kinematics, self._start, self._kept)

    @cached_property
    def _kinematics(self) -> Kinematics:
        if self._at_start.settled or self._motionless:
            return self._at_start.kinematics
        return self._study.of_states(self.scouts).kinematics

    def known(self) -> Kinematics:
        """Return the kinematics with the rows independent over the motion."""
        return self._kinematics


class Assembly:
    """Assembles a mechanism with given drives and held joints.

    Attributes:
        groups: all groups of the scene.
        needed: which of the groups the outputs need.
        decided: velocity coordinates of the passive joints that the needed groups decide.
        start: `(size,)` closed coordinates at the held positions, where the drives start.

    Raises:
        ArgumentError: there is no such assembly mode.
        AssemblyError: the loops cannot be closed at the held positions.
        MobilityError: the drives do not match the mobility.
        SingularConfigurationError: the scene starts in a dead point of its drives.
    """

    def __init__(
        self, problem: Problem, varied: tuple[str, ...] = (), like: Assembly | None = None
    ) -> None:
        """Assemble a mechanism.

        Args:
            problem: its drives, held joints and start.
            varied: held joints whose positions differ from sample to sample. They are drives here.
            like: assembly of the same problem without them, whose start is taken.
        """
        self._problem = problem = problem.driving(varied)
        self._system = system = LoopSystem(problem.mechanism, problem.held)
        division = of_open_loops = _Division.of_open_loops(problem, system)
        states = self._states_to_start(division) if like is None else [like.start]
        self._first_mode = states[-1]
        division = division.finer(problem, system, states[-1])
        study = division.study(problem, states[-1])
        # The start itself may be singular; judge the rank from all states on the way to it.
        redundancy = study.of_states(np.array(states))
        study.refuse_locked(redundancy, self._first_mode)
        self.start: Array = self._first_mode
        if problem.branch != _FIRST_MODE and like is None:
            self.start = self._mode_called(problem.branch)
            division = of_open_loops.finer(problem, system, self.start)
            study = division.study(problem, self.start)
            redundancy = study.of_states(self.start[None, :])
        self.groups, self.needed, self.decided, _ = division
        self._at: Mapping[str, Array] | None = None
        self._open_kinematics = study.open_kinematics
        motionless = not self.decided.size
        self._motion = _Motion(study, redundancy, self.start, motionless, problem.mechanism.kept)
        known = self._motion.known
        common = study.open_kinematics, known, self.start, motionless
        self._guesses = Guesses(problem, *common, len(varied))

    @property
    def kinematics(self) -> Kinematics:
        """Closes the loops for the scene's drives, with the rows independent over the motion.

        Raises:
            MobilityError: the drives do not decide the motion.
        """
        return self._motion.known()

    def orders(self, tree: Tree, roles: Roles) -> Orders:
        """Return the orders of elimination of the closure rows; arguments as of `Orders`."""
        from .following.orders import Orders  # What is made only to be looked at needs none.

        return Orders.kept(lambda: self._motion.scouts, tree, roles, self._problem.mechanism.kept)

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
        if self._at is not None:
            targets = self._with_design(targets)
        return self._guesses.at(targets, along_path)

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
        is_closed = _is_closed(state, guess)
        if np.count_nonzero(is_closed) < len(is_closed):
            bad = int(np.argmin(is_closed))
            rods = [] if state.correction[bad] > SAFE_CORRECTION else self._idle_rods()
            stuck = "".join(
                f"; {', '.join(rod)} hold a rod that may spin, and that cannot turn about its line "
                "to where it settles: describe three hinges that meet as one ball"
                for rod in rods[:1]
            )
            raise AssemblyError(
                f"the loops cannot be closed on the branch at drive position "
                f"{as_text(positions[bad])} (closure error {state.residual[bad]:.1e}, "
                f"{state.correction[bad]:.1e} away from where the branch leads){stuck}",
                position=as_position(positions[bad]),
                nearest=None,
                residual=float(state.residual[bad]),
                sample=first + bad,
            )
        worst = int(state.condition.argmax())
        if state.condition[worst] > SINGULAR_CONDITION:
            from .diagnosis.singularities import (
                gimbal_note,  # Imported here: only errors need it.
                singularity_at,
            )

            singularity = singularity_at(self.kinematics, state.x[worst], self.start)
            note = gimbal_note(self.kinematics.coordinates, state.x[worst], self.decided.tolist())
            raise SingularConfigurationError(
                f"drive position {as_text(positions[worst])} is singular (condition "
                f"{state.condition[worst]:.1e}), {singularity.text}; leave it out or choose "
                f"another drive{note}",
                position=as_position(positions[worst]),
                condition=float(state.condition[worst]),
                sample=first + worst,
                **singularity.details,
            )
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
                is_good = _is_closed(state, block) & (state.condition <= SINGULAR_CONDITION)
            is_there[span] &= is_good
        return is_there

    def period(self) -> float | None:
        """Return the drive displacement [rad] after which the motion repeats, None if it does not.

        The scene has a single drive.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        if self._drive_slides:
            return None
        if not self.decided.size:
            return 2.0 * np.pi
        return self._guesses.period()

    def motion_range(self) -> tuple[float, float]:
        """Return the limits of the only drive [rad or m], ±inf where it has none."""
        return self._motion_range

    @cached_property
    def _motion_range(self) -> tuple[float, float]:
        if not self.decided.size:
            return -np.inf, np.inf
        from .following.branch import Branch
        from .following.reach import reach_of  # Most scenes are swept without.

        branch = Branch.shared(self._open_kinematics, self.start, self._problem.mechanism.kept)
        length = self._problem.mechanism.characteristic_length
        return reach_of(branch, self._drive_slides, length)

    def modes(self) -> AssemblyModes:
        """Return the assembly modes with the drives where the description's own mode starts.

        Those of all loops, so that a name means the same mode whatever the outputs are; but of the
        solved loops only where nothing decides the motion of others.
        """
        from .assembly_modes import assembly_modes  # Most scenes need no other mode.

        # What was proven around the start need not hold in other modes.
        division = _Division.of_open_loops(self._problem, self._system)
        if len(division.needed.motion) < len(division.groups):
            try:
                return self.with_all_loops(_FIRST_MODE).modes()
            except MobilityError:
                pass
        return assembly_modes(
            self._problem.mechanism,
            division.kinematics.with_open_reductions(self._first_mode),
            division.decided,
            self._first_mode,
            self._joints_of_idle_rods(),
        )

    def with_all_loops(self, branch: str) -> Assembly:
        """Return the assembly in which outputs leave out no loop, in some assembly mode.

        Raises:
            CardanError: as for a scene that has all joints as outputs.
        """
        joints = tuple(self._problem.mechanism.joints)
        return Assembly(replace(self._problem, outputs=joints, all_outputs=True, branch=branch))

    def _joints_of_idle_rods(self) -> set[str]:
        """Return the joints whose positions depend on spins that nothing decides."""
        return {name for rod in self._idle_rods() for name in rod}

    def _idle_rods(self) -> list[tuple[str, ...]]:
        """Return the joints at the ends of every rod that may spin."""
        free = set(self._problem.passive_columns.tolist())
        return rods_by_name(self._problem.mechanism, free)

    @property
    def _drive_slides(self) -> bool:
        return self._problem.mechanism.drivable[self._problem.independent[0]].slides

    def _mode_called(self, name: str) -> Array:
        """Return closed coordinates `(size,)` of an assembly mode, by its name."""
        from .assembly_modes import mode_name

        modes = self.modes()
        named = modes.named()
        if name not in named:
            poses = [mode_name(pose) for pose in range(len(modes.poses))]
            more = len(named) - len(poses)
            variants = f", and {more} variants of them" if more else ""
            raise ArgumentError(
                f"branch {name!r} does not exist; branches: {choices(poses, name)}{variants}"
            )
        return named[name]

    def _states_to_start(self, division: _Division) -> list[Array]:
        """Return closed coordinates `(size,)` on the way to the held positions, the last one there.

        They begin where the joints of `start` are at their positions.
        """
        problem = self._problem
        search = StartSearch(problem, self._system, division.kinematics, division.decided)
        states = [search.closed_start()]
        try:
            search.bring_held(states)
            if problem.near:
                states.append(search.at_start(states[-1]))
        except CardanError:
            # A MobilityError explains the failure better than a closure error does.
            _, needed, _, kinematics = division
            study = RedundancyStudy(problem, division.groups, needed, kinematics)
            study.refuse_locked(study.of_states(np.array(states)), states[-1])
            raise
        return states


def _is_closed(state: ClosedState, guess: Guess) -> Array:
    """Return `(N,)` whether loops are closed, in the assembly mode in which guesses were."""
    is_closed: Array = state.residual < CLOSURE_TOLERANCE
    if guess.followed:
        # The negated comparison counts what is not a number as near, as its residual is judged.
        is_closed &= ~(state.correction > SAFE_CORRECTION)
    return is_closed
