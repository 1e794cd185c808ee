"""Welds: where loops are closed, as Pinocchio has it, and the lengths that they span."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio

from .tree import se3

if TYPE_CHECKING:
    from ..description.description import LoopDescription


LEAST_LENGTH = 1e-15
"""Greatest distance within a mechanism [m] below which it counts as none: sines of angles, and
differences of lengths in metres, leave some 1e-17 to 1e-16 of zero. No mechanism is as small as an
atom's nucleus."""


class Loop(NamedTuple):
    """A weld that closes a loop.

    Attributes:
        joint: name of the joint that the loop is.
        predecessor: index in `Mechanism.model` of the welded body on the predecessor's side (the
            body of the loop's own joint, or the predecessor itself for a `fixed` loop).
        predecessor_placement: `pin.SE3` of the weld in that body.
        successor: index of the successor's body, 0 for the world.
        successor_placement: `pin.SE3` of the weld in the successor's body.
    """

    joint: str
    predecessor: int
    predecessor_placement: pinocchio.SE3
    successor: int
    successor_placement: pinocchio.SE3


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
    return Loop(loop.name, predecessor, placement, successor, frame * se3(loop.successor_origin))


def constraint_models(
    model: pinocchio.Model, loops: Iterable[Loop]
) -> pinocchio.StdVec_RigidConstraintModel:
    """Return welds as Pinocchio's constraints."""
    result = pinocchio.StdVec_RigidConstraintModel()
    for loop in loops:
        result.append(
            pinocchio.RigidConstraintModel(
                pinocchio.ContactType.CONTACT_6D,
                model,
                loop.predecessor,
                loop.predecessor_placement,
                loop.successor,
                loop.successor_placement,
                pinocchio.ReferenceFrame.LOCAL,
            )
        )
    return result


def characteristic_length(model: pinocchio.Model, loops: Iterable[Loop]) -> float:
    """Return the greatest distance that occurs within a body of the mechanism [m].

    It is 1 m where there is none, as in a spherical linkage without mass.
    """
    longest = greatest_length(model, loops)
    return longest if longest >= LEAST_LENGTH else 1.0


def greatest_length(model: pinocchio.Model, loops: Iterable[Loop]) -> float:
    """Return the greatest distance that occurs within a body of the mechanism [m], or zero."""
    placed = list(zip(list(model.parents)[1:], list(model.jointPlacements)[1:], strict=True))
    for loop in loops:
        placed.append((loop.predecessor, loop.predecessor_placement))
        placed.append((loop.successor, loop.successor_placement))
    lengths = [0.0]
    lengths += [float(np.linalg.norm(frame.translation)) for body, frame in placed if body]
    # The world's origin may be anywhere, so frames in the world are measured from their middle.
    on_world = [frame.translation for body, frame in placed if not body]
    if on_world:
        spread = np.asarray(on_world) - np.mean(on_world, axis=0)
        lengths.append(float(np.max(np.linalg.norm(spread, axis=1))))
    for inertia in list(model.inertias)[1:]:
        if inertia.mass > 0.0:
            lengths.append(float(np.linalg.norm(inertia.lever)))
            spread_of_mass = max(float(np.trace(inertia.inertia)), 0.0) / (2.0 * inertia.mass)
            lengths.append(float(np.sqrt(spread_of_mass)))
    return max(lengths)
