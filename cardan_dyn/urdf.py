"""URDF: text with loops to a checked description.

Pinocchio's parser builds the tree. What it accepts silently and would turn into wrong numbers
(a link with two parents, a negative mass) is refused here.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio

from .description import CouplingDescription, Description, LoopDescription
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

_INERTIA_TOLERANCE = 1e-9
"""Relative violation of the triangle inequality that rounding in a file may cause."""


def parse(robot: ElementTree.Element, where: str, path: Path | None, strict: bool) -> Description:
    """Check a URDF and the loops that belong to it.

    Args:
        robot: its outermost element.
        where: how messages name the source of the text.
        path: the file, beside which Gepetto's YAML file may stand.
        strict: whether inertias that no body can have are refused.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    from . import notations

    links = _names(robot, "link", where)
    if not links:
        raise ModelError(f"{where}: there is no <link>")
    remarks = [
        remark
        for link in robot.findall("link")
        if (remark := _check_inertial(link, f"{where}: link {link.get('name')!r}", strict))
    ]

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
        axes[name] = np.array([1.0, 0.0, 0.0]) if kind == "fixed" else _axis(joint, at)
    _names(robot, "joint", where)
    extra = notations.gepetto(path, robot, joints) if path is not None else None
    if extra is not None:
        joints.update(extra.joint_types)
    loops, notation = notations.agreed(robot, links, extra, where)
    couplings = tuple(_coupling(item, links, where) for item in robot.findall("coupling"))
    named = [*joints, *(loop.name for loop in loops), *(item.name for item in couplings)]
    check_unique(named, "joint or loop", where)
    independent = tuple(
        _name(joint, where) for joint in robot.findall("joint") if _flag(joint, where)
    )
    if extra is not None and not independent:
        independent = extra.motors

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
        tree=_tree_builder(_tree_only(robot, joints), where),
        links=tuple(links),
        joints=joints,
        axes=axes,
        loops=loops,
        couplings=couplings,
        independent=independent,
        notation=notation,
        remarks=tuple(remarks),
    )


def _tree_builder(text: str, where: str) -> Callable[[], pinocchio.Model]:
    def build() -> pinocchio.Model:
        try:
            return pinocchio.buildModelFromXML(text)
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"{where}: Pinocchio cannot build the tree: {error}") from error

    return build


def _flag(joint: ElementTree.Element, where: str) -> bool:
    value = joint.get("independent", "false").lower()
    if value not in ("true", "false"):
        raise ModelError(
            f"{where}: joint {joint.get('name')!r}: independent is {value!r}, "
            "expected true or false"
        )
    return value == "true"


def _coupling(element: ElementTree.Element, links: list[str], where: str) -> CouplingDescription:
    name = _name(element, where)
    at = f"{where}: coupling {name!r}"
    ends = [_link_of(element, side, links, at) for side in ("predecessor", "successor")]
    found = element.find("ratio")
    value = None if found is None else found.get("value")
    ratio = float(_numbers(value, 1, "", f"{at}: ratio value")[0])
    if ratio == 0.0:
        raise ModelError(f"{at}: a ratio of zero would hold the successor, not couple it")
    return CouplingDescription(name, ends[0], ends[1], ratio)


def _tree_only(robot: ElementTree.Element, types: dict[str, str]) -> str:
    """Return the text for Pinocchio: without loops, and without what only a viewer needs.

    Joints of types that its parser does not know stand in it as `floating`.
    """
    tree = ElementTree.Element("robot", {"name": robot.get("name") or "mechanism"})
    for element in robot:
        if element.tag == "link":
            link = ElementTree.SubElement(tree, "link", element.attrib)
            link.extend(element.findall("inertial"))
        elif element.tag == "joint":
            kind = types[element.get("name", "")]
            copied = ElementTree.SubElement(tree, "joint", element.attrib)
            copied.extend(list(element))
            copied.set("type", kind if kind in JOINT_TYPES else "floating")
    return ElementTree.tostring(tree, encoding="unicode")


