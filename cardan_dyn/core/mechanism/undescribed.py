"""Undescribed: what couplings leave open that do not say which forces they exert.

Between the two links of each joint that such a coupling couples, teeth, belts or a control may act,
so that nothing is known of what is left for the joint. Where two coupled joints have no link in
common, these forces pass through the joints between them as well, and those around their loops.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import Array
from .joints import Joint
from .tree import ancestors

if TYPE_CHECKING:
    from .welds import Coupling, Loop

REMEDY = (
    'write forces="mesh" and pressure_angle in it for the teeth of two gears on parallel axes, or '
    'forces="none" where nothing but moments about the axes of its joints acts; MJCF, SDF '
    'and Pinocchio have no such word: load(..., forces={"name of the coupling": "none"}), or '
    "from_pinocchio likewise, says it"
)
"""What the author of a coupling can do."""


class Undescribed(NamedTuple):
    """A coupling whose forces nothing describes.

    Attributes:
        coupling: its name.
        coupled: names of the joints that it couples.
        changes: joints to columns `(6, k)` that span what the forces may change of their wrenches.
    """

    coupling: str
    coupled: tuple[str, ...]
    changes: Mapping[str, Array]

    def told(self) -> str:
        """Return in a sentence what is not known."""
        return (
            f"how {self.coupling!r}, which couples {' and '.join(self.coupled)}, presses on their "
            "bearings is not described"
        )


def undescribed(
    couplings: Sequence[Coupling],
    model: pinocchio.Model,
    joints: Mapping[str, Joint],
    loops: Sequence[Loop],
) -> tuple[Undescribed, ...]:
    """Return what the couplings of a mechanism leave open that state no forces."""
    silent = [item for item in couplings if not item.forces]
    owners = {part.id - 1: joint for joint in joints.values() for part in joint.parts}
    bodies = {
        column: index - 1
        for index in range(1, model.njoints)
        for column in range(model.idx_vs[index], model.idx_vs[index] + model.nvs[index])
    }
    rings = _rings(model, loops, owners, joints)
    result = []
    for item in silent:
        columns = (*item.predecessor_columns, *item.successor_columns)
        coupled = {bodies[column] for column in columns}
        chains = [set(ancestors(model, body + 1)) for body in coupled]
        # Along the tree from one of them to the others, without what carries them all.
        common = set(chains[0]).intersection(*chains[1:])
        way = (coupled.union(*chains) - common) | coupled
        between = {owners[body].name for body in way} - {owners[body].name for body in coupled}
        for ring in rings:
            if between & ring:
                between |= ring
        names = tuple(owners[body].name for body in sorted(coupled))
        changes = {name: free_of(joints[name]) for name in sorted(between)}
        result.append(Undescribed(item.name, names, changes | dict.fromkeys(names, np.eye(6))))
    return tuple(result)


def free_of(joint: Joint) -> Array:
    """Return columns `(6, 6)` that span what does no work in the last motion of a joint."""
    if not joint.parts:
        return np.eye(6)
    part = joint.parts[-1]
    twist = np.zeros((6, part.nv))
    if part.kind == "spherical":
        twist[3:] = np.eye(3)
    else:
        twist[slice(3) if part.kind == "prismatic" else slice(3, 6), 0] = part.axis
    return np.asarray(np.eye(6) - twist @ twist.T)


def greatest_changes(items: Iterable[Undescribed], joints: Iterable[str]) -> Array:
    """Return `(k, 6)` how much of each component of joints couplings leave open, from 0 to 1."""
    rows = []
    for name in joints:
        spans = [item.changes[name] for item in items if name in item.changes]
        rows.append(
            np.max([np.linalg.norm(each, axis=1) for each in [np.zeros((6, 1)), *spans]], 0)
        )
    return np.array(rows).reshape(-1, 6)


def _rings(
    model: pinocchio.Model,
    loops: Sequence[Loop],
    owners: Mapping[int, Joint],
    joints: Mapping[str, Joint],
) -> list[set[str]]:
    """Return the names of the joints on each loop; of loops that have some in common, once."""
    rings: list[set[str]] = []
    for loop in loops:
        ends = (set(ancestors(model, body)) for body in (loop.predecessor, loop.successor))
        first, second = ends
        ring = {owners[body].name for body in first ^ second} | {joints[loop.joint].name}
        for other in [other for other in rings if other & ring]:
            rings.remove(other)
            ring |= other
        rings.append(ring)
    return rings
