"""Momentum: weights of the bodies, and the rates at which their momentum changes."""

from __future__ import annotations

from typing import NamedTuple

from ..mechanism.frames import RigidBody
from ..tape import Scalar
from .placing import Axes, Frame, constant
from .screws import Screw, velocity_at
from .vectors import Vector, add, combine, components, cross, dot, norm, scale, subtract


class Massive(NamedTuple):
    """A body that has mass.

    Attributes:
        mass: [kg].
        centre: in the frame of the motion that carries it [m].
        inertia: columns of the matrix about the centre, in that frame [kg·m²].
    """

    mass: float
    centre: Vector
    inertia: Axes

    @staticmethod
    def of(body: RigidBody) -> Massive:
        """Return the same in plain numbers."""
        x, y, z = map(constant, body.inertia.T)
        return Massive(body.mass, constant(body.centre), (x, y, z))

    def inertial_wrench(
        self, frame: Frame, gravity: Vector, motion: tuple[Screw, Screw] | None
    ) -> Screw:
        """Return its weight less the rate of its momentum, with which joints and loads balance.

        By Newton, the force is m (g - a) with the acceleration a of the centre; by Euler, the
        moment about the centre is -(I α + ω × I ω) in the axes of the body, in which I is constant
        (Murray, Li, Sastry 1994, chapter 4).

        Args:
            frame: that carries it.
            gravity: g [m/s²].
            motion: twist of this frame, and its rate, see `Screws.changes`; None at rest.

        Returns:
            A wrench about the corner.
        """
        centre = add(frame.origin, combine(frame.axes, self.centre))
        if motion is None:
            force = scale(gravity, self.mass)
            return force, cross(centre, force)
        twist, rate = motion
        transport = cross(twist[1], velocity_at(centre, twist))
        acceleration = add(velocity_at(centre, rate), transport)
        force = scale(subtract(gravity, acceleration), self.mass)
        spin, spin_rate = components(frame.axes, twist[1]), components(frame.axes, rate[1])
        momentum = combine(self.inertia, spin)
        momentum_rate = add(combine(self.inertia, spin_rate), cross(spin, momentum))
        return force, subtract(cross(centre, force), combine(frame.axes, momentum_rate))

    def turning(self, motion: tuple[Screw, Screw], length: float) -> Scalar:
        """Return the size of the terms that momentum rates are the sum of [N·m].

        Args:
            motion: see `inertial_wrench`.
            length: characteristic length [m].
        """
        (_, spin), (_, spin_rate) = motion
        return (norm(spin_rate) + dot(spin, spin)) * (self.mass * length**2)
