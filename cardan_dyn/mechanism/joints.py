"""Joints: of which elementary parts each joint type is made, and where a mechanism has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..frozen import read_only


@dataclass(frozen=True, eq=False)
class Part:
    """An elementary part of a joint.

    Attributes:
        kind: `revolute`, `prismatic` or `spherical`.
        axis: `(3,)` unit axis in the joint frame.
        id: index of its joint in the model.
    """

    kind: str
    axis: Array
    id: int

    def __post_init__(self) -> None:
        read_only(self.axis)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates."""
        return 3 if self.kind == "spherical" else 1


@dataclass(frozen=True, eq=False, repr=False)
class Joint:
    """One joint of a mechanism, in the tree or closing a loop.

    Attributes:
        name: its name in the description.
        type: its type in the description.
        axis: `(3,)` unit axis in the joint frame: of rotation or sliding; the normal of a `planar`
            joint; of a `universal` joint the normal of both its axes at zero. Torsion and axial
            force are the components along it.
        parts: its elementary parts in `Mechanism.model`, the child's body last; none for a
            `fixed` loop.
    """

    name: str
    type: str
    axis: Array
    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        read_only(self.axis)

    @property
    def id(self) -> int:
        """Index of the child's body in `Mechanism.model`; 0 for a `fixed` loop."""
        return self.parts[-1].id if self.parts else 0

    @property
    def nv(self) -> int:
        """Number of velocity coordinates."""
        return sum(part.nv for part in self.parts)

    def __repr__(self) -> str:
        return f"<Joint {self.name!r}: {self.type}>"


def elementary(kind: str, axis: Array, axis_2: Array) -> list[tuple[str, Array]]:
    """Return kinds and axes of a joint type's parts, from the parent outwards.

    Args:
        kind: a joint type of URDF, or `spherical`, `universal`, `cylindrical`.
        axis: unit axis; the normal of a `planar` joint, the first axis of a `universal` one.
        axis_2: second axis of a `universal` joint.
    """
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    x, y, z = np.eye(3)
    return {
        "fixed": [],
        "revolute": [("revolute", axis)],
        "continuous": [("revolute", axis)],
        "prismatic": [("prismatic", axis)],
        "cylindrical": [("prismatic", axis), ("revolute", axis)],
        "planar": [
            ("prismatic", across),
            ("prismatic", np.cross(axis, across)),
            ("revolute", axis),
        ],
        "universal": [("revolute", axis), ("revolute", axis_2)],
        "spherical": [("spherical", axis)],
        "floating": [
            ("prismatic", x),
            ("prismatic", y),
            ("prismatic", z),
            ("spherical", x),
        ],
    }[kind]
