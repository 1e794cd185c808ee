"""Read: URDF text with loops to checked, plain data.

Pinocchio's parser builds the tree. What it accepts silently and would turn into wrong numbers
(a link with two parents, a negative mass, an unknown way of writing a loop) is refused here.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from .errors import ModelError, choices

JOINT_TYPES = frozenset({"revolute", "continuous", "prismatic", "fixed", "planar", "floating"})
"""Types of tree joints that can be loaded."""
LOOP_TYPES = frozenset(
    {
        *("revolute", "continuous", "prismatic", "fixed", "planar"),
        *("spherical", "universal", "cylindrical"),
    }
)
"""Types of loops that can be closed."""
FOREIGN_LOOPS = ("coupling", "loop_joint")
"""Elements of other notations that close chains and must not be ignored silently."""

_INERTIA_TOLERANCE = 1e-9
"""Relative violation of the triangle inequality that rounding in a file may cause."""


@dataclass(frozen=True)
class LoopDescription:
    """A closure between two links, in URDF+ notation.

    Attributes:
        name: name of the joint that the loop is.
        type: one of `LOOP_TYPES`.
        predecessor, successor: names of the two links.
        predecessor_origin, successor_origin: `(4, 4)` placements of the joint frame in the links
            [m]. The coordinate is zero where both coincide.
        axis: `(3,)` unit vector in the joint frame.
        axis_2: `(3,)` second axis of a `universal` joint, normal to the first; else the first.
    """

    name: str
    type: str
    predecessor: str
    successor: str
    predecessor_origin: np.ndarray
    successor_origin: np.ndarray
    axis: np.ndarray
    axis_2: np.ndarray


@dataclass(frozen=True)
class Description:
    """A checked description.

    Attributes:
        name: name of the mechanism.
        urdf: the text, as Pinocchio reads it.
        links: names of the links in file order.
        joints: names of the tree joints to their types.
        axes: `(3,)` unit axis of each tree joint in its joint frame.
        loops: the closures in file order.
        root: name of the link without a parent.
    """

    name: str
    urdf: str
    links: tuple[str, ...]
    joints: dict[str, str]
    axes: dict[str, np.ndarray]
    loops: tuple[LoopDescription, ...]
    root: str


def bundled_directory() -> Path:
    """Return the directory of the bundled descriptions.

    A wheel carries it inside the package; in a checkout it stands beside the package.
    """
    inside = Path(__file__).parent / "urdf"
    return inside if inside.is_dir() else Path(__file__).parent.parent / "urdf"


def bundled_names() -> list[str]:
    """Return the names of the bundled descriptions that `load` accepts."""
    return sorted(path.stem for path in bundled_directory().glob("*.urdf"))


def read(source: str | os.PathLike[str]) -> Description:
    """Read a bundled description by name, a file by path, or URDF text.

    Args:
        source: name in `bundled_names()`, path, or text that starts with `<`.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    if not isinstance(source, (str, os.PathLike)):
        raise ModelError(
            f"load() takes a name, a path or URDF text, not {type(source).__name__}; "
            f"bundled descriptions: {choices(bundled_names())}"
        )
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        return parse(source.lstrip("\ufeff \t\r\n"), where="URDF text")
    path = _find(os.fspath(source))
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"{path}: cannot be read as text ({error})") from error
    return parse(text, where=str(path))


def _find(name: str) -> Path:
    bundled = bundled_directory() / f"{name}.urdf"
    if name in bundled_names():
        return bundled
    path = Path(name)
    try:
        found = path.is_file()
    except (OSError, ValueError):
        found = False
    if not found:
        raise ModelError(
            f"no description {name!r}: it is neither a file nor a bundled name; "
            f"bundled descriptions: {choices(bundled_names())}"
        )
    return path


