"""Joints: where a mechanism has their elementary parts, and how their coordinates are called."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import Record

if TYPE_CHECKING:
    from ..description.description import Description


_COORDINATES = {
    "universal": ("turn_1", "turn_2"),
    "cylindrical": ("slide", "turn"),
    "planar": ("slide_1", "slide_2", "turn"),
    "spherical": ("x", "y", "z"),
    "floating": ("x", "y", "z", "turn_x", "turn_y", "turn_z"),
    "loose": ("slide_1", "slide_2", "tilt_1", "tilt_2", "turn"),
}
"""Names of the coordinates of the joint types that have several, from the parent outwards. Those of
a ball are Cardan angles: turns about x of the parent's side, then the carried y, then the child's
z. No description has a `loose` joint: it is a pin whose two bearings have play, held along its axis
alone."""


@dataclass(frozen=True, eq=False)
class Part(Record):
    """An elementary part of a joint.

    Attributes:
        kind: `revolute`, `prismatic` or `spherical`.
        axis: `(3,)` unit axis in the joint frame.
        id: index of its joint in the model.
    """

    kind: str
    axis: Array
    id: int

    @property
    def nv(self) -> int:
        """Number of velocity coordinates."""
        return 3 if self.kind == "spherical" else 1


@dataclass(frozen=True, eq=False, repr=False)
class Joint(Record):
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

    @property
    def id(self) -> int:
        """Index of the child's body in `Mechanism.model`; 0 for a `fixed` loop."""
        return self.parts[-1].id if self.parts else 0

    @property
    def nv(self) -> int:
        """Number of velocity coordinates."""
        return sum(part.nv for part in self.parts)

    @property
    def has_ball(self) -> bool:
        """Whether one of its parts is a ball."""
        return any(part.kind == "spherical" for part in self.parts)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names by which scenes drive, hold and load its coordinates, from the parent outwards.

        The joint's own name if it has one coordinate, else `joint.coordinate`.
        """
        if self.nv < 2:
            return (self.name,) * self.nv
        return tuple(f"{self.name}.{coordinate}" for coordinate in _COORDINATES[self.type])

    def __repr__(self) -> str:
        return f"<Joint {self.name!r}: {self.type}>"


def described_joints(description: Description, parts: dict[str, list[Part]]) -> dict[str, Joint]:
    """Return the joints that carry a wrench by name, those of the tree first, then the loops."""
    joints = {}
    for item in description.joints_and_loops:
        if item.name in parts:
            axis = np.cross(item.axis, item.axis_2) if item.type == "universal" else item.axis
            joints[item.name] = Joint(item.name, item.type, axis, tuple(parts[item.name]))
    return joints


class NamedCoordinate(NamedTuple):
    """A coordinate that scenes can drive, hold and load.

    Attributes:
        joint: name of its joint.
        offset: which of the joint's velocity coordinates it is, from 0.
        slides: whether it is a slide [m]; else it is an angle [rad].
    """

    joint: str
    offset: int
    slides: bool

    @property
    def unit(self) -> str:
        """Unit of its positions: `"m"` or `"rad"`."""
        return "m" if self.slides else "rad"

    @property
    def effort_unit(self) -> str:
        """Unit of what acts along it: `"N"` or `"N·m"`."""
        return "N" if self.slides else "N·m"

    def __str__(self) -> str:
        what = "slides" if self.slides else "turns"
        return f"{what}: position in {self.unit}, effort in {self.effort_unit}"


def named_coordinates(joints: Iterable[Joint]) -> dict[str, NamedCoordinate]:
    """Return the coordinates of joints by name.

    A joint may be called what would be a coordinate of another one: then the name is the joint's.
    """
    joints = list(joints)
    names = {joint.name for joint in joints}
    return {
        name: NamedCoordinate(joint.name, offset, kind == "prismatic")
        for joint in joints
        for offset, (name, kind) in enumerate(zip(joint.coordinates, _kinds(joint), strict=True))
        if joint.nv == 1 or name not in names
    }


def _kinds(joint: Joint) -> list[str]:
    """Return the kind of the part that each velocity coordinate of a joint belongs to."""
    return [part.kind for part in joint.parts for _ in range(part.nv)]
