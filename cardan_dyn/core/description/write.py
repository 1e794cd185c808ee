"""Write: a description as a file, or as URDF+ text that `read` turns into an equal description.

Names, masses, lengths, ratios, offsets and limits come back to the last bit. Rotations are written
as roll, pitch and yaw, and axes are scaled to the length 1 when they are read, so their entries may
differ by rounding, some 1e-16; `Description.agrees` compares with such a tolerance.

What was read from another notation than URDF becomes what a URDF can say:

- A URDF's link has the frame of the joint that carries it. Where a joint of MJCF or SDF stands
  elsewhere in its child, the link is described in the joint's frame, which moves the link's frame.
- The order of joints in Pinocchio's model is then that of a URDF, alphabetical.

Visuals, comments and warnings are no part of a description and are not written.
"""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import file_path, writing
from ...kit.errors import ArgumentError, ModelError
from .coupled_forces import forces_words
from .description import GUESTS, TWO_AXES, JointDescription
from .elements import (
    DYNAMICS_WORDS,
    LOOP_TYPES,
    ROTATION_TOLERANCE,
    TREE_TYPES,
    one_of,
    rotation,
    words,
)
from .mimics import check_mimics, default_name

if TYPE_CHECKING:
    from .description import (
        CouplingDescription,
        Description,
        JointOrLoop,
        Limits,
        LinkDescription,
        LoopDescription,
    )

_SUFFIXES = (".urdf", ".xml", ".mjcf")


def write(description: Description, path: str | os.PathLike[str]) -> Path:
    """Write a description to a file, in place of what it contained; return its path.

    A warning lists what the notation has no word for.

    Args:
        description: what to write.
        path: `.urdf` for URDF+, `.xml` or `.mjcf` for MJCF.

    Raises:
        ArgumentError: the suffix is unknown, or the file cannot be written.
        ModelError: the notation cannot say something of the description.
    """
    target = _path(path)
    if target.suffix.lower() == ".urdf":
        text, left_out = to_urdf(description), _left_out(description)
    else:
        text, left_out = import_module(f"{GUESTS['mujoco']}.writer").written(description)
    with writing(target) as part:
        part.write_text(text, encoding="utf-8")
    if left_out:
        warnings.warn(
            f"{target}: not written, as its notation has no word for it: {'; '.join(left_out)}",
            stacklevel=3,
        )
    return target


def _left_out(description: Description) -> list[str]:
    """Return what of a description a URDF does not say, in words."""
    named = {
        "keyframe": description.keyframes,
        "frame": description.own_frames,
        "actuator": [item.name or item.joint for item in description.actuators],
    }
    gravity = ["gravity"] * description.states_gravity
    return [f"{what} {name!r}" for what, names in named.items() for name in names] + gravity


def _path(path: object) -> Path:
    target = file_path("path", path)
    if target.suffix.lower() not in _SUFFIXES:
        raise ArgumentError(
            f"{target}: the suffix {target.suffix!r} names no notation; write .urdf for URDF+, "
            ".xml or .mjcf for MJCF"
        )
    try:
        exists = target.parent.is_dir()
    except (OSError, ValueError):  # A name that is too long, or contains a null character.
        exists = False
    if not exists:
        raise ArgumentError(f"{target}: the directory {str(target.parent)!r} does not exist")
    return target


def to_urdf(description: Description) -> str:
    """Return a description as URDF+ text, loops as `<loop>`.

    A description with inertias that no body can have is read back with `strict=False` only, as it
    was read at first.

    Raises:
        ModelError: something in a description made by hand has no notation in URDF+: an unknown
            type, a mass of zero with an inertia, a matrix that is no rotation, limits of position
            on a continuous joint, a joint that is coupled with several others or in a circle.
    """
    urdf = with_links_at_joints(description)
    known = {joint.name for joint in urdf.joints}
    for name in urdf.independent_joints:
        one_of(name, known, "independent joint", urdf.name, "is no joint of the tree")
    robot = Element("robot", name=urdf.name)
    for link in urdf.links:
        _write_link(robot, link)
    check_mimics(urdf.couplings, urdf.name)
    mimics = {item.successor: item for item in urdf.couplings if item.of_joints}
    for joint in _in_order_of_drives(urdf):
        element = _write_joint(robot, joint, joint.name in urdf.independent_joints)
        if joint.name in mimics:
            write_mimic(element, mimics[joint.name])
    for loop in urdf.loops:
        _write_loop(robot, loop)
    for coupling in urdf.couplings:
        if not coupling.of_joints:
            write_coupling(robot, coupling)
    indent(robot)
    return f'<?xml version="1.0"?>\n{tostring(robot, encoding="unicode")}\n'


