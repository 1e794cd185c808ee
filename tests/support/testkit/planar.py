"""Planar mechanisms solved by hand: circles, loop equations and free-body diagrams.

Positions come from the intersection of circles, speeds and accelerations from the loop
equations, forces from Newton's and Euler's three equations per link, as in any textbook of
mechanism theory (J. Volmer: Getriebetechnik; J. J. Uicker, G. R. Pennock, J. E. Shigley: Theory of
Machines and Mechanisms). Nothing here knows the package under test.

Vectors are arrays `(N, 2)` in world axes, x to the right, y up; angles are counter-clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testkit.urdf_reader import Reader

Array = np.ndarray


def direction(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def turned(vectors: Array) -> Array:
    """Return vectors turned by 90° counter-clockwise, k × r."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def angle_of(vectors: Array) -> Array:
    return np.arctan2(vectors[..., 1], vectors[..., 0])


def circles(first: Array, radius_1: float, second: Array, radius_2: float, side: float) -> Array:
    """Return where two circles meet: left (`side` +1) or right (-1) of the line of centres."""
    line = second - first
    distance = np.hypot(line[..., 0], line[..., 1])
    along = (radius_1**2 - radius_2**2 + distance**2) / (2.0 * distance)
    height = np.sqrt(radius_1**2 - along**2)
    unit = line / distance[..., None]
    return first + along[..., None] * unit + side * height[..., None] * turned(unit)


def two_rates(column_1: Array, column_2: Array, right: Array) -> tuple[Array, Array]:
    """Solve x_1 column_1 + x_2 column_2 = right, the two equations of a loop, by Cramer's rule."""
    determinant = _cross(column_1, column_2)
    return _cross(right, column_2) / determinant, _cross(column_1, right) / determinant


def _cross(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


@dataclass(frozen=True)
class PlanarLink:
    """Mass [kg], centre of mass [m] in the axes of the link, inertia about its normal [kg·m²]."""

    mass: float
    centre: Array
    inertia: float


def planar_link(reader: Reader, name: str) -> PlanarLink:
    body = reader.body(name)
    assert body is not None
    return PlanarLink(body.mass, body.centre[:2], float(body.inertia[2, 2]))


@dataclass(frozen=True)
class Moving:
    """A link in motion: its origin, the angle of its x axis, and how both accelerate."""

    origin: Array
    origin_acceleration: Array
    angle: Array
    speed: Array
    acceleration: Array

    def arm(self, local: Array) -> Array:
        """Return the vector from the origin to a point of the link, in world axes."""
        x = direction(self.angle)
        return local[0] * x + local[1] * turned(x)

    def point(self, local: Array) -> Array:
        return self.origin + self.arm(local)

    def point_acceleration(self, local: Array) -> Array:
        arm = self.arm(local)
        tangential = self.acceleration[:, None] * turned(arm)
        return self.origin_acceleration + tangential - (self.speed**2)[:, None] * arm


class FreeBodies:
    """The free-body diagrams of all links of a mechanism, and their equations.

    Every unknown is what a joint's first link (`parent`) exerts on its second (`child`); the
    reaction acts on the first link with the opposite sign. A link that was not added is the
    frame.
    """

    def __init__(self, samples: int) -> None:
        self.samples = samples
        self._centres: dict[str, Array] = {}
        self._known: dict[str, Array] = {}
        self._columns: list[tuple[str, dict[str, Array]]] = []

    def link(self, name: str, link: PlanarLink, motion: Moving, gravity: float) -> None:
        """Add m a = Σ F and I α = Σ M about the centre of mass, under gravity along -y."""
        force = link.mass * (motion.point_acceleration(link.centre) + np.array([0.0, gravity]))
        moment = link.inertia * motion.acceleration
        self._centres[name] = motion.point(link.centre)
        self._known[name] = np.concatenate([force, moment[:, None]], axis=1)

    def force(self, joint: str, parent: str, child: str, at: Array, along: Array) -> None:
        """Add an unknown force along a direction, through a point."""
        along = np.broadcast_to(along, (self.samples, 2))
        self._unknown(joint, parent, child, along, at, np.zeros(self.samples))

    def hinge(self, joint: str, parent: str, child: str, at: Array) -> None:
        """Add both unknown components of a hinge force: `joint.x` and `joint.y`."""
        self.force(f"{joint}.x", parent, child, at, np.array([1.0, 0.0]))
        self.force(f"{joint}.y", parent, child, at, np.array([0.0, 1.0]))

    def couple(self, joint: str, parent: str, child: str) -> None:
        """Add an unknown couple: a drive torque, or what keeps a slider from turning."""
        zero = np.zeros((self.samples, 2))
        self._unknown(joint, parent, child, zero, zero, np.ones(self.samples))

    def load(self, parent: str, child: str, at: Array, force: Array, couple: float = 0.0) -> None:
        """Add a known effort between two links."""
        force = np.broadcast_to(force, (self.samples, 2))
        for name, sign in ((child, 1.0), (parent, -1.0)):
            if name in self._known:
                moment = _cross(at - self._centres[name], force) + couple
                effect = np.concatenate([force, moment[:, None]], axis=1)
                self._known[name] = self._known[name] - sign * effect

    def solve(self) -> dict[str, Array]:
        """Return every unknown `(N,)` by name."""
        names = list(self._known)
        matrix = np.zeros((self.samples, 3 * len(names), len(self._columns)))
        for column, (_, effects) in enumerate(self._columns):
            for name, effect in effects.items():
                row = 3 * names.index(name)
                matrix[:, row : row + 3, column] = effect
        known = np.concatenate([self._known[name] for name in names], axis=1)
        solution = np.linalg.solve(matrix, known[:, :, None])[:, :, 0]
        return {name: solution[:, column] for column, (name, _) in enumerate(self._columns)}

    def _unknown(
        self, joint: str, parent: str, child: str, force: Array, at: Array, couple: Array
    ) -> None:
        effects = {}
        for name, sign in ((child, 1.0), (parent, -1.0)):
            if name in self._known:
                moment = _cross(at - self._centres[name], force) + couple
                effects[name] = sign * np.concatenate([force, moment[:, None]], axis=1)
        self._columns.append((joint, effects))
