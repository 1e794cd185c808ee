"""Digits: all that is found of a chain in fifty digits, as a function of every number of it.

Rates and accelerations come of Taylor's jets of placements, three orders of time at once, and no
equation is differentiated by hand. Loops close, and balances are solved, by steps of matrices in
double precision which are repeated until fifty digits stay. What a number changes is then told by
a difference over 1e-25 of it.

A jet is an array with the value, its rate and its acceleration along the first axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import lru_cache
from typing import Any, NamedTuple

import mpmath
import numpy as np
from chains import angles
from free_bodies import Oracle, Position
from scenes import Case
from scipy.linalg import qr

Array = np.ndarray
Numbers = dict[str, Decimal]
"""All numbers of a scene, by the names that the package gives to parameters."""

DIGITS = 50
STEP = Decimal("1e-25")
_IDENTITY = np.eye(3, dtype=int).astype(object)
AXES = "xyz"
TURNS = ("roll", "pitch", "yaw")
INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")


@dataclass(frozen=True)
class Spring:
    """A spring and a damper between points of two links."""

    name: str
    links: tuple[str, str]
    points: tuple[Array, Array]
    length: float


@dataclass(frozen=True)
class AtJoint:
    """A spring and a damper, or friction, along the coordinate of a joint.

    Attributes:
        joint: its name.
        rest: position without effort of a spring.
        transition: speed of friction; 0 of a spring.
    """

    name: str
    joint: str
    rest: float = 0.0
    transition: float = 0.0


class Found(NamedTuple):
    """What is found of a sample, all of it in doubles once differences are taken.

    Attributes:
        positions: `(n,)` in the order of `Oracle.columns`; of a ball, rotation since the start.
        velocities, accelerations: `(n,)`; of a ball, in the child's axes.
        wrenches: `(k, 6)`, in the order of `Oracle.wrenched`.
        couplings: moments.
        efforts: of prescribed joints.
        gaps: of loops and couplings, those which are not needed to close them included.
    """

    positions: Array
    velocities: Array
    accelerations: Array
    wrenches: Array
    couplings: Array
    efforts: Array
    gaps: Array


class Sample:
    """A sample of a case, solved in fifty digits.

    Attributes:
        numbers: all of its numbers.
        found: what follows from them.
        units: `(n,)` of coordinates: the size of the chain of slides, else 1.
        influence: `(k, 6)` by how much self-stress of size one changes components of wrenches.
        hang: likewise efforts of prescribed joints.
    """

    def __init__(
        self,
        case: Case,
        oracle: Oracle,
        numbers: Mapping[str, float],
        near: Position,
        elements: Sequence[Spring | AtJoint] = (),
    ) -> None:
        """Solve it.

        Args:
            case: a case.
            oracle: of its chain.
            numbers: see `numbers_of`.
            near: closed position, in doubles.
            elements: what acts besides.
        """
        self._case, self._oracle, self._near, self._elements = case, oracle, near, elements
        self.numbers = {name: Decimal(float(value)) for name, value in numbers.items()}
        self._passive = oracle.passive(case.prescribed)
        self._bodies = sorted(set(oracle.body_of.values()) - {oracle.root})
        start = np.zeros((3, oracle.count), dtype=object)
        for name, span in oracle.columns.items():
            if len(near[name]) == span.stop - span.start:
                start[0, span] = [Decimal(float(value)) for value in near[name]]
            elif span.stop - span.start == 6:
                start[0, span.start : span.start + 3] = [Decimal(float(x)) for x in near[name][:3]]
        geometry, size = oracle.geometry(near), case.chain.size
        matrix = oracle.jacobian(geometry).copy()
        for k, loop in enumerate(oracle.loops):
            point = geometry.frames[loop.name][:3, 3]
            rows = matrix[6 * k : 6 * k + 6]
            rows[:3] += np.cross(rows[3:], point, axis=0)
        self.units = np.where(oracle.slides, size, 1.0)
        joints = 6 * len(oracle.wrenched)
        ratios = (np.abs(oracle.coupling_rows) * self.units).max(axis=1, initial=0.0)
        self._per_row = 1.0 / np.append(
            np.tile(np.repeat([size, 1.0], 3), len(oracle.loops)), ratios
        )
        own = (self._per_row[:, None] * matrix * self.units)[:, self._passive]
        self._rows = qr(own.T, pivoting=True, mode="r")[1][: own.shape[1]]
        self._closing = np.linalg.inv(matrix[np.ix_(self._rows, self._passive)])
        with localcontext() as context:
            context.prec = DIGITS
            y = self._closed(self.numbers, start, 7)
            matrix, _, _ = self._balance(self.numbers, y)
        matrix, first = matrix.astype(float), 6 * len(self._bodies)
        per_column = np.append(np.tile(np.repeat([size, 1.0], 3), len(oracle.wrenched)), ratios)
        by_row = np.append(np.tile(np.repeat([size, 1.0], 3), len(self._bodies)), self.units)
        every = matrix / per_column * by_row[:, None]
        kept = [*range(first), *[first + k for k in self._passive]]
        self._kept, balance = kept, every[kept]
        self._columns = qr(balance, pivoting=True, mode="r")[1][: len(kept)]
        self._solving = np.linalg.inv(matrix[np.ix_(kept, self._columns)])
        null = np.linalg.svd(balance)[2][len(kept) :].T
        self._stress = _decimals(null.sum(axis=1) / per_column)
        self.influence = np.linalg.norm(null[:joints], axis=1).reshape(-1, 6)
        moved = np.linalg.norm(every[first:] @ null, axis=1)
        self.hang = moved[oracle.rate_columns(case.prescribed)]
        self._start, self._wrenches = y, np.zeros(matrix.shape[1], dtype=object)
        self.found = self._solved(self.numbers)
        self._wrenches = np.append(self.found.wrenches.ravel(), self.found.couplings)

    def change(self, name: str, unit: float = 1.0, stress: float = 0.0) -> Found:
        """Return how all that is found changes with a number, per its unit.

        Args:
            name: of the number.
            unit: by which it changes things about as much as there is.
            stress: self-stress that acts besides.
        """
        with localcontext() as context:
            context.prec = DIGITS
            step, more = STEP * Decimal(unit), Decimal(stress) * self._stress
            before = self._solved(self.numbers, more) if stress else self.found
            moved = self._solved({**self.numbers, name: self.numbers[name] + step}, more)
            return Found(
                *(
                    ((after - before) / step).astype(float)
                    for before, after in zip(before, moved, strict=True)
                )
            )

    def _solved(self, numbers: Numbers, stress: Array | int = 0) -> Found:
        with localcontext() as context:
            context.prec = DIGITS
            y = self._closed(numbers, self._start, 4)
            matrix, right, frames = self._balance(numbers, y)
            w, kept = self._wrenches + stress, self._kept
            for _ in range(5):
                missing = (right - matrix @ w)[kept]
                w[self._columns] += _decimals(self._solving @ missing.astype(float))
            efforts = matrix @ w - right
            first = 6 * len(self._bodies)
            own = [first + k for k in self._oracle.rate_columns(self._case.prescribed)]
            velocities, accelerations = y[1].copy(), y[2].copy()
            for name, span in self._oracle.columns.items():
                if name in frames.relative:
                    turned, last = frames.relative[name], slice(span.stop - 3, span.stop)
                    velocities[last] = _vector(turned[0].T @ turned[1])
                    accelerations[last] = _vector(turned[0].T @ turned[2])
            joints = 6 * len(self._oracle.wrenched)
            return Found(
                y[0],
                velocities,
                accelerations,
                w[:joints].reshape(-1, 6),
                w[joints:],
                efforts[own],
                self._gaps(frames, y)[0] * _decimals(self._per_row),
            )

    def _closed(self, numbers: Numbers, start: Array, steps: int) -> Array:
        """Return coordinates with which loops are closed, and their rates.

        A step gains some twelve digits, but rates follow what is closed a step behind.
        """
        case, oracle, y = self._case, self._oracle, start.copy()
        for name in case.prescribed:
            (column,) = oracle.rate_columns([name])
            y[0, column] = numbers[name]
            for order, kind in enumerate(("speed", "acceleration"), 1):
                y[order, column] = numbers.get(f"{kind}:{name}", Decimal(0))
        for _ in range(steps):
            gaps = self._gaps(self._frames(numbers, y), y)[:, self._rows]
            y[:, self._passive] -= _decimals(gaps.astype(float) @ self._closing.T)
        return y

    def _frames(self, numbers: Numbers, y: Array) -> _Frames:
        """Return where everything is."""
        oracle, chain = self._oracle, self._case.chain
        identity = _constant(_IDENTITY)
        links = {oracle.root: (identity, _constant(np.array([0, 0, 0], object)))}
        frames, ends, ways, relative = {}, {}, {}, {}
        for joint in chain.joints.values():
            name = joint.name
            place = f"{name}.predecessor" if joint.closes else name
            at = _placed(links[joint.parent], *_placement(numbers, place))
            column = oracle.columns[name].start
            for kind, axis in oracle.parts[name]:
                if kind == "ball":
                    start = _of_quaternion(self._near[name][-4:])
                    own = start @ _cayley(y[:, column : column + 3])
                    relative[name], at = own, (_product(at[0], own), at[1])
                    ways[column] = [(kind, at[0][0][:, k], at[1][0]) for k in range(3)]
                    column += 3
                    continue
                axis = _unit(axis)
                ways[column] = [(kind, at[0][0] @ axis, at[1][0])]
                if kind == "turn":
                    at = _product(at[0], _turn(axis, y[:, column])), at[1]
                else:
                    at = at[0], at[1] + _product(at[0], y[:, column, None] * axis)
                column += 1
            frames[name] = at
            if not joint.closes:
                links[joint.child] = ends[name] = at
        for joint in oracle.loops:
            place = _placement(numbers, f"{joint.name}.successor")
            ends[joint.name] = _placed(links[joint.child], *place)
        every = {start + k: way for start, own in ways.items() for k, way in enumerate(own)}
        return _Frames(links, frames, ends, every, relative)

    def _gaps(self, frames: _Frames, y: Array) -> Array:
        """Return jets `(3, 6 L + G)` of how far loops and couplings are open."""
        gaps = []
        for joint in self._oracle.loops:
            (rotation, point), (other, end) = frames.ends[joint.name], frames.frames[joint.name]
            across = _product(rotation, np.swapaxes(other, 1, 2))
            gaps.append(end - point)
            gaps.append(-np.array([_vector(part) for part in across], object))
        single = np.zeros_like(y)
        columns = self._oracle.rate_columns(self._oracle.single())
        single[:, columns] = y[:, columns]
        gaps.append(single @ _decimals(self._oracle.coupling_rows).T)
        return np.concatenate(gaps, axis=1)

    def _balance(self, numbers: Numbers, y: Array) -> tuple[Array, Array, _Frames]:
        """Return rows of bodies and of coordinates, what they should be, and where things are."""
        oracle, chain = self._oracle, self._case.chain
        frames = self._frames(numbers, y)
        row_of = {body: 6 * k for k, body in enumerate(self._bodies)}
        first, joints = 6 * len(self._bodies), 6 * len(oracle.wrenched)
        shape = first + oracle.count, joints + len(chain.couplings)
        matrix, right = np.zeros(shape, object), np.zeros(shape[0], object)
        for k, joint in enumerate(oracle.wrenched):
            rotation, point = (part[0] for part in frames.ends[joint.name])
            across = _skew(point) @ rotation
            for link, sign in ((joint.child, 1), (joint.parent, -1)):
                if (row := row_of.get(oracle.body_of[link])) is not None:
                    force, moment = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
                    matrix[row : row + 3, force] += sign * rotation
                    matrix[row + 3 : row + 6, force] += sign * across
                    matrix[row + 3 : row + 6, moment] += sign * rotation
            for column in oracle.rate_columns([joint.name]):
                kind, way, at = frames.ways[column]
                row = matrix[first + column]
                if kind == "slide":
                    row[6 * k : 6 * k + 3] = way @ rotation
                else:
                    row[6 * k : 6 * k + 3] = (_skew(way) @ (point - at)) @ rotation
                    row[6 * k + 3 : 6 * k + 6] = way @ rotation
        matrix[first:, joints:] = _decimals(oracle.coupling_rows).T

        def push(link: str, force: Array, moment: Array, at: Array) -> None:
            """Let a force at a place, and a moment, act on a link."""
            if (row := row_of.get(oracle.body_of[link])) is not None:
                right[row : row + 3] -= force
                right[row + 3 : row + 6] -= moment + _skew(at) @ force

        gravity = np.array([numbers[f"gravity.{axis}"] for axis in AXES])
        for name in chain.links:
            if oracle.body_of[name] in row_of:
                rotation, point = frames.links[name]
                centre = np.array([numbers[f"centre:{name}.{axis}"] for axis in AXES])
                inertia = np.zeros((3, 3), object)
                for kind in INERTIA:
                    row, column = map(AXES.index, kind)
                    inertia[row, column] = inertia[column, row] = numbers[f"inertia:{name}.{kind}"]
                at = point + rotation @ centre
                now, rate, bend = rotation
                spin, turning = _vector(rate @ now.T), _vector(bend @ now.T)
                change = rate @ inertia @ now.T
                moment = (change + change.T) @ spin + now @ inertia @ (now.T @ turning)
                push(name, numbers[f"mass:{name}"] * (gravity - at[2]), -moment, at[0])
        for name, (_, _, axes) in self._case.link_loads.items():
            force, moment = (
                np.array([numbers[f"load:{name}.{kind}_{axis}"] for axis in AXES])
                for kind in ("force", "moment")
            )
            rotation, point = (part[0] for part in frames.links[name])
            if axes == "link":
                force, moment = rotation @ force, rotation @ moment
            push(name, force, moment, point)
        for name in oracle.single():
            (column,) = oracle.rate_columns([name])
            right[first + column] += numbers[f"load:{name}"]
        for item in self._elements:
            if isinstance(item, Spring):
                ends = [
                    frames.links[link][1] + frames.links[link][0] @ _decimals(point)
                    for link, point in zip(item.links, item.points, strict=True)
                ]
                span = ends[1] - ends[0]
                length = (span[0] @ span[0]).sqrt()
                pull = numbers[f"stiffness:{item.name}"] * (length - Decimal(item.length))
                pull += numbers[f"damping:{item.name}"] * (span[0] @ span[1]) / length
                force, none = pull / length * span[0], np.array([0, 0, 0], object)
                push(item.links[0], force, none, ends[0][0])
                push(item.links[1], -force, none, ends[1][0])
                continue
            (column,) = oracle.rate_columns([item.joint])
            x, v, _ = y[:, column]
            if item.transition:
                effort = numbers[f"friction:{item.name}"] * v
                effort /= (v * v + Decimal(item.transition) ** 2).sqrt()
            else:
                effort = numbers[f"stiffness:{item.name}"] * (x - Decimal(item.rest))
                effort += numbers[f"damping:{item.name}"] * v
            right[first + column] -= effort
        return matrix, right, frames


class _Frames(NamedTuple):
    """Where everything is; placements are jets of rotations and points.

    Attributes:
        links: link to its placement.
        frames: joint to its frame after its motion; `ends` to that in its child.
        ways: coordinate to kind, direction and place of its motion.
        relative: joint with a ball to the rotation of that.
    """

    links: dict[str, Any]
    frames: dict[str, Any]
    ends: dict[str, Any]
    ways: dict[int, tuple[str, Array, Array]]
    relative: dict[str, Array]


def numbers_of(case: Case, oracle: Oracle, sample: int) -> dict[str, float]:
    """Return all numbers of a sample of a case, but for those of elements."""
    found: dict[str, float] = dict(case.held)
    for k, name in enumerate(case.drives):
        found[name] = case.positions[sample, k]
        found[f"speed:{name}"] = case.speeds[sample, k]
        found[f"acceleration:{name}"] = case.accelerations[sample, k]
    found |= {f"gravity.{axis}": case.gravity[k] for k, axis in enumerate(AXES)}
    found |= {f"load:{name}": case.joint_loads.get(name, 0.0) for name in oracle.single()}
    for name, parts in case.link_loads.items():
        for kind, part in zip(("force", "moment"), parts[:2], strict=True):
            found |= {f"load:{name}.{kind}_{axis}": part[k] for k, axis in enumerate(AXES)}
    for name, link in case.chain.links.items():
        found[f"mass:{name}"] = link.mass
        found |= {f"centre:{name}.{axis}": link.centre[k] for k, axis in enumerate(AXES)}
        for kind in INERTIA:
            row, column = map(AXES.index, kind)
            found[f"inertia:{name}.{kind}"] = link.inertia[row, column]
    for joint in case.chain.joints.values():
        places = {joint.name: joint.parent_side}
        if joint.closes:
            places = {
                f"{joint.name}.predecessor": joint.parent_side,
                f"{joint.name}.successor": joint.child_side,
            }
        for place, side in places.items():
            values = [*side[:3, 3], *angles(side[:3, :3])]
            found |= {
                f"origin:{place}.{component}": value
                for component, value in zip((*AXES, *TURNS), values, strict=True)
            }
    return found


@np.vectorize(otypes=[object])
def _decimal(value: float) -> Decimal:
    return Decimal(float(value))


def _decimals(values: Any) -> Array:
    values = np.asarray(values, float)
    return _decimal(values) if values.size else np.zeros(values.shape, object)


@lru_cache(maxsize=4096)
def _sine_and_cosine(angle: Decimal) -> tuple[Decimal, Decimal]:
    with mpmath.workdps(DIGITS + 10):
        values = mpmath.sin(mpmath.mpf(str(angle))), mpmath.cos(mpmath.mpf(str(angle)))
        sine, cosine = (Decimal(mpmath.nstr(value, DIGITS + 5)) for value in values)
    return sine, cosine


def _constant(value: Array) -> Array:
    return np.stack([value, 0 * value, 0 * value])


def _product(one: Array, other: Array) -> Array:
    """Return the product of two jets of matrices, or of one with a jet of vectors."""
    if other.ndim == 2:
        return _product(one, other[..., None])[..., 0]
    return np.stack(
        [
            one[0] @ other[0],
            one[1] @ other[0] + one[0] @ other[1],
            one[2] @ other[0] + 2 * (one[1] @ other[1]) + one[0] @ other[2],
        ]
    )


def _skew(vector: Array) -> Array:
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], object)


def _vector(matrix: Array) -> Array:
    """Return the vector of the skew part of a matrix."""
    parts = [matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]
    return np.array(parts, object) / Decimal(2)


def _unit(vector: Array) -> Array:
    exact = _decimals(vector)
    return exact / (exact @ exact).sqrt()


def _turned(axis: Array, angle: Decimal) -> Array:
    """Return the rotation about a unit axis."""
    cross, (sine, cosine) = _skew(axis), _sine_and_cosine(angle)
    return _IDENTITY + sine * cross + (1 - cosine) * (cross @ cross)


def _turn(axis: Array, angle: Array) -> Array:
    """Return the jet of a rotation about a unit axis by a jet."""
    cross, now = _skew(axis), _turned(axis, angle[0])
    rate = cross @ now
    return np.stack([now, angle[1] * rate, angle[2] * rate + angle[1] ** 2 * (cross @ rate)])


def _cayley(vector: Array) -> Array:
    """Return the jet of the rotation that a small jet of a rotation vector says, by Cayley."""
    half = vector / Decimal(2)
    cross = np.stack([_skew(part) for part in half])
    # (1 + |c|²) f = 2, order by order.
    size = half[0] @ half[0], 2 * (half[0] @ half[1]), 2 * (half[1] @ half[1] + half[0] @ half[2])
    f = 2 / (1 + size[0])
    g = -f * size[1] / (1 + size[0])
    k = -(2 * g * size[1] + f * size[2]) / (1 + size[0])
    every = cross + _product(cross, cross)
    return np.stack(
        [
            _IDENTITY + f * every[0],
            g * every[0] + f * every[1],
            k * every[0] + 2 * g * every[1] + f * every[2],
        ]
    )


def _of_quaternion(quaternion: Array) -> Array:
    x, y, z, w = _unit(quaternion)
    cross = _skew(np.array([x, y, z], object))
    return _IDENTITY + 2 * w * cross + 2 * (cross @ cross)


def _placed(at: tuple[Array, Array], rotation: Array, point: Array) -> tuple[Array, Array]:
    return at[0] @ rotation, at[1] + at[0] @ point


def _placement(numbers: Numbers, place: str) -> tuple[Array, Array]:
    point = np.array([numbers[f"origin:{place}.{axis}"] for axis in AXES], object)
    return _by_angles(*(numbers[f"origin:{place}.{turn}"] for turn in TURNS)), point


@lru_cache(maxsize=4096)
def _by_angles(roll: Decimal, pitch: Decimal, yaw: Decimal) -> Array:
    x, y, z = (
        _turned(axis, angle) for axis, angle in zip(_IDENTITY, (roll, pitch, yaw), strict=True)
    )
    return z @ y @ x
