"""Beside: YAML files beside a URDF that list its loops.

Gepetto's file has the name of the URDF. The robots of its `example-parallel-robots` have pairs of
frames, `closed_loop`, with their types, 6d or 3d; motors, `name_mot`; and joints of another type
than in the URDF.

The file `loop_closures.yaml` comes from two programs. scikit-robot's `RobotAssembly` and its
relative sw2robot (SolidWorks, Inventor) list `closures`, hinges that the tree had to cut:

    closures: [{link_a: crank, link_b: rod, point: [0.1, 0, 0], axis: [0, 0, 1]}]
    dependent: [elbow]      # joints that the loops decide; their <mimic>, if any, is approximate
    independent: [motor]

with point and axis in the root's frame at zero. The humanoid RoboNex (Fusion 360) lists

    pin_loops: [{name: knee, parent: crank, child: rod, parent_xyz: [...], child_xyz: [...],
                 axis: [0, 1, 0]}]
    ball_loops: [{name: ankle, parent: rod, child: foot, parent_xyz: [...], child_xyz: [...]}]
    ball_upgrades: [joint]  # hinges of the URDF that are balls
    actuated_joints: [motor]

where all links have parallel axes at zero. scikit-robot writes the file beside the URDF, the others
one directory above it, where the URDF is in a directory `urdf`, or in `config` there.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from ...kit.frozen import FrozenDict
from .description import X_AXIS, LoopDescription, placed_links
from .elements import (
    JOINT_TYPES,
    at_point,
    check_unique,
    direction,
    ends_of,
    file_text,
    names,
    numbers,
    one_of,
    placement,
)
from .words import unknown_keys

LOOP_CLOSURES = "loop_closures.yaml"
"""Name of the file in which several programs list loops, whatever the URDF is called."""
GEPETTO_TYPES = {"6d": "fixed", "3d": "spherical"}
"""Gepetto's word for a closure to the type of the loop that it is."""
_GEPETTO_KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
_YAML = re.compile(r"\.ya?ml$")
_UNIVERSAL = re.compile(r"ujoint_([xyz])([xyz])", re.IGNORECASE)
"""Gepetto's word for a universal joint, with the axes of its parent's and its child's side."""
_READ_AHEAD = 100_000
"""Bytes of a file in which loops are looked for, so that no large file is read in vain."""
_PLACES = ("parent_xyz", "child_xyz")
_LISTS = {
    "closures": ("link_a", "link_b", "point", "axis"),
    "pin_loops": ("parent", "child", *_PLACES, "axis"),
    "ball_loops": ("parent", "child", *_PLACES),
}
"""Keys of `loop_closures.yaml` that list loops, and those of their entries, first of the links."""
_JOINTS = ("dependent", "independent", "ball_upgrades", "actuated_joints")
"""Keys of that file that list joints."""
_PARALLEL = 1e-6
"""Greatest difference between the axes of two links that count as parallel: what angles written
with six digits have."""
YamlContent = dict[object, object]
"""What a YAML file says, by key."""
_Entry = Mapping[object, object]


class ChangedType(NamedTuple):
    """The type that a file beside a URDF gives to a joint.

    Attributes:
        type: one of `elements.TREE_TYPES`.
        axes: `(3,)` unit axes of a universal joint; none where the URDF's own axis counts.
    """

    type: str
    axes: tuple[()] | tuple[Array, Array] = ()


class Beside(NamedTuple):
    """What a YAML file adds to a URDF.

    Attributes:
        path: the file.
        notation: who writes such files.
        text: its text, from which the proof reads the numbers again.
        loops: the closures.
        motors: names of the driven joints.
        joint_types: joints whose type it changes.
        solved: joints that its loops decide, whatever they mimic.
        warnings: what in it does not belong to the URDF, and was passed over.
    """

    path: Path
    notation: str
    text: str | bytes
    loops: tuple[LoopDescription, ...]
    motors: tuple[str, ...] = ()
    joint_types: Mapping[str, ChangedType] = FrozenDict({})
    solved: frozenset[str] = frozenset()
    warnings: tuple[str, ...] = ()


