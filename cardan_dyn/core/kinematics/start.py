"""Start: the closed configuration in which a scene starts.

There is one way to it. The mechanism is followed from the description's zero, since a jump could
end in another assembly mode: the joints of `near` and then the held joints are brought to their
positions one after the other, and the rest follows. Where that way ends, because the zero is not
closed or singular, closed loops are searched for with these joints at their positions.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import AssemblyError, CardanError, SingularConfigurationError
from ...kit.frozen import read_only
from .closing.all_groups import Kinematics
from .closing.group_solver import LONGEST_STEP, MOST_STEPS
from .division import Division
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION


def states_to_start(division: Division, tells: bool = True) -> list[Array]:
    """Return closed coordinates `(size,)` on the way to the start of a scene, the last one there.

    Args:
        division: of the scene's open loops.
        tells: whether to warn where another assembly is as near as the one that is taken.

    Raises:
        AssemblyError: the loops cannot be closed.
        MobilityError: they cannot, since the drives do not match the mobility.
        SingularConfigurationError: a dead point lies on the way.
    """
    problem = division.problem
    key = (
        *(solver.group.key for solver in division.kinematics.solvers),
        *(tuple(problem.near.items()), tuple(problem.held.items())),
        *((name, quaternion.tobytes()) for name, quaternion in problem.near_balls.items()),
        *(problem.passive_columns.tobytes(), division.decided.tobytes()),
    )
    states, told = problem.mechanism.kept.of("way to start", key, _Way(division).states)
    if told and tells:
        problem.mechanism.base.kept.of("told of assemblies", told, lambda: _warned(told))
    return states


class _Way:
    """The way to the start of a scene."""

    def __init__(self, division: Division) -> None:
        self._division, self._kinematics = division, division.kinematics
        self._problem, self._mechanism = division.problem, division.problem.mechanism
        self._coordinates = self._mechanism.coordinates
        self._needed, self._told = division.decided, ""
        # Velocity coordinates of passive joints that no output needs.
        passives = frozenset(self._problem.passive_columns.tolist())
        self._left_out = passives.difference(self._needed.tolist())

    def _fixed(self) -> dict[str, float]:
        """Return what is fixed in the description, which closes no loop that is open there."""
        base = self._mechanism.base.joints
        return {name: 0.0 for name in self._mechanism.joints if name not in base}

    def states(self) -> tuple[list[Array], str]:
        """Return closed coordinates on it, see `states_to_start`, and of what to warn."""
        division, states = self._division, [self._begun()]
        try:
            self._bring_held(states)
            if self._problem.near:
                states.append(self._met(states[-1]))
        except CardanError:
            # A MobilityError explains the failure better than a closure error does.
            division.refuse_locked(division.independent(np.array(states)), states[-1])
            raise
        return [read_only(state) for state in states], self._told

    def _begun(self) -> Array:
        """Return closed coordinates `(size,)` from which the held joints can be moved.

        A complete start that closes the loops is taken as it is, with the joints of loops that it
        does not name where they fit. Balls are not followed along their quaternions.
        """
        problem, mechanism = self._problem, self._mechanism
        wanted = self._with(mechanism.zero, problem.near)
        for joint, quaternion in problem.near_balls.items():
            columns = self._coordinates.columns[joint]
            wanted[columns.stop - 4 : columns.stop] = quaternion
        if self._is_complete():
            named = (*problem.near, *problem.near_balls, *problem.held)
            fitting = mechanism.fitted(wanted, self._coordinates.rates_of(named))
            if self._kinematics.evaluate(fitting[None, :]).residual[0] < CLOSURE_TOLERANCE:
                return fitting
        ended: CardanError | None = None
        if not problem.near_balls:
            try:
                return self._near_moved(self._from_zero())
            except (AssemblyError, SingularConfigurationError) as error:
                if not problem.near:
                    raise
                ended = error
        try:
            return self._searched(wanted, {**self._fixed(), **problem.near})
        except AssemblyError as error:
            # An end of the way says more: how far the joints could be followed.
            told = ended if isinstance(ended, AssemblyError) else error
            return self._nearest(wanted, (), told)

    def _met(self, state: Array) -> Array:
        """Return closed coordinates `(size,)` in which all of `near` is met as well as `held`.

        While one joint moves, others that are there already may be carried along, and the held
        joints carry them all. So they are moved once more.
        """
        if self._is_met(state):
            return state
        try:
            moved = self._near_moved(state)
            if self._is_met(moved):
                return moved
        except (AssemblyError, SingularConfigurationError):
            moved = state
        pinned = {**self._problem.near, **self._problem.held}
        try:
            return self._searched(self._with(moved, pinned), pinned)
        except AssemblyError as error:
            return self._nearest(moved, self._problem.held, error)

    def _nearest(self, x: Array, held: Iterable[str], error: AssemblyError) -> Array:
        """Return closed coordinates `(size,)` nearest to `near`, which cannot all be met."""
        from .closing.nearest import nearest_to  # Most starts can be met.

        near, structure = self._problem.near, self._division.system.structure
        if not near:
            raise error
        wanted = self._with(x, near)
        return nearest_to(structure, wanted, near, self._free(held), self._needed, error)

    def _is_complete(self) -> bool:
        """Return whether `near` names all coordinates of the tree's joints on loops.

        Only then does it say in which assembly mode the loops are, and how many turns joints made.
        """
        mechanism, near, balls = self._mechanism, self._problem.near, self._problem.near_balls
        closing = {loop.joint for loop in mechanism.loops}
        return bool(near or balls) and all(
            coordinate in near
            or (coordinate not in self._coordinates.named and joint.name in balls)
            for joint in mechanism.joints.values()
            for coordinate in joint.coordinates
            if self._division.system.is_on_loops(joint.name) and joint.name not in closing
        )

    def _is_met(self, state: Array) -> bool:
        """Return whether `near` is met, to rounding times the condition of the way there."""
        away = (self._with(state, self._problem.near) - state) * self._coordinates.scale
        return bool(np.all(np.abs(away) < CLOSURE_TOLERANCE))

    def _with(self, x: Array, positions: Mapping[str, float]) -> Array:
        """Return coordinates `(size,)` with some joints at other positions."""
        x = x.copy()
        x[self._coordinates.columns_of(positions)] = list(positions.values())
        return x

    def _free(self, pinned: Iterable[str]) -> Array:
        """Return velocity coordinates that do not belong to joints that stay."""
        free = np.ones(self._mechanism.model.nv, dtype=bool)
        free[self._coordinates.rates_of(pinned)] = False
        return np.nonzero(free)[0]

    def _from_zero(self) -> Array:
        """Return closed coordinates `(size,)` at or near the description's zero.

        The drives stay at zero if Newton's method closes the loops nearby. From far away it may end
        in any assembly mode, which would then depend on the choice of the drives.
        """

        def nearest(x: Array) -> tuple[Array, str]:
            from .closing.rivals import nearest_of_rivals  # Most zeros are closed.

            solvers = self._kinematics.solvers
            return nearest_of_rivals(self._mechanism, solvers, self._mechanism.zero, x)

        def closed() -> tuple[Array, str]:
            zero = self._mechanism.zero
            state = self._kinematics.close(zero[None, :], most=MOST_STEPS)
            # While no step was shortened, this is the assembly mode that the zero is nearest to.
            if not (state.residual[0] < CLOSURE_TOLERANCE and state.correction[0] < LONGEST_STEP):
                return nearest(self._searched(zero, self._fixed()))
            if state.correction[0] > SAFE_CORRECTION:
                from ..proof.closed_positions import refuse_left  # Most zeros are closed and stay.

                groups = [solver.group for solver in self._kinematics.solvers]
                loops = [index for group in groups for index in group.loops]
                couplings = [index for group in groups for index in group.couplings]
                refuse_left(self._mechanism, loops, couplings, zero, state.x[0])
                return nearest(state.x[0])
            return state.x[0], ""

        groups = *(solver.group.key for solver in self._kinematics.solvers), self._needed.tobytes()
        x, told = self._mechanism.kept.of("closed zero", groups, closed)
        if not self._problem.near:
            self._told = told
        return read_only(x)

    def _searched(self, x: Array, pinned: Mapping[str, float]) -> Array:
        """Return closed coordinates `(size,)` near some that may be far from closed.

        Args:
            x: `(size,)` coordinates to start from.
            pinned: joints that stay, at their positions [rad or m].
        """
        from .closing.far import assembled_near  # Most descriptions are closed at zero.

        structure = self._division.system.structure
        nearby, residual = assembled_near(structure, x, self._free(pinned), self._needed)
        if not residual < CLOSURE_TOLERANCE:
            from .diagnosis.reach import unclosed  # Imported here: only errors need it.

            whose = "all joints of start and held"
            raise unclosed(self._mechanism, residual, pinned, whose)
        # Where the drives leave a freedom open, Newton's method may step away.
        state = self._kinematics.close(nearby[None, :])
        is_near = state.correction[0] < SAFE_CORRECTION
        return state.x[0] if is_near and state.residual[0] < residual else nearby

    def _near_moved(self, state: Array) -> Array:
        """Return the state after the joints of `near` have moved to their positions.

        All joints that are not held follow them, the drives as well.
        """
        free = self._free(self._problem.held)
        for joint, value in self._problem.near.items():
            passives = free[free != self._coordinates.named[joint].rate]
            state = self._moved("near", state, joint, value, passives)
        return state

    def _bring_held(self, states: list[Array]) -> None:
        """Append closed coordinates `(size,)` after each held joint has come to its position."""
        held, passives = self._problem.held, self._problem.passive_columns
        away = tuple(
            joint
            for joint, value in held.items()
            if value != states[-1][self._coordinates.named[joint].column]
        )
        together = None
        if len(away) > 1:
            together = self._division.system.together(states[-1], away, passives, self._left_out)
        for joint, value in held.items():
            states.append(self._moved("held", states[-1], joint, value, passives, together))

    def _moved(
        self,
        role: str,
        state: Array,
        joint: str,
        value: float,
        passives: Array,
        together: Kinematics | None = None,
    ) -> Array:
        """Return the state after a joint has moved; errors say which joint it was."""
        system = self._division.system
        try:
            return system.moved(state, joint, value, passives, self._left_out, together)
        except (AssemblyError, SingularConfigurationError) as error:
            from .diagnosis.reach import out_of_reach  # Imported here: only errors need it.

            slides = self._mechanism.drivable[joint].slides
            raise out_of_reach(f"{role} joint", joint, value, slides, error) from error


def _warned(told: str) -> bool:
    """Warn, which is then known to be done."""
    warnings.warn(told, stacklevel=2)
    return True
