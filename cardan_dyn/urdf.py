"""URDF: text with loops to a checked description.

Pinocchio's parser builds the tree. What it accepts silently and would turn into wrong numbers
(a link with two parents, a negative mass) is refused here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio

from . import notations
from .description import CouplingDescription, Description
from .elements import (
    JOINT_TYPES,
    axis_of,
    check_unique,
    link_of,
    name_of,
    names,
    numbers,
    placement,
)
from .errors import ModelError, choices

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
    links = names(robot, "link", where)
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
        name = name_of(joint, where)
        at = f"{where}: joint {name!r}"
        kind = joint.get("type")
        if kind not in JOINT_TYPES:
            raise ModelError(f"{at}: type {kind!r} is not supported; types: {choices(JOINT_TYPES)}")
        parent = link_of(joint, "parent", links, at)
        child = link_of(joint, "child", links, at)
        if child in parent_joint:
            raise ModelError(
                f"{at}: link {child!r} has two parents, joints {parent_joint[child]!r} and "
                f"{name!r}; a URDF is a tree: write one of them as <loop>"
            )
        parent_joint[child] = name
        children[parent].append(child)
        joints[name] = kind
        placement(joint, at)
        axes[name] = np.array([1.0, 0.0, 0.0]) if kind == "fixed" else axis_of(joint, at)
    names(robot, "joint", where)
    extra = notations.gepetto(path, robot, joints) if path is not None else None
    if extra is not None:
        joints.update(extra.joint_types)
    loops, notation = notations.agreed(robot, links, extra, where)
    couplings = tuple(_coupling(item, links, where) for item in robot.findall("coupling"))
    named = [*joints, *(loop.name for loop in loops), *(item.name for item in couplings)]
    check_unique(named, "joint or loop", where)
    independent = tuple(
        name_of(joint, where) for joint in robot.findall("joint") if _flag(joint, where)
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
    name = name_of(element, where)
    at = f"{where}: coupling {name!r}"
    ends = [link_of(element, side, links, at) for side in ("predecessor", "successor")]
    found = element.find("ratio")
    value = None if found is None else found.get("value")
    ratio = float(numbers(value, 1, "", f"{at}: ratio value")[0])
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


def _check_inertial(link: ElementTree.Element, at: str, strict: bool) -> str:
    """Check a link's inertia; return what is wrong with it where that is to be accepted.

    A massless inertia that is accepted is taken out of the link.
    """
    inertial = link.find("inertial")
    if inertial is None:
        return ""
    placement(inertial, at)
    mass_element, inertia_element = inertial.find("mass"), inertial.find("inertia")
    if mass_element is None or inertia_element is None:
        raise ModelError(f"{at}: <inertial> needs <mass> and <inertia>; a massless link has none")
    mass = float(numbers(mass_element.get("value"), 1, "", f"{at}: mass")[0])
    if mass == 0.0 and not strict:
        link.remove(inertial)
        return f"{at}: mass 0 kg: taken as massless"
    if mass <= 0.0:
        raise ModelError(
            f"{at}: mass {mass:g} kg is not positive; a massless link has no <inertial>"
            + ("; load(..., strict=False) takes zero for that" if mass == 0.0 else "")
        )
    xx, yy, zz, xy, xz, yz = (
        float(numbers(inertia_element.get(name), 1, "0", f"{at}: inertia {name}")[0])
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
