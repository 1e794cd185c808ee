"""Robot: the elements of a URDF+ description, written one after the other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from ..arrays import Array

_RANGE = {"revolute": 3.15, "prismatic": 1.0}
"""Limits that URDF asks for [rad, m]; scenes do not regard them."""


class Robot:
    """A description that is being written.

    Attributes:
        element: the `<robot>`.
    """

    def __init__(self, name: str) -> None:
        self.element = ElementTree.Element("robot", name=name)

    def text(self) -> str:
        """Return the description as text."""
        ElementTree.indent(self.element)
        return ElementTree.tostring(self.element, encoding="unicode") + "\n"

    def link(
        self,
        name: str,
        *,
        mass: float = 0.0,
        centre: float = 0.0,
        moments: Sequence[float] = (0.0, 0.0, 0.0),
        visuals: Iterable[ElementTree.Element] = (),
    ) -> None:
        """Write a link.

        Args:
            name: of the link.
            mass: [kg]; no inertia without it.
            centre: x of its centre of mass [m].
            moments: principal moments of inertia about it, in axes of the link [kg·m²].
            visuals: its shapes.
        """
        link = ElementTree.SubElement(self.element, "link", name=name)
        if mass:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "origin", xyz=numbers((centre, 0.0, 0.0)))
            ElementTree.SubElement(inertial, "mass", value=repr(float(mass)))
            values = dict(zip(("ixx", "iyy", "izz"), map(repr, map(float, moments)), strict=True))
            products = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
            ElementTree.SubElement(inertial, "inertia", values | products)
        link.extend(visuals)

    def joint(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        axis: Array,
        *,
        xyz: Iterable[float] = (0.0, 0.0, 0.0),
        rpy: Iterable[float] = (0.0, 0.0, 0.0),
        axis2: Array | None = None,
    ) -> ElementTree.Element:
        """Write a tree joint."""
        joint = ElementTree.SubElement(self.element, "joint", name=name, type=kind)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=child)
        ElementTree.SubElement(joint, "origin", xyz=numbers(xyz), rpy=numbers(rpy))
        if kind != "fixed":
            ElementTree.SubElement(joint, "axis", xyz=numbers(axis))
        if axis2 is not None:
            ElementTree.SubElement(joint, "axis2", xyz=numbers(axis2))
        if kind == "prismatic":
            _limit(joint, kind)
        return joint

    def mimic(self, element: ElementTree.Element, of: str) -> None:
        """Let a joint follow another one of the tree."""
        ElementTree.SubElement(element, "mimic", joint=of, multiplier="1", offset="0")

    def adjustable(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        axis: Array,
        *,
        xyz: Iterable[float] = (0.0, 0.0, 0.0),
        rpy: Iterable[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Write a joint that is fixed unless a scene holds it."""
        joint = self.joint(name, "fixed", parent, child, axis, xyz=xyz, rpy=rpy)
        joint.set("adjustable", kind)
        ElementTree.SubElement(joint, "axis", xyz=numbers(axis))
        _limit(joint, kind)

    def loop(
        self,
        name: str,
        kind: str,
        predecessor: tuple[str, Iterable[float], Iterable[float]],
        successor: tuple[str, Iterable[float], Iterable[float]],
        axis: Array | None = None,
    ) -> None:
        """Write a loop between two links, with the place and turn of its frame in each."""
        loop = ElementTree.SubElement(self.element, "loop", name=name, type=kind)
        sides = {"predecessor": predecessor, "successor": successor}
        for side, (link, xyz, rpy) in sides.items():
            end = ElementTree.SubElement(loop, side, link=link)
            ElementTree.SubElement(end, "origin", xyz=numbers(xyz), rpy=numbers(rpy))
        if axis is not None:
            ElementTree.SubElement(loop, "axis", xyz=numbers(axis))


def rpy(rotation: Array) -> tuple[float, float, float]:
    """Return the angles [rad] about the fixed axes x, then y, then z, of a rotation `(3, 3)`."""
    (xx, _, _), (yx, _, _), (zx, zy, zz) = rotation.tolist()
    pitch = math.atan2(-zx, math.hypot(xx, yx))
    if math.hypot(xx, yx) > 1e-9:
        return math.atan2(zy, zz), pitch, math.atan2(yx, xx)
    # Upright: roll and yaw are about the same axis.
    return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0


def numbers(values: Iterable[float]) -> str:
    """Return numbers as an attribute lists them, to the last digit."""
    # Adding zero turns -0.0 into 0.0.
    return " ".join(f"{float(value) + 0.0!r}".removesuffix(".0") for value in values)


def _limit(joint: ElementTree.Element, kind: str) -> None:
    size = _RANGE[kind]
    limit = {"lower": f"{-size}", "upper": f"{size}", "effort": "1e6", "velocity": "10"}
    ElementTree.SubElement(joint, "limit", limit)
