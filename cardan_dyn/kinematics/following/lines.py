"""Lines: closed positions that drives lead to along straight lines, followed step by step.

Positions of several drives have no order. What configuration a position means is therefore defined
by the straight line of drive positions from the start to it, whatever other samples there are. All
lines advance together, each with steps of its own length: every step has a predictor (extrapolation
by two derivatives), a corrector (Newton's method) and a control, which keeps steps so short that
Newton's method cannot change the assembly mode. The branch of a single drive is two such lines
whose nodes are kept. As these lead on, its steps become shorter towards singular configurations,
where assembly modes meet; samples at the ends of lines may be singular, and are refused later.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import BLOCK_SIZE, Array
from ...errors import AssemblyError, as_text
from ...mechanism.coordinates import Coordinates
from ..closing.all_groups import ClosedState, Kinematics
from ..tolerances import CLOSURE_TOLERANCE

ALLOWED_ERROR = 0.03
"""Error [rad] of an extrapolation that steps are chosen for where the closure equations are well
conditioned: small against the distance between assembly modes."""
_WELL_CONDITIONED = 100.0
"""Condition number up to which `ALLOWED_ERROR` holds undiminished."""
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
LONGEST_WAY = 1.0
"""Greatest displacement [rad] of a coordinate in a step, by each of its first two derivatives. Of
longer steps some end by accident near other solutions, often whole turns of a joint away."""
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
_TRIED = np.array([1.8, 1.1, 0.65])
"""Ratios to the step that errors let expect, longest first, which are tried together where nodes
are proven afterwards: a round takes about as long for several, and the longest that is safe leads
farther than one that was chosen beforehand."""
_SHORTEST = 1e-9
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
        return Rows.of_rates(kinematics.coordinates, x, v, a)

    @staticmethod
    def of_rates(layout: Coordinates, x: Array, v: Array, a: Array) -> Rows:
        """Return the rows at joint velocities and accelerations `(K, nv)`."""
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
        condition: `(N,)` greatest condition number on the line, as far as it was followed.
        left: `(N,)` error of `x` as far as a step tells, see `GroupState.left`.
    """

    x: Array
    is_there: Array
    residual: Array
    condition: Array
    left: Array

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

    def of_lines(self, first: int, last: int) -> tuple[slice, OnLines]:
        """Return which samples lie on some of the lines, and these samples."""
        begin, end = np.searchsorted(self.line, [first, last])
        span = slice(int(begin), int(end))
        return span, OnLines(self.line[span] - first, self.share[span])


def along_lines(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    positions: Array,
    begin: ClosedState | None = None,
) -> Reached:
    """Follow the straight lines from closed coordinates to drive positions `(N, d)`.

    Args:
        kinematics: of the drives and the groups that they move.
        starts: `(N, size)` or `(1, size)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: [rad or m].
        begin: state of a single start, if it is known.
    """
    count = len(positions)
    samples = OnLines(np.arange(count), np.ones(count))
    return samples_on_lines(kinematics, starts, columns, positions, samples, begin)


