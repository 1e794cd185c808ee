"""Closure equations of a group: the one text of placements and closure, traced and run.

Seen from the base of the group, a closed loop says that the twists of its joints about one point,
summed along the predecessor's path, equal those along the successor's path. Each loop gives six
rows; rows that no motion of the loop's joints can ever violate are redundant and are projected out
(`Reduction`), their reactions being statically indeterminate. A planar loop stays in its plane only
as seen from the body that carries it, so rows are chosen in the axes of that body: the nearest one
from which both sides of the loop hang. It is the base unless several loops are solved together.
Where a slide between that body and the loop's other joints moves a point that all their axes pass
through, more rows are redundant in the axes of a body behind the slide.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ...mechanics import closure, spins
from ...mechanics.bodies import massless
from ...mechanics.placements import Placed, moving, placed
from ...mechanics.vectors import (
    UNTURNED,
    ZERO,
    Rotation,
    Scalar,
    Vector,
    added,
    cross,
    dot,
    less,
    seen,
    times,
    turned,
)
from ...mechanism.kept import MOST, Kept
from ...mechanism.mechanism import Mechanism
from ...mechanism.welds import Coupling
from ...tape import Program, Trace, absolute, greater, sqrt
from ..loops.groups import Group
from ..tolerances import RANK_TOLERANCE


class LoopAxes(NamedTuple):
    """The axes in which a loop's rows are chosen.

    Attributes:
        body: index in the tree of the body that carries the loop, -1 for the base.
        point: about which twists are taken, in that body; None for halfway between the welds.
    """

    body: int
    point: Vector | None

    def placed(self, at: Placed, middle: Vector) -> tuple[Rotation, Vector]:
        """Return these axes and the point, with the one halfway between the welds."""
        if self.point is None or self.body < 0:
            return UNTURNED, middle if self.point is None else self.point
        rotation = at.rotations[self.body]
        return rotation, added(at.points[self.body], turned(rotation, self.point))


class _Reduction(NamedTuple):
    rows: tuple[Array, ...]
    axes: tuple[LoopAxes, ...]


class Reduction(_Reduction):
    """The rows of each loop that its motion can reach, and those that it cannot.

    Attributes:
        rows: per loop `(6, r)`: orthonormal combinations of the weighted rows, in the loop's
            axes, that the joints' twists span over the whole motion; the identity if r is 6.
        axes: per loop, the axes in which its rows are chosen.
    """

    @cached_property
    def key(self) -> Hashable:
        """All of it, as the key of a dictionary."""
        return tuple((rows.shape, rows.tobytes(), axes) for rows, axes in zip(*self, strict=True))


class ClosureEquations:
    """The loops and couplings of a group, and what its idle rods do, whichever joints move.

    Attributes:
        tree: the group's bodies, loops and couplings as seen from its base, about a point near the
            loops, so that no digits are lost far from the base's origin.
        origin: `(3,)` that point in the frame of the base [m].
        length: the mechanism's characteristic length [m].
        rates: the M velocity coordinates of the bodies.
        slides: `(nv,)` which velocity coordinates are lengths.
        columns: of coordinate rows that place the bodies.
    """

    def __init__(self, mechanism: Mechanism, group: Group) -> None:
        """Collect the equations of a group."""
        self._kept = Kept()
        self._at_zero, self._bodies = mechanism.placements_at_zero, group.bodies
        self._welded = [mechanism.loops[index].predecessor - 1 for index in group.loops]
        self.length = mechanism.characteristic_length
        points = [self._at_zero[body].translation for body in self._welded or group.bodies]
        origin = np.mean(points, axis=0) if points else np.zeros(3)
        self.origin = self._at_zero[group.base].actInv(origin)
        whole = massless(mechanism, group.loops, group.couplings)
        own = self.origin if group.base >= 0 else whole.in_axes(self.origin - whole.origin)
        self.tree = whole.hung(
            group.bodies,
            group.base,
            tuple((own / whole.length).tolist()),
        )
        bodies = self.tree.bodies
        self.slides = np.zeros(mechanism.model.nv, dtype=bool)
        self.slides[[body.rates[0] for body in bodies if body.kind == "prismatic"]] = True
        stated = [mechanism.couplings[index] for index in group.couplings]
        self._slip_factors = list(map(self._slip_factor, stated))
        # The base stands for what carries it.
        index_of = {body: index for index, body in enumerate(group.bodies)}
        rods = [
            (index_of[rod.body], rod.columns, rod.line, index_of.get(rod.frame, -1))
            for rod in group.idle
        ]
        self._spins = spins.spins_of(self.tree, mechanism.zero, rods) if rods else ()
        self.rates = [rate for body in bodies for rate in body.rates]
        self.columns = [column for body in bodies for column in body.columns]
        coupled = {*sum((item.predecessor_columns + item.successor_columns for item in stated), ())}
        self._coupled = [body.column for body in bodies if not coupled.isdisjoint(body.rates)]

    def _slip_factor(self, coupling: Coupling) -> float:
        """Return what a coupling's slip, in units of the tree, is multiplied with.

        It then counts in radians, or in the mechanism's length.
        """
        columns, ratio, unit = coupling.successor_columns, 1.0, 1.0
        if columns:
            unit = float(self.tree.units[columns[0]])
        else:
            columns, ratio = coupling.predecessor_columns, abs(coupling.ratio)
        return unit / (ratio * (self.length if self.slides[columns[0]] else 1.0))

    @cached_property
    def full(self) -> Reduction:
        """Return the reduction that keeps all six rows of every loop."""
        loops = range(len(self.tree.loops))
        axes = tuple(next(self._candidates(loop)) for loop in loops)
        return Reduction((np.eye(6),) * len(axes), axes)

    @cached_property
    def about_welds(self) -> Reduction:
        """Return the same about the welds, so that gaps and angles do not mix in their errors."""
        return self.full._replace(axes=(LoopAxes(-1, None),) * len(self.full.axes))

    def _candidates(self, loop: int) -> Iterator[LoopAxes]:
        """Yield axes for a loop's rows: those of the body that carries it, then of those on it.

        Twists are taken about where the weld is at zero.
        """
        ends = self.tree.loops[loop].predecessor, self.tree.loops[loop].successor
        first, second = self.tree.apart(*(end.body for end in ends))
        outer = first or second
        common = self.tree.bodies[outer[-1]].parent if outer else ends[0].body
        for body in (common, *sorted(first + second)):
            point = ZERO
            if body >= 0:
                welded = self._at_zero[self._welded[loop]].translation
                point = self._at_zero[self._bodies[body]].actInv(welded) / self.tree.length
            yield LoopAxes(body, tuple(point))

    def reduction(self, x: Array, movable: Array) -> Reduction:
        """Find the reachable rows at positions all over the motion, see `reachable_rows`.

        Args:
            x: coordinates `(N, size)`, closed or open.
            movable: velocity coordinates that may move.
        """
        own = [self.rates.index(rate) for rate in movable.tolist()]
        # In rank decisions slides count in lengths of the mechanism; otherwise the unit of length
        # would decide.
        units = np.where(self.slides[movable], self.length, 1.0)[:, None]
        of_all, alone = self.at(x, self.full)[0], [np.zeros((6, 0))] * len(self.full.rows)

        def twists(loop: int, axes: LoopAxes) -> Array:
            """Return unit twists `(N, m, 6)` of the coordinates around a loop."""
            rows = of_all[:, own, 6 * loop : 6 * loop + 6]
            if axes != self.full.axes[loop]:
                kept = (*alone[:loop], np.eye(6), *alone[loop + 1 :])
                others = (*self.full.axes[:loop], axes, *self.full.axes[loop + 1 :])
                rows = self.at(x, Reduction(kept, others))[0][:, own, :6]
            return np.asarray(rows * units)

        found = [
            reachable_rows(partial(twists, loop), self._candidates(loop))
            for loop in range(len(self.tree.loops))
        ]
        return Reduction(*zip(*found, strict=True)) if found else Reduction((), ())

    def at(
        self, x: Array, reduction: Reduction, turns: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return the equations at coordinates, closed or not.

        Args:
            x: `(N, size)`.
            reduction: which rows of loops.
            turns: `(N, size)` whole turns that the angles in `x` lack; couplings count them.

        Returns:
            Transposed closure matrix `(N, M, R)`, a row per velocity coordinate: its columns are
            the reduced rows of the loops, then those of couplings; with k idle rods
            `(N, M, R + k)`: their rates about their lines follow. What rows are off by `(N, R)`.
            And the worst angle [rad] or gap at a weld `(N,)`, the latter as a fraction of the
            mechanism's length, or the worst slip.
        """
        count, m = len(x), len(self.rates)
        if not self.tree.loops and not self.tree.couplings:
            return np.zeros((count, m, 0)), np.zeros((count, 0)), np.zeros(count)
        given = [x[:, self.columns].T]
        if self._coupled:
            none = np.zeros((len(self._coupled), 1))
            given.append(none if turns is None else turns[:, self._coupled].T)
        found = self._run("rows", self._traced_rows, reduction, given, count)
        # All rows, an error for each column but those of spins, and the residual.
        size = (found.shape[1] - 1 + len(self._spins)) // (m + 1)
        rows = np.ascontiguousarray(found[:, : m * size]).reshape(count, m, size)
        return rows, np.ascontiguousarray(found[:, m * size : -1]), found[:, -1].copy()

    def drift(self, x: Array, v: Array, reduction: Reduction) -> Array:
        """Return accelerations of the rows `(N, R)` that joint rates alone cause.

        Those of idle rods about their lines follow, `(N, R + k)`. Loops are closed.

        Args:
            x: coordinates `(N, size)` or `(1, size)`.
            v: joint velocities `(N, nv)`.
            reduction: which rows of loops.
        """
        given = [x[:, self.columns].T, v[:, self.rates].T]
        return self._run("drift", self._traced_drift, reduction, given, len(v))

    def turned(self, x: Array) -> Array:
        """Return `(N, k)` angles [rad] of the idle rods, see `spins`."""

        def outputs(trace: Trace, _: Reduction) -> list[Scalar]:
            at = placed(self.tree, self._inputs(trace))
            return [spins.turned(at, spin) for spin in self._spins]

        return self._run("turned", outputs, Reduction((), ()), [x[:, self.columns].T], len(x))

    def _run(
        self,
        kind: str,
        text: Callable[[Trace, Reduction], list[Scalar]],
        reduction: Reduction,
        given: list[Array],
        count: int,
    ) -> Array:
        """Return outputs `(N, outputs)` of a text, which is traced once for each reduction."""

        def traced() -> Program:
            with Trace() as trace:
                return Program(trace, text(trace, reduction), keeps_inputs=True)

        program = self._kept.of(kind, reduction.key, traced)
        return program.run_rows(given, count).T

    def _inputs(self, trace: Trace) -> dict[int, Scalar]:
        """Return the coordinates of the bodies by columns, slides in the tree's length."""
        return {
            column: trace.input(f"x{column}", 0.0)
            / (self.tree.length if body.kind == "prismatic" else 1.0)
            for body in self.tree.bodies
            for column in body.columns
        }

    def _traced_rows(self, trace: Trace, reduction: Reduction) -> list[Scalar]:
        """Return what `at` returns at one sample: rows, errors and the residual."""
        tree, x = self.tree, self._inputs(trace)
        at = placed(tree, x)
        gaps, residual = closure.gaps(tree, at), 0.0
        places = [
            axes.placed(at, gap.middle) for axes, gap in zip(reduction.axes, gaps, strict=True)
        ]
        entries: dict[int, list[Scalar]] = {rate: [] for rate in self.rates}
        rows = closure.rows(tree, at, entries, [point for _, point in places])
        errors: list[Scalar] = []
        each = zip(gaps, closure.turns(tree, at), places, reduction.rows, strict=True)
        for number, (gap, turn, (rotation, point), kept) in enumerate(each):
            of_loop = rows[6 * number : 6 * number + 6]
            for rate, own in entries.items():
                if rate in of_loop[0]:
                    twist = self._weighted([row[rate] for row in of_loop], rotation)
                    own += _combined(twist, kept)
                else:
                    own += [0.0] * kept.shape[1]
            # A rotation about the point shifts the weld as well; the twist makes up for it.
            shift = added(gap.shift, cross(turn, less(point, gap.middle)))
            errors += _combined(self._weighted([*shift, *turn], rotation), kept)
            far = times(gap.shift, 1.0 / tree.norm_length)
            for off in (far, turn):
                residual = greater(residual, sqrt(dot(off, off)))
        turns = {c: 2.0 * np.pi * trace.input(f"t{c}", 0.0) for c in self._coupled}
        angles = {
            rate: x[body.column] + turns[body.column]
            for body in tree.bodies
            for rate in body.rates
            if body.column in turns
        }
        slips = closure.slips(tree, angles, [coupling.offset for coupling in tree.couplings])
        couplings = rows[6 * len(tree.loops) :]
        for slip, row, factor in zip(slips, couplings, self._slip_factors, strict=True):
            for rate, own in entries.items():
                own.append(row.get(rate, 0.0) * factor)
            errors.append(slip * factor)
            residual = greater(residual, absolute(errors[-1]))
        for spin in self._spins:
            row = spins.row(tree, at, spin, entries)
            for rate, own in entries.items():
                own.append(row.get(rate, 0.0))
        outputs = [
            value / float(tree.units[rate]) for rate, own in entries.items() for value in own
        ]
        return [*outputs, *errors, residual]

    def _traced_drift(self, trace: Trace, reduction: Reduction) -> list[Scalar]:
        """Return what `drift` returns at one sample."""
        tree, at = self.tree, placed(self.tree, self._inputs(trace))
        v = {rate: trace.input(f"v{rate}", 0.0) / float(tree.units[rate]) for rate in self.rates}
        motion = moving(tree, at, v, {}, ZERO)
        drifts = closure.drifts(tree, at, motion)
        result: list[Scalar] = []
        each = zip(closure.gaps(tree, at), reduction.axes, reduction.rows, strict=True)
        for number, (gap, axes, kept) in enumerate(each):
            linear: Vector = drifts[6 * number : 6 * number + 3]
            angular: Vector = drifts[6 * number + 3 : 6 * number + 6]
            rotation, point = axes.placed(at, gap.middle)
            linear = added(linear, cross(angular, less(point, gap.middle)))
            result += _combined(self._weighted([*linear, *angular], rotation), kept)
        bends = zip(closure.bends(tree, at, v), self._slip_factors, strict=True)
        result += [bend * factor for bend, factor in bends]
        return result + [spins.drift(at, motion, spin) for spin in self._spins]

    def _weighted(self, twist: Sequence[Scalar], rotation: Rotation) -> list[Scalar]:
        """Return a twist in turned axes, lengths in units of the mechanism's."""
        linear, angular = (
            part if rotation is UNTURNED else seen(rotation, part)
            for part in (twist[:3], twist[3:])
        )
        return [*times(linear, 1.0 / self.tree.norm_length), *angular]


