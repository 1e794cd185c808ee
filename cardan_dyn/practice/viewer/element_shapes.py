"""Element shapes of the viewer: what is drawn of each force element, and where.

Springs and dampers between points stretch with them, bushings and pins with clearance are balls;
elements along coordinates stand about the axes of their joints.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.elements.bushing import Bushing
from ...core.elements.element_forces import labels
from ...core.elements.joint_elements import Actuator, JointElement, JointFriction, JointSpring
from ...core.elements.link_motions import LinkMotion, LinkMotions
from ...core.elements.pin_contact import PinContact
from ...core.elements.point_actuator import PointActuator
from ...core.elements.point_spring import PointSpring
from ...core.mechanism.joints import Part
from ...core.results.sweep import Sweep
from ...kit.arrays import Array
from . import shapes as forms
from .commands import Color, Drawing, Pose, mesh, meshcat, node_name
from .still import Still
from .vectors import beside

SPRING = Color.of("#d17b00")
BUSHING = Color.of("#8d6e63", opacity=0.8, on_top=True, layer=2)
CONTACT = Color.of("#c2185b", opacity=0.8, on_top=True, layer=2)
JOINT_SPRING = Color.of("#d17b00", opacity=0.9, on_top=True, layer=2)
DAMPER = Color.of("#827717", opacity=0.75, on_top=True, layer=2)
CYLINDER = Color.of("#8e24aa", opacity=0.75, on_top=True, layer=2)
FRICTION = Color.of("#546e7a", opacity=0.9, on_top=True, layer=2)
SHOES = Color.of("#263238", opacity=0.9, on_top=True, layer=3)
ACTUATOR = Color.of("#e53935", on_top=True, layer=4)

_BALLS = {BUSHING.css: "bushing", CONTACT.css: "pin with clearance"}
"""What balls mean, by their colour."""

# Lengths in the drawing are fractions of the radius of the scene, chosen for legibility.
_COIL_RADIUS, _DASHPOT_RADIUS, _WIRE_RADIUS, _BALL_RADIUS = 0.03, 0.02, 0.005, 0.035
_SPIRAL_RADIUS, _PIN_RADIUS, _PIN_LENGTH = 0.12, 0.01, 0.05
"""Radius of a spiral; radius and half the length of the pin on the parent at which it ends when at
rest."""
_DRUM_RADIUS, _BRAKE_RADIUS, _PAD_SIZE = 0.1, 0.12, 0.05
_ROOM = 0.25
"""Least length of a coil along a slide."""
ARC_RADIUS = 0.26
"""Radius of the arc of the greatest effort."""
_APART = 0.09
"""Distance of the elements of one coordinate, along its axis or beside a slide, likewise."""


class DrawnElements(NamedTuple):
    """What was drawn of elements.

    Attributes:
        legend: CSS colour and meaning.
        points: `(n, 3)` what the camera has to see [m].
    """

    legend: list[tuple[str, str]]
    points: Array


def draw_elements(
    drawing: Drawing, sweep: Sweep | Still, samples: Array, radius: float
) -> DrawnElements:
    """Draw the force elements of a sweep or a still.

    Args:
        drawing: what they are drawn on.
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        radius: of the scene [m].

    Raises:
        ArgumentError: an actuator's function fails.
    """
    places = _Places(sweep, samples, radius)
    between = _BetweenLinks(drawing, places, radius)
    along = JointDrawing(drawing, places.greatest_efforts())
    points = [np.zeros((0, 3))]
    for index, (element, label) in enumerate(zip(places.elements, places.labels, strict=True)):
        path = f"/elements/{node_name(element.name or str(index))}"
        if isinstance(element, (PointSpring, PointActuator)):
            points += between.draw_spring(path, element)
        elif isinstance(element, Bushing):
            points += between.draw_ball(path, element.link_a, element.origin[:3, 3], BUSHING)
        elif isinstance(element, PinContact):
            points += between.draw_ball(path, element.link_b, element.point_b, CONTACT)
        elif isinstance(element, JointElement) and places.knows(element):
            points += along.draw(path, element, places.axis(element), label)
    legend = {**between.legend, **along.legend}
    return DrawnElements(list(legend.items()), np.concatenate(points))


class _Places:
    """Where the ends and axes of elements are at the samples that are shown.

    Attributes:
        elements: those of the sweep.
        labels: how messages call them.
    """

    def __init__(self, sweep: Sweep | Still, samples: Array, radius: float) -> None:
        self.elements = sweep.elements
        self.labels = labels(self.elements)
        self._mechanism, self._radius = sweep.mechanism, radius
        self._named = self._mechanism.coordinates.named
        self._rows = sweep.motion.rows[samples]
        self._rates = sweep.motion.v.reshape(len(sweep.motion.rows), -1)[samples]
        self._time = np.broadcast_to(sweep.time, sweep.motion.shape).reshape(-1)[samples]
        links = {link for item in self.elements for link in item.links}
        coordinates = self._mechanism.coordinates
        parts = dict(zip(coordinates.starts, coordinates.parts, strict=True))
        joints = {name for item in self.elements for name in item.joints}
        self._parts = {name: parts[self._named[name].column] for name in joints}
        bodies = {part.id for part in self._parts.values()}
        motions = LinkMotions(self._mechanism, links, bodies)
        self._corner = motions.corner
        self._links = motions.at(self._rows, self._rates)
        self._bodies = motions.bodies_at(self._rows, self._rates)
        self._taken: dict[str, int] = {}

    def point(self, link: str, place: Array) -> Array:
        """Return where a point `(3,)` of a link is, `(n, 3)` [m]."""
        motion = self._links[link]
        at = motion.rotation @ place + motion.position + self._corner
        return np.broadcast_to(at, (len(self._rows), 3))

    def knows(self, element: JointElement) -> bool:
        """Return whether the motion of an element's joint was solved."""
        moved = self._bodies[self._parts[element.joint].id]
        return bool(np.all(np.isfinite(moved.position)) and np.all(np.isfinite(moved.rotation)))

    def axis(self, element: JointElement) -> Axis:
        """Return the axis of an element's coordinate, shifted where others stand there already."""
        item, part = self._named[element.joint], self._parts[element.joint]
        moved = self._bodies[part.id]
        joint = self._mechanism.joints[self._mechanism.drivable[element.joint].joint]
        count = self._taken.get(element.joint, 0)
        aside = across(part.axis) if part.kind == "prismatic" else part.axis
        # The arrow of an actuator goes around the others.
        self._taken[element.joint] = count + (not isinstance(element, Actuator))
        return Axis(
            part=part,
            child=LinkMotion(
                moved.rotation, moved.position + self._corner, moved.velocity, moved.spin
            ),
            x=self._rows[:, item.column],
            v=self._rates[:, item.rate],
            time=self._time,
            shift=beside(self._mechanism, joint, self._radius) * joint.axis
            + count * _APART * self._radius * aside,
            radius=self._radius,
        )

    def greatest_efforts(self) -> dict[bool, float]:
        """Return the greatest effort of all actuators at slides (True) and at turns."""
        greatest = {True: 0.0, False: 0.0}
        for element, label in zip(self.elements, self.labels, strict=True):
            if isinstance(element, Actuator):
                item = self._named[element.joint]
                x, v = self._rows[:, item.column], self._rates[:, item.rate]
                effort = element.force(x, v, self._time, label).effort
                slides = self._parts[element.joint].kind == "prismatic"
                greatest[slides] = max(greatest[slides], float(np.max(np.abs(effort))))
        return greatest


