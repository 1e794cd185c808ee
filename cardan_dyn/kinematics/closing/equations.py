"""Closure equations: what welds the loops, for many samples at once.

In the axes of the batch model's base, about its origin, a closed loop says that the twists of its
joints, summed along the predecessor's path, equal those along the successor's path. Each loop gives
six rows; rows that no motion of the loop's joints can ever violate are redundant and are projected
out (`Reduction`), their reactions being statically indeterminate. A planar loop stays in its plane
only as seen from the body that carries it, so rows are chosen in the axes of that body: the nearest
one from which both sides of the loop hang. It is the base unless several loops are solved together.
Where a slide between that body and the loop's other joints moves a point that all their axes pass
through, more rows are redundant in the axes of a body behind the slide.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio

from ...arrays import Array, consecutive, cross
from ...mechanism.mechanism import Mechanism
from ...mechanism.welds import Coupling, Loop
from ..loops.groups import Group
from ..loops.idle_rods import IdleRod
from ..tolerances import RANK_TOLERANCE
from .batch_model import BatchModel, UnitTwists, placement

_HALF_TURN = 1e-12
"""Four times the squared cosine of half an angle up to which a rotation counts as a half turn: it
is then within 1e-6 rad of one. A smaller square would lose its digits in rounding: of 1e-12, the
rounding of its terms, 1e-16, is already 1e-4."""
_UNROTATED = np.eye(3)
_BELOW_DIAGONAL, _ABOVE_DIAGONAL = np.array([7, 2, 3]), np.array([5, 6, 1])
"""Entries (z, y), (x, z), (y, x) of a matrix of nine numbers in a row, and their mirror images."""
_NEXT, _AFTER_NEXT = np.array([1, 2, 0]), np.array([2, 0, 1])
_FACTORS = np.array([[3, 0], [3, 3], [0, 3]])[:, :, None]
_ADDED, _TAKEN_OFF = (
    (6 * (_FACTORS[:, 0] + first) + _FACTORS[:, 1] + second).ravel()
    for first, second in ((_NEXT, _AFTER_NEXT), (_AFTER_NEXT, _NEXT))
)
"""Of the 36 products of components of two twists (V, Ω) and (v, ω), those that the cross products
Ω × v, Ω × ω and V × ω add, and those that they take off."""
_ALIGNED = 1e-12
"""Greatest deviation of a projector's entries from 0 and 1 that counts as rounding. The rounding of
a projector of six columns is some 1e-15; a space that is tilted against the axes by an angle has
entries of the size of that angle."""


class BodiesOn(NamedTuple):
    """The bodies on a loop, k in all.

    Attributes:
        rows: their rows in the actions of the batch model.
        joints: the bodies (0-based joints of the mechanism's model).
        signs: `(k, 1, 1)` on which side of the loop each is, see `ClosureEquations.signs`.
    """

    rows: slice | Array
    joints: slice | Array
    signs: Array

    @staticmethod
    def of(signs: Array, batch: BatchModel) -> BodiesOn:
        """Return the bodies whose `signs`, `(n,)`, are not zero."""
        (path,) = np.nonzero(signs)
        rows = consecutive((6 * path[:, None] + np.arange(6)).ravel())
        return BodiesOn(rows, consecutive(batch.bodies[path]), signs[path][:, None, None])


class ClosureEquations:
    """The loops and couplings of a group.

    A coupling adds one row, which needs no geometry: the displacements of its two sides are
    proportional. Its slip is the ratio times the predecessor's displacement plus the offset, less
    the successor's displacement.

    Attributes:
        batch: of the group's bodies.
        movable: `(m,)` velocity coordinates that may move, known ones first, then passives.
        unit_twists: of those.
        rod_spins: of the group's idle rods, if it has any.
        loops: the L loops of the group.
        couplings: its G couplings.
        length: the mechanism's characteristic length [m].
        alike: the loops with the placements of their ends.
        moved_bodies: `(m,)` index in the batch of the body that each movable coordinate moves.
        signs: `(L, n)` +1 for bodies on a loop's predecessor path, -1 on its successor path.
        column_signs: `(L, m)` the same for the movable coordinates.
        weights: `(6,)` scale of a wrench's components [1/m for forces, 1 for moments]: rows and
            wrenches are compared with lengths in units of the mechanism's length.
        coupled_columns: velocity coordinates that couplings count, held ones included.
        coupled_ratios: their coefficients in the couplings' rows, `(len(coupled_columns), G)`.
        coupled_offsets: `(G,)` what their slips are at zero [rad or m].
        slip_units: `(G,)` the length where a slip is one, else 1.
        coupling_rows: `(m, G)` the couplings' rows of the movable coordinates, in these units.
    """

    def __init__(self, mechanism: Mechanism, batch: BatchModel, group: Group) -> None:
        """Collect the equations of a group.

        Args:
            mechanism: the mechanism.
            batch: of the group's bodies.
            group: the group.
        """
        self.batch = batch
        self._at_zero = mechanism.placements_at_zero
        self.length = mechanism.characteristic_length
        self.movable = np.concatenate([group.known, group.passives])
        self.unit_twists = UnitTwists(batch, self.movable)
        self.loops = [mechanism.loops[index] for index in group.loops]
        self.couplings = [mechanism.couplings[index] for index in group.couplings]
        self.weights = np.repeat([1.0 / mechanism.characteristic_length, 1.0], 3)
        self._weight_column = self.weights[:, None]
        self.signs = np.array([self._signs_of(loop) for loop in self.loops])
        self.signs = self.signs.reshape(len(self.loops), len(batch))
        self.moved_bodies = batch.moved_body[self.movable]
        if group.idle:
            self.rod_spins = RodSpins(batch, group.idle, self.moved_bodies, mechanism.zero)
        self.column_signs = self.signs[:, self.moved_bodies]
        self.alike = _alike(self.loops, batch)
        self._paths = LoopPaths.of(self.column_signs, self.moved_bodies)
        self._axes = tuple(_axes_of(loop, mechanism, batch) for loop in self.loops)
        on_loops = [np.flatnonzero(signs) for signs in self.column_signs]
        self._columns_on = [consecutive(on) for on in on_loops]
        self._signs_on = [
            signs[on][:, None] for signs, on in zip(self.column_signs, on_loops, strict=True)
        ]
        self._factors = [signs * self.weights for signs in self._signs_on]
        # Its rows need no array that other rows share.
        self._is_one_loop = (
            len(self.loops) == 1 and not self.couplings and len(on_loops[0]) == len(self.movable)
        )
        slides = np.any(batch.subspace[:, :3] != 0.0, axis=1)
        # In rank decisions slides count in lengths of the mechanism; otherwise the unit of length
        # would decide.
        units = np.where(slides[self.movable], mechanism.characteristic_length, 1.0)
        self._units = units[:, None] * self.weights
        nv, length = mechanism.model.nv, mechanism.characteristic_length
        coupling_rows = np.array([_coupling_row(coupling, nv) for coupling in self.couplings])
        coupling_rows = coupling_rows.reshape(-1, nv).T
        self.coupled_columns = np.nonzero(np.any(coupling_rows != 0.0, axis=1))[0]
        self.coupled_ratios = coupling_rows[self.coupled_columns]
        self.coupled_offsets = np.array([coupling.offset for coupling in self.couplings])
        self.slip_units = np.array(
            [_slip_unit(coupling, slides, length) for coupling in self.couplings]
        )
        # In units of their slips, like the rows of loops: the unit of length would decide rank and
        # condition.
        self.coupling_rows = coupling_rows[self.movable] / self.slip_units

    def _signs_of(self, loop: Loop) -> Array:
        """Return `(n,)` on which side of a loop each body is, see `signs`."""
        predecessors, successors = _paths_to(loop, self.batch)
        signs = np.zeros(len(self.batch))
        signs[[index for index in predecessors if index not in successors]] = 1.0
        signs[[index for index in successors if index not in predecessors]] = -1.0
        return signs

    @cached_property
    def _candidates(self) -> list[list[LoopAxes]]:
        """Per loop, axes for its rows: those of the body that carries it, then of those on it."""
        return [
            [own, *(_axes_on(int(body), loop, self._at_zero, self.batch) for body in on_loop)]
            for own, loop, on_loop in zip(
                self._axes, self.loops, map(np.flatnonzero, self.signs), strict=True
            )
        ]

    @cached_property
    def bodies_on(self) -> list[BodiesOn]:
        """Per loop, the bodies on it."""
        return [BodiesOn.of(signs, self.batch) for signs in self.signs]

    def full(self) -> Reduction:
        """Return the reduction that keeps all six rows of every loop."""
        count = len(self.loops)
        return Reduction((np.eye(6),) * count, (np.zeros((6, 0)),) * count, self._axes)

    def reduction(self, twists: Array, actions: Array) -> Reduction:
        """Find the reachable rows at positions all over the motion, see `reachable_rows`.

        Args:
            twists: `(N, m, 6)` of the moving coordinates.
            actions: see `actions_of`.
        """
        moving = [twists[:, signs != 0.0] for signs in self.column_signs]
        units = [self._units[signs != 0.0] for signs in self.column_signs]
        found = [
            reachable_rows(*item, actions)
            for item in zip(moving, units, self._candidates, strict=True)
        ]
        rows, null, axes = zip(*found, strict=True) if found else ((), (), ())
        return Reduction(rows, null, axes)

    def rows(self, twists: Array, actions: Array, reduction: Reduction) -> Array:
        """Return the transposed closure matrix `(N, m, R)`: a row per moving coordinate.

        Its columns are the reduced rows of the loops, then those of the couplings.
        """
        if self._is_one_loop and reduction.axes[0].body < 0:
            return self._rows_of_loop(0, twists, actions, reduction)
        count, moving = twists.shape[:2]
        loops = sum(rows.shape[1] for rows in reduction.rows)
        # Most loops move with few of the coordinates.
        result = np.zeros((count, moving, loops + len(self.couplings)))
        start = 0
        for index, (on, rows) in enumerate(zip(self._columns_on, reduction.rows, strict=True)):
            own = slice(start, start + rows.shape[1])
            result[:, on, own] = self._rows_of_loop(index, twists[:, on], actions, reduction)
            start = own.stop
        if self.couplings:
            result[:, :, loops:] = self.coupling_rows
        return result

    def _rows_of_loop(
        self, index: int, twists: Array, actions: Array, reduction: Reduction
    ) -> Array:
        """Return a loop's rows `(N, k, r)` for the coordinates on it, with twists `(N, k, 6)`."""
        axes, rows = reduction.axes[index], reduction.rows[index]
        if axes.body >= 0:
            weighted = self._weighted(axes, actions, rows)
            return np.asarray((twists * self._signs_on[index]) @ weighted)
        factored = twists * self._factors[index]
        if rows.shape[1] == 6:
            return factored
        # A product for every sample: one of tall matrices rounds by their number.
        return np.asarray(np.matmul(factored, rows))

    def project(
        self, twist: Array, slips: Array | None, actions: Array, reduction: Reduction
    ) -> Array:
        """Return `(N, R)` components along the reduced rows.

        Args:
            twist: loop twists `(N, L, 6)`.
            slips: of the couplings `(N, G)`; zero if None.
            actions: see `actions_of`.
            reduction: which rows.
        """
        weighted = twist * self.weights
        blocks = []
        for index, (axes, rows) in enumerate(zip(reduction.axes, reduction.rows, strict=True)):
            if axes.body >= 0:
                blocks.append((twist[:, [index]] @ self._weighted(axes, actions, rows))[:, 0])
            else:
                own = weighted[:, index]
                blocks.append(own if rows.shape[1] == 6 else np.matmul(own[:, None], rows)[:, 0])
        if self.couplings or not blocks:
            none = np.zeros((len(twist), self.coupling_rows.shape[1]))
            blocks.append(none if slips is None else slips / self.slip_units)
        return blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=1)

    def wrench(self, axes: LoopAxes, actions: Array, combinations: Array) -> Array:
        """Return wrenches of a loop in the base's axes about the batch model's origin.

        Args:
            axes: of the loop, see `Reduction`.
            actions: see `actions_of`.
            combinations: of its weighted rows, `(N, 6, k)` or `(6, k)`.

        Returns:
            `(N, 6, k)`, force first.
        """
        weighted = combinations * self._weight_column
        if axes.body >= 0:
            return np.asarray(axes.matrices(actions) @ weighted)
        whole = (len(actions), *weighted.shape[-2:])
        return weighted if weighted.shape == whole else np.broadcast_to(weighted, whole)

    def _weighted(self, axes: LoopAxes, actions: Array, rows: Array) -> Array:
        """Return `(N, 6, r)` the rows of a loop that a moving body carries, in the base's axes."""
        return np.asarray(axes.matrices(actions) @ (self.weights[:, None] * rows))

    def error(self, placed: Array) -> tuple[Array, Array]:
        """Return how far the loops are from closed.

        Args:
            placed: see `BatchModel.placed`.

        Returns:
            The twist `(N, L, 6)` that would take each successor to its predecessor, and the
            closure error `(N,)` at the welds: the worst angle [rad] or gap, the latter as a
            fraction of the mechanism's length.
        """
        gap, turn, middle = self._gaps(placed)
        result = np.empty((placed.shape[0], gap.shape[1], 6))
        # A rotation about the origin shifts the weld as well; the twist makes up for it.
        result[:, :, :3] = (gap - cross(turn, middle)).transpose(2, 1, 0)
        result[:, :, 3:] = turn.transpose(2, 1, 0)
        deviation = np.empty((2, *gap.shape))
        np.divide(gap, self.length, out=deviation[0])
        deviation[1] = turn
        deviation *= deviation
        squares = np.add.reduce(deviation, axis=1)
        worst = np.maximum.reduce(squares, axis=(0, 1), initial=0.0)
        return result, np.sqrt(worst)

    def _gaps(self, placed: Array) -> tuple[Array, Array, Array]:
        """Return the gaps, rotations and middles `(3, L, N)` of all loops, see `LoopGaps.at`."""
        found = [alike.at(placed) for alike in self.alike]
        if len(found) == 1:
            return found[0]
        gap, turn, middle = np.empty((3, 3, len(self.loops), len(placed)))
        for alike, own in zip(self.alike, found, strict=True):
            gap[:, alike.loops], turn[:, alike.loops], middle[:, alike.loops] = own
        return gap, turn, middle

    def at_welds(self, twists: Array, placed: Array) -> tuple[Array, Array]:
        """Return all closure equations about the welds instead of the batch model's origin.

        There, gaps and angles do not mix, so that the sum of their squares says how far the loops
        are from closed, wherever the origin is.

        Args:
            twists: `(N, m, 6)` unit twists of the movable coordinates.
            placed: see `BatchModel.placed`.

        Returns:
            Transposed matrices `(N, m, 6 L + G)`, and errors `(N, 6 L)`: gaps as fractions of the
            characteristic length and angles [rad].
        """
        parts, errors = [], []
        each = zip(
            self.column_signs, *(of.transpose(1, 0, 2) for of in self._gaps(placed)), strict=True
        )
        for signs, gap, turn, middle in each:
            rows = twists * signs[:, None]
            rows[:, :, :3] += np.cross(rows[:, :, 3:], middle.T[:, None, :])
            parts.append(rows * self.weights)
            errors.append(np.concatenate([gap, turn]).T * self.weights)
        count = len(twists)
        parts.append(np.broadcast_to(self.coupling_rows, (count, *self.coupling_rows.shape)))
        errors.append(np.zeros((count, 0)))
        return np.concatenate(parts, axis=2), np.concatenate(errors, axis=1)

    def drift(self, twists: Array, rates: Array, closes: bool = False) -> Array:
        """Return loop accelerations `(N, L, 6)` that joint rates alone cause.

        They are accelerations of the predecessor less those of the successor, spatial ones in
        the base's axes about the batch model's origin. The motion of the body that carries a loop
        adds nothing, which holds for rates that keep the loop closed only.

        Args:
            twists: `(N, m, 6)` or `(1, m, 6)` unit twists of the movable coordinates.
            rates: `(N, m)` of these coordinates, with which the loops stay closed.
            closes: the rates close the loops instead, see `LoopPaths.drift`.
        """
        return drift_along(self._paths, twists, rates, closes)


