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
from importlib import import_module
from xml.etree.ElementTree import Element

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from .beside import Beside
from .description import GUESTS, LoopDescription
from .elements import NOTATIONS, ends_of, loop, placement

_CLOSING_FRAME = re.compile(r"(closing_.+)_([12])")
"""Name of a frame: that of its mate, and which side it is on."""
_ON_Z = 1e-4
"""Greatest sine of the angle between the z-axis of a frame and the way to the frame on it: both are
written with six digits, and are 0.1 m apart."""


def agreed(
    robot: Element,
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
        f"{author} <{tag}>": tuple(loop(item, links, where) for item in robot.findall(tag))
        for author, tag in zip(("URDF+", "Isaac", "ROS"), NOTATIONS, strict=True)
    }
    notes: tuple[str, ...] = ()
    if robot.find("gazebo/joint") is not None:
        gazebo = import_module(f"{GUESTS['sdf']}.gazebo")  # Few descriptions have any.
        by_notation[gazebo.NOTATION], notes = gazebo.loops(robot, where, strict)
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
    remarks = "".join(
        f"; {notation} closes the same links and is not used" for notation in repeating
    )
    if may_be_frames:
        remarks += "; closing frames are not used"
    return written[used], used + remarks, notes


def _link_pairs(loops: tuple[LoopDescription, ...]) -> list[tuple[str, ...]]:
    """Return the pairs of links that loops connect, whichever of them is the predecessor."""
    return sorted(tuple(sorted((loop.predecessor, loop.successor))) for loop in loops)


def _closing_loops(
    robot: Element, links: Collection[str], where: str
) -> tuple[list[LoopDescription], list[str]]:
    """Return the loops that pairs of frames close, and warnings about what they leave open."""
    frames = _fixed_links(robot, where)
    loops, warnings, guessed = [], [], []
    for link in links:
        match = _CLOSING_FRAME.fullmatch(link)
        if match is None:
            continue
        name, side = match.groups()
        partner = f"{name}_{3 - int(side)}"
        if not {link, partner} <= frames.keys():
            missing = partner if link in frames else link
            warnings.append(
                f"{where}: frame {link!r} closes no loop: there is no link {missing!r} that is "
                "fixed to a body"
            )
        elif side == "1":
            ends, kind = (link, partner), "spherical"
            if any(f"{end}_z" in frames for end in ends):
                kind = "revolute"
                for end in ends:
                    _check_on_z(end, frames, f"{where}: frame '{end}_z'")
            else:
                guessed.append(name)
            loops.append(LoopDescription(name, kind, *ends, np.eye(4), np.eye(4), np.eye(3)[2]))
    if guessed:
        warnings.append(
            f"{where}: closing frames do not state the type of {choices(guessed)}: taken as "
            "spherical; write <loop> where it is another one"
        )
    return loops, warnings


def _fixed_links(robot: Element, where: str) -> dict[str, tuple[str, Array]]:
    """Return links that fixed joints attach to others: to these, `(4, 4)` placement there."""
    frames = {}
    for joint in robot.findall("joint"):
        if joint.get("type") == "fixed":
            parent, child = ends_of(joint)
            frames[child] = parent, placement(joint, f"{where}: joint {joint.get('name')!r}")
    return frames


def _check_on_z(link: str, frames: dict[str, tuple[str, Array]], at: str) -> None:
    """Refuse a frame that does not lie on the z-axis of another one of the same body."""
    body, origin = frames[link]
    other, beyond = frames.get(f"{link}_z", ("", origin))
    if other != body:
        raise ModelError(f"{at} is not fixed to the body of {link!r}; a revolute mate has both")
    x, y, z = origin[:3, :3].T @ (beyond[:3, 3] - origin[:3, 3])
    if not np.hypot(x, y) <= _ON_Z * z or z == 0.0:
        raise ModelError(f"{at} does not lie on the z-axis of {link!r}; correct its origin")
