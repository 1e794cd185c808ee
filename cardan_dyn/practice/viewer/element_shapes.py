"""Element shapes of the viewer: what is drawn of each force element, and where.

Springs and dampers between points stretch with them, bushings and pins with clearance are balls;
elements along coordinates stand about the axes of their joints.
"""

from __future__ import annotations

from collections.abc import Sequence
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
from ...kit.arrays import Array, quaternion_product
from ...kit.quantities import amount
from . import shapes as forms
from .commands import Color, Drawing, Pose, node_name
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

# In radii of the scene, but for what is stretched, whose length is 1.
ARC_RADIUS = 0.26
"""Radius of the arc of the greatest effort."""
_APART = 0.09
"""Distance of the elements of one coordinate, along its axis or beside a slide."""
_COIL = forms.path(forms.coil(0.03), 0.005)
_DASHPOT = forms.dashpot(0.02)
_BALL = forms.capsule(0.035)
_SPIRAL = forms.path(forms.spiral(0.12), 0.005)
_PIN = forms.moved(forms.rod(0.01, -0.05, 0.05), np.eye(3), np.array([0.12, 0.0, 0.0]))
"""The pin on the parent at which a spiral ends when at rest."""
_DRUM = forms.joined(forms.rod(0.09, -0.006, 0.006), forms.ring(0.086, 0.1, -0.022, 0.022))
"""A damper that turns: a disc with a rim."""
_DISC = forms.ring(0.086, 0.12, -0.012, 0.012)
"""What turns in a brake."""
_BRAKE_SHOES = forms.brake_shoes(0.12)
_PADS = forms.pads(0.05)


def draw_elements(drawing: Drawing, sweep: Sweep | Still, samples: Array) -> None:
    """Draw the force elements of a sweep or a still.

    Args:
        drawing: what they are drawn on.
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.

    Raises:
        ArgumentError: an actuator's function fails.
    """
    places = _Places(sweep, samples, drawing.size)
    efforts: list[tuple[str, Array, Axis]] = []
    for index, (element, label) in enumerate(
        zip(sweep.elements, labels(sweep.elements), strict=True)
    ):
        path = f"/elements/{node_name(element.name or str(index))}"
        if isinstance(element, (PointSpring, PointActuator)):
            start = places.point(element.link_a, element.point_a)
            _between(drawing, path, element, start, places.point(element.link_b, element.point_b))
        elif isinstance(element, Bushing):
            middle = places.point(element.link_a, element.origin[:3, 3])
            drawing.add(path, _BALL, BUSHING, pose=_standing(drawing, middle), means="bushing")
        elif isinstance(element, PinContact):
            middle = places.point(element.link_b, element.point_b)
            pose = _standing(drawing, middle)
            drawing.add(path, _BALL, CONTACT, pose=pose, means="pin with clearance")
        elif isinstance(element, JointElement) and places.knows(element):
            axis = places.axis(element)
            if isinstance(element, Actuator):
                effort = element.force(axis.x, axis.v, axis.time, label).effort
                efforts.append((path, effort, axis))
            else:
                draw_along(drawing, path, element, axis)
    draw_efforts(drawing, efforts)


def _standing(drawing: Drawing, at: Array, turn: Array | None = None) -> Pose:
    """Return the pose of what is drawn in radii of the scene, which the camera sees."""
    drawing.include(at)
    return Pose.of(at, turn, np.full(1, drawing.size))


def _stretched(drawing: Drawing, start: Array, end: Array, turn: Array, length: Array) -> Pose:
    """Return the pose of what is as long as told, and else in radii of the scene."""
    drawing.include(start, end)
    scale = np.full((len(length), 3), drawing.size)
    scale[:, 2] = length
    return Pose.of(start, turn, scale)


def _between(
    drawing: Drawing, path: str, element: PointSpring | PointActuator, start: Array, end: Array
) -> None:
    """Draw a spring as a coil, all others between points as a dashpot."""
    least = forms.LEAST_SCALE * drawing.size
    direction, length = forms.filled(end - start, least)
    turn = forms.towards(direction)
    pose = _stretched(drawing, start, end, turn, np.maximum(length, least))
    if element.conserves or (isinstance(element, PointSpring) and element.stiffness > 0.0):
        drawing.add(path, _COIL, SPRING, pose=pose, means="spring")
    elif element.gives_power:
        drawing.add(path, _DASHPOT, CYLINDER, pose=pose, means="thrust of an actuator")
    else:
        drawing.add(path, _DASHPOT, DAMPER, pose=pose, means="damper")


class _Places:
    """Where the ends and axes of elements are at the samples that are shown."""

    def __init__(self, sweep: Sweep | Still, samples: Array, radius: float) -> None:
        self._mechanism, self._radius = sweep.mechanism, radius
        self._named = self._mechanism.coordinates.named
        self._rows = sweep.motion.rows[samples]
        self._rates = sweep.motion.v.reshape(len(sweep.motion.rows), -1)[samples]
        self._time = np.broadcast_to(sweep.time, sweep.motion.shape).reshape(-1)[samples]
        links = {link for item in sweep.elements for link in item.links}
        coordinates = self._mechanism.coordinates
        parts = dict(zip(coordinates.starts, coordinates.parts, strict=True))
        joints = {name for item in sweep.elements for name in item.joints}
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
        aside = forms.upright(part.axis)[:, 0] if part.kind == "prismatic" else part.axis
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
        )