def _alike(loops: list[Loop], batch: BatchModel) -> list[LoopGaps]:
    """Return loops with ends on bodies and on the base alike, to be worked on together."""
    kinds: dict[tuple[bool, bool], list[int]] = {}
    for index, loop in enumerate(loops):
        kind = _is_on_base(loop.predecessor, batch), _is_on_base(loop.successor, batch)
        kinds.setdefault(kind, []).append(index)
    return [
        LoopGaps(
            consecutive(np.array(indices)),
            _ends([(loops[k].predecessor, loops[k].predecessor_placement) for k in indices], batch),
            successor_ends([loops[k] for k in indices], batch),
        )
        for indices in kinds.values()
    ]


def successor_ends(loops: Sequence[Loop], batch: BatchModel) -> LoopEnds:
    """Return the ends of loops on their successors' sides."""
    return _ends([(loop.successor, loop.successor_placement) for loop in loops], batch)


def _is_on_base(body: int, batch: BatchModel) -> bool:
    """Return whether a body (index in Pinocchio's model, 0 for the world) is the base."""
    return batch.place(body - 1)[0] < 0


def _ends(placed: list[tuple[int, pinocchio.SE3]], batch: BatchModel) -> LoopEnds:
    """Return the ends of loops at bodies (indices in Pinocchio's model, 0 for the world)."""
    carriers = [batch.place(body - 1) for body, _ in placed]
    bodies = np.array([index for index, _ in carriers])
    ends = [
        end if at is None else at * end for (_, at), (_, end) in zip(carriers, placed, strict=True)
    ]
    rotations = np.array([end.rotation for end in ends])
    translations = np.array([end.translation for end in ends])
    if bodies[0] < 0:
        translations -= batch.origin
    return LoopEnds.of(bodies, rotations, translations)


