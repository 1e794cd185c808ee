"""Placements: where the bodies of a tree are, along what their coordinates move them, and how fast.

Vectors are in the tree's axes, points from its origin; those of a motion are in axes of bodies, in
which levers, centres of mass and most axes of joints are numbers, many of them zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..tape import cos, sin, sqrt
from .bodies import Body, End, Tree
from .vectors import (
    UNTURNED,
    ZERO,
    Rotation,
    Scalar,
    Vector,
    about,
    about_axis,
    added,
    cross,
    of_quaternion,
    product,
    seen,
    times,
    turned,
)


class Placed(NamedTuple):
    """Where the bodies are.

    Attributes:
        rotations, points: of the bodies' frames.
        directions: velocity coordinate to the unit vector along or about which it moves.
        positions: likewise to the angle or the slide of what is no ball.
        turns, levers: of the bodies' frames, from those of the bodies that carry them.
    """

    rotations: list[Rotation]
    points: list[Vector]
    directions: dict[int, Vector]
    positions: dict[int, Scalar]
    turns: list[Rotation]
    levers: list[Vector]

    def end(self, end: End) -> tuple[Rotation, Vector]:
        """Return where the end of a loop is: its rotation, and its point from its body's."""
        if end.body < 0:
            return end.rotation, end.translation
        rotation = self.rotations[end.body]
        whole = rotation if end.rotation is UNTURNED else product(rotation, end.rotation)
        return whole, turned(rotation, end.translation)

    def at_zero(self, tree: Tree, body: int) -> Rotation:
        """Return the rotation that a body's frame has while its joint is at zero."""
        parent, rotation = tree.bodies[body].parent, tree.bodies[body].rotation
        return rotation if parent < 0 else product(self.rotations[parent], rotation)

    def point(self, body: int) -> Vector:
        """Return where a body's frame is; the origin for the world."""
        return ZERO if body < 0 else self.points[body]

    def in_tree(self, body: int, vector: Vector) -> Vector:
        """Return a vector in the axes of a body, or of the world, in those of the tree."""
        return vector if body < 0 else turned(self.rotations[body], vector)

    def in_body(self, body: int, vector: Vector) -> Vector:
        """Return a vector in the tree's axes in those of a body, or of the world."""
        return vector if body < 0 else seen(self.rotations[body], vector)


def placed(tree: Tree, x: Mapping[int, Scalar]) -> Placed:
    """Place all bodies: R = R_p R_0 R(q), p = p_p + R_p p_0 (Featherstone 2008, chapter 4).

    Args:
        tree: the bodies.
        x: column of coordinate rows to its value: angles [rad], slides in units of the length, four
            numbers of a quaternion (x, y, z, w) of unit length but for rounding.
    """
    rotations: list[Rotation] = []
    points: list[Vector] = []
    directions: dict[int, Vector] = {}
    positions: dict[int, Scalar] = {}
    turns: list[Rotation] = []
    levers: list[Vector] = []
    for body in tree.bodies:
        carrier, lever = UNTURNED, body.translation
        point, rotation, turn = lever, body.rotation, UNTURNED
        if body.parent >= 0:
            carrier = rotations[body.parent]
            point = added(points[body.parent], turned(carrier, body.translation))
            rotation = carrier if rotation is UNTURNED else product(carrier, rotation)
        if body.kind == "spherical":
            turn = of_quaternion([x[body.column + k] for k in range(4)])
            rotation = product(rotation, turn)
            directions.update(zip(body.rates, rotation, strict=True))
        else:
            (rate,) = body.rates
            own, value = body.axis, x[body.column]
            axis = rotation[own] if isinstance(own, int) else turned(rotation, own)
            directions[rate], positions[rate] = axis, value
            if body.kind == "prismatic":
                point = added(point, times(axis, value))
                lever = added(lever, times(turned(body.rotation, *body.directions), value))
            elif isinstance(own, int):
                turn = about_axis(UNTURNED, own, sin(value), cos(value))
                rotation = about_axis(rotation, own, sin(value), cos(value))
            else:
                turn = about(own, sin(value), cos(value))
                rotation = product(rotation, turn)
        rotations.append(rotation)
        points.append(point)
        turns.append(turn if body.rotation is UNTURNED else product(body.rotation, turn))
        levers.append(lever)
    return Placed(rotations, points, directions, positions, turns, levers)


