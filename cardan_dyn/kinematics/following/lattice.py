"""Lattice: closed positions near many samples of several drives, found once for all of them.

Thousands of straight lines from one start run beside each other. Where samples are dense, their
lines are replaced by those of the points of a lattice: a line goes from lattice point to lattice
point, each the nearest one to it, and all lines that pass a point share what is known there.
So no line is farther than the lattice's spacing from the sample's own, and as on a single line
every step from point to point is tried: a line one step of which is not safe is not used. Where a
drive moves last and alone, nothing singular lies between its points and the samples beside them;
whether the mechanism comes back after a turn is then the same for both. Guesses at samples are
interpolated between the points around them. Points stay for later calls, and the more samples there
were, the finer a lattice becomes, as the branch of a single drive does.

It is there for speed alone: without it, sweeps of the universal joint over random input and joint
angles took 1.3 times the processor time at 1000 samples, 2.7 times at 10 000 and 3.2 times at
100 000; on six legs of a platform it makes no difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property, reduce
from itertools import product
from operator import getitem
from typing import NamedTuple

import numpy as np

from ... import compiled
from ...arrays import Array, blocks
from ...compiled import Plan
from ..closing.all_groups import ClosedState, Kinematics
from .branch import whole_turns
from .lines import (
    ALLOWED_ERROR,
    LONGEST_WAY,
    MOST_CORRECTIONS,
    NEAR,
    REJECTED,
    Rows,
    allowed_error,
    is_safe_step,
)

_GREATEST_SPACING = 0.4
"""Spacing [rad] of the coarsest lattice, beyond which steps are hardly ever safe."""
_SMALLEST_SPACING = 0.02
"""Spacing [rad] of the finest lattice: extrapolations over half of it are off by the third power,
some 1e-7, which one Newton step makes rounding."""
_SAMPLES_PER_POINT = 12
"""Samples that a lattice point is to serve before the lattice becomes finer, so that points take
no more of the time of their samples than the Newton step that better guesses spare these."""
_FEWEST_PER_POINT = 4
"""Samples per point below which every line is followed by itself: a point takes several steps, one
from each of its neighbours that lines come from."""
_SAMPLES_PER_STEP = 48
"""Samples per step from point to point before the lattice becomes finer. Points that lie in a row,
as of one turn of a drive while the others hardly move, are closed one after the other, each for the
calls that many samples beside each other take."""
_FEW = 0.25
"""Share of the samples up to which a finer lattice is left out where whole turns were taken off
them: designs that represent others serve so few sooner."""
_CLEAR = 0.5
"""Greatest product of a condition number and how far joints move between the points that one drive
passes alone and a sample beside them. A singular configuration between both would make it 3 or
more, see `joint_motion`; half of that is for joints that move the faster the nearer they come to a
dead point, the rest for positions between the points."""
_MOST_AROUND = 3
"""Drives up to which guesses are interpolated between the points around: of d drives there are 2ᵈ,
and it takes the time of a Newton step to read what is known at eight of them."""
_MOST_KEYS = 2**62
"""Greatest number of lattice points in the box of all samples: each has a whole number as key."""
_MOST_MARKS = 16
"""Greatest key of points, in samples, up to which they are marked in an array of all keys: that
takes a tenth of the time of sorting where they are few."""
_MOST_KEPT = 1_000_000
"""Numbers that are known at the points of a lattice, up to which it is kept for later calls."""
_MOST_LATTICES = 4
"""Lattices that are kept: a call that finds no point takes two or three of them."""
_MOST_PASSED = 100_000
"""Points that the lines pass which are worked on at a time."""


def spacing_for(ahead: Array, finer_than: float = np.inf, before: int = 0) -> float | None:
    """Return the spacing [rad] of a lattice that pays for samples, None if none does.

    Args:
        ahead: `(N, d)` displacements of the drives from the start, slides in lengths.
        finer_than: spacing that was too coarse for these samples [rad].
        before: samples of earlier calls, which let expect as many in later ones.
    """
    spacing, samples = min(_GREATEST_SPACING, 0.5 * finer_than), len(ahead) + before
    if spacing < _SMALLEST_SPACING or _count(ahead, spacing) * _FEWEST_PER_POINT > len(ahead):
        return None
    farthest = max((float(np.max(np.abs(column), initial=0.0)) for column in ahead.T), default=0.0)
    least = 2.0 * max(_SMALLEST_SPACING, farthest * _SAMPLES_PER_STEP / max(1, samples))
    most = min(samples / _SAMPLES_PER_POINT, len(ahead) / _FEWEST_PER_POINT)
    while spacing >= least and _count(ahead, 0.5 * spacing) <= most:
        spacing *= 0.5
    return spacing


class Turn(NamedTuple):
    """A drive that comes back to where it was, whose whole turns were taken off samples.

    Attributes:
        drive: index of it among the drives.
        period: displacement after which it does [rad].
        taken: `(N,)` periods that were taken off samples, which lie within half of one now.
        turns: `(N, size)` whole turns of all coordinates; those in the periods taken are added
            where a lattice serves.
    """

    drive: int
    period: float
    taken: Array
    turns: Array


def near_lattices(
    kinematics: Kinematics,
    start: Array,
    columns: list[int],
    positions: Array,
    units: Array,
    legs: Sequence[list[int]],
    turn: Turn | None = None,
    kept: KeptLattices | None = None,
) -> tuple[Array, Array]:
    """Return coordinates `(N, size)` near closed ones where lattices serve, NaN elsewhere.

    With their errors `(N,)`, see `GroupState.left`. Where one lattice is too coarse for some
    samples, a finer one is tried.

    Args:
        kinematics: see `near_lattice`, as for the others.
        start: likewise.
        columns: likewise.
        positions: `(N, d)` of the drives [rad or m].
        units: `(d,)` displacements of the drives that count as one radian [rad or m].
        legs: likewise.
        turn: a drive whose whole turns were taken off; it moves last, and alone.
        kept: likewise.
    """
    x, left = np.full((len(positions), start.size), np.nan), np.full(len(positions), np.inf)
    rest, spacing = np.arange(len(positions)), np.inf
    ahead, before = (positions - start[columns]) / units, 0
    if kept is not None:
        before, kept.samples = kept.samples, kept.samples + len(positions)
    while rest.size and (found := spacing_for(ahead[rest], spacing, before)) is not None:
        spacing = found
        common = kinematics, start, columns
        given = *common, positions[rest], spacing * units, legs, turn, kept
        rest = rest[~near_lattice(x, left, rest, *given)]
        if turn is not None and len(rest) < _FEW * len(positions):
            break
    return x, left


def near_lattice(
    x: Array,
    left: Array,
    samples: Array,
    kinematics: Kinematics,
    start: Array,
    columns: list[int],
    positions: Array,
    units: Array,
    legs: Sequence[list[int]],
    turn: Turn | None = None,
    kept: KeptLattices | None = None,
) -> Array:
    """Write coordinates one Newton step from a guess between lattice points into some rows.

    Args:
        x: `(N, size)`; the rows of samples to which steps are not safe stay as they are.
        left: `(N,)` likewise; errors of the coordinates, see `GroupState.left`.
        samples: `(K,)` rows (indices) of the samples.
        kinematics: of the drives and the groups that they move.
        start: `(size,)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: `(K, d)` of these samples [rad or m].
        units: `(d,)` spacing of the lattice [rad or m].
        legs: sets of drives that move one after the other.
        turn: see `near_lattices`.
        kept: lattices of earlier calls with the same kinematics, start and legs, to which this one
            is added.

    Returns:
        `(K,)` which rows lie at the end of a sample's line.
    """
    if turn is not None:
        units, steps = units.copy(), np.ceil(0.5 * turn.period / units[turn.drive])
        units[turn.drive] = 0.5 * turn.period / steps
    ahead = (positions - start[columns]) / units
    nearest, count = np.rint(ahead), len(samples)
    alone = legs[-1] if len(legs) > 1 and len(legs[-1]) == 1 else []
    beside = nearest.copy()
    beside[:, alone] = 0.0
    _, chosen, column_of = different(_keys(beside, *_box(beside)))
    ends = np.zeros((0, len(columns)))
    if turn is not None:
        if len(chosen) * (2.0 * steps + 1.0) * _FEWEST_PER_POINT > count:
            return np.zeros(count, dtype=bool)
        ends = np.repeat(beside[chosen][None], 2, axis=0)
        ends[:, :, turn.drive] = np.array([[-steps], [steps]])
        ends = ends.reshape(-1, len(columns))
    common = kinematics, start, columns
    points, end_of = _points_to(np.concatenate([nearest, ends]), *common, units, legs, kept)
    leads, lines = points.leads[end_of], points.lines
    is_there = leads[:count]
    if alone:
        away = np.abs(ahead - nearest)
        away[:, alone] = 0.0
        nearness = points.nearness_along(beside[chosen], alone)
        with np.errstate(invalid="ignore"):  # Singular points are infinitely near.
            is_there &= np.sum(nearness[column_of] * away, axis=1) < _CLEAR
    if turn is not None:
        # If the mechanism is the same half a period back and ahead, it comes back there.
        last = points.x[lines.ends[end_of[count:]]].reshape(2, -1, start.size)
        comes_back, windings = whole_turns(kinematics, *last)
        comes_back &= leads[count:].reshape(2, -1).all(axis=0)
        is_there &= comes_back[column_of] | (turn.taken[samples] == 0.0)
    for block in _blocks(np.nonzero(is_there)[0]):
        near, is_safe = points.near(lines.ends[end_of[block]], positions[block])
        safe = block[is_safe]
        x[samples[safe]], left[samples[safe]] = near.x[is_safe], near.left[is_safe]
        is_there[block] = is_safe
        if turn is not None:
            taken = turn.taken[samples[safe], None]
            turn.turns[samples[safe]] += taken * windings[column_of[safe]]
    return np.asarray(is_there)


def _points_to(
    nearest: Array,
    kinematics: Kinematics,
    start: Array,
    columns: list[int],
    units: Array,
    legs: Sequence[list[int]],
    kept: KeptLattices | None,
) -> tuple[_Points, Array]:
    """Return lattice points on the lines to some of them `(N, d)`, closed.

    Points that were known from earlier calls stay among them.

    Args:
        nearest: where lines end.
        kinematics: see `near_lattice`, as for the others.
        start: likewise.
        columns: likewise.
        units: likewise.
        legs: likewise.
        kept: likewise.

    Returns:
        The points, and `(N,)` which line leads to each.
    """
    known = None if kept is None else kept.of(units)
    _, chosen, end_of = different(_keys(nearest, *_box(nearest)))
    ends = nearest[chosen]
    if known is not None:
        line, is_known = known.lines.line_to(ends)
        if np.all(is_known):
            return known, line[end_of]
        both = np.concatenate([ends, known.lines.ways.ends])
        known = known if _have_keys(np.abs(both)) else None
        ends = ends if known is None else both
    lines, line = lines_to(ends, legs)
    points = _Points(kinematics, start, columns, lines, units)
    if known is not None:
        points.take(known)
    points.close_along()
    if kept is not None:
        kept.keep(points, units)
    return points, line[end_of]


class _Points:
    """The mechanism at lattice points, with its derivatives there.

    Attributes:
        lines: that pass them.
        x: `(M, size)` closed coordinates.
        is_closed: `(M,)` whether they are known.
    """

    def __init__(
        self,
        kinematics: Kinematics,
        start: Array,
        columns: list[int],
        lines: LatticeLines,
        units: Array,
    ) -> None:
        """Begin at the start, which is the lattice point whose coordinates are 0.

        With units `(d,)`: the spacing of the lattice [rad or m].
        """
        self._kinematics, self._columns = kinematics, columns
        self.lines, self._units, self._origin = lines, units, start[columns]
        count, d = lines.points.shape
        self.x = np.repeat(start[None, :], count, axis=0)
        self.is_closed = ~np.any(lines.points, axis=1)
        self._pairs = [(i, j) for i in range(d) for j in range(i, d)]
        # Coordinates, their derivatives with respect to each drive, in units of the spacing, and
        # the second ones with respect to each pair.
        self._jets = np.zeros((count, 1 + d + len(self._pairs), start.size))
        # Condition numbers times how far joints move to the next point in each direction.
        self._nearness = np.zeros((count, d))
        state = kinematics.evaluate(start[None, :])
        self._inverses = [np.repeat(inverse, count, axis=0) for inverse in state.inverses]
        self._keep(np.nonzero(self.is_closed)[0], state, np.ones(1, dtype=bool))
        self._is_good = np.zeros(len(lines.first), dtype=bool)
        # Whether steps along the lines are safe, and were tried, `(E,)` each.
        self._is_tried = self._is_good.copy()

    @property
    def numbers(self) -> int:
        """How many numbers are known at the points."""
        return self._jets.size + sum(inverse.size for inverse in self._inverses)

    def take(self, known: _Points) -> None:
        """Take over what is known at the same points and steps of the same lattice."""
        lines, others = self.lines, known.lines
        index, is_here = lines.index_of(others.points)
        to, of = index[is_here], np.flatnonzero(is_here)
        mine = [self.x, self.is_closed, self._jets, self._nearness, *self._inverses]
        theirs = [known.x, known.is_closed, known._jets, known._nearness, *known._inverses]
        for values, own in zip(mine, theirs, strict=True):
            values[to] = own[of]
        numbers = lines.first * len(lines.keys) + lines.second
        wanted = index[others.first] * len(lines.keys) + index[others.second]
        step = np.minimum(np.searchsorted(numbers, wanted), len(numbers) - 1)
        is_same = is_here[others.first] & is_here[others.second] & known._is_tried
        is_same &= numbers[step] == wanted
        self._is_good[step[is_same]] = known._is_good[is_same]
        self._is_tried[step[is_same]] = True

    @cached_property
    def leads(self) -> Array:
        """On which lines `(L,)` all steps are safe."""
        return self.lines.lead_there(self._is_good)

    def close_along(self) -> None:
        """Close the loops at all points that safe steps lead to."""
        lines, is_good, is_tried = self.lines, self._is_good, self._is_tried
        while True:
            is_open = ~self.is_closed[lines.second]
            waiting = np.nonzero(self.is_closed[lines.first] & is_open & ~is_tried)[0]
            if not waiting.size:
                break
            # One step to each point; the others are compared with what it finds.
            _, chosen = np.unique(lines.second[waiting], return_index=True)
            for block in _blocks(waiting[chosen]):
                is_good[block] = self._close(lines.first[block], lines.second[block])
            is_tried[waiting[chosen]] = True
        is_known = self.is_closed[lines.first] & self.is_closed[lines.second]
        for block in _blocks(np.nonzero(is_known & ~is_tried)[0]):
            is_good[block] = self._agree(lines.first[block], lines.second[block])
        is_tried |= is_known

    def nearness_along(self, columns: Array, alone: list[int]) -> Array:
        """Return how near singular configurations are to columns of points.

        Args:
            columns: a lattice point of each column `(C, d)`.
            alone: the drive (index) that passes the points of a column.

        Returns:
            `(C, d)` greatest product of the condition number and how far joints move per spacing.
        """
        points = np.concatenate([columns, self.lines.points])
        points[:, alone] = 0.0
        _, of = np.unique(_keys(points, *_box(points)), return_inverse=True)
        greatest = np.zeros((1 + int(np.max(of)), len(self._columns)))
        np.maximum.at(greatest, of[len(columns) :], self._nearness)
        return np.asarray(greatest[of[: len(columns)]])

    def near(self, points: Array, positions: Array) -> tuple[ClosedState, Array]:
        """Return what is one Newton step from guesses, and `(N,)` whether it is safe.

        Guesses are interpolated between the points around each position, where these are known:
        that is off by the fourth power of the spacing, and extrapolations by the third. It counts
        as a part of the error by how much both differ, so that points around are trusted no more
        than the one that the line of a sample leads to.

        Args:
            points: `(N,)` the points (indices) nearest to the positions, to begin at.
            positions: `(N, d)` of the drives [rad or m].
        """
        guess, is_short, between, is_known = self._around(points, positions)
        with np.errstate(all="ignore"):
            scale = self._kinematics.coordinates.scale
            apart = np.max(np.abs(between - guess) * scale, axis=1)
            is_known &= apart < ALLOWED_ERROR
            guess[is_known] = between[is_known]
            state = self._kinematics.newton_step(guess)
            error = state.correction + np.where(is_known, apart, 0.0)
            is_safe = is_short & (error < allowed_error(state.condition))
            is_safe &= self._kinematics.same_side(state, [item[points] for item in self._inverses])
        return state, is_safe

    def _around(self, points: Array, positions: Array) -> tuple[Array, Array, Array, Array]:
        """Return what `_extrapolated` does, then what `_interpolated` does."""
        if compiled.kernel is None or len(self._columns) > _MOST_AROUND:
            extrapolated = self._extrapolated(points, positions)
            return (*extrapolated, *self._interpolated(points, positions))
        count, size = len(points), self.x.shape[1]
        (guess, between), (longest, is_known) = np.empty((2, count, size)), np.empty((2, count))
        given = points.astype(float), positions, self._jets, LONGEST_WAY
        around = self.is_closed.astype(float), between, is_known
        compiled.kernel.lattice(self._plan.handle, *given, guess, longest, *around)
        return guess, longest >= 1.0, between, is_known == 1.0

    @cached_property
    def _plan(self) -> Plan:
        """What the compiled function `lattice` works along."""
        _, _, _, _, ways, keys = self.lines
        scale = self._kinematics.coordinates.scale
        numbers = [self.lines.points, ways.low, self._units, self._origin, scale]
        return Plan("lattice", [np.array(self._columns), keys, ways.factors], numbers)

    def _extrapolated(self, points: Array, positions: Array) -> tuple[Array, Array]:
        """Return coordinates `(N, size)` at drive positions, from the derivatives at points.

        Returns:
            The coordinates, and `(N,)` whether the way there is short enough.
        """
        # Twin: `lattice` of compiled/following.c.
        if compiled.kernel is not None:
            guess, longest = np.empty((len(points), self.x.shape[1])), np.empty(len(points))
            given = points.astype(float), positions, self._jets, LONGEST_WAY
            nothing = None, None, None
            compiled.kernel.lattice(self._plan.handle, *given, guess, longest, *nothing)
            return guess, longest >= 1.0
        coordinates, x = self._kinematics.coordinates, self.x[points]
        jets, d = self._jets[points], len(self._columns)
        step = (positions - x[:, self._columns]) / self._units
        first = np.matmul(step[:, None], jets[:, 1 : 1 + d])[:, 0]
        pairs = [step[:, i] * step[:, j] * (0.5 if i == j else 1.0) for i, j in self._pairs]
        second = np.matmul(np.stack(pairs, axis=1)[:, None], jets[:, 1 + d :])[:, 0]
        rows = Rows(x, first, second)
        guess = rows.after(np.ones(len(x)))
        guess[:, self._columns] = positions
        return guess, rows.longest(coordinates) >= 1.0

    def _interpolated(self, points: Array, positions: Array) -> tuple[Array, Array]:
        """Return coordinates `(N, size)` between the points around positions.

        Values and two derivatives agree at all of these: one drive after the other, fifth order
        for coordinates, third for their first derivatives and first for the second.

        Returns:
            The coordinates, and `(N,)` whether all points around are known.
        """
        # Twin: `lattice` of compiled/following.c.
        d, lines = len(self._columns), self.lines
        guess, is_known = self.x[points], np.full(len(points), d <= _MOST_AROUND)
        if d > _MOST_AROUND:
            return guess, is_known
        ahead = (positions - self._origin) / self._units
        nearest = lines.points[points]
        side = np.where(ahead < nearest, -1.0, 1.0)
        share = np.abs(ahead - nearest)
        ends = _hermite(share.T, side.T), _hermite(1.0 - share.T, -side.T)
        guess = np.zeros(guess.shape)
        for corner in product((0, 1), repeat=d):
            at = points
            if any(corner):
                at, is_there = lines.index_of(nearest + side * corner)
                is_known &= is_there & self.is_closed[at]
            weights = _weights([[values[k] for values in ends[c]] for k, c in enumerate(corner)])
            guess += np.matmul(weights[:, None], self._jets[at])[:, 0]
        guess[:, self._columns] = positions
        return guess, is_known

    def _positions(self, points: Array) -> Array:
        """Return drive positions `(K, d)` of points [rad or m]."""
        return np.asarray(self._origin + self.lines.points[points] * self._units)

    def _close(self, first: Array, second: Array) -> Array:
        """Close the loops at points from other points; return `(K,)` whether it was safe."""
        guess, is_short = self._extrapolated(first, self._positions(second))
        with np.errstate(all="ignore"):  # Points out of reach may overflow; they are not safe.
            state = self._kinematics.close(guess, most=MOST_CORRECTIONS, leaves=NEAR)
            inverses = [inverse[first] for inverse in self._inverses]
            is_safe = is_short & is_safe_step(self._kinematics, state, inverses)
            self._keep(second[is_safe], state, is_safe)
        return is_safe

    def _agree(self, first: Array, second: Array) -> Array:
        """Return `(K,)` whether steps lead from points to what is known at other points."""
        kinematics = self._kinematics
        guess, is_short = self._extrapolated(first, self._positions(second))
        guess = kinematics.coordinates.normalised(guess)
        state = kinematics.evaluate(self.x[second])
        error = np.max(np.abs(guess - state.x) * kinematics.coordinates.scale, axis=1)
        inverses = [inverse[first] for inverse in self._inverses]
        is_short &= error < REJECTED * ALLOWED_ERROR
        return np.asarray(is_short & kinematics.same_side(state, inverses))

    def _keep(self, points: Array, state: ClosedState, chosen: Array) -> None:
        """Keep closed coordinates of points with their derivatives.

        With points `(K,)`.
        """
        kinematics, d = self._kinematics, len(self._columns)
        ratios = kinematics.velocity_ratios(state) * self._units
        self.x[points], self.is_closed[points] = state.x[chosen], True
        for inverse, new in zip(self._inverses, state.inverses, strict=True):
            inverse[points] = new[chosen]
        jets, at_rest = np.empty((len(state.x), *self._jets.shape[1:])), np.zeros((len(state.x), d))
        layout = kinematics.coordinates
        jets[:, 0] = state.x
        for i in range(d):
            jets[:, 1 + i] = layout.derivative(state.x, ratios[:, :, i])
        own: dict[int, Array] = {}
        for k, (i, j) in sorted(enumerate(self._pairs), key=lambda pair: pair[1][0] != pair[1][1]):
            v = ratios[:, :, i] if i == j else ratios[:, :, i] + ratios[:, :, j]
            bend = layout.curvature(state.x, v, kinematics.accelerations(state, v, at_rest))
            if i == j:
                own[i] = bend
            else:
                bend = 0.5 * (bend - own[i] - own[j])
            jets[:, 1 + d + k] = bend
        self._jets[points] = jets[chosen]
        moved = np.max(np.abs(jets[chosen, 1 : 1 + d]) * layout.scale, axis=2)
        self._nearness[points] = moved * state.condition[chosen, None]


class KeptLattices:
    """Lattices that are kept for later calls.

    Attributes:
        samples: how many there were in earlier calls.
    """

    def __init__(self) -> None:
        """Begin with none."""
        self.samples = 0
        self._lattices: dict[bytes, _Points] = {}

    def of(self, units: Array) -> _Points | None:
        """Return the lattice of a spacing `(d,)` [rad or m], if there is one."""
        return self._lattices.get(units.tobytes())

    def keep(self, points: _Points, units: Array) -> None:
        """Keep the lattice of a spacing `(d,)` [rad or m] instead of what was known of it."""
        self._lattices.pop(units.tobytes(), None)
        if points.numbers <= _MOST_KEPT:
            # Those come first which were kept longest ago.
            for key in list(self._lattices)[: 1 - _MOST_LATTICES]:
                self._lattices.pop(key, None)  # Another thread may have taken it.
            self._lattices[units.tobytes()] = points


def _hermite(share: Array, way: Array) -> tuple[Array, ...]:
    """Return weights of what is known at one of two points between which is interpolated.

    Args:
        share: `(d, N)` of the way to the other point.
        way: `(d, N)` there: 1 or -1.

    Returns:
        `(d, N)` each: of value, derivative and second derivative in interpolation of fifth order,
        of value and derivative in that of third order, of the value in a linear one.
    """
    rest = 1.0 - share
    square, cube = rest * rest, rest * rest * rest
    return (
        cube * (1.0 + share * (3.0 + 6.0 * share)),
        way * share * cube * (1.0 + 3.0 * share),
        0.5 * share * share * cube,
        square * (1.0 + 2.0 * share),
        way * share * square,
        rest,
    )


def _weights(along: list[list[Array]]) -> Array:
    """Return weights `(N, 1 + d + d (d + 1) / 2)` of a point's coordinates and derivatives.

    Args:
        along: of each drive, see `_hermite`.
    """
    d, (value, slope, bend, cubic_value, cubic_slope, linear) = len(along), range(6)
    kinds = [[value] * d]
    kinds += [[cubic_value] * i + [slope] + [value] * (d - i - 1) for i in range(d)]
    for i in range(d):
        kinds.append([linear] * i + [bend] + [value] * (d - i - 1))
        for j in range(i + 1, d):
            between = [cubic_slope] + [cubic_value] * (j - i - 1) + [slope]
            kinds.append([linear] * i + between + [value] * (d - j - 1))
    return np.stack([reduce(np.multiply, map(getitem, along, own)) for own in kinds], axis=1)


def _count(ahead: Array, spacing: float) -> float:
    """Return how many lattice points displacements `(N, d)` lie near; inf if they are too far."""
    # Columns in a row, since NumPy takes ten times as long for rows of a few numbers.
    nearest = np.rint(ahead.T / spacing).T
    return count_of(nearest) if _have_keys(np.abs(nearest)) else np.inf


def _have_keys(sizes: Array) -> bool:
    """Return whether there are whole numbers for lattice points of such coordinates `(N, d)`."""
    spans = [1.0 + np.max(column, initial=0.0) for column in sizes.T]
    return bool(np.prod(2.0 * np.array(spans)) < _MOST_KEYS)


def _blocks(indices: Array) -> list[Array]:
    """Return indices of samples in blocks."""
    return [indices[block] for block in blocks(len(indices))]


class _Ways(NamedTuple):
    """Lines of L points, each as far as its end.

    Attributes:
        ends: `(L, d)` lattice points at which they end, in units of the spacing; the start is 0.
        lengths: `(L, k)` steps of each leg.
        legs: sets of drives that move one after the other.
        low: `(d,)` least coordinates of a point.
        factors: `(d,)` by which coordinates are multiplied in its key.
    """

    ends: Array
    lengths: Array
    legs: Sequence[list[int]]
    low: Array
    factors: Array

    @property
    def counts(self) -> Array:
        """Points on each line `(L,)`, both ends included; two where it leads nowhere."""
        return np.asarray(np.maximum(np.sum(self.lengths, axis=1), 1) + 1)

    def pieces(self) -> Iterator[slice]:
        """Yield lines that are worked on at a time."""
        of_piece = np.cumsum(self.counts) // _MOST_PASSED
        ends = np.nonzero(np.diff(of_piece, append=of_piece[-1:] + 1))[0] + 1
        begin = 0
        for end in ends.tolist():
            yield slice(begin, end)
            begin = end

    def passed(self, lines: slice) -> tuple[Array, Array]:
        """Return the keys `(K,)` of all points on lines, and where in them each line begins."""
        ends, lengths, counts = self.ends[lines], self.lengths[lines], self.counts[lines]
        begins = np.cumsum(counts) - counts
        line_of = np.repeat(np.arange(len(ends)), counts)
        count = np.arange(len(line_of)) - begins[line_of]
        on_lines = np.zeros((len(line_of), ends.shape[1]))
        for leg, length in zip(self.legs, lengths.T, strict=True):
            done = np.minimum(count, length[line_of])
            share = done / np.maximum(length, 1)[line_of]
            on_lines[:, leg] = np.rint(ends[line_of][:, leg] * share[:, None])
            count = count - done
        return _keys(on_lines, self.low, self.factors), begins

    def steps(self, keys: Array, lines: slice) -> tuple[Array, Array]:
        """Return the numbers `(S,)` of the steps of lines, and where in them each line begins."""
        passed, begins = self.passed(lines)
        point_of = np.searchsorted(keys, passed)
        is_first = np.zeros(len(passed), dtype=bool)
        is_first[begins] = True
        to = np.nonzero(~is_first)[0]
        return point_of[to - 1] * len(keys) + point_of[to], begins - np.arange(len(begins))


class LatticeLines(NamedTuple):
    """Lines from the start to lattice points.

    Attributes:
        points: `(M, d)` lattice points on any of them, in units of the spacing; the start is 0.
        first, second: `(E,)` points (indices) that a step leads between.
        ends: `(L,)` points (indices) at which the lines end.
        ways: their points.
        keys: `(M,)` of the points, ascending.
    """

    points: Array
    first: Array
    second: Array
    ends: Array
    ways: _Ways
    keys: Array

    def index_of(self, points: Array) -> tuple[Array, Array]:
        """Return `(N,)` indices of lattice points `(N, d)`, and whether they are among them."""
        keys = _keys(points, self.ways.low, self.ways.factors)
        index = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        # Points outside the box of the lines may have the key of another one.
        return index, np.all(self.points[index] == points, axis=1)

    def line_to(self, points: Array) -> tuple[Array, Array]:
        """Return which line (index) ends at lattice points `(N, d)`, and whether one does."""
        index, is_there = self.index_of(points)
        # Both ascend by their keys.
        line = np.minimum(np.searchsorted(self.ends, index), len(self.ends) - 1)
        return line, is_there & (self.ends[line] == index)

    def lead_there(self, is_good: Array) -> Array:
        """Return `(L,)` on which lines all steps are good, of which `(E,)` are."""
        numbers = self.first * len(self.keys) + self.second
        found = [
            np.logical_and.reduceat(is_good[np.searchsorted(numbers, steps)], begins)
            for steps, begins in (self.ways.steps(self.keys, k) for k in self.ways.pieces())
        ]
        return np.concatenate([np.zeros(0, dtype=bool), *found])


def lines_to(nearest: Array, legs: Sequence[list[int]]) -> tuple[LatticeLines, Array]:
    """Return lines to lattice points `(N, d)`, and `(N,)` the line (index) that leads to each.

    Args:
        nearest: the points.
        legs: sets of drives that move one after the other.
    """
    low, factors = _box(nearest)
    _, chosen, end_of = different(_keys(nearest, low, factors))
    ends = nearest[chosen]
    lengths = np.stack([np.max(np.abs(ends[:, leg]), axis=1) for leg in legs], axis=1).astype(int)
    ways = _Ways(ends, lengths, legs, low, factors)
    keys = _united([ways.passed(lines)[0] for lines in ways.pieces()])
    numbers = _united([ways.steps(keys, lines)[0] for lines in ways.pieces()])
    return LatticeLines(
        points=_points(keys, low, factors),
        first=numbers // len(keys),
        second=numbers % len(keys),
        ends=np.searchsorted(keys, _keys(ends, low, factors)),
        ways=ways,
        keys=keys,
    ), end_of


def count_of(nearest: Array) -> int:
    """Return how many different lattice points there are among `(N, d)`."""
    keys = _keys(nearest, *_box(nearest))
    marks = _marks(keys)
    return len(np.unique(keys)) if marks is None else int(np.count_nonzero(marks))


def different(keys: Array) -> tuple[Array, Array, Array]:
    """Return the different ones of whole numbers `(N,)`, none below 0, as `np.unique` does.

    Returns:
        They, ascending; the first place of each among all; and `(N,)` which of them each one is.
    """
    marks = _marks(keys)
    if marks is None:
        return np.unique(keys, return_index=True, return_inverse=True)
    found = np.flatnonzero(marks)
    of = (np.cumsum(marks) - 1)[keys]
    first = np.empty(len(found), dtype=np.intp)
    # The last one that is written to a place stays there.
    first[of[::-1]] = np.arange(len(keys) - 1, -1, -1)
    return found, first, of


def _marks(keys: Array) -> Array | None:
    """Return which whole numbers from 0 on are among keys; None where sorting takes less time."""
    most = int(np.max(keys, initial=0))
    if most > _MOST_MARKS * len(keys):
        return None
    marks = np.zeros(1 + most, dtype=bool)
    marks[keys] = True
    return marks


def _united(sets: Sequence[Array]) -> Array:
    """Return the different ones of whole numbers, ascending."""
    found = [different(own)[0] for own in sets]
    return found[0] if len(found) == 1 else np.unique(np.concatenate([np.zeros(0, int), *found]))


def _box(points: Array) -> tuple[Array, Array]:
    """Return the least coordinates of points `(N, d)` and the start, and factors of their keys."""
    # NumPy takes ten times as long for all columns at once.
    low = np.array([np.min(column, initial=0.0) for column in points.T])
    spans = np.array([np.max(column, initial=0.0) for column in points.T]) - low + 1.0
    return low, np.concatenate([[1.0], np.cumprod(spans[:-1])]).astype(np.int64)


def _keys(points: Array, low: Array, factors: Array) -> Array:
    """Return a whole number `(N,)` for each lattice point `(N, d)`, by its coordinates."""
    keys = np.zeros(len(points), dtype=np.int64)
    for column, least, factor in zip(points.T, low, factors, strict=True):
        keys += (column - least).astype(np.int64) * factor
    return keys


def _points(keys: Array, low: Array, factors: Array) -> Array:
    """Return the lattice points `(M, d)` of keys, see `_keys`."""
    points = np.empty((len(keys), len(low)))
    for column in range(len(low) - 1, -1, -1):
        points[:, column], keys = keys // factors[column] + low[column], keys % factors[column]
    return points