def _paths_to(loop: Loop, batch: BatchModel) -> list[list[int]]:
    """Return the indices of the bodies from the base to each end of a loop."""
    return [batch.path(batch.place(body - 1)[0]) for body in (loop.predecessor, loop.successor)]


def _axes_of(loop: Loop, mechanism: Mechanism, batch: BatchModel) -> LoopAxes:
    """Return axes fixed to the nearest body from which both sides of a loop hang."""
    first, second = _paths_to(loop, batch)
    common = max(set(first) & set(second), default=-1)
    if common < 0:
        return LoopAxes(-1, np.zeros(3))
    return _axes_on(common, loop, mechanism.placements_at_zero, batch)


def _axes_on(
    body: int, loop: Loop, at_zero: dict[int, pinocchio.SE3], batch: BatchModel
) -> LoopAxes:
    """Return axes fixed to a body (index in the batch model), about where the weld is at zero.

    With the placements of all bodies at zero.
    """
    carrier, end = at_zero[batch.bodies[body]], at_zero[loop.predecessor - 1]
    return LoopAxes(body, carrier.rotation.T @ (end.translation - carrier.translation))


def _coupling_row(coupling: Coupling, size: int) -> Array:
    """Return coefficients `(size,)`: ratio times the predecessor's side less the successor's."""
    row = np.zeros(size)
    row[list(coupling.predecessor_columns)] = coupling.ratio
    row[list(coupling.successor_columns)] = -1.0
    return row