def equations_of(mechanism: Mechanism, group: Group) -> ClosureEquations:
    """Return the equations of a group, which all groups of the same loops share."""
    most = MOST + mechanism.model.njoints
    made = partial(ClosureEquations, mechanism, group)
    return mechanism.kept.of("equations", group.closure, made, most)


def _combined(values: Sequence[Scalar], vectors: Array) -> list[Scalar]:
    """Return the components of six values along columns `(6, r)`."""
    if vectors.shape[1] == 6:
        return [*values]
    return [
        sum((factor * value for factor, value in zip(column, values, strict=True) if factor), 0.0)
        for column in vectors.T.tolist()
    ]


def axis_aligned(vectors: Array) -> Array:
    """Return a basis of the same space along the axes where the space allows it.

    Exact zeros and ones keep the rows of a planar or spherical loop free of rounding. Of a space
    that is tilted against the axes by an angle, the projector has entries of the size of that.

    Args:
        vectors: `(6, r)` orthonormal columns.

    Returns:
        `(6, r)` orthonormal columns: unit vectors if axes span the space, else `vectors`.
    """
    projector = vectors @ vectors.T
    exact = np.rint(projector)
    if vectors.shape[1] and (np.abs(projector - exact) <= ROUNDED).all():
        return np.eye(6)[:, np.diag(exact) == 1.0]
    return vectors


