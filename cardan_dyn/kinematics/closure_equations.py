"""Closure: the equations that weld the loops, for many samples at once.

In world axes about the batch model's origin a closed loop says that the twists of its joints,
summed along the predecessor's path, equal those along the successor's path. Each loop gives six
rows; rows that no motion of the loop's joints can ever violate are redundant and are projected out
(`Reduction`), their reactions being statically indeterminate. A planar loop stays in its plane only
as seen from the body that carries it, so rows are chosen in the axes of that body: the nearest one
from which both sides of the loop hang.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, cross
from ..mechanism.mechanism import Coupling, Loop, Mechanism
from ..mechanism.tree import ancestors
from .batch_model import BatchModel, UnitTwists
from .loop_geometry import LoopAxes, LoopEnd, LoopPath, rotations_between
from .loop_groups import Group
from .reduction import Reduction, axis_aligned
from .tolerances import RANK_TOLERANCE


class ClosureEquations:
    """The loops and couplings of a group.

    A coupling adds one row, which needs no geometry: the angles of its two sides are proportional.

    Attributes:
        movable: `(m,)` velocity coordinates that may move, known ones first, then passives.
        unit_twists: of those.
        signs: `(L, n)` +1 for bodies on a loop's predecessor path, -1 on its successor path.
        weights: `(6,)` scale of a wrench's components [1/m for forces, 1 for moments]: rows and
            wrenches are compared with lengths in units of the mechanism's length.
        coupled_columns: velocity coordinates that couplings count, held ones included.
        coupled_ratios: their coefficients in the couplings' rows, `(len(coupled_columns), G)`.
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
        self.loops = [mechanism.loops[number] for number in group.loops]
        self.couplings = [mechanism.couplings[number] for number in group.couplings]
        self.weights = np.repeat([1.0 / mechanism.characteristic_length, 1.0], 3)
        self.signs = np.zeros((len(self.loops), len(batch)))
        self._owners = batch.owner[self.movable]
        self.ends: list[tuple[LoopEnd, LoopEnd]] = []
        self._paths: list[LoopPath] = []
        self._axes: list[LoopAxes] = []
        for number, loop in enumerate(self.loops):
            sides, path = self._ends_of(number, loop)
            self.ends.append(sides)
            self._paths.append(path)
            self._axes.append(self._axes_of(loop))
        self.column_signs = self.signs[:, self._owners]
        self._factors = self.column_signs[:, :, None] * self.weights
        slides = np.any(batch.subspace[self.movable, :3] != 0.0, axis=1)
        # In rank decisions slides count by lengths, or the unit of length would decide.
        self._units = np.where(slides, mechanism.characteristic_length, 1.0)[:, None] * self.weights
        coupling_rows = np.array([self._coupling_row(coupling) for coupling in self.couplings])
        coupling_rows = coupling_rows.reshape(-1, mechanism.model.nv).T
        self._coupling_rows = coupling_rows[self.movable]
        self.coupled_columns = np.nonzero(np.any(coupling_rows != 0.0, axis=1))[0]
        self.coupled_ratios = coupling_rows[self.coupled_columns]
        slides = np.any(batch.subspace[:, :3] != 0.0, axis=1)
        self.slip_units = np.array(
            [self._slip_unit(coupling, slides) for coupling in self.couplings]
        )

    def _ends_of(self, number: int, loop: Loop) -> tuple[tuple[LoopEnd, LoopEnd], LoopPath]:
        paths = [self._path(body) for body in (loop.predecessor, loop.successor)]
        sides, columns, signs = [], [], []
        for sign, outwards, other, body, frame in (
            (1.0, paths[0], paths[1], loop.predecessor, loop.predecessor_placement),
            (-1.0, paths[1], paths[0], loop.successor, loop.successor_placement),
        ):
            own = [place for place in outwards if place not in other]
            self.signs[number, own] = sign
            found = [column for place in own for column in np.nonzero(self._owners == place)[0]]
            columns += found
            signs += [sign] * len(found)
            translation = frame.translation - (self.batch.origin if body == 0 else 0.0)
            place = self.batch.local[body - 1] if body else -1
            sides.append(LoopEnd.of(place, frame.rotation, translation))
        owners = self._owners[columns]
        # Bodies are numbered from the root outwards.
        before = (owners[:, None] > owners) & np.equal.outer(signs, signs)
        path = LoopPath(
            np.array(columns, dtype=int), np.array(signs)[:, None], before.astype(float)
        )
        return (sides[0], sides[1]), path

    def _axes_of(self, loop: Loop) -> LoopAxes:
        first, second = (
            ancestors(self.mechanism.model, body) for body in (loop.predecessor, loop.successor)
        )
        common = [body for body in first if body in set(second)]
        if not common:
            return LoopAxes(-1, np.zeros(3))
        at_zero = self.mechanism.placements_at_zero
        carrier, end = at_zero[common[-1]], at_zero[loop.predecessor - 1]
        point = carrier.rotation.T @ (end.translation - carrier.translation)
        return LoopAxes(self.batch.local[common[-1]], point)

    def _path(self, index: int) -> list[int]:
        return [self.batch.local[body] for body in ancestors(self.mechanism.model, index)]

    def _coupling_row(self, coupling: Coupling) -> Array:
        row = np.zeros(self.mechanism.model.nv)
        for column in coupling.predecessor_columns:
            row[column] = coupling.ratio
        for column in coupling.successor_columns:
            row[column] = -1.0
        return row

    def _slip_unit(self, coupling: Coupling, slides: Array) -> float:
        """Return what a coupling's slip is compared with: one radian, or the length."""
        length = self.mechanism.characteristic_length
        if coupling.successor_columns:
            return length if slides[coupling.successor_columns[0]] else 1.0
        first = coupling.predecessor_columns[0]
        return abs(coupling.ratio) * (length if slides[first] else 1.0)

    def full(self) -> Reduction:
        """Return the reduction that keeps all six rows of every loop."""
        count = len(self.ends)
        return Reduction((np.eye(6),) * count, (np.zeros((6, 0)),) * count)

    def reduction(self, twists: Array, actions: Array) -> Reduction:
        """Find the reachable rows at positions all over the motion.

        The unit twists of a loop's joints at all positions together span the motions that the
        loop can make; when that space is smaller than six (a planar or a spherical chain), the
        rest of its rows hold by themselves, at every position.

        Args:
            twists: `(N, m, 6)` of the moving coordinates.
            actions: see `BatchModel.actions`.
        """
        rows, null = [], []
        for signs, axes in zip(self.column_signs, self._axes, strict=True):
            chosen = signs != 0.0
            on_path = twists[:, chosen]
            if axes.body >= 0:
                on_path = on_path @ axes.matrices(actions)
            on_path = on_path * self._units[chosen]
            # Six columns decide; the triangle of a QR factorisation says all about them.
            triangle = np.asarray(np.linalg.qr(on_path.reshape(-1, 6), mode="r"))
            vectors, values, _ = np.linalg.svd(triangle.T, full_matrices=True)
            rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0
            rows.append(axis_aligned(vectors[:, :rank]))
            null.append(axis_aligned(vectors[:, rank:]))
        return Reduction(tuple(rows), tuple(null))

    def rows(self, twists: Array, actions: Array, reduction: Reduction) -> Array:
        """Return the transposed closure matrix `(N, m, R)`: a row per moving coordinate.

        Its columns are the reduced rows of the loops, then those of the couplings.
        """
        count, moving = twists.shape[:2]
        parts = []
        for signs, factors, axes, rows in zip(
            self.column_signs, self._factors, self._axes, reduction.rows, strict=True
        ):
            if axes.body >= 0:
                parts.append((twists * signs[:, None]) @ self._weighed(axes, actions, rows))
                continue
            # One product of tall matrices is faster than one for every sample.
            part = (twists * factors).reshape(-1, 6) @ rows
            parts.append(part.reshape(count, moving, rows.shape[1]))
        if self.couplings or not parts:
            parts.append(np.broadcast_to(self._coupling_rows, (count, *self._coupling_rows.shape)))
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=2)

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
        weighed = twist * self.weights
        parts = [
            weighed[:, number] @ rows
            if axes.body < 0
            else (twist[:, [number]] @ self._weighed(axes, actions, rows))[:, 0]
            for number, (axes, rows) in enumerate(zip(self._axes, reduction.rows, strict=True))
        ]
        if self.couplings or not parts:
            parts.append(
                np.zeros((len(twist), self._coupling_rows.shape[1])) if slips is None else slips
            )
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    def wrench(self, number: int, actions: Array, combinations: Array) -> Array:
        """Return wrenches of a loop in world axes about the batch model's origin.

        Args:
            number: place of the loop in the group.
            actions: see `BatchModel.actions`.
            combinations: of its weighed rows, `(N, 6, k)` or `(6, k)`.
        """
        weighed = combinations * self.weights[:, None]
        axes = self._axes[number]
        if axes.body >= 0:
            return np.asarray(axes.matrices(actions) @ weighed)
        return np.broadcast_to(weighed, (len(actions), *weighed.shape[-2:]))

    def _weighed(self, axes: LoopAxes, actions: Array, rows: Array) -> Array:
        """Return `(N, 6, r)` the rows of a loop that a moving body carries, in world axes."""
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
        for number, (predecessor, successor) in enumerate(self.ends):
            rotation_1, position_1 = predecessor.place(actions)
            rotation_2, position_2 = successor.place(actions)
            turn = rotations_between(rotation_1, rotation_2)
            gap = position_1 - position_2
            # A rotation about the origin shifts the weld as well; the twist makes up for it.
            result[:, number, :3] = (gap - cross(turn, 0.5 * (position_1 + position_2))).T
            result[:, number, 3:] = turn.T
            gap /= self.mechanism.characteristic_length
            for part in (turn, gap):
                part *= part
                np.maximum(worst, part.sum(axis=0), out=worst)
        np.sqrt(worst, out=worst)
        return result, worst

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return loop accelerations `(N, L, 6)` that joint rates `(N, m)` alone cause."""
        result = np.empty((len(twists), len(self._paths), 6))
        for number, path in enumerate(self._paths):
            result[:, number] = path.drift(twists, rates).T
        return result
