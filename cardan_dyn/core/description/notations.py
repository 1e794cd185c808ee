"""Notations: which of the ways of writing loops beside a URDF's tree is used.

URDF+ `<loop>` (Chignoli et al., arXiv 2411.19753) comes first, then NVIDIA Isaac's `<loop_joint>`,
ROS' proposed `<constraint>`, Gazebo's joints of SDF and the file beside the URDF. Where a
description uses several, they must say the same. Frames of onshape-to-robot are last, since they
are mere names.

`<constraint>` is that of pull request 264 of ros/urdfdom (parser) and 108 of ros/urdfdom_headers,
as it stood in 2026: `<parent>` and `<child>` name the links, `<parent_origin>` and `<child_origin>`
place a frame in each of them, and both frames coincide up to the motion of the joint that was cut.
A constraint of the type `link` cuts a link in two: nothing moves.

onshape-to-robot makes of a mate called `closing_NAME` two frames, links without mass that are fixed
to both bodies: `closing_NAME_1` and `closing_NAME_2`, which coincide (its documentation, "Handling
kinematic loops"). A revolute mate adds a frame on the z-axis of each, with `_z` behind its name. A
URDF says nothing else about the mate's type. PlaCo, for which these frames are meant, holds the
points of such a pair together, and so does onshape-to-robot's own MJCF for a ball: a pair without
frames on z is taken as a ball, with a warning.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ...kit.errors import ModelError, choices
from .beside import Beside
from .description import LoopDescription
from .elements import (
    DIRECTION_TOLERANCE,
    axes_of,
    axis_of,
    link_of,
    loop,
    name_of,
    only,
    placement,
    pose,
)

CONSTRAINT_TYPES = {
    **{kind: kind for kind in ("revolute", "prismatic", "universal", "spherical")},
    **{f"{kind}_joint": kind for kind in ("revolute", "prismatic", "universal", "spherical")},
    "link": "fixed",
}
"""Type of a constraint to the type of the loop that it is."""
_CLOSING_FRAME = re.compile(r"(closing_.+)_([12])")
"""Name of a frame: that of its mate, and which side it is on."""
_ON_Z = 1e-4
"""Greatest sine of the angle between the z-axis of a frame and the way to the frame on it: both are
written with six digits, and are 0.1 m apart."""


def agreed(
    robot: ElementTree.Element,
    links: Collection[str],
    beside: Beside | None,
    where: str,
    strict: bool = True,
) -> tuple[tuple[LoopDescription, ...], str, tuple[str, ...]]:
    """Return the loops of a description, their notation, and what that leaves open.

    The notation says as well which others say the same.

    Args:
        robot: outermost element of the URDF.
        links: names of all links.
        beside: what a file beside the URDF says.
        where: how messages name the source of the text.
        strict: whether unknown words of Gazebo's joints are refused.

    Raises:
        ModelError: two notations close different loops.
    """
    by_notation = {
        "URDF+ <loop>": tuple(
            loop(item, ("predecessor", "successor"), links, where) for item in robot.findall("loop")
        ),
        "Isaac <loop_joint>": tuple(
            loop(item, ("link1", "link2"), links, where) for item in robot.findall("loop_joint")
        ),
        "ROS <constraint>": tuple(
            _constraint(item, links, where) for item in robot.findall("constraint")
        ),
    }
    notes: tuple[str, ...] = ()
    if robot.find("gazebo/joint") is not None:
        from .gazebo import NOTATION, gazebo_loops  # Few descriptions have any.

        by_notation[NOTATION], notes = gazebo_loops(robot, where, strict)
    if beside is not None:
        by_notation[beside.notation] = beside.loops
    written = {notation: loops for notation, loops in by_notation.items() if loops}
    may_be_frames = any(link.startswith("closing_") for link in links)
    if not written:
        closing, open_types = _closing_loops(robot, links, where) if may_be_frames else ([], [])
        notation = "closing frames of onshape-to-robot" if closing else "no loops"
        return tuple(closing), notation, (*open_types, *notes)
    used, *repeating = written
    for notation in repeating:
        if _link_pairs(written[notation]) != _link_pairs(written[used]):
            raise ModelError(
                f"{where}: {used} and {notation} close different loops: "
                f"{choices(map(str, _link_pairs(written[used])))} against "
                f"{choices(map(str, _link_pairs(written[notation])))}; keep one of them"
            )
    remarks = "".join(f"; {notation} says the same and is not used" for notation in repeating)
    if may_be_frames:
        remarks += "; closing frames are not used"
    return written[used], used + remarks, notes


def _link_pairs(loops: tuple[LoopDescription, ...]) -> list[tuple[str, ...]]:
    """Return the pairs of links that loops connect, whichever of them is the predecessor."""
    return sorted(tuple(sorted((loop.predecessor, loop.successor))) for loop in loops)


def _constraint(
    element: ElementTree.Element, links: Collection[str], where: str
) -> LoopDescription:
    name = name_of(element, where)
    at = f"{where}: constraint {name!r}"
    kind = CONSTRAINT_TYPES.get(element.get("type", ""))
    if kind is None:
        listed = choices(CONSTRAINT_TYPES, element.get("type"))
        raise ModelError(f"{at}: type {element.get('type')!r} is not supported; types: {listed}")
    parent, child = (link_of(element, side, links, at) for side in ("parent", "child"))
    if parent == child:
        raise ModelError(f"{at}: parent and child are the same link {child!r}")
    first, second = (_origin(element, side, at) for side in ("parent_origin", "child_origin"))
    axis = axis_2 = np.array([1.0, 0.0, 0.0])
    if kind == "universal":
        axis, axis_2 = axes_of(element, kind, at, ("parent_axis", "child_axis"))
    elif kind in ("revolute", "prismatic"):
        axis = axis_2 = _single_axis(element, at)
    return LoopDescription(name, kind, parent, child, first, second, axis, axis_2)


def _origin(element: ElementTree.Element, tag: str, at: str) -> np.ndarray:
    """Return the `(4, 4)` placement of a side's frame in its link; identity where it has none."""
    origin = only(element, tag, at)
    return np.eye(4) if origin is None else pose(origin, at)


