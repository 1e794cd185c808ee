"""Closure: the equations that weld the loops, for many samples at once.

In world axes about the twin's origin a closed loop says that the twists of its joints, summed
along the predecessor's path, equal those along the successor's path. Each loop gives six rows;
rows that no motion of the loop's joints can ever violate are redundant and are projected out
(`Reduction`), their reactions being statically indeterminate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .groups import Group
from .mechanism import Coupling, Loop, Mechanism
from .tree import ancestors
from .twin import Twin, cross, placement

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the greatest count as zero in rank decisions."""


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a weld: where it sits and the moving coordinates on its path to the other side.

    Attributes:
        body: number of the joint that moves the body (0-based), -1 for the world.
        rotation, translation: constant placement of the weld in that body.
        columns: moving coordinates on the path, from the common ancestor outwards.
        starts: where in `columns` each joint begins.
    """

    body: int
    rotation: Array
    translation: Array
    columns: Array
    starts: Array

    def place(self, actions: Array) -> tuple[Array, Array]:
        """Return rotation `(3, 3, N)` and position `(3, N)` of the weld."""
        if self.body < 0:
            ones = np.ones(len(actions))
            return self.rotation[:, :, None] * ones, self.translation[:, None] * ones
        rotation, position = placement(actions, self.body)
        return (
            np.einsum("ikn,kj->ijn", rotation, self.rotation),
            position + np.einsum("ikn,k->in", rotation, self.translation),
        )

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return `(N, 6)` accelerations of the weld that the velocities alone cause."""
        if not self.columns.size:
            return np.zeros((len(twists), 6))
        own = twists[:, self.columns] * rates[:, self.columns, None]
        own = np.add.reduceat(np.ascontiguousarray(own.transpose(2, 1, 0)), self.starts, axis=1)
        carried = np.cumsum(own, axis=1) - own
        linear = cross(carried[3:], own[:3]) + cross(carried[:3], own[3:])
        angular = cross(carried[3:], own[3:])
        return np.concatenate([linear.sum(axis=1), angular.sum(axis=1)]).T


@dataclass(frozen=True, eq=False)
class Reduction:
    """The rows of each loop that its motion can reach, and those that it cannot.

    Attributes:
        rows: per loop `(6, r)`: orthonormal combinations of the weighed rows that the joints'
            twists span over the whole motion.
        null: per loop `(6, 6 - r)`: the combinations that they never reach.
    """

    rows: tuple[Array, ...]
    null: tuple[Array, ...]

    @property
    def null_count(self) -> int:
        """Number of redundant rows of all loops together."""
        return sum(null.shape[1] for null in self.null)


