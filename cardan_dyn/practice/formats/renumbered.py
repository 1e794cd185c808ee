"""Renumbered: joints, loops and links with numbers from where things stand in the world.

Second readings find that out, each in its own way; no first reading uses it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from ...core.description.description import JointDescription, JointOrLoop, LinkDescription
from ...kit.arrays import Array

_Item = TypeVar("_Item", bound=JointOrLoop)


def placed_at(
    item: _Item, frames: Sequence[Array], links: Mapping[str, Array], *axes: Array
) -> _Item:
    """Return a joint or loop with other numbers.

    Args:
        item: what is known of it.
        frames: `(4, 4)` placements of its frame in the world [m], of a loop at both ends.
        links: those of links by name.
        axes: `(3,)` its axes in its frame; none where they stay.
    """
    axes = axes or (item.axis, item.axis_2)
    placed: dict[str, Any] = {
        field: np.linalg.solve(links[getattr(item, link)], frame)
        for (link, field), frame in zip(item.ENDS, frames, strict=True)
    }
    if isinstance(item, JointDescription):
        placed["child_placement"] = np.linalg.solve(frames[0], links[item.child])
    return replace(item, **placed, axis=axes[0], axis_2=axes[-1])


def link_in(name: str, mass: float, frame: Array, tensor: Array) -> LinkDescription:
    """Return a link, from the `(4, 4)` frame at its centre and the inertia in its axes."""
    inertia = np.einsum("ij,jk,lk->il", frame[:3, :3], tensor, frame[:3, :3])
    return LinkDescription(name, mass, frame[:3, 3], inertia)


def link_of(name: str, parameters: Array, frame: Array) -> LinkDescription:
    """Return a link with mass by Pinocchio's dynamic parameters `(10,)`, as seen in a frame of it.

    They are mass, first and second moments about the `(4, 4)` frame.
    """
    mass, first, (xx, xy, yy, xz, yz, zz) = parameters[0], parameters[1:4], parameters[4:]
    centre = first / mass if mass else first
    about_frame = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    tensor = about_frame - (centre @ first) * np.eye(3) + np.outer(centre, first)
    at_centre = frame.copy()
    at_centre[:3, 3] += frame[:3, :3] @ centre
    return link_in(name, float(mass), at_centre, tensor)
