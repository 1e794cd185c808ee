"""Lines: closed positions that drives lead to along straight lines, followed step by step.

Positions of several drives have no order. What configuration a position means is therefore defined
by the straight line of drive positions from the start to it, whatever other samples there are. All
lines advance together, each with steps of its own length: every step has a predictor (extrapolation
by two derivatives), a corrector (Newton's method) and a control, which keeps steps so short that
Newton's method cannot change the assembly mode. The branch of a single drive is two such lines
that lead on without an end. Their steps become shorter towards singular configurations, where
assembly modes meet, and are so short that what is interpolated over them stays in one; samples at
the ends of other lines may be singular, and are refused later.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....kit.arrays import BLOCK_SIZE, Array
from ...mechanism.coordinates import Coordinates
from ..closing.all_groups import ClosedState, Kinematics
from ..tolerances import CLOSURE_TOLERANCE, LONGEST_WAY, SAFE_CORRECTION

ALLOWED_ERROR = 0.03
"""Error [rad] of an extrapolation that steps are chosen for where the closure equations are well
conditioned: small against the distance between assembly modes."""
REJECTED = 4.0
"""Ratio of an extrapolation's error to the allowed one from which on its step is rejected. The
error grows with the third power of the step, so such a step is 1.6 times too long."""
_BETWEEN = 1.0 / 3.0
"""Part of the allowed error that steps are chosen for where samples between them are interpolated:
these are then off by some 3e-5, which two Newton steps make rounding."""
_AMBIGUOUS_CONDITION = 1e7
"""Condition number from which on rounding decides in which assembly mode a branch goes on: modes
are about its reciprocal apart, 1e-7 rad, and positions near a dead point known to the root of
rounding, 1e-8."""
_FIRST_STEP = 0.4
"""First step as a part of the longest, where more than the end of a line counts."""
_SINGULAR_DISTANCE = 3.0
"""Distance to a singular configuration times the condition number there, as a lower bound: at a
distance δ from where assembly modes meet, the condition number is about 3/δ or more."""
_APPROACH = 0.7
"""Share of the estimated way to a singular configuration that one step may go. Below one, the
margin stays positive and the singular configuration is never stepped over."""
_LONGER, _SHORTER, _AFTER_REJECTION = 4.0, 0.1, 0.5
"""Greatest and least ratio of a step to the one before it, and the greatest after a failure."""
SHORTEST = 1e-9
"""Step [rad] below which a line cannot be followed any farther, far above the rounding of drive
positions, so that a step always moves; as a share of its way where only its end counts."""
MOST_CORRECTIONS = 6
"""Greatest number of Newton steps per step of a line. Convergence is quadratic: from the allowed
error about four reach rounding. What needs more is tried again from nearer by."""
NEAR = 1e-12
"""Error [rad] with which a position on a line is closed well enough for the next step, far below
`CLOSURE_TOLERANCE`. Who uses it takes another step."""
_SMALLEST_BATCH, _LARGEST_BATCH = 8, 512
"""Samples tried at once: few where most of them would be thrown away, and not so many that arrays
become large. Between the two, a batch is twice as large as the last one was successful."""


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
        """Return the rows of K closed positions, or of one, as drives move by `way (K, d)`."""
        v, x = kinematics.rates(state, way), state.x
        a = kinematics.accelerations(state, v, np.zeros(way.shape))
        if len(x) < len(way):
            x = np.broadcast_to(x, (len(way), x.shape[1]))
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
        _, first, second = self
        fastest, most_bent = (
            np.max(np.abs(way) * layout.scale, axis=1, initial=0.0) for way in (first, second)
        )
        with np.errstate(divide="ignore"):
            return np.minimum(LONGEST_WAY / fastest, np.sqrt(LONGEST_WAY / most_bent))

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


class Reached(NamedTuple):
    """How far straight lines were followed.

    Attributes:
        x: `(N, size)` closed coordinates at the end of each line, or where it could not go on.
        is_there: `(N,)` whether that is the end.
        residual: `(N,)` closure error of the last step that was tried, where it is not.
    """

    x: Array
    is_there: Array
    residual: Array

    def keep(self, lines: Array, others: Reached) -> None:
        """Overwrite what was found of some lines, by their indices."""
        for own, other in zip(self, others, strict=True):
            own[lines] = other


class OnLines(NamedTuple):
    """Samples on straight lines, those of a line one behind the other.

    Attributes:
        line: `(N,)` the line (index) of each sample, ascending.
        share: `(N,)` where on its line it lies, between 0 and 1; ascending on every line.
    """

    line: Array
    share: Array


def along_lines(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    positions: Array,
) -> Reached:
    """Follow the straight lines from closed coordinates to drive positions `(N, d)`.

    Args:
        kinematics: of the drives and the groups that they move.
        starts: `(N, size)` or `(1, size)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: [rad or m].
    """
    count = len(positions)
    samples = OnLines(np.arange(count), np.ones(count))
    return samples_on_lines(kinematics, starts, columns, positions, samples)


def samples_on_lines(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    ends: Array,
    samples: OnLines,
) -> Reached:
    """Return coordinates at samples on straight lines.

    At the end of a line they are closed; before it, they are interpolated between closed ones, and
    off by the sixth power of a step.

    Args:
        kinematics: of the drives and the groups that they move.
        starts: `(L, size)` or `(1, size)` closed coordinates at which the lines begin.
        columns: columns of the drives in a row of coordinates.
        ends: drive positions `(L, d)` to which the lines lead [rad or m].
        samples: N samples.
    """
    count, size = len(samples.line), starts.shape[1]
    begin = kinematics.evaluate(starts) if len(starts) == 1 else None
    reached = Reached(np.empty((count, size)), np.empty(count, dtype=bool), np.empty(count))
    for first in range(0, len(ends), BLOCK_SIZE):
        chosen = slice(first, first + BLOCK_SIZE)
        span = slice(*np.searchsorted(samples.line, [first, first + BLOCK_SIZE]).tolist())
        own = OnLines(samples.line[span] - first, samples.share[span])
        own_starts = starts if len(starts) == 1 else starts[chosen]
        lines = Lines(kinematics, own_starts, columns, ends[chosen], begin)
        for whole, values in zip(reached, lines.at(own), strict=True):
            whole[span] = values
    return reached


class Lines:
    """Straight lines that are followed together: all steps of a round are one set of arrays.

    Attributes:
        x: `(L, size)` closed coordinates where each line is.
        share: `(L,)` of it that was followed.
        tried: `(L,)` share at which the last step failed, one to open loops if there was any; it
            counts as long as the line has not passed it.
        residual: `(L,)` closure error there; zero where no step failed.
        rows: what is known where each line is, with derivatives with respect to the share.
    """

    def __init__(
        self,
        kinematics: Kinematics,
        starts: Array,
        columns: list[int],
        ends: Array,
        begin: ClosedState | None = None,
        leads: bool = False,
    ) -> None:
        """Begin at the starts; arguments as of `samples_on_lines`, with one start or L.

        Lines that lead on do so beyond their ends, which only say how far a share of one is.
        """
        self._kinematics, self._columns, self._leads = kinematics, columns, leads
        state = kinematics.evaluate(starts) if begin is None else begin
        of_each = len(ends) // max(len(starts), 1)
        self.x = starts.repeat(of_each, axis=0)
        begins = self.x[:, columns]
        self._begins, self._ends, self._way = begins, ends, ends - begins
        self._whole = np.inf if leads else 1.0
        self.share, self.tried, self.residual = np.zeros((3, len(ends)))
        self._inverses = [inverse.repeat(of_each, 0) for inverse in state.inverses]
        with np.errstate(all="ignore"):
            self.rows = Rows.along(kinematics, state, self._way)._replace(x=self.x)
            self._longest = self.rows.longest(kinematics.coordinates)
            extent = np.abs(self._way) * kinematics.coordinates.scale[columns]
            self._shortest = SHORTEST / np.max(extent, axis=1, initial=0.0)
        self._step, self._margin = np.ones(len(ends)), 1.0 / state.condition.repeat(of_each)
        if leads:
            self._longest = np.minimum(self._longest, _SINGULAR_DISTANCE * self._margin)
            # Of the first step no error is known yet; of several, the longest may lead as far.
            self._step = _FIRST_STEP * self._longest
        else:
            self._shortest = np.minimum(self._shortest, SHORTEST)

    def at(self, samples: OnLines) -> Reached:
        """Follow all lines to their ends, or as far as they lead; see `samples_on_lines`."""
        # Samples are sought by the number of their line and half of their share.
        keys = samples.line + 0.5 * samples.share
        values, following = (
            self.x[samples.line],
            np.searchsorted(keys, np.arange(len(self.x)), side="right"),
        )

        def passed(lines: Array, to: Array, old: Rows, new: Rows) -> None:
            begins = following[lines]
            ends = following[lines] = np.searchsorted(keys, lines + 0.5 * to, "right")
            counts = ends - begins
            step = np.repeat(np.arange(len(lines)), counts)
            if not step.size:
                return
            chosen = np.arange(len(step)) + np.repeat(begins - np.cumsum(counts) + counts, counts)
            length, before = to - self.share[lines], self.share[lines][step]
            share = samples.share[chosen]
            part = (share - before) / length[step]
            rows = new.x[step]
            inside = part < 1.0
            if inside.any():
                curves = old.quintics(length, new)
                rows[inside] = quintic(curves, step[inside], part[inside])
                rows[:, self._columns] = self._positions(lines[step], share)
            values[chosen] = rows

        aim = 1.0
        if len(keys) > len(self.x):
            aim, self._step = _BETWEEN, _FIRST_STEP * self._longest
        self._follow(passed, aim, np.ones(len(self.x)))
        is_there = samples.share <= self.share[samples.line]
        values[~is_there] = self.x[samples.line[~is_there]]
        return Reached(values, is_there, self.residual[samples.line])

    def lead(self, until: Array, passed: Callable[[int, Rows], None]) -> None:
        """Follow lines that lead on to shares `(L,)` or beyond, unless they end before.

        Where steps end depends on the lines alone.

        Args:
            until: negative where a line stays where it is.
            passed: is told of each step: the line, and the row where it ends, closed but for
                rounding.
        """

        def each(lines: Array, to: Array, old: Rows, new: Rows) -> None:
            for index, line in enumerate(lines.tolist()):
                passed(line, new.of([index]))

        self._follow(each, 1.0, until)

    def _follow(self, passed: _Passed, aim: float, until: Array) -> None:
        with np.errstate(all="ignore"):  # Steps out of reach may overflow; they are not safe.
            self._steps(passed, aim, until)
        # What failed before a line passed it says nothing any more.
        self.residual[self.tried < self.share] = 0.0

    def _steps(self, passed: _Passed, aim: float, until: Array) -> None:
        """Take steps until no line goes on.

        Args:
            passed: is told of the steps that were taken.
            aim: part of the allowed error that steps are chosen for.
            until: `(L,)` shares.
        """
        kinematics, layout, share = self._kinematics, self._kinematics.coordinates, self.share
        rows, step, longest = self.rows, self._step, self._longest
        leaves = None if self._leads else NEAR
        line = np.arange(len(share))
        while True:
            # Written so that what is not a number stops as well.
            line = line[(share[line] < until[line]) & (step[line] >= self._shortest[line])]
            if not line.size:
                return
            remaining = self._whole - share[line]
            length = np.minimum(np.minimum(step[line], longest[line]), remaining)
            to = np.where(length == remaining, 1.0, share[line] + length)
            at = rows.of(line)
            guess = at.after(length)
            guess[:, self._columns] = self._positions(line, to)
            state = kinematics.close(guess, most=MOST_CORRECTIONS, leaves=leaves)
            new = Rows.along(kinematics, state, self._way[line])
            # Towards a dead point the derivatives grow without bound: a step can be short enough
            # to extrapolate to its end, and too long to interpolate over it.
            back = np.abs(new.after(-length) - at.x) * layout.scale
            error = np.maximum(state.correction, np.max(back, axis=1, initial=0.0))
            error /= allowed_error(state.condition) if self._leads else ALLOWED_ERROR
            is_safe = kinematics.same_side(state, [inverse[line] for inverse in self._inverses])
            is_safe &= state.residual < CLOSURE_TOLERANCE
            if self._leads:
                is_safe &= state.condition < _AMBIGUOUS_CONDITION
            taken = is_safe & (error < REJECTED)
            # What is not a number counts as the greatest error.
            ratio = np.fmax(np.cbrt(aim / np.maximum(error, 1e-6)), _SHORTER)
            step[line] = length * np.minimum(ratio, np.where(taken, _LONGER, _AFTER_REJECTION))
            chosen: Array | slice = slice(None)
            if not taken.all():
                (chosen,) = np.nonzero(taken)
                # Loops that are open beyond say more than steps that were too long.
                (failed,) = np.nonzero(~taken)
                is_told = ~(state.residual[failed] < CLOSURE_TOLERANCE)
                is_told |= self.tried[line[failed]] <= share[line[failed]]
                failed = failed[is_told]
                lost = line[failed]
                self.tried[lost], self.residual[lost] = to[failed], state.residual[failed]
            done, to, length, new = line[chosen], to[chosen], length[chosen], new.of(chosen)
            passed(done, to, at.of(chosen), new)
            share[done] = to
            if done.size == line.size and (to == self._whole).all():
                self.x[done] = new.x
                return
            longest[done] = new.longest(layout)
            if self._leads:
                # The margin is taken to fall in proportion to the distance from where it vanishes.
                margins = 1.0 / state.condition[chosen]
                before, self._margin[done] = self._margin[done], margins
                approach = _APPROACH * length * margins / np.maximum(before - margins, 0.0)
                step[done] = np.fmin(step[done], approach)
                longest[done] = np.fmin(longest[done], approach)
            rows.keep(done, new)
            for inverse, after in zip(self._inverses, state.inverses, strict=True):
                inverse[done] = after[chosen]

    def _positions(self, lines: Array, share: Array) -> Array:
        """Return drive positions `(K, d)` at shares `(K,)` of lines, exact at their ends."""
        between = self._begins[lines] + share[:, None] * self._way[lines]
        return np.where(share[:, None] == 1.0, self._ends[lines], between)


_Passed = Callable[[Array, Array, Rows, Rows], None]
"""Is told of steps: which lines took them, their shares afterwards, and rows before and after."""


def allowed_error(condition: Array) -> Array:
    """Return how far extrapolations may be off [rad], from the condition numbers they lead to.

    Other assembly modes come nearer in proportion to the condition number.
    """
    return ALLOWED_ERROR * np.minimum(1.0, 1.0 / SAFE_CORRECTION / condition)


def follow(kinematics: Kinematics, start: Array, columns: list[int], positions: Array) -> Array:
    """Return closed coordinates `(N, size)` at drive positions `(N, d)`.

    Args:
        kinematics: of the scene.
        start: `(size,)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: in the order in which they are followed [rad or m].

    Raises:
        AssemblyError: the loops cannot be closed on the way to a sample.
    """
    result = np.empty((len(positions), start.size))
    last, count, batch_size = start, 0, _SMALLEST_BATCH
    while count < len(positions):
        targets = positions[count : count + batch_size]
        before = kinematics.evaluate(last[None, :])
        with np.errstate(all="ignore"):  # Targets out of reach may overflow; they are not safe.
            rows = Rows.along(kinematics, before, targets - last[columns])
            guess = rows.after(np.ones(len(targets)))
            guess[:, columns] = targets
            state = kinematics.close(guess, most=MOST_CORRECTIONS)
            is_safe = rows.longest(kinematics.coordinates) >= 1.0
            is_safe &= state.correction < REJECTED * ALLOWED_ERROR
            is_safe &= state.residual < CLOSURE_TOLERANCE
            is_safe &= kinematics.same_side(state, before.inverses)
        reached = len(targets) if np.all(is_safe) else int(np.argmin(is_safe))
        batch_size = min(max(2 * reached, _SMALLEST_BATCH), _LARGEST_BATCH)
        if reached:
            result[count : count + reached] = state.x[:reached]
        else:
            way = along_lines(kinematics, last[None, :], columns, targets[:1])
            if not way.is_there[0]:
                from ..diagnosis.reach import beyond_line  # Imported here: only errors need it.

                ended = way.x[0], way.residual[0]
                raise beyond_line(kinematics, columns, targets[0], *ended, count)
            result[count], reached = way.x[0], 1
        count += reached
        last = result[count - 1]
    return result