def file_beside(robot: Element, where: str, path: Path, strict: bool) -> Beside | None:
    """Return what a YAML file says about a URDF, None where there is no such file.

    Args:
        robot: outermost element of the URDF.
        where: how messages name it.
        path: of the URDF.
        strict: whether names that do not exist are refused; else what names them is passed over.

    Raises:
        ModelError: a file is malformed, names a frame, link or joint that does not exist, or there
            are two.
    """
    folder = path.parent
    places = [f"{folder}"]
    if folder.name == "urdf":
        places += [f"{folder.parent}", f"{folder.parent}/config"]
    files = (
        [f"{folder}/{path.stem}.yaml", f"{folder}/{path.stem}.yml"],
        [f"{place}/{LOOP_CLOSURES}" for place in places],
    )
    # Most descriptions have none, and a path for each would take ten times as long.
    existing = [next(filter(os.path.isfile, each), "") for each in files]
    if not any(existing):
        return None
    joints = set(names(robot, "joint", where))
    readers = (gepetto, _loop_closures)
    listed = [
        reader(Path(file), robot, joints, strict)
        for reader, file in zip(readers, existing, strict=True)
        if file
    ]
    found = [item for item in listed if item is not None]
    if len(found) > 1:
        paths = " and ".join(str(item.path) for item in found)
        raise ModelError(f"{where}: both {paths} list its loops; keep one of them")
    return found[0] if found else None


def yaml_content(text: str | bytes, where: str) -> YamlContent:
    """Return the content of a YAML text; none where it is no mapping.

    Raises:
        ModelError: it is malformed, or contains a key twice.
    """
    import yaml

    try:
        loader = yaml.SafeLoader(text)
        try:
            node = loader.get_single_node()
            content = None if node is None else loader.construct_document(node)
        finally:
            loader.dispose()
    except Exception as error:
        # PyYAML raises errors of many types, on malformed scalars and deep nesting for instance.
        detail = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"{where}: cannot be read as YAML: {detail}") from error
    if not isinstance(content, dict):
        return {}
    # The dictionary silently keeps the last of equal keys, so the keys of the text are checked.
    keys = node.value if isinstance(node, yaml.MappingNode) else []
    check_unique([key.value for key, _ in keys if isinstance(key, yaml.ScalarNode)], "key", where)
    return content


def list_of_names(value: object, at: str) -> list[str]:
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


def unknown_joints(names: list[str], joints: set[str], where: str, strict: bool) -> list[str]:
    """Return warnings about names of joints that do not exist.

    Raises:
        ModelError: there are some, and `strict` refuses them.
    """
    unknown = [name for name in dict.fromkeys(names) if name not in joints]
    if strict and unknown:
        raise ModelError(
            f"{where}: joint {unknown[0]!r} does not exist; joints: "
            f"{choices(joints, unknown[0])}; load(..., strict=False) passes it over"
        )
    return [f"{where}: joint {name!r} does not exist and was passed over" for name in unknown]


def gepetto(file: Path, robot: Element, joints: set[str], strict: bool = True) -> Beside | None:
    """Read Gepetto's YAML file of the same name beside a URDF; return None where it lists no loops.

    Args:
        file: the file.
        robot: outermost element of the URDF.
        joints: names of its joints.
        strict: whether names of joints that do not exist are refused; else they are passed over.

    Raises:
        ModelError: the file is malformed, or names a frame or joint that does not exist.
    """
    where = str(file)
    text = file_text(file, where)
    content = yaml_content(text, where)
    unknown = unknown_keys(content, _GEPETTO_KEYS, where, strict)
    if "closed_loop" not in content:
        return None
    loops = _gepetto_loops(content, robot, where)
    motors = _names_at(content, "name_mot", where)
    changed, kinds = (_names_at(content, key, where) for key in ("joint_name", "joint_type"))
    check_unique(changed, "joint_name", where)
    check_unique(motors, "name_mot", where)
    if len(changed) != len(kinds):
        raise ModelError(f"{where}: {len(changed)} joint_name but {len(kinds)} joint_type entries")
    types = {
        name: _changed_type(kind, f"{where}: joint_type")
        for name, kind in zip(changed, kinds, strict=True)
    }
    unknown += unknown_joints([*motors, *changed], joints, where, strict)
    return Beside(
        path=file,
        notation=f"Gepetto {file.name}",
        text=text,
        loops=loops,
        motors=tuple(name for name in motors if name in joints),
        joint_types={name: types[name] for name in changed if name in joints},
        warnings=tuple(unknown),
    )


