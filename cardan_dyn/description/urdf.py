"""URDF: text with loops to a checked description.

What other readers accept silently and turn into wrong numbers (a link with two parents, a negative
mass, a number that is none) is refused here.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError, choices
from . import notations
from .description import CouplingDescription, Description, JointDescription, Limits, LinkDescription
from .elements import (
    JOINT_TYPES,
    axis_of,
    check_size,
    check_unique,
    link_of,
    name_of,
    names,
    numbers,
    only,
    placement,
)

_INERTIA_TOLERANCE = 1e-9
"""Relative violation of the triangle inequality that rounding in a file may cause."""
_LEAST_MASS = 1e-50
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


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
    check_size(len(robot.findall("link")), where)
    _check_namespaces(robot, where)
    links, warnings = _links(robot, where, strict)
    # A dictionary answers for thousands of links whether it has a name.
    known = dict.fromkeys(link.name for link in links)
    declared = names(robot, "joint", where)
    extra = None if path is None else notations.gepetto(path, robot, set(declared))
    types: Mapping[str, str] = {} if extra is None else extra.joint_types
    joints = [_joint(element, known, types, where, warnings) for element in robot.findall("joint")]
    loops, notation = notations.agreed(robot, known, extra, where)
    couplings = tuple(_coupling(item, known, where) for item in robot.findall("coupling"))
    named = [item.name for items in (joints, loops, couplings) for item in items]
    check_unique(named, "joint or loop", where)
    independent = tuple(
        name_of(joint, where) for joint in robot.findall("joint") if _flag(joint, where)
    )
    if extra is not None and not independent:
        independent = extra.motors
    check_tree(list(known), joints, where)
    return Description(
        name=robot.get("name") or "mechanism",
        links=tuple(links),
        joints=tuple(joints),
        order=tuple(sorted(joint.name for joint in joints)),
        loops=loops,
        couplings=couplings,
        independent_joints=independent,
        notation=notation,
        warnings=tuple(warnings),
    )


_READ = frozenset(
    {
        *("link", "inertial", "mass", "inertia", "origin"),
        *("joint", "parent", "child", "axis", "axis2", "limit", "dynamics", "coupling", "ratio"),
        *("loop", "predecessor", "successor", "loop_joint", "link1", "link2"),
    }
)
"""Elements that are read."""


def _check_namespaces(robot: ElementTree.Element, where: str) -> None:
    """Refuse elements that would be read but for their namespace, and what is to be processed.

    Others' extensions, in their own namespace or none, are left alone.
    """
    waiting = [robot]
    while waiting:
        for element in waiting.pop():
            if element.tag in _READ:
                waiting.append(element)
            space, _, name = element.tag.rpartition("}")
            if "xacro" in space:
                raise ModelError(
                    f"{where}: <xacro:{name}> is to be processed first: xacro FILE > FILE.urdf"
                )
            if space and name in _READ:
                raise ModelError(
                    f"{where}: <{name}> stands in the namespace {space[1:]!r}, where no reader of "
                    "URDF looks for it; take it out of there"
                )


def check_tree(links: list[str], joints: list[JointDescription], where: str) -> None:
    """Refuse joints that do not connect all links as a tree.

    Raises:
        ModelError: two parents, a ring, or several roots.
    """
    parent_joint: dict[str, str] = {}
    children: dict[str, list[str]] = {link: [] for link in links}
    for joint in joints:
        if joint.child in parent_joint:
            raise ModelError(
                f"{where}: joint {joint.name!r}: link {joint.child!r} has two parents, joints "
                f"{parent_joint[joint.child]!r} and {joint.name!r}; a URDF is a tree: write one "
                "of them as <loop>"
            )
        parent_joint[joint.child] = joint.name
        children[joint.parent].append(joint.child)
    roots = [link for link in links if link not in parent_joint]
    if len(roots) != 1:
        detail = f"links without a parent: {choices(roots)}" if roots else "the joints form a ring"
        raise ModelError(f"{where}: a URDF has exactly one root link; {detail}")
    reached = {roots[0]}
    queue = [roots[0]]
    while queue:
        found = children[queue.pop()]
        reached.update(found)
        queue.extend(found)
    if len(reached) != len(links):
        lost = choices(set(links) - reached)
        raise ModelError(
            f"{where}: not connected to the root {roots[0]!r}: {lost}; "
            "their joints form a ring: write one of them as <loop>"
        )


def check_inertia(tensor: np.ndarray, at: str, strict: bool) -> str:
    """Return what is wrong with an inertia `(3, 3)`, where that is accepted.

    Raises:
        ModelError: something is wrong with it, and it is not.
    """
    try:
        if not np.all(np.isfinite(tensor)):
            raise ValueError("it is not finite")
        small, middle, large = np.linalg.eigvalsh(tensor)
    except ValueError as error:  # NumPy's LinAlgError among them.
        raise ModelError(f"{at}: the inertia has no principal moments ({error})") from error
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


def _links(
    robot: ElementTree.Element, where: str, strict: bool
) -> tuple[list[LinkDescription], list[str]]:
    """Return the links, and what is wrong with them and was accepted."""
    if not names(robot, "link", where):
        raise ModelError(f"{where}: there is no <link>")
    links, warnings = [], []
    for element in robot.findall("link"):
        link, warning = _link(element, where, strict)
        links.append(link)
        if warning:
            warnings.append(warning)
    return links, warnings


def _link(element: ElementTree.Element, where: str, strict: bool) -> tuple[LinkDescription, str]:
    name = element.get("name", "")
    at = f"{where}: link {name!r}"
    inertial = only(element, "inertial", at)
    if inertial is None:
        return LinkDescription(name), ""
    frame = placement(inertial, at)
    mass_element, inertia_element = only(inertial, "mass", at), only(inertial, "inertia", at)
    if mass_element is None or inertia_element is None:
        raise ModelError(f"{at}: <inertial> needs <mass> and <inertia>; a massless link has none")
    mass = float(numbers(mass_element.get("value"), 1, "", f"{at}: mass")[0])
    if mass == 0.0 and not strict:
        return LinkDescription(name), f"{at}: mass 0 kg: taken as massless"
    if mass < _LEAST_MASS:
        raise ModelError(
            f"{at}: mass {mass:g} kg is not positive; a massless link has no <inertial>"
            + ("; load(..., strict=False) takes zero for that" if mass == 0.0 else "")
        )
    xx, yy, zz, xy, xz, yz = (
        float(numbers(inertia_element.get(moment), 1, "0", f"{at}: inertia {moment}")[0])
        for moment in _MOMENTS
    )
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    warning = check_inertia(tensor, at, strict)
    rotation = frame[:3, :3]
    return LinkDescription(name, mass, frame[:3, 3], rotation @ tensor @ rotation.T), warning


def _joint(
    element: ElementTree.Element,
    links: dict[str, None],
    types: Mapping[str, str],
    where: str,
    warnings: list[str],
) -> JointDescription:
    """Return a joint; `types` has the types that some get from a file beside the URDF."""
    name = name_of(element, where)
    at = f"{where}: joint {name!r}"
    kind = element.get("type")
    if kind not in JOINT_TYPES:
        raise ModelError(f"{at}: type {kind!r} is not supported; types: {choices(JOINT_TYPES)}")
    kind = types.get(name, kind)
    axis = np.array([1.0, 0.0, 0.0]) if kind == "fixed" else axis_of(element, at)
    dynamics = only(element, "dynamics", at)
    acting = (
        {}
        if dynamics is None
        else {
            key: value
            for key in ("damping", "friction")
            if (value := float(numbers(dynamics.get(key), 1, "0", f"{at}: dynamics {key}")[0]))
        }
    )
    if element.find("mimic") is not None:
        warnings.append(f"{at}: <mimic> left out: write the gear as <coupling>")
    if acting:
        listed = ", ".join(f"{key} {value:g}" for key, value in acting.items())
        warnings.append(f"{at}: {listed} of <dynamics> left out: wrenches are without friction")
    return JointDescription(
        name=name,
        type=kind,
        parent=link_of(element, "parent", links, at),
        child=link_of(element, "child", links, at),
        origin=placement(element, at),
        axis=axis,
        axis_2=axis,
        limits=_limits(element, kind, at),
    )


def _limits(element: ElementTree.Element, kind: str, at: str) -> Limits:
    found = only(element, "limit", at)
    if found is None:
        return Limits()

    def limit(name: str, default: str) -> float:
        return float(numbers(found.get(name), 1, default, f"{at}: limit {name}")[0])

    velocity, effort = limit("velocity", "0"), limit("effort", "0")
    if kind == "continuous":
        return Limits(velocity=velocity, effort=effort)
    return Limits(limit("lower", "0"), limit("upper", "0"), velocity, effort)


def _flag(joint: ElementTree.Element, where: str) -> bool:
    value = joint.get("independent", "false").lower()
    if value not in ("true", "false"):
        raise ModelError(
            f"{where}: joint {joint.get('name')!r}: independent is {value!r}, "
            "expected true or false"
        )
    return value == "true"


def _coupling(
    element: ElementTree.Element, links: dict[str, None], where: str
) -> CouplingDescription:
    name = name_of(element, where)
    at = f"{where}: coupling {name!r}"
    ends = [link_of(element, side, links, at) for side in ("predecessor", "successor")]
    found = only(element, "ratio", at)
    value = None if found is None else found.get("value")
    ratio = float(numbers(value, 1, "", f"{at}: ratio value")[0])
    if ratio == 0.0:
        raise ModelError(f"{at}: a ratio of zero would hold the successor, not couple it")
    return CouplingDescription(name, ends[0], ends[1], ratio)
