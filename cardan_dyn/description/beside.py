"""Beside: YAML files beside a URDF, and what those that list loops add to it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import ModelError, choices
from .description import LoopDescription
from .elements import check_unique

LOOP_CLOSURES = "loop_closures.yaml"
"""Name of the file in which several programs list loops, whatever the URDF is called."""
YamlContent = dict[object, object]
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
class Beside:
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
    joint_types: dict[str, ChangedType] = field(default_factory=dict)
    solved: frozenset[str] = frozenset()
    warnings: tuple[str, ...] = ()


def loop_closures_of(path: Path) -> Path | None:
    """Return the file `loop_closures.yaml` that belongs to a URDF, None without one.

    It stands beside the URDF; or one directory above it or in `config` there, where the URDF is in
    a directory called `urdf`.
    """
    places = [path.parent]
    if path.parent.name == "urdf":
        places += [path.parent.parent, path.parent.parent / "config"]
    files = (place / LOOP_CLOSURES for place in places)
    return next((file for file in files if file.is_file()), None)


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


def check_joints(names: list[str], joints: set[str], where: str) -> None:
    """Refuse names of joints that do not exist."""
    for name in names:
        if name not in joints:
            raise ModelError(
                f"{where}: joint {name!r} does not exist; joints: {choices(joints, name)}; "
                "load(..., strict=False) passes it over"
            )


def passed_over(names: list[str], joints: set[str], where: str) -> tuple[str, ...]:
    """Return warnings about names of joints that do not exist."""
    return tuple(
        f"{where}: joint {name!r} does not exist and was passed over"
        for name in dict.fromkeys(names)
        if name not in joints
    )
