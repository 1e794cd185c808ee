"""Gepetto: loops in a YAML file of the same name beside a URDF.

So the robots of Gepetto's `example-parallel-robots` have theirs: pairs of frames, `closed_loop`,
with their types, 6d or 3d; motors, `name_mot`; and joints of another type than in the URDF.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError, choices
from .beside import (
    Beside,
    ChangedType,
    YamlContent,
    check_joints,
    list_of_names,
    passed_over,
    yaml_content,
)
from .description import LoopDescription
from .elements import JOINT_TYPES, check_unique, file_text
from .words import unknown_keys

GEPETTO_TYPES = {"6d": "fixed", "3d": "spherical"}
"""Gepetto's word for a closure to the type of the loop that it is."""

_KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
"""Keys of a file that are known."""
_UNIVERSAL = re.compile(r"ujoint_([xyz])([xyz])", re.IGNORECASE)
"""Gepetto's word for a universal joint, with the axes of its parent's and its child's side."""

_READ_AHEAD = 100_000
"""Bytes of a file in which loops are looked for, so that no large file is read in vain."""


def gepetto(
    path: Path, robot: ElementTree.Element, joints: set[str], strict: bool = True
) -> Beside | None:
    """Read Gepetto's YAML file of the same name beside a URDF, if there is one.

    Args:
        path: of the URDF.
        robot: its outermost element.
        joints: names of its joints.
        strict: whether names of joints that do not exist are refused; else they are passed over.

    Raises:
        ModelError: the file is malformed, or names a frame or joint that does not exist.
    """
    candidates = [path.with_suffix(suffix) for suffix in (".yaml", ".yml")]
    existing = [candidate for candidate in candidates if candidate.is_file()]
    if not existing:
        return None
    where = str(existing[0])
    text = file_text(existing[0], where)
    content = yaml_content(text, where)
    unknown = unknown_keys(content, _KEYS, where, strict)
    if "closed_loop" not in content:
        return None
    loops = _loops(content, robot, where)
    motors = list_of_names(content.get("name_mot", []), f"{where}: name_mot")
    joint_types = _joint_types(content, where)
    check_unique(motors, "name_mot", where)
    named = [*motors, *joint_types]
    if strict:
        check_joints(named, joints, where)
    return Beside(
        path=existing[0],
        notation=f"Gepetto {existing[0].name}",
        text=text,
        loops=loops,
        motors=tuple(name for name in motors if name in joints),
        joint_types={name: changed for name, changed in joint_types.items() if name in joints},
        warnings=(*unknown, *passed_over(named, joints, where)),
    )


def unread_files(path: Path) -> list[str]:
    """Return warnings about files beside a URDF that list loops, but belong to no URDF by name.

    Args:
        path: of the URDF.
    """
    return [
        f"{path}: {file.name} beside it lists loops and is not read, since it has another name; "
        f"rename it to {path.stem}.yaml if the loops are those of this URDF"
        for file in sorted(path.parent.glob("*.y*ml"))
        if not file.with_suffix(".urdf").exists() and _lists_loops(file)
    ]


def _lists_loops(file: Path) -> bool:
    try:
        with file.open("rb") as stream:
            return b"closed_loop" in stream.read(_READ_AHEAD)
    except OSError:
        return False


def _loops(
    content: YamlContent, robot: ElementTree.Element, where: str
) -> tuple[LoopDescription, ...]:
    """Return the closures that a file lists, welds where it does not state their types."""
    pairs = content["closed_loop"]
    if not isinstance(pairs, list):
        raise ModelError(f"{where}: closed_loop is not a list of pairs of names")
    types = list_of_names(content.get("type", ["6d"] * len(pairs)), f"{where}: type")
    if len(types) != len(pairs):
        raise ModelError(f"{where}: {len(pairs)} closed_loop but {len(types)} type entries")
    frames = _frames(robot)
    return tuple(
        _loop(
            count, list_of_names(pair, f"{where}: closed_loop entry {count}"), kind, frames, where
        )
        for count, (pair, kind) in enumerate(zip(pairs, types, strict=True), start=1)
    )


def _joint_types(content: YamlContent, where: str) -> dict[str, ChangedType]:
    """Return the joints to which a file gives another type than the URDF, and those types."""
    names = list_of_names(content.get("joint_name", []), f"{where}: joint_name")
    kinds = list_of_names(content.get("joint_type", []), f"{where}: joint_type")
    check_unique(names, "joint_name", where)
    if len(names) != len(kinds):
        raise ModelError(f"{where}: {len(names)} joint_name but {len(kinds)} joint_type entries")
    return {
        name: _changed_type(kind, f"{where}: joint_type")
        for name, kind in zip(names, kinds, strict=True)
    }


def _changed_type(word: str, at: str) -> ChangedType:
    """Return what a word for a type of joints means.

    Raises:
        ModelError: it is unknown, or names one axis twice.
    """
    known = JOINT_TYPES | {"spherical"}
    if word.lower() in known:
        return ChangedType(word.lower())
    universal = _UNIVERSAL.fullmatch(word)
    if not universal:
        listed = choices((*known, "UJOINT_XY and so on"), word)
        raise ModelError(f"{at} {word!r} is unknown; types: {listed}")
    first, second = ("xyz".index(axis.lower()) for axis in universal.groups())
    if first == second:
        raise ModelError(f"{at} {word!r} has the same axis twice")
    return ChangedType("universal", (np.eye(3)[first], np.eye(3)[second]))


def _loop(
    count: int, pair: list[str], kind: str, frames: dict[str, set[str]], where: str
) -> LoopDescription:
    """Return the closure between two frames.

    Args:
        count: which entry of the file it is, from 1; it has no name there.
        pair: names of the frames.
        kind: a key of `GEPETTO_TYPES`.
        frames: frame to the links that it is on.
        where: how messages name the file.
    """
    if kind.lower() not in GEPETTO_TYPES:
        raise ModelError(
            f"{where}: type {kind!r} is unknown; types: {choices(GEPETTO_TYPES, kind)}"
        )
    if len(pair) != 2:
        raise ModelError(f"{where}: closed_loop entry {pair} is not a pair of frames")
    links: list[str] = []
    for frame in pair:
        if frame not in frames:
            raise ModelError(
                f"{where}: frame {frame!r} does not exist; frames: {choices(frames, frame)}"
            )
        if len(frames[frame]) > 1:
            raise ModelError(
                f"{where}: frame {frame!r} is a link and a joint, which move different links: "
                f"{choices(frames[frame])}; rename one of them"
            )
        links += frames[frame]
    if links[0] == links[1]:
        raise ModelError(
            f"{where}: closed_loop entry {pair}: both frames are on the link {links[0]!r}"
        )
    axis = np.array([1.0, 0.0, 0.0])
    name, kind = f"loop_{count}", GEPETTO_TYPES[kind.lower()]
    return LoopDescription(name, kind, links[0], links[1], np.eye(4), np.eye(4), axis, axis)


def _frames(robot: ElementTree.Element) -> dict[str, set[str]]:
    """Return the names of Pinocchio's frames, those of links and joints, with the links they move.

    A link and a joint of the same name may belong to different links.
    """
    frames = {link.get("name", ""): {link.get("name", "")} for link in robot.findall("link")}
    for joint in robot.findall("joint"):
        child = joint.find("child")
        if child is not None:
            frames.setdefault(joint.get("name", ""), set()).add(child.get("link", ""))
    return frames
