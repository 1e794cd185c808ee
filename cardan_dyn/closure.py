"""Closure: the equations that weld the loops, for many samples at once.

In world axes about the twin's origin a closed loop says that the twists of its joints, summed
along the predecessor's path, equal those along the successor's path. Each loop gives six rows;
rows that no motion of the loop's joints can ever violate are redundant and are projected out
(`Reduction`), their reactions being statically indeterminate. A planar loop stays in its plane
only as seen from the body that carries it, so rows are chosen in the axes of that body: the
nearest one from which both sides of the loop hang.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .groups import RANK_TOLERANCE, Group
from .mechanism import Coupling, Loop, Mechanism
from .tree import ancestors
from .twin import Twin, UnitTwists, cross, placement

if TYPE_CHECKING:
    from pinocchio import SE3


@dataclass(frozen=True, eq=False, repr=False)
class Side:
    """One side of a weld.

    Attributes:
        body: number of the joint that moves the body (0-based), -1 for the world.
        rotation, translation: constant placement of the weld in that body.
        turned, moved: whether they are more than the identity.
    """

    body: int
    rotation: Array
    translation: Array
    turned: bool
    moved: bool

    @staticmethod
    def of(body: int, rotation: Array, translation: Array) -> Side:
        """Return the side of a weld placed like this in a body."""
        turned, moved = bool(np.any(rotation != np.eye(3))), bool(np.any(translation))
        return Side(body, rotation, translation, turned, moved)

    def place(self, actions: Array) -> tuple[Array, Array]:
        """Return rotation `(3, 3, N)` and position `(3, N)` of the weld, N = 1 in the world."""
        if self.body < 0:
            return self.rotation[:, :, None], self.translation[:, None]
        rotation, position = placement(actions, self.body)
        if self.moved:
            position = position + np.einsum("ikn,k->in", rotation, self.translation)
        if self.turned:
            rotation = np.einsum("ikn,kj->ijn", rotation, self.rotation)
        return rotation, position


@dataclass(frozen=True, eq=False, repr=False)
class Path:
    """The moving coordinates of a loop, from the common ancestor outwards on both sides.

    Attributes:
        columns: their places among the moving coordinates.
        signs: `(k, 1)` 1 on the predecessor's side, -1 on the successor's.
        before: `(k, k)` 1 where the second one moves the joint of the first.
    """

    columns: Array
    signs: Array
    before: Array

    def drift(self, twists: Array, rates: Array) -> Array:
        """Return `(6, N)` accelerations, predecessor less successor, that rates alone cause."""
        own = twists[:, self.columns] * rates[:, self.columns, None]
        own = own.transpose(2, 1, 0)
        carried = np.matmul(self.before, own)
        own = own * self.signs
        # Of a twist (v, w) carried with another one: linear w × v + v × w, angular w × w.
        count = len(self.columns)
        parts = cross(
            np.concatenate((carried[3:], carried[:3], carried[3:]), axis=1),
            np.concatenate((own[:3], own[3:], own[3:]), axis=1),
        )
        linear, angular = parts[:, : 2 * count].sum(axis=1), parts[:, 2 * count :].sum(axis=1)
        return np.concatenate((linear, angular))


@dataclass(frozen=True, eq=False, repr=False)
class Base:
    """The axes in which a loop's rows are chosen.

    Attributes:
        body: place in the twin of the body that carries the loop, -1 for the world.
        point: `(3,)` point in that body about which twists are taken there.
    """

    body: int
    point: Array

    def turns(self, actions: Array) -> Array:
        """Return `(N, 6, 6)` matrices: a twist (a row, in world axes) times them is one here.

        Times a wrench here (a column), they give the wrench in world axes.
        """
        rotation, position = placement(actions, self.body)
        point = position + np.einsum("ikn,k->in", rotation, self.point)
        columns = rotation.transpose(2, 0, 1)
        result = np.zeros((len(actions), 6, 6))
        result[:, :3, :3] = result[:, 3:, 3:] = columns
        result[:, 3:, :3] = np.cross(point.T[:, :, None], columns, axis=1)
        return result


@dataclass(frozen=True, eq=False, repr=False)
class Reduction:
    """The rows of each loop that its motion can reach, and those that it cannot.

    Attributes:
        rows: per loop `(6, r)`: orthonormal combinations of the weighed rows, in the loop's
            `Base`, that the joints' twists span over the whole motion.
        null: per loop `(6, 6 - r)`: the combinations that they never reach.
    """

    rows: tuple[Array, ...]
    null: tuple[Array, ...]


class Closure:
    """The loops and couplings of a group.

    A coupling adds one row, which needs no geometry: the angles of its two sides are proportional.

    Attributes:
        moving: `(m,)` velocity coordinates that may move, known ones first, then passives.
        unit_twists: of those.
        signs: `(L, n)` +1 for bodies on a loop's predecessor path, -1 on its successor path.
        weights: `(6,)` scale of a wrench's components [1/m for forces, 1 for moments]: rows and
            wrenches are compared with lengths in units of the mechanism's length.
        bases: per loop, the axes in which its rows are chosen.
        gears: `(m, G)` coefficients of the couplings' rows.
        geared: velocity coordinates that couplings count, held ones included.
        gear_ratios: their coefficients, `(len(geared), G)`.
        gear_units: `(G,)` the length where a slip is one, else 1.
    """

    def __init__(
        self, mechanism: Mechanism, twin: Twin, group: Group, zero: dict[int, SE3]
    ) -> None:
        """Collect the equations of a group.

        Args:
            mechanism: the mechanism.
            twin: of the group's bodies.
            group: the group.
            zero: placements of the bodies with every joint at zero.
        """
        self.mechanism = mechanism
        self.twin = twin
        self.moving = np.concatenate([group.known, group.passives])
        self.unit_twists = UnitTwists(twin, self.moving)
        self.loops = [mechanism.loops[number] for number in group.loops]
        self.couplings = [mechanism.couplings[number] for number in group.couplings]
        self.weights = np.repeat([1.0 / mechanism.length, 1.0], 3)
        self.signs = np.zeros((len(self.loops), len(twin)))
        self._owners = twin.owner[self.moving]
        self.sides: list[tuple[Side, Side]] = []
        self._paths: list[Path] = []
        self.bases: list[Base] = []
        for number, loop in enumerate(self.loops):
            sides, path = self._sides(number, loop)
            self.sides.append(sides)
            self._paths.append(path)
            self.bases.append(self._base(loop, zero))
        self.column_signs = self.signs[:, self._owners]
        self._factors = self.column_signs[:, :, None] * self.weights
        slides = np.any(twin.subspace[self.moving, :3] != 0.0, axis=1)
        # In rank decisions slides count by lengths, or the unit of length would decide.
        self._units = np.where(slides, mechanism.length, 1.0)[:, None] * self.weights
        gears = np.array([self._gear(coupling) for coupling in self.couplings])
        gears = gears.reshape(-1, mechanism.model.nv).T
        self.gears = gears[self.moving]
        self.geared = np.nonzero(np.any(gears != 0.0, axis=1))[0]
        self.gear_ratios = gears[self.geared]
        slides = np.any(twin.subspace[:, :3] != 0.0, axis=1)
        self.gear_units = np.array(
            [self._slip_unit(coupling, slides) for coupling in self.couplings]
        )

    def _sides(self, number: int, loop: Loop) -> tuple[tuple[Side, Side], Path]:
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
            translation = frame.translation - (self.twin.origin if body == 0 else 0.0)
            place = self.twin.local[body - 1] if body else -1
            sides.append(Side.of(place, frame.rotation, translation))
        owners = self._owners[columns]
        # Bodies are numbered from the root outwards.
        before = (owners[:, None] > owners) & np.equal.outer(signs, signs)
        path = Path(np.array(columns, dtype=int), np.array(signs)[:, None], before.astype(float))
        return (sides[0], sides[1]), path

    def _base(self, loop: Loop, zero: dict[int, SE3]) -> Base:
        first, second = (
            ancestors(self.mechanism.model, body) for body in (loop.predecessor, loop.successor)
        )
        common = [body for body in first if body in set(second)]
        if not common:
            return Base(-1, np.zeros(3))
        carrier, end = zero[common[-1]], zero[loop.predecessor - 1]
        point = carrier.rotation.T @ (end.translation - carrier.translation)
        return Base(self.twin.local[common[-1]], point)

    def _path(self, index: int) -> list[int]:
        return [self.twin.local[body] for body in ancestors(self.mechanism.model, index)]

    def _gear(self, coupling: Coupling) -> Array:
        row = np.zeros(self.mechanism.model.nv)
        for column in coupling.predecessor_columns:
            row[column] = coupling.ratio
        for column in coupling.successor_columns:
            row[column] = -1.0
        return row

    def _slip_unit(self, coupling: Coupling, slides: Array) -> float:
        """Return what a coupling's slip is compared with: one radian, or the length."""
        length = self.mechanism.length
        if coupling.successor_columns:
            return length if slides[coupling.successor_columns[0]] else 1.0
        first = coupling.predecessor_columns[0]
        return abs(coupling.ratio) * (length if slides[first] else 1.0)

    def full(self) -> Reduction:
        """Return the reduction that keeps all six rows of every loop."""
        count = len(self.sides)
        return Reduction((np.eye(6),) * count, (np.zeros((6, 0)),) * count)

    def reduction(self, twists: Array, actions: Array) -> Reduction:
        """Find the reachable rows at positions all over the motion.

        The unit twists of a loop's joints at all positions together span the motions that the
        loop can make; when that space is smaller than six (a planar or a spherical chain), the
        rest of its rows hold by themselves, at every position.

        Args:
            twists: `(N, m, 6)` of the moving coordinates.
            actions: see `Twin.actions`.
        """
        rows, null = [], []
        for signs, base in zip(self.column_signs, self.bases, strict=True):
            chosen = signs != 0.0
            on_path = twists[:, chosen]
            if base.body >= 0:
                on_path = on_path @ base.turns(actions)
            on_path = on_path * self._units[chosen]
            # Six columns decide; the triangle of a QR factorisation says all about them.
            triangle = np.asarray(np.linalg.qr(on_path.reshape(-1, 6), mode="r"))
            vectors, values, _ = np.linalg.svd(triangle.T, full_matrices=True)
            rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0
            rows.append(_tidy(vectors[:, :rank]))
            null.append(_tidy(vectors[:, rank:]))
        return Reduction(tuple(rows), tuple(null))

    def rows(self, twists: Array, actions: Array, reduction: Reduction) -> Array:
        """Return the transposed closure matrix `(N, m, R)`: a row per moving coordinate.

        Its columns are the reduced rows of the loops, then those of the couplings.
        """
        count, moving = twists.shape[:2]
        parts = []
        for signs, factors, base, rows in zip(
            self.column_signs, self._factors, self.bases, reduction.rows, strict=True
        ):
            if base.body >= 0:
                parts.append((twists * signs[:, None]) @ self._weighed(base, actions, rows))
                continue
            # One product of tall matrices is faster than one for every sample.
            part = (twists * factors).reshape(-1, 6) @ rows
            parts.append(part.reshape(count, moving, rows.shape[1]))
        if self.couplings or not parts:
            parts.append(np.broadcast_to(self.gears, (count, *self.gears.shape)))
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=2)

    def project(
        self, twist: Array, slips: Array | None, actions: Array, reduction: Reduction
    ) -> Array:
        """Return `(N, R)` components along the reduced rows.

        Args:
            twist: loop twists `(N, L, 6)`.
            slips: of the couplings `(N, G)`; zero if None.
            actions: see `Twin.actions`.
            reduction: which rows.
        """
        weighed = twist * self.weights
        parts = [
            weighed[:, number] @ rows
            if base.body < 0
            else (twist[:, [number]] @ self._weighed(base, actions, rows))[:, 0]
            for number, (base, rows) in enumerate(zip(self.bases, reduction.rows, strict=True))
        ]
        if self.couplings or not parts:
            parts.append(np.zeros((len(twist), self.gears.shape[1])) if slips is None else slips)
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    def wrench(self, number: int, actions: Array, combinations: Array) -> Array:
        """Return wrenches of a loop in world axes about the twin's origin.

        Args:
            number: place of the loop in the group.
            actions: see `Twin.actions`.
            combinations: of its weighed rows, `(N, 6, k)` or `(6, k)`.
        """
        weighed = combinations * self.weights[:, None]
        base = self.bases[number]
        if base.body >= 0:
            return np.asarray(base.turns(actions) @ weighed)
        return np.broadcast_to(weighed, (len(actions), *weighed.shape[-2:]))

    def _weighed(self, base: Base, actions: Array, rows: Array) -> Array:
        """Return `(N, 6, r)` the rows of a loop that a moving body carries, in world axes."""
        return np.asarray(base.turns(actions) @ (self.weights[:, None] * rows))

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
            turn = _turns(rotation_1, rotation_2)
            gap = position_1 - position_2
            # A rotation about the origin shifts the weld as well; the twist makes up for it.
            result[:, number, :3] = (gap - cross(turn, 0.5 * (position_1 + position_2))).T
            result[:, number, 3:] = turn.T
            gap /= self.mechanism.length
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


def _turns(first: Array, second: Array) -> Array:
    """Return the rotations `(3, N)` that take second frames to first ones, both `(3, 3, N)`.

    Along the axis, twice the sine of half the angle: the angle itself where it is small.
    """
    # The cross products of corresponding axes sum up to the axis times twice the sine.
    vector = cross(second, first).sum(axis=1)
    product = first * second
    # The trace of the rotation and one more are four times the squared cosine of half the angle.
    square = product.reshape(9, -1).sum(axis=0) + 1.0
    if not square.min() > 1e-12:
        return _half_turns(vector, square, first, second)
    vector /= np.sqrt(square)
    return np.asarray(vector)


def _half_turns(vector: Array, square: Array, first: Array, second: Array) -> Array:
    """Return rotations some of which are half turns, whose axis the products do not tell."""
    half = ~(square > 1e-12)
    vector /= np.sqrt(np.where(half, 1.0, square))
    for sample in np.nonzero(half)[0]:
        one, other = (part[:, :, sample % part.shape[2]] for part in (first, second))
        columns = one @ other.T + np.eye(3)
        axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
        vector[:, sample] = 2.0 * axis / np.linalg.norm(axis)
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
