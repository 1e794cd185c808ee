"""Element shapes of the viewer: what is drawn of each force element, and where.

Springs and dampers between points stretch with them, bushings and pins with play are balls;
elements along coordinates stand about the axes of their joints, see `joint_element_shapes`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..elements.bushing import Bushing
from ..elements.element_forces import labels
from ..elements.joint_elements import Actuator, JointElement
from ..elements.link_motions import LinkMotion, LinkMotions
from ..elements.pin_contact import PinContact
from ..elements.point_spring import PointSpring
from ..results.sweep import Sweep
from . import element_forms
from . import shapes as forms
from .commands import Color, Drawing, Pose, mesh, meshcat, node_name
from .joint_element_shapes import DAMPER, Axis, JointDrawing, across
from .still import Still
from .vectors import beside

SPRING = Color.of("#d17b00")
BUSHING = Color.of("#8d6e63", opacity=0.8, on_top=True, layer=2)
CONTACT = Color.of("#c2185b", opacity=0.8, on_top=True, layer=2)

_BALLS = {BUSHING.css: "bushing", CONTACT.css: "pin with play"}
"""What balls mean, by their colour."""

# Lengths in the drawing are fractions of the radius of the scene, chosen for legibility.
_COIL_RADIUS, _DASHPOT_RADIUS, _WIRE_RADIUS, _BALL_RADIUS = 0.03, 0.02, 0.005, 0.035
_LEAST_LENGTH = 1e-5
"""Least length of a coil, as a fraction of that radius; a scale of zero has no inverse."""
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
        if isinstance(element, PointSpring):
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

    def draw_spring(self, path: str, element: PointSpring) -> list[Array]:
        """Draw a point spring as a coil, one without stiffness as a dashpot; return its ends."""
        start = self._places.point(element.link_a, element.point_a)
        span = self._places.point(element.link_b, element.point_b) - start
        direction, length = forms.filled(span, _LEAST_LENGTH * self._radius)
        scale = np.ones((len(span), 3))
        scale[:, 2] = np.maximum(length, _LEAST_LENGTH * self._radius)
        self._drawing.place(path, Pose.of(start, forms.towards(direction), scale))
        if element.stiffness > 0.0 or element.damping == 0.0:
            # The coil has the length 1: only that is stretched. Its wire is as thick across as it
            # is wide.
            wire = element_forms.coil(_COIL_RADIUS * self._radius)
            self._drawing.add(path, mesh(forms.path(wire, _WIRE_RADIUS * self._radius)), SPRING)
            self.legend[SPRING.css] = "spring"
        else:
            dashpot = element_forms.dashpot(_DASHPOT_RADIUS * self._radius)
            self._drawing.add(path, mesh(dashpot), DAMPER)
            self.legend[DAMPER.css] = "damper"
        return [start, start + span]

    def draw_ball(self, path: str, link: str, point: Array, color: Color) -> list[Array]:
        """Draw a bushing or a pin with play as a ball at a point of a link; return its middle."""
        middle = self._places.point(link, point)
        self._drawing.place(path, Pose.of(middle))
        ball = meshcat().geometry.Sphere(_BALL_RADIUS * self._radius)
        self._drawing.add(path, ball, color)
        self.legend[color.css] = _BALLS[color.css]
        return [middle]