def samples_on_lines(
    kinematics: Kinematics,
    starts: Array,
    columns: list[int],
    ends: Array,
    samples: OnLines,
    begin: ClosedState | None = None,
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
        begin: state of a single start, if it is known.
    """
    count, size = len(samples.line), starts.shape[1]
    if len(starts) == 1 < len(ends) and begin is None:
        begin = kinematics.evaluate(starts)
    reached = Reached(np.empty((count, size)), np.empty(count, dtype=bool), *np.empty((3, count)))
    for first in range(0, len(ends), BLOCK_SIZE):
        chosen = slice(first, first + BLOCK_SIZE)
        span, own = samples.of_lines(first, first + BLOCK_SIZE)
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
        condition: `(L,)` condition number there.
        greatest: `(L,)` greatest condition number at the steps that were taken.
        nodes: after `to_ends`, the lines (index) and coordinates that each round has reached.
    """

    def __init__(
        self,
        kinematics: Kinematics,
        starts: Array,
        columns: list[int],
        ends: Array,
        begin: ClosedState | None = None,
    ) -> None:
        """Begin at the starts; arguments as of `samples_on_lines`, with one start or L."""
        self._kinematics, self._columns = kinematics, columns
        self._begin = kinematics.evaluate(starts) if begin is None else begin
        self.x = starts.repeat(len(ends) // len(starts), axis=0) if len(starts) else starts.copy()
        begins = self.x[:, columns]
        self._begins, self._ends, self._way = begins, ends, ends - begins
        units = kinematics.coordinates.scale[columns]
        self._extent = np.max(np.abs(self._way) * units, axis=1, initial=0.0)
        self.share, self.tried, self.residual = np.zeros((3, len(ends)))
        self.condition = np.ones(len(ends))
        self.greatest = self._begin.condition.repeat(len(ends) // max(len(starts), 1))
        self.nodes: list[tuple[Array, Array]] = []

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

        self._follow(passed, 1.0 if len(keys) <= len(self.x) else _BETWEEN)
        is_there = samples.share <= self.share[samples.line]
        values[~is_there] = self.x[samples.line[~is_there]]
        of_lines = self.residual[samples.line], self.greatest[samples.line]
        return Reached(values, is_there, *of_lines, np.full(len(values), np.inf))

    def to_ends(self, rows: Rows, quick: bool) -> None:
        """Follow all lines of a single drive as far as they lead, and keep all nodes.

        Args:
            rows: at the starts, with derivatives with respect to the drive.
            quick: take one Newton step per node, which leaves an error of its square, and of steps
                of several lengths the longest that is safe; who uses the nodes closes them and
                proves that each leads on to the next.
        """

        def passed(lines: Array, to: Array, old: Rows, new: Rows) -> None:
            self.nodes.append((lines, new.x))

        way = self._way
        begin = Rows(self.x, way * rows.first, way**2 * rows.second)
        self._follow(passed, 1.0, quick, begin)

    def _follow(
        self, passed: _Passed, aim: float, quick: bool = False, begin: Rows | None = None
    ) -> None:
        with np.errstate(all="ignore"):  # Steps out of reach may overflow; they are not safe.
            self._steps(passed, aim, quick, begin)
        # What failed before a line passed it says nothing any more.
        is_beyond = self.tried < self.share
        self.residual[is_beyond], self.condition[is_beyond] = 0.0, 1.0

    def _steps(self, passed: _Passed, aim: float, quick: bool, begin: Rows | None) -> None:
        """Take steps until no line goes on.

        Args:
            passed: is told of the steps that were taken.
            aim: part of the allowed error that steps are chosen for.
            quick: see `to_ends`.
            begin: rows at the starts of lines that lead on, and so keep clear of singular
                configurations; None where only their ends count.
        """
        kinematics, layout, share = self._kinematics, self._kinematics.coordinates, self.share
        state = self._begin
        rows = begin or Rows.along(kinematics, state, self._way)._replace(x=self.x)
        self.condition[:] = state.condition
        margin = 1.0 / self.condition
        longest, step = rows.longest(layout), np.ones(len(share))
        if begin or aim < 1.0:
            # Of the first step no error is known yet; of several, the longest may lead as far.
            step = longest / _TRIED[0] if quick else _FIRST_STEP * longest
        if begin:
            longest = np.minimum(longest, _SINGULAR_DISTANCE * margin / self._extent)
            step = np.minimum(step, longest)
        shortest = _SHORTEST / self._extent
        if not begin:
            shortest = np.minimum(shortest, _SHORTEST)
        inverses = [inverse.repeat(len(share) // len(inverse), 0) for inverse in state.inverses]
        ratios = _TRIED if quick else np.ones(1)
        active = np.arange(len(share))
        while True:
            # Written so that what is not a number stops as well.
            active = active[(share[active] < 1.0) & (step[active] >= shortest[active])]
            if not active.size:
                return
            line = active.repeat(len(ratios))
            remaining = 1.0 - share[line]
            length = np.multiply.outer(step[active], ratios).ravel()
            length = np.minimum(np.minimum(length, longest[line]), remaining)
            to = np.where(length == remaining, 1.0, share[line] + length)
            at = rows.of(line)
            guess = at.after(length)
            guess[:, self._columns] = self._positions(line, to)
            if quick:
                state = kinematics.newton_step(guess)
            else:
                state = kinematics.close(guess, most=MOST_CORRECTIONS, leaves=NEAR)
            new = Rows.along(kinematics, state, self._way[line])
            # Towards a dead point the derivatives grow without bound: a step can be short enough
            # to extrapolate to its end, and too long to interpolate over it.
            back = np.abs(new.after(-length) - at.x) * layout.scale
            error = np.maximum(state.correction, np.max(back, axis=1, initial=0.0))
            error /= allowed_error(state.condition) if begin else ALLOWED_ERROR
            is_safe = kinematics.same_side(state, [inverse[line] for inverse in inverses])
            is_safe &= error < REJECTED
            if begin:
                is_safe &= state.condition < _AMBIGUOUS_CONDITION
            if not quick:
                is_safe &= state.residual < CLOSURE_TOLERANCE
            # Of every line the longest step that is safe, or the shortest.
            safe = is_safe.reshape(-1, len(ratios))
            longest_safe = np.where(safe.any(axis=1), safe.argmax(axis=1), len(ratios) - 1)
            best = np.arange(0, len(line), len(ratios)) + longest_safe
            taken = is_safe[best]
            # What is not a number counts as the greatest error.
            ratio = np.fmax(np.cbrt(aim / np.maximum(error[best], 1e-6)), _SHORTER)
            most = np.where(taken, _LONGER, _AFTER_REJECTION)
            step[active] = length[best] * np.minimum(ratio, most)
            if is_safe.all() and len(ratios) == 1:
                chosen: Array | slice = slice(None)
            else:
                chosen = best[taken]
                # Loops that are open beyond say more than steps that were too long.
                failed, lost = best[~taken], active[~taken]
                is_told = ~(state.residual[failed] < CLOSURE_TOLERANCE)
                is_told |= self.tried[lost] <= share[lost]
                failed, lost = failed[is_told], lost[is_told]
                self.tried[lost], self.residual[lost] = to[failed], state.residual[failed]
                self.condition[lost] = state.condition[failed]
            done, to, length, new = line[chosen], to[chosen], length[chosen], new.of(chosen)
            passed(done, to, at.of(chosen), new)
            share[done] = to
            self.greatest[done] = np.maximum(self.greatest[done], state.condition[chosen])
            if done.size == active.size and (to == 1.0).all():
                self.x[done] = new.x
                return
            longest[done] = new.longest(layout)
            if begin:
                # The margin is taken to fall in proportion to the distance from where it vanishes.
                margins = 1.0 / state.condition[chosen]
                approach = _APPROACH * length * margins / np.maximum(margin[done] - margins, 0.0)
                step[done], margin[done] = np.fmin(step[done], approach), margins
                longest[done] = np.fmin(longest[done], approach)
            rows.keep(done, new)
            for inverse, after in zip(inverses, state.inverses, strict=True):
                inverse[done] = after[chosen]

    def tried_at(self, line: int) -> Array:
        """Return the drive positions `(d,)` that were tried last on a line."""
        (position,) = self._positions(np.array([line]), self.tried[[line]])
        return np.asarray(position)

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
    return ALLOWED_ERROR * np.minimum(1.0, _WELL_CONDITIONED / condition)


def is_safe_step(kinematics: Kinematics, state: ClosedState, inverses: list[Array]) -> Array:
    """Return `(N,)` whether closed states are in the assembly mode that a step began in.

    Args:
        kinematics: that closed them.
        state: after the step.
        inverses: of every group's closure equations before it.
    """
    is_safe = state.correction < REJECTED * ALLOWED_ERROR
    is_safe &= state.residual < CLOSURE_TOLERANCE
    return np.asarray(is_safe & kinematics.same_side(state, inverses))


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
        state, is_safe = _one_step(kinematics, last, columns, targets)
        reached = len(targets) if np.all(is_safe) else int(np.argmin(is_safe))
        batch_size = min(max(2 * reached, _SMALLEST_BATCH), _LARGEST_BATCH)
        if reached:
            result[count : count + reached] = state.x[:reached]
        else:
            way = along_lines(kinematics, last[None, :], columns, targets[:1])
            if not way.is_there[0]:
                raise beyond_reach(
                    kinematics, columns, targets[0], way.x[0], way.residual[0], count
                )
            result[count], reached = way.x[0], 1
        count += reached
        last = result[count - 1]
    return result


def _one_step(
    kinematics: Kinematics, last: Array, columns: list[int], targets: Array
) -> tuple[ClosedState, Array]:
    """Close the loops at targets `(K, d)`, each in one step; return `(K,)` whether it is safe."""
    before = kinematics.evaluate(last[None, :])
    with np.errstate(all="ignore"):  # Targets out of reach may overflow; they are not safe.
        rows = Rows.along(kinematics, before, targets - last[columns])
        guess = rows.after(np.ones(len(targets)))
        guess[:, columns] = targets
        state = kinematics.close(guess, most=MOST_CORRECTIONS)
        is_safe = is_safe_step(kinematics, state, before.inverses)
    return state, is_safe & (rows.longest(kinematics.coordinates) >= 1.0)


def beyond_reach(
    kinematics: Kinematics,
    columns: list[int],
    target: Array,
    nearest: Array,
    residual: float,
    sample: int,
) -> AssemblyError:
    """Return the error for drive positions that a straight line does not reach.

    Args:
        kinematics: that closed the loops.
        columns: columns of the drives in a row of coordinates.
        target: `(d,)` positions that were asked for [rad or m].
        nearest: `(size,)` closed coordinates where the line ended.
        residual: closure error of the step beyond.
        sample: index of the target.
    """
    from ..diagnosis.singularities import gimbal_note  # Only errors need it.

    passives = [column for solver in kinematics.solvers for column in solver.group.passives]
    note = gimbal_note(kinematics.coordinates, nearest, passives)
    return AssemblyError(
        f"the loops cannot be closed at drive positions {as_text(target)}; on the way there the "
        f"nearest that were reached are {as_text(nearest[columns])}{note}",
        position=target.copy(),
        nearest=nearest[columns].copy(),
        residual=float(residual),
        sample=sample,
        hint=note,
    )
