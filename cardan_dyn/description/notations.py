"""Notations: the ways in which other programs write loops beside a URDF's tree.

URDF+ `<loop>` (Chignoli et al., arXiv 2411.19753) comes first, then NVIDIA Isaac's `<loop_joint>`,
then Gepetto's YAML file beside the URDF. Where a description uses several, they must say the same.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError, choices
from .description import LoopDescription
from .elements import JOINT_TYPES, check_unique, loop
from .encoding import yaml_text

GEPETTO_TYPES = {"6d": "fixed", "3d": "spherical"}
"""Gepetto's word for a closure to the type of the loop that it is."""

_UNIVERSAL = re.compile(r"ujoint_([xyz])([xyz])", re.IGNORECASE)
"""Gepetto's word for a universal joint, with the axes of its parent's and its child's side."""

_READ_AHEAD = 100_000
"""Bytes of a file in which loops are looked for, so that no large file is read in vain."""
_Content = dict[object, object]
"""What a YAML file says, by key."""


@dataclass(frozen=True, eq=False)
class ChangedType:
    """The type that a file beside a URDF gives to a joint.

    Attributes:
        type: one of `elements.TREE_TYPES`.
        axes: `(3,)` unit axes of a universal joint; none where the URDF's own axis counts.
    """

    type: str
    axes: tuple[np.ndarray, ...] = ()


@dataclass(frozen=True, eq=False)
class Gepetto:
    """What Gepetto's YAML file adds to a URDF.

    Attributes:
        path: the file.
        loops: the closures.
        motors: names of the driven joints.
        joint_types: joints whose type it changes.
        warnings: names of joints in it that do not exist, and were passed over.
    """

    path: Path
    loops: tuple[LoopDescription, ...]
    motors: tuple[str, ...]
    joint_types: dict[str, ChangedType]
    warnings: tuple[str, ...] = ()


def agreed(
    robot: ElementTree.Element, links: Collection[str], extra: Gepetto | None, where: str
) -> tuple[tuple[LoopDescription, ...], str]:
    """Return the loops of a description, and which notation they came from.

    Args:
        robot: outermost element of the URDF.
        links: names of all links.
        extra: what a file beside the URDF says.
        where: how messages name the source of the text.

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
        f"Gepetto {extra.path.name}" if extra else "": extra.loops if extra else (),
    }
    written = {notation: loops for notation, loops in by_notation.items() if loops}
    if not written:
        return (), "no loops"
    used, *repeating = written
    for notation in repeating:
        if _link_pairs(written[notation]) != _link_pairs(written[used]):
            raise ModelError(
                f"{where}: {used} and {notation} close different loops: "
                f"{choices(map(str, _link_pairs(written[used])))} against "
                f"{choices(map(str, _link_pairs(written[notation])))}; keep one of them"
            )
    remarks = "".join(f"; {notation} says the same and is not used" for notation in repeating)
    return written[used], used + remarks


def _link_pairs(loops: tuple[LoopDescription, ...]) -> list[tuple[str, ...]]:
    """Return the pairs of links that loops connect, whichever of them is the predecessor."""
    return sorted(tuple(sorted((loop.predecessor, loop.successor))) for loop in loops)


def gepetto(
    path: Path, robot: ElementTree.Element, joints: set[str], strict: bool = True
) -> Gepetto | None:
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
    content = _content(existing[0], where)
    if content is None:
        return None
    loops = _loops(content, robot, where)
    motors = _names(content.get("name_mot", []), f"{where}: name_mot")
    joint_types = _joint_types(content, where)
    check_unique(motors, "name_mot", where)
    named = [*motors, *joint_types]
    unknown = [name for name in dict.fromkeys(named) if name not in joints]
    if strict:
        _check_joints(named, joints, where)
    return Gepetto(
        existing[0],
        loops,
        tuple(name for name in motors if name in joints),
        {name: changed for name, changed in joint_types.items() if name in joints},
        tuple(f"{where}: joint {name!r} does not exist and was passed over" for name in unknown),
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
    content: _Content, robot: ElementTree.Element, where: str
) -> tuple[LoopDescription, ...]:
    """Return the closures that a file lists, welds where it does not state their types."""
    pairs = content["closed_loop"]
    if not isinstance(pairs, list):
        raise ModelError(f"{where}: closed_loop is not a list of pairs of names")
    types = _names(content.get("type", ["6d"] * len(pairs)), f"{where}: type")
    if len(types) != len(pairs):
        raise ModelError(f"{where}: {len(pairs)} closed_loop but {len(types)} type entries")
    frames = _frames(robot)
    return tuple(
        _loop(count, _names(pair, f"{where}: closed_loop entry {count}"), kind, frames, where)
        for count, (pair, kind) in enumerate(zip(pairs, types, strict=True), start=1)
    )


def _joint_types(content: _Content, where: str) -> dict[str, ChangedType]:
    """Return the joints to which a file gives another type than the URDF, and those types."""
    names = _names(content.get("joint_name", []), f"{where}: joint_name")
    kinds = _names(content.get("joint_type", []), f"{where}: joint_type")
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


def _check_joints(names: list[str], joints: set[str], where: str) -> None:
    for name in names:
        if name not in joints:
            raise ModelError(
                f"{where}: joint {name!r} does not exist; joints: {choices(joints, name)}"
            )


def _content(path: Path, where: str) -> _Content | None:
    """Return what a YAML file says about loops, None if it is about something else.

    Raises:
        ModelError: it cannot be read, or contains a key twice.
    """
    import yaml

    try:
        loader = yaml.SafeLoader(yaml_text(path.read_bytes(), where))
        try:
            node = loader.get_single_node()
            content = None if node is None else loader.construct_document(node)
        finally:
            loader.dispose()
    except Exception as error:
        # PyYAML raises errors of many types, on malformed scalars and deep nesting for instance.
        detail = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"{where}: cannot be read as YAML: {detail}") from error
    if not isinstance(content, dict) or "closed_loop" not in content:
        return None
    # The dictionary silently keeps the last of equal keys, so the keys of the text are checked.
    keys = node.value if isinstance(node, yaml.MappingNode) else []
    check_unique([key.value for key, _ in keys if isinstance(key, yaml.ScalarNode)], "key", where)
    return content


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


def _names(value: object, at: str) -> list[str]:
    """Return a value of the file that has to be a list of names."""
    if not isinstance(value, list):
        raise ModelError(f"{at} is not a list of names")
    for item in value:
        if not isinstance(item, str):
            raise ModelError(
                f"{at}: {type(item).__name__} is not a name; what YAML takes for something else, "
                "like 1 or no, needs quotes"
            )
    return value