def parse(text: str, where: str) -> Description:
    """Parse and check URDF text.

    Args:
        text: the URDF.
        where: how messages name the source of the text.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    try:
        robot = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise ModelError(f"{where}: malformed XML: {error}") from error
    if robot.tag != "robot":
        raise ModelError(f"{where}: the outermost element is <{robot.tag}>, expected <robot>")
    for tag in FOREIGN_LOOPS:
        if robot.find(tag) is not None:
            raise ModelError(
                f"{where}: <{tag}> is not supported; close chains with <loop> of the types "
                f"{choices(LOOP_TYPES)}"
            )

    links = _names(robot, "link", where)
    if not links:
        raise ModelError(f"{where}: there is no <link>")
    for link in robot.findall("link"):
        _check_inertial(link, f"{where}: link {link.get('name')!r}")

    joints: dict[str, str] = {}
    axes: dict[str, np.ndarray] = {}
    parent_joint: dict[str, str] = {}
    children: dict[str, list[str]] = {link: [] for link in links}
    for joint in robot.findall("joint"):
        name = _name(joint, where)
        at = f"{where}: joint {name!r}"
        kind = joint.get("type")
        if kind not in JOINT_TYPES:
            raise ModelError(f"{at}: type {kind!r} is not supported; types: {choices(JOINT_TYPES)}")
        parent = _link_of(joint, "parent", links, at)
        child = _link_of(joint, "child", links, at)
        if child in parent_joint:
            raise ModelError(
                f"{at}: link {child!r} has two parents, joints {parent_joint[child]!r} and "
                f"{name!r}; a URDF is a tree: write one of them as <loop>"
            )
        parent_joint[child] = name
        children[parent].append(child)
        joints[name] = kind
        _placement(joint, at)
        axes[name] = _axis(joint, at)
    loops = tuple(_loop(element, links, where) for element in robot.findall("loop"))
    _check_unique([*joints, *(loop.name for loop in loops)], "joint or loop", where)
    _names(robot, "joint", where)

    roots = [link for link in links if link not in parent_joint]
    if len(roots) != 1:
        detail = f"links without a parent: {choices(roots)}" if roots else "the joints form a ring"
        raise ModelError(f"{where}: a URDF has exactly one root link; {detail}")
    reached = {roots[0]}
    queue = [roots[0]]
    while queue:
        for child in children[queue.pop()]:
            reached.add(child)
            queue.append(child)
    if len(reached) != len(links):
        lost = choices(set(links) - reached)
        raise ModelError(
            f"{where}: not connected to the root {roots[0]!r}: {lost}; "
            "their joints form a ring: write one of them as <loop>"
        )
    return Description(
        name=robot.get("name") or "mechanism",
        urdf=_tree_only(robot),
        links=tuple(links),
        joints=joints,
        axes=axes,
        loops=loops,
        root=roots[0],
    )


def _tree_only(robot: ElementTree.Element) -> str:
    """Return the text for Pinocchio: without loops, and without what only a viewer needs."""
    tree = ElementTree.Element("robot", {"name": robot.get("name") or "mechanism"})
    for element in robot:
        if element.tag == "link":
            link = ElementTree.SubElement(tree, "link", element.attrib)
            link.extend(element.findall("inertial"))
        elif element.tag == "joint":
            tree.append(element)
    return ElementTree.tostring(tree, encoding="unicode")


def _names(robot: ElementTree.Element, tag: str, where: str) -> list[str]:
    names = [_name(element, where) for element in robot.findall(tag)]
    _check_unique(names, tag, where)
    return names


def _check_unique(names: list[str], what: str, where: str) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise ModelError(f"{where}: {what} names that occur twice: {choices(twice)}")


def _name(element: ElementTree.Element, where: str) -> str:
    name = element.get("name")
    if not name:
        raise ModelError(f"{where}: a <{element.tag}> has no name")
    return name


def _link_of(element: ElementTree.Element, tag: str, links: list[str], at: str) -> str:
    found = element.find(tag)
    if found is None or not found.get("link"):
        raise ModelError(f'{at}: <{tag} link="..."/> is missing')
    name = found.get("link", "")
    if name not in links:
        raise ModelError(f"{at}: {tag} link {name!r} does not exist; links: {choices(links)}")
    return name


def _numbers(text: str | None, count: int, default: str, at: str) -> np.ndarray:
    words = (default if text is None else text).split()
    try:
        values = np.array([float(word) for word in words])
    except ValueError as error:
        raise ModelError(f"{at}: {text!r} is not {count} number(s)") from error
    if values.size != count or not np.all(np.isfinite(values)):
        raise ModelError(f"{at}: {text!r} is not {count} finite number(s)")
    return values


def _placement(element: ElementTree.Element, at: str) -> np.ndarray:
    """Return the `(4, 4)` placement of an element's <origin>; identity where it has none."""
    origin = element.find("origin")
    placement = np.eye(4)
    if origin is None:
        return placement
    placement[:3, 3] = _numbers(origin.get("xyz"), 3, "0 0 0", f"{at}: origin xyz")
    roll, pitch, yaw = _numbers(origin.get("rpy"), 3, "0 0 0", f"{at}: origin rpy")
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    placement[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return placement


def _axis(element: ElementTree.Element, at: str, tag: str = "axis") -> np.ndarray:
    found = element.find(tag)
    axis = _numbers(None if found is None else found.get("xyz"), 3, "1 0 0", f"{at}: {tag} xyz")
    length = float(np.linalg.norm(axis))
    if length == 0.0 or not math.isfinite(length):
        raise ModelError(f"{at}: the {tag} {axis.tolist()} has no direction")
    return axis / length


def _loop(element: ElementTree.Element, links: list[str], where: str) -> LoopDescription:
    name = _name(element, where)
    at = f"{where}: loop {name!r}"
    kind = element.get("type")
    if kind not in LOOP_TYPES:
        raise ModelError(f"{at}: type {kind!r} is not supported; types: {choices(LOOP_TYPES)}")
    predecessor = _link_of(element, "predecessor", links, at)
    successor = _link_of(element, "successor", links, at)
    if predecessor == successor:
        raise ModelError(f"{at}: predecessor and successor are the same link {successor!r}")
    sides = [element.find(side) for side in ("predecessor", "successor")]
    origins = [_placement(side, at) for side in sides if side is not None]
    axis = axis_2 = _axis(element, at)
    if kind == "universal":
        axis_2 = _axis(element, at, "axis2")
        if abs(float(axis @ axis_2)) > 1e-9:
            raise ModelError(
                f"{at}: a universal joint needs <axis> and <axis2> at right angles, not "
                f"{axis.tolist()} and {axis_2.tolist()}"
            )
    return LoopDescription(name, kind, predecessor, successor, origins[0], origins[1], axis, axis_2)


def _check_inertial(link: ElementTree.Element, at: str) -> None:
    inertial = link.find("inertial")
    if inertial is None:
        return
    _placement(inertial, at)
    mass_element, inertia_element = inertial.find("mass"), inertial.find("inertia")
    if mass_element is None or inertia_element is None:
        raise ModelError(f"{at}: <inertial> needs <mass> and <inertia>; a massless link has none")
    mass = float(_numbers(mass_element.get("value"), 1, "", f"{at}: mass")[0])
    if mass <= 0.0:
        raise ModelError(
            f"{at}: mass {mass:g} kg is not positive; a massless link has no <inertial>"
        )
    xx, yy, zz, xy, xz, yz = (
        float(_numbers(inertia_element.get(name), 1, "0", f"{at}: inertia {name}")[0])
        for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    small, middle, large = np.linalg.eigvalsh(tensor)
    slack = _INERTIA_TOLERANCE * abs(large)
    if small < -slack:
        raise ModelError(f"{at}: the inertia has a negative principal moment {small:g} kg·m²")
    if small + middle < large - slack:
        raise ModelError(
            f"{at}: principal moments {small:g}, {middle:g}, {large:g} kg·m² violate the triangle "
            "inequality: the greatest exceeds the sum of the other two, which no body can have"
        )
