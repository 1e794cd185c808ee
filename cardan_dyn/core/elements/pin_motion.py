"""Pin motion: where the pin of a contact is in its bush, and what acts on both, state by state.

A simulation asks for one state after the other, of which a touch takes hundreds: vectors are three
numbers here, of which NumPy's operations would take five times as long.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...kit.arrays import Array

if TYPE_CHECKING:
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
    """A pin and its bush in a mechanism.

    Attributes:
        bush, pin: indices of the bodies that move them, 0 for the world.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        bush: tuple[str, Array, Array],
        pin: tuple[str, Array],
        radius: float,
        clearance: float,
    ) -> None:
        """Find what moves the pin and the bush.

        Args:
            mechanism: the mechanism.
            bush: its link, the centre there `(3,)` [m] and its axis `(3,)`.
            pin: its link, and its point there `(3,)` [m].
            radius: of the wall [m].
            clearance: in the diameter [m].
        """
        link, centre, axis = bush
        self.bush, frame = mechanism.link_frames[link]
        self._centre = _vector(frame.act(centre))
        self._axis = _vector(frame.rotation @ axis)
        link, point = pin
        self.pin, frame = mechanism.link_frames[link]
        self._point = _vector(frame.act(point))
        self._radius, self._play = float(radius), 0.5 * float(clearance)

    def place(self, data: Any) -> PinPlace:
        """Return where the pin is; forward kinematics and velocities have been computed."""
        axis, centre, at = self._axis, self._centre, self._point
        seen = spin = (0.0, 0.0, 0.0)
        if self.pin:
            turned, origin, moving, spin = _frame(data, self.pin)
            arm = _turned(turned, at)
            at = _sum(origin, arm)
            seen = _sum(moving, cross(spin, arm))
        if self.bush:
            turned, origin, (vx, vy, vz), (wx, wy, wz) = _frame(data, self.bush)
            axis = _turned(turned, axis)
            centre = _sum(origin, _turned(turned, centre))
            # Both as they move where the pin is.
            cx, cy, cz = cross((wx, wy, wz), _difference(at, origin))
            seen = seen[0] - vx - cx, seen[1] - vy - cy, seen[2] - vz - cz
            spin = spin[0] - wx, spin[1] - wy, spin[2] - wz
        span = _difference(at, centre)
        off = _dot(axis, span)
        x, y, z = span[0] - off * axis[0], span[1] - off * axis[1], span[2] - off * axis[2]
        distance = math.sqrt(x * x + y * y + z * z)
        away = (x / distance, y / distance, z / distance) if distance > 0.0 else (x, y, z)
        along, radius = cross(axis, away), self._radius
        slide = _dot(along, seen) + radius * _dot(axis, spin)
        touch = at[0] + radius * away[0], at[1] + radius * away[1], at[2] + radius * away[2]
        return PinPlace(distance - self._play, _dot(away, seen), away, along, slide, touch)


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


def cross(a: Vector, b: Vector) -> Vector:
    """Return the cross product of two vectors."""
    x, y, z = a
    u, v, w = b
    return y * w - z * v, z * u - x * w, x * v - y * u