def _names_at(content: YamlContent, key: str, where: str) -> list[str]:
    """Return the names that a key of a file lists; none without it."""
    return list_of_names(content.get(key) or [], f"{where}: {key}")


def unread_files(path: Path) -> list[str]:
    """Return warnings about files beside a URDF that list loops, but belong to no URDF by name.

    Args:
        path: of the URDF.
    """
    try:
        listed = os.listdir(path.parent)  # noqa: PTH208  # A path for each takes ten times as long.
    except OSError:
        return []
    return [
        f"{path}: {file.name} beside it lists loops and is not read, since it has another name; "
        f"rename it to {path.stem}.yaml if the loops are those of this URDF"
        for file in map(path.with_name, sorted(filter(_YAML.search, listed)))
        if not file.with_suffix(".urdf").exists() and _lists_loops(file)
    ]


def _lists_loops(file: Path) -> bool:
    try:
        with file.open("rb") as stream:
            return b"closed_loop" in stream.read(_READ_AHEAD)
    except OSError:
        return False


def _gepetto_loops(content: YamlContent, robot: Element, where: str) -> tuple[LoopDescription, ...]:
    """Return the closures that a file lists, welds where it does not state their types."""
    pairs = content["closed_loop"]
    if not isinstance(pairs, list):
        raise ModelError(f"{where}: closed_loop is not a list of pairs of names")
    types = _names_at(content, "type", where) if "type" in content else ["6d"] * len(pairs)
    if len(types) != len(pairs):
        raise ModelError(f"{where}: {len(pairs)} closed_loop but {len(types)} type entries")
    frames = _frames(robot)
    return tuple(
        _gepetto_loop(
            count, list_of_names(pair, f"{where}: closed_loop entry {count}"), kind, frames, where
        )
        for count, (pair, kind) in enumerate(zip(pairs, types, strict=True), start=1)
    )


def _changed_type(word: str, at: str) -> ChangedType:
    """Return what a word for a type of joints means."""
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


def _gepetto_loop(
    count: int, pair: list[str], kind: str, frames: dict[str, set[str]], where: str
) -> LoopDescription:
    one_of(kind.lower(), GEPETTO_TYPES, "type", where, "is unknown")
    if len(pair) != 2:
        raise ModelError(f"{where}: closed_loop entry {pair} is not a pair of frames")
    links: list[str] = []
    for frame in pair:
        if len(frames[one_of(frame, frames, "frame", where)]) > 1:
            raise ModelError(
                f"{where}: frame {frame!r} is a link and a joint, which move different links: "
                f"{choices(frames[frame])}; rename one of them"
            )
        links += frames[frame]
    kind = GEPETTO_TYPES[kind.lower()]
    first, second = links
    return LoopDescription(f"loop_{count}", kind, first, second, np.eye(4), np.eye(4))


def _frames(robot: Element) -> dict[str, set[str]]:
    """Return the names of Pinocchio's frames, those of links and joints, with the links they move.

    A link and a joint of the same name may belong to different links.
    """
    frames = {link.get("name", ""): {link.get("name", "")} for link in robot.findall("link")}
    for joint in robot.findall("joint"):
        _, child = ends_of(joint)
        if child:
            frames.setdefault(joint.get("name", ""), set()).add(child)
    return frames


