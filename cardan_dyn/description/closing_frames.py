"""Closing frames: loops as pairs of frames, as onshape-to-robot exports them.

A mate called `closing_NAME` becomes two frames, links without mass that are fixed to both bodies:
`closing_NAME_1` and `closing_NAME_2`, which coincide (documentation of Rhoban's onshape-to-robot,
"Handling kinematic loops"). A revolute mate adds a frame on the z-axis of each, with `_z` behind
its name. A URDF says nothing else about the mate's type. PlaCo, for which these frames are meant,
holds the points of such a pair together, and so does onshape-to-robot's own MJCF for a ball: a pair
without frames on z is taken as a ball, with a warning.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError, choices
from .description import LoopDescription
from .elements import placement

_FRAME = re.compile(r"(closing_.+)_([12])")
"""Name of a frame: that of its mate, and which side it is on."""
_ON_Z = 1e-4
"""Greatest sine of the angle between the z-axis of a frame and the way to the frame on it: both are
written with six digits, and are 0.1 m apart."""


class _Frame(NamedTuple):
    """A link that is fixed to another one.

    Attributes:
        body: name of the other link.
        origin: `(4, 4)` placement in it.
    """

    body: str
    origin: np.ndarray


def closing_loops(
    robot: ElementTree.Element, links: Collection[str], where: str
) -> tuple[list[LoopDescription], list[str]]:
    """Return the loops that pairs of closing frames are, and warnings.

    Args:
        robot: outermost element of the URDF.
        links: names of all links.
        where: how messages name the source of the text.

    Raises:
        ModelError: frames on the z-axis of others are not there.
    """
    frames = _fixed_links(robot, where)
    loops, warnings, guessed = [], [], []
    for link in links:
        match = _FRAME.fullmatch(link)
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


def _fixed_links(robot: ElementTree.Element, where: str) -> dict[str, _Frame]:
    """Return the links that fixed joints attach to others."""
    frames = {}
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if joint.get("type") == "fixed" and parent is not None and child is not None:
            origin = placement(joint, f"{where}: joint {joint.get('name')!r}")
            frames[child.get("link", "")] = _Frame(parent.get("link", ""), origin)
    return frames


def _check_on_z(link: str, frames: dict[str, _Frame], at: str) -> None:
    """Refuse a frame that does not lie on the z-axis of another one of the same body."""
    frame, beyond = frames[link], frames.get(f"{link}_z")
    if beyond is None or beyond.body != frame.body:
        raise ModelError(f"{at} is not fixed to the body of {link!r}; a revolute mate has both")
    way = frame.origin[:3, :3].T @ (beyond.origin[:3, 3] - frame.origin[:3, 3])
    if not (way[2] > 0.0 and np.linalg.norm(way[:2]) <= _ON_Z * way[2]):
        raise ModelError(f"{at} does not lie on the z-axis of {link!r}; correct its origin")
