"""Second reading of the numbers that stand in a file beside a URDF, for the proof.

Like `second_reading` it shares nothing with the first reader. Of the files beside a URDF, only
`loop_closures.yaml` has numbers; Gepetto's names frames.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..errors import ModelError

if TYPE_CHECKING:
    from .description import JointDescription, LoopDescription


def reread_beside(
    loops: Iterable[LoopDescription], joints: Iterable[JointDescription], text: str | bytes
) -> dict[str, LoopDescription]:
    """Return the loops that a file states, by name, with the numbers of its text.

    Args:
        loops: those that the URDF itself does not state.
        joints: those of the tree, with the numbers of the URDF.
        text: of the file.

    Raises:
        ModelError: the file states loops, and not all of these.
    """
    import yaml

    content: dict[str, Any] = yaml.safe_load(text)
    hinges = {
        entry.get("name") or f"loop_{index + 1}": entry
        for index, entry in enumerate(content.get("closures") or [])
    }
    pins = {
        entry.get("name") or f"{key}_{index + 1}": entry
        for key in ("pin_loops", "ball_loops")
        for index, entry in enumerate(content.get(key) or [])
    }
    carrier = {joint.child: joint for joint in joints}
    result = {}
    for loop in loops:
        if loop.name in hinges:
            result[loop.name] = _hinge(loop, hinges[loop.name], carrier)
        elif loop.name in pins:
            result[loop.name] = _pin(loop, pins[loop.name])
        elif hinges or pins:
            # Otherwise the first reader's numbers would prove themselves.
            raise ModelError(f"loop {loop.name!r} is not found by the second reading of the file")
    return result


def _hinge(
    loop: LoopDescription, entry: dict[str, Any], carrier: dict[str, JointDescription]
) -> LoopDescription:
    """Return a hinge whose point and axis are stated in the root's frame at zero."""
    point = np.array([float(word) for word in entry["point"]])
    ends = []
    for link in (entry["link_a"], entry["link_b"]):
        turn, place = np.eye(3), np.zeros(3)
        while link in carrier:
            joint = carrier[link]
            place = joint.origin[:3, :3] @ place + joint.origin[:3, 3]
            turn, link = joint.origin[:3, :3] @ turn, joint.parent
        end = np.eye(4)
        end[:3, :3], end[:3, 3] = turn.T, turn.T @ (point - place)
        ends.append(end)
    axis = _unit(entry)
    return replace(
        loop, predecessor_origin=ends[0], successor_origin=ends[1], axis=axis, axis_2=axis
    )


def _pin(loop: LoopDescription, entry: dict[str, Any]) -> LoopDescription:
    """Return a pin or ball whose place is stated in each of its links."""
    ends = [np.eye(4), np.eye(4)]
    for end, key in zip(ends, ("parent_xyz", "child_xyz"), strict=True):
        end[:3, 3] = [float(word) for word in entry[key]]
    axis = _unit(entry) if loop.type == "revolute" else loop.axis
    return replace(
        loop, predecessor_origin=ends[0], successor_origin=ends[1], axis=axis, axis_2=axis
    )


def _unit(entry: dict[str, Any]) -> Array:
    """Return the `(3,)` unit axis of an entry."""
    axis = np.array([float(word) for word in entry["axis"]])
    return axis / np.sqrt(axis @ axis)
