"""Start search: the closed configuration in which a scene starts.

The mechanism is assembled at the description's zero, or near it where the zero is not closed. Then
the joints of `start` are brought to their positions one after the other, and the rest follows: a
jump could end in another assembly mode.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, SingularConfigurationError
from ..frozen import read_only
from ..problem.problem import Problem
from .closing.all_groups import Kinematics
from .closing.group_solver import LONGEST_STEP, MOST_STEPS_FROM_AFAR
from .loop_system import LoopSystem
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION

_SAME_POSITION = 1e-9
"""Difference [rad, or lengths of the mechanism] up to which a joint is where `start` wants it:
positions that Newton's method has reached are off by some 1e-15 times the condition number."""


class StartSearch:
    """Finds the start of a scene."""

    def __init__(
        self, problem: Problem, system: LoopSystem, kinematics: Kinematics, decided: Array
    ) -> None:
        """Prepare the search.

        Args:
            problem: the drives, held joints and start of the scene.
            system: its loops.
            kinematics: for its drives, with all rows.
            decided: velocity coordinates of the passive joints whose motion is needed.
        """
        self._problem = problem
        self._system = system
        self._kinematics = kinematics
        self._decided = decided
        passives = frozenset(problem.passive_columns.tolist())
        self._left_out = passives - set(decided.tolist())

    def closed_start(self) -> Array:
        """Return closed coordinates `(size,)` from which the held joints can be moved.

        A complete start that closes the loops is taken as it is, with the joints of loops that it
        does not name where they fit. One with quaternions of balls is assembled near it, since
        balls are not followed along their quaternions. Otherwise the mechanism is assembled near
        the description's zero, and followed from there to the start, so that the assembly mode
        stays the same. Where that is impossible, since the zero is singular, it is assembled with
        the joints of `start` at their positions.

        Raises:
            AssemblyError: the loops cannot be closed.
        """
        zero = self._problem.mechanism.zero
        wanted = self._with(zero, self._problem.near)
        for joint, quaternion in self._problem.near_balls.items():
            columns = self._problem.mechanism.coordinates.columns[joint]
            wanted[columns.stop - 4 : columns.stop] = quaternion
        if self._is_complete():
            mechanism, problem = self._problem.mechanism, self._problem
            named = (*problem.near, *problem.near_balls, *problem.held)
            fitting = mechanism.fitted(wanted, mechanism.coordinates.rates_of(named))
            state = self._kinematics.evaluate(fitting[None, :])
            if state.residual[0] < CLOSURE_TOLERANCE:
                return fitting
        if self._problem.near_balls:
            return self._closed_near(wanted, self._free(self._problem.near))
        try:
            return self._moved_to_start(self._closed_zero(zero))
        except (AssemblyError, SingularConfigurationError) as first:
            if not self._problem.near:
                raise
            try:
                return self._closed_near(wanted, self._free(self._problem.near))
            except AssemblyError as error:
                # An end of the way says more: how far the joints could be followed.
                if isinstance(first, AssemblyError):
                    raise first from error
                raise self._not_closed(self._problem.near, error) from error

    def at_start(self, state: Array) -> Array:
        """Return closed coordinates `(size,)` in which all of `start` is met as well as `held`.

        While one joint moves, others that are there already may be carried along, and the held
        joints carry them all. So they are moved once more, and where that does not suffice, the
        mechanism is assembled with all of them at their positions.

        Args:
            state: `(size,)` closed coordinates with the held joints at their positions.

        Raises:
            AssemblyError: these positions contradict each other.
        """
        if self._is_at_start(state):
            return state
        try:
            moved = self._moved_to_start(state)
            if self._is_at_start(moved):
                return moved
        except (AssemblyError, SingularConfigurationError):
            moved = state
        prescribed = {**self._problem.near, **self._problem.held}
        try:
            return self._closed_near(self._with(moved, prescribed), self._free(prescribed))
        except AssemblyError as error:
            raise self._not_closed(prescribed, error) from error

    def _not_closed(self, positions: Mapping[str, float], error: AssemblyError) -> AssemblyError:
        """Return the error for joints that cannot be at their positions all together."""
        from .following.reach import degrees_hint  # Imported here: only errors need it.

        listed = ", ".join(f"{name}: {value:g}" for name, value in positions.items())
        mechanism = self._problem.mechanism
        angles = [
            degrees_hint(value)
            for name, value in positions.items()
            if not mechanism.drivable[name].slides
        ]
        return AssemblyError(
            f"{mechanism.name}: the loops cannot be closed with all joints of start and held at "
            f"their positions ({listed}); the least closure error is {error.residual:.1e}: leave "
            f"one of them out, or change it{next(filter(None, angles), '')}",
            **error.details,
        )

    def _is_complete(self) -> bool:
        """Return whether `start` names all coordinates of the tree's joints on loops.

        Only then does it say in which assembly mode the loops are, and how many turns joints made.
        """
        mechanism, start = self._problem.mechanism, self._problem.near
        closing = {loop.joint for loop in mechanism.loops}
        return bool(start or self._problem.near_balls) and all(
            coordinate in start
            or (coordinate not in mechanism.coordinates.named and joint.name in balls)
            for balls in (self._problem.near_balls,)
            for joint in mechanism.joints.values()
            for coordinate in joint.coordinates
            if self._system.is_on_loops(joint.name) and joint.name not in closing
        )

    def _is_at_start(self, state: Array) -> bool:
        wanted = self._with(state, self._problem.near)
        difference = (wanted - state) * self._problem.mechanism.coordinates.scale
        return bool(np.all(np.abs(difference) < _SAME_POSITION))

    def _with(self, x: Array, positions: Mapping[str, float]) -> Array:
        """Return coordinates `(size,)` with some joints at other positions."""
        x = x.copy()
        for joint, value in positions.items():
            x[self._problem.mechanism.coordinates.named[joint].column] = value
        return x

    def _free(self, pinned: Iterable[str]) -> Array:
        """Return `(nv,)` which velocity coordinates do not belong to joints that stay."""
        free = np.ones(self._problem.mechanism.model.nv, dtype=bool)
        free[self._problem.mechanism.coordinates.rates_of(pinned)] = False
        return free

    def _closed_zero(self, zero: Array) -> Array:
        """Return closed coordinates `(size,)` at or near the description's zero.

        The drives stay at zero if Newton's method closes the loops nearby. From far away it may end
        in any assembly mode, which would then depend on the choice of the drives.
        """
        key = (*(solver.group.key for solver in self._kinematics.solvers), self._decided.tobytes())
        kept = self._problem.mechanism.kept
        return kept.of("closed zero", key, lambda: read_only(self._closed_at(zero)))

    def _closed_at(self, zero: Array) -> Array:
        """See `_closed_zero`."""
        state = self._kinematics.close(zero[None, :], most=MOST_STEPS_FROM_AFAR)
        # As long as no step was shortened, this is the assembly mode that the zero is nearest to.
        if state.residual[0] < CLOSURE_TOLERANCE and state.correction[0] < LONGEST_STEP:
            if state.correction[0] > SAFE_CORRECTION:
                self._prove_open(zero, state.x[0])
            return state.x[0]
        return self._closed_near(zero, self._free(()))

    def _prove_open(self, zero: Array, closed: Array) -> None:
        """Refuse closed coordinates `(size,)` if those that they were found from were closed."""
        from ..proof.closed_positions import refuse_left  # Most zeros are closed and stay.

        groups = [solver.group for solver in self._kinematics.solvers]
        loops = [index for group in groups for index in group.loops]
        couplings = [index for group in groups for index in group.couplings]
        refuse_left(self._problem.mechanism, loops, couplings, zero, closed)

    def _closed_near(self, x: Array, free: Array) -> Array:
        """Return closed coordinates `(size,)` near some that may be far from closed.

        Args:
            x: `(size,)` coordinates to start from.
            free: `(nv,)` which velocity coordinates may move.
        """
        from .closing.far import (  # Most descriptions are closed at zero.
            assembled_near,
            unclosed,
        )

        mechanism = self._problem.mechanism
        nearby, residual = assembled_near(
            self._system.structure, x, np.nonzero(free)[0], self._decided
        )
        if residual < CLOSURE_TOLERANCE:
            # Where the drives leave a freedom open, Newton's method may step away.
            state = self._kinematics.close(nearby[None, :])
            is_near = state.correction[0] < SAFE_CORRECTION
            return state.x[0] if is_near and state.residual[0] < residual else nearby
        raise unclosed(mechanism, residual)

    def _moved_to_start(self, state: Array) -> Array:
        """Return the state after the joints of `start` have moved to their positions.

        All joints that are not held follow them, the drives as well.
        """
        problem = self._problem
        near, held = tuple(problem.near.items()), tuple(problem.held.items())
        key = state.tobytes(), near, held, self._left_out
        return problem.mechanism.kept.of(
            "way to near", key, lambda: read_only(self._way_to_near(state))
        )

    def _way_to_near(self, state: Array) -> Array:
        """See `_moved_to_start`."""
        problem = self._problem
        coordinates = problem.mechanism.coordinates
        (free,) = np.nonzero(self._free(problem.held))
        for joint, value in problem.near.items():
            passives = free[free != coordinates.named[joint].rate]
            state = self.moved(state, joint, value, passives)
        return state

    def bring_held(self, states: list[Array]) -> None:
        """Bring the held joints to their positions, one after the other.

        Args:
            states: `(size,)` closed coordinates; those after every joint are appended.
        """
        held = tuple(self._problem.held.items())
        key = states[-1].tobytes(), held, self._problem.passive_columns.tobytes(), self._left_out
        way = self._problem.mechanism.kept.of(
            "way of held joints", key, lambda: self._way_of_held(states[-1])
        )
        states.extend(way)

    def _way_of_held(self, state: Array) -> list[Array]:
        """Return the states `(size,)` after every held joint, see `bring_held`."""
        problem, states = self._problem, [state]
        wanted = self._with(state, problem.held)
        coordinates, passives = problem.mechanism.coordinates, problem.passive_columns
        away = tuple(
            joint
            for joint in problem.held
            if wanted[coordinates.named[joint].column] != state[coordinates.named[joint].column]
        )
        together = None
        if len(away) > 1:
            together = self._system.together(state, away, passives, self._left_out)
        for joint, value in problem.held.items():
            known = together if joint in away else None
            states.append(self.moved(states[-1], joint, value, passives, known))
        return [read_only(item) for item in states[1:]]

    def moved(
        self,
        state: Array,
        joint: str,
        value: float,
        passives: Array,
        together: Kinematics | None = None,
    ) -> Array:
        """Return the state after a joint has moved; errors say which joint it was."""
        try:
            return self._system.moved(state, joint, value, passives, self._left_out, together)
        except (AssemblyError, SingularConfigurationError) as error:
            from .following.reach import Aim, out_of_reach  # Imported here: only errors need it.

            role = "held" if joint in self._problem.held else "near"
            slides = self._problem.mechanism.drivable[joint].slides
            who = f"{role} joint {joint!r} cannot be brought to"
            raise out_of_reach(Aim(who, value, slides, joint=joint), error) from error
