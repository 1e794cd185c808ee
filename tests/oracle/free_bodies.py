"""Free bodies: all wrenches of a closed chain at once, from the laws of motion of every body.

The unknowns are the six components of the wrench in every joint, loops included, and one moment
per coupling. The equations are Newton's and Euler's for every body, and the given effort along
every passive coordinate. No tree is cut, nothing is eliminated: what the equations leave open is
the null space of one matrix.

Twists and wrenches are in world axes about the world's origin, linear part and force first, unless
said otherwise.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from chains import Chain, Joint, Redraw, of_quaternion, skew, turn

Array = np.ndarray
Position = dict[str, Array]
"""Joint to its coordinates, in the layout of `Motion.position`."""

OPEN = 1e-7
"""Influence of self-stress, of size one, from which on a component is open."""


def parts_of(joint: Joint) -> list[tuple[str, Array]]:
    """Return the elementary motions of a joint, from the parent outwards, in its frame."""
    axis = joint.axis
    slide, spin = ("slide", axis), ("turn", axis)
    if joint.type == "planar":
        smallest = min(range(3), key=lambda k: (abs(axis[k]), k))
        across = np.cross(axis, np.eye(3)[smallest])
        across /= np.linalg.norm(across)
        return [("slide", across), ("slide", np.cross(axis, across)), spin]
    return {
        "fixed": [],
        "revolute": [spin],
        "continuous": [spin],
        "prismatic": [slide],
        "cylindrical": [slide, spin],
        "universal": [spin, ("turn", joint.axis_2)],
        "spherical": [("ball", axis)],
        "floating": [*(("slide", one) for one in np.eye(3)), ("ball", axis)],
    }[joint.type]


def size_of(joint: Joint) -> int:
    """Return the number of velocity coordinates of a joint."""
    return sum(3 if kind == "ball" else 1 for kind, _ in parts_of(joint))


def carried(first: Array, second: Array) -> Array:
    """Return the rate of the second twist if it is carried along with the first."""
    (v, w), (p, s) = (first[:3], first[3:]), (second[:3], second[3:])
    return np.concatenate([np.cross(w, p) + np.cross(v, s), np.cross(w, s)])


def quaternion_times(first: Array, rotation_vector: Array) -> Array:
    """Return a quaternion turned on by a small rotation in the child's axes."""
    half = 0.5 * np.linalg.norm(rotation_vector)
    second = np.append(0.5 * np.sinc(half / np.pi) * rotation_vector, np.cos(half))
    (u, a), (v, b) = (first[:3], first[3]), (second[:3], second[3])
    result = np.append(a * v + b * u + np.cross(u, v), a * b - u @ v)
    return result / np.linalg.norm(result)


@dataclass(frozen=True, eq=False)
class Geometry:
    """Where everything is at one position.

    Attributes:
        links: link to its placement.
        frames: joint to its frame after its motion.
        before: joint to its frame at coordinate zero, which stays with the parent.
        columns: `(6, n)` unit twists of all coordinates.
    """

    links: dict[str, Array]
    frames: dict[str, Array]
    before: dict[str, Array]
    columns: Array


@dataclass(frozen=True, eq=False)
class Acting:
    """What acts on a chain at one position.

    Attributes:
        gravity: `(3,)` [m/s²].
        joint_loads: joints with one coordinate to efforts.
        link_loads: links to force, moment about the link's origin, and `link` or `world` axes.
    """

    gravity: Array
    joint_loads: Mapping[str, float]
    link_loads: Mapping[str, tuple[Array, Array, str]]


@dataclass(frozen=True, eq=False)
class Statics:
    """Wrenches at one position.

    Attributes:
        wrench: joint to `(6,)`, by the parent on the child, at the joint's origin, in its frame.
        influence: joint to `(6,)` the greatest change of each component, in units of self-stress.
        effort: joint with one coordinate to what drives or holds it; nan where that stays open.
        coupling: coupling to its moment on the successor's coordinates.
        residual: imbalance relative to `scale`.
        scale: size of the greatest wrench, or of what acts on a body [N·m].
        spread: smallest and greatest share of the singular values of the balance that count.
        stiffness: singular values of the elastic problem, relative to what they could be.
    """

    wrench: dict[str, Array]
    influence: dict[str, Array]
    effort: dict[str, float]
    coupling: dict[str, float]
    residual: float
    scale: float
    spread: tuple[float, float]
    stiffness: Array


