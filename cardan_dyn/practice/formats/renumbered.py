"""Renumbered: joints, loops and links with numbers from where things stand in the world.

Second readings find that out, each in its own way; no first reading uses it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...core.description.description import JointDescription, LinkDescription, LoopDescription
from ...kit.arrays import Array


def joint_at(
    joint: JointDescription, frame: Array, links: Mapping[str, Array], *axes: Array
) -> JointDescription:
    """Return a joint with other numbers.

    Args:
        joint: what is known of it.
        frame: `(4, 4)` placement of its frame in the world [m].
        links: those of links by name.
        axes: `(3,)` its axes in its frame; none where they stay.
    """
    axes = axes or (joint.axis, joint.axis_2)
    return replace(
        joint,
        origin=np.linalg.solve(links[joint.parent], frame),
        child_placement=np.linalg.solve(frame, links[joint.child]),
        axis=axes[0],
        axis_2=axes[-1],
    )


def loop_at(
    loop: LoopDescription, ends: tuple[Array, Array], links: Mapping[str, Array], *axes: Array
) -> LoopDescription:
    """Return a loop with other numbers, from its frames at both ends; see `joint_at`."""
    axes = axes or (loop.axis, loop.axis_2)
    return replace(
        loop,
        predecessor_origin=np.linalg.solve(links[loop.predecessor], ends[0]),
        successor_origin=np.linalg.solve(links[loop.successor], ends[1]),
        axis=axes[0],
        axis_2=axes[-1],
    )


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
