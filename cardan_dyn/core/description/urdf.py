"""URDF: text with loops to a checked description.

Other readers accept a link with two parents, a negative mass or text in the place of a number, and
compute wrong results from it without a message. All of that is refused here.

Beyond URDF, the types of loops (`spherical`, `universal`, `cylindrical`) are read as types of tree
joints too, a universal one with its second axis in `<axis2>`; and a limit may be infinite: `inf`
for velocity, effort and upper, `-inf` for lower; so it is from 1e50 on. `least_effort` is the
least effort where it is not the greatest one in the other sense.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from .beside import ChangedType, file_beside, unread_files
from .description import (
    X_AXIS,
    CouplingDescription,
    Description,
    JointDescription,
    Limits,
    LinkDescription,
    SourceText,
)
from .elements import (
    ADDED_TYPES,
    JOINT_TYPES,
    LEAST_MASS,
    TREE_TYPES,
    adjustable_type,
    armature_of,
    axes_of,
    bound,
    check_size,
    check_unique,
    dynamics_of,
    link_of,
    name_of,
    names,
    number,
    only,
    placement,
)
from .left_out import elements_left_out
from .notations import agreed
from .words import check_words

_INERTIA_TOLERANCE = 1e-9
"""Violation of the triangle inequality, relative to the greatest principal moment, that rounding in
a file with ten or more digits may cause."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of `<inertia>`, in the order in which `tensor_of` takes them."""
_LEAST = ("lower", "least_effort")
"""Attributes of `<limit>` that bound from below."""
_UNLIMITED = {-1.0: "-inf", 1.0: "inf"}
"""Side of a limit to the word that says that there is none."""