def reachable_rows(
    twists: Callable[[LoopAxes], Array], candidates: Iterable[LoopAxes]
) -> tuple[Array, LoopAxes]:
    """Find the rows of a loop that its joints reach at positions all over the motion.

    The unit twists of a loop's joints at all positions together span the motions that the loop can
    make; when that space is smaller than six (a planar or a spherical chain), no motion can violate
    the rest of its rows, at any position.

    Args:
        twists: unit twists `(N, k, 6)` of the loop's moving coordinates, in some axes.
        candidates: axes in which the rows may be chosen; the first ones that show as few as any
            are taken.

    Returns:
        The rows `(6, r)` that are reached, and their axes.
    """
    axes, *others = candidates
    found = twists(axes)
    vectors, rank = _spanned(found)
    # At one position, no axes can have fewer rows than its twists are independent.
    if rank > _spanned(found[:1])[1]:
        for other in others:
            there, own = _spanned(twists(other))
            if own < rank:
                vectors, rank, axes = there, own, other
    return axis_aligned(vectors[:, :rank]), axes


def _spanned(twists: Array) -> tuple[Array, int]:
    """Return `(6, 6)` orthonormal vectors, first those of the space that twists span, and its rank.

    With twists `(N, k, 6)`, at all positions together.
    """
    # The triangular factor has the singular values and row space of the tall matrix.
    triangle = np.asarray(np.linalg.qr(twists.reshape(-1, 6), mode="r"))
    vectors, values, _ = np.linalg.svd(triangle.T, full_matrices=True)
    return vectors, int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0
