"""Left out: what a description says and no wrench considers, one line of warning per kind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element

from ...kit.errors import ModelError, choices
from .description import JointDescription, JointOrLoop

_MOST_NAMED = 3
"""Joints that a line names; it counts the others."""
_MOST_FORCES = 8
"""Forces that a message lists, so that it stays readable."""
_OF_JOINTS = {
    "safety_controller": "safety controllers",
    "calibration": "calibrations",
}
"""Elements of joints that play no part, with what they are called."""
_BALLS = ("spherical", "floating")
"""Joint types with a ball, of which no single coordinate can rub."""
_OF_PROGRAMS = ("transmission", "gazebo", "mujoco", "drake")
"""Elements of `<robot>` that are for other programs."""


def elements_left_out(robot: Element, where: str) -> list[str]:
    """Return warnings about elements of a URDF that wrenches are without.

    Args:
        robot: its outermost element.
        where: how messages name the source of the text.
    """
    joints, lines = robot.findall("joint"), list[str]()
    for tag, label in _OF_JOINTS.items():
        named = [joint.get("name", "") for joint in joints if joint.find(tag) is not None]
        lines += line_of(where, label, named, "no wrench considers them")
    touching = [
        link.get("name", "") for link in robot.findall("link") if link.find("contact") is not None
    ]
    lines += line_of(where, "<contact>", touching, "no wrench considers it", "link")
    for tag in _OF_PROGRAMS:
        count = sum(not _is_read(item, joints) for item in robot.findall(tag))
        if count:
            times = f" ({count} times)" if count > 1 else ""
            lines.append(f"{where}: <{tag}>{times} is for other programs and was passed over")
    return lines


def _is_read(element: Element, joints: Sequence[Element]) -> bool:
    """Return whether an element for other programs says loops (`gazebo`), motors or rotors."""
    if element.tag == "transmission":
        known = {joint.get("name") for joint in joints}
        return any(joint.get("name") in known for joint in element.findall("joint"))
    tags = {part.tag for part in element}
    return bool(tags) and element.tag == "gazebo" and tags <= {"joint", "frame"}


def limits_left_out(joints: Iterable[JointDescription], where: str) -> list[str]:
    """Return a warning about limits of joints, if there are any.

    Args:
        joints: of the tree.
        where: how messages name the source of the text.
    """
    limited = [
        joint.name
        for joint in joints
        if any(
            math.isfinite(value)
            for of in [joint.limits]
            for value in (of.lower, of.upper, of.velocity, *of.efforts)
        )
    ]
    told = "they hold nothing back; results say where positions, speeds and efforts lie beyond them"
    return line_of(where, "limits", limited, told, is_left_out=False)


def dynamics_left_out(joints: Iterable[JointOrLoop], where: str) -> list[str]:
    """Return warnings about damping, friction and springs of joints and loops.

    Args:
        joints: all of them.
        where: how messages name the source of the text.
    """
    acting = [item for item in joints if item.dynamics.acts]
    balls = [item.name for item in acting if item.type in _BALLS]
    others = [item.name for item in acting if item.type not in _BALLS]
    has_springs = any(item.dynamics.stiffness for item in acting)
    what = "damping, friction or springs" if has_springs else "damping or friction"
    taken = (
        "Scene(..., elements=described_elements(mechanism)) takes it in, as "
        "`cardan-dyn simulate` and `vibration` do; other scenes are without it"
    )
    return [
        *line_of(where, what, others, taken, is_left_out=False),
        *line_of(where, what, balls, "wrenches are without it", "ball"),
    ]


def forces_left_out(forces: Sequence[str], where: str, strict: bool) -> list[str]:
    """Return a warning for each force that a file states and no wrench considers.

    Args:
        forces: what they are and what states them.
        where: how messages name the source of the text.
        strict: whether they are refused.

    Raises:
        ModelError: there are some, and `strict` refuses them.
    """
    if strict and forces:
        more = len(forces) - _MOST_FORCES
        listed = "; ".join(forces[:_MOST_FORCES]) + (f"; and {more} more" if more > 0 else "")
        raise ModelError(
            f"{where}: forces that wrenches leave out: {listed}; load(..., strict=False) accepts "
            "the file and leaves them out"
        )
    return [f"{where}: {force} left out of the wrenches" for force in forces]


def line_of(
    where: str,
    what: str,
    names: list[str],
    result: str,
    owner: str = "joint",
    is_left_out: bool = True,
) -> list[str]:
    """Return a warning about something of some joints or links; none where there are none."""
    left_out = " left out" * is_left_out
    owners = f"{len(names)} {owner}{'s' * (len(names) > 1)} ({choices(names, most=_MOST_NAMED)})"
    return [f"{where}: {what} of {owners}{left_out}: {result}"] if names else []
