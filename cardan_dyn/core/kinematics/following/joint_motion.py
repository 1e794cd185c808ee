"""Joint motion: what is known of the joints that several drives move together."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....kit.arrays import Array, blocks, consecutive, distinct
from ....kit.errors import AssemblyError, SingularConfigurationError
from ...problem.problem import Problem
from ..closing.all_groups import Kinematics
from .branch import TURN, Branch, whole_turns
from .drive_motion import MOST_TURNS, turned_back, turns_freely
from .lines import along_lines, follow

if TYPE_CHECKING:
    from ...mechanics.bodies import Tree
    from ...mechanics.sample import Roles
    from .orders import Orders
    from .taped_lines import TapedLines


class JointMotion:
    """The motion of what several drives move together; varied held joints are drives here as well.

    The configuration at a sample is reached from the start: held joints first move to their
    positions along a straight line, or one after the other, as to the start of a scene; then the
    drives to theirs. Before the latter, whole turns are taken off the drives that bring the
    mechanism back to itself when they turn alone, from there; where the rest of the way is not
    open, the drives move along the whole straight line.
    """

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        known: Callable[[], Kinematics],
        orders: Callable[[Tree, Roles], Orders],
        varied: int = 0,
        in_turn: bool = False,
    ) -> None:
        """Begin at the start; arguments as of `DriveMotion`, with several drives.

        The last `varied` drives of the problem are held joints, which move together or in turn;
        `known` returns the kinematics with the rows that are independent over the motion, `orders`
        see `Orders`.
        """
        self._drives, self._mechanism = consecutive(np.array(drives)), problem.mechanism
        self._names = tuple(problem.independent[index] for index in drives)
        self._kinematics, self._known = kinematics, known
        self._groups = list(range(len(kinematics.solvers)))
        self._start, self._orders = start, orders
        coordinates = problem.mechanism.coordinates
        self._drive_columns = coordinates.columns_of(self._names)
        self._columns = consecutive(coordinates.columns_moved_by(kinematics.moved))
        # By their indices among these drives.
        first_varied = len(problem.independent) - varied
        self._driven = [k for k, index in enumerate(drives) if index < first_varied]
        self._held = [k for k, index in enumerate(drives) if index >= first_varied]
        # Sets of them that move one after the other.
        held = [[k] for k in self._held] if in_turn else [self._held]
        self._legs = [leg for leg in (*held, self._driven) if leg]

    def write(
        self,
        prescribed: Array,
        x: Array,
        turns: Array,
        along_path: bool = False,
        strict: bool = True,
    ) -> Array:
        """Follow the motion to positions of the scene's drives, see `DriveMotion.write`.

        Along a path, every sample is followed from the one before it, and has to be within reach.
        """
        asked, columns = prescribed[:, self._drives], self._columns
        own, own_turns = asked.copy(), np.zeros(x.shape)
        try:
            if along_path:
                found = follow(self._kinematics, self._start, self._drive_columns, asked)
                is_there = np.ones(len(found), dtype=bool)
            else:
                self._take_turns_off(own, own_turns)
                found, is_there = self._reached(own)
                if not is_there.all():
                    self._follow_whole_ways(asked, own, own_turns, found, is_there)
                    if strict and not np.all(is_there):
                        raise self._beyond(asked, own, found, is_there)
        except AssemblyError as error:
            from ..diagnosis.reach import all_out_of_reach  # Imported here: only errors need it.

            raise all_out_of_reach(self._names, self._driven, asked, error) from None
        x[:, columns] = found[:, columns]
        # Zeros that are never written take no memory.
        if np.count_nonzero(own_turns):
            turns[:, columns] = own_turns[:, columns]
        return is_there

    def _take_turns_off(self, own: Array, turns: Array) -> None:
        """Take whole turns off positions `(N, d)`, and add them to `turns (N, size)`.

        A drive brings the mechanism back to itself if all is the same half a period back and ahead
        of the start, with held joints where they are.
        """
        ways = own - self._start[self._drive_columns]
        is_far = np.abs(ways) > TURN
        for index in is_far.any(axis=0).nonzero()[0].tolist():
            if index in self._held or not turns_freely(self._mechanism, self._names[index]):
                continue
            ahead, (far,) = ways[:, index], is_far[:, index].nonzero()
            held = own[far][:, self._held]
            chosen, of = distinct(held)
            designs = held[chosen]
            period = self._period(index)
            ends = self._start[self._drive_columns] + np.zeros((2, len(designs), 1))
            ends[:, :, self._held] = designs
            ends[:, :, index] += 0.5 * period * np.array([[-1.0], [1.0]])
            x, is_there = self._reached(np.concatenate(ends))
            is_back, windings = whole_turns(self._kinematics, *np.split(x, 2))
            is_back &= np.logical_and(*np.split(is_there, 2))
            back, of = far[is_back[of]], of[is_back[of]]
            # Of a closed way, both sides lead to a sample; that of several drives is another line.
            whole = np.rint if len(self._driven) == 1 else np.trunc
            periods = whole(ahead[back] / period)
            own[back, index] = turned_back(own[back, index], periods, period)
            for block in blocks(len(back)):
                turns[back[block]] += periods[block, None] * windings[of[block]]

    def _period(self, index: int) -> float:
        """Return a drive's period [rad] while the others rest at the start; a turn if none."""
        kinematics = self._kinematics.part([index], self._groups)
        branch = Branch.shared(kinematics, self._start, self._mechanism.kept)
        with suppress(AssemblyError, SingularConfigurationError):
            branch.find_period()
        return branch.period or TURN

    def _reached(self, own: Array) -> tuple[Array, Array]:
        """Return coordinates `(N, size)` at positions `(N, d)` without whole turns, and if there.

        By tapes where these serve; else with the rows that are independent over the motion, and at
        last with all that open loops can reach.
        """
        x, is_there = self._taped.ends(own)
        tried = None
        for rows in self._known, lambda: self._kinematics:
            (rest,) = (~is_there).nonzero()
            if not rest.size:
                break
            kinematics = rows()
            if kinematics.key != tried:
                x[rest], is_there[rest] = self._on_lines(kinematics, own[rest])
            tried = kinematics.key
        return x, is_there

    @cached_property
    def _taped(self) -> TapedLines:
        """Follows lines."""
        from .taped_lines import TapedLines  # Most scenes have a single drive.

        return TapedLines(self._mechanism, self._kinematics, self._start, self._legs, self._orders)

    def _follow_whole_ways(
        self, asked: Array, own: Array, turns: Array, x: Array, is_there: Array
    ) -> None:
        """Follow the lines to samples, whole turns included, that cannot be reached without these.

        Behind whole turns of one drive alone, the straight line to a sample is another one, which
        may lead through positions that cannot be closed. Of very many turns, it is not followed.

        With asked and own `(N, d)`, turns and x `(N, size)`, is_there `(N,)`.
        """
        taken = np.sum(np.abs(asked - own), axis=1)
        rest = np.nonzero(~is_there & (taken > 0.0) & (taken <= MOST_TURNS * TURN))[0]
        if rest.size:
            x[rest], is_there[rest] = self._reached(asked[rest])
            own[rest], turns[rest] = asked[rest], 0.0

    def _on_lines(self, kinematics: Kinematics, own: Array) -> tuple[Array, Array]:
        """Return coordinates `(N, size)` at positions `(N, d)`, followed along straight lines.

        And which of them are there `(N,)`. What moves alike is followed once.
        """
        moved = list[int]()
        x, is_there = np.tile(self._start, (len(own), 1)), np.ones(len(own), dtype=bool)
        for leg in self._legs:
            moved += leg
            (on,) = np.nonzero(is_there)
            chosen, of = distinct(own[on][:, moved])
            first, columns = on[chosen], [self._drive_columns[index] for index in leg]
            found, ends = along_lines(
                kinematics.part(leg, self._groups), x[first], columns, own[first][:, leg]
            )
            x[on], is_there[on] = found[of], ends[of]
        return x, is_there

    def _beyond(self, asked: Array, own: Array, x: Array, is_there: Array) -> AssemblyError:
        """Return the error for samples that straight lines do not reach.

        With asked and own `(N, d)`, x `(N, size)`, is_there `(N,)`.
        """
        sample, more = int(np.argmin(is_there)), int(np.sum(~is_there)) - 1
        nearest = x[sample].copy()
        nearest[self._drive_columns] += asked[sample] - own[sample]
        from ..diagnosis.reach import beyond_line  # Imported here: only errors need it.

        way = self._drive_columns, asked[sample], nearest
        error = beyond_line(self._kinematics, *way, sample)
        if np.any(asked[sample] != own[sample]):
            error.hint += "; whole turns were taken first, one drive after the other"
        if more:
            error.hint += f"; {more} other sample{'s are' if more > 1 else ' is'} out of reach too"
        return error
