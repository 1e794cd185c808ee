"""Loop closures: hinges and balls in the file `loop_closures.yaml` near a URDF.

Two programs write such files. scikit-robot's `RobotAssembly` and its relative sw2robot
(SolidWorks, Inventor) list `closures`, hinges that the tree had to cut:

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

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..errors import ModelError, choices
from .beside import (
    LOOP_CLOSURES,
    Beside,
    ChangedType,
    YamlContent,
    check_joints,
    list_of_names,
    passed_over,
    yaml_content,
)
from .description import LoopDescription
from .elements import GREATEST, file_text, placement
from .words import unknown_keys

_LISTS = ("closures", "pin_loops", "ball_loops")
"""Keys of a file that list loops."""
_KEYS = {
    "": {*_LISTS, "dependent", "independent", "ball_upgrades", "ball_limit_deg", "actuated_joints"},
    "closures": {"name", "link_a", "link_b", "point", "axis"},
    "pin_loops": {"name", "parent", "child", "parent_xyz", "child_xyz", "axis"},
    "ball_loops": {"name", "parent", "child", "parent_xyz", "child_xyz"},
}
"""Keys of a file, and of the entries of its lists, that are known."""
_PARALLEL = 1e-6
"""Greatest difference between the axes of two links that count as parallel: what angles written
with six digits have."""


def loop_closures(
    path: Path, file: Path, robot: ElementTree.Element, joints: set[str], strict: bool = True
) -> Beside | None:
    """Read a file of loop closures; return None where it lists none.

    Args:
        path: of the URDF.
        file: of its loop closures, see `beside.loop_closures_of`.
        robot: outermost element of the URDF.
        joints: names of its joints.
        strict: whether names that do not exist are refused; else what names them is passed over.

    Raises:
        ModelError: the file is malformed, or names a link or joint that does not exist.
    """
    where = str(file)
    text = file_text(file, where)
    content = yaml_content(text, where)
    warnings = _unknown_keys(content, where, strict)
    if strict and not any(key in _KEYS[""] for key in content):
        raise ModelError(f"{where}: it lists no loops; keys: {choices(_KEYS[''])}")
    if not any(content.get(key) for key in _LISTS):
        return None
    at_zero = placements_at_zero(robot, where)
    loops = []
    for name, entry, kind in _entries(content, where):
        unknown = [link for link in _ends(entry, kind) if link not in at_zero]
        if unknown and strict:
            raise ModelError(
                f"{where}: {name}: link {unknown[0]!r} does not exist in {path.name}; links: "
                f"{choices(at_zero, unknown[0])}; load(..., strict=False) passes the loop over"
            )
        if unknown:
            warnings.append(f"{where}: {name}: no link {unknown[0]!r}; the loop was passed over")
        else:
            loops.append(_loop(name, entry, kind, at_zero, f"{where}: {name}"))
    named = {
        key: list_of_names(content.get(key) or [], f"{where}: {key}")
        for key in ("dependent", "independent", "ball_upgrades", "actuated_joints")
    }
    # Where all loops were passed over, nothing but their mimics decides these joints.
    solved = frozenset(named["dependent"]) & joints if loops else frozenset()
    every = [name for names in named.values() for name in names]
    if strict:
        check_joints(every, joints, where)
    motors = [*named["independent"], *named["actuated_joints"]]
    if "ball_limit_deg" in content:
        warnings.append(f"{where}: ball_limit_deg left out: limits play no part")
    return Beside(
        path=file,
        notation=LOOP_CLOSURES,
        text=text,
        loops=tuple(loops),
        motors=tuple(name for name in dict.fromkeys(motors) if name in joints),
        joint_types={
            name: ChangedType("spherical") for name in named["ball_upgrades"] if name in joints
        },
        solved=solved,
        warnings=(*warnings, *passed_over(every, joints, where)),
    )


def placements_at_zero(robot: ElementTree.Element, where: str) -> dict[str, Array]:
    """Return the `(4, 4)` placements of all links in the root, with every joint at zero.

    Links that no chain of joints connects to a root, which the check of the tree refuses later, are
    at the root.
    """
    children: dict[str, list[tuple[str, Array]]] = {}
    carried = set()
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            continue  # The reader of joints says what is missing.
        origin = placement(joint, f"{where}: joint {joint.get('name')!r}")
        children.setdefault(parent.get("link", ""), []).append((child.get("link", ""), origin))
        carried.add(child.get("link", ""))
    placed = {
        link.get("name", ""): np.eye(4)
        for link in robot.findall("link")
        if link.get("name") not in carried
    }
    waiting = list(placed)
    while waiting:
        parent_link = waiting.pop()
        for link, origin in children.get(parent_link, []):
            if link not in placed:
                placed[link] = placed[parent_link] @ origin
                waiting.append(link)
    return {link.get("name", ""): np.eye(4) for link in robot.findall("link")} | placed


_Entry = Mapping[object, object]


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


def _unknown_keys(content: YamlContent, where: str, strict: bool) -> list[str]:
    """Return warnings about keys that are not known; see `unknown_keys` for errors."""
    warnings = unknown_keys(content, _KEYS[""], where, strict)
    for _, entry, kind in _entries(content, where):
        warnings += unknown_keys(entry, _KEYS[kind], f"{where}: {kind}", strict)
    return list(dict.fromkeys(warnings))


def _ends(entry: _Entry, kind: str) -> list[str]:
    """Return the links that an entry names, empty where it names none."""
    keys = ("link_a", "link_b") if kind == "closures" else ("parent", "child")
    return [str(entry.get(key, "")) for key in keys]


def _loop(
    name: str, entry: _Entry, kind: str, at_zero: Mapping[str, Array], at: str
) -> LoopDescription:
    """Return the loop of an entry.

    Args:
        name: of the loop.
        entry: what the file says of it.
        kind: key of its list.
        at_zero: placements of the links in the root.
        at: how messages name it.
    """
    links = _ends(entry, kind)
    first, second = links
    if first == second:
        raise ModelError(f"{at}: both links are {first!r}")
    axis = np.array([1.0, 0.0, 0.0]) if kind == "ball_loops" else _axis(entry, at)
    if kind == "closures":
        point = _at_point(_vector(entry, "point", at))
        ends = [np.linalg.solve(at_zero[link], point) for link in links]
    else:
        ends = [_at_point(_vector(entry, key, at)) for key in ("parent_xyz", "child_xyz")]
    turned = at_zero[first][:3, :3] - at_zero[second][:3, :3]
    if kind == "pin_loops" and np.max(np.abs(turned)) > _PARALLEL:
        raise ModelError(
            f"{at}: the frames of {first!r} and {second!r} are not parallel at zero, so it is open "
            "in which of them the axis is meant; write <loop>"
        )
    loop_type = "spherical" if kind == "ball_loops" else "revolute"
    return LoopDescription(name, loop_type, first, second, ends[0], ends[1], axis, axis)


def _at_point(point: Array) -> Array:
    """Return the `(4, 4)` placement at a point, axes parallel."""
    result = np.eye(4)
    result[:3, 3] = point
    return result


def _axis(entry: _Entry, at: str) -> Array:
    """Return the `(3,)` unit axis of an entry."""
    axis = _vector(entry, "axis", at)
    length = float(np.linalg.norm(axis))
    if length < 1.0 / GREATEST:
        raise ModelError(f"{at}: the axis {axis.tolist()} has no direction")
    return axis / length


def _vector(entry: _Entry, key: str, at: str) -> Array:
    """Return three numbers of an entry."""
    value = entry.get(key)
    # YAML takes 1e-3 for a text, since it has no point; true and false are numbers to Python.
    if not isinstance(value, list) or any(isinstance(item, (bool, list)) for item in value):
        raise ModelError(f"{at}: {key} {value!r} is not 3 finite number(s)")
    try:
        vector = np.array([float(item) for item in value])
    except (TypeError, ValueError, OverflowError) as error:
        raise ModelError(f"{at}: {key} {value!r} is not 3 finite number(s)") from error
    if vector.shape != (3,) or not np.all(np.abs(vector) <= GREATEST):
        raise ModelError(f"{at}: {key} {value!r} is not 3 finite number(s)")
    return vector
