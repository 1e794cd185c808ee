"""Constraint: loops as `<constraint>`, the element that is proposed for ROS' URDF.

The format is that of pull request 264 of ros/urdfdom (parser) and 108 of ros/urdfdom_headers, as it
stood in 2026: `<parent>` and `<child>` name the links, `<parent_origin>` and `<child_origin>` place
a frame in each of them, and both frames coincide up to the motion of the joint that was cut. A
constraint of the type `link` cuts a link in two: nothing moves.
"""

from __future__ import annotations

from collections.abc import Collection
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError, choices
from .description import LoopDescription
from .elements import DIRECTION_TOLERANCE, axes_of, axis_of, link_of, name_of, only, pose

CONSTRAINT_TYPES = {
    **{kind: kind for kind in ("revolute", "prismatic", "universal", "spherical")},
    **{f"{kind}_joint": kind for kind in ("revolute", "prismatic", "universal", "spherical")},
    "link": "fixed",
}
"""Type of a constraint to the type of the loop that it is."""


def constraint(element: ElementTree.Element, links: Collection[str], where: str) -> LoopDescription:
    """Return the loop that a `<constraint>` is.

    Args:
        element: the constraint.
        links: names of all links.
        where: how messages name the source of the text.

    Raises:
        ModelError: what is wrong with it.
    """
    name = name_of(element, where)
    at = f"{where}: constraint {name!r}"
    kind = CONSTRAINT_TYPES.get(element.get("type", ""))
    if kind is None:
        listed = choices(CONSTRAINT_TYPES, element.get("type"))
        raise ModelError(f"{at}: type {element.get('type')!r} is not supported; types: {listed}")
    parent, child = (link_of(element, side, links, at) for side in ("parent", "child"))
    if parent == child:
        raise ModelError(f"{at}: parent and child are the same link {child!r}")
    first, second = (_origin(element, side, at) for side in ("parent_origin", "child_origin"))
    axis = axis_2 = np.array([1.0, 0.0, 0.0])
    if kind == "universal":
        axis, axis_2 = axes_of(element, kind, at, ("parent_axis", "child_axis"))
    elif kind in ("revolute", "prismatic"):
        axis = axis_2 = _single_axis(element, at)
    return LoopDescription(name, kind, parent, child, first, second, axis, axis_2)


def _origin(element: ElementTree.Element, tag: str, at: str) -> np.ndarray:
    """Return the `(4, 4)` placement of a side's frame in its link; identity where it has none."""
    origin = only(element, tag, at)
    return np.eye(4) if origin is None else pose(origin, at)


def _single_axis(element: ElementTree.Element, at: str) -> np.ndarray:
    """Return the `(3,)` unit axis of a hinge or slide, which the parent's side states.

    The child's side may state it, too. Since the frames turn about it or slide along it, it has the
    same components in both.
    """
    axis = axis_of(element, at, "parent_axis")
    if element.find("child_axis") is not None:
        other = axis_of(element, at, "child_axis")
        if np.linalg.norm(np.cross(axis, other)) > DIRECTION_TOLERANCE:
            raise ModelError(
                f"{at}: parent_axis {axis.tolist()} and child_axis {other.tolist()} differ, and "
                "both frames share the axis of a hinge or slide; turn one origin, or leave "
                "child_axis out"
            )
    return axis