def _slip_unit(coupling: Coupling, slides: Array, length: float) -> float:
    """Return what a coupling's slip is compared with: one radian, or the length.

    With slides `(nv,)`.
    """
    if coupling.successor_columns:
        return length if slides[coupling.successor_columns[0]] else 1.0
    first = coupling.predecessor_columns[0]
    return abs(coupling.ratio) * (length if slides[first] else 1.0)


class LoopEnds(NamedTuple):
    """Ends of k loops, where they are welded: all on bodies of the batch, or all on its base.

    Attributes:
        bodies: `(k,)` indices of the bodies in the batch model, or the same as a slice; None for
            the base.
        rotations, translations: `(k, 3, 3)` and `(k, 3)` placements of the welds in these bodies;
            on the base, about the batch model's origin.
        is_rotated, is_shifted: whether any of them differ from the identity and from zero.
    """

    bodies: slice | Array | None
    rotations: Array
    translations: Array
    is_rotated: bool
    is_shifted: bool

    @staticmethod
    def of(bodies: Array, rotations: Array, translations: Array) -> LoopEnds:
        """Return the ends of loops that are placed like this in bodies, -1 for the base."""
        is_rotated = bool((rotations != _UNROTATED).any())
        on = None if bodies[0] < 0 else consecutive(bodies)
        return LoopEnds(on, rotations, translations, is_rotated, bool(translations.any()))

    def placements_on_base(self, placed: Array) -> tuple[Array, Array]:
        """Return rotations `(3, k, 3, N)` and positions `(3, k, N)` about the batch's origin.

        N is 1 for ends on the base.

        Args:
            placed: see `BatchModel.placed`.
        """
        if self.bodies is None:
            return self.rotations.transpose(1, 0, 2)[..., None], self.translations.T[:, :, None]
        blocks = placed[:, self.bodies]
        blocks = blocks.reshape(*blocks.shape[:2], 4, 3).transpose(3, 1, 2, 0)
        rotations, shifts = np.ascontiguousarray(blocks[:, :, :3]), blocks[:, :, 3]
        if self.is_shifted:
            shifts = shifts + np.add.reduce(self.translations[:, :, None] * rotations, axis=2)
        if self.is_rotated:
            # Term by term, so that a sample comes out alike whatever others are beside it.
            turned = self.rotations[:, :, :, None] * rotations[:, :, :, None]
            rotations = np.add.reduce(turned, axis=2)
        return rotations, shifts


