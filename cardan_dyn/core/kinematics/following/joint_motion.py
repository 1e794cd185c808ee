"""Joint motion: what is known of the joints that several drives move together."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....kit.arrays import Array, blocks
from ....kit.errors import AssemblyError, SingularConfigurationError
from ...problem.problem import Problem
from ...problem.samples import Targets
from ..closing.all_groups import Kinematics
from .branch import TURN, Branch, whole_turns
from .drive_motion import turned_back, turns_freely
from .lines import (
    OnLines,
    Reached,
    along_lines,
    follow,
    samples_on_lines,
)

if TYPE_CHECKING:
    from ...mechanics.bodies import Tree
    from ...mechanics.sample import Roles
    from .orders import Orders
    from .taped_lines import TapedLines

_FARTHEST = 64
"""Turns of the drives together up to which a line is followed with all of them."""


class JointMotion:
    """The motion of what several drives move together; varied held joints are drives here as well.

    The configuration at a sample is reached from the start: held joints first move to their
    positions along a straight line, then the drives to theirs. Before the latter, whole turns are
    taken off the drives that bring the mechanism back to itself when they turn alone, from there;
    where the rest of the way is not open, the drives move along the whole straight line.

    Attributes:
        groups: indices of the groups whose passives they move.
    """

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        groups: list[int],
        known: Callable[[], Kinematics],
        orders: Callable[[Tree, Roles], Orders],
        varied: int = 0,
    ) -> None:
        """Begin at the start; arguments as of `DriveMotion`, with several drives.

        The last `varied` drives of the problem are held joints; `known` returns the scene's
        kinematics with the rows that are independent over the motion, `orders` see `Orders`.
        """
        self.groups = groups
        self._drives, self._mechanism = drives, problem.mechanism
        self._names = tuple(problem.independent[index] for index in drives)
        # With all rows that open loops can reach.
        self._kinematics = kinematics.part(drives, groups)
        self._start, self._orders = start, orders
        self._known: Callable[[], Kinematics] = lambda: known().part(drives, groups)
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

    def followed(
        self, targets: Targets, along_path: bool = False, strict: bool = True
    ) -> tuple[Array, ...]:
        """Follow the motion to targets of the scene.

        Args:
            targets: N samples.
            along_path: whether every sample is followed from the one before it.
            strict: whether all have to be within reach; along a path they have to be.

        Returns:
            Coordinates `(N, size)`, of which those that these drives move count; the whole turns
            that they lack `(N, size)`; and which samples are within reach `(N,)`.

        Raises:
            AssemblyError: a position is out of reach.
        """
        asked = targets.prescribed[:, self._drives]
        turns = np.zeros((len(asked), self._start.size))
        try:
            if along_path:
                x = follow(self._kinematics, self._start, self._drive_columns, asked)
                count = len(x)
                reached = Reached(x, np.ones(count, dtype=bool), np.zeros(count))
            else:
                own = asked.copy()
                self._take_turns_off(own, turns, targets.design_of)
                reached = self._reached(own, targets.design_of)
                if not np.all(reached.is_there):
                    self._follow_whole_ways(asked, own, turns, targets.design_of, reached)
                    if strict and not np.all(reached.is_there):
                        raise self._beyond(asked, own, reached)
        except AssemblyError as error:
            from ..diagnosis.reach import all_out_of_reach  # Imported here: only errors need it.

            raise all_out_of_reach(self._names, self._driven, asked, error) from error
        return reached.x, turns, reached.is_there

    def _take_turns_off(self, own: Array, turns: Array, design_of: Array) -> None:
        """Take whole turns off positions `(N, d)`, and add them to `turns (N, size)`."""
        for index in self._turning:
            ahead = own[:, index] - self._start[self._drive_columns[index]]
            if not np.max(np.abs(ahead), initial=0.0) > TURN:
                continue
            if index not in self._turns:
                self._turns[index] = self._turn_of(index)
            turn = self._turns[index]
            if self._held:
                self._turn_designs(index, TURN if turn is None else turn[0], own, turns, design_of)
            elif turn is not None:
                period, windings = turn
                periods = np.trunc(ahead / period)
                own[:, index] = turned_back(own[:, index], periods, period)
                for block in blocks(len(own)):
                    turns[block] += periods[block, None] * windings

    def _turn_designs(
        self, index: int, period: float, own: Array, turns: Array, design_of: Array
    ) -> None:
        """Take whole turns of a drive off positions `(N, d)` whose designs come back.

        Either way round leads to the same: the nearer one is taken.

        Args:
            index: the drive, by its index.
            period: displacement after which designs are expected to come back [rad].
            own: changed in place.
            turns: `(N, size)`, likewise.
            design_of: `(N,)`.
        """
        begin = self._start[self._drive_columns[index]]
        periods = np.rint((own[:, index] - begin) / period)
        (turned,) = np.nonzero(periods)
        if not turned.size:
            return
        _, chosen, of = np.unique(design_of[turned], return_index=True, return_inverse=True)
        # If the mechanism is the same half a period back and ahead, it comes back there.
        ends = own[turned[chosen]].repeat(2, axis=0)
        ends[::2, index], ends[1::2, index] = begin - 0.5 * period, begin + 0.5 * period
        reached = self._reached(ends, np.arange(len(chosen)).repeat(2))
        is_back, windings = whole_turns(self._kinematics, reached.x[::2], reached.x[1::2])
        is_back &= reached.is_there.reshape(-1, 2).all(axis=1)
        back, of = turned[is_back[of]], of[is_back[of]]
        own[back, index] = turned_back(own[back, index], periods[back], period)
        for block in blocks(len(back)):
            turns[back[block]] += periods[back[block], None] * windings[of[block]]

    def _reached(self, own: Array, design_of: Array) -> Reached:
        """Return coordinates `(N, size)` at positions `(N, d)` without whole turns.

        By tapes where these serve; else with the rows that are independent over the motion, and at
        last with all that open loops can reach.
        """
        reached = Reached(*self._taped.ends(own), np.zeros(len(own)))
        for known in True, False:
            (rest,) = np.nonzero(~reached.is_there)
            if not rest.size:
                break
            kinematics = self._known() if known else self._kinematics
            reached.keep(rest, self._on_lines(kinematics, own[rest], design_of[rest]))
        return reached

    @cached_property
    def _taped(self) -> TapedLines:
        """Follows lines."""
        from .taped_lines import TapedLines  # Most scenes have a single drive.

        legs = [leg for leg in (self._held, self._driven) if leg]
        return TapedLines(self._mechanism, self._kinematics, self._start, legs, self._orders)

    def _follow_whole_ways(
        self, asked: Array, own: Array, turns: Array, design_of: Array, reached: Reached
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
        reached.keep(rest, self._reached(asked[rest], design_of[rest]))
        own[rest], turns[rest] = asked[rest], 0.0

    def _on_lines(self, kinematics: Kinematics, own: Array, design_of: Array) -> Reached:
        """Return coordinates `(N, size)` at positions `(N, d)`, followed along straight lines."""
        groups, columns = list(range(len(self.groups))), self._drive_columns
        starts, of_design = self._start[None, :], np.zeros(len(own), dtype=int)
        if self._held:
            _, chosen, of_design = np.unique(design_of, return_index=True, return_inverse=True)
            at_designs = along_lines(
                kinematics.part(self._held, groups),
                starts,
                [columns[index] for index in self._held],
                own[chosen][:, self._held],
            )
            starts = at_designs.x
        kinematics = kinematics.part(self._driven, groups)
        columns, own = [columns[index] for index in self._driven], own[:, self._driven]
        if not self._driven:
            count = len(own)
            reached = Reached(starts[of_design], np.ones(count, dtype=bool), np.zeros(count))
        elif len(self._driven) == 1:
            reached = _along_one(kinematics, starts, columns, own[:, 0], of_design)
        else:
            whole = starts if len(starts) == 1 else starts[of_design]
            reached = along_lines(kinematics, whole, columns, own)
        if not self._held:
            return reached
        if np.all(at_designs.is_there):
            return reached
        lost = ~at_designs.is_there[of_design]
        reached.x[lost] = starts[of_design[lost]]
        reached.residual[lost] = at_designs.residual[of_design[lost]]
        return reached._replace(is_there=reached.is_there & ~lost)

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
        from ..diagnosis.reach import beyond_line  # Imported here: only errors need it.

        way = self._drive_columns, asked[sample], nearest, reached.residual[sample]
        error = beyond_line(self._kinematics, *way, sample)
        if np.any(asked[sample] != own[sample]):
            error.hint += "; whole turns were taken first, one drive after the other"
        if more:
            error.hint += f"; {more} other sample{'s are' if more > 1 else ' is'} out of reach too"
        return error

    def write(self, followed: tuple[Array, ...], targets: Targets, x: Array, turns: Array) -> None:
        """Write closed coordinates into those of all joints, see `DriveMotion.write`."""
        (own_x, own_turns, _), columns = followed, self._columns
        if len(x) == 1:
            x[0, columns], turns[0, columns] = own_x[0, columns], own_turns[0, columns]
            return
        for own, rows in (own_x, x), (own_turns, turns):
            for block in blocks(len(own)):
                rows[block, columns] = own[block, columns]


def _along_one(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    positions: Array,
    of_start: Array,
) -> Reached:
    """Return coordinates `(N, size)` at positions `(N,)` of one drive.

    Samples with the same start on the same side of it lie on the same line.

    With starts `(D, size)`, of_start `(N,)`.
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
    found = samples_on_lines(kinematics, whole, columns, ends, OnLines(line, share))
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return Reached(*(values[back] for values in found))