class _BetweenLinks:
    """Draws the elements between links.

    Attributes:
        legend: CSS colour to meaning of what was drawn.
    """

    def __init__(self, drawing: Drawing, places: _Places, radius: float) -> None:
        self._drawing, self._places, self._radius = drawing, places, radius
        self.legend: dict[str, str] = {}

    def draw_spring(self, path: str, element: PointSpring | PointActuator) -> list[Array]:
        """Draw a spring as a coil, all others between points as a dashpot; return their ends."""
        start = self._places.point(element.link_a, element.point_a)
        span = self._places.point(element.link_b, element.point_b) - start
        direction, length = forms.filled(span, forms.LEAST_SCALE * self._radius)
        scale = np.ones((len(span), 3))
        scale[:, 2] = np.maximum(length, forms.LEAST_SCALE * self._radius)
        self._drawing.place(path, Pose.of(start, forms.towards(direction), scale))
        if element.conserves or (isinstance(element, PointSpring) and element.stiffness > 0.0):
            # The coil has the length 1: only that is stretched. Its wire is as thick across as it
            # is wide.
            wire = forms.coil(_COIL_RADIUS * self._radius)
            self._drawing.add(path, mesh(forms.path(wire, _WIRE_RADIUS * self._radius)), SPRING)
            self.legend[SPRING.css] = "spring"
        else:
            dashpot = forms.dashpot(_DASHPOT_RADIUS * self._radius)
            color = CYLINDER if element.gives_power else DAMPER
            self._drawing.add(path, mesh(dashpot), color)
            self.legend[color.css] = "thrust of an actuator" if element.gives_power else "damper"
        return [start, start + span]

    def draw_ball(self, path: str, link: str, point: Array, color: Color) -> list[Array]:
        """Draw a bushing or a pin contact as a ball at a point of a link; return its middle."""
        middle = self._places.point(link, point)
        self._drawing.place(path, Pose.of(middle))
        ball = meshcat().geometry.Sphere(_BALL_RADIUS * self._radius)
        self._drawing.add(path, ball, color)
        self.legend[color.css] = _BALLS[color.css]
        return [middle]


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
                self.legend[JOINT_SPRING.css] = "spring"
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
            f"{path}/spiral", mesh(forms.path(forms.spiral(size), wire)), JOINT_SPRING
        )
        pin = forms.rod(
            _PIN_RADIUS * axis.radius, -_PIN_LENGTH * axis.radius, _PIN_LENGTH * axis.radius
        )
        outside = np.eye(4)
        outside[0, 3] = size
        self._drawing.place(f"{path}/rest", Pose.of(origin, axis.quaternion(element.rest - axis.x)))
        self._drawing.add(f"{path}/rest/pin", mesh(pin), JOINT_SPRING, outside)
        return [origin]

    def _coil(self, path: str, element: JointSpring, axis: Axis) -> list[Array]:
        """Draw a spring along an axis, as a coil that is shortest where it is pressed most."""
        wire = forms.path(forms.coil(_COIL_RADIUS * axis.radius), _WIRE_RADIUS * axis.radius)
        return self._stretched(path, wire, JOINT_SPRING, element.rest, axis)

    def _damper(self, path: str, element: JointSpring, axis: Axis) -> list[Array]:
        """Draw a damper without a spring: a drum about an axis, or a dashpot along it."""
        if axis.slides:
            dashpot = forms.dashpot(_DASHPOT_RADIUS * axis.radius)
            return self._stretched(path, dashpot, DAMPER, element.rest, axis)
        self._drawing.place(path, Pose.of(axis.origin, axis.quaternion()))
        self._drawing.add(path, mesh(forms.drum(_DRUM_RADIUS * axis.radius)), DAMPER)
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
            rod = forms.rod(_WIRE_RADIUS * radius, low - margin, high + margin)
            start = origin - axis.x[:, None] * axis.direction
            self._drawing.place(f"{path}/rod", Pose.of(start, axis.quaternion()))
            self._drawing.add(f"{path}/rod", mesh(rod), FRICTION)
            self._drawing.place(f"{path}/pads", Pose.of(origin, axis.quaternion()))
            self._drawing.add(f"{path}/pads", mesh(forms.pads(_PAD_SIZE * radius)), SHOES)
            return [start + (end * axis.direction) for end in (low - margin, high + margin)]
        size = _BRAKE_RADIUS * radius
        self._drawing.place(f"{path}/ring", Pose.of(origin, axis.quaternion()))
        self._drawing.add(f"{path}/ring", mesh(forms.brake_disc(size)), FRICTION)
        self._drawing.place(f"{path}/shoes", Pose.of(origin, axis.quaternion(-axis.x)))
        self._drawing.add(f"{path}/shoes", mesh(forms.brake_shoes(size)), SHOES)
        return [origin]

    def _effort(self, path: str, effort: Array, axis: Axis) -> list[Array]:
        """Draw efforts `(n,)` as an arc about an axis or an arrow along it, in their sense."""
        greatest = self._greatest[axis.slides]
        if not greatest > 0.0:
            return []
        self.legend[ACTUATOR.css] = self._meaning()
        largest = forms.ARROW if axis.slides else ARC_RADIUS
        size = np.abs(effort) * (largest * axis.radius / greatest)
        sense, _ = forms.filled(effort[:, None] * axis.direction, forms.LEAST_SCALE * greatest)
        surface = forms.arrow(forms.ARROW_RADIUS) if axis.slides else forms.arc_arrow()
        scale = np.maximum(size, forms.LEAST_SCALE * axis.radius)
        self._drawing.place(path, Pose.of(axis.origin, forms.towards(sense), scale))
        self._drawing.add(path, mesh(surface), ACTUATOR)
        reach = size[:, None] * axis.direction
        return [axis.origin + reach, axis.origin - reach]

    def _meaning(self) -> str:
        """Return what the arrows of actuators say, with the efforts of the greatest of them."""
        units = {False: "N·m", True: "N"}
        greatest = [f"{self._greatest[k]:.4g} {units[k]}" for k in units if self._greatest[k] > 0.0]
        return f"effort of an actuator, at most {' and '.join(greatest)}"
