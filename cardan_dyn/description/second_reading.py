"""Second reading: the numbers of a URDF or SDF text, read once more for the proof.

A proof that took its masses and lengths from where the solution has them could not detect an error
that was made when they were read. So the text is read a second time, by code that shares nothing
with the first reader; what the first reader checked is not checked again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from .description import Description, LinkDescription

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from .description import JointDescription, LoopDescription


def reread(description: Description) -> Description:
    """Return a description with the numbers of its text: masses, origins, axes, ratios.

    MJCF, and loops that stand beside a URDF, keep the numbers that were read first.
    """
    source = description.source
    if source is None:
        return description
    from xml.etree import ElementTree

    robot = ElementTree.fromstring(source.text)
    if robot.tag == "sdf":
        from .sdf import second_reading as sdf

        return sdf.reread(description, robot)
    if robot.tag != "robot":
        return description
    links, joints, loops, couplings = (
        {item.attrib["name"]: item for tag in tags for item in robot.findall(tag)}
        # Where both notations close the same loops, <loop> comes last and replaces the other.
        for tags in (("link",), ("joint",), ("loop_joint", "loop"), ("coupling",))
    )
    return replace(
        description,
        links=tuple(_link(link.name, links[link.name]) for link in description.links),
        joints=tuple(_joint(joint, joints[joint.name]) for joint in description.joints),
        loops=tuple(
            _loop(loop, loops[loop.name]) if loop.name in loops else loop
            for loop in description.loops
        ),
        couplings=tuple(
            replace(item, ratio=float(_child(couplings[item.name], "ratio").attrib["value"]))
            for item in description.couplings
        ),
    )


def _link(name: str, element: Element) -> LinkDescription:
    """Return a link with the mass and inertia of its element."""
    inertial = element.find("inertial")
    if inertial is None or float(_child(inertial, "mass").attrib["value"]) == 0.0:
        return LinkDescription(name)
    frame = _origin(inertial)
    inertia = _child(inertial, "inertia")
    rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
    tensor = np.array([[float(inertia.get(key, "0")) for key in row] for row in rows])
    return LinkDescription(
        name,
        float(_child(inertial, "mass").attrib["value"]),
        frame[:3, 3],
        np.einsum("ij,jk,lk->il", frame[:3, :3], tensor, frame[:3, :3]),
    )


def _joint(joint: JointDescription, element: Element) -> JointDescription:
    """Return a joint with the placement and axes of its element."""
    origin = _origin(element)
    made_universal = joint.type == "universal" and element.get("type") != "universal"
    if joint.type == "fixed" or made_universal:
        # A file beside the URDF that makes a joint universal states its axes as well.
        return replace(joint, origin=origin)
    axis = _axis(element, "axis")
    axis_2 = _axis(element, "axis2") if joint.type == "universal" else axis
    return replace(joint, origin=origin, axis=axis, axis_2=axis_2)


def _loop(loop: LoopDescription, element: Element) -> LoopDescription:
    """Return a loop with the placements and axes of its element."""
    predecessor, successor = _ends(element)
    axis = _axis(element, "axis")
    return replace(
        loop,
        predecessor_origin=predecessor,
        successor_origin=successor,
        axis=axis,
        axis_2=_axis(element, "axis2") if loop.type == "universal" else axis,
    )


def _axis(element: Element, tag: str) -> Array:
    """Return the `(3,)` unit vector that a child element states."""
    axis = _triple(element.find(tag), "xyz", (1.0, 0.0, 0.0))
    return axis / np.sqrt(axis @ axis)


def _ends(loop: Element) -> tuple[Array, Array]:
    """Return the `(4, 4)` placements of a loop's frame in its predecessor and its successor."""
    sides = ("link1", "link2") if loop.tag == "loop_joint" else ("predecessor", "successor")
    ends = [_child(loop, side) for side in sides]
    predecessor, successor = (
        _frame(end) if end.find("origin") is None else _origin(end) for end in ends
    )
    return predecessor, successor


def _origin(element: Element) -> Array:
    """Return the `(4, 4)` placement of an element's <origin>; identity where it has none."""
    origin = element.find("origin")
    return np.eye(4) if origin is None else _frame(origin)


def _frame(element: Element) -> Array:
    """Return the `(4, 4)` placement of xyz and rpy: turns about fixed axes x, y, z in turn."""
    frame = np.eye(4)
    for axis, angle in enumerate(_triple(element, "rpy", (0.0, 0.0, 0.0))):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(4)
        turn[second, second] = turn[third, third] = np.cos(angle)
        turn[third, second], turn[second, third] = np.sin(angle), -np.sin(angle)
        frame = turn @ frame
    frame[:3, 3] = _triple(element, "xyz", (0.0, 0.0, 0.0))
    return frame


def _triple(element: Element | None, name: str, default: tuple[float, ...]) -> Array:
    """Return the three numbers of an attribute, or those that count without it."""
    words = None if element is None else element.get(name)
    return np.array(default) if words is None else np.array(words.split(), dtype=float)


def _child(element: Element, tag: str) -> Element:
    """Return a child element, which the first reader has found there."""
    child = element.find(tag)
    if child is None:
        raise ValueError(f"<{element.tag}> has no <{tag}>, which the first reader found")
    return child