class Axis(NamedTuple):
    """Where a coordinate's axis is at the samples that are shown.

    Attributes:
        part: the elementary part that turns about it or slides along it.
        child: motion of the body that the part moves.
        x: coordinate `(n,)` [rad or m].
        v: its rate `(n,)` [rad/s or m/s].
        time: `(n,)` [s].
        shift: `(3,)` from the origin of the joint to the drawing, in the joint's axes [m].
    """

    part: Part
    child: LinkMotion
    x: Array
    v: Array
    time: Array
    shift: Array

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
        half = np.broadcast_to(0.5 * np.asarray(turn), self.x.shape)
        about = np.stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)], axis=1)
        upright = forms.quaternions(self.child.rotation @ forms.upright(self.part.axis))
        return quaternion_product(np.broadcast_to(upright, about.shape), about)


def draw_along(drawing: Drawing, path: str, element: JointElement, axis: Axis) -> None:
    """Draw a spring, a damper or friction along a coordinate.

    Args:
        drawing: what it is drawn on.
        path: of its node.
        element: the element.
        axis: of its coordinate.
    """
    if isinstance(element, JointFriction):
        _brake(drawing, path, axis)
    if not isinstance(element, JointSpring):
        return
    springs = element.stiffness > 0.0 or element.damping == 0.0
    means, color = ("spring", JOINT_SPRING) if springs else ("damper", DAMPER)
    if axis.slides:
        # Between the child and a point of the parent behind it: shortest where pressed most.
        free = float(np.max(element.rest - axis.x)) + 0.25 * drawing.size
        length = axis.x - element.rest + free
        start = axis.origin - length[:, None] * axis.direction
        pose = _stretched(drawing, start, axis.origin, axis.quaternion(), length)
        drawing.add(path, _COIL if springs else _DASHPOT, color, pose=pose, means=means)
    elif springs:
        # A spiral on the child, whose end meets a pin at rest.
        pose = _standing(drawing, axis.origin, axis.quaternion())
        drawing.add(f"{path}/spiral", _SPIRAL, color, pose=pose, means=means)
        at_rest = _standing(drawing, axis.origin, axis.quaternion(element.rest - axis.x))
        drawing.add(f"{path}/rest", _PIN, color, pose=at_rest)
    else:
        pose = _standing(drawing, axis.origin, axis.quaternion())
        drawing.add(path, _DRUM, color, pose=pose, means=means)


def _brake(drawing: Drawing, path: str, axis: Axis) -> None:
    """Draw friction: a ring that turns between shoes, or pads that slide along a rod."""
    moving = _standing(drawing, axis.origin, axis.quaternion())
    if axis.slides:
        start = axis.origin - axis.x[:, None] * axis.direction
        low, high = np.min(axis.x) / drawing.size - 0.1, np.max(axis.x) / drawing.size + 0.1
        drawing.include(*(start + end * drawing.size * axis.direction for end in (low, high)))
        still = _standing(drawing, start, axis.quaternion())
        rod = forms.rod(0.005, float(low), float(high))
        drawing.add(f"{path}/rod", rod, FRICTION, pose=still, means="dry friction")
        drawing.add(f"{path}/pads", _PADS, SHOES, pose=moving)
        return
    drawing.add(f"{path}/ring", _DISC, FRICTION, pose=moving, means="dry friction")
    still = _standing(drawing, axis.origin, axis.quaternion(-axis.x))
    drawing.add(f"{path}/shoes", _BRAKE_SHOES, SHOES, pose=still)


def draw_efforts(drawing: Drawing, efforts: Sequence[tuple[str, Array, Axis]]) -> None:
    """Draw efforts of actuators as arcs about axes and arrows along them, in their sense.

    Args:
        drawing: what they are drawn on.
        efforts: paths of nodes, efforts `(n,)` [N·m or N] and axes; those about axes have one
            scale, and those along them another one.
    """
    greatest = {
        slides: max(
            (float(np.max(np.abs(effort))) for _, effort, axis in efforts if axis.slides == slides),
            default=0.0,
        )
        for slides in (False, True)
    }
    units = zip(greatest.values(), ("N·m", "N"), strict=True)
    sizes = " and ".join(amount(size, unit) for size, unit in units if size > 0.0)
    for path, effort, axis in efforts:
        whole = greatest[axis.slides]
        if not whole > 0.0:
            continue
        largest = (forms.ARROW if axis.slides else ARC_RADIUS) * drawing.size
        size = np.abs(effort) / whole * largest
        sense, _ = forms.filled(effort[:, None] * axis.direction, forms.LEAST_SCALE * whole)
        scale = np.maximum(size, forms.LEAST_SCALE * drawing.size)
        pose = Pose.of(axis.origin, forms.towards(sense), scale)
        surface = forms.arrow() if axis.slides else forms.arc_arrow()
        means = f"effort of an actuator, at most {sizes}"
        drawing.add(path, surface, ACTUATOR, pose=pose, means=means)
        reach = size[:, None] * axis.direction
        drawing.include(axis.origin + reach, axis.origin - reach)
