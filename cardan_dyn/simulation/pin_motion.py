"""Pin motion: where the pin of a contact is in its bush, and what acts on both, state by state.

A simulation asks for one state after the other, of which a touch takes hundreds: vectors are three
numbers here, of which NumPy's operations would take five times as long.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array
from ..elements.pin_contact import PinContact
from ..mechanism.mechanism import Mechanism

Vector = tuple[float, float, float]


class PinPlace(NamedTuple):
    """Where a pin is in its bush.

    Attributes:
        depth: by which it has entered the wall; negative in the clearance [m].
        growth: rate of the depth [m/s].
        away: unit vector from the bush's axis to the pin, in world axes.
        along: unit vector along the wall, in the sense of a turn about the axis.
        slide: speed of the pin's surface along the wall [m/s].
        touch: where it touches, in world axes [m].
    """

    depth: float
    growth: float
    away: Vector
    along: Vector
    slide: float
    touch: Vector


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
        self._centre = _vector(frame.act(element.point_a))
        self._axis = _vector(frame.rotation @ element.axis_a)
        self._pin, frame = mechanism.links[element.link_b]
        self._point = _vector(frame.act(element.point_b))
        self._radius, self._play = float(element.radius), 0.5 * float(element.clearance)

    @property
    def joints(self) -> tuple[int, int]:
        """Indices of the joints in the model that move bush and pin, 0 for the world."""
        return self._bush, self._pin

    def place(self, data: Any) -> PinPlace:
        """Return where the pin is; forward kinematics and velocities have been computed."""
        axis, centre, at = self._axis, self._centre, self._point
        seen = spin = (0.0, 0.0, 0.0)
        if self._pin:
            turned, origin, moving, spin = _frame(data, self._pin)
            arm = _turned(turned, at)
            at = _sum(origin, arm)
            seen = _sum(moving, _cross(spin, arm))
        if self._bush:
            turned, origin, (vx, vy, vz), (wx, wy, wz) = _frame(data, self._bush)
            axis = _turned(turned, axis)
            centre = _sum(origin, _turned(turned, centre))
            # Both as they move where the pin is.
            cx, cy, cz = _cross((wx, wy, wz), _difference(at, origin))
            seen = seen[0] - vx - cx, seen[1] - vy - cy, seen[2] - vz - cz
            spin = spin[0] - wx, spin[1] - wy, spin[2] - wz
        span = _difference(at, centre)
        off = _dot(axis, span)
        x, y, z = span[0] - off * axis[0], span[1] - off * axis[1], span[2] - off * axis[2]
        distance = math.sqrt(x * x + y * y + z * z)
        away = (x / distance, y / distance, z / distance) if distance > 0.0 else (x, y, z)
        along, radius = _cross(axis, away), self._radius
        slide = _dot(along, seen) + radius * _dot(axis, spin)
        touch = at[0] + radius * away[0], at[1] + radius * away[1], at[2] + radius * away[2]
        return PinPlace(distance - self._play, _dot(away, seen), away, along, slide, touch)

    def add(self, efforts: Array, model: Any, data: Any, time: float) -> None:
        """Add what the contact exerts to efforts `(nv,)`.

        Placements, velocities and Jacobians of the state have been computed.
        """
        element = self.element
        if not element.acts_at(time):
            return
        place = self.place(data)
        pressure = element.pressure_at(place.depth, place.growth, time)
        (x, y, z), (u, v, w), rubbing = place.away, place.along, 0.0
        if element.friction:
            slip = place.slide / math.hypot(place.slide, element.transition)
            rubbing = element.friction * pressure * slip
        force = (
            -pressure * x - rubbing * u,
            -pressure * y - rubbing * v,
            -pressure * z - rubbing * w,
        )
        wrench = np.array([*force, *_cross(place.touch, force)])
        frame = pinocchio.ReferenceFrame.WORLD
        for joint, sign in ((self._bush, -1.0), (self._pin, 1.0)):
            if joint:
                jacobian = pinocchio.getJointJacobian(model, data, joint, frame)
                efforts += (sign * wrench).dot(jacobian)


_Matrix = tuple[Vector, Vector, Vector]


def _frame(data: Any, joint: int) -> tuple[_Matrix, Vector, Vector, Vector]:
    """Return rotation and origin of a body, velocity of its origin and spin, in world axes."""
    first, second, third, _ = data.oMi[joint].homogeneous.tolist()
    turned = first[:3], second[:3], third[:3]
    moving = data.v[joint].vector.tolist()
    origin = first[3], second[3], third[3]
    return turned, origin, _turned(turned, moving[:3]), _turned(turned, moving[3:])


def _vector(values: Array) -> Vector:
    x, y, z = np.asarray(values).tolist()
    return x, y, z


def _turned(matrix: _Matrix, vector: Vector) -> Vector:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    x, y, z = vector
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _difference(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    x, y, z = a
    u, v, w = b
    return y * w - z * v, z * u - x * w, x * v - y * u