class Closure:
    """The loops and couplings of a group.

    A coupling adds one row, which needs no geometry: the angles of its two sides are proportional.

    Attributes:
        moving: `(m,)` velocity coordinates that may move, known ones first, then passives.
        signs: `(L, n)` +1 for bodies on a loop's predecessor path, -1 on its successor path.
        weights: `(6,)` scale of a wrench's components [1/m for forces, 1 for moments]: rows and
            wrenches are compared with lengths in units of the mechanism's length.
        gears: `(m, G)` coefficients of the couplings' rows.
        geared: velocity coordinates that couplings count, held ones included.
        gear_ratios: their coefficients, `(len(geared), G)`.
    """

    def __init__(self, mechanism: Mechanism, twin: Twin, group: Group) -> None:
        self.mechanism = mechanism
        self.twin = twin
        self.moving = np.concatenate([group.known, group.passives])
        self.loops = [mechanism.loops[number] for number in group.loops]
        self.couplings = [mechanism.couplings[number] for number in group.couplings]
        self.weights = np.repeat([1.0 / mechanism.length, 1.0], 3)
        self.signs = np.zeros((len(self.loops), len(twin)))
        self.sides = [self._sides(number, loop) for number, loop in enumerate(self.loops)]
        self._owners = twin.owner[self.moving]
        self.column_signs = self.signs[:, self._owners]
        gears = np.array([self._gear(coupling) for coupling in self.couplings])
        gears = gears.reshape(-1, mechanism.model.nv).T
        self.gears = gears[self.moving]
        self.geared = np.nonzero(np.any(gears != 0.0, axis=1))[0]
        self.gear_ratios = gears[self.geared]

    def _sides(self, number: int, loop: Loop) -> tuple[Side, Side]:
        owners = self.twin.owner[self.moving]
        paths = [self._path(body) for body in (loop.predecessor, loop.successor)]
        sides = []
        for sign, path, other, body, frame in (
            (1.0, paths[0], paths[1], loop.predecessor, loop.predecessor_placement),
            (-1.0, paths[1], paths[0], loop.successor, loop.successor_placement),
        ):
            own = [place for place in path if place not in other]
            self.signs[number, own] = sign
            columns = [column for place in own for column in np.nonzero(owners == place)[0]]
            on_path = owners[columns]
            starts = [k for k in range(len(columns)) if k == 0 or on_path[k] != on_path[k - 1]]
            translation = frame.translation - (self.twin.origin if body == 0 else 0.0)
            sides.append(
                Side(
                    self.twin.local[body - 1] if body else -1,
                    frame.rotation,
                    translation,
                    np.array(columns, dtype=int),
                    np.array(starts, dtype=int),
                )
            )
        return sides[0], sides[1]

    def _path(self, index: int) -> list[int]:
        return [self.twin.local[body] for body in ancestors(self.mechanism.model, index)]

    def _gear(self, coupling: Coupling) -> Array:
        row = np.zeros(self.mechanism.model.nv)
        for column in coupling.predecessor_columns:
            row[column] = coupling.ratio
        for column in coupling.successor_columns:
            row[column] = -1.0
        return row

    def full(self) -> Reduction:
        """Return the reduction that keeps all six rows of every loop."""
        count = len(self.sides)
        return Reduction((np.eye(6),) * count, (np.zeros((6, 0)),) * count)

    def reduction(self, twists: Array) -> Reduction:
        """Find the reachable rows from twists `(N, m, 6)` at positions all over the motion.

        The unit twists of a loop's joints at all positions together span the motions that the
        loop can make; when that space is smaller than six (a planar or a spherical chain), the
        rest of its rows hold by themselves, at every position.
        """
        rows, null = [], []
        for signs in self.column_signs:
            on_path = twists[:, signs != 0.0] * self.weights
            # Six columns decide; the triangle of a QR factorisation says all about them.
            triangle = np.asarray(np.linalg.qr(on_path.reshape(-1, 6), mode="r"))
            vectors, values, _ = np.linalg.svd(triangle.T, full_matrices=True)
            rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0
            rows.append(_tidy(vectors[:, :rank]))
            null.append(_tidy(vectors[:, rank:]))
        return Reduction(tuple(rows), tuple(null))

    def rows(self, twists: Array, reduction: Reduction) -> Array:
        """Return the transposed closure matrix `(N, m, R)`: a row per moving coordinate.

        Its columns are the reduced rows of the loops, then those of the couplings.
        """
        weighed = twists * self.weights
        parts = [
            (weighed * signs[:, None]) @ rows
            for signs, rows in zip(self.column_signs, reduction.rows, strict=True)
        ]
        parts.append(np.broadcast_to(self.gears, (len(twists), *self.gears.shape)))
        return np.concatenate(parts, axis=2)

    def project(self, twist: Array, slips: Array | None, reduction: Reduction) -> Array:
        """Return `(N, R)` components along the reduced rows.

        Args:
            twist: loop twists `(N, L, 6)`.
            slips: of the couplings `(N, G)`; zero if None.
            reduction: which rows.
        """
        weighed = twist * self.weights
        parts = [weighed[:, number] @ rows for number, rows in enumerate(reduction.rows)]
        parts.append(np.zeros((len(twist), self.gears.shape[1])) if slips is None else slips)
        return np.concatenate(parts, axis=1)

    def error(self, actions: Array) -> tuple[Array, Array]:
        """Return how far the loops are from closed.

        Returns:
            The twist `(N, L, 6)` that would take each successor to its predecessor, and the
            closure error `(N,)` at the welds: the worst angle [rad] or gap, the latter as a
            fraction of the mechanism's length.
        """
        result = np.empty((len(actions), len(self.sides), 6))
        worst = np.zeros(len(actions))
        for number, (predecessor, successor) in enumerate(self.sides):
            rotation_1, position_1 = predecessor.place(actions)
            rotation_2, position_2 = successor.place(actions)
            turn = _rotation_vector(np.einsum("ikn,jkn->ijn", rotation_1, rotation_2))
            gap = position_1 - position_2
            # A rotation about the origin shifts the weld as well; the twist makes up for it.
            result[:, number, :3] = (gap - cross(turn, 0.5 * (position_1 + position_2))).T
            result[:, number, 3:] = turn.T
            for part in (turn, gap / self.mechanism.length):
                worst = np.maximum(worst, np.sqrt(np.sum(part * part, axis=0)))
        return result, worst

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return loop accelerations `(N, L, 6)` that joint rates `(N, m)` alone cause."""
        result = np.empty((len(twists), len(self.sides), 6))
        for number, (predecessor, successor) in enumerate(self.sides):
            result[:, number] = predecessor.drift(twists, rates) - successor.drift(twists, rates)
        return result


def _rotation_vector(rotation: Array) -> Array:
    """Return rotation vectors `(3, N)` of rotations `(3, 3, N)` below half a turn."""
    vector = 0.5 * np.stack(
        (
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        )
    )
    sine = np.linalg.norm(vector, axis=0)
    cosine = 0.5 * (np.trace(rotation) - 1.0)
    small = sine < 1e-8
    vector *= np.where(small, 1.0, np.arctan2(sine, cosine) / np.where(small, 1.0, sine))
    for sample in np.nonzero(small & (cosine < 0.0))[0]:
        # Half a turn has no antisymmetric part; without this it would pass as closed.
        columns = rotation[:, :, sample] + np.eye(3)
        axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
        vector[:, sample] = np.pi * axis / np.linalg.norm(axis)
    return vector


def _tidy(vectors: Array) -> Array:
    """Return a basis of the same space along the axes where the space allows it.

    Exact zeros and ones keep the rows of a planar or spherical loop free of rounding.
    """
    projector = vectors @ vectors.T
    exact = np.round(projector)
    if vectors.shape[1] and np.allclose(projector, exact, rtol=0.0, atol=1e-12):
        return np.eye(6)[:, np.diag(exact) == 1.0]
    return vectors
