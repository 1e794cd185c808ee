"""Description: what a file says about a mechanism, checked, as plain data.

Every number in it was checked, and the model is built from these numbers alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass(frozen=True, eq=False)
class SourceText:
    """Where a description comes from, for what is read only when it is shown or proven.

    Attributes:
        text: the whole text.
        path: the file, beside which meshes are found; None for text.
    """

    text: str
    path: Path | None


@dataclass(frozen=True, eq=False)
class LinkDescription:
    """A link and its mass.

    Attributes:
        name: its name.
        mass: [kg]; 0 for a massless link.
        centre: `(3,)` centre of mass in the link's frame [m].
        inertia: `(3, 3)` about the centre, in the link's axes [kg·m²].
    """

    name: str
    mass: float = 0.0
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True)
class Limits:
    """Limits of a joint's coordinate; they are kept for Pinocchio's functions only.

    Attributes:
        lower, upper: position [rad or m].
        velocity: [rad/s or m/s].
        effort: [N·m or N].
    """

    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    effort: float = np.inf


@dataclass(frozen=True, eq=False)
class JointDescription:
    """A joint of the spanning tree.

    Attributes:
        name: its name.
        type: one of `elements.JOINT_TYPES`, or a type of loops.
        parent, child: names of the two links.
        origin: `(4, 4)` placement of the joint's frame in the parent [m].
        axis: `(3,)` unit axis in the joint frame.
        axis_2: `(3,)` second axis of a `universal` joint; else the first.
        child_placement: `(4, 4)` placement of the child link in the joint's frame, which a URDF
            lets coincide.
        limits: of its coordinate.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: np.ndarray
    axis: np.ndarray
    axis_2: np.ndarray
    child_placement: np.ndarray = field(default_factory=lambda: np.eye(4))
    limits: Limits = Limits()


@dataclass(frozen=True, eq=False)
class LoopDescription:
    """A closure between two links, in URDF+ notation.

    Attributes:
        name: name of the joint that the loop is.
        type: one of `elements.LOOP_TYPES`.
        predecessor, successor: names of the two links.
        predecessor_origin, successor_origin: `(4, 4)` placements of the joint frame in the links
            [m]. The coordinate is zero where both coincide.
        axis: `(3,)` unit vector in the joint frame.
        axis_2: `(3,)` second axis of a `universal` joint, normal to the first; else the first.
    """

    name: str
    type: str
    predecessor: str
    successor: str
    predecessor_origin: np.ndarray
    successor_origin: np.ndarray
    axis: np.ndarray
    axis_2: np.ndarray


@dataclass(frozen=True)
class CouplingDescription:
    """A gear, in URDF+ notation.

    The rotation of the successor is `ratio` times that of the predecessor, both summed up over
    the joints from their nearest common ancestor.
    """

    name: str
    predecessor: str
    successor: str
    ratio: float


@dataclass(frozen=True, eq=False)
class Description:
    """A checked description.

    Attributes:
        name: name of the mechanism.
        links: in file order; one of them, the root, is the child of no joint.
        joints: those of the spanning tree, in file order.
        order: names of the tree joints in the order in which Pinocchio's own reader of the
            format would take them, so that its users find the indices that they know.
        loops: the closures in file order.
        couplings: the gears in file order.
        independent_joints: names of the joints that its author drives.
        notation: how the loops were written, and what else was found.
        warnings: what is wrong with it and was accepted.
        source: its text and file.
    """

    name: str
    links: tuple[LinkDescription, ...]
    joints: tuple[JointDescription, ...]
    order: tuple[str, ...]
    loops: tuple[LoopDescription, ...]
    couplings: tuple[CouplingDescription, ...] = ()
    independent_joints: tuple[str, ...] = ()
    notation: str = "URDF+"
    warnings: tuple[str, ...] = ()
    source: SourceText | None = None

    @property
    def root(self) -> str:
        """Name of the link that stands in the world."""
        children = {joint.child for joint in self.joints}
        return next(link.name for link in self.links if link.name not in children)
