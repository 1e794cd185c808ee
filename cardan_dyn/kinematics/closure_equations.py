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

from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array, consecutive, cross
from ..mechanism.couplings import Coupling
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import ancestors
from ..mechanism.welds import Loop
from .batch_model import BatchModel, UnitTwists
from .loop_geometry import LoopAxes, LoopEnd, LoopPath, gap_between
from .loop_groups import Group
from .reduction import Reduction, reachable_rows


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
        mechanism: the mechanism.
        batch: of the group's bodies.
        movable: `(m,)` velocity coordinates that may move, known ones first, then passives.
        unit_twists: of those.
        rod_spins: of the group's idle rods, if it has any.
        loops: the L loops of the group.
        couplings: its G couplings.
        ends: per loop, its ends on the predecessor's and on the successor's side.
        signs: `(L, n)` +1 for bodies on a loop's predecessor path, -1 on its successor path.
        column_signs: `(L, m)` the same for the movable coordinates.
        weights: `(6,)` scale of a wrench's components [1/m for forces, 1 for moments]: rows and
            wrenches are compared with lengths in units of the mechanism's length.
        coupled_columns: velocity coordinates that couplings count, held ones included.
        coupled_ratios: their coefficients in the couplings' rows, `(len(coupled_columns), G)`.
        coupled_offsets: `(G,)` what their slips are at zero [rad or m].
        slip_units: `(G,)` the length where a slip is one, else 1.
    """

    def __init__(self, mechanism: Mechanism, batch: BatchModel, group: Group) -> None:
        """Collect the equations of a group.

        Args:
            mechanism: the mechanism.
            batch: of the group's bodies.
            group: the group.
        """
        self.mechanism = mechanism
        self.batch = batch
        self.movable = np.concatenate([group.known, group.passives])
        self.unit_twists = UnitTwists(batch, self.movable)
        self.loops = [mechanism.loops[index] for index in group.loops]
        self.couplings = [mechanism.couplings[index] for index in group.couplings]
        self.weights = np.repeat([1.0 / mechanism.characteristic_length, 1.0], 3)
        self._weight_column = self.weights[:, None]
        self.signs = np.array([self._signs_of(loop) for loop in self.loops])
        self.signs = self.signs.reshape(len(self.loops), len(batch))
        self._moved_bodies = batch.moved_body[self.movable]
        if group.idle:
            from .rod_spins import RodSpins  # Few mechanisms have idle rods.

            self.rod_spins = RodSpins(batch, group.idle, self._moved_bodies)
        self.column_signs = self.signs[:, self._moved_bodies]
        self.ends = [_ends_of(loop, batch) for loop in self.loops]
        self._paths = [LoopPath.of(signs, self._moved_bodies) for signs in self.column_signs]
        self._axes = tuple(_axes_of(loop, mechanism, batch) for loop in self.loops)
        self._factors = self.column_signs[:, :, None] * self.weights
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
        self._coupling_rows = coupling_rows[self.movable] / self.slip_units

    def _signs_of(self, loop: Loop) -> Array:
        """Return `(n,)` on which side of a loop each body is, see `signs`."""
        predecessors, successors = (
            self._indices_from_root(body) for body in (loop.predecessor, loop.successor)
        )
        signs = np.zeros(len(self.batch))
        signs[[index for index in predecessors if index not in successors]] = 1.0
        signs[[index for index in successors if index not in predecessors]] = -1.0
        return signs

    @cached_property
    def _candidates(self) -> list[list[LoopAxes]]:
        """Per loop, axes for its rows: those of the body that carries it, then of those on it."""
        return [
            [own, *(_axes_on(int(body), loop, self.mechanism, self.batch) for body in on_loop)]
            for own, loop, on_loop in zip(
                self._axes, self.loops, map(np.flatnonzero, self.signs), strict=True
            )
        ]

    @cached_property
    def bodies_on(self) -> list[BodiesOn]:
        """Per loop, the bodies on it."""
        return [BodiesOn.of(signs, self.batch) for signs in self.signs]

    def _indices_from_root(self, body: int) -> list[int]:
        """Return the batch indices of a body (index in Pinocchio's model) and its ancestors."""
        index_of = self.batch.index_of
        path = ancestors(self.mechanism.model, body)
        return [index_of[index] for index in path if index in index_of]

    def full(self) -> Reduction:
        """Return the reduction that keeps all six rows of every loop."""
        count = len(self.ends)
        return Reduction((np.eye(6),) * count, (np.zeros((6, 0)),) * count, self._axes)

    def reduction(self, twists: Array, actions: Array) -> Reduction:
        """Find the reachable rows at positions all over the motion, see `reachable_rows`.

        Args:
            twists: `(N, m, 6)` of the moving coordinates.
            actions: see `BatchModel.actions`.
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
        count, moving = twists.shape[:2]
        blocks = []
        for signs, factors, axes, rows in zip(
            self.column_signs, self._factors, reduction.axes, reduction.rows, strict=True
        ):
            if axes.body >= 0:
                blocks.append((twists * signs[:, None]) @ self._weighted(axes, actions, rows))
                continue
            # One product of tall matrices is faster than one for every sample.
            block = (twists * factors).reshape(-1, 6) @ rows
            blocks.append(block.reshape(count, moving, rows.shape[1]))
        if self.couplings or not blocks:
            blocks.append(np.broadcast_to(self._coupling_rows, (count, *self._coupling_rows.shape)))
        return blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=2)

    def project(
        self, twist: Array, slips: Array | None, actions: Array, reduction: Reduction
    ) -> Array:
        """Return `(N, R)` components along the reduced rows.

        Args:
            twist: loop twists `(N, L, 6)`.
            slips: of the couplings `(N, G)`; zero if None.
            actions: see `BatchModel.actions`.
            reduction: which rows.
        """
        weighted = twist * self.weights
        blocks = [
            weighted[:, index] @ rows
            if axes.body < 0
            else (twist[:, [index]] @ self._weighted(axes, actions, rows))[:, 0]
            for index, (axes, rows) in enumerate(zip(reduction.axes, reduction.rows, strict=True))
        ]
        if self.couplings or not blocks:
            none = np.zeros((len(twist), self._coupling_rows.shape[1]))
            blocks.append(none if slips is None else slips / self.slip_units)
        return blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=1)

    def wrench(self, axes: LoopAxes, actions: Array, combinations: Array) -> Array:
        """Return wrenches of a loop in the base's axes about the batch model's origin.

        Args:
            axes: of the loop, see `Reduction`.
            actions: see `BatchModel.actions`.
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

    def error(self, actions: Array) -> tuple[Array, Array]:
        """Return how far the loops are from closed.

        Returns:
            The twist `(N, L, 6)` that would take each successor to its predecessor, and the
            closure error `(N,)` at the welds: the worst angle [rad] or gap, the latter as a
            fraction of the mechanism's length.
        """
        result = np.empty((len(actions), len(self.ends), 6))
        worst = np.zeros(len(actions))
        deviation = np.empty((2, 3, len(actions)))
        for index, ends in enumerate(self.ends):
            gap, turn, middle = gap_between(ends, actions)
            # A rotation about the origin shifts the weld as well; the twist makes up for it.
            result[:, index, :3] = (gap - cross(turn, middle)).T
            result[:, index, 3:] = turn.T
            np.divide(gap, self.mechanism.characteristic_length, out=deviation[0])
            deviation[1] = turn
            deviation *= deviation
            np.maximum(worst, np.add.reduce(deviation, axis=1).max(axis=0), out=worst)
        return result, np.sqrt(worst)

    def at_welds(self, twists: Array, actions: Array) -> tuple[Array, Array]:
        """Return all closure equations about the welds instead of the batch model's origin.

        There, gaps and angles do not mix, so that the sum of their squares says how far the loops
        are from closed, wherever the origin is.

        Args:
            twists: `(N, m, 6)` unit twists of the movable coordinates.
            actions: see `BatchModel.actions`.

        Returns:
            Transposed matrices `(N, m, 6 L + G)`, and errors `(N, 6 L)`: gaps as fractions of the
            characteristic length and angles [rad].
        """
        parts, errors = [], []
        for ends, signs in zip(self.ends, self.column_signs, strict=True):
            gap, turn, middle = gap_between(ends, actions)
            rows = twists * signs[:, None]
            rows[:, :, :3] += np.cross(rows[:, :, 3:], middle.T[:, None, :])
            parts.append(rows * self.weights)
            errors.append(np.concatenate([gap, turn]).T * self.weights)
        count = len(twists)
        parts.append(np.broadcast_to(self._coupling_rows, (count, *self._coupling_rows.shape)))
        errors.append(np.zeros((count, 0)))
        return np.concatenate(parts, axis=2), np.concatenate(errors, axis=1)

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return loop accelerations `(N, L, 6)` that joint rates alone cause.

        They are accelerations of the predecessor less those of the successor, spatial ones in
        the base's axes about the batch model's origin. The motion of the body that carries a loop
        adds nothing, which holds for rates that keep the loop closed only.

        Args:
            twists: `(N, m, 6)` or `(1, m, 6)` unit twists of the movable coordinates.
            rates: `(N, m)` of these coordinates, with which the loops stay closed.
        """
        result = np.empty((len(rates), len(self._paths), 6))
        for index, path in enumerate(self._paths):
            result[:, index] = path.drift(twists, rates).T
        return result


def _ends_of(loop: Loop, batch: BatchModel) -> tuple[LoopEnd, LoopEnd]:
    """Return the ends of a loop on its predecessor's and its successor's side."""
    return (
        _end(loop.predecessor, loop.predecessor_placement, batch),
        _end(loop.successor, loop.successor_placement, batch),
    )


def _end(body: int, placement: pinocchio.SE3, batch: BatchModel) -> LoopEnd:
    """Return the end of a loop at a body (index in Pinocchio's model, 0 for the world)."""
    index = batch.index_of.get(body - 1, -1)
    translation = placement.translation - (0.0 if index >= 0 else batch.origin)
    return LoopEnd.of(index, placement.rotation, translation)


def _axes_of(loop: Loop, mechanism: Mechanism, batch: BatchModel) -> LoopAxes:
    """Return axes fixed to the nearest body from which both sides of a loop hang."""
    first, second = (
        ancestors(mechanism.model, body) for body in (loop.predecessor, loop.successor)
    )
    common = max(set(first) & set(second), default=-1)
    if common == batch.base:
        return LoopAxes(-1, np.zeros(3))
    return _axes_on(batch.index_of[common], loop, mechanism, batch)


def _axes_on(body: int, loop: Loop, mechanism: Mechanism, batch: BatchModel) -> LoopAxes:
    """Return axes fixed to a body (index in the batch model), about where the weld is at zero."""
    at_zero = mechanism.placements_at_zero
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

    Args:
        coupling: the coupling.
        slides: `(nv,)` which velocity coordinates are slides.
        length: characteristic length [m].
    """
    if coupling.successor_columns:
        return length if slides[coupling.successor_columns[0]] else 1.0
    first = coupling.predecessor_columns[0]
    return abs(coupling.ratio) * (length if slides[first] else 1.0)