def _loop_closures(file: Path, robot: Element, joints: set[str], strict: bool) -> Beside | None:
    """Read a file of loop closures; return None where it lists none."""
    where = str(file)
    text = file_text(file, where)
    content = yaml_content(text, where)
    keys = {*_LISTS, *_JOINTS, "ball_limit_deg"}
    warnings = unknown_keys(content, keys, where, strict)
    if strict and keys.isdisjoint(content):
        raise ModelError(f"{where}: it lists no loops; keys: {choices(keys)}")
    at_zero, loops, entries = placements_at_zero(robot, where), [], _entries(content, where)
    for _, entry, kind in entries:
        warnings += unknown_keys(entry, ("name", *_LISTS[kind]), f"{where}: {kind}", strict)
    for name, entry, kind in entries:
        links = [str(entry.get(key, "")) for key in _LISTS[kind][:2]]
        unknown = [link for link in links if link not in at_zero]
        if unknown and strict:
            raise ModelError(
                f"{where}: {name}: link {unknown[0]!r} does not exist in the URDF; links: "
                f"{choices(at_zero, unknown[0])}; load(..., strict=False) passes the loop over"
            )
        if unknown:
            warnings.append(f"{where}: {name}: no link {unknown[0]!r}; the loop was passed over")
        else:
            loops.append(_closure(name, entry, kind, links, at_zero, f"{where}: {name}"))
    if not entries:
        return None
    solved, motors, balls, more = (_names_at(content, key, where) for key in _JOINTS)
    unknown_names = unknown_joints([*solved, *motors, *balls, *more], joints, where, strict)
    if "ball_limit_deg" in content:
        warnings.append(f"{where}: ball_limit_deg left out: limits play no part")
    return Beside(
        path=file,
        notation=LOOP_CLOSURES,
        text=text,
        loops=tuple(loops),
        motors=tuple(name for name in dict.fromkeys([*motors, *more]) if name in joints),
        joint_types={name: ChangedType("spherical") for name in balls if name in joints},
        # Where all loops were passed over, nothing but their mimics decides these joints.
        solved=frozenset(solved) & joints if loops else frozenset(),
        warnings=(*dict.fromkeys(warnings), *unknown_names),
    )


def placements_at_zero(robot: Element, where: str) -> dict[str, Array]:
    """Return the `(4, 4)` placements of all links in the root, with every joint at zero.

    Links that no chain of joints connects to a root, which the check of the tree refuses later, are
    at the root.
    """
    joints = [
        # The reader of joints says what is missing.
        (*ends_of(joint), placement(joint, f"{where}: joint {joint.get('name')!r}"))
        for joint in robot.findall("joint")
    ]
    return placed_links([link.get("name", "") for link in robot.findall("link")], joints)


def _entries(content: YamlContent, where: str) -> list[tuple[str, _Entry, str]]:
    """Return the loops of a file: names, what it says of them, and the keys of their lists."""
    result = []
    for key in _LISTS:
        listed = content.get(key) or []
        if not isinstance(listed, list) or not all(isinstance(item, dict) for item in listed):
            raise ModelError(f"{where}: {key} is not a list of loops, each with its links")
        for count, entry in enumerate(listed, start=1):
            name = entry.get("name") or (f"loop_{count}" if key == "closures" else f"{key}_{count}")
            if not isinstance(name, str):
                raise ModelError(f"{where}: {key}: {name!r} is not a name; it needs quotes")
            result.append((name, entry, key))
    return result


def _closure(
    name: str, entry: _Entry, kind: str, links: list[str], at_zero: Mapping[str, Array], at: str
) -> LoopDescription:
    first, second = links
    axis = X_AXIS
    if kind != "ball_loops":
        axis = direction(_vector(entry, "axis", at), f"{at}: the axis")
    if kind == "closures":
        point = at_point(_vector(entry, "point", at))
        ends = [np.linalg.solve(at_zero[link], point) for link in links]
    else:
        ends = [at_point(_vector(entry, key, at)) for key in _PLACES]
    turned = at_zero[first][:3, :3] - at_zero[second][:3, :3]
    if kind == "pin_loops" and np.max(np.abs(turned)) > _PARALLEL:
        raise ModelError(
            f"{at}: the frames of {first!r} and {second!r} are not parallel at zero, so it is open "
            "in which of them the axis is meant; write <loop>"
        )
    loop_type = "spherical" if kind == "ball_loops" else "revolute"
    return LoopDescription(name, loop_type, first, second, ends[0], ends[1], axis)


def _vector(entry: _Entry, key: str, at: str) -> Array:
    value = entry.get(key)
    # YAML takes 1e-3 for a text, since it has no point.
    stated = " ".join(map(str, value)) if isinstance(value, list) else str(value or "")
    return numbers(stated, 3, "", f"{at}: {key}")