class Motion(NamedTuple):
    """How the bodies move, each in its own axes.

    Attributes:
        spins, spin_rates: angular velocities and accelerations.
        accelerations: of the bodies' frames.
    """

    spins: list[Vector]
    spin_rates: list[Vector]
    accelerations: list[Vector]

    def spin(self, body: int) -> Vector:
        """Return the angular velocity of a body; none of the world."""
        return ZERO if body < 0 else self.spins[body]

    def spin_rate(self, body: int) -> Vector:
        """Return its angular acceleration."""
        return ZERO if body < 0 else self.spin_rates[body]

    def at(self, body: int, lever: Vector) -> Vector:
        """Return the acceleration of a point of a body, from its frame: a + α × r + ω × (ω × r)."""
        if body < 0:
            return ZERO
        spin = self.spins[body]
        turning = cross(self.spin_rates[body], lever)
        return added(self.accelerations[body], added(turning, cross(spin, cross(spin, lever))))


def moving(
    tree: Tree, at: Placed, v: Mapping[int, Scalar], a: Mapping[int, Scalar], base: Vector
) -> Motion:
    """Return how the bodies move (Featherstone 2008, chapter 5).

    Args:
        tree: the bodies.
        at: where they are.
        v: velocity coordinate to joint velocity; what is missing is zero.
        a: likewise to joint acceleration.
        base: acceleration of the world, which is that of free fall with its sign changed where
            weight is to be counted.
    """
    result = Motion([], [], [])
    for index, (body, turn) in enumerate(zip(tree.bodies, at.turns, strict=True)):
        parent, acceleration = body.parent, base
        if parent >= 0:
            acceleration = result.at(parent, at.levers[index])
        spin, spin_rate, acceleration = (
            seen(turn, of) for of in (result.spin(parent), result.spin_rate(parent), acceleration)
        )
        relative, change = ZERO, ZERO
        for rate, axis in zip(body.rates, body.directions, strict=True):
            relative = added(relative, times(axis, v.get(rate, 0.0)))
            change = added(change, times(axis, a.get(rate, 0.0)))
        turning = cross(spin, relative)
        if body.kind == "prismatic":
            # Coriolis: 2 ω × v.
            acceleration = added(acceleration, added(change, times(turning, 2.0)))
        else:
            spin_rate = added(spin_rate, added(change, turning))
            spin = added(spin, relative)
        for own, of_body in zip(result, (spin, spin_rate, acceleration), strict=True):
            own.append(of_body)
    return result


def stepped(body: Body, x: Mapping[int, Scalar], step: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Return the coordinates of a body after a small step of its velocity coordinates."""
    changes = moved(body, x, step)
    result = {column: x[column] + change for column, change in changes.items()}
    return normalised(body, result)


def moved(body: Body, x: Mapping[int, Scalar], v: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Return the rates of the coordinates of a body: of a quaternion q (ω/2, 0)."""
    if body.kind != "spherical":
        (rate,) = body.rates
        return {body.column: v[rate]}
    a, b, c, d = (x[column] for column in body.columns)
    p, q, r = (0.5 * v[rate] for rate in body.rates)
    rates: Sequence[Scalar] = (
        d * p + b * r - c * q,
        d * q + c * p - a * r,
        d * r + a * q - b * p,
        -(a * p) - b * q - c * r,
    )
    return dict(zip(body.columns, rates, strict=True))


def normalised(body: Body, x: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Return the coordinates of a body, a quaternion of unit length."""
    values = [x[column] for column in body.columns]
    if body.kind == "spherical":
        scale = 1.0 / sqrt(sum((value * value for value in values), 0.0))
        values = [value * scale for value in values]
    return dict(zip(body.columns, values, strict=True))
