"""Straight lines: closed positions that several drives lead to along straight lines from the start.

Positions of several drives have no order along which a branch could be kept. What configuration a
position means is therefore defined by the straight line of drive positions from the start to it,
whatever other samples there are. All samples advance together, each with steps of its own length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import AssemblyError, as_text
from ...mechanism.coordinates import Coordinates
from ..closing.all_groups import ClosedState, Kinematics
from ..tolerances import CLOSURE_TOLERANCE

SAFE_STEP = 0.1
"""Error [rad] up to which an extrapolation is taken to end in the same assembly mode. It may be
greater than `SAFE_CORRECTION`, since nothing is interpolated between these samples, and every step
is also checked for a change of side of a singular configuration."""
_LONGEST_WAY = 1.0
"""Greatest displacement [rad] of a coordinate in a step, by each of its first two derivatives. Of
longer steps some end by accident near other solutions, often whole turns of a joint away."""
MOST_CORRECTIONS = 6
"""Greatest number of Newton steps per sample. Convergence is quadratic: from a safe extrapolation
about four steps reach rounding. What needs more is tried again from nearer by."""
_NEAR = 1e-6
"""Newton step [rad] after which a sample on a line is closed well enough for the next step: what is
left is its square, some 1e-12, far below `CLOSURE_TOLERANCE`. Who uses it takes another step."""
_AIM = 0.03
"""Error [rad] that steps are chosen for. Extrapolations of second order are off by the third power
of the step, so that a step is a third shorter than one that is just safe, and few are in vain."""
_AIM_BETWEEN = 0.01
"""The same where samples between the steps are interpolated: these are then off by some 3e-5, which
two Newton steps make rounding."""
_FIRST_STEP_BETWEEN = 0.4
"""First step of such lines, as a part of the longest that is allowed."""
_LONGER, _SHORTER = 4.0, 0.1
"""Greatest and smallest ratio of a step to the one before it."""
_SMALLEST_SHARE = 1e-9
"""Share of the remaining way to a sample that is tried last, before the sample counts as out of
reach."""
BLOCK_SIZE = 768
"""Greatest number of samples that advance together, so that their arrays stay in the cache."""


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
    kinematics: Kinematics, starts: Array, columns: list[int], positions: Array
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
    kinematics: Kinematics, starts: Array, columns: list[int], ends: Array, samples: OnLines
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
    starts = np.broadcast_to(starts, (len(ends), size))
    reached = Reached(np.empty((count, size)), np.empty(count, dtype=bool), np.empty(count))
    for first in range(0, len(ends), BLOCK_SIZE):
        lines = slice(first, first + BLOCK_SIZE)
        span, own = samples.of_lines(first, first + BLOCK_SIZE)
        block = _Lines(kinematics, starts[lines], columns, ends[lines], own).followed()
        for whole, values in zip(reached, block, strict=True):
            whole[span] = values
    return reached


class _Rows(NamedTuple):
    """Rows of coordinates as functions of the share of a line that was followed.

    Attributes:
        x: `(K, size)`.
        first: derivatives.
        second: half of the second derivatives.
    """

    x: Array
    first: Array
    second: Array

    def of(self, lines: Array) -> _Rows:
        """Return the rows of some lines."""
        return _Rows(*(values[lines] for values in self))

    def keep(self, lines: Array, rows: _Rows) -> None:
        """Overwrite the rows of some lines."""
        for values, new in zip(self, rows, strict=True):
            values[lines] = new


class _Lines:
    """Straight lines that are followed together: all steps of a round are one set of arrays."""

    def __init__(
        self,
        kinematics: Kinematics,
        starts: Array,
        columns: list[int],
        ends: Array,
        samples: OnLines,
    ) -> None:
        """Begin at the starts; arguments as of `samples_on_lines`."""
        self._kinematics, self._columns = kinematics, columns
        self._begins, self._ends, self._way = starts[:, columns], ends, ends - starts[:, columns]
        self._x, count = starts.copy(), len(ends)
        self._share, self._residual = np.zeros(count), np.zeros(count)
        # Samples are sought by the number of their line and half of their share.
        self._samples, self._keys = samples, samples.line + 0.5 * samples.share
        self._values = starts[samples.line]
        self._aim = _AIM if len(samples.line) <= count else _AIM_BETWEEN
        self._next = np.searchsorted(self._keys, np.arange(count), side="right")

    def followed(self) -> Reached:
        """Follow all lines to their ends, or as far as they lead."""
        with np.errstate(all="ignore"):  # Steps out of reach may overflow; they are not safe.
            self._follow()
        samples, share = self._samples, self._share
        is_there = samples.share <= share[samples.line]
        self._values[~is_there] = self._x[samples.line[~is_there]]
        return Reached(self._values, is_there, self._residual[samples.line])

    def _follow(self) -> None:
        kinematics, coordinates = self._kinematics, self._kinematics.coordinates
        share, way = self._share, self._way
        before = kinematics.evaluate(self._x)
        rows = _Rows(self._x, *_derivatives(kinematics, before, way))
        longest, step = longest_way(coordinates, rows.first, rows.second), np.ones(len(share))
        if self._aim < _AIM:
            # Of the first step no error is known yet.
            step = _FIRST_STEP_BETWEEN * longest
        inverses = [inverse.copy() for inverse in before.inverses]
        active = np.arange(len(share))
        while active.size:
            remaining = 1.0 - share[active]
            length = np.minimum(np.minimum(step[active], longest[active]), remaining)
            is_last = length == remaining
            to = np.where(is_last, 1.0, share[active] + length)
            at = rows.of(active)
            guess = at.x + length[:, None] * (at.first + length[:, None] * at.second)
            guess[:, self._columns] = self._positions(active, to)
            state = kinematics.close(guess, most=MOST_CORRECTIONS, enough=_NEAR)
            is_safe = is_safe_step(kinematics, state, [inverse[active] for inverse in inverses])
            step[active] = length * _ratios(state.correction, is_safe, self._aim)
            self._residual[active] = state.residual
            done = active[is_safe]
            new = _Rows(state.x, *_derivatives(kinematics, state, way[active])).of(is_safe)
            self._pass(done, to[is_safe], rows.of(done), new)
            rows.keep(done, new)
            share[done] = to[is_safe]
            for inverse, after in zip(inverses, state.inverses, strict=True):
                inverse[done] = after[is_safe]
            longest[done] = longest_way(coordinates, new.first, new.second)
            # Written so that what is not a number stops as well.
            goes_on = step[active] >= _SMALLEST_SHARE * (1.0 - share[active])
            active = active[(share[active] < 1.0) & goes_on]

    def _positions(self, lines: Array, share: Array) -> Array:
        """Return drive positions `(K, d)` at shares `(K,)` of lines, exact at their ends."""
        between = self._begins[lines] + share[:, None] * self._way[lines]
        return np.where(share[:, None] == 1.0, self._ends[lines], between)

    def _pass(
        self,
        lines: Array,
        to: Array,
        old: _Rows,
        new: _Rows,
    ) -> None:
        """Keep the coordinates of the samples that a step passes.

        Args:
            lines: `(K,)` those that took the step.
            to: `(K,)` their shares after it.
            old: of these lines before it.
            new: after it.
        """
        begins, ends = self._next[lines], np.searchsorted(self._keys, lines + 0.5 * to, "right")
        self._next[lines] = ends
        counts = ends - begins
        step = np.repeat(np.arange(len(lines)), counts)
        if not step.size:
            return
        passed = np.arange(len(step)) + np.repeat(begins - np.cumsum(counts) + counts, counts)
        length = to - self._share[lines]
        part = (self._samples.share[passed] - self._share[lines][step]) / length[step]
        values = _interpolated(part, step, length, old, new)
        values[:, self._columns] = self._positions(lines[step], self._samples.share[passed])
        at_end = part == 1.0
        values[at_end] = new.x[step[at_end]]
        self._values[passed] = values


def _interpolated(
    part: Array,
    step: Array,
    length: Array,
    old: _Rows,
    new: _Rows,
) -> Array:
    """Return rows `(M, size)` within steps, of fifth order in the length of the step.

    Args:
        part: `(M,)` of the step that is done, between 0 and 1.
        step: `(M,)` the step (index).
        length: `(K,)` of the steps.
        old: before the steps.
        new: after them.
    """
    scale = length[:, None]
    slope, bend = scale * old.first, scale**2 * old.second
    # What the second derivative before the step leaves of rows, and of their derivatives.
    gap = new.x - old.x - slope - bend
    turn = scale * new.first - slope - 2.0 * bend
    change = 2.0 * (scale**2 * new.second - bend)
    third = 10.0 * gap - 4.0 * turn + 0.5 * change
    fourth = -15.0 * gap + 7.0 * turn - change
    fifth = 6.0 * gap - 3.0 * turn + 0.5 * change
    t = part[:, None]
    result = fifth[step]
    for coefficient in (fourth, third, bend, slope, old.x):
        result *= t
        result += coefficient[step]
    return result


def extrapolated(coordinates: Coordinates, x: Array, v: Array, a: Array) -> tuple[Array, Array]:
    """Return rows `(N, size)` after unit time, and `(N,)` after what time at most they may be used.

    Args:
        coordinates: layout of the rows.
        x: `(N, size)` rows before.
        v: joint velocities `(N, nv)`.
        a: joint accelerations `(N, nv)`.
    """
    first, second = coordinates.derivative(x, v), 0.5 * coordinates.curvature(x, v, a)
    return x + (first + second), longest_way(coordinates, first, second)


def longest_way(coordinates: Coordinates, first: Array, second: Array) -> Array:
    """Return `(N,)` after what time at most rows may be extrapolated.

    Args:
        coordinates: layout of the rows.
        first: derivatives `(N, size)` of the rows.
        second: half of their second derivatives.
    """
    fastest, most_bent = (
        np.max(np.abs(way) * coordinates.scale, axis=1, initial=0.0) for way in (first, second)
    )
    with np.errstate(divide="ignore"):
        return np.minimum(_LONGEST_WAY / fastest, np.sqrt(_LONGEST_WAY / most_bent))


def is_safe_step(kinematics: Kinematics, state: ClosedState, inverses: list[Array]) -> Array:
    """Return `(N,)` whether closed states are in the assembly mode that a step began in.

    Args:
        kinematics: that closed them.
        state: after the step.
        inverses: of every group's closure equations before it.
    """
    is_safe = (state.residual < CLOSURE_TOLERANCE) & (state.correction < SAFE_STEP)
    return np.asarray(is_safe & kinematics.same_side(state, inverses))


def _derivatives(kinematics: Kinematics, state: ClosedState, way: Array) -> tuple[Array, Array]:
    """Return how rows `(N, size)` change when drives move by `way (N, d)` in unit time.

    Args:
        kinematics: of the drives.
        state: N closed positions.
        way: what the drives move by.

    Returns:
        Derivatives, and half of the second derivatives.
    """
    v = kinematics.rates(state, way)
    a = kinematics.accelerations(state, v, np.zeros_like(way))
    coordinates = kinematics.coordinates
    return coordinates.derivative(state.x, v), 0.5 * coordinates.curvature(state.x, v, a)


def _ratios(correction: Array, is_safe: Array, aim: float) -> Array:
    """Return `(N,)` how much longer the next steps are than those with these errors `(N,)`."""
    ratios = np.cbrt(aim / np.maximum(correction, 1e-6))
    ratios = np.where(np.isfinite(ratios), np.clip(ratios, _SHORTER, _LONGER), _SHORTER)
    return np.where(is_safe, ratios, np.minimum(ratios, 0.5))


_SMALLEST_BATCH, _LARGEST_BATCH = 8, 512
"""Samples tried at once: few where most of them would be thrown away, and not so many that arrays
become large. Between the two, a batch is twice as large as the last one was successful."""


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
    """Close the loops at targets `(K, d)`, each in one step from closed coordinates `(size,)`.

    Returns:
        The states, and `(K,)` whether they are in the same assembly mode.
    """
    coordinates = kinematics.coordinates
    before = kinematics.evaluate(last[None, :])
    x = np.broadcast_to(last, (len(targets), last.size))
    step = targets - last[columns]
    with np.errstate(all="ignore"):  # Targets out of reach may overflow; they are not safe.
        v = kinematics.rates(before, step)
        a = kinematics.accelerations(before, v, np.zeros_like(step))
        guess, longest = extrapolated(coordinates, x, v, a)
        guess[:, columns] = targets
        state = kinematics.close(guess, most=MOST_CORRECTIONS)
        is_safe = is_safe_step(kinematics, state, before.inverses) & (longest >= 1.0)
    return state, is_safe


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
