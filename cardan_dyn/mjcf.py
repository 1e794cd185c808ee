"""MJCF: closed chains of a MuJoCo model, through Pinocchio's own reader."""

from __future__ import annotations

import tempfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio

from .description import Description, LoopDescription
from .errors import ModelError, choices

EQUALITIES = ("connect", "weld")
"""Kinds of <equality> that Pinocchio reads."""


def parse(root: ElementTree.Element, text: str, where: str, path: Path | None) -> Description:
    """Read an MJCF model with `<equality>` constraints `connect` and `weld`.

    A `connect` becomes a loop of the type `spherical`, a `weld` one of the type `fixed`.

    Args:
        root: outermost element.
        text: the whole text.
        where: how messages name it.
        path: the file, if it is one; includes and meshes are found from there.

    Raises:
        ModelError: Pinocchio cannot read it, or it closes chains in ways that are not supported.
    """
    for equality in root.iter("equality"):
        for item in equality:
            if item.tag not in EQUALITIES:
                raise ModelError(
                    f"{where}: <equality> <{item.tag}> is not supported; kinds: "
                    f"{choices(EQUALITIES)}"
                )
    model, constraints = _read(*_under_one_body(root, text, where, path), where)
    bodies = {
        frame.name: frame for frame in list(model.frames) if frame.type == pinocchio.FrameType.BODY
    }
    lost = {body.get("name", "") for body in root.iter("body")} - {"", *bodies}
    if lost:
        raise ModelError(f"{where}: Pinocchio's reader leaves out the bodies {choices(lost)}")
    carrier = {frame.parentJoint: name for name, frame in reversed(list(bodies.items()))}
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    joints, axes = {}, {}
    for index in range(1, model.njoints):
        name = model.names[index]
        joints[name], axes[name] = _joint(model, data, index, f"{where}: joint {name!r}")
    loops: list[LoopDescription] = []
    for number, constraint in enumerate(constraints, start=1):
        ends = (
            (constraint.joint1_id, constraint.joint1_placement),
            (constraint.joint2_id, constraint.joint2_placement),
        )
        kinds = {
            pinocchio.ContactType.CONTACT_3D: "spherical",
            pinocchio.ContactType.CONTACT_6D: "fixed",
        }
        axis = np.array([1.0, 0.0, 0.0])
        links = [carrier[index] for index, _ in ends]
        origins = [
            (bodies[link].placement.inverse() * placement).homogeneous
            for link, (_, placement) in zip(links, ends, strict=True)
        ]
        name = constraint.name or f"equality_{number}"
        if name in joints or name in {loop.name for loop in loops}:
            name = f"{name}_{number}"
        loops.append(
            LoopDescription(
                name, kinds[constraint.type], links[0], links[1], origins[0], origins[1], axis, axis
            )
        )
    return Description(
        name=root.get("model") or "mechanism",
        tree=lambda: model,
        links=tuple(bodies),
        joints=joints,
        axes=axes,
        loops=tuple(loops),
        notation="MJCF <equality>",
    )


def _under_one_body(
    root: ElementTree.Element, text: str, where: str, path: Path | None
) -> tuple[str, Path | None]:
    """Put the bodies of the world under one that does not move.

    Pinocchio's reader takes the first body of the world and silently leaves out the others.
    """
    world = root.find("worldbody")
    bodies = [] if world is None else world.findall("body")
    if world is None or len(bodies) < 2:
        return text, path
    if path is not None and (
        root.find(".//include") is not None or root.find(".//mesh") is not None
    ):
        raise ModelError(
            f"{where}: Pinocchio's reader takes only the first of the {len(bodies)} bodies in "
            "<worldbody>; put them into one <body> without a joint"
        )
    ground = ElementTree.SubElement(world, "body", {"name": "world_bodies"})
    for body in bodies:
        world.remove(body)
        ground.append(body)
    return ElementTree.tostring(root, encoding="unicode"), None


def _read(text: str, path: Path | None, where: str) -> tuple[pinocchio.Model, list]:  # type: ignore[type-arg]
    try:
        if path is not None:
            return pinocchio.buildModelAndLegacyConstraintsFromMJCF(str(path))
        with tempfile.TemporaryDirectory() as directory:
            file = Path(directory) / "model.xml"
            file.write_text(text, encoding="utf-8")
            return pinocchio.buildModelAndLegacyConstraintsFromMJCF(str(file))
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{where}: Pinocchio cannot read this MJCF: {error}") from error


def _joint(
    model: pinocchio.Model, data: pinocchio.Data, index: int, at: str
) -> tuple[str, np.ndarray]:
    """Return type and axis of a joint of Pinocchio's model."""
    joint = model.joints[index]
    name = joint.shortname()
    axis = np.array([1.0, 0.0, 0.0])
    if name == "JointModelFreeFlyer":
        return "floating", axis
    if name == "JointModelSpherical":
        return "spherical", axis
    if joint.nv != 1:
        raise ModelError(
            f"{at}: several joints on one body ({name}) are not supported; put a body between them"
        )
    column = np.asarray(data.joints[index].S).ravel()
    angular = bool(np.any(column[3:]))
    axis = column[3:] if angular else column[:3]
    if not angular:
        return "prismatic", axis
    return "continuous" if joint.nq == 2 else "revolute", axis
