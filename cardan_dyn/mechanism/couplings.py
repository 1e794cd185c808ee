"""Couplings: which joints a coupling of links or of joints couples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import pinocchio

from ..errors import ModelError
from .joints import Joint
from .tree import ancestors

if TYPE_CHECKING:
    from ..description.description import CouplingDescription


class Coupling(NamedTuple):
    """A ratio between two motions: ratio times the predecessor's plus offset is the successor's.

    The motions are those of two joints, or those of two links: angles or slides, summed up over the
    joints from their nearest common ancestor.

    Attributes:
        name: its name in the description.
        ratio: motion of the successor per motion of the predecessor.
        offset: motion of the successor while the predecessor is at zero [rad or m].
        predecessor_columns, successor_columns: velocity coordinates of the two joints, or of the
            joints between the two links and their nearest common ancestor.
    """

    name: str
    ratio: float
    offset: float
    predecessor_columns: tuple[int, ...]
    successor_columns: tuple[int, ...]


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
    ends = (coupling.predecessor, coupling.successor)
    if coupling.of_joints:
        mimicked, joint = (int(model.idx_vs[joints[name].id]) for name in ends)
        return Coupling(coupling.name, coupling.ratio, coupling.offset, (mimicked,), (joint,))
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
    return Coupling(coupling.name, coupling.ratio, coupling.offset, first, second)


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

    return f"{coupling.name}: {shown_ratio(coupling.ratio, coupling.offset)}"