def _single_axis(element: ElementTree.Element, at: str) -> np.ndarray:
    """Return the `(3,)` unit axis of a hinge or slide, which the parent's side states.

    The child's side may state it, too. Since the frames turn about it or slide along it, it has the
    same components in both.
    """
    axis = axis_of(element, at, "parent_axis")
    if element.find("child_axis") is not None:
        other = axis_of(element, at, "child_axis")
        if np.linalg.norm(np.cross(axis, other)) > DIRECTION_TOLERANCE:
            raise ModelError(
                f"{at}: parent_axis {axis.tolist()} and child_axis {other.tolist()} differ, and "
                "both frames share the axis of a hinge or slide; turn one origin, or leave "
                "child_axis out"
            )
    return axis


class _FixedLink(NamedTuple):
    """A link that is fixed to another one.

    Attributes:
        body: name of the other link.
        origin: `(4, 4)` placement in it.
    """

    body: str
    origin: np.ndarray


def _closing_loops(
    robot: ElementTree.Element, links: Collection[str], where: str
) -> tuple[list[LoopDescription], list[str]]:
    frames = _fixed_links(robot, where)
    loops, warnings, guessed = [], [], []
    for link in links:
        match = _CLOSING_FRAME.fullmatch(link)
        if match is None:
            continue
        name, side = match.groups()
        partner = f"{name}_{3 - int(side)}"
        if partner not in frames or link not in frames:
            missing = partner if link in frames else link
            warnings.append(
                f"{where}: frame {link!r} closes no loop: there is no link {missing!r} that is "
                "fixed to a body"
            )
            continue
        if side == "2":
            continue
        has_axis = [f"{end}_z" in frames for end in (link, partner)]
        if any(has_axis):
            for end in (link, partner):
                _check_on_z(end, frames, f"{where}: frame '{end}_z'")
        else:
            guessed.append(name)
        kind = "revolute" if any(has_axis) else "spherical"
        axis = np.array([0.0, 0.0, 1.0])
        loops.append(LoopDescription(name, kind, link, partner, np.eye(4), np.eye(4), axis, axis))
    if guessed:
        warnings.append(
            f"{where}: closing frames do not state the type of {choices(guessed)}: taken as "
            "spherical; write <loop> where it is another one"
        )
    return loops, warnings


def _fixed_links(robot: ElementTree.Element, where: str) -> dict[str, _FixedLink]:
    """Return the links that fixed joints attach to others."""
    frames = {}
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if joint.get("type") == "fixed" and parent is not None and child is not None:
            origin = placement(joint, f"{where}: joint {joint.get('name')!r}")
            frames[child.get("link", "")] = _FixedLink(parent.get("link", ""), origin)
    return frames


def _check_on_z(link: str, frames: dict[str, _FixedLink], at: str) -> None:
    """Refuse a frame that does not lie on the z-axis of another one of the same body."""
    frame, beyond = frames[link], frames.get(f"{link}_z")
    if beyond is None or beyond.body != frame.body:
        raise ModelError(f"{at} is not fixed to the body of {link!r}; a revolute mate has both")
    way = frame.origin[:3, :3].T @ (beyond.origin[:3, 3] - frame.origin[:3, 3])
    if not (way[2] > 0.0 and np.linalg.norm(way[:2]) <= _ON_Z * way[2]):
        raise ModelError(f"{at} does not lie on the z-axis of {link!r}; correct its origin")
