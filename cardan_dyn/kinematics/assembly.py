"""Assembly: closed positions of a scene for any positions of its drives.

The way from the description's zero position to the wanted one is followed, never guessed: first
the joints of `start` and the held joints are brought to their positions one after the other, then
the drives move.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import (
    ArgumentError,
    AssemblyError,
    CardanError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ..problem.problem import Problem
from .all_groups import ClosedState, Kinematics
from .assembly_modes import assembly_modes, mode_name
from .guess_cache import Guess, GuessCache
from .loop_system import LoopSystem
from .needs import columns_of, needs
from .redundancy import RedundancyStudy
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION

_REACH_OF_SLIDE = 10.0
"""Characteristic lengths that a slide is followed before it counts as endless."""
_REACH_OF_ANGLE = 4.0 * np.pi
"""How far a drive that does not repeat is followed to find its limits: they lie within a turn, but
the start may be as far as another turn from them."""


class Assembly:
    """Assembles a mechanism with given drives and held joints.

    Attributes:
        groups: all groups of the scene.
        needed: which of them its outputs need.
        decided: velocity coordinates of the passive joints that those decide.
        start: `(size,)` closed coordinates at the held positions, where the drives start.

    Raises:
        ArgumentError: there is no such assembly mode.
        AssemblyError: the loops cannot be closed at the held positions.
        MobilityError: the drives do not match the mobility.
        SingularConfigurationError: the scene starts in a dead point of its drives.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._system = system = LoopSystem(problem.mechanism, problem.held)
        self.groups = system.groups(problem.drives, problem.passive_columns)
        self.needed = needs(problem.mechanism, self.groups, problem.wanted_bodies)
        kept = [self.groups[index] for index in self.needed.motion]
        self.decided = columns_of(kept)
        kinematics = system.kinematics(problem.drives, kept)
        states = [self._closed_zero(kinematics)]
        self._bring_to_start(states)
        states = states[-1:]
        try:
            self._bring_held(states)
        except CardanError:
            # A MobilityError explains the failure better than a closure error does.
            RedundancyStudy(problem, self.groups, self.needed, kinematics).of_states(
                np.array(states)
            )
            raise
        self._first = states[-1]
        self._open_kinematics = kinematics.with_open_reductions(self._first)
        study = RedundancyStudy(problem, self.groups, self.needed, self._open_kinematics)
        # The start itself may be singular; judge the rank from all states on the way to it.
        redundancy = study.of_states(np.array(states))
        self.start = self._first
        if problem.branch != mode_name(0):
            self.start = self._mode(problem.branch)
            redundancy = study.of_states(self.start[None, :])
        motionless = not self.decided.size
        self._cache = GuessCache(problem, system, study, self.start, redundancy, motionless)

    @property
    def kinematics(self) -> Kinematics:
        """Closes the loops for the scene's drives; it knows more rows the more was solved."""
        return self._cache.kinematics

    def guesses(self, positions: Array) -> Guess:
        """Return coordinates near closed ones for drive positions `(N, d)`.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        return self._cache.guesses(positions)

    def close(self, guess: Guess, positions: Array) -> ClosedState:
        """Close the loops at guesses for drive positions `(N, d)`.

        Raises:
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        state = guess.kinematics.close(guess.x, guess.turns)
        lost = (state.correction > SAFE_CORRECTION) & guess.followed
        bad = ~(state.residual < CLOSURE_TOLERANCE) | lost
        if np.any(bad):
            worst = int(np.argmax(bad))
            raise AssemblyError(
                f"the loops cannot be closed on the branch at drive position "
                f"{as_text(positions[worst])} (closure error {state.residual[worst]:.1e}, "
                f"{state.correction[worst]:.1e} away from where the branch leads)",
                position=as_position(positions[worst]),
                nearest=None,
                residual=float(state.residual[worst]),
            )
        worst = int(np.argmax(state.condition))
        if state.condition[worst] > SINGULAR_CONDITION:
            raise SingularConfigurationError(
                f"drive position {as_text(positions[worst])} is a dead point: the closure "
                f"equations have condition {state.condition[worst]:.1e}; leave it out or choose "
                "another drive",
                position=as_position(positions[worst]),
                condition=float(state.condition[worst]),
            )
        return state

    def period(self) -> float | None:
        """Return the displacement after which the only drive is back where it was, if it is."""
        if self._drive_slides:
            return None
        if not self.decided.size:
            return 2.0 * np.pi
        return self._cache.period()

    def motion_range(self) -> tuple[float, float]:
        """Return between which positions the only drive can move, ±inf where it turns through."""
        if not self.decided.size:
            return -np.inf, np.inf
        drive = self._problem.drives[0]
        branch = self._system.branch(drive, self._open_kinematics, self.start)
        if self._drive_slides:
            reach = _REACH_OF_SLIDE * self._problem.mechanism.characteristic_length
        else:
            try:
                if branch.find_period():
                    return -np.inf, np.inf
            except (AssemblyError, SingularConfigurationError):
                pass  # It does not turn through; the limits say how far it goes.
            reach = _REACH_OF_ANGLE
        start = self.start[self._problem.mechanism.coordinates.columns[drive].start]
        return branch.limit(start - reach), branch.limit(start + reach)

    def modes(self) -> dict[str, Array]:
        """Return the assembly modes with the drives where the description's own mode starts.

        Returns:
            Name to closed coordinates `(size,)`, the description's own mode first.
        """
        found = assembly_modes(
            self._open_kinematics,
            self.decided,
            self._first,
            self._problem.mechanism.characteristic_length,
        )
        return {mode_name(index): state for index, state in enumerate(found)}

    @property
    def _drive_slides(self) -> bool:
        return self._problem.mechanism.joints[self._problem.drives[0]].type == "prismatic"

    def _mode(self, name: str) -> Array:
        modes = self.modes()
        if name not in modes:
            raise ArgumentError(f"branch {name!r} does not exist; branches: {choices(modes)}")
        return modes[name]

    def _closed_zero(self, kinematics: Kinematics) -> Array:
        """Return closed coordinates `(size,)` near the description's zero position."""
        mechanism = self._problem.mechanism
        state = kinematics.close(mechanism.coordinates.neutral()[None, :], most=50)
        if not state.residual[0] < CLOSURE_TOLERANCE:
            raise AssemblyError(
                f"{mechanism.name}: the loops cannot be closed with every joint near zero "
                f"(closure error {state.residual[0]:.1e}): check the origins of joints and loops",
                position=None,
                nearest=None,
                residual=float(state.residual[0]),
            )
        return state.x[0]

    def _bring_to_start(self, states: list[Array]) -> None:
        """Bring the joints of `start` to their positions; everything not held follows them."""
        problem = self._problem
        velocities = problem.mechanism.coordinates.velocity_columns
        fixed = [velocities[name].start for name in problem.held]
        free = np.setdiff1d(np.arange(problem.mechanism.model.nv), fixed)
        for joint, value in problem.start.items():
            passives = free[free != velocities[joint].start]
            states.append(self._brought(states[-1], joint, value, passives))

    def _bring_held(self, states: list[Array]) -> None:
        """Bring the held joints to their positions; the passives follow them."""
        for joint, value in self._problem.held.items():
            passives = self._problem.passive_columns
            states.append(self._brought(states[-1], joint, value, passives))

    def _brought(self, state: Array, joint: str, value: float, passives: Array) -> Array:
        left_out = set(self._problem.passive_columns.tolist()) - set(self.decided.tolist())
        try:
            return self._system.moved(state, joint, value, passives, left_out)
        except CardanError as error:
            raise type(error)(
                f"joint {joint!r} cannot be brought to {value:g}: {error}", **error.details
            ) from error
