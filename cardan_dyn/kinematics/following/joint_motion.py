"""Joint motion: what is known of the joints that several drives move together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import Array, blocks
from ...errors import AssemblyError, SingularConfigurationError
from ...problem.problem import Problem
from ...problem.samples import Targets
from ..closing.all_groups import ClosedState, Kinematics
from ..diagnosis.mobility import STATES_STUDIED
from ..tolerances import CLOSURE_TOLERANCE
from .branch import TURN, Branch, whole_turns
from .drive_motion import Followed, turned_back, turns_freely
from .lattice import KeptLattices, Turn, near_lattices, spacing_for
from .lines import (
    MOST_CORRECTIONS,
    NEAR,
    Curves,
    OnLines,
    Reached,
    Rows,
    allowed_error,
    along_lines,
    beyond_reach,
    curves_along,
    follow,
    samples_on_lines,
)

_TYPICAL_STEP = 0.25
"""Step along a line [rad] that most mechanisms allow. It only decides what serves samples best."""
_FEWEST_PER_STEP = 2
"""Samples per step of their line from which on no lattice is tried."""
_FARTHEST = 64
"""Turns of the drives together up to which a line is followed with all of them."""
_MOST_LATTICE_DRIVES = 6
"""Drives up to which a lattice is tried: a point takes an acceleration for each pair of them."""
_SPACINGS = (0.0125, 0.025, 0.05, 0.1)
"""Distances [rad, or lengths of the mechanism] between designs that represent others; the first one
is taken at which each represents enough."""
_FEWEST = 16
"""Designs that each of them has to represent, so that ways to them take little of the time."""
_FEWEST_AGAIN = 3
"""The same of those at half the distance, for designs whose first one is too near a singular
configuration: they take no more of the time than each design by itself would."""
_NEAR_LAST = 0.05
"""Distance of a position from the last one [rad, or lengths of the mechanism] up to which it is
tried to reach it from there: half of that of designs that may represent each other."""
_CLEAR = 0.15
"""How far apart closure equations may be (see `Kinematics.apart`) between two ways that lead to the
same configuration. Where a singular configuration lay between them it would be at least 1; the rest
is for how the equations change on both ways, of which only the greatest condition is known."""
_MOST_KEPT = 1_000_000
"""Coefficients on the lines of designs that represented others up to which these are kept for later
calls. A line has some 25 steps."""
_LOOKS = 12
"""Positions on each half of a period at which it is looked how near a singular configuration is."""
_ALL_OF_IT, _IS_THERE = np.ones(1), np.ones(1, dtype=bool)
"""The share of a way that is gone in a step, and what is said of its end; of a single sample."""
_NEAREST = 0.1
"""Greatest product of a distance between designs and the condition number, see `TurnSearch`, at
which one represents the other: at a distance δ from a singular configuration, the condition number
is about 3/δ. It is a thirtieth of that, since the condition may be greater between the positions
that are looked at."""


class JointMotion:
    """The motion of what several drives move together; varied held joints are drives here as well.

    The configuration at a sample is reached from the start: held joints first move to their
    positions along a straight line, then the drives to theirs. Before the latter, whole turns are
    taken off the drives that bring the mechanism back to itself when they turn alone, from there;
    where the rest of the way is not open, the drives move along the whole straight line. Lattices
    and designs that represented others are kept for later calls.

    Attributes:
        groups: indices of the groups whose passives they move.
        is_exact: see `DriveMotion`.
        amplitudes: `(1, size)` how far joints move, where guesses at the last targets may be exact
            but for rounding: those from a lattice. None where they are not.
    """

    is_exact = False

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        groups: list[int],
        varied: int = 0,
    ) -> None:
        """Begin at the start; arguments as of `DriveMotion`, with several drives.

        The last `varied` drives of the problem are held joints.
        """
        self.groups = groups
        self.amplitudes: Array | None = None
        self._seen, self._states = start[None, :], start[None, :]
        self._drives = drives
        self._names = tuple(problem.independent[index] for index in drives)
        # With all rows that open loops can reach.
        self._kinematics = kinematics.part(drives, groups)
        self._start = start
        coordinates = problem.mechanism.coordinates
        self._drive_columns = coordinates.columns_of(self._names)
        self._columns = coordinates.columns_moved_by(self._kinematics.moved)
        # A slide counts as one radian when it moves by the mechanism's length.
        self._units = 1.0 / coordinates.scale[self._drive_columns]
        # By their indices among these drives.
        first_varied = len(problem.independent) - varied
        self._driven = [k for k, index in enumerate(drives) if index < first_varied]
        self._held = [k for k, index in enumerate(drives) if index >= first_varied]
        self._turning = [
            index for index in self._driven if turns_freely(problem.mechanism, self._names[index])
        ]
        self._turns: dict[int, tuple[float, Array] | None] = {}
        # The start and the last single position, for the kinematics of one scene.
        self._known: tuple[Kinematics, Kinematics] | None = None
        self._at_start: ClosedState | None = None
        self._lattices = KeptLattices()
        # Designs that represented others, by the drive that turned.
        self._represented: dict[int, list[Represented]] = {}
        self._last: _Last | None = None

    @property
    def states(self) -> Array:
        """Closed coordinates `(K, size)` of some of the last positions."""
        if self._states is not self._seen:
            closed = self._kinematics.close(self._seen)
            self._seen = self._states = closed.x[closed.residual < CLOSURE_TOLERANCE]
        return self._states

    def more_states(self) -> Array:
        """Return no states `(0, size)` besides those that were followed."""
        return self.states[:0]

    def followed(
        self,
        targets: Targets,
        kinematics: Kinematics,
        along_path: bool = False,
        strict: bool = True,
    ) -> Followed:
        """Follow the motion to targets of the scene.

        Args:
            targets: N samples.
            kinematics: of the scene, with the rows that are known to be independent.
            along_path: whether every sample is followed from the one before it.
            strict: whether all have to be within reach; along a path they have to be.

        Raises:
            AssemblyError: a position is out of reach.
        """
        self.amplitudes = None
        asked = targets.prescribed[:, self._drives]
        turns, missing = np.zeros((len(asked), self._start.size)), 0
        try:
            if along_path:
                x = follow(self._kinematics, self._start, self._drive_columns, asked)
                count = len(x)
                of_samples = np.zeros(count), np.zeros(count), np.full(count, np.inf)
                reached = Reached(x, np.ones(count, dtype=bool), *of_samples)
            else:
                own, near = asked.copy(), None
                if self._turning:
                    near = self._without_turns(kinematics, own, turns, targets.design_of)
                reached = self._reached(kinematics, own, targets, near)
                missing = len(asked) - int(np.count_nonzero(reached.is_there))
                if missing:
                    self._follow_whole_ways(kinematics, asked, own, turns, targets, reached)
                    if strict and not np.all(reached.is_there):
                        raise self._beyond(asked, own, reached)
        except AssemblyError as error:
            from .reach import all_out_of_reach  # Imported here: only errors need it.

            raise all_out_of_reach(self._names, self._driven, asked, error) from error
        x, is_there = reached.x, reached.is_there
        every = 1 + len(x) // STATES_STUDIED
        if not missing:
            self._seen = x[::every]
        elif np.any(is_there):
            self._seen = x[np.nonzero(is_there)[0][::every]]
        return Followed((x, turns), True, is_there, reached.left)

    def _without_turns(
        self, kinematics: Kinematics, own: Array, turns: Array, design_of: Array
    ) -> tuple[Array, Array] | None:
        """Take whole turns off positions `(N, d)`, and add them to `turns (N, size)`.

        Returns:
            Coordinates `(N, size)` near closed ones, where dense designs have shown them on the
            way, NaN elsewhere, with their errors `(N,)`, see `GroupState.left`. None where designs
            are not dense.
        """
        near = None
        for index in self._turning:
            column = self._drive_columns[index]
            ahead = own[:, index] - self._start[column]
            farthest = np.max(np.abs(ahead), initial=0.0)
            if not farthest > (0.5 * TURN if self._is_dense(index, own, design_of) else TURN):
                continue
            if index not in self._turns:
                self._turns[index] = self._turn_of(index)
            turn = self._turns[index]
            if self._held:
                period = TURN if turn is None else turn[0]
                near = self._turn_designs(kinematics, index, period, own, turns, design_of)
            elif turn is not None:
                period, windings = turn
                periods = np.trunc(ahead / period)
                own[:, index] = turned_back(own[:, index], periods, period)
                for block in blocks(len(own)):
                    turns[block] += periods[block, None] * windings
        return near

    def _is_dense(self, index: int, own: Array, design_of: Array) -> bool:
        """Return whether a lattice serves designs at positions `(N, d)` of a drive alone."""
        if not self._may_be_dense(index, own, design_of):
            return False
        return spacing_for((own - self._start[self._drive_columns]) / self._units) is not None

    def _may_be_dense(self, index: int, own: Array, design_of: Array) -> bool:
        """Return the same as far as their number tells."""
        only = bool(self._held) and self._driven == [index]
        return only and not self._lines_pay(own, design_of)

    def _turn_designs(
        self,
        kinematics: Kinematics,
        index: int,
        period: float,
        own: Array,
        turns: Array,
        design_of: Array,
    ) -> tuple[Array, Array] | None:
        """Take whole turns of a drive off positions `(N, d)` whose designs come back.

        Either way round leads to the same: the nearer one is taken.

        Args:
            kinematics: of the scene.
            index: the drive, by its index.
            period: displacement after which designs are expected to come back [rad].
            own: changed in place.
            turns: `(N, size)`, likewise.
            design_of: `(N,)`.

        Returns:
            See `_without_turns`.
        """
        column = self._drive_columns[index]
        taken = np.rint((own[:, index] - self._start[column]) / period)
        back = own.copy()
        back[:, index] = turned_back(own[:, index], taken, period)
        is_open, near = taken != 0.0, None
        common = self._start, self._drive_columns
        if self._may_be_dense(index, back, design_of):
            known, legs = self._known_part(kinematics), [self._held, self._driven]
            turn = Turn(index, period, taken, turns)
            near = near_lattices(known, *common, back, self._units, legs, turn, self._lattices)
            is_served = ~np.isnan(near[0][:, column])
            own[is_served] = back[is_served]
            if np.any(is_served):
                is_open = ~is_served
            else:
                near = None
        (rest,) = np.nonzero(is_open)
        if rest.size:
            kept = self._represented.setdefault(index, [])
            search = TurnSearch(self._kinematics, *common, self._held, index, period, kept)
            found, of, x = search.of_samples(back[rest], design_of[rest], near is not None)
            comes_back = found.period[of] > 0.0
            is_open = comes_back | (taken[rest] == 0.0)
            if near is not None:
                near[0][rest[is_open]] = x[is_open]
            own[rest[comes_back]] = back[rest[comes_back]]
            for block in blocks(len(rest)):
                turns[rest[block]] += taken[rest[block], None] * found.windings[of[block]]
        return near

    def _reached(
        self,
        kinematics: Kinematics,
        own: Array,
        targets: Targets,
        near: tuple[Array, Array] | None = None,
    ) -> Reached:
        """Return coordinates `(N, size)` at positions `(N, d)` without whole turns.

        With what is near as far as it is known, see `_without_turns`.
        """
        known = self._known_part(kinematics)
        from_last = self._near_last(known, own)
        if from_last is not None:
            return from_last
        design_of = targets.design_of
        if near is not None:
            x, left = near
        else:
            x, left = np.full((len(own), self._start.size), np.nan), np.full(len(own), np.inf)
            if not self._lines_pay(own, design_of):
                legs = [leg for leg in (self._held, self._driven) if leg]
                common = known, self._start, self._drive_columns
                x, left = near_lattices(*common, own, self._units, legs, None, self._lattices)
        is_there = ~np.isnan(x[:, self._drive_columns[0]])
        if np.any(is_there):
            self.amplitudes = np.max(np.abs(x[is_there]), axis=0)[None]
        residual, condition = np.zeros((2, len(own)))
        ways = [known]
        if any(
            one is not other
            for one, other in zip(known.reductions, self._kinematics.reductions, strict=True)
        ):
            ways.append(self._kinematics)
        for way in ways:
            rest = np.nonzero(~is_there)[0]
            if rest.size:
                found = self._on_lines(way, own[rest], design_of[rest])
                x[rest], is_there[rest], residual[rest], condition[rest], left[rest] = found
        if len(own) == 1 and is_there[0] and condition[0] > 0.0:
            self._last = _Last(known, own, x.copy(), float(condition[0]))
        return Reached(x, is_there, residual, condition, left)

    def _known_part(self, kinematics: Kinematics) -> Kinematics:
        """Return the kinematics of this motion, the same object as long as the scene's is it."""
        if self._known is None or self._known[0] is not kinematics:
            self._known = kinematics, kinematics.part(self._drives, self.groups)
            self._at_start, self._last = None, None
            self._lattices = KeptLattices()
        return self._known[1]

    def _near_last(self, known: Kinematics, own: Array) -> Reached | None:
        """Return what is reached at a position `(1, d)` near the last one; None if that is far.

        A loop of a controller asks for one position after the other. The straight line to each is
        so near the line to the last one that it leads to the same configuration: the closure
        equations on both hardly differ.
        """
        last = self._last
        if last is None or len(own) != 1:
            return None
        way = own - last.position
        if not np.maximum.reduce(np.abs(way / self._units), axis=None) <= _NEAR_LAST:
            return None
        there = last.state
        rows = Rows.along(known, there, way)
        guess = rows.after(_ALL_OF_IT)
        guess[:, self._drive_columns] = own
        state = known.newton_step(guess)
        # Before the last position both the rates and the inverses of the equations may be greater.
        worse = last.condition / float(there.condition[0])
        apart = float(known.apart(state, there.inverses)[0])
        apart *= worse**2 if worse > 1.0 else 1.0
        # Written so that what is not a number is far as well.
        is_safe = apart <= _CLEAR and bool(rows.longest(known.coordinates)[0] >= 1.0)
        if not (is_safe and bool(state.correction[0] < allowed_error(state.condition)[0])):
            return None
        condition, greatest = last.condition / (1.0 - apart), state.condition
        if condition > greatest[0]:
            greatest = np.array([condition])
        self._last = _Last(known, own, state, float(greatest[0]))
        return Reached(state.x, _IS_THERE.copy(), state.residual, greatest, state.left)

    def _follow_whole_ways(
        self,
        kinematics: Kinematics,
        asked: Array,
        own: Array,
        turns: Array,
        targets: Targets,
        reached: Reached,
    ) -> None:
        """Follow the lines to samples, whole turns included, that cannot be reached without these.

        Behind whole turns of one drive alone, the straight line to a sample is another one, which
        may lead through positions that cannot be closed. Of very many turns, it is not followed.

        With asked `(N, d)`, turns `(N, size)`.
        """
        taken = np.sum(np.abs(asked - own), axis=1)
        rest = np.nonzero(~reached.is_there & (taken > 0.0) & (taken <= _FARTHEST * TURN))[0]
        if not rest.size:
            return
        found = self._reached(kinematics, asked[rest], targets.of_samples(rest))
        for whole, values in zip(reached, found, strict=True):
            whole[rest] = values
        own[rest], turns[rest] = asked[rest], 0.0

    def _lines_pay(self, own: Array, design_of: Array) -> bool:
        """Return whether so many samples lie on the same lines that these serve them best."""
        if len(self._drives) > _MOST_LATTICE_DRIVES:
            return True
        if len(self._driven) != 1 or not self._held:
            return False
        ahead = own[:, self._driven] - self._start[self._drive_columns][self._driven]
        designs = 1 + int(np.max(design_of)) if len(design_of) else 1
        steps = designs * (1.0 + float(np.ptp(ahead, axis=0)[0]) / _TYPICAL_STEP)
        return steps * _FEWEST_PER_STEP < len(own)

    def _on_lines(self, kinematics: Kinematics, own: Array, design_of: Array) -> Reached:
        """Return coordinates `(N, size)` at positions `(N, d)`, followed along straight lines."""
        groups, columns = list(range(len(self.groups))), self._drive_columns
        begin: ClosedState | None = self._state_at_start(kinematics)
        starts, of_design = self._start[None, :], np.zeros(len(own), dtype=int)
        if self._held:
            _, chosen, of_design = np.unique(design_of, return_index=True, return_inverse=True)
            at_designs = along_lines(
                kinematics.part(self._held, groups),
                starts,
                [columns[index] for index in self._held],
                own[chosen][:, self._held],
                begin,
            )
            starts, begin = at_designs.x, None
        kinematics = kinematics.part(self._driven, groups)
        columns, own = [columns[index] for index in self._driven], own[:, self._driven]
        if not self._driven:
            count = len(own)
            of_samples = np.zeros(count), np.ones(count), np.full(count, np.inf)
            reached = Reached(starts[of_design], np.ones(count, dtype=bool), *of_samples)
        elif len(self._driven) == 1:
            reached = _along_one(kinematics, starts, columns, own[:, 0], of_design, begin)
        else:
            whole = starts if len(starts) == 1 else starts[of_design]
            reached = along_lines(kinematics, whole, columns, own, begin)
        if not self._held:
            return reached
        np.maximum(reached.condition, at_designs.condition[of_design], out=reached.condition)
        if np.all(at_designs.is_there):
            return reached
        lost = ~at_designs.is_there[of_design]
        reached.x[lost] = starts[of_design[lost]]
        reached.residual[lost] = at_designs.residual[of_design[lost]]
        return reached._replace(is_there=reached.is_there & ~lost)

    def _state_at_start(self, kinematics: Kinematics) -> ClosedState:
        """Return the state at the start, which is kept for what is known of the scene."""
        if self._known is None or self._known[1] is not kinematics:
            return kinematics.evaluate(self._start[None, :])
        if self._at_start is None:
            self._at_start = kinematics.evaluate(self._start[None, :])
        return self._at_start

    def _turn_of(self, index: int) -> tuple[float, Array] | None:
        """Return a drive's period [rad] while the others rest at the start, and its windings."""
        kinematics = self._kinematics.part([index], list(range(len(self.groups))))
        branch = Branch(kinematics, self._start)
        try:
            branch.find_period()
        except (AssemblyError, SingularConfigurationError):
            return None
        return None if branch.period is None else (branch.period, branch.windings)

    def _beyond(self, asked: Array, own: Array, reached: Reached) -> AssemblyError:
        """Return the error for samples that straight lines do not reach.

        With asked `(N, d)`.
        """
        sample, more = int(np.argmin(reached.is_there)), int(np.sum(~reached.is_there)) - 1
        nearest = reached.x[sample].copy()
        nearest[self._drive_columns] += asked[sample] - own[sample]
        error = beyond_reach(
            self._kinematics,
            self._drive_columns,
            asked[sample],
            nearest,
            reached.residual[sample],
            sample,
        )
        if np.any(asked[sample] != own[sample]):
            error.hint += "; whole turns were taken first, one drive after the other"
        if more:
            error.hint += f"; {more} other sample{'s are' if more > 1 else ' is'} out of reach too"
        return error

    def write(
        self, followed: Followed, targets: Targets, x: Array, turns: Array, kinematics: Kinematics
    ) -> None:
        """Write closed coordinates into those of all joints, see `DriveMotion.write`."""
        (own_x, own_turns), columns = followed.values, self._columns
        if len(x) == 1:
            x[0, columns], turns[0, columns] = own_x[0, columns], own_turns[0, columns]
            return
        for own, rows in (own_x, x), (own_turns, turns):
            for block in blocks(len(own)):
                rows[block, columns] = own[block, columns]