def with_links_at_joints(description: Description) -> Description:
    """Return the same mechanism with every link described in the frame of its joint.

    Masses, inertias, and the joints and loops that a link carries keep their places in the
    mechanism; every `child_placement` becomes the identity.
    """
    placements = {joint.child: joint.child_placement for joint in description.joints}
    # Products with an identity would not change a number, but the sign of zeros.
    moved = {
        link: placement
        for link, placement in placements.items()
        if not np.array_equal(placement, np.eye(4))
    }
    if not moved:
        return description

    def at_joints(item: Any) -> Any:
        placed = {
            field: moved[link] @ getattr(item, field)
            for carrier, field in item.ENDS
            if (link := getattr(item, carrier)) in moved
        }
        if isinstance(item, JointDescription):
            placed["child_placement"] = np.eye(4)
        return replace(item, **placed)

    links = tuple(
        link.seen_in(moved[link.name]) if link.name in moved else link for link in description.links
    )
    return description.with_each(at_joints, links=links)


def _in_order_of_drives(description: Description) -> list[JointDescription]:
    """Return the joints such that the independent ones stand in the order of their drives.

    A URDF lists independent joints in the order of its joints; Gepetto's file has one of its own.
    """
    joints = {joint.name: joint for joint in description.joints}
    independent = iter(description.independent_joints)
    return [
        joints[next(independent)] if joint.name in description.independent_joints else joint
        for joint in description.joints
    ]


def _write_link(robot: Element, link: LinkDescription) -> None:
    element = SubElement(robot, "link", name=link.name)
    if link.is_massless:
        return
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=words(link.centre))
    SubElement(inertial, "mass", value=words([link.mass]))
    # Rotated inertias are symmetric up to rounding.
    tensor = 0.5 * (link.inertia + link.inertia.T)
    axes = "xyz"
    moments = {
        f"i{axes[row]}{axes[column]}": words([tensor[row, column]])
        for row in range(3)
        for column in range(row, 3)
    }
    SubElement(inertial, "inertia", moments)


def _write_joint(robot: Element, joint: JointDescription, independent: bool) -> Element:
    at = f"joint {joint.name!r}"
    one_of(joint.type, TREE_TYPES, "type", at, "cannot be written")
    element = SubElement(robot, "joint", name=joint.name, type=joint.type)
    if independent:
        element.set("independent", "true")
    if joint.adjustable:
        element.set("adjustable", joint.adjustable)
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    write_origin(element, joint.origin, at)
    if joint.type != "fixed" or joint.adjustable:
        _write_axes(element, joint)
    _write_limits(element, joint.limits, joint.type, at)
    _write_dynamics(element, joint)
    return element


def _write_dynamics(element: Element, joint: JointOrLoop) -> None:
    """Add what rubs and springs; springs in the words of SDF, since URDF has none for them.

    Other readers refuse an element without damping and friction.
    """
    dynamics = joint.dynamics
    if not any(dynamics) and not joint.armature:
        return
    count = len(dynamics) if dynamics.stiffness or dynamics.rest else 2
    values = zip(DYNAMICS_WORDS[:count], dynamics[:count], strict=True)
    stated = {name: words([value]) for name, value in values}
    if joint.armature:
        stated["armature"] = words(joint.armature)
    SubElement(element, "dynamics", stated)


