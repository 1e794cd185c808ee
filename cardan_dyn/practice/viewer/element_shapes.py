"""Element shapes of the viewer: what is drawn of each force element, and where.

Springs and dampers between points stretch with them, bushings and pins with clearance are balls;
elements along coordinates stand about the axes of their joints.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...core.elements.bushing import Bushing
from ...core.elements.element import Element
from ...core.elements.element_forces import labels
from ...core.elements.joint_elements import Actuator, JointElement, JointFriction, JointSpring
from ...core.elements.pin_contact import PinContact
from ...core.elements.point_actuator import PointActuator
from ...core.elements.point_spring import PointSpring
from ...kit.arrays import Array
from ...kit.quantities import amount
from . import shapes as forms
from .commands import Color, Drawing, Pose, node_name
from .places import Axis, Places

SPRING = Color.of("#d17b00")
BUSHING = Color.of("#8d6e63", opacity=0.8, layer=2)
CONTACT = Color.of("#c2185b", opacity=0.8, layer=2)
JOINT_SPRING = Color.of("#d17b00", opacity=0.9, layer=2)
DAMPER = Color.of("#827717", opacity=0.75, layer=2)
CYLINDER = Color.of("#8e24aa", opacity=0.75, layer=2)
FRICTION = Color.of("#546e7a", opacity=0.9, layer=2)
SHOES = Color.of("#263238", opacity=0.9, layer=3)
ACTUATOR = Color.of("#e53935", layer=4)

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


def draw_elements(drawing: Drawing, elements: Sequence[Element], places: Places) -> None:
    """Draw force elements.

    Args:
        drawing: what they are drawn on.
        elements: all of a sweep or a still.
        places: of the latter.

    Raises:
        ArgumentError: an actuator's function fails.
    """
    taken: Counter[str] = Counter()
    efforts: list[tuple[str, Array, Axis]] = []
    for index, (element, label) in enumerate(zip(elements, labels(elements), strict=True)):
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
        elif isinstance(element, JointElement) and (axis := places.axis(element.joint)):
            z = axis.part.axis
            aside = forms.upright(z)[:, 0] if axis.slides else z
            count = taken[element.joint]
            axis = axis._replace(shift=axis.shift + count * _APART * drawing.size * aside)
            # The arrow of an actuator goes around the others.
            taken[element.joint] += not isinstance(element, Actuator)
            if isinstance(element, Actuator):
                effort = element.force(axis.x, axis.v, axis.time, label).effort
                efforts.append((path, effort, axis))
            else:
                draw_along(drawing, path, element, axis)
    draw_efforts(drawing, efforts)


def _standing(drawing: Drawing, at: Array, turn: ArrayLike = (0, 0, 0, 1)) -> Pose:
    """Return the pose of what is drawn in radii of the scene, which the camera sees."""
    drawing.include(at)
    return Pose(at, turn, drawing.size)


def _stretched(drawing: Drawing, start: Array, end: Array, turn: Array, length: Array) -> Pose:
    """Return the pose of what is as long as told, and else in radii of the scene."""
    drawing.include(start, end)
    scale = np.full((len(length), 3), drawing.size)
    scale[:, 2] = length
    return Pose(start, turn, scale)


def _between(
    drawing: Drawing, path: str, element: PointSpring | PointActuator, start: Array, end: Array
) -> None:
    """Draw a spring as a coil, all others between points as a dashpot."""
    least = 0.1 * forms.PIXEL * drawing.size
    direction, length = forms.filled(end - start, least)
    turn = forms.towards(direction)
    pose = _stretched(drawing, start, end, turn, np.maximum(length, least))
    if element.conserves or (isinstance(element, PointSpring) and element.stiffness > 0.0):
        drawing.add(path, _COIL, SPRING, pose=pose, means="spring")
    elif element.gives_power:
        drawing.add(path, _DASHPOT, CYLINDER, pose=pose, means="thrust of an actuator")
    else:
        drawing.add(path, _DASHPOT, DAMPER, pose=pose, means="damper")


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
    for slides, unit, size in ((False, "N·m", ARC_RADIUS), (True, "N", forms.ARROW)):
        own = [item for item in efforts if item[2].slides == slides]
        most = max((float(np.max(np.abs(effort))) for _, effort, _ in own), default=0.0)
        means = f"effort of an actuator, at most {amount(most, unit)}"
        surface = forms.arrow() if slides else forms.arc_arrow()
        for path, effort, axis in own if most > 0.0 else ():
            shown = (size * drawing.size / most * effort)[:, None] * axis.direction
            drawing.arrow(path, axis.origin, shown, ACTUATOR, means, surface)
            drawing.include(axis.origin - shown)