def _cells(places: Array) -> tuple[Array, Array]:
    """Return the points of the integer lattice near places `(N, d)`, and `(N,)` which is whose."""
    cells, of_cell = np.unique(np.rint(places), axis=0, return_inverse=True)
    return cells, of_cell


class _Last:
    """A single position that was reached.

    Attributes:
        position: `(1, d)` of the drives.
        condition: greatest condition number on the way there.
    """

    def __init__(
        self, kinematics: Kinematics, position: Array, there: Array | ClosedState, condition: float
    ) -> None:
        """Keep a position with its state, or with coordinates `(1, size)` near closed ones."""
        self.position, self.condition = position, condition
        self._kinematics, self._there = kinematics, there

    @property
    def state(self) -> ClosedState:
        """The closed position."""
        there = self._there
        if not isinstance(there, ClosedState):
            self._there = there = self._kinematics.evaluate(there)
        return there


def _along_one(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    positions: Array,
    of_start: Array,
    begin: ClosedState | None,
) -> Reached:
    """Return coordinates `(N, size)` at positions `(N,)` of one drive.

    Samples with the same start on the same side of it lie on the same line.

    With starts `(D, size)`, of_start `(N,)`; begin is the state of a single start, if it is known.
    """
    ahead = positions - starts[of_start, columns[0]]
    sides = 2 * of_start + (ahead < 0.0)
    order = np.lexsort((np.abs(ahead), sides))
    used, first, line = np.unique(sides[order], return_index=True, return_inverse=True)
    last = np.append(first[1:], len(order)) - 1
    longest = np.abs(ahead[order][last])
    share = np.abs(ahead[order]) / np.where(longest > 0.0, longest, 1.0)[line]
    ends = positions[order][last][:, None]
    whole = starts if len(starts) == 1 else starts[used // 2]
    found = samples_on_lines(kinematics, whole, columns, ends, OnLines(line, share), begin)
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return Reached(*(values[back] for values in found))


class DesignTurns(NamedTuple):
    """How a mechanism comes back to itself, for D designs.

    Attributes:
        period: `(D,)` displacement of the drive [rad]; zero where it does not come back.
        windings: `(D, size)` whole turns of all coordinates meanwhile.
    """

    period: Array
    windings: Array


class Represented(NamedTuple):
    """Designs that represented others.

    Attributes:
        places: of each, by the bytes of its held joints' positions.
        found: see `TurnSearch._each`; None of no designs.
    """

    places: dict[bytes, int]
    found: tuple[DesignTurns, Array, Curves] | None

    def with_more(self, keys: list[bytes], found: tuple[DesignTurns, Array, Curves]) -> Represented:
        """Return these designs and others, whose keys are not among them."""
        places = {**self.places, **{key: len(self.places) + k for k, key in enumerate(keys)}}
        if self.found is None:
            return Represented(places, found)
        (own, condition, curves), (more, others, more_curves) = self.found, found
        turns = DesignTurns(*(np.concatenate(pair) for pair in zip(own, more, strict=True)))
        conditions = np.concatenate([condition, others])
        return Represented(places, (turns, conditions, curves.with_more(more_curves)))


class TurnSearch(NamedTuple):
    """Looks whether designs come back to themselves.

    Attributes:
        kinematics: of the drives, held joints included, and the groups that they move.
        start: `(size,)` closed coordinates of the scene.
        columns: columns of the drives, held joints included, in a row of coordinates.
        held: indices of the held joints among the drives.
        drive: index of the drive that turns.
        period: displacement after which designs are expected to come back [rad].
        kept: designs that represented others, for later searches.
    """

    kinematics: Kinematics
    start: Array
    columns: list[int]
    held: list[int]
    drive: int
    period: float
    kept: list[Represented]

    def of_samples(
        self, positions: Array, design_of: Array, closes: bool
    ) -> tuple[DesignTurns, Array, Array]:
        """Return how the designs of samples come back, and coordinates near closed ones.

        Args:
            positions: `(K, d)` of the drives, the one that turns within half a period of its start.
            design_of: `(K,)` which design (index) each sample is of.
            closes: whether coordinates are asked for.

        Returns:
            How the different designs come back; `(K,)` which of these (index) each sample is of;
            and coordinates `(K, size)` at samples whose designs are represented by others, NaN
            elsewhere.
        """
        _, chosen, of = np.unique(design_of, return_index=True, return_inverse=True)
        count = len(positions) if closes else 0
        rows = positions[chosen][:, self.held]
        found, near = self._found(rows, positions[:count], of[:count])
        x = np.full((len(positions), self.start.size), np.nan)
        x[:count] = near
        return found, of, x

    def _found(self, rows: Array, positions: Array, of: Array) -> tuple[DesignTurns, Array]:
        """Return how designs `(D, h)` come back, and coordinates at samples `(K, size)`.

        With positions `(K, d)` of the samples and their designs (index) `(K,)`.
        """
        scale = self.kinematics.coordinates.scale[[self.columns[index] for index in self.held]]
        x = np.full((len(positions), self.start.size), np.nan)
        for spacing in _SPACINGS:
            cells, of_cell = _cells(rows * scale / spacing)
            if len(cells) * _FEWEST <= len(rows):
                break
        else:
            return self._each(rows)[0], x
        period, windings = np.zeros(len(rows)), np.zeros((len(rows), self.start.size))
        is_alone, rest = np.zeros(len(rows), dtype=bool), np.arange(len(rows))
        while rest.size and len(cells) * _FEWEST_AGAIN <= len(rest):
            middles = cells * spacing / scale + 0.0  # No negative zeros, which have other bytes.
            cell_of = np.full(len(rows), -1)
            cell_of[rest] = of_cell
            (own,) = np.nonzero(cell_of[of] >= 0)
            found, condition, beside = self._beside(middles, positions[own], cell_of[of[own]])
            away = np.sqrt(np.sum(((rows[rest] - middles[of_cell]) * scale) ** 2, axis=1))
            period[rest], windings[rest] = found.period[of_cell], found.windings[of_cell]
            # Designs beside one that does not come back are looked at, each by itself.
            is_alone[rest[period[rest] == 0.0]] = True
            is_near = away * condition[of_cell] < _NEAREST
            cell_of[rest[~is_near | (period[rest] == 0.0)]] = -1
            is_served = cell_of[of[own]] >= 0
            x[own[is_served]] = self._stepped(beside[is_served], positions[own[is_served]])
            rest = rest[~is_near & (period[rest] > 0.0)]
            spacing *= 0.5
            cells, of_cell = _cells(rows[rest] * scale / spacing)
        is_alone[rest] = True
        if np.any(is_alone):
            alone = self._each(rows[is_alone])[0]
            period[is_alone], windings[is_alone] = alone
        return DesignTurns(period, windings), x

    def _beside(
        self, middles: Array, positions: Array, of: Array
    ) -> tuple[DesignTurns, Array, Array]:
        """Return what `_each` finds of designs `(C, h)`, and coordinates at samples.

        These are `(K, size)`, with the held joints as in the design (index) that represents each
        `(K,)`, at positions `(K, d)`.
        """
        known = self.kept[0] if self.kept else Represented({}, None)
        keys = [middle.tobytes() for middle in middles]
        (missing,) = np.nonzero([key not in known.places for key in keys])
        if missing.size:
            found = self._each(middles[missing])
            known = known.with_more([keys[k] for k in missing], found)
        own = np.array([known.places[key] for key in keys], dtype=int)
        assert known.found is not None
        turns, condition, curves = known.found
        self.kept[:] = [known][: curves.coefficients.size <= _MOST_KEPT]
        ahead = positions[:, self.drive] - self.start[self.columns[self.drive]]
        share = np.minimum(np.abs(ahead) / (0.5 * self.period), 1.0)
        x, _ = curves.at(OnLines(2 * own[of] + (ahead > 0.0), share))
        return DesignTurns(*(values[own] for values in turns)), condition[own], x

    def _each(self, rows: Array) -> tuple[DesignTurns, Array, Curves]:
        """Return how each design comes back, and `(D,)` how near a singular configuration is.

        That is the greatest condition number meanwhile, times how far joints move with the held
        ones where that is farther: towards dead points they do so the faster the nearer they are.

        The last ones are the lines of each design, half a period back and ahead.
        """
        count, groups = len(rows), list(range(len(self.kinematics.solvers)))
        held = self.kinematics.part(self.held, groups)
        columns = [self.columns[index] for index in self.held]
        begin = along_lines(held, self.start[None, :], columns, rows)
        drive, column = self.kinematics.part([self.drive], groups), self.columns[self.drive]
        # Half a period each way, which takes half as many steps one after the other.
        starts, half = begin.x.repeat(2, axis=0), 0.5 * self.period
        ends = starts[:, [column]] + np.tile([[-half], [half]], (count, 1))
        curves = curves_along(drive, starts, [column], ends)
        line = np.repeat(np.arange(2 * count), _LOOKS)
        share = np.tile(np.arange(1.0, _LOOKS + 1.0) / _LOOKS, 2 * count)
        looks, is_there = curves.at(OnLines(line, share))
        first, last = looks.reshape(count, 2, _LOOKS, -1)[:, :, -1].swapaxes(0, 1)
        comes_back, windings = whole_turns(self.kinematics, first, last)
        comes_back &= begin.is_there & is_there.reshape(count, -1).all(axis=1)
        with np.errstate(all="ignore"):  # Of designs out of reach, nothing is said.
            state = self.kinematics.evaluate(looks)
            lengths = self.kinematics.coordinates.rate_scale
            ratios = self.kinematics.velocity_ratios(state)[:, :, self.held]
            ratios *= lengths[self.kinematics.drives[self.held]] / lengths[:, None]
            condition = state.condition * np.maximum(1.0, np.max(np.abs(ratios), axis=(1, 2)))
            condition = condition.reshape(count, -1).max(axis=1)
        turns = DesignTurns(np.where(comes_back, self.period, 0.0), windings * comes_back[:, None])
        return turns, condition, curves

    def _stepped(self, beside: Array, positions: Array) -> Array:
        """Return coordinates `(K, size)` at positions `(K, d)`, NaN where a step is not safe.

        With coordinates `(K, size)` near closed ones at designs beside them.
        """
        kinematics, result = self.kinematics, np.full(beside.shape, np.nan)
        for block in blocks(len(positions)):
            to = positions[block]
            with np.errstate(all="ignore"):
                state = kinematics.close(beside[block], most=MOST_CORRECTIONS, leaves=NEAR)
                is_safe = state.correction < allowed_error(state.condition)
                is_safe &= state.residual < CLOSURE_TOLERANCE
                rows = Rows.along(kinematics, state, to - state.x[:, self.columns])
                guess = rows.after(np.ones(len(to)))
                guess[:, self.columns] = to
                there = kinematics.newton_step(guess)
                is_safe &= rows.longest(kinematics.coordinates) >= 1.0
                is_safe &= there.correction < allowed_error(there.condition)
                is_safe &= kinematics.same_side(there, state.inverses)
            result[block][is_safe] = there.x[is_safe]
        return result