def _names(robot: ElementTree.Element, tag: str, where: str) -> list[str]:
    names = [_name(element, where) for element in robot.findall(tag)]
    check_unique(names, tag, where)
    return names


def check_unique(names: list[str], what: str, where: str) -> None:
    """Refuse names that occur twice."""
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
    return np.eye(4) if origin is None else _pose(origin, at)


def _pose(origin: ElementTree.Element, at: str) -> np.ndarray:
    """Return the `(4, 4)` placement that an element's attributes xyz and rpy describe."""
    placement = np.eye(4)
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


def loop(
    element: ElementTree.Element, sides: Iterable[str], links: list[str], where: str
) -> LoopDescription:
    """Return a loop from an element that names a link and a placement for each side.

    Args:
        element: with `name`, `type`, a child per side, and `<axis>`.
        sides: tags of the predecessor's and the successor's child.
        links: names of all links.
        where: how messages name the source of the text.
    """
    name = _name(element, where)
    at = f"{where}: {element.tag} {name!r}"
    kind = element.get("type")
    if kind not in LOOP_TYPES:
        raise ModelError(f"{at}: type {kind!r} is not supported; types: {choices(LOOP_TYPES)}")
    predecessor, successor = (_link_of(element, side, links, at) for side in sides)
    if predecessor == successor:
        raise ModelError(f"{at}: predecessor and successor are the same link {successor!r}")
    # URDF+ has an <origin> in each side; Isaac writes its attributes on the side itself.
    children = [child for side in sides if (child := element.find(side)) is not None]
    origins = [
        _placement(child, at) if child.find("origin") is not None else _pose(child, at)
        for child in children
    ]
    axis = axis_2 = _axis(element, at)
    if kind == "universal":
        axis_2 = _axis(element, at, "axis2")
        if abs(float(axis @ axis_2)) > 1e-9:
            raise ModelError(
                f"{at}: a universal joint needs <axis> and <axis2> at right angles, not "
                f"{axis.tolist()} and {axis_2.tolist()}"
            )
    return LoopDescription(name, kind, predecessor, successor, origins[0], origins[1], axis, axis_2)


def _check_inertial(link: ElementTree.Element, at: str, strict: bool) -> str:
    """Check a link's inertia; return what is wrong with it where that is to be accepted.

    A massless inertia that is accepted is taken out of the link.
    """
    inertial = link.find("inertial")
    if inertial is None:
        return ""
    _placement(inertial, at)
    mass_element, inertia_element = inertial.find("mass"), inertial.find("inertia")
    if mass_element is None or inertia_element is None:
        raise ModelError(f"{at}: <inertial> needs <mass> and <inertia>; a massless link has none")
    mass = float(_numbers(mass_element.get("value"), 1, "", f"{at}: mass")[0])
    if mass == 0.0 and not strict:
        link.remove(inertial)
        return f"{at}: mass 0 kg: taken as massless"
    if mass <= 0.0:
        raise ModelError(
            f"{at}: mass {mass:g} kg is not positive; a massless link has no <inertial>"
            + ("; load(..., strict=False) takes zero for that" if mass == 0.0 else "")
        )
    xx, yy, zz, xy, xz, yz = (
        float(_numbers(inertia_element.get(name), 1, "0", f"{at}: inertia {name}")[0])
        for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    small, middle, large = np.linalg.eigvalsh(tensor)
    slack = _INERTIA_TOLERANCE * abs(large)
    wrong = ""
    if small < -slack:
        wrong = f"{at}: the inertia has a negative principal moment {small:g} kg·m²"
    elif small + middle < large - slack:
        wrong = (
            f"{at}: principal moments {small:g}, {middle:g}, {large:g} kg·m² violate the triangle "
            "inequality: the greatest exceeds the sum of the other two, which no body can have"
        )
    if wrong and strict:
        raise ModelError(f"{wrong}; load(..., strict=False) accepts it")
    return wrong
