"""Welds and couplings: what holds the tree together, and the lengths that it spans."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ...kit.errors import ModelError
from .joints import Joint
from .tree import ancestors, se3

if TYPE_CHECKING:
    from ..description.description import CouplingDescription, LoopDescription


LEAST_LENGTH = 1e-15
"""Greatest distance within a mechanism [m] below which it counts as none: sines of angles, and
differences of lengths in metres, leave some 1e-17 to 1e-16 of zero. No mechanism is as small as an
atom's nucleus."""
_COINCIDENT = float(np.finfo(np.float32).eps)
"""Part of a body's radius of gyration by which points of it may be apart and count as one: what
numbers of single precision leave of it."""


class Loop(NamedTuple):
    """A weld that closes a loop.

    Attributes:
        joint: name of the joint that the loop is.
        predecessor: index in `Mechanism.model` of the welded body on the predecessor's side (the
            body of the loop's own joint, or the predecessor itself for a `fixed` loop).
        predecessor_placement: `pin.SE3` of the weld in that body.
        successor: index of the successor's body, 0 for the world.
        successor_placement: `pin.SE3` of the weld in the successor's body.
        is_fixed: whether the loop is `fixed`: it has a wrench, but neither coordinate nor body.
    """

    joint: str
    predecessor: int
    predecessor_placement: pinocchio.SE3
    successor: int
    successor_placement: pinocchio.SE3
    is_fixed: bool

    def constraint(self, model: pinocchio.Model) -> pinocchio.RigidConstraintModel:
        """Return the weld as a constraint of a model in which its bodies are."""
        return pinocchio.RigidConstraintModel(
            pinocchio.ContactType.CONTACT_6D,
            model,
            self.predecessor,
            self.predecessor_placement,
            self.successor,
            self.successor_placement,
            pinocchio.ReferenceFrame.LOCAL,
        )


def weld(loop: LoopDescription, links: Mapping[str, tuple[int, pinocchio.SE3]], joint: int) -> Loop:
    """Return the weld of a loop.

    Args:
        loop: the loop.
        links: see `Mechanism.links`.
        joint: index of the body of the loop's own joint; 0 for a `fixed` loop.
    """
    predecessor, frame = links[loop.predecessor]
    placement = frame * se3(loop.predecessor_origin)
    if joint:
        predecessor, placement = joint, pinocchio.SE3.Identity()
    successor, frame = links[loop.successor]
    end = frame * se3(loop.successor_origin)
    return Loop(loop.name, predecessor, placement, successor, end, is_fixed=not joint)


def greatest_length(model: pinocchio.Model, loops: Sequence[Loop]) -> float:
    """Return the greatest distance that occurs within a body of the mechanism [m], or zero.

    Distances are those between its joints and its centre of mass. Where there are no loops, or no
    such distances in any body, the radius of gyration about the centre counts as well; elsewhere
    it does not, since what closes loops does not depend on how heavy bodies are. They do not
    depend on which joints of a ring are in the tree and which one is the loop.
    """
    # What carries the joint of a loop to its successor is that one once more.
    welded = {loop.predecessor for loop in loops if model.names[loop.predecessor] == loop.joint}
    points: list[list[Array]] = [[] for _ in range(model.njoints)]
    lengths = [0.0]
    for body, parent in enumerate(model.parents):
        if body:
            points[parent].append(model.jointPlacements[body].translation)
            if body not in welded:
                points[body].append(np.zeros(3))
    for loop in loops:
        points[loop.successor].append(loop.successor_placement.translation)
        if loop.predecessor not in welded:
            points[loop.predecessor].append(loop.predecessor_placement.translation)
    mass, spread = 0.0, 0.0
    for body, inertia in enumerate(model.inertias):
        # What has mass in the world does not move.
        if body and body not in welded and inertia.mass > 0.0:
            points[body].append(inertia.lever)
            mass += inertia.mass
            spread += 0.5 * max(inertia.inertia.trace(), 0.0)
    # Of all bodies together: that of a rotor with next to no mass says nothing about lengths.
    gyration = math.sqrt(spread / mass) if mass else 0.0
    for body, in_body in enumerate(points):
        if in_body:
            placed = np.array(in_body)
            # The world's origin may be anywhere, so what is in the world counts from its middle.
            apart = placed[:, None] - placed if body else placed - placed.mean(axis=0)
            lengths.append(math.sqrt((apart * apart).sum(axis=-1).max()))
    longest = max(lengths)
    return longest if loops and longest > _COINCIDENT * gyration else max(longest, gyration)


