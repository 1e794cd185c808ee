"""Reads what a test needs from a description, with the standard library and NumPy alone.

It shares no code with the package under test: numbers, units and axes are read from the file a
second time, and inertias are computed from the visuals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

URDF = Path(__file__).parents[3] / "urdf"
DENSITY = 7850.0
"""Density of steel [kg/m³], as the header of every description states."""


def text(name: str) -> str:
    """Return the text of a bundled description."""
    return (URDF / f"{name}.urdf").read_text(encoding="utf-8")


def vector(element: ElementTree.Element | None, key: str = "xyz") -> np.ndarray:
    """Return three numbers of an attribute, zeros where there is none."""
    words = None if element is None else element.get(key)
    return np.array((words or "0 0 0").split(), dtype=float)


def rotation(rpy: np.ndarray) -> np.ndarray:
    """Return the rotation of fixed-axis roll, pitch, yaw: R_z(yaw) R_y(pitch) R_x(roll)."""
    result = np.eye(3)
    for (first, second), angle in zip(((1, 2), (2, 0), (0, 1)), rpy, strict=True):
        turn = np.eye(3)
        turn[first, first] = turn[second, second] = np.cos(angle)
        turn[second, first] = np.sin(angle)
        turn[first, second] = -np.sin(angle)
        result = turn @ result
    return result


@dataclass(frozen=True)
class Body:
    """Mass [kg], centre of mass [m] and inertia about it [kg·m²], in the axes of a link."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray

    def __add__(self, other: Body) -> Body:
        mass = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        return Body(mass, centre, self.about(centre) + other.about(centre))

    def about(self, point: np.ndarray) -> np.ndarray:
        """Return the inertia about another point (Steiner)."""
        arm = self.centre - point
        return self.inertia + self.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


class Reader:
    """A description as the numbers in its file."""

    def __init__(self, urdf: str) -> None:
        self.robot = ElementTree.fromstring(urdf)

    def links(self) -> list[str]:
        return [link.get("name", "") for link in self.robot.findall("link")]

    def element(self, tag: str, name: str) -> ElementTree.Element:
        (found,) = (item for item in self.robot.findall(tag) if item.get("name") == name)
        return found

    def origin(self, joint: str) -> np.ndarray:
        """Return where a tree joint sits in its parent, in the parent's axes [m]."""
        return vector(self.element("joint", joint).find("origin"))

    def ends(self, loop: str) -> tuple[np.ndarray, np.ndarray]:
        """Return where a loop sits in its predecessor and in its successor, in their axes [m]."""
        element = self.element("loop", loop)
        return (
            vector(element.find("predecessor/origin")),
            vector(element.find("successor/origin")),
        )

    def axis(self, joint: str) -> np.ndarray:
        return vector(self.element("joint", joint).find("axis"))

    def zero_placement(self, link: str) -> tuple[np.ndarray, np.ndarray]:
        """Return axes and origin of a link in the world with all tree coordinates at zero."""
        joints = {_link(joint, "child"): joint for joint in self.robot.findall("joint")}
        axes, origin = np.eye(3), np.zeros(3)
        while link in joints:
            placement = joints[link].find("origin")
            turn = rotation(vector(placement, "rpy"))
            axes, origin = turn @ axes, vector(placement) + turn @ origin
            link = _link(joints[link], "parent")
        return axes, origin

    def loop_placements(self, loop: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return axes and origin of both frames of a loop in the world at zero."""
        placements = []
        for side in ("predecessor", "successor"):
            axes, origin = self.zero_placement(_link(self.element("loop", loop), side))
            own = self.element("loop", loop).find(f"{side}/origin")
            placements.append(
                (axes @ rotation(vector(own, "rpy")), origin + axes @ vector(own, "xyz"))
            )
        return placements

    def body(self, link: str) -> Body | None:
        """Return the stated inertia of a link, None for a massless one."""
        inertial = self.element("link", link).find("inertial")
        if inertial is None:
            return None
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        assert mass is not None and inertia is not None
        xx, yy, zz, xy, xz, yz = (
            float(inertia.get(key, "0")) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        )
        return Body(
            float(mass.get("value", "nan")),
            vector(inertial.find("origin")),
            np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
        )

    def primitives(self, link: str) -> dict[str, Body]:
        """Return the steel bodies that the visuals of a link show, by name."""
        return {
            visual.get("name", ""): _primitive(visual)
            for visual in self.element("link", link).findall("visual")
        }


def _link(element: ElementTree.Element, side: str) -> str:
    found = element.find(side)
    assert found is not None
    return found.get("link", "")


def _primitive(visual: ElementTree.Element) -> Body:
    name, shape = visual.get("name", ""), visual.find("geometry")
    assert shape is not None
    (shape,) = shape
    if shape.tag == "box":
        x, y, z = vector(shape, "size")
        mass = DENSITY * x * y * z
        moments = mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    elif shape.tag == "cylinder":
        outer, length = (float(shape.get(key, "nan")) for key in ("radius", "length"))
        wall = float(name.split("_wall_")[1].removesuffix("mm")) if "_wall_" in name else None
        inner = 0.0 if wall is None else outer - 1e-3 * wall
        mass = DENSITY * np.pi * (outer**2 - inner**2) * length
        across = mass * (3.0 * (outer**2 + inner**2) + length**2) / 12.0
        moments = np.array([across, across, 0.5 * mass * (outer**2 + inner**2)])
    else:
        assert shape.tag == "sphere", f"{name}: no inertia is known for <{shape.tag}>"
        radius = float(shape.get("radius", "nan"))
        mass = DENSITY * 4.0 / 3.0 * np.pi * radius**3
        moments = np.full(3, 0.4 * mass * radius**2)
    origin = visual.find("origin")
    axes = rotation(vector(origin, "rpy"))
    return Body(mass, vector(origin), axes @ np.diag(moments) @ axes.T)


def edited(urdf: str, change: Callable[[ElementTree.Element], None]) -> str:
    """Return a variant of a description, its XML tree changed in place by `change`."""
    robot = ElementTree.fromstring(urdf)
    change(robot)
    return ElementTree.tostring(robot, encoding="unicode")
