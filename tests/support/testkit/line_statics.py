"""Statics of drive lines by the equilibrium of all their bodies, each cut free, at rest.

Shafts (two pieces where there is a spline), crosses and discs are bodies; contacts pass on the
forces and moments that their freedoms leave. Nothing is taken from the package but the data of a
line: directions and centres are those of its geometry, pins are turned by the rule that each is
normal to the shaft behind and to the other pin.
"""

from __future__ import annotations

import numpy as np

from cardan_dyn.drive_lines import DriveLine

Array = np.ndarray


def pins(line: DriveLine, position: float) -> list[tuple[Array, Array] | None]:
    """Directions of the driving and the driven pin of each joint; None at constant velocity."""
    axes = line.geometry.directions
    left = np.cross([0.0, 0.0, 1.0], axes[0])
    fork = turned(left / np.linalg.norm(left), axes[0], position)
    found: list[tuple[Array, Array] | None] = []
    for k in range(line.count):
        before, behind = axes[k], axes[k + 1]
        if line.joints[k].kind == "constant_velocity":
            # Rotation is passed on by the swing from one axis to the other; the mark is at 90°.
            swung = swing(before, behind) @ fork
            driven = np.cross(behind, swung)
            found.append(None)
        else:
            driven = np.cross(behind, fork)
            driven /= np.linalg.norm(driven)
            found.append((fork, driven))
        if k + 1 < line.count:
            fork = turned(driven, behind, line.shafts[k + 1].fork_offset)
    return found


def turned(vector: Array, axis: Array, angle: float) -> Array:
    """The vector turned about a unit axis."""
    along = axis * (axis @ vector)
    return along + np.cos(angle) * (vector - along) + np.sin(angle) * np.cross(axis, vector)


def swing(before: Array, behind: Array) -> Array:
    """The least rotation that takes one unit vector to another."""
    normal = np.cross(before, behind)
    cross = np.array(
        [[0, -normal[2], normal[1]], [normal[2], 0, -normal[0]], [-normal[1], normal[0], 0]]
    )
    return np.eye(3) + cross + cross @ cross / (1.0 + before @ behind)


def meeting(line: DriveLine, piece: int) -> Array:
    """The point in which the axes beside a coupling piece meet, or its middle if they are one."""
    one, two = line.geometry.centres[piece - 1 : piece + 1]
    u, v = line.geometry.directions[piece - 1], line.geometry.directions[piece + 1]
    if np.linalg.norm(np.cross(u, v)) < 1e-12:
        kind = line.shafts[piece].centring
        length = np.linalg.norm(two - one)
        if kind.equal_at is None:
            return (one + two) / 2
        arm = length / 2 / np.cos(kind.equal_at / 2)
        return two - arm * v if kind.fixed_to == "rear" else one + arm * u
    s = np.linalg.lstsq(np.stack([u, v], axis=1), two - one, rcond=None)[0]
    return one + s[0] * u


class Statics:
    """Unknowns and balances of a line at one position."""

    def __init__(self, line: DriveLine) -> None:
        self.line = line
        self.columns: list[tuple[int, Array, Array]] = []  # number of the unknown, its wrench
        self.bodies: dict[object, int] = {}
        self.entries: list[tuple[int, int, Array]] = []
        self.count = 0
        self.known: list[tuple[int, Array]] = []

    def body(self, name: object) -> int:
        return self.bodies.setdefault(name, len(self.bodies))

    def contact(
        self, one: object, two: object, point: Array, forces: list[Array], moments: list[Array]
    ) -> range:
        """Unknown forces and moments of body one (or None, the ground) on body two at a point."""
        start = self.count
        for force, moment in [(f, np.zeros(3)) for f in forces] + [
            (np.zeros(3), m) for m in moments
        ]:
            wrench = np.concatenate([force, moment + np.cross(point, force)])
            for name, sign in ((two, 1.0), (one, -1.0)):
                if name is not None:
                    self.entries.append((self.body(name), self.count, sign * wrench))
            self.count += 1
        return range(start, self.count)

    def load(self, name: object, force: Array, moment: Array, point: Array) -> None:
        self.known.append(
            (self.body(name), np.concatenate([force, moment + np.cross(point, force)]))
        )

    def solved(self) -> tuple[Array, float]:
        matrix = np.zeros((6 * len(self.bodies), self.count))
        right = np.zeros(6 * len(self.bodies))
        for body, column, wrench in self.entries:
            matrix[6 * body : 6 * body + 6, column] += wrench
        for body, wrench in self.known:
            right[6 * body : 6 * body + 6] -= wrench
        found, *_ = np.linalg.lstsq(matrix, right, rcond=None)
        return found, float(np.abs(matrix @ found - right).max())