class LoopGaps(NamedTuple):
    """Loops whose ends are on bodies and on the base alike.

    Attributes:
        loops: `(k,)` their indices among the loops of the group, or the same as a slice.
        first, second: their ends on the predecessor's and on the successor's side.
    """

    loops: slice | Array
    first: LoopEnds
    second: LoopEnds

    def at(self, placed: Array) -> tuple[Array, Array, Array]:
        """Return how far they are from closed.

        Args:
            placed: see `BatchModel.placed`.

        Returns:
            Vectors `(3, k, N)`: from the successor's weld to the predecessor's [m], the rotation
            between them (see `rotations_between`), and the point halfway from the batch model's
            origin [m].
        """
        rotations_1, positions_1 = self.first.placements_on_base(placed)
        rotations_2, positions_2 = self.second.placements_on_base(placed)
        turns = rotations_between(rotations_1, rotations_2)
        return positions_1 - positions_2, turns, 0.5 * (positions_1 + positions_2)


class LoopPaths(NamedTuple):
    """The moving coordinates of loops that have k each, outwards from the common ancestors.

    Attributes:
        loops: `(l,)` their indices among the loops, or the same as a slice.
        columns: `(l, k)` indices of these coordinates among the movable ones, first those on the
            predecessor's side, then those on the successor's.
        signs: `(l, k, 1)` 1 on the predecessor's side, -1 on the successor's.
        carries: `(l, k, k)` 1 where the coordinate of the column moves the joint of the row's.
        sides: `(l, 2, k)` 1 where a coordinate is on the predecessor's and on the successor's side.
    """

    loops: slice | Array
    columns: Array
    signs: Array
    carries: Array
    sides: Array

    @staticmethod
    def of(column_signs: Array, moved_bodies: Array) -> list[LoopPaths]:
        """Return the paths of loops, those of one length together.

        Args:
            column_signs: `(L, m)` on which side of them each movable coordinate is, see
                `ClosureEquations`.
            moved_bodies: `(m,)` body that each of them moves.
        """
        of_length: dict[int, list[tuple[int, Array]]] = {}
        for loop, row in enumerate(column_signs):
            sides = [np.nonzero(row == side)[0] for side in (1.0, -1.0)]
            # The coordinates of a ball stay in their order, hence a stable sort.
            sorted_sides = [side[np.argsort(moved_bodies[side], kind="stable")] for side in sides]
            columns = np.concatenate(sorted_sides)
            of_length.setdefault(len(columns), []).append((loop, columns))
        paths = []
        for found in of_length.values():
            loops, columns = (np.array(items) for items in zip(*found, strict=True))
            bodies = moved_bodies[columns]
            signs = np.take_along_axis(column_signs[loops], columns, axis=1)
            # On one side of a loop, a body with a smaller index carries all that follow.
            carries = bodies[:, :, None] > bodies[:, None]
            carries &= signs[:, :, None] == signs[:, None]
            ends = np.stack([signs > 0.0, signs < 0.0], axis=1)
            factors = signs[:, :, None], carries.astype(float), ends.astype(float)
            paths.append(LoopPaths(consecutive(loops), columns, *factors))
        return paths

    def drift(self, twists: Array, rates: Array, closes: bool = False) -> Array:
        """Return `(N, l, 6)` accelerations, predecessor less successor, that rates alone cause.

        Args:
            twists: `(N, m, 6)` unit twists of the movable coordinates.
            rates: `(N, m)` of these coordinates.
            closes: the rates take one end of a loop to the other in a unit of time. Then twice what
                is left of the gap, to second order, is returned. With twists V of the predecessor
                and W of the successor the gap is log(exp(V + V̇/2) exp(W - V) exp(-W - Ẇ/2)), which
                by the formula of Baker, Campbell and Hausdorff is (V̇ - Ẇ + [V, W])/2.
        """
        joint = np.empty((6, *self.columns.shape, len(rates)))
        np.multiply(
            twists[:, self.columns], rates[:, self.columns, None], out=joint.transpose(3, 1, 2, 0)
        )
        carrier = _summed(self.carries, joint)
        if closes:
            ends = _summed(self.sides, joint)
            joint *= self.signs
            carrier = np.concatenate((carrier, ends[:, :, :1]), axis=2)
            joint = np.concatenate((joint, ends[:, :, 1:]), axis=2)
        else:
            joint *= self.signs
        # A joint's twist (v, ω) that moves with the twist (V, Ω) of its carrier changes by
        # (Ω × v + V × ω, Ω × ω). Of all products of their components, summed over the joints, each
        # of the three cross products is the difference of two.
        differences = np.zeros((9, len(self.columns), len(rates)))
        for k in range(joint.shape[2]):
            first, second = carrier[:, :, k], joint[:, :, k]
            differences += first[_ADDED // 6] * second[_ADDED % 6]
            differences -= first[_TAKEN_OFF // 6] * second[_TAKEN_OFF % 6]
        differences[:3] += differences[6:]
        return differences[:6].T


def _summed(factors: Array, values: Array) -> Array:
    """Return sums `(6, l, j, N)` of values `(6, l, k, N)` times factors `(l, j, k)`.

    One term after the other, so that a sample comes out alike whatever others are beside it.
    """
    result = np.zeros((*values.shape[:2], factors.shape[1], values.shape[3]))
    for k in range(values.shape[2]):
        result += factors[:, :, k, None] * values[:, :, k, None]
    return result


def drift_along(paths: list[LoopPaths], twists: Array, rates: Array, closes: bool = False) -> Array:
    """Return accelerations `(N, L, 6)` of all loops, see `LoopPaths.drift`."""
    found = [path.drift(twists, rates, closes) for path in paths]
    if len(found) == 1:
        return found[0]
    result = np.empty((len(rates), sum(drift.shape[1] for drift in found), 6))
    for path, drift in zip(paths, found, strict=True):
        result[:, path.loops] = drift
    return result


class LoopAxes(NamedTuple):
    """The axes in which a loop's rows are chosen.

    Attributes:
        body: index in the batch model of the body that carries the loop, -1 for the base.
        point: `(3,)` point in that body about which twists are taken there.
    """

    body: int
    point: Array

    def matrices(self, actions: Array) -> Array:
        """Return `(N, 6, 6)` matrices between these axes and the base's about the batch's origin.

        A twist in the base's axes (a row) times them is that twist in these axes. They times a
        wrench in these axes (a column) are that wrench in the base's axes.
        """
        rotation, position = placement(actions, self.body)
        point = position + np.matmul(self.point, rotation)
        columns = rotation.transpose(2, 0, 1)
        result = np.zeros((len(actions), 6, 6))
        result[:, :3, :3] = result[:, 3:, 3:] = columns
        result[:, 3:, :3] = np.cross(point.T[:, :, None], columns, axis=1)
        return result


def rotations_between(first: Array, second: Array) -> Array:
    """Return the rotations `(3, …, N)` that take second frames to first ones.

    Along the axis, twice the sine of half the angle: the angle itself where it is small.

    Args:
        first: `(3, …, 3, N)`; one of both may be constant, with N = 1.
        second: likewise.
    """
    relative = np.add.reduce(first[:, None] * second, axis=-2)
    relative = relative.reshape(9, *relative.shape[2:])
    # Of a rotation R, the differences R[k, j] - R[j, k] are the axis times twice the sine.
    vectors = relative.take(_BELOW_DIAGONAL, 0)
    vectors -= relative.take(_ABOVE_DIAGONAL, 0)
    # Its trace plus one is four times the squared cosine of half the angle.
    squares = relative[0] + relative[4] + relative[8] + 1.0
    if not np.minimum.reduce(squares, axis=None, initial=np.inf) > _HALF_TURN:
        return _with_half_turns(vectors, squares, first, second)
    vectors /= np.sqrt(squares)
    return np.asarray(vectors)


def _with_half_turns(sines: Array, squares: Array, first: Array, second: Array) -> Array:
    """Return rotations, some of which are half turns: their sines vanish and show no axis.

    With sines `(3, …, N)`, squares `(…, N)`, first and second `(3, …, 3, N)`.
    """
    is_half = ~(squares > _HALF_TURN)
    result = sines / np.sqrt(np.where(is_half, 1.0, squares))
    first, second = np.broadcast_arrays(first, second)
    for *loop, sample in zip(*np.nonzero(is_half), strict=True):
        at = (slice(None), *loop, slice(None), sample)
        to, start = first[at], second[at]
        # R + 1 = 2 n nᵀ for a half turn about n; its longest column gives n most accurately.
        columns = to @ start.T + np.eye(3)
        axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
        result[(slice(None), *loop, sample)] = 2.0 * axis / np.linalg.norm(axis)
    return result


class Reduction(NamedTuple):
    """The rows of each loop that its motion can reach, and those that it cannot.

    Attributes:
        rows: per loop `(6, r)`: orthonormal combinations of the weighted rows, in the loop's
            axes, that the joints' twists span over the whole motion; the identity if r is 6.
        null: per loop `(6, 6 - r)`: the combinations that they never reach.
        axes: per loop, the axes in which its rows are chosen.
    """

    rows: tuple[Array, ...]
    null: tuple[Array, ...]
    axes: tuple[LoopAxes, ...]

    @property
    def key(self) -> Hashable:
        """All of it, as the key of a dictionary."""
        return tuple(
            (rows.shape, rows.tobytes(), null.tobytes(), axes.body, axes.point.tobytes())
            for rows, null, axes in zip(*self, strict=True)
        )


def axis_aligned(vectors: Array) -> Array:
    """Return a basis of the same space along the axes where the space allows it.

    Exact zeros and ones keep the rows of a planar or spherical loop free of rounding.

    Args:
        vectors: `(6, r)` orthonormal columns.

    Returns:
        `(6, r)` orthonormal columns: unit vectors if axes span the space, else `vectors`.
    """
    projector = vectors @ vectors.T
    exact = np.rint(projector)
    if vectors.shape[1] and (np.abs(projector - exact) <= _ALIGNED).all():
        return np.eye(6)[:, np.diag(exact) == 1.0]
    return vectors


def reachable_rows(
    twists: Array, units: Array, candidates: Sequence[LoopAxes], actions: Array
) -> tuple[Array, Array, LoopAxes]:
    """Find the rows of a loop that its joints reach at positions all over the motion.

    The unit twists of a loop's joints at all positions together span the motions that the loop can
    make; when that space is smaller than six (a planar or a spherical chain), no motion can violate
    the rest of its rows, at any position.

    Args:
        twists: `(N, k, 6)` of the loop's moving coordinates.
        units: `(k, 6)` scale of their components.
        candidates: axes in which the rows may be chosen; the first ones that show as few as any
            are taken.
        actions: see `actions_of`.

    Returns:
        The rows `(6, r)` that are reached, the others, and their axes.
    """
    axes = candidates[0]
    space = _spanned(twists, units, axes, actions)
    # At one position, no axes can have fewer rows than its twists are independent.
    if space.rank > _spanned(twists[:1], units, axes, actions[:1]).rank:
        for other in candidates[1:]:
            there = _spanned(twists, units, other, actions)
            if there.rank < space.rank:
                space, axes = there, other
    rows, null = space.vectors[:, : space.rank], space.vectors[:, space.rank :]
    return axis_aligned(rows), axis_aligned(null), axes


class _Space(NamedTuple):
    """The space that twists span.

    Attributes:
        vectors: `(6, 6)` orthonormal, those that span it first.
        rank: its dimension.
    """

    vectors: Array
    rank: int


def _spanned(twists: Array, units: Array, axes: LoopAxes, actions: Array) -> _Space:
    """Return the space that twists `(N, k, 6)` of a loop's joints span at all positions together.

    With units `(k, 6)`.
    """
    if axes.body >= 0:
        twists = twists @ axes.matrices(actions)
    # The triangular factor has the singular values and row space of the tall matrix.
    triangle = np.asarray(np.linalg.qr((twists * units).reshape(-1, 6), mode="r"))
    vectors, values, _ = np.linalg.svd(triangle.T, full_matrices=True)
    rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0
    return _Space(vectors, rank)


class RodSpins:
    """The k idle rods of a group, and the coordinates that move them.

    Attributes:
        bodies: their indices in the batch model.
        directions: `(k, 3)` of their lines, in the frames of their joints.
        moves: `(m, k)` 1 for what moves a rod, -1 for what moves its frame.
    """

    def __init__(
        self,
        batch: BatchModel,
        rods: tuple[IdleRod, ...],
        moved_bodies: Array,
        zero: Array,
    ) -> None:
        """Find what moves the rods.

        Args:
            batch: of the group's bodies.
            rods: the k rods.
            moved_bodies: `(m,)` indices in the batch of the bodies that the movable coordinates
                move.
            zero: `(size,)` coordinates of the description's zero.
        """
        self._batch, self._zero = batch, zero
        self.bodies = [batch.index_of[rod.body] for rod in rods]
        self.directions = np.array([rod.line for rod in rods])
        # The base of the batch stands for what carries it.
        self._frames = [batch.index_of.get(rod.frame, -1) for rod in rods]
        self._carried = [k for k, frame in enumerate(self._frames) if frame >= 0]
        # How a rod moves relative to its frame: what moves both alike makes no difference.
        moves = np.zeros((len(rods), len(moved_bodies)))
        for row, (body, frame) in enumerate(zip(self.bodies, self._frames, strict=True)):
            of_rod, of_frame = set(batch.path(body)), set(batch.path(frame))
            moves[row, np.isin(moved_bodies, list(of_rod - of_frame))] = 1.0
            moves[row, np.isin(moved_bodies, list(of_frame - of_rod))] = -1.0
        self._paths = LoopPaths.of(moves, moved_bodies)
        self.moves = moves.T

    def turned(self, actions: Array) -> Array:
        """Return `(N, k)` angles [rad] of the rods about their lines from where they settle.

        There a rod is turned from its orientation at the description's zero, as seen from its
        frame, by the least rotation that takes its line to where it is.

        Args:
            actions: of the batch at closed positions, see `actions_of`.
        """
        start, across, side = self._at_zero
        rotations = self._rotations(actions, self.bodies)
        now, found = (
            self._seen(actions, rotations, self.directions),
            self._seen(actions, rotations, side),
        )
        # A vector across the line, turned by the least rotation. At half a turn there is none;
        # nearby, the result turns fast.
        axis = cross(start, now)
        turned = cross(axis, across)
        scale = 1.0 + np.add.reduce(start * now)
        settled = across + turned + cross(axis, turned) / np.maximum(scale, np.finfo(float).tiny)
        sine = np.add.reduce(now * cross(settled, found))
        return np.asarray(np.arctan2(sine, np.add.reduce(settled * found)).T)

    @cached_property
    def _at_zero(self) -> tuple[Array, Array, Array]:
        """At the description's zero, seen from the frames: lines, and vectors across them.

        The former and the latter `(3, k, 1)`; and the latter `(k, 3)` as the rods carry them.
        """
        batch = self._batch
        actions = batch.actions(self._zero[None, :])
        # Across the line: along the axis that is farthest from it, less the part along the line.
        side = np.eye(3)[np.argmin(np.abs(self.directions), axis=1)]
        side -= np.sum(side * self.directions, axis=1, keepdims=True) * self.directions
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        rotations = self._rotations(actions, self.bodies)
        start, across = (self._seen(actions, rotations, item) for item in (self.directions, side))
        return start, across, side

    def rows(self, twists: Array, lines: Array) -> Array:
        """Return `(N, m, k)` how fast the rods turn about their lines per unit of a coordinate.

        Args:
            twists: `(N, m, 6)` unit twists of the movable coordinates.
            lines: `(N, 3, k)`, see `lines`.
        """
        return np.asarray(np.matmul(twists[:, :, 3:], lines) * self.moves)

    def lines(self, actions: Array) -> Array:
        """Return the directions `(N, 3, k)` of the rods' lines, in the axes of the base."""
        rotations = self._rotations(actions, self.bodies)
        return np.asarray(
            np.matmul(self.directions[:, None], rotations)[:, :, 0].transpose(2, 0, 1)
        )

    def drift(self, twists: Array, v: Array, lines: Array) -> Array:
        """Return `(N, k)` accelerations about the lines that rates alone cause.

        Args:
            twists: see `rows`.
            v: `(N, m)` rates of the movable coordinates.
            lines: see `lines`.
        """
        # A line is fixed in its rod, so its own motion adds nothing along it.
        drifts = drift_along(self._paths, twists, v)[:, :, 3:]
        return np.asarray(np.einsum("nki,nik->nk", drifts, lines))

    def _rotations(self, actions: Array, bodies: list[int]) -> Array:
        """Return the rotations `(3, k, 3, N)` of bodies in the axes of the base."""
        blocks = actions.reshape(len(actions), len(self._batch), 6, 6)[:, bodies, :3, :3]
        return np.ascontiguousarray(blocks.transpose(3, 1, 2, 0))

    def _seen(self, actions: Array, rotations: Array, vectors: Array) -> Array:
        """Return vectors `(k, 3)` that the rods carry as seen from their frames, `(3, k, N)`.

        With rotations `(3, k, 3, N)` of the rods.
        """
        seen = np.matmul(vectors[:, None], rotations)[:, :, 0]
        if self._carried:
            frames = self._rotations(actions, [self._frames[k] for k in self._carried])
            own = np.add.reduce(frames * seen[:, self._carried, None])
            seen[:, self._carried] = own.transpose(1, 0, 2)
        return seen
