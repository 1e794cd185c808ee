"""Second reading: the numbers of a text, read once more for the proof.

A proof that took its masses and lengths from where the solution has them could not detect an error
that was made when they were read. So the text is read a second time, by code that shares nothing
with the first reader; what the first reader checked is not checked again. Of the files beside a
URDF, only `loop_closures.yaml` has numbers; Gepetto's names frames.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, fromstring

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ...kit.errors import ModelError
from .description import (
    GUESTS,
    CouplingDescription,
    Description,
    LinkDescription,
    Mesh,
    at_last_parts,
    kinds_of,
)

if TYPE_CHECKING:
    from .description import (
        JointDescription,
        JointOrLoop,
        LoopDescription,
    )


_VANISHING = 1e-150
"""Mass [kg] below which a lenient reading takes it as zero: its square is no double."""


def reread(description: Description) -> Description:
    """Return a description with the numbers of its text: masses, origins, axes, ratios.

    Loops and couplings that were added are read from their own text, frames that were displaced are
    displaced again, and lengths and angles that can move can do so again.
    """
    if description.origins:
        from .origins import with_origins, without_origins

        return with_origins(reread(without_origins(description)), description.origins)
    by = {item[:2]: item.matrix for item in description.displacements}
    result = description.undisplaced() if by else description
    result = _with_added(result) if result.added else _reread(result)
    return result.displaced(by) if by else result


def _with_added(description: Description) -> Description:
    """Return a description with the numbers of its source and of what was added to it."""
    stated = {item.attrib["name"]: item for item in fromstring(description.added)}

    before: dict[str, Any] = {"loops": (), "couplings": ()}
    added: dict[str, Any] = {"loops": (), "couplings": ()}
    for kind, read in (("loops", _loop), ("couplings", _coupling)):
        for item in getattr(description, kind):
            follows = getattr(item, "of_joints", False)
            element = stated.get(item.successor if follows else item.name)
            if element is None:
                before[kind] += (item,)
            else:
                added[kind] += (read(item, element),)
    kept = _reread(replace(description, **before))
    return replace(kept, **{kind: getattr(kept, kind) + items for kind, items in added.items()})


def _by(guest: str) -> Any:
    """Return the second reading of a package."""
    return import_module(f"{guest}.second_reading")


def _reread(description: Description) -> Description:
    """Return a description with the numbers of its source."""
    given, source = description.source, description.text
    if given is not None and given.guest:
        again: Description = _by(given.guest).reread(description, given)
        return again
    if source is None:
        return description
    robot = fromstring(source.text)
    links, joints, loops, couplings = (
        {item.attrib["name"]: item for tag in tags for item in robot.findall(tag)}
        # Where notations close the same loops, the one that is used comes last and replaces others.
        for tags in (
            ("link",),
            ("joint",),
            ("constraint", "loop_joint", "loop"),
            ("coupling",),
        )
    )
    rotors = _rotors(robot)
    placed = tuple(
        replace(
            _joint(joint, joints[joint.name]),
            armature=_armature(joint, joints[joint.name], rotors.get(joint.name, 0.0)),
        )
        for joint in description.joints
    )
    # In the order in which the first reading looks for one notation that it uses.
    elsewhere: dict[str, LoopDescription] = {}
    others = [loop for loop in description.loops if loop.name not in loops]
    if robot.find("gazebo/joint") is not None:
        elsewhere = _by(GUESTS["sdf"]).loops_in_urdf(robot, others)
        others = [loop for loop in others if loop.name not in elsewhere]
    if source.beside:
        elsewhere |= reread_beside(others, placed, source.beside)
    return replace(
        description,
        links=tuple(_link(link.name, links[link.name]) for link in description.links),
        joints=placed,
        loops=tuple(
            _loop(loop, loops[loop.name]) if loop.name in loops else elsewhere.get(loop.name, loop)
            for loop in description.loops
        ),
        couplings=tuple(
            _coupling(item, joints[item.successor] if item.of_joints else couplings[item.name])
            for item in description.couplings
        ),
    )


def _coupling(coupling: CouplingDescription, element: Element) -> CouplingDescription:
    """Return a coupling with the numbers of its element, or of the joint that mimics the other."""
    if coupling.of_joints:
        element = _child(element, "mimic")
        ratio, offset = element.get("multiplier", "1"), element.get("offset", "0")
    else:
        ratio, offset = _child(element, "ratio").attrib["value"], "0"
    return _with_teeth(replace(coupling, ratio=float(ratio), offset=float(offset)), element)


def _with_teeth(coupling: CouplingDescription, element: Element) -> CouplingDescription:
    """Return a coupling with the numbers that its element states of powers and of teeth."""
    powers = [float(word) for word in element.get("higher", "").split()]
    while powers and not powers[-1]:
        powers.pop()
    coupling = replace(coupling, higher=tuple(powers))
    forces = element.get("forces", "")
    if forces != "mesh":
        return replace(coupling, forces=forces, mesh=None)
    pressure, helix = (
        float(element.get(f"{kind}_angle", default))
        for kind, default in (("pressure", str(np.pi / 9.0)), ("helix", "0"))
    )
    along = element.get("along")
    mesh = Mesh(pressure, helix, None if along is None else float(along))
    return replace(coupling, forces=forces, mesh=mesh)


def _link(name: str, element: Element) -> LinkDescription:
    """Return a link with the mass and inertia of its element."""
    inertial = element.find("inertial")
    if inertial is None:
        return LinkDescription(name)
    frame = _origin(inertial)
    stated = _child(inertial, "inertia")
    rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
    tensor = np.array([[float(stated.get(key, "0")) for key in row] for row in rows])
    mass = float(_child(inertial, "mass").attrib["value"])
    inertia = frame[:3, :3] @ tensor @ frame[:3, :3].T
    return LinkDescription(name, 0.0 if mass < _VANISHING else mass, frame[:3, 3], inertia)


def _joint(joint: JointDescription, element: Element) -> JointDescription:
    """Return a joint with the placement and axes of its element."""
    origin = _origin(element)
    made_universal = joint.type == "universal" and element.get("type") != "universal"
    has_no_axis = joint.type in ("fixed", "floating") and not joint.adjustable
    if has_no_axis or made_universal:
        # A file beside the URDF that makes a joint universal states its axes as well.
        return replace(joint, origin=origin)
    axis, axis_2 = _axis(element, "axis"), _axis(element, "axis2")
    return replace(joint, origin=origin, axis=axis, axis_2=axis_2)


def _rotors(robot: Element) -> dict[str, float]:
    """Return joints to the inertia of the rotors that transmissions couple with them."""
    found: dict[str, float] = {}
    for element in robot.iterfind("transmission/actuator/{*}rotor_inertia/../.."):
        name = _child(element, "joint").attrib["name"]
        for actuator in element.iterfind("actuator"):
            inertia, ratio = (
                next((float(item.attrib["value"]) for item in actuator.iterfind(tag)), default)
                for tag, default in (("{*}rotor_inertia", 0.0), ("{*}gear_ratio", 1.0))
            )
            found[name] = found.get(name, 0.0) + ratio * inertia * ratio
    return found


def _armature(item: JointOrLoop, element: Element, rotors: float = 0.0) -> tuple[float, ...]:
    """Return the armature of the parts of a joint, from its element and what else turns with it."""
    kind = getattr(item, "adjustable", "") or item.type
    # Hinges that were opened turn last.
    opened = kind in ("planar", "loose") and element.get("type") != kind
    count = 1 if opened else len(kinds_of(kind))
    stated = element.find("dynamics")
    listed = "0" if stated is None else stated.get("armature", "0")
    found = rotors + np.array(listed.split(), dtype=float) * np.ones(count)
    return at_last_parts(found.tolist(), kind)


def _loop(loop: LoopDescription, element: Element) -> LoopDescription:
    """Return a loop with the placements and axes of its element."""
    predecessor, successor = _ends(element)
    is_constraint = element.tag == "constraint"
    first, second = ("parent_axis", "child_axis") if is_constraint else ("axis", "axis2")
    return replace(
        loop,
        predecessor_origin=predecessor,
        successor_origin=successor,
        axis=_axis(element, first),
        axis_2=_axis(element, second),
        armature=_armature(loop, element),
    )


def _axis(element: Element, tag: str) -> Array:
    """Return the `(3,)` unit vector that a child element states."""
    axis = _triple(element.find(tag), "xyz", (1.0, 0.0, 0.0))
    return axis / np.sqrt(axis @ axis)


def _ends(loop: Element) -> tuple[Array, Array]:
    """Return the `(4, 4)` placements of a loop's frame in its predecessor and its successor."""
    if loop.tag == "constraint":
        origins = (loop.find("parent_origin"), loop.find("child_origin"))
        first, second = (np.eye(4) if end is None else _frame(end) for end in origins)
        return first, second
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
    turn = pinocchio.rpy.rpyToMatrix(_triple(element, "rpy", (0.0, 0.0, 0.0)))
    place = pinocchio.SE3(turn, _triple(element, "xyz", (0.0, 0.0, 0.0)))
    return np.array(place.homogeneous)


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