class Oracle:
    """Kinematics and statics of a chain.

    Attributes:
        chain: its data.
        columns: joint to its velocity coordinates.
        count: number of velocity coordinates.
        wrenched: joints that carry a wrench: all but fixed tree joints.
        body_of: link to the first link of its rigid body.
    """

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.columns: dict[str, slice] = {}
        self.parts = {joint.name: parts_of(joint) for joint in chain.joints.values()}
        self.count = 0
        for joint in chain.joints.values():
            size = size_of(joint)
            self.columns[joint.name] = slice(self.count, self.count + size)
            self.count += size
        self.slides = np.zeros(self.count, dtype=bool)
        for name, parts in self.parts.items():
            column = self.columns[name].start
            for kind, _ in parts:
                self.slides[column] = kind == "slide"
                column += 3 if kind == "ball" else 1
        self.tree = [joint for joint in chain.joints.values() if not joint.closes]
        self.loops = [joint for joint in chain.joints.values() if joint.closes]
        self.wrenched = [
            joint for joint in chain.joints.values() if joint.closes or joint.type != "fixed"
        ]
        self.root = next(iter(set(chain.links) - {joint.child for joint in self.tree}))
        self.body_of = {self.root: self.root}
        self.above = {self.root: np.zeros(self.count, dtype=bool)}
        for joint in self.tree:
            parent = self.body_of[joint.parent]
            self.body_of[joint.child] = parent if joint.type == "fixed" else joint.child
            self.above[joint.child] = self.above[joint.parent].copy()
            self.above[joint.child][self.columns[joint.name]] = True
        self.coupling_rows = self._coupling_rows()

    def zero(self) -> Position:
        """Return the position in which every joint of the tree is at zero, and the loops closed."""
        result = {}
        for name, parts in self.parts.items():
            stated = self.chain.joints[name].zero
            if stated is not None:
                result[name] = stated.copy()
                continue
            values = [[0.0, 0.0, 0.0, 1.0] if kind == "ball" else [0.0] for kind, _ in parts]
            result[name] = np.array([value for group in values for value in group])
        return result

    def single(self) -> list[str]:
        """Return the joints with one coordinate."""
        return [name for name, span in self.columns.items() if span.stop - span.start == 1]

    def rate_columns(self, names: Iterable[str]) -> list[int]:
        """Return the velocity coordinates of joints."""
        return [k for name in names for k in range(*self.columns[name].indices(self.count))]

    def passive(self, prescribed: Iterable[str]) -> list[int]:
        """Return the velocity coordinates of all other joints."""
        rest = set(prescribed)
        return self.rate_columns(name for name in self.columns if name not in rest)

    def geometry(self, x: Position) -> Geometry:
        """Return where everything is."""
        links = {self.root: np.eye(4)}
        frames: dict[str, Array] = {}
        before: dict[str, Array] = {}
        columns = np.zeros((6, self.count))
        for joint in [*self.tree, *self.loops]:
            frame = links[joint.parent] @ joint.parent_side
            before[joint.name] = frame.copy()
            column, at = self.columns[joint.name].start, 0
            for kind, axis in self.parts[joint.name]:
                rotated, point = frame[:3, :3], frame[:3, 3]
                if kind == "ball":
                    rotated = rotated @ of_quaternion(x[joint.name][at : at + 4])
                    columns[:, column : column + 3] = _turning(rotated, point)
                    frame = _moved(frame, rotated, point)
                    column, at = column + 3, at + 4
                    continue
                value, direction = float(x[joint.name][at]), rotated @ axis
                if kind == "slide":
                    columns[:3, column] = direction
                    frame = _moved(frame, rotated, point + direction * value)
                else:
                    columns[:, column] = _turning(direction[:, None], point)[:, 0]
                    frame = _moved(frame, rotated @ turn(axis, value), point)
                column, at = column + 1, at + 1
            frames[joint.name] = frame
            if not joint.closes:
                links[joint.child] = frame
        return Geometry(links, frames, before, columns)

    def gaps(self, geometry: Geometry) -> Array:
        """Return `(6 L,)` by which twists the loops are open, predecessor to successor."""
        gaps = []
        for joint in self.loops:
            frame = geometry.frames[joint.name]
            child_frame = geometry.links[joint.child] @ joint.child_side
            rotated = child_frame[:3, :3] @ frame[:3, :3].T
            vector = 0.5 * np.array(
                [
                    rotated[2, 1] - rotated[1, 2],
                    rotated[0, 2] - rotated[2, 0],
                    rotated[1, 0] - rotated[0, 1],
                ]
            )
            sine, cosine = float(np.linalg.norm(vector)), 0.5 * (np.trace(rotated) - 1.0)
            if sine > 0.0:
                vector *= np.arctan2(sine, cosine) / sine
            point = frame[:3, 3]
            gaps.append(
                np.concatenate([child_frame[:3, 3] - point + np.cross(point, vector), vector])
            )
        return np.concatenate(gaps) if gaps else np.zeros(0)

    def coupling_gaps(self, x: Position) -> Array:
        """Return by how much couplings are not met."""
        values = np.zeros(self.count)
        for name in self.single():
            values[self.columns[name]] = x[name]
        return -self.coupling_rows @ values

    def jacobian(self, geometry: Geometry) -> Array:
        """Return `(6 L + G, n)` the closure equations of all coordinates."""
        rows = []
        for joint in self.loops:
            signs = self.above[joint.parent].astype(float) - self.above[joint.child]
            signs[self.columns[joint.name]] = 1.0
            rows.append(geometry.columns * signs)
        return np.concatenate([*rows, self.coupling_rows]) if rows else self.coupling_rows

    def scaled(self, geometry: Geometry, length: float) -> Array:
        """Return the closure equations with lengths in units of one, about a point nearby."""
        centre = np.mean([frame[:3, 3] for frame in geometry.frames.values()], axis=0)
        matrix = self.jacobian(geometry).copy()
        for loop in range(len(self.loops)):
            rows = slice(6 * loop, 6 * loop + 3)
            matrix[rows] += np.cross(matrix[6 * loop + 3 : 6 * loop + 6], centre, axis=0)
            matrix[rows] /= length
        matrix[:, self.slides] *= length
        gears = matrix[6 * len(self.loops) :]
        gears /= np.max(np.abs(gears), axis=1, initial=0.0, keepdims=True)
        return matrix

    def close(
        self, x: Position, targets: Mapping[str, float], prescribed: Iterable[str], length: float
    ) -> tuple[Position, float]:
        """Bring prescribed joints to their targets and close the loops (Newton).

        Returns:
            The position, and by how much passive joints had to move.

        Raises:
            Redraw: the loops cannot be closed nearby.
        """
        x = {name: values.copy() for name, values in x.items()}
        for name, value in targets.items():
            x[name][0] = value
        passive = self.passive(prescribed)
        per_rate = np.where(self.slides, 1.0 / length, 1.0)
        total = 0.0
        for _ in range(15):
            geometry = self.geometry(x)
            gaps = np.concatenate([self.gaps(geometry), self.coupling_gaps(x)])
            step = np.zeros(self.count)
            step[passive] = self._solved(geometry, gaps, passive, length)
            size = float(np.max(np.abs(step * per_rate), initial=0.0))
            if size > 1.0:
                break
            x, total = self.moved(x, step), total + size
            if size < 1e-14:
                break
        if size > 1e-12:
            raise Redraw("loops cannot be closed")
        return x, total

    def moved(self, x: Position, step: Array) -> Position:
        """Return a position moved along all velocity coordinates `(n,)`."""
        result = {name: values.copy() for name, values in x.items()}
        for name, span in self.columns.items():
            self._move(result, name, step[span])
        return result

    def rates(
        self,
        geometry: Geometry,
        speeds: Mapping[str, float],
        accelerations: Mapping[str, float],
        prescribed: Iterable[str],
        length: float,
    ) -> tuple[Array, Array]:
        """Return velocities and accelerations `(n,)` for those of the drives."""
        passive = self.passive(prescribed)
        matrix = self.jacobian(geometry)
        orders = []
        for given, drift in ((speeds, None), (accelerations, self._drift)):
            rates = np.zeros(self.count)
            for name, value in given.items():
                rates[self.columns[name]] = value
            right = -matrix @ rates
            if drift is not None:
                right -= drift(geometry, orders[0])
            rates[passive] = self._solved(geometry, right, passive, length)
            orders.append(rates)
        return orders[0], orders[1]

    def twists(self, geometry: Geometry, v: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return twists, and accelerations that rates alone cause, of links and loop frames.

        Loop frames have the names of their joints.
        """
        twist = {self.root: np.zeros(6)}
        bias = {self.root: np.zeros(6)}
        for joint in [*self.tree, *self.loops]:
            moving, drift = twist[joint.parent].copy(), bias[joint.parent].copy()
            column = self.columns[joint.name].start
            for kind, _ in self.parts[joint.name]:
                width = 3 if kind == "ball" else 1
                relative = geometry.columns[:, column : column + width] @ v[column : column + width]
                # A ball's axes turn with the child, but its own rotation adds nothing.
                drift += carried(moving, relative)
                moving = moving + relative
                column += width
            name = joint.name if joint.closes else joint.child
            twist[name], bias[name] = moving, drift
        return twist, bias

    def statics(
        self,
        geometry: Geometry,
        v: Array,
        a: Array,
        prescribed: Iterable[str],
        acting: Acting,
        length: float,
        compliance: Mapping[str, Array] | None = None,
    ) -> Statics:
        """Return all wrenches.

        Args:
            geometry: of a closed position.
            v, a: velocities and accelerations `(n,)`.
            prescribed: driven and held joints.
            acting: loads.
            length: by which forces are compared with moments [m].
            compliance: joints to `(6, 6)` compliances, in axes that stay with the parent.
        """
        wrenched = self.wrenched
        unknowns = 6 * len(wrenched) + len(self.chain.couplings)
        bodies = sorted(set(self.body_of.values()) - {self.root})
        row_of = {body: 6 * index for index, body in enumerate(bodies)}
        reference = {
            self.body_of[joint.child]: geometry.frames[joint.name][:3, 3]
            for joint in self.tree
            if joint.type != "fixed"
        }
        balance = np.zeros((6 * len(bodies), unknowns))
        efforts = np.zeros((self.count, unknowns))
        for index, joint in enumerate(wrenched):
            frame, span = geometry.frames[joint.name], slice(6 * index, 6 * index + 6)
            if joint.closes:
                frame = geometry.links[joint.child] @ joint.child_side
            for link, sign in ((joint.child, 1.0), (joint.parent, -1.0)):
                body = self.body_of[link]
                if body in row_of:
                    rows = slice(row_of[body], row_of[body] + 6)
                    balance[rows, span] += sign * _action(frame, frame[:3, 3] - reference[body])
            twists = geometry.columns[:, self.columns[joint.name]]
            linear = twists[:3] + np.cross(twists[3:], frame[:3, 3], axis=0)
            axes = frame[:3, :3].T
            efforts[self.columns[joint.name], span] = np.concatenate(
                [axes @ linear, axes @ twists[3:]]
            ).T
        # ratio × predecessor − successor = 0: the moment acts on the successor's coordinates.
        efforts[:, 6 * len(wrenched) :] = self.coupling_rows.T
        inertia, acts = self._inertia_wrenches(geometry, v, a, acting, row_of, reference)

        given = np.zeros(self.count)
        for name, load in acting.joint_loads.items():
            given[self.columns[name]] = load
        passive = self.passive(prescribed)
        matrix = np.concatenate([balance, efforts[passive]])
        right = np.concatenate([inertia, given[passive]])

        # In moments: forces times the length.
        per_row = np.concatenate(
            [
                np.tile(np.repeat([length, 1.0], 3), len(bodies)),
                np.where(self.slides[passive], length, 1.0),
            ]
        )
        per_unknown = np.ones(unknowns)
        per_unknown[: 6 * len(wrenched)] = np.tile(np.repeat([1.0 / length, 1.0], 3), len(wrenched))
        per_unknown[6 * len(wrenched) :] = 1.0 / np.max(
            np.abs(self.coupling_rows) * np.where(self.slides, length, 1.0), axis=1, initial=0.0
        )
        matrix = matrix * per_row[:, None] * per_unknown
        right = right * per_row
        left_vectors, values, vectors = np.linalg.svd(matrix, full_matrices=True)
        rank = int(np.sum(values > 1e-10 * values[0]))
        null = vectors[rank:].T

        def solved(side: Array) -> Array:
            return vectors[:rank].T @ ((left_vectors[:, :rank].T @ side) / values[:rank])

        solution = solved(right)
        solution = solution + solved(right - matrix @ solution)
        joints = 6 * len(wrenched)
        stiffness = np.zeros(0)
        choice, loose = np.zeros(null.shape[1]), np.eye(null.shape[1])
        if compliance:
            rows = self._elastic(geometry, compliance, per_unknown)
            rows /= np.max(np.linalg.norm(rows, axis=1), initial=1e-300)
            choice, loose, stiffness = _least(rows @ null, -rows @ solution, loose)
        rest = -(solution + null @ choice)[:joints]
        more, loose, _ = _least(null[:joints] @ loose, rest, loose)
        solution = solution + null @ (choice + more)
        residual = matrix @ solution - right

        sizes = [float(np.linalg.norm(part)) for part in solution[:joints].reshape(-1, 6)]
        scale = max([*sizes, acts, *np.abs(right[6 * len(bodies) :]), 1e-300])
        physical = solution * per_unknown
        total = efforts @ physical - given
        unsettled = np.abs((efforts * per_unknown) @ null @ loose).max(axis=1, initial=0.0)
        total[unsettled > OPEN * np.where(self.slides, 1.0 / length, 1.0)] = np.nan
        influence = np.linalg.norm(null, axis=1)
        return Statics(
            {j.name: physical[6 * k : 6 * k + 6] for k, j in enumerate(wrenched)},
            {j.name: influence[6 * k : 6 * k + 6] for k, j in enumerate(wrenched)},
            {name: float(total[self.columns[name]][0]) for name in self.single()},
            {
                coupling.name: float(value)
                for coupling, value in zip(self.chain.couplings, physical[joints:], strict=True)
            },
            float(np.max(np.abs(residual), initial=0.0)) / scale,
            scale,
            (
                float(values[rank - 1] / values[0]),
                float(values[rank] / values[0]) if rank < len(values) else 0.0,
            ),
            stiffness,
        )

    def power(self, geometry: Geometry, v: Array, a: Array, rates: Array, acting: Acting) -> float:
        """Return the power of loads, weight and inertia for virtual rates `(n,)` [W]."""
        virtual, _ = self.twists(geometry, rates)
        bodies = sorted(set(self.body_of.values()) - {self.root})
        reference = {body: np.zeros(3) for body in bodies}
        rows = {body: 6 * index for index, body in enumerate(bodies)}
        inertia, _ = self._inertia_wrenches(geometry, v, a, acting, rows, reference)
        spent = -sum(inertia[row : row + 6] @ virtual[body] for body, row in rows.items())
        loads = [load * rates[self.columns[name]][0] for name, load in acting.joint_loads.items()]
        return float(spent + sum(loads))

    def _coupling_rows(self) -> Array:
        rows = np.zeros((len(self.chain.couplings), self.count))
        for row, coupling in zip(rows, self.chain.couplings, strict=True):
            to_predecessor, to_successor = (
                self.above[coupling.predecessor],
                self.above[coupling.successor],
            )
            row[to_predecessor & ~to_successor] = coupling.ratio
            row[to_successor & ~to_predecessor] = -1.0
        return rows

    def _move(self, x: Position, name: str, step: Array) -> None:
        column = at = 0
        for kind, _ in self.parts[name]:
            if kind == "ball":
                x[name][at : at + 4] = quaternion_times(
                    x[name][at : at + 4], step[column : column + 3]
                )
                column, at = column + 3, at + 4
            else:
                x[name][at] += step[column]
                column, at = column + 1, at + 1

    def _solved(self, geometry: Geometry, right: Array, passive: list[int], length: float) -> Array:
        """Return the passive rates that meet the closure equations best."""
        matrix = self.jacobian(geometry)[:, passive]
        rows = np.ones(len(matrix))
        for loop in range(len(self.loops)):
            rows[6 * loop : 6 * loop + 3] = 1.0 / length
        per_rate = np.where(self.slides[passive], length, 1.0)
        ratios = np.abs(self.coupling_rows) * np.where(self.slides, length, 1.0)
        rows[6 * len(self.loops) :] = 1.0 / np.max(ratios, axis=1, initial=0.0)
        scaled_rates = np.linalg.lstsq(
            matrix * rows[:, None] * per_rate, right * rows, rcond=1e-11
        )[0]
        return scaled_rates * per_rate

    def _drift(self, geometry: Geometry, v: Array) -> Array:
        _, bias = self.twists(geometry, v)
        parts = [bias[joint.name] - bias[joint.child] for joint in self.loops]
        return np.concatenate([*parts, np.zeros(len(self.chain.couplings))])

    def _inertia_wrenches(
        self,
        geometry: Geometry,
        v: Array,
        a: Array,
        acting: Acting,
        rows: dict[str, int],
        reference: dict[str, Array],
    ) -> tuple[Array, float]:
        """Return what joints must exert on the bodies about their references.

        Returns:
            `(6 B,)`, and the size of the greatest part of it as a moment.
        """
        twist, bias = self.twists(geometry, v)
        result, greatest = np.zeros(6 * len(rows)), 0.0
        reach = max(self.chain.size, 1e-300)

        def add(body: str, force: Array, moment: Array, point: Array) -> None:
            nonlocal greatest
            about = moment + np.cross(point - reference[body], force)
            row = rows[body]
            result[row : row + 6] += np.concatenate([force, about])
            greatest = max(greatest, reach * np.linalg.norm(force), np.linalg.norm(about))

        for name, link in self.chain.links.items():
            body = self.body_of[name]
            if body == self.root or link.mass == 0.0:
                continue
            placement = geometry.links[name]
            axes = placement[:3, :3]
            centre = placement[:3, 3] + axes @ link.centre
            change = bias[name] + geometry.columns[:, self.above[name]] @ a[self.above[name]]
            spin, turning = twist[name][3:], change[3:]
            speed = twist[name][:3] + np.cross(spin, centre)
            acceleration = change[:3] + np.cross(turning, centre) + np.cross(spin, speed)
            tensor = axes @ link.inertia @ axes.T
            add(body, -link.mass * acting.gravity, np.zeros(3), centre)
            add(
                body,
                link.mass * acceleration,
                tensor @ turning + np.cross(spin, tensor @ spin),
                centre,
            )
        for name, (force, moment, axes_of) in acting.link_loads.items():
            placement = geometry.links[name]
            axes = placement[:3, :3] if axes_of == "link" else np.eye(3)
            add(self.body_of[name], -axes @ force, -axes @ moment, placement[:3, 3])
        return result, float(greatest)

    def _elastic(
        self, geometry: Geometry, compliance: Mapping[str, Array], per_unknown: Array
    ) -> Array:
        """Return rows whose squares sum up to twice the elastic energy."""
        rows = []
        for index, joint in enumerate(self.wrenched):
            if joint.name not in compliance:
                continue
            values, vectors = np.linalg.eigh(compliance[joint.name])
            root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
            frame = geometry.frames[joint.name]
            turned = geometry.before[joint.name][:3, :3].T @ frame[:3, :3]
            both = np.kron(np.eye(2), turned)
            row = np.zeros((6, len(per_unknown)))
            row[:, 6 * index : 6 * index + 6] = root @ both
            rows.append(row * per_unknown)
        return np.concatenate(rows)


def _least(rows: Array, right: Array, within: Array) -> tuple[Array, Array, Array]:
    """Return the least squares solution, what it leaves open, and the singular values.

    Args:
        rows: for amounts along `within`, each of size one or less.
        right: what they should be.
        within: columns along which amounts may be chosen.
    """
    if within.shape[1] == 0:
        return np.zeros(len(within)), within, np.zeros(0)
    left, values, vectors = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.sum(values > 1e-7))
    amounts = vectors[:rank].T @ ((left[:, :rank].T @ right) / values[:rank])
    return within @ amounts, within @ vectors[rank:].T, values


def _turning(directions: Array, point: Array) -> Array:
    """Return the twists `(6, k)` of turns about directions `(3, k)` through a point."""
    return np.concatenate([np.cross(point[:, None], directions, axis=0), directions])


def _moved(frame: Array, rotated: Array, point: Array) -> Array:
    result = frame.copy()
    result[:3, :3], result[:3, 3] = rotated, point
    return result


def _action(frame: Array, arm: Array) -> Array:
    """Return `(6, 6)` from a wrench in a frame to world axes about a point, an arm away."""
    axes = frame[:3, :3]
    result = np.zeros((6, 6))
    result[:3, :3] = result[3:, 3:] = axes
    result[3:, :3] = skew(arm) @ axes
    return result