def parse(robot: Element, given: SourceText, where: str, strict: bool) -> Description:
    """Check a URDF and the loops that belong to it.

    Args:
        robot: its outermost element.
        given: its text, and the file, beside which a YAML file may list its loops.
        where: how messages name the source of the text.
        strict: whether to refuse what is probably wrong: inertias that no body can have, misspelled
            words.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    check_size(len(robot.findall("link")), where)
    unknown = check_words(robot, "urdf", where, strict)
    if not names(robot, "link", where):
        raise ModelError(f"{where}: there is no <link>")
    links, noted = zip(
        *(_link(element, where, strict) for element in robot.findall("link")), strict=True
    )
    warnings = filter(None, noted)
    # Thousands of joints ask whether a link exists: a dictionary answers without a search, and
    # keeps the links in file order.
    link_names = dict.fromkeys(link.name for link in links)
    path = given.path
    beside = None if path is None else file_beside(robot, where, path, strict)
    changed_types: Mapping[str, ChangedType] = {} if beside is None else beside.joint_types
    joints = [
        _joint(element, link_names, changed_types, where) for element in robot.findall("joint")
    ]
    if robot.find("transmission/actuator") is not None:
        from .transmissions import with_rotors  # Most descriptions state none.

        joints = with_rotors(robot, joints, where)
    if robot.find("ros2_control/joint/command_interface/param") is not None:
        from .transmissions import with_commanded_efforts

        joints = with_commanded_efforts(robot, joints, where)
    loops, notation, open_types = agreed(robot, link_names, beside, where, strict)
    left_out = elements_left_out(robot, where)
    if beside is not None:
        left_out += beside.warnings
    elif path is not None:
        left_out += unread_files(path)
    left_out += open_types
    couplings = [coupling(item, link_names, where) for item in robot.findall("coupling")]
    taken = [item.name for items in (loops, couplings) for item in items]
    solved = frozenset() if beside is None else beside.solved
    if robot.find("joint/mimic") is not None:
        from .mimics import mimics  # Most descriptions have none.

        mimicking, without = mimics(robot, joints, taken, where, solved)
        couplings += mimicking
        left_out += without
    named = [item.name for items in (joints, loops, couplings) for item in items]
    check_unique(named, "joint or loop", where)
    independent = _independent(robot, where)
    if beside is not None and not independent:
        independent = beside.motors
    if not independent:
        following = {item.successor for item in couplings}
        movable = {item.name for item in joints if item.type != "fixed"} - following
        independent = tuple(name for name in _motors(robot) if name in movable)
    check_tree(list(link_names), joints, where)
    return Description(
        name=robot.get("name") or "mechanism",
        links=links,
        joints=tuple(joints),
        order=tuple(sorted(joint.name for joint in joints)),
        loops=loops,
        couplings=tuple(couplings),
        independent_joints=independent,
        notation=notation,
        warnings=(*unknown, *warnings, *left_out),
        source=given if beside is None else replace(given, beside=beside.text),
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
    waiting = [roots[0]]
    while waiting:
        carried = children[waiting.pop()]
        reached.update(carried)
        waiting.extend(carried)
    if len(reached) != len(links):
        unreached = choices(set(links) - reached)
        raise ModelError(
            f"{where}: not connected to the root {roots[0]!r}: {unreached}; "
            "their joints form a ring: write one of them as <loop>"
        )


def check_inertia(mass: float, tensor: Array, at: str, strict: bool, massless: str) -> str:
    """Return why no body can have a mass and inertia; an empty text where one can.

    Args:
        mass: the mass [kg].
        tensor: the inertia `(3, 3)` about the centre of mass [kg·m²].
        at: how messages name it.
        strict: whether what no body can have is refused.
        massless: how the notation describes a massless link.

    Raises:
        ModelError: the mass is negative; or no body can have that, and `strict` refuses it; or the
            inertia has no principal moments.
    """
    accepted = "; load(..., strict=False) accepts it"
    if not mass >= LEAST_MASS and (strict or mass):
        raise ModelError(
            f"{at}: mass {mass:g} kg is not positive; a massless link has {massless}"
            f"{'' if mass else accepted}"
        )
    meaning = "an inertia without mass" if np.any(tensor) else "taken as massless"
    weightless = "" if mass else f"{at}: mass 0 kg: {meaning}"
    try:
        if not np.isfinite(tensor).all():
            raise ValueError("it is not finite")
        small, middle, large = np.linalg.eigvalsh(tensor).tolist()
    except ValueError as error:  # NumPy's LinAlgError is one of them.
        raise ModelError(f"{at}: the inertia has no principal moments ({error})") from error
    rounding = _INERTIA_TOLERANCE * abs(large)
    fault = ""
    if small < -rounding:
        fault = f"{at}: the inertia has a negative principal moment {small:g} kg·m²"
    elif small + middle < large - rounding:
        fault = (
            f"{at}: principal moments {small:g}, {middle:g}, {large:g} kg·m² violate the triangle "
            "inequality: the greatest exceeds the sum of the other two, which no body can have"
        )
    if fault and strict:
        raise ModelError(f"{fault}{accepted}")
    return "; ".join(filter(None, (weightless, fault)))


def _link(element: Element, where: str, strict: bool) -> tuple[LinkDescription, str]:
    name = element.get("name", "")
    at = f"{where}: link {name!r}"
    inertial = only(element, "inertial", at)
    if inertial is None:
        return LinkDescription(name), ""
    frame = placement(inertial, at)
    mass_element, inertia_element = only(inertial, "mass", at), only(inertial, "inertia", at)
    if mass_element is None or inertia_element is None:
        raise ModelError(f"{at}: <inertial> needs <mass> and <inertia>; a massless link has none")
    mass = number(mass_element.get("value"), "", f"{at}: mass")
    moments = [
        number(inertia_element.get(moment), "0", f"{at}: inertia {moment}") for moment in MOMENTS
    ]
    tensor = tensor_of(*moments)
    warning = check_inertia(mass, tensor, at, strict, "no <inertial>")
    rotation = frame[:3, :3]
    return LinkDescription(name, mass, frame[:3, 3], rotation @ tensor @ rotation.T), warning


def tensor_of(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> Array:
    """Return the symmetric `(3, 3)` matrix of an inertia's moments and products [kg·m²]."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _joint(
    element: Element,
    links: dict[str, None],
    changed_types: Mapping[str, ChangedType],
    where: str,
) -> JointDescription:
    name = name_of(element, where)
    at = f"{where}: joint {name!r}"
    kind = element.get("type")
    if kind not in TREE_TYPES:
        raise ModelError(
            f"{at}: type {kind!r} is not supported; types: {choices(JOINT_TYPES, kind)}, and "
            f"beyond URDF: {choices(ADDED_TYPES, kind)}"
        )
    changed = changed_types.get(name, ChangedType(kind))
    kind = changed.type
    adjustable = adjustable_type(element, kind, at)
    moving = adjustable or kind
    axis, axis_2 = changed.axes or (X_AXIS, X_AXIS)
    if not changed.axes and moving not in ("fixed", "floating"):
        axis, axis_2 = axes_of(element, moving, at)
    return JointDescription(
        name,
        kind,
        link_of(element, "parent", links, at),
        link_of(element, "child", links, at),
        placement(element, at),
        axis,
        axis_2,
        limits=_limits(element, kind, at),
        adjustable=adjustable,
        dynamics=dynamics_of(element, at),
        armature=armature_of(element, moving, at),
    )


