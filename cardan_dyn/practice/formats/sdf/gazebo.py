"""Gazebo: loops of a URDF as joints of SDF, `<joint>` in a `<gazebo>` without a reference.

sdformat adds them to the model that it makes of the URDF, as they are. Links and joints of the URDF
are the frames that they can name, and their own frame is placed in their child unless `<pose>`
names another one. An axis is seen in the joint's frame, as of sdformat 9 on; a warning says where
older versions, which see it in the model's frame, would make another joint of it.
"""

from __future__ import annotations

from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np

from ....core.description.description import LoopDescription
from ....core.description.elements import DIRECTION_TOLERANCE, ends_of
from ....core.description.left_out import forces_left_out
from ....core.description.words import check_words
from ....kit.errors import ModelError, choices
from .frames import WORLD, NamedFrames
from .joints import GEARBOX, Edge, edge, kind_of
from .plain import of_urdf

NOTATION = "SDF <joint> in <gazebo>"
"""What the notation is called."""


def loops(
    robot: Element, where: str, strict: bool
) -> tuple[tuple[LoopDescription, ...], tuple[str, ...]]:
    """Return the loops that `<gazebo>` elements add to a URDF, and warnings.

    Warnings name what is left out, and what depends on Gazebo's version. A fixed joint between the
    world and the root says what is so without it, and is left out.

    Args:
        robot: outermost element of the URDF.
        where: how messages name the source of the text.
        strict: whether unknown words are refused, and forces that no wrench considers.

    Raises:
        ModelError: what is wrong with them, or what cannot be read.
    """
    for item in robot.findall("gazebo"):
        if item.get("reference") and item.find("joint") is not None:
            raise ModelError(
                f"{where}: <gazebo reference={item.get('reference')!r}>: a <joint> belongs to the "
                "robot as a whole: write it in a <gazebo> without a reference"
            )
    carried = {ends_of(joint)[1] for joint in robot.findall("joint")}
    links = [link.get("name", "") for link in robot.findall("link")]
    roots = [name for name in links if name not in carried]
    if len(roots) != 1:
        raise ModelError(f"{where}: a URDF has exactly one root link, not {choices(roots)}")
    (root,) = roots
    model, is_flagged = of_urdf(robot, f"{where}: <gazebo>")
    if root != WORLD:
        model.set("canonical_link", root)
    frames = NamedFrames(model, where, has_names=not is_flagged)
    warnings, forces, found_loops = list[str](), list[str](), list[LoopDescription]()
    for joint in model.findall("joint"):
        at = f"{where}: <gazebo>: joint {joint.get('name')!r}"
        warnings += check_words(joint, "sdf", at, strict)
        if kind_of(joint, at) == GEARBOX or joint.find("*/mimic") is not None:
            raise ModelError(f"{at}: couplings are not read here: write <coupling> or <mimic>")
        found = edge(joint, frames, f"{where}: <gazebo>")
        warnings += found.warnings
        forces += found.forces
        found = replace(found, parent=root if found.parent == WORLD else found.parent)
        if found.child == root:
            if found.type == "fixed" and found.parent == root:
                continue
            raise ModelError(
                f"{at}: its child is the root {root!r}, which stands still here: write it as a "
                "<joint> of the URDF, or swap parent and child"
            )
        if not is_flagged:
            warnings += _axis_notes(joint, found, at)
        ends = {link: frames.placement(link, at) for link in (found.parent, found.child)}
        found_loops.append(found.loop(ends))
    return tuple(found_loops), (*warnings, *forces_left_out(forces, where, strict))


def _axis_notes(joint: Element, found: Edge, at: str) -> list[str]:
    """Return a warning where older versions of Gazebo would make another joint of an axis."""
    turn = found.origin[:3, :3]
    return [
        f"{at}: <{tag}> is seen in the joint's frame, as of sdformat 9 on; older versions "
        "see it in the model's frame, where it is another one: write expressed_in"
        for tag, axis in (("axis", found.axis), ("axis2", found.axis_2))
        for xyz in joint.iterfind(f"{tag}/xyz")
        if found.type not in ("fixed", "spherical") and not xyz.get("expressed_in")
        if np.max(np.abs(turn @ axis - axis)) > DIRECTION_TOLERANCE
    ]