class Coupling(NamedTuple):
    """What couples two motions; the successor's is a polynomial of the predecessor's.

    The motions are those of two joints, or those of two links: angles or slides, summed up over the
    joints from their nearest common ancestor.

    Attributes:
        name: its name in the description.
        ratio: motion of the successor per motion of the predecessor.
        offset: motion of the successor while the predecessor is at zero [rad or m].
        predecessor_columns, successor_columns: velocity coordinates of the two joints, or of the
            joints between the two links and their nearest common ancestor.
        forces, higher: see `CouplingDescription`.
    """

    name: str
    ratio: float
    offset: float
    predecessor_columns: tuple[int, ...]
    successor_columns: tuple[int, ...]
    forces: str
    higher: tuple[float, ...] = ()


def coupling_of(
    coupling: CouplingDescription,
    model: pinocchio.Model,
    joints: Mapping[str, Joint],
    links: Mapping[str, tuple[int, pinocchio.SE3]],
) -> Coupling:
    """Return a coupling of a mechanism.

    Args:
        coupling: its description.
        model: of the tree.
        joints: of the mechanism by name.
        links: by name, each with its body in the model.

    Raises:
        ModelError: it couples nothing, or a joint with several coordinates.
    """

    def between(first: tuple[int, ...], second: tuple[int, ...]) -> Coupling:
        numbers = coupling.ratio, coupling.offset
        return Coupling(coupling.name, *numbers, first, second, coupling.forces, coupling.higher)

    ends = (coupling.predecessor, coupling.successor)
    if coupling.of_joints:
        mimicked, joint = (int(model.idx_vs[joints[name].id]) for name in ends)
        return between((mimicked,), (joint,))
    chains = [set(ancestors(model, links[name][0])) for name in ends]
    at = f"{model.name}: coupling {coupling.name!r}"
    first, second = (
        tuple(_coupled_columns(model, joints, side - opposite, at))
        for side, opposite in (chains, chains[::-1])
    )
    if not (first or second):
        raise ModelError(
            f"{at}: no joint moves {coupling.predecessor!r} relative to {coupling.successor!r}"
        )
    if coupling.higher and not (first and second):
        raise ModelError(
            f"{at}: one of {ends[0]!r} and {ends[1]!r} carries the other, so that only one of them "
            "moves; a ratio that changes is one of two motions: couple two joints"
        )
    return between(first, second)


def _coupled_columns(
    model: pinocchio.Model, joints: Mapping[str, Joint], bodies: set[int], at: str
) -> list[int]:
    """Return the velocity coordinates of the joints that move some bodies (0-based)."""
    columns = []
    for joint in joints.values():
        for part in joint.parts:
            if part.id - 1 not in bodies:
                continue
            if joint.nv != 1:
                raise ModelError(
                    f"{at}: joint {joint.name!r} between its links is {joint.type}; only joints "
                    "with one coordinate can be coupled"
                )
            columns.append(model.idx_vs[part.id])
    return columns


def shown(coupling: Coupling) -> str:
    """Return the name and ratio of a coupling as text."""
    from ..description.description import shown_ratio  # Only notebooks show it.

    shown = shown_ratio(coupling.ratio, coupling.offset, coupling.higher)
    return f"{coupling.name}: {shown}"
