"""Elements: what URDF-like XML elements say, read and checked."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Iterable
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError, choices
from .description import LoopDescription

JOINT_TYPES = frozenset({"revolute", "continuous", "prismatic", "fixed", "planar", "floating"})
"""Types of tree joints that can be loaded."""
LOOP_TYPES = frozenset(
    {
        *("revolute", "continuous", "prismatic", "fixed", "planar"),
        *("spherical", "universal", "cylindrical"),
    }
)
"""Types of loops that can be closed."""


MOST_LINKS = 2000
"""Greatest number of links of a description."""


def check_size(links: int, where: str) -> None:
    """Refuse a description that is larger than anything was tested with.

    Raises:
        ModelError: it has more than `MOST_LINKS` links.
    """
    if links > MOST_LINKS:
        raise ModelError(
            f"{where}: there are {links} links, the limit is {MOST_LINKS}; describe what moves "
            "together as one link, or load parts of it"
        )


def only(element: ElementTree.Element, tag: str, at: str) -> ElementTree.Element | None:
    """Return the child of a kind, None without one.

    Raises:
        ModelError: there are several, which would leave open what holds.
    """
    found = element.findall(tag)
    if len(found) > 1:
        raise ModelError(f"{at}: there are {len(found)} <{tag}> in <{element.tag}>; keep one")
    return found[0] if found else None


def names(robot: ElementTree.Element, tag: str, where: str) -> list[str]:
    """Return the names of all elements of a kind, each of which occurs once."""
    found = [name_of(element, where) for element in robot.findall(tag)]
    check_unique(found, tag, where)
    return found


def check_unique(names: list[str], what: str, where: str) -> None:
    """Refuse names that occur twice."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise ModelError(f"{where}: {what} names that occur twice: {choices(twice)}")


def name_of(element: ElementTree.Element, where: str) -> str:
    """Return the name of an element, which must have one."""
    name = element.get("name")
    if not name:
        raise ModelError(f"{where}: a <{element.tag}> has no name")
    return name


def link_of(element: ElementTree.Element, tag: str, links: Collection[str], at: str) -> str:
    """Return the name of an existing link that a child element points to."""
    found = only(element, tag, at)
    if found is None or not found.get("link"):
        raise ModelError(f'{at}: <{tag} link="..."/> is missing')
    name = found.get("link", "")
    if name not in links:
        raise ModelError(f"{at}: {tag} link {name!r} does not exist; links: {choices(links)}")
    return name


_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
GREATEST = 1e50
"""Greatest number in a description: products of several of them are still far from overflow."""


_LEAST = 1e-150  # Squares of smaller numbers vanish: they are taken as zero.


def numbers(text: str | None, count: int, default: str, at: str) -> np.ndarray:
    """Return the numbers that an attribute lists.

    They are decimal numbers as XML knows them, with blanks between and around them. Python would
    read more (`1_0`, digits of other scripts), of which no other program makes the same number.
    """
    words = re.split(r"[ \t\r\n]+", (default if text is None else text).strip(" \t\r\n"))
    if len(words) != count or not all(_NUMBER.fullmatch(word) for word in words):
        raise ModelError(f"{at}: {text!r} is not {count} finite number(s)")
    values = np.array([float(word) for word in words])
    if not np.all(np.abs(values) <= GREATEST):
        raise ModelError(
            f"{at}: {text!r} is beyond {GREATEST:.0e}; choose units in which numbers are not so "
            "far from 1"
        )
    values[np.abs(values) < _LEAST] = 0.0
    return values


def placement(element: ElementTree.Element, at: str) -> np.ndarray:
    """Return the `(4, 4)` placement of an element's <origin>; identity where it has none."""
    origin = only(element, "origin", at)
    return np.eye(4) if origin is None else pose(origin, at)


def pose(origin: ElementTree.Element, at: str) -> np.ndarray:
    """Return the `(4, 4)` placement that an element's attributes xyz and rpy describe."""
    if origin.get("quat_xyzw") is not None:
        raise ModelError(f"{at}: origin quat_xyzw is not read; write rpy instead")
    result = np.eye(4)
    result[:3, 3] = numbers(origin.get("xyz"), 3, "0 0 0", f"{at}: origin xyz")
    roll, pitch, yaw = numbers(origin.get("rpy"), 3, "0 0 0", f"{at}: origin rpy")
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    result[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return result


def axis_of(element: ElementTree.Element, at: str, tag: str = "axis") -> np.ndarray:
    """Return the `(3,)` unit axis of an element."""
    found = only(element, tag, at)
    axis = numbers(None if found is None else found.get("xyz"), 3, "1 0 0", f"{at}: {tag} xyz")
    length = float(np.linalg.norm(axis))
    # Of shorter ones the squares, and at last the numbers themselves, lose digits.
    if length < 1.0 / GREATEST:
        raise ModelError(
            f"{at}: the {tag} {axis.tolist()} has no direction; its length is to be 1 and may be "
            f"from {1.0 / GREATEST:.0e} to {GREATEST:.0e}"
        )
    return axis / length


def loop(
    element: ElementTree.Element, sides: Iterable[str], links: Collection[str], where: str
) -> LoopDescription:
    """Return a loop from an element that names a link and a placement for each side.

    Args:
        element: with `name`, `type`, a child per side, and `<axis>`.
        sides: tags of the predecessor's and the successor's child.
        links: names of all links.
        where: how messages name the source of the text.
    """
    name = name_of(element, where)
    at = f"{where}: {element.tag} {name!r}"
    kind = element.get("type")
    if kind not in LOOP_TYPES:
        raise ModelError(f"{at}: type {kind!r} is not supported; types: {choices(LOOP_TYPES)}")
    predecessor, successor = (link_of(element, side, links, at) for side in sides)
    if predecessor == successor:
        raise ModelError(f"{at}: predecessor and successor are the same link {successor!r}")
    origins = [_end(only(element, side, at), at) for side in sides]
    axis = axis_2 = axis_of(element, at)
    if kind == "universal":
        axis_2 = axis_of(element, at, "axis2")
        if abs(float(axis @ axis_2)) > 1e-9:
            raise ModelError(
                f"{at}: a universal joint needs <axis> and <axis2> at right angles, not "
                f"{axis.tolist()} and {axis_2.tolist()}"
            )
    return LoopDescription(name, kind, predecessor, successor, origins[0], origins[1], axis, axis_2)


def _end(side: ElementTree.Element | None, at: str) -> np.ndarray:
    """Return the placement of a loop's frame in the link of a side."""
    if side is None:
        return np.eye(4)
    # URDF+ has an <origin> in each side; Isaac writes its attributes on the side itself.
    if side.find("origin") is None:
        return pose(side, at)
    if side.get("xyz") is not None or side.get("rpy") is not None:
        raise ModelError(f"{at}: <{side.tag}> has attributes xyz or rpy and an <origin>; keep one")
    return placement(side, at)
