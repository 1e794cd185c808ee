"""Notations: which of the ways of writing loops beside a URDF's tree is used.

URDF+ `<loop>` (Chignoli et al., arXiv 2411.19753) comes first, then NVIDIA Isaac's `<loop_joint>`,
ROS' proposed `<constraint>`, Gazebo's joints of SDF and the file beside the URDF. Where a
description uses several, they must say the same. Frames of onshape-to-robot are last, since they
are mere names.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple
from xml.etree import ElementTree

from ..errors import ModelError, choices
from .beside import Beside
from .description import LoopDescription
from .elements import loop


class Agreed(NamedTuple):
    """The loops of a description.

    Attributes:
        loops: the loops.
        notation: which notation they came from, and which others say the same.
        warnings: what the notation leaves open.
    """

    loops: tuple[LoopDescription, ...]
    notation: str
    warnings: tuple[str, ...] = ()


def agreed(
    robot: ElementTree.Element,
    links: Collection[str],
    beside: Beside | None,
    where: str,
    strict: bool = True,
) -> Agreed:
    """Return the loops of a description.

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
        "ROS <constraint>": _constraints(robot, links, where),
    }
    notes: tuple[str, ...] = ()
    if robot.find("gazebo/joint") is not None:
        from .gazebo import NOTATION, gazebo_loops  # Few descriptions have any.

        by_notation[NOTATION], notes = gazebo_loops(robot, where, strict)
    if beside is not None:
        by_notation[beside.notation] = beside.loops
    written = {notation: loops for notation, loops in by_notation.items() if loops}
    if not written:
        found = _of_closing_frames(robot, links, where)
        return found._replace(warnings=(*found.warnings, *notes))
    used, *repeating = written
    for notation in repeating:
        if _link_pairs(written[notation]) != _link_pairs(written[used]):
            raise ModelError(
                f"{where}: {used} and {notation} close different loops: "
                f"{choices(map(str, _link_pairs(written[used])))} against "
                f"{choices(map(str, _link_pairs(written[notation])))}; keep one of them"
            )
    remarks = "".join(f"; {notation} says the same and is not used" for notation in repeating)
    if _may_have_closing_frames(links):
        remarks += "; closing frames are not used"
    return Agreed(written[used], used + remarks, notes)


def _constraints(
    robot: ElementTree.Element, links: Collection[str], where: str
) -> tuple[LoopDescription, ...]:
    """Return the loops that `<constraint>` elements are."""
    elements = robot.findall("constraint")
    if not elements:
        return ()
    from .constraint import constraint  # Few descriptions have any.

    return tuple(constraint(item, links, where) for item in elements)


def _may_have_closing_frames(links: Collection[str]) -> bool:
    """Return whether there are links whose names begin like those of closing frames."""
    return any(link.startswith("closing_") for link in links)


def _of_closing_frames(robot: ElementTree.Element, links: Collection[str], where: str) -> Agreed:
    """Return the loops of a description that states none but may have closing frames."""
    if not _may_have_closing_frames(links):
        return Agreed((), "no loops")
    from .closing_frames import closing_loops  # Few descriptions have any.

    closing, warnings = closing_loops(robot, links, where)
    notation = "closing frames of onshape-to-robot" if closing else "no loops"
    return Agreed(tuple(closing), notation, tuple(warnings))


def _link_pairs(loops: tuple[LoopDescription, ...]) -> list[tuple[str, ...]]:
    """Return the pairs of links that loops connect, whichever of them is the predecessor."""
    return sorted(tuple(sorted((loop.predecessor, loop.successor))) for loop in loops)
