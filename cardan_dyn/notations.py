"""Notations: the ways in which others write loops beside a URDF's tree.

URDF+ `<loop>` (Chignoli et al., arXiv 2411.19753) comes first, then NVIDIA Isaac's `<loop_joint>`,
then Gepetto's YAML file beside the URDF. Where a description uses several, they must say the same.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from .description import JointDescription, LoopDescription
from .elements import JOINT_TYPES, loop
from .errors import ModelError, choices

GEPETTO_TYPES = {"6d": "fixed", "3d": "spherical"}


@dataclass(frozen=True, eq=False)
class Gepetto:
    """What Gepetto's YAML file adds to a URDF.

    Attributes:
        path: the file.
        loops: the closures.
        motors: names of the driven joints.
        joint_types: joints whose type it changes.
    """

    path: Path
    loops: tuple[LoopDescription, ...]
    motors: tuple[str, ...]
    joint_types: dict[str, str]


def agreed(
    robot: ElementTree.Element, links: Collection[str], extra: Gepetto | None, where: str
) -> tuple[tuple[LoopDescription, ...], str]:
    """Return the loops of a description and which notation they came from.

    Raises:
        ModelError: two notations close different loops.
    """
    found = {
        "URDF+ <loop>": tuple(
            loop(item, ("predecessor", "successor"), links, where) for item in robot.findall("loop")
        ),
        "Isaac <loop_joint>": tuple(
            loop(item, ("link1", "link2"), links, where) for item in robot.findall("loop_joint")
        ),
        f"Gepetto {extra.path.name}" if extra else "": extra.loops if extra else (),
    }
    used = {name: loops for name, loops in found.items() if loops}
    if not used:
        return (), "no loops"
    first = next(iter(used))
    for other in list(used)[1:]:
        if _ends(used[other]) != _ends(used[first]):
            raise ModelError(
                f"{where}: {first} and {other} close different loops: "
                f"{choices(map(str, _ends(used[first])))} against "
                f"{choices(map(str, _ends(used[other])))}; keep one of them"
            )
    same = "".join(f"; {other} says the same and is not used" for other in list(used)[1:])
    return used[first], first + same


def _ends(loops: tuple[LoopDescription, ...]) -> list[tuple[str, ...]]:
    return sorted(tuple(sorted((loop.predecessor, loop.successor))) for loop in loops)


def changed(joint: JointDescription, extra: Gepetto) -> JointDescription:
    """Return a joint with the type that Gepetto's file gives it."""
    return replace(joint, type=extra.joint_types.get(joint.name, joint.type))


def gepetto(path: Path, robot: ElementTree.Element, joints: set[str]) -> Gepetto | None:
    """Read Gepetto's YAML file of the same name beside a URDF, if there is one.

    Args:
        path: of the URDF.
        robot: its outermost element.
        joints: names of its joints.

    Raises:
        ModelError: the file is malformed, or names a frame or joint that does not exist.
    """
    beside = [path.with_suffix(suffix) for suffix in (".yaml", ".yml")]
    existing = [candidate for candidate in beside if candidate.is_file()]
    if not existing:
        return None
    import yaml

    where = str(existing[0])
    try:
        content = yaml.safe_load(existing[0].read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ModelError(f"{where}: cannot be read as YAML: {error}") from error
    if not isinstance(content, dict) or "closed_loop" not in content:
        return None
    pairs = _strings(content["closed_loop"], f"{where}: closed_loop", nested=True)
    types = _strings(content.get("type", ["6d"] * len(pairs)), f"{where}: type")
    if len(types) != len(pairs):
        raise ModelError(f"{where}: {len(pairs)} closed_loop but {len(types)} type entries")
    frames = _frames(robot)
    loops = []
    for number, (pair, kind) in enumerate(zip(pairs, types, strict=True), start=1):
        if kind.lower() not in GEPETTO_TYPES:
            raise ModelError(f"{where}: type {kind!r} is unknown; types: {choices(GEPETTO_TYPES)}")
        if not isinstance(pair, list) or len(pair) != 2:
            raise ModelError(f"{where}: closed_loop entry {pair!r} is not a pair of frames")
        for frame in pair:
            if frame not in frames:
                raise ModelError(
                    f"{where}: frame {frame!r} does not exist; frames: {choices(frames)}"
                )
        axis = np.array([1.0, 0.0, 0.0])
        loops.append(
            LoopDescription(
                f"loop_{number}",
                GEPETTO_TYPES[kind.lower()],
                frames[pair[0]],
                frames[pair[1]],
                np.eye(4),
                np.eye(4),
                axis,
                axis,
            )
        )
    motors = tuple(_strings(content.get("name_mot", []), f"{where}: name_mot"))
    names = _strings(content.get("joint_name", []), f"{where}: joint_name")
    kinds = _strings(content.get("joint_type", []), f"{where}: joint_type")
    for name in (*motors, *names):
        if name not in joints:
            raise ModelError(f"{where}: joint {name!r} does not exist; joints: {choices(joints)}")
    known = JOINT_TYPES | {"spherical"}
    for kind in kinds:
        if kind.lower() not in known:
            raise ModelError(f"{where}: joint_type {kind!r} is unknown; types: {choices(known)}")
    if len(names) != len(kinds):
        raise ModelError(f"{where}: {len(names)} joint_name but {len(kinds)} joint_type entries")
    changed = {name: kind.lower() for name, kind in zip(names, kinds, strict=True)}
    return Gepetto(existing[0], tuple(loops), motors, changed)


def _frames(robot: ElementTree.Element) -> dict[str, str]:
    """Return names that Pinocchio gives frames, of links and joints, to the links they sit on."""
    frames = {}
    for joint in robot.findall("joint"):
        child = joint.find("child")
        if child is not None:
            frames[joint.get("name", "")] = child.get("link", "")
    return frames | {link.get("name", ""): link.get("name", "") for link in robot.findall("link")}


def _strings(value: object, at: str, nested: bool = False) -> list:  # type: ignore[type-arg]
    if not isinstance(value, list) or not all(
        isinstance(item, (str, list) if nested else str) for item in value
    ):
        raise ModelError(f"{at} is not a list of {'pairs of ' if nested else ''}names")
    return value