def across(axis: Array) -> list[Array]:
    """Two unit vectors normal to an axis and to each other."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return [first, np.cross(axis, first)]


def statics(
    line: DriveLine,
    position: float,
    locating: dict[str, bool],
    torque: float = 1.0,
    *,
    push: float = 0.0,
    weight: float = 0.0,
) -> dict[str, Array]:
    """Forces of bearings on their shafts, and of centrings on the shaft behind, in world axes.

    Args:
        line: whose bearings all have names.
        position: of the input shaft [rad].
        locating: whether each bearing carries axial force.
        torque: that the input shaft brings [N·m].
        push: force with which the front piece pushes the rear piece at each spline [N].
        weight: acceleration of free fall [m/s²], of shafts whose mass is theirs in one piece.
    """
    axes, centres = line.geometry.directions, line.geometry.centres
    found = Statics(line)
    whole = list(np.eye(3))

    def piece(k: int, distance: float) -> object:
        spline = line.shafts[k].spline
        if spline is None:
            return ("shaft", k)
        cut = spline.distance if spline.distance is not None else line.geometry.lengths[k] / 2
        return ("rear", k) if distance > cut else ("shaft", k)

    def rear(k: int) -> object:
        return ("rear", k) if line.shafts[k].spline is not None else ("shaft", k)

    wanted = {}
    for k, shaft in enumerate(line.shafts):
        origin, axis = centres[max(k - 1, 0)], axes[k]
        for bearing in shaft.bearings:
            at = origin + axis * (bearing.distance if k else -bearing.distance)
            forces = across(axis) + ([axis] if locating[bearing.name] else [])
            body = piece(k, bearing.distance)
            wanted[bearing.name] = found.contact(None, body, at, forces, []), forces
        if shaft.spline is not None:
            distance = shaft.spline.distance
            at = origin + axis * (line.geometry.lengths[k] / 2 if distance is None else distance)
            found.contact(("shaft", k), ("rear", k), at, across(axis), whole)
            found.load(("rear", k), push * axis, np.zeros(3), at)
            found.load(("shaft", k), -push * axis, np.zeros(3), at)
        if weight and shaft.mass:
            length = line.geometry.lengths[k]
            length = 0.0 if np.isnan(length) else length
            centre = length / 2 if shaft.centre is None else shaft.centre
            at = origin + axis * (centre if k else -centre)
            found.load(("shaft", k), np.array([0, 0, -weight * shaft.mass]), np.zeros(3), at)
        if shaft.centring is not None:
            at = meeting(line, k)
            before, behind = rear(k - 1), ("shaft", k + 1)
            if shaft.centring.kind == "disc":
                found.contact(("shaft", k), ("disc", k), at, [axis], whole)
                found.contact(("disc", k), before, at, across(axis), [])
                forces = across(axis)
                wanted[f"centring {k}"] = found.contact(("disc", k), behind, at, forces, []), forces
            else:
                slides = axes[k - 1] if shaft.centring.fixed_to == "rear" else axes[k + 1]
                forces = across(slides)
                wanted[f"centring {k}"] = found.contact(before, behind, at, forces, []), forces
    for k, pair in enumerate(pins(line, position)):
        before, behind, at = rear(k), ("shaft", k + 1), centres[k]
        if pair is None:
            found.contact(before, behind, at, whole, [axes[k] + axes[k + 1]])
            continue
        driving, driven = pair
        found.contact(before, ("cross", k), at, whole, across(driving))
        found.contact(("cross", k), behind, at, whole, across(driven))
        if weight and line.joints[k].cross_mass:
            force = np.array([0, 0, -weight * line.joints[k].cross_mass])
            found.load(("cross", k), force, np.zeros(3), at)
    found.load(("shaft", 0), np.zeros(3), torque * axes[0], centres[0])
    found.contact(None, ("shaft", line.count), centres[-1], [], [axes[-1]])
    values, residual = found.solved()
    assert residual < 1e-9 * max(abs(torque), abs(push), weight * 100.0, 1.0), residual
    return {
        name: sum(values[i] * force for i, force in zip(columns, forces, strict=True))
        for name, (columns, forces) in wanted.items()
    }