def write_mimic(joint: Element, coupling: CouplingDescription) -> None:
    """Add a `<mimic>` to a joint; with a name where it is not the one that the joint gives it."""
    mimic = SubElement(joint, "mimic", joint=coupling.predecessor)
    mimic.set("multiplier", words([coupling.ratio]))
    if coupling.offset:
        mimic.set("offset", words([coupling.offset]))
    if coupling.name != default_name(coupling.successor):
        mimic.set("name", coupling.name)
    mimic.attrib.update(forces_words(coupling))


def _write_limits(joint: Element, limits: Limits, kind: str, at: str) -> None:
    """Add the limits of a joint; those that URDF requires are without any the greatest number.

    Other readers refuse a hinge or slide without limits, and a word as a number.
    """
    values = {name: getattr(limits, name) for name in ("lower", "upper", "velocity", "effort")}
    if limits.least_effort is not None:
        values["least_effort"] = limits.least_effort
    if all(map(math.isinf, values.values())) and kind not in ("revolute", "prismatic"):
        return
    if kind == "continuous":
        lower, upper = values.pop("lower"), values.pop("upper")
        if math.isfinite(lower) or math.isfinite(upper):
            raise ModelError(f"{at}: a continuous joint has no limits of position")
    # To the last bit, and infinite ones as the greatest number in either sense.
    stated = {name: words([float(np.nan_to_num(value))]) for name, value in values.items()}
    SubElement(joint, "limit", stated)


def _write_loop(robot: Element, loop: LoopDescription) -> None:
    at = f"loop {loop.name!r}"
    one_of(loop.type, LOOP_TYPES, "type", at, "cannot be written")
    element = SubElement(robot, "loop", name=loop.name, type=loop.type)
    for side, origin in loop.ENDS:
        end = SubElement(element, side, link=getattr(loop, side))
        write_origin(end, getattr(loop, origin), at)
    _write_axes(element, loop)
    _write_dynamics(element, loop)


def write_coupling(robot: Element, coupling: CouplingDescription) -> None:
    """Add the `<coupling>` of a coupling of links."""
    element = SubElement(robot, "coupling", {"name": coupling.name, **forces_words(coupling)})
    SubElement(element, "predecessor", link=coupling.predecessor)
    SubElement(element, "successor", link=coupling.successor)
    SubElement(element, "ratio", value=words([coupling.ratio]))


def _write_axes(element: Element, joint: JointOrLoop) -> None:
    SubElement(element, "axis", xyz=words(joint.axis))
    if joint.type in TWO_AXES:
        SubElement(element, "axis2", xyz=words(joint.axis_2))


def write_origin(element: Element, placement: Array, at: str) -> None:
    """Add the `<origin>` of a `(4, 4)` placement.

    Raises:
        ModelError: it has no rotation; `at` says in the message of what it is.
    """
    origin = SubElement(element, "origin", xyz=words(placement[:3, 3]))
    angles = angles_of(placement[:3, :3])
    if not np.allclose(rotation(*angles), placement[:3, :3], rtol=0.0, atol=ROTATION_TOLERANCE):
        raise ModelError(f"{at}: {placement[:3, :3].tolist()} is no rotation")
    if any(angles):
        origin.set("rpy", words(angles))


def angles_of(turn: Array) -> tuple[float, float, float]:
    """Return roll, pitch and yaw [rad] of a rotation `(3, 3)`, accurate in every position.

    Where pitch is a right angle, only the sum or difference of roll and yaw is determined. There
    `atan2` returns an arbitrary yaw; roll is computed from the matrix turned back by that yaw, so
    that both together are the rotation.
    """
    yaw = math.atan2(turn[1, 0], turn[0, 0])
    cosine, sine = math.cos(yaw), math.sin(yaw)
    pitch = math.atan2(-turn[2, 0], cosine * turn[0, 0] + sine * turn[1, 0])
    roll = math.atan2(
        sine * turn[0, 2] - cosine * turn[1, 2], cosine * turn[1, 1] - sine * turn[0, 1]
    )
    return roll, pitch, yaw
