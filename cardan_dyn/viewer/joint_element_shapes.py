"""Joint element shapes of the viewer: springs, dampers, brakes and efforts about joints' axes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..elements.joint_elements import Actuator, JointElement, JointFriction, JointSpring
from ..elements.link_motions import LinkMotion
from ..mechanism.joints import Part
from . import element_forms
from . import shapes as forms
from .commands import Color, Drawing, Pose, mesh

SPRING = Color.of("#d17b00", opacity=0.9, on_top=True, layer=2)
DAMPER = Color.of("#827717", opacity=0.75, on_top=True, layer=2)
FRICTION = Color.of("#546e7a", opacity=0.9, on_top=True, layer=2)
SHOES = Color.of("#263238", opacity=0.9, on_top=True, layer=3)
ACTUATOR = Color.of("#e53935", on_top=True, layer=4)

# Lengths in the drawing are fractions of the radius of the scene, chosen for legibility.
_SPIRAL_RADIUS, _COIL_RADIUS, _WIRE_RADIUS = 0.12, 0.03, 0.005
_PIN_RADIUS, _PIN_LENGTH = 0.01, 0.05
"""Radius and half the length of the pin on the parent at which the spiral ends when at rest."""
_DRUM_RADIUS, _DASHPOT_RADIUS, _BRAKE_RADIUS, _PAD_SIZE = 0.1, 0.02, 0.12, 0.05
_ROD_RADIUS = 0.006
"""Radius of the rod along which the pads of a slide rub."""
_ROOM = 0.25
"""Least length of a coil along a slide."""
ARC_RADIUS, ARROW_LENGTH, _ARROW_RADIUS = 0.26, 0.42, 0.028
"""Radius of the arc and length of the arrow of the greatest effort, and the radius of an arrow's
shaft as a fraction of its length."""
_LEAST_SCALE = 1e-5
"""Least size of an arrow, as a fraction of that radius; a scale of zero has no inverse."""


class Axis(NamedTuple):
    """Where a coordinate's axis is at the samples that are shown.

    Attributes:
        part: the elementary part that turns about it or slides along it.
        child: motion of the body that the part moves.
        x: coordinate `(n,)` [rad or m].
        v: its rate `(n,)` [rad/s or m/s].
        time: `(n,)` [s].
        shift: `(3,)` from the origin of the joint to the drawing, in the joint's axes [m].
        radius: of the scene [m].
    """

    part: Part
    child: LinkMotion
    x: Array
    v: Array
    time: Array
    shift: Array
    radius: float

    @property
    def slides(self) -> bool:
        """Whether the coordinate is a slide."""
        return self.part.kind == "prismatic"

    @property
    def direction(self) -> Array:
        """Unit axis in world axes `(n, 3)`."""
        return np.broadcast_to(self.child.rotation @ self.part.axis, (len(self.x), 3))

    @property
    def origin(self) -> Array:
        """Point of the axis at which the drawing stands, moved by the part `(n, 3)` [m]."""
        at = self.child.position + self.child.rotation @ self.shift
        return np.broadcast_to(at, (len(self.x), 3))

    def quaternion(self, turn: Array | float = 0.0) -> Array:
        """Return the turns `(n, 4)` from a drawing about z to the axis.

        Args:
            turn: `(n,)` by which the drawing is turned about the axis against the child [rad].
        """
        z = self.part.axis
        x = across(z)
        basis = np.stack([x, np.cross(z, x), z], axis=1)
        angle = np.broadcast_to(np.asarray(turn, dtype=float), self.x.shape)
        cosine, sine, none = np.cos(angle), np.sin(angle), np.zeros_like(angle)
        rows = [[cosine, -sine, none], [sine, cosine, none], [none, none, none + 1.0]]
        about = np.array(rows).transpose(2, 0, 1)
        return forms.quaternions(self.child.rotation @ basis @ about)


def across(axis: Array) -> Array:
    """Return a unit vector `(3,)` across another one."""
    vector = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    return np.asarray(vector / np.linalg.norm(vector))


class JointDrawing:
    """Draws the elements along coordinates.

    Args:
        drawing: what they are drawn on.
        greatest: greatest effort of the actuators at slides and at turns [N, N·m]; the arrows of
            both have their own scale.

    Attributes:
        legend: CSS colour to meaning of what was drawn.
    """

    def __init__(self, drawing: Drawing, greatest: dict[bool, float]) -> None:
        self._drawing, self._greatest = drawing, greatest
        self.legend: dict[str, str] = {}

    def draw(self, path: str, element: JointElement, axis: Axis, label: str) -> list[Array]:
        """Draw an element.

        Args:
            path: of its node.
            element: the element.
            axis: of its coordinate.
            label: how messages call the element.

        Returns:
            Points `(n, 3)` that the camera has to see [m].

        Raises:
            ArgumentError: an actuator's function fails.
        """
        if isinstance(element, JointSpring):
            if element.stiffness > 0.0 or element.damping == 0.0:
                self.legend[SPRING.css] = "spring"
                return (self._coil if axis.slides else self._spiral)(path, element, axis)
            self.legend[DAMPER.css] = "damper"
            return self._damper(path, element, axis)
        if isinstance(element, JointFriction):
            self.legend[FRICTION.css] = "dry friction"
            return self._brake(path, axis)
        if isinstance(element, Actuator):
            effort = element.force(axis.x, axis.v, axis.time, label).effort
            return self._effort(path, effort, axis)
        return []

    def _spiral(self, path: str, element: JointSpring, axis: Axis) -> list[Array]:
        """Draw a spring about an axis: a spiral on the child, whose end meets a pin at rest."""
        size, wire = _SPIRAL_RADIUS * axis.radius, _WIRE_RADIUS * axis.radius
        origin = axis.origin
        self._drawing.place(f"{path}/spiral", Pose.of(origin, axis.quaternion()))
        self._drawing.add(
            f"{path}/spiral", mesh(forms.path(element_forms.spiral(size), wire)), SPRING
        )
        pin = forms.rod(
            _PIN_RADIUS * axis.radius, -_PIN_LENGTH * axis.radius, _PIN_LENGTH * axis.radius
        )
        outside = np.eye(4)
        outside[0, 3] = size
        self._drawing.place(f"{path}/rest", Pose.of(origin, axis.quaternion(element.rest - axis.x)))
        self._drawing.add(f"{path}/rest/pin", mesh(pin), SPRING, outside)
        return [origin]

    def _coil(self, path: str, element: JointSpring, axis: Axis) -> list[Array]:
        """Draw a spring along an axis, as a coil that is shortest where it is pressed most."""
        wire = forms.path(
            element_forms.coil(_COIL_RADIUS * axis.radius), _WIRE_RADIUS * axis.radius
        )
        return self._stretched(path, wire, SPRING, element.rest, axis)

    def _damper(self, path: str, element: JointSpring, axis: Axis) -> list[Array]:
        """Draw a damper without a spring: a drum about an axis, or a dashpot along it."""
        if axis.slides:
            dashpot = element_forms.dashpot(_DASHPOT_RADIUS * axis.radius)
            return self._stretched(path, dashpot, DAMPER, element.rest, axis)
        self._drawing.place(path, Pose.of(axis.origin, axis.quaternion()))
        self._drawing.add(path, mesh(element_forms.drum(_DRUM_RADIUS * axis.radius)), DAMPER)
        return [axis.origin]

    def _stretched(
        self, path: str, surface: tuple[Array, Array], color: Color, rest: float, axis: Axis
    ) -> list[Array]:
        """Draw a form of length 1 between the child and a point of the parent behind it."""
        free = float(np.max(rest - axis.x)) + _ROOM * axis.radius
        length = axis.x - rest + free
        start = axis.origin - length[:, None] * axis.direction
        scale = np.ones((len(length), 3))
        scale[:, 2] = length
        self._drawing.place(path, Pose.of(start, axis.quaternion(), scale))
        self._drawing.add(path, mesh(surface), color)
        return [start, axis.origin]

    def _brake(self, path: str, axis: Axis) -> list[Array]:
        """Draw friction: a ring that turns between shoes, or pads that slide along a rod."""
        origin, radius = axis.origin, axis.radius
        if axis.slides:
            low, high = float(np.min(axis.x)), float(np.max(axis.x))
            margin = 2.0 * _PAD_SIZE * radius
            rod = forms.rod(_ROD_RADIUS * radius, low - margin, high + margin)
            start = origin - axis.x[:, None] * axis.direction
            self._drawing.place(f"{path}/rod", Pose.of(start, axis.quaternion()))
            self._drawing.add(f"{path}/rod", mesh(rod), FRICTION)
            self._drawing.place(f"{path}/pads", Pose.of(origin, axis.quaternion()))
            self._drawing.add(f"{path}/pads", mesh(element_forms.pads(_PAD_SIZE * radius)), SHOES)
            return [start + (end * axis.direction) for end in (low - margin, high + margin)]
        size = _BRAKE_RADIUS * radius
        self._drawing.place(f"{path}/ring", Pose.of(origin, axis.quaternion()))
        self._drawing.add(f"{path}/ring", mesh(element_forms.brake_disc(size)), FRICTION)
        self._drawing.place(f"{path}/shoes", Pose.of(origin, axis.quaternion(-axis.x)))
        self._drawing.add(f"{path}/shoes", mesh(element_forms.brake_shoes(size)), SHOES)
        return [origin]

    def _effort(self, path: str, effort: Array, axis: Axis) -> list[Array]:
        """Draw efforts `(n,)` as an arc about an axis or an arrow along it, in their sense."""
        greatest = self._greatest[axis.slides]
        if not greatest > 0.0:
            return []
        self.legend[ACTUATOR.css] = self._meaning()
        largest = ARROW_LENGTH if axis.slides else ARC_RADIUS
        size = np.abs(effort) * (largest * axis.radius / greatest)
        sense, _ = forms.filled(effort[:, None] * axis.direction, _LEAST_SCALE * greatest)
        surface = forms.arrow(_ARROW_RADIUS) if axis.slides else element_forms.arc_arrow()
        scale = np.maximum(size, _LEAST_SCALE * axis.radius)
        self._drawing.place(path, Pose.of(axis.origin, forms.towards(sense), scale))
        self._drawing.add(path, mesh(surface), ACTUATOR)
        reach = size[:, None] * axis.direction
        return [axis.origin + reach, axis.origin - reach]

    def _meaning(self) -> str:
        """Return what the arrows of actuators say, with the efforts of the greatest of them."""
        units = {False: "N·m", True: "N"}
        greatest = [f"{self._greatest[k]:.4g} {units[k]}" for k in units if self._greatest[k] > 0.0]
        return f"effort of an actuator, at most {' and '.join(greatest)}"