def _limits(element: Element, kind: str, at: str) -> Limits:
    """Return the limits of a joint, which URDF takes as zero where `<limit>` does not state them.

    Without `<limit>` there are none. A `continuous` joint has no limits of position.
    """
    limit = only(element, "limit", at)
    if limit is None:
        return Limits()
    position = ("lower", "upper") if kind != "continuous" else ()
    given = ("least_effort",) if limit.get("least_effort") is not None else ()
    stated = (*position, "velocity", "effort", *given)
    return Limits(**{name: _limit(limit, name, at) for name in stated})


def _limit(element: Element, name: str, at: str) -> float:
    """Return a limit of a joint; infinite where it says so."""
    text = element.get(name)
    sign = -1.0 if name in _LEAST else 1.0
    if text == _UNLIMITED[sign]:
        return float(text)
    return bound(text, sign, "0", f"{at}: limit {name}")


def _independent(robot: Element, where: str) -> tuple[str, ...]:
    """Return names of the joints that are independent, in file order.

    URDF+ takes a joint for independent unless it says otherwise. In URDF joints say nothing, and
    not every one has a motor: so this holds only where some joint says that it is not.
    """
    marks = {name_of(joint, where): joint.get("independent") for joint in robot.findall("joint")}
    for name, mark in marks.items():
        if mark is not None and mark.lower() not in ("true", "false"):
            raise ModelError(
                f"{where}: joint {name!r}: independent is {mark!r}, expected true or false"
            )
    said = {name: mark.lower() == "true" for name, mark in marks.items() if mark is not None}
    if not all(said.values()):
        for joint in robot.findall("joint"):
            if joint.get("type") not in ("fixed", "floating") and joint.find("mimic") is None:
                said.setdefault(joint.get("name", ""), True)
    return tuple(name for name in marks if said.get(name))


def _motors(robot: Element) -> tuple[str, ...]:
    """Return names of the joints that `<transmission>` and `<ros2_control>` drive, in file order.

    Joints of the latter that only states are read of have no motor.
    """
    driven = (
        joint.get("name", "")
        for path in ("transmission/joint", "ros2_control/joint[command_interface]")
        for joint in robot.iterfind(path)
    )
    return tuple(dict.fromkeys(driven))


def coupling(element: Element, links: Collection[str], where: str) -> CouplingDescription:
    """Return the coupling of links that a `<coupling>` states.

    Raises:
        ModelError: what is wrong with it.
    """
    from .coupled_forces import with_forces  # Few descriptions have couplings.

    name = name_of(element, where)
    at = f"{where}: coupling {name!r}"
    if element.get("type", "rolling") != "rolling":
        raise ModelError(
            f"{at}: type {element.get('type')!r} is not supported; it is 'rolling', if it is stated"
        )
    predecessor, successor = (
        link_of(element, side, links, at) for side in ("predecessor", "successor")
    )
    ratio_element = only(element, "ratio", at)
    text = None if ratio_element is None else ratio_element.get("value")
    ratio = number(text, "", f"{at}: ratio value")
    return with_forces(CouplingDescription(name, predecessor, successor, ratio), element, at)
