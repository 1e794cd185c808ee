"""Assembly: closed positions of a scene for any positions of its drives.

The way from the description's zero position to the wanted one is followed, never guessed: first
the held joints are brought to their positions one after the other, then the drive moves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from .branch import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION, Branch
from .closure import Reduction
from .coordinates import Array, Coordinates
from .errors import AssemblyError, CardanError, SingularConfigurationError, shown
from .following import follow
from .groups import Group, Structure, partition
from .kinematics import ClosedMechanism, Kinematics
from .mechanism import Mechanism
from .mobility import check_mobility
from .plan import columns_of, needs
from .solver import Solver

_REGULAR = 1e6  # Condition number of positions that leave no doubt about the rank.
_STARTS = 400
_STUDIED = 32
_MOST_TURNS = 1000


class Assembly:
    """Assembles a mechanism with given drives and held joints.

    Attributes:
        groups: all groups of the scene.
        needed: which of them its outputs need.
        decided: velocity coordinates of the passive joints that those decide.
        kinematics: closes the loops for the scene's drives.
        start: `(size,)` closed coordinates at the held positions, where drives start.

    Raises:
        AssemblyError: the loops cannot be closed at the held positions.
        MobilityError: the drives do not match the mobility.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        coordinates: Coordinates,
        drives: tuple[str, ...],
        held: dict[str, float],
        wanted: set[int] | None,
        start: dict[str, float],
    ) -> None:
        """Assemble at the held positions.

        Args:
            mechanism: the mechanism.
            coordinates: layout of its coordinates.
            drives: names of the driven joints.
            held: held joints and their positions.
            wanted: see `plan.needs`.
            start: joints that are brought to positions first, the drives following them.
        """
        self.mechanism = mechanism
        self.drives = drives
        self.held = held
        self._structure = Structure(mechanism, coordinates)
        self._coordinates = coordinates
        self._columns = [coordinates.columns[name].start for name in drives]
        prescribed = {coordinates.velocities[name].start for name in (*drives, *held)}
        self.passives = np.array(sorted(set(range(mechanism.model.nv)) - prescribed), dtype=int)
        self._branch: Branch | None = None
        self._served = 0
        self.groups = self._groups_for(drives, self.passives)
        self.needed = needs(mechanism, coordinates, self.groups, wanted)
        kept = [self.groups[number] for number in self.needed.motion]
        self.decided = columns_of(kept)
        self.kinematics = self._kinematics_of(drives, kept)
        state = self._zero()
        everything = set(range(mechanism.model.nv)) - {
            coordinates.velocities[name].start for name in held
        }
        for joint, value in start.items():
            others = everything - {coordinates.velocities[joint].start}
            state = self._brought(state, joint, value, np.array(sorted(others), dtype=int))
        way = [state]
        self._settled = False
        self._open = [solver.reduction for solver in self.kinematics.solvers]
        try:
            for joint, value in held.items():
                way.append(self._brought(way[-1], joint, value, self.passives))
        except CardanError:
            self._study(np.array(way))  # Too few or too many drives are the better reason.
            raise
        self.start = way[-1]
        self._open = [solver.open_reduction(self.start) for solver in self.kinematics.solvers]
        # The start may be a dead point; the way to it tells.
        self._study(np.array(way))

    @property
    def reductions(self) -> list[Reduction]:
        """Which rows every group solves; they change as long as little of the motion is known."""
        return [solver.reduction for solver in self.kinematics.solvers]

    def guesses(self, positions: Array) -> tuple[Array, Array]:
        """Return coordinates near closed ones on the branch.

        Args:
            positions: `(N, d)` drive positions.

        Returns:
            Coordinates `(N, size)`, exact in the drives, and whole turns `(N, size)` that their
            angles lack.
        """
        turns = np.zeros((len(positions), self._coordinates.size))
        if not self.decided.size:
            guesses = np.repeat(self.start[None, :], len(positions), axis=0)
            guesses[:, self._columns] = positions
            return guesses, turns
        if len(self.drives) > 1:
            with self._open_rows():
                followed = follow(self.kinematics, self.start, self._columns, positions)
            self._study(followed[:: 1 + len(followed) // _STUDIED])
            return followed, turns
        known = self._branch.span if self._branch else None
        wanted = positions[:, 0]
        with self._open_rows():
            if self._branch is None:
                self._branch = self._branch_of(self.drives[0], self.kinematics, self.start)
            branch = self._branch
            periods = self._covered(branch, wanted)
        if branch.span != known:
            self._study(branch.states())
        # Nodes pay once enough samples have used them.
        self._served += len(positions)
        branch.refine(most=self._served // 24)
        for solver in self.kinematics.solvers:
            solver.set_amplitudes(branch.states())
        reduced = wanted - periods * (branch.period or 0.0)
        guesses = branch.guess(reduced)
        guesses[:, self._columns] = positions
        turns += periods[:, None] * branch.windings
        turns[:, self._columns] = 0.0
        return guesses, turns

    def close(self, guesses: Array, turns: Array, positions: Array) -> ClosedMechanism:
        """Close the loops at guesses, as `guesses` returns them, for drive positions `(N, d)`.

        Raises:
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        here = self.kinematics.close(guesses, turns)
        lost = here.correction > SAFE_CORRECTION if self._branch else np.zeros(len(guesses), bool)
        bad = ~(here.residual < CLOSURE_TOLERANCE) | lost
        if np.any(bad):
            worst = int(np.argmax(bad))
            raise AssemblyError(
                f"the loops cannot be closed on the branch at drive position "
                f"{shown(positions[worst])} (closure error {here.residual[worst]:.1e}, "
                f"{here.correction[worst]:.1e} away from where the branch leads)",
                position=positions[worst],
                nearest=None,
                residual=float(here.residual[worst]),
            )
        worst = int(np.argmax(here.condition))
        if here.condition[worst] > SINGULAR_CONDITION:
            raise SingularConfigurationError(
                f"drive position {shown(positions[worst])} is a dead point: the closure equations "
                f"have condition {here.condition[worst]:.1e}; leave it out or choose another drive",
                position=positions[worst],
                condition=float(here.condition[worst]),
            )
        return here

    def period(self) -> float | None:
        """Return the displacement after which the only drive is back where it was, if it is."""
        if self.mechanism.joints[self.drives[0]].type == "prismatic":
            return None
        if not self.decided.size:
            return 2.0 * np.pi
        if self._branch is None or self._branch.period is None:
            with self._open_rows():
                self._branch = self._branch or self._branch_of(
                    self.drives[0], self.kinematics, self.start
                )
                found = self._branch.find_period()
            self._study(self._branch.states())
            if not found:
                return None
        return self._branch.period

    def range(self) -> tuple[float, float]:
        """Return between which positions the only drive can move, ±inf where it turns through."""
        name = self.drives[0]
        if not self.decided.size:
            return -np.inf, np.inf
        with self._open_rows():
            branch = self._branch_of(name, self.kinematics, self.start)
            if self.mechanism.joints[name].type == "prismatic":
                reach = 10.0 * self.mechanism.length
            else:
                try:
                    if branch.find_period():
                        return -np.inf, np.inf
                except CardanError:
                    pass
                reach = 4.0 * np.pi
            here = self.start[self._columns[0]]
            return branch.limit(here - reach), branch.limit(here + reach)

    def others(self) -> list[Array]:
        """Return the ways to assemble the loops with all drives at zero, the scene's own first.

        They are searched from many starts, the same ones at every call.
        """
        rng = np.random.default_rng(1851)
        starts = np.repeat(self.start[None, :], _STARTS, axis=0)
        coordinates = self._coordinates
        passive = coordinates.moves(self.decided)
        step = rng.uniform(-np.pi, np.pi, (_STARTS, len(self.decided)))
        step[:, passive.slides] *= self.mechanism.length / np.pi
        step[0] = 0.0
        passive.apply(starts, step)
        with np.errstate(all="ignore"), self._open_rows():
            found = self.kinematics.close(starts, most=60)
        good = (found.residual < CLOSURE_TOLERANCE) & (found.condition < SINGULAR_CONDITION)
        kept: list[Array] = []
        shapes: list[Array] = []
        order = np.argsort(
            np.linalg.norm(
                coordinates.shape(found.x) - coordinates.shape(self.start[None, :]), axis=1
            ),
            kind="stable",
        )
        for number in order[good[order]]:
            shape = coordinates.shape(found.x[[number]])[0]
            if all(np.linalg.norm(shape - other) > 1e-6 for other in shapes):
                shapes.append(shape)
                kept.append(found.x[number])
        return kept

    def restart(self, start: Array) -> None:
        """Assemble in another way, from `others`."""
        self.start = start
        self._branch = None

    def _zero(self) -> Array:
        """Return closed coordinates near the description's zero position."""
        here = self.kinematics.close(self._coordinates.neutral()[None, :], most=50)
        if not here.residual[0] < CLOSURE_TOLERANCE:
            raise AssemblyError(
                f"{self.mechanism.name}: the loops cannot be closed with every joint near zero "
                f"(closure error {here.residual[0]:.1e}): check the origins of joints and loops",
                position=0.0,
                nearest=None,
                residual=float(here.residual[0]),
            )
        return here.x[0]

    def _brought(self, state: Array, joint: str, value: float, passives: Array) -> Array:
        try:
            return self._moved(state, joint, value, passives)
        except CardanError as error:
            raise type(error)(
                f"joint {joint!r} cannot be brought to {value:g}: {error}", **error.details
            ) from error

    def _moved(self, state: Array, joint: str, value: float, passives: Array) -> Array:
        """Follow the mechanism from a state while one joint moves to a value.

        The passives follow; all other joints rest.
        """
        column = self._coordinates.columns[joint].start
        if value == state[column]:
            return state
        # What the scene leaves out need not follow either.
        left_out = set(self.passives.tolist()) - set(self.decided.tolist())
        kept = [
            group
            for group in self._groups_for((joint,), passives)
            if set(group.passives.tolist()) - left_out
        ]
        kinematics = self._kinematics_of((joint,), kept)
        for solver in kinematics.solvers:
            solver.reduction = solver.open_reduction(state)
        branch = self._branch_of(joint, kinematics, state)
        branch.cover(min(value, state[column]), max(value, state[column]))
        return branch.states()[-1 if value > state[column] else 0]

    def _covered(self, branch: Branch, wanted: Array) -> Array:
        """Follow the branch over all wanted positions; return whole periods `(N,)` to take off."""
        low, high = float(np.min(wanted)), float(np.max(wanted))
        turn = 2.0 * np.pi
        endless = self.mechanism.joints[self.drives[0]].type == "continuous"
        far = endless and (high - low >= turn or max(high, -low) > turn)
        if far and branch.period is None:
            branch.find_period()
        if branch.period is not None:
            return np.asarray(np.floor((wanted - branch.span[0]) / branch.period))
        if far and high - low > _MOST_TURNS * turn:
            raise AssemblyError(
                f"the mechanism does not repeat within a few turns of {self.drives[0]!r}, so "
                f"{(high - low) / turn:.0f} turns cannot be followed; sweep over at most "
                f"{_MOST_TURNS} turns",
                position=high,
                nearest=branch.span[1],
                residual=0.0,
            )
        branch.cover(low, high)
        return np.zeros(len(wanted))

    @contextmanager
    def _open_rows(self) -> Iterator[None]:
        """Solve all rows that open loops can reach, for a while.

        At the few positions known so far a closed loop may look planar or spherical that is not.
        """
        solvers = self.kinematics.solvers
        before = [solver.reduction for solver in solvers]
        for solver, reduction in zip(solvers, self._open, strict=True):
            solver.reduction = reduction
        try:
            yield
        finally:
            for solver, reduction in zip(solvers, before, strict=True):
                solver.reduction = reduction

    def _study(self, states: Array) -> None:
        """Find the redundant rows over closed states `(K, size)`, then check the mobility."""
        if self._settled:
            return
        with self._open_rows():
            here = self.kinematics.evaluate(states)
        if self._determined(here):
            # All rows that can be reached are, and the passives follow from them.
            for solver, reduction in zip(self.kinematics.solvers, self._open, strict=True):
                solver.reduction = reduction
            self._settled = True
            return
        for solver, closed in zip(self.kinematics.solvers, here.groups, strict=True):
            solver.reduction = solver.closure.reduction(closed.twists)
        check_mobility(
            self.kinematics,
            self.kinematics.evaluate(states),
            self.drives,
            list(self.held),
            # What was left out is nobody's concern, unless no group decides it.
            set(self.passives.tolist())
            - (set(columns_of(self.groups).tolist()) - set(self.decided.tolist())),
        )

    def _determined(self, here: ClosedMechanism) -> bool:
        """Return whether every group has as many independent equations as passives somewhere."""
        decided = columns_of(self.groups)
        return np.array_equal(decided, self.passives) and all(
            closed.passive_rows.shape[1] == closed.passive_rows.shape[2]
            and float(np.min(closed.condition)) < _REGULAR
            for closed in here.groups
        )

    def _groups_for(self, drives: tuple[str, ...], passives: Array) -> list[Group]:
        x = self._coordinates.neutral()
        for name, value in self.held.items():
            x[self._coordinates.columns[name]] = value
        return partition(self._structure, x, self._driven(drives), passives)

    def _kinematics_of(self, drives: tuple[str, ...], groups: list[Group]) -> Kinematics:
        zero = self.mechanism.zero_positions()
        solvers = [Solver(self.mechanism, self._coordinates, group, zero) for group in groups]
        return Kinematics(self._coordinates, self._driven(drives), solvers)

    def _driven(self, drives: tuple[str, ...]) -> Array:
        return np.array([self._coordinates.velocities[name].start for name in drives], dtype=int)

    def _branch_of(self, joint: str, kinematics: Kinematics, state: Array) -> Branch:
        prismatic = self.mechanism.joints[joint].type == "prismatic"
        unit = self.mechanism.length if prismatic else 1.0
        return Branch(kinematics, state, self._coordinates.columns[joint].start, unit)