def reread_beside(
    loops: Sequence[LoopDescription], joints: Iterable[JointDescription], text: str | bytes
) -> dict[str, LoopDescription]:
    """Return the loops that a file states, by name, with the numbers of its text.

    Args:
        loops: those that the URDF itself does not state.
        joints: those of the tree, with the numbers of the URDF.
        text: of the file.

    Raises:
        ModelError: the file states loops, and not all of these.
    """
    import yaml

    content: dict[str, Any] = yaml.safe_load(text)
    entries = {
        entry.get("name") or f"{'loop' if key == 'closures' else key}_{index}": entry
        for key in ("closures", "pin_loops", "ball_loops")
        for index, entry in enumerate(content.get(key) or [], start=1)
    }
    if not entries:
        return {}
    carrier = {joint.child: joint for joint in joints}
    # Otherwise the first reader's numbers would prove themselves.
    missing = [loop.name for loop in loops if loop.name not in entries]
    if missing:
        raise ModelError(f"loop {missing[0]!r} is not found by the second reading of the file")
    return {loop.name: _listed(loop, entries[loop.name], carrier) for loop in loops}


def _listed(
    loop: LoopDescription, entry: dict[str, Any], carrier: dict[str, JointDescription]
) -> LoopDescription:
    """Return a loop whose place is stated in each of its links, or in the root's frame at zero."""
    ends = []
    for side, key in (("link_a", "parent_xyz"), ("link_b", "child_xyz")):
        point = np.array([float(word) for word in entry.get(key) or entry["point"]])
        turn, place, link = np.eye(3), np.zeros(3), entry.get(side)
        while link in carrier:
            joint = carrier[link]
            place = joint.origin[:3, :3] @ place + joint.origin[:3, 3]
            turn, link = joint.origin[:3, :3] @ turn, joint.parent
        end = np.eye(4)
        end[:3, :3], end[:3, 3] = turn.T, turn.T @ (point - place)
        ends.append(end)
    axis = loop.axis
    if loop.type == "revolute":
        axis = np.array([float(word) for word in entry["axis"]])
        axis = axis / np.sqrt(axis @ axis)
    return replace(loop, predecessor_origin=ends[0], successor_origin=ends[1], axis=axis)
