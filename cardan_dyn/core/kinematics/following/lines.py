"""Lines: closed positions that drives lead to along straight lines, followed step by step.

Positions of several drives have no order. What configuration a position means is therefore defined
by the straight line of drive positions from the start to it, whatever other samples there are. All
lines advance together, each with steps of its own length, by the rules of those on tapes (see
`mechanics.following`): a step has a predictor, extrapolation by two derivatives, a corrector,
Newton's method, and a control, which keeps steps so short that Newton's method cannot change the
assembly mode. The branch of a single drive is two lines that lead on without an end. Their steps
become shorter towards singular configurations, where assembly modes meet, and never cross one;
samples at the ends of other lines may be singular, and are refused later.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....kit.arrays import BLOCK_SIZE, EPS, Array, blocks
from ...mechanics.following import ALLOWED, SHORTEST, longest, next_length
from ...mechanism.coordinates import Coordinates
from ..closing.all_groups import ClosedState, Kinematics
from ..tolerances import CLOSURE_TOLERANCE

LEAST_LEAD = 1e-9
"""Step [rad, or lengths of the mechanism] below which a line that leads on cannot be followed any
farther: far above the rounding of drive positions, so that a step always moves."""


class Rows(NamedTuple):
    """Rows of coordinates along ways of the drives.

    Attributes:
        x: `(K, size)`.
        first: derivatives with respect to the way.
        second: half of the second derivatives.
    """

    x: Array
    first: Array
    second: Array

    @staticmethod
    def along(kinematics: Kinematics, state: ClosedState, way: Array) -> Rows:
        """Return the rows of K closed positions as drives move by `way (K, d)`."""
        v, x = kinematics.rates(state, way), state.x
        a = kinematics.accelerations(state, v, np.zeros(way.shape))
        layout = kinematics.coordinates
        return Rows(x, layout.derivative(x, v), 0.5 * layout.curvature(x, v, a))

    def of(self, chosen: Array | slice | list[int]) -> Rows:
        """Return some of the rows."""
        return Rows(self.x[chosen], self.first[chosen], self.second[chosen])

    def keep(self, chosen: Array, rows: Rows) -> None:
        """Overwrite some of the rows."""
        for values, new in zip(self, rows, strict=True):
            values[chosen] = new

    def longest(self, layout: Coordinates) -> Array:
        """Return `(K,)` how far at most rows may be extrapolated."""
        fastest, half_bent = (
            np.max(np.abs(way) * layout.scale, axis=1, initial=0.0) for way in self[1:]
        )
        return np.asarray(longest(fastest, 2.0 * half_bent))

    def after(self, step: Array) -> Array:
        """Return Taylor polynomials of second order `(K, size)` after steps `(K,)`."""
        step = step[:, None]
        return np.asarray(self.x + step * (self.first + step * self.second))

    def quintics(self, step: Array, end: Rows) -> Array:
        """Return coefficients `(6, K, size)` of polynomials to other rows, see `quintic`.

        Value and two derivatives agree at both ends: Hermite interpolation of fifth order.

        Args:
            step: `(K,)` how far the other rows are away.
            end: the other rows.
        """
        scale = step[:, None]
        slope, bend = scale * self.first, scale**2 * self.second
        # What the second derivative before the step leaves of rows, and of their derivatives.
        gap = end.x - self.x - slope - bend
        turn = scale * end.first - slope - 2.0 * bend
        change = 2.0 * (scale**2 * end.second - bend)
        third = 10.0 * gap - 4.0 * turn + 0.5 * change
        fourth = -15.0 * gap + 7.0 * turn - change
        fifth = 6.0 * gap - 3.0 * turn + 0.5 * change
        return np.stack([self.x, slope, bend, third, fourth, fifth])


def quintic(coefficients: Array, steps: Array, share: Array) -> Array:
    """Return the values `(N, k)` of polynomials, one of `(6, K, k)` for each of N samples.

    Args:
        coefficients: of ascending powers.
        steps: `(N,)` the polynomial (index) of each sample.
        share: `(N,)` of its step.
    """
    share, own = share[:, None], coefficients.take(steps, 1)
    result = own[5]
    for power in range(4, -1, -1):
        result *= share
        result += own[power]
    return np.asarray(result)


class Lines:
    """Straight lines that are followed together: all steps of a round are one set of arrays.

    Attributes:
        rows: of the L closed configurations where lines are, with derivatives with respect to the
            share.
        share: `(L,)` of each line that was followed.
        left: `(L,)` shares to where assembly modes meet, as far as is known of lines that lead on;
            half of it is the most that a step goes.
    """

    def __init__(
        self,
        kinematics: Kinematics,
        starts: Array,
        columns: list[int],
        ends: Array,
        leads: bool = False,
    ) -> None:
        """Begin at the starts.

        Args:
            kinematics: of the drives and the groups that they move.
            starts: `(L, size)` or `(1, size)` closed coordinates at which the lines begin.
            columns: columns of the drives in a row of coordinates.
            ends: drive positions `(L, d)` to which the lines lead [rad or m].
            leads: whether they lead on beyond their ends, which then only say how far a share of
                one is.
        """
        self._kinematics, self._columns, self._leads = kinematics, columns, leads
        state = kinematics.evaluate(np.repeat(starts, len(ends) // max(len(starts), 1), axis=0))
        self._start = state.x.copy()
        self._begins, self._ends = state.x[:, columns], ends
        self._way = ends - self._begins
        self._inverses, self._margin = state.inverses, 1.0 / state.condition
        self.share = np.zeros(len(ends))
        with np.errstate(all="ignore"):  # Ends out of reach may overflow; no step is taken then.
            self.rows = Rows.along(kinematics, state, self._way)
        # At a distance δ from where assembly modes meet, the condition number is about 3/δ or more.
        self.left = 3.0 * self._margin
        self._step = 0.5 * self.left if leads else np.ones(len(ends))

    def going(self, until: Array | float = 1.0, most: float = np.inf) -> Array:
        """Return which lines (index) can be followed farther.

        Args:
            until: shares `(L,)` at which they end.
            most: how far from its start a joint goes [rad, or lengths of the mechanism].
        """
        least = LEAST_LEAD if self._leads else SHORTEST
        # Written so that what is not a number stops as well.
        on = (self.share < until) & (self._step >= least)
        if most < np.inf:
            ways = np.abs(self.rows.x - self._start) * self._kinematics.coordinates.scale
            on &= np.max(ways, axis=1, initial=0.0) <= most
        return on.nonzero()[0]

    @np.errstate(all="ignore")  # Steps out of reach may overflow; they are not taken.
    def advance(self, line: Array) -> Array:
        """Try a step of some lines (index); return those that took it."""
        kinematics, layout = self._kinematics, self._kinematics.coordinates
        at, rest = self.rows.of(line), (np.inf if self._leads else 1.0) - self.share[line]
        length = np.minimum(np.minimum(self._step[line], at.longest(layout)), rest)
        to = np.where(length == rest, 1.0, self.share[line] + length)
        guess, share = at.after(length), to[:, None]
        between = self._begins[line] + share * self._way[line]
        guess[:, self._columns] = np.where(share == 1.0, self._ends[line], between)
        state = kinematics.close(guess, within=ALLOWED)
        new = Rows.along(kinematics, state, self._way[line])
        # Towards a dead point the derivatives grow without bound: a step can be short enough to
        # extrapolate to its end, and too long to interpolate over it.
        back = np.abs(new.after(-length) - at.x) * layout.scale
        error = np.maximum(state.correction, np.max(back, axis=1, initial=0.0))
        taken = kinematics.same_side(state, [inverse[line] for inverse in self._inverses])
        taken &= (state.residual < CLOSURE_TOLERANCE) & (error < ALLOWED)
        if self._leads:
            # Modes are about the reciprocal of the condition number apart; behind this one,
            # rounding decides in which of them a line goes on.
            taken &= state.condition < EPS**-0.5
        self._step[line] = next_length(length, error, taken)
        done = line[taken]
        self.share[done] = to[taken]
        self.rows.keep(done, new.of(taken))
        for inverse, after in zip(self._inverses, state.inverses, strict=True):
            inverse[done] = after[taken]
        if self._leads:
            # The margin is taken to fall in proportion to the distance from where it vanishes.
            before, margin = self._margin[done], 1.0 / state.condition[taken]
            self._margin[done] = margin
            self.left[done] = length[taken] * margin / np.maximum(before - margin, 0.0)
            self._step[done] = np.fmin(self._step[done], 0.5 * self.left[done])
        return done


def along_lines(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    positions: Array,
    most: float = np.inf,
) -> tuple[Array, Array]:
    """Follow the straight lines from closed coordinates to drive positions `(N, d)`.

    Args:
        kinematics: of the drives and the groups that they move.
        starts: `(N, size)` or `(1, size)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: [rad or m].
        most: see `Lines.going`.

    Returns:
        Closed coordinates `(N, size)` at the end of each line, or where it could not go on; and
        `(N,)` whether that is the end.
    """
    x = starts.repeat(len(positions) // max(len(starts), 1), axis=0)
    is_there = np.zeros(len(positions), dtype=bool)
    for block in blocks(len(positions)):
        lines = Lines(kinematics, x[block], columns, positions[block])
        while (line := lines.going(most=most)).size:
            lines.advance(line)
        x[block], is_there[block] = lines.rows.x, lines.share == 1.0
    return x, is_there


def follow(kinematics: Kinematics, start: Array, columns: list[int], positions: Array) -> Array:
    """Return closed coordinates `(N, size)` at drive positions `(N, d)`.

    Of the samples ahead, all count that a single step leads to.

    Args:
        kinematics: of the scene.
        start: `(size,)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: in the order in which they are followed [rad or m].

    Raises:
        AssemblyError: the loops cannot be closed on the way to a sample.
    """
    result = np.empty((len(positions), start.size))
    last, count, batch = start[None, :], 0, 1
    while count < len(positions):
        ahead = positions[count : count + batch]
        lines = Lines(kinematics, last, columns, ahead)
        lines.advance(np.arange(len(ahead)))
        x, is_there = lines.rows.x, lines.share == 1.0
        if not is_there[0]:
            x, is_there = along_lines(kinematics, last, columns, ahead[:1])
        if not is_there[0]:
            from ..diagnosis.reach import beyond_line  # Imported here: only errors need it.

            raise beyond_line(kinematics, columns, ahead[0], x[0], count)
        reached = len(x) if is_there.all() else int(np.argmin(is_there))
        result[count : count + reached] = x[:reached]
        last, count, batch = x[reached - 1 : reached], count + reached, 2 * reached
        batch = min(batch, BLOCK_SIZE)
    return result
