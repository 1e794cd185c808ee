"""Screws: how frames move, and what moves them, by spatial vectors about `Frames.corner`.

A screw is a pair of vectors in world axes. A twist is the velocity of a body's point that lies at
the corner [m/s] and the angular velocity [rad/s]; a wrench is the force [N] and its moment about
the corner [N·m] (Featherstone 2008, chapter 2). Both add up along chains as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from ..mechanism.frames import Frames
from ..tape import Scalar
from .placing import Frame, Placing, constant
from .vectors import ZERO, Vector, add, combine, cross, dot, scale, subtract

Screw: TypeAlias = tuple[Vector, Vector]

NOTHING: Screw = (ZERO, ZERO)


def plus(a: Screw, b: Screw) -> Screw:
    """Return the sum of two screws."""
    if a is NOTHING:
        return b
    return a if b is NOTHING else (add(a[0], b[0]), add(a[1], b[1]))


def minus(a: Screw, b: Screw) -> Screw:
    """Return the difference of two screws."""
    return subtract(a[0], b[0]), subtract(a[1], b[1])


def by(a: Screw, factor: Scalar) -> Screw:
    """Return a screw times a scalar."""
    if type(factor) is float and factor == 0.0:
        return NOTHING
    return scale(a[0], factor), scale(a[1], factor)


def total_of(screws: Sequence[Screw]) -> Screw:
    """Return the sum of screws."""
    if len(screws) == 1:
        return screws[0]
    ones = [1.0] * len(screws)
    linear, angular = [screw[0] for screw in screws], [screw[1] for screw in screws]
    return combine(linear, ones), combine(angular, ones)


def velocity_at(point: Vector, twist: Screw) -> Vector:
    """Return the velocity of the point of a body that is there, and likewise of rates of twists."""
    velocity, spin = twist
    return add(velocity, cross(spin, point))


def change(twist: Screw, carried: Screw) -> Screw:
    """Return the rate of a twist that is carried by a body with another one: their product v × m.

    Of its linear part, it is ω × linear + v × angular, of the angular one, ω × angular
    (Featherstone 2008, chapter 2).
    """
    (velocity, spin), (linear, angular) = twist, carried
    return add(cross(spin, linear), cross(velocity, angular)), cross(spin, angular)


def about(point: Vector, wrench: Screw) -> Screw:
    """Return a wrench with its moment about another point than the corner."""
    force, moment = wrench
    return force, subtract(moment, cross(point, force))


def in_world(wrench: Screw, frame: Frame) -> Screw:
    """Return a wrench in the axes of a frame, about its origin, as one about the corner.

    Featherstone (2008), chapter 2.
    """
    axes, origin = frame
    force = combine(axes, wrench[0])
    return force, add(combine(axes, wrench[1]), cross(origin, force))


def power(wrench: Screw, twist: Screw) -> Scalar:
    """Return the power of a wrench on a body with a twist; Featherstone (2008), chapter 2."""
    return dot(wrench[0], twist[0]) + dot(wrench[1], twist[1])


class Screws:
    """The rates of a description's joints, and the screws along which they move what follows.

    There are K rates of M elementary motions: one per turn or slide, three per ball.

    Attributes:
        frames: of the description.
        placing: where they are.
        owners: `(K,)` per rate, the index of its elementary motion.
        rates: `(K,)` its index among the joint velocities.
        sliding: `(K,)` whether it is a slide.
        slides: the joint velocities that are.
        axes: `(K,)` its direction in the frame of its motion.
    """

    def __init__(self, frames: Frames) -> None:
        self.frames, self.placing = frames, Placing(frames)
        self.owners: list[int] = []
        self.rates: list[int] = []
        self.axes: list[Vector] = []
        self._rows: list[range] = []
        for index, motion in enumerate(frames.motions):
            first = len(self.rates)
            self.owners += [index] * motion.size
            self.rates += range(motion.rate, motion.rate + motion.size)
            is_ball = motion.kind == "ball"
            x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
            self.axes += [x, y, z] if is_ball else [constant(motion.axis)]
            self._rows.append(range(first, len(self.rates)))
        self.sliding = [frames.motions[owner].kind == "slide" for owner in self.owners]
        rates = zip(self.rates, self.sliding, strict=True)
        self.slides = [rate for rate, is_slide in rates if is_slide]

    def units(self, placed: Sequence[Frame]) -> list[Screw]:
        """Return the twist per unit of each rate: of a turn (p × n, n), of a slide (n, 0).

        Args:
            placed: frames of all motions.
        """
        units = []
        for owner, axis, slides in zip(self.owners, self.axes, self.sliding, strict=True):
            frame = placed[owner]
            along = combine(frame.axes, axis)
            units.append((along, ZERO) if slides else (cross(frame.origin, along), along))
        return units

    def relative(self, units: Sequence[Screw], rates: Sequence[Scalar]) -> list[Screw]:
        """Return per motion the twist of its frame relative to the one before: S q̇.

        Args:
            units: see `units`.
            rates: all joint velocities.
        """
        found = []
        for rows in self._rows:
            twists = [by(units[row], rates[self.rates[row]]) for row in rows]
            found.append(total_of(twists))
        return found

    def absolute(self, relative: Sequence[Screw]) -> list[Screw]:
        """Return the sums from the world to each motion; Featherstone (2008), chapter 5."""
        sums: list[Screw] = []
        for motion, own in zip(self.frames.motions, relative, strict=True):
            sums.append(plus(sums[motion.before], own) if motion.before >= 0 else own)
        return sums

    def changes(
        self,
        units: Sequence[Screw],
        accelerations: Sequence[Scalar],
        relative: Sequence[Screw],
        velocities: Sequence[Screw],
    ) -> list[Screw]:
        """Return what each motion adds to the rate of the twist before it: S q̈ + Ṡ q̇.

        These are rates of twists at the corner, which is fixed in the world: not accelerations of
        the bodies' points that pass there.
        """
        found = []
        added = self.relative(units, accelerations)
        for motion, own, rate in zip(self.frames.motions, relative, added, strict=True):
            if motion.before >= 0:
                rate = plus(rate, change(velocities[motion.before], own))
            found.append(rate)
        return found
