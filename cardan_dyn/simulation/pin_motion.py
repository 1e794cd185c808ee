"""Pin motion: where the pin of a contact is in its bush, and what acts on both, state by state."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array
from ..elements.pin_contact import PinContact
from ..mechanism.mechanism import Mechanism


class PinPlace(NamedTuple):
    """Where a pin is in its bush.

    Attributes:
        depth: by which it has entered the wall; negative in the clearance [m].
        growth: rate of the depth [m/s].
        away: `(3,)` unit vector from the bush's axis to the pin, in world axes.
        along: `(3,)` unit vector along the wall, in the sense of a turn about the axis.
        slide: speed of the pin's surface along the wall [m/s].
        touch: `(3,)` where it touches, in world axes [m].
    """

    depth: float
    growth: float
    away: Array
    along: Array
    slide: float
    touch: Array


class PinMotion:
    """The pin of a contact in a mechanism.

    `ElementForces` computes the same for many states at once.

    Attributes:
        element: the contact.
    """

    def __init__(self, mechanism: Mechanism, element: PinContact) -> None:
        """Find what moves the pin and the bush.

        Args:
            mechanism: the mechanism.
            element: checked against it.
        """
        self.element = element
        self._bush, frame = mechanism.links[element.link_a]
        self._centre = np.asarray(frame.act(element.point_a))
        self._axis = np.asarray(frame.rotation @ element.axis_a)
        self._pin, frame = mechanism.links[element.link_b]
        self._point = np.asarray(frame.act(element.point_b))

    @property
    def joints(self) -> tuple[int, int]:
        """Indices of the joints in the model that move bush and pin, 0 for the world."""
        return self._bush, self._pin

    def place(self, data: Any) -> PinPlace:
        """Return where the pin is; forward kinematics and velocities have been computed."""
        element = self.element
        bush, pin = data.oMi[self._bush], data.oMi[self._pin]
        axis = bush.rotation @ self._axis
        at = pin.act(self._point)
        span = at - bush.act(self._centre)
        span -= axis * float(axis @ span)
        # As twists about the world's origin, both act at the same place.
        twist = pin.act(data.v[self._pin]) - bush.act(data.v[self._bush])
        spin = twist.angular
        seen = twist.linear + _cross(spin, at)
        distance = math.sqrt(float(span @ span))
        away = span / distance if distance > 0.0 else span
        along = _cross(axis, away)
        slide = float(along @ seen) + element.radius * float(axis @ spin)
        touch = at + element.radius * away
        depth = distance - 0.5 * element.clearance
        return PinPlace(depth, float(away @ seen), away, along, slide, touch)

    def add(self, efforts: Array, model: Any, data: Any, time: float) -> None:
        """Add what the contact exerts to efforts `(nv,)`.

        Placements, velocities and Jacobians of the state have been computed.
        """
        element = self.element
        if not element.acts_at(time):
            return
        place = self.place(data)
        pressure = element.pressure_at(place.depth, place.growth, time)
        force = -pressure * place.away
        if element.friction:
            slip = place.slide / math.hypot(place.slide, element.transition)
            force -= (element.friction * pressure * slip) * place.along
        wrench = np.concatenate([force, _cross(place.touch, force)])
        for joint, sign in ((self._bush, -1.0), (self._pin, 1.0)):
            if joint:
                frame = pinocchio.ReferenceFrame.WORLD
                efforts += wrench @ pinocchio.getJointJacobian(model, data, joint, frame) * sign


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors; NumPy's takes ten times as long."""
    x, y, z = a.tolist()
    u, v, w = b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])
