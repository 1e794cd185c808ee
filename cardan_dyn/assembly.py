"""Assembly: closed positions of a scene for any positions of its drives.

The way from the description's zero position to the wanted one is followed, never guessed: first
the held joints are brought to their positions one after the other, then the drive moves.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from .branch import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION, Branch
from .coordinates import Array, Coordinates
from .errors import AssemblyError, CardanError, SingularConfigurationError, shown, where
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


@dataclass(frozen=True, eq=False, repr=False)
class Guess:
    """Coordinates near closed ones, and what closes them.

    Attributes:
        x: `(N, size)` coordinates, exact in the drives.
        turns: `(N, size)` whole turns that their angles lack.
        kinematics: with the rows that are known to be independent.
        followed: whether they lie on a branch that was followed before.
    """

    x: Array
    turns: Array
    kinematics: Kinematics
    followed: bool

    def __getitem__(self, rows: slice) -> Guess:
        return Guess(self.x[rows], self.turns[rows], self.kinematics, self.followed)


class Assembly:
    """Assembles a mechanism with given drives and held joints.

    What is learned about the motion is kept for later calls. Calls from several threads learn one
    after the other, and none changes what another one has got.

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
        items = range(len(self._structure.paths))
        self._on_loops = {
            column for item in items for column in self._structure.coordinates_on(item)
        }
        self._coordinates = coordinates
        self._columns = [coordinates.columns[name].start for name in drives]
        prescribed = {coordinates.velocities[name].start for name in (*drives, *held)}
        self.passives = np.array(sorted(set(range(mechanism.model.nv)) - prescribed), dtype=int)
        self._lock = threading.RLock()
        self._branch: Branch | None = None
        self._served = 0
        self.groups = self._groups_for(drives, self.passives)
        self.needed = needs(mechanism, coordinates, self.groups, wanted)
        kept = [self.groups[number] for number in self.needed.motion]
        self.decided = columns_of(kept)
        self.kinematics = self._open = self._kinematics_of(drives, kept)
        state = self._zero()
        everything = set(range(mechanism.model.nv)) - {
            coordinates.velocities[name].start for name in held
        }
        for joint, value in start.items():
            others = everything - {coordinates.velocities[joint].start}
            state = self._brought(state, joint, value, np.array(sorted(others), dtype=int))
        way = [state]
        self._settled = False
        try:
            for joint, value in held.items():
                way.append(self._brought(way[-1], joint, value, self.passives))
        except CardanError:
            self._study(np.array(way))  # Too few or too many drives are the better reason.
            raise
        self.start = self._first = way[-1]
        self._open = self._open.solving(
            [solver.open_reduction(self.start) for solver in self._open.solvers]
        )
        # The start may be a dead point; the way to it tells.
        self._study(np.array(way))

    def guesses(self, positions: Array) -> Guess:
        """Return coordinates near closed ones on the branch.

        Args:
            positions: `(N, d)` drive positions.
        """
        with self._lock:
            return self._guesses(positions)

    def _guesses(self, positions: Array) -> Guess:
        turns = np.zeros((len(positions), self._coordinates.size))
        if not self.decided.size:
            guesses = np.repeat(self.start[None, :], len(positions), axis=0)
            guesses[:, self._columns] = positions
            return Guess(guesses, turns, self.kinematics, False)
        if len(self.drives) > 1:
            followed = follow(self._open, self.start, self._columns, positions)
            self._study(followed[:: 1 + len(followed) // _STUDIED])
            return Guess(followed, turns, self.kinematics, False)
        known = self._branch.span if self._branch else None
        wanted = positions[:, 0]
        if self._branch is None:
            self._branch = self._branch_of(self.drives[0], self._open, self.start)
        branch = self._branch
        periods = self._covered(branch, wanted)
        if branch.span != known:
            self._study(branch.states(), branch)
        # Nodes pay once enough samples have used them.
        self._served += len(positions)
        branch.refine(self.kinematics, most=self._served // 24)
        reduced = wanted - periods * (branch.period or 0.0)
        guesses = branch.guess(reduced)
        guesses[:, self._columns] = positions
        turns += periods[:, None] * branch.windings
        turns[:, self._columns] = 0.0
        return Guess(guesses, turns, self.kinematics.moving(branch.states()), True)

    def close(self, guess: Guess, positions: Array) -> ClosedMechanism:
        """Close the loops at guesses for drive positions `(N, d)`.

        Raises:
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        here = guess.kinematics.close(guess.x, guess.turns)
        lost = (here.correction > SAFE_CORRECTION) & guess.followed
        bad = ~(here.residual < CLOSURE_TOLERANCE) | lost
        if np.any(bad):
            worst = int(np.argmax(bad))
            raise AssemblyError(
                f"the loops cannot be closed on the branch at drive position "
                f"{shown(positions[worst])} (closure error {here.residual[worst]:.1e}, "
                f"{here.correction[worst]:.1e} away from where the branch leads)",
                position=where(positions[worst]),
                nearest=None,
                residual=float(here.residual[worst]),
            )
        worst = int(np.argmax(here.condition))
        if here.condition[worst] > SINGULAR_CONDITION:
            raise SingularConfigurationError(
                f"drive position {shown(positions[worst])} is a dead point: the closure equations "
                f"have condition {here.condition[worst]:.1e}; leave it out or choose another drive",
                position=where(positions[worst]),
                condition=float(here.condition[worst]),
            )
        return here

    def period(self) -> float | None:
        """Return the displacement after which the only drive is back where it was, if it is."""
        if self.mechanism.joints[self.drives[0]].type == "prismatic":
            return None
        if not self.decided.size:
            return 2.0 * np.pi
        with self._lock:
            if self._branch is None:
                self._branch = self._branch_of(self.drives[0], self._open, self.start)
            branch = self._branch
            if branch.period is None:
                branch.find_period()
                self._study(branch.states(), branch)
            return branch.period

    def range(self) -> tuple[float, float]:
        """Return between which positions the only drive can move, ±inf where it turns through."""
        name = self.drives[0]
        if not self.decided.size:
            return -np.inf, np.inf
        branch = self._branch_of(name, self._open, self.start)
        if self.mechanism.joints[name].type == "prismatic":
            reach = 10.0 * self.mechanism.length
        else:
            try:
                if branch.find_period():
                    return -np.inf, np.inf
            except (AssemblyError, SingularConfigurationError):
                pass  # It does not turn through; the limits say how far it goes.
            reach = 4.0 * np.pi
        here = self.start[self._columns[0]]
        return branch.limit(here - reach), branch.limit(here + reach)

    def others(self) -> list[Array]:
        """Return the ways to assemble the loops where the description's own way starts.

        The description's own comes first, whichever one this is in. They are searched from many
        starts, the same ones at every call.
        """
        rng = np.random.default_rng(1851)
        starts = np.repeat(self._first[None, :], _STARTS, axis=0)
        coordinates = self._coordinates
        passive = coordinates.moves(self.decided)
        step = rng.uniform(-np.pi, np.pi, (_STARTS, len(self.decided)))
        step[:, passive.slides] *= self.mechanism.length / np.pi
        step[0] = 0.0
        passive.apply(starts, step)
        with np.errstate(all="ignore"):
            found = self._open.close(starts, most=60)
        good = (found.residual < CLOSURE_TOLERANCE) & (found.condition < SINGULAR_CONDITION)
        kept: list[Array] = []
        shapes: list[Array] = []
        order = np.argsort(
            np.linalg.norm(
                coordinates.shape(found.x) - coordinates.shape(self._first[None, :]), axis=1
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
        """Assemble in another way, from `others`; what was learned on the first one is forgotten.

        Raises:
            MobilityError: the drives do not decide the motion here.
            SingularConfigurationError: the way starts in a dead point.
        """
        self.start = start
        self._branch = None
        self._served = 0
        self._settled = False
        self._study(start[None, :])

    def _zero(self) -> Array:
        """Return closed coordinates near the description's zero position."""
        here = self.kinematics.close(self._coordinates.neutral()[None, :], most=50)
        if not here.residual[0] < CLOSURE_TOLERANCE:
            raise AssemblyError(
                f"{self.mechanism.name}: the loops cannot be closed with every joint near zero "
                f"(closure error {here.residual[0]:.1e}): check the origins of joints and loops",
                position=None,
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
        if self._coordinates.velocities[joint].start not in self._on_loops:
            state = state.copy()
            state[column] = value
            return state
        # What the scene leaves out need not follow either.
        left_out = set(self.passives.tolist()) - set(self.decided.tolist())
        kept = [
            group
            for group in self._groups_for((joint,), passives)
            if set(group.passives.tolist()) - left_out
        ]
        kinematics = self._kinematics_of((joint,), kept)
        kinematics = kinematics.solving(
            [solver.open_reduction(state) for solver in kinematics.solvers]
        )
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

    def _study(self, states: Array, branch: Branch | None = None) -> None:
        """Find the redundant rows over closed states `(K, size)`, then check the mobility.

        Args:
            states: closed coordinates.
            branch: that they are on, if any.
        """
        if self._settled:
            return
        here = self._open.evaluate(states)
        if self._determined(here):
            # All rows that can be reached are, and the passives follow from them.
            self.kinematics = self._open
            self._settled = True
            return
        if branch is not None and len(states) < _STUDIED:
            # What two or three states do not reach, those between them may.
            between = self._open.close(branch.guess(np.linspace(*branch.span, _STUDIED)))
            closed = between.x[between.residual < CLOSURE_TOLERANCE]
            states = np.concatenate([states, closed])
            here = self._open.evaluate(states)
        self.kinematics = self._open.solving(
            [
                closed.solver.closure.reduction(closed.twists, closed.actions)
                for closed in here.groups
            ]
        )
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
        zero = self.mechanism.zero_placements()
        solvers = [Solver(self.mechanism, self._coordinates, group, zero) for group in groups]
        return Kinematics(self._coordinates, self._driven(drives), solvers)

    def _driven(self, drives: tuple[str, ...]) -> Array:
        return np.array([self._coordinates.velocities[name].start for name in drives], dtype=int)

    def _branch_of(self, joint: str, kinematics: Kinematics, state: Array) -> Branch:
        prismatic = self.mechanism.joints[joint].type == "prismatic"
        unit = self.mechanism.length if prismatic else 1.0
        return Branch(kinematics, state, self._coordinates.columns[joint].start, unit)
