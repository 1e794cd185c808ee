"""Teeth: what two gears on parallel axes exert on each other, from the places of their axes.

Both axes are carried by one link, the housing or a carrier, and one gear rolls on the other at the
pitch point P of the line between them. With the tangent t = z × n there (z along the predecessor's
axis, n from this axis to the other one) and the moment m of the coupling on its successor's joint,
the teeth exert on the successor's gear

    Fₜ t + Fₐ z + Fᵣ e,   Fₐ = ∓Fₜ tan β,   Fᵣ = |Fₜ| tan α / cos β,

and the opposite on the other gear, at the pressure angle α and the helix angle β. The radial force
presses the smaller gear towards its own axis, whatever the sign of m is. Source: ISO 21771-1:2024.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ...kit.errors import ModelError
from .joints import Joint

if TYPE_CHECKING:
    from ..description.description import Mesh
    from .welds import Coupling

_PARALLEL = 1e-6
"""Sine of the angle between axes that still count as parallel, and part of their distance by which
the origins of their joints may lie apart along them: what files with seven digits leave of none."""


class Gear(NamedTuple):
    """One of two gears.

    Attributes:
        body: index of its body in the model (0-based), -1 for the world.
        rotation, translation: `(3, 3)` and `(3,)` placement of its joint's frame in that body [m].
        axis: `(3,)` of the joint in its frame.
        joint: name of its joint.
        sense: 1 if the gear is the joint's child, -1 if it is the parent.
        linear: `(6,)` wrench on the gear about the joint's origin, in the joint's frame at zero,
            per moment of the coupling.
        radial: `(6,)` likewise, per size of that moment.
    """

    body: int
    rotation: Array
    translation: Array
    axis: Array
    joint: str
    sense: float
    linear: Array
    radial: Array

    def wrench(self, moment: Array, angle: Array) -> tuple[Array, Array]:
        """Return force and moment `(N, 3)` on the gear, about its joint's origin.

        They are in the axes of the joint on the gear's side.

        Args:
            moment: of the coupling `(N,)` [N·m].
            angle: of its joint `(N,)` [rad].
        """
        wrench = moment[:, None] * self.linear + np.abs(moment)[:, None] * self.radial
        turned = -self.sense * angle[:, None]
        force, about = (_turned(part, self.axis, turned) for part in (wrench[:, :3], wrench[:, 3:]))
        return force, about


class Teeth(NamedTuple):
    """The teeth of two gears that a coupling couples.

    Attributes:
        coupling: its index.
        joints: names of the joints of its predecessor and of its successor.
        gears: the gears, without those that stand in the world.
    """

    coupling: int
    joints: tuple[str, str]
    gears: tuple[Gear, ...]


def teeth_of(
    index: int,
    mesh: Mesh,
    coupling: Coupling,
    model: pinocchio.Model,
    joints: Mapping[str, Joint],
) -> Teeth:
    """Return the teeth of a coupling.

    Args:
        index: of the coupling.
        mesh: what is stated of them.
        coupling: the coupling.
        model: of the tree.
        joints: of the mechanism by name.

    Raises:
        ModelError: there is no pair of gears that could have them.
    """
    at = f"{model.name}: coupling {coupling.name!r}: forces='mesh'"
    columns = (*coupling.predecessor_columns, *coupling.successor_columns)
    turning = {
        int(model.idx_vs[joint.id]): joint
        for joint in joints.values()
        if joint.nv == 1 and joint.parts[0].kind == "revolute"
    }
    pair = [turning[column] for column in columns if column in turning]
    if not len(coupling.predecessor_columns) == len(coupling.successor_columns) == len(pair) - 1:
        raise ModelError(f"{at}: teeth are those of two gears, each on a joint that turns")
    bodies = [(model.parents[joint.id], joint.id) for joint in pair]
    shared = set(bodies[0]) & set(bodies[1])
    if not shared:
        raise ModelError(
            f"{at}: joints {pair[0].name!r} and {pair[1].name!r} have no link in common; gears "
            "turn in one housing, or on one carrier, and the lengths of these cannot be held"
        )
    (carrier,) = shared
    senses = [1.0 if parent == carrier else -1.0 for parent, _ in bodies]
    frames = [
        model.jointPlacements[joint.id] if sense > 0.0 else pinocchio.SE3.Identity()
        for joint, sense in zip(pair, senses, strict=True)
    ]
    axes = [frame.rotation @ joint.parts[0].axis for frame, joint in zip(frames, pair, strict=True)]
    z, way = axes[0], frames[1].translation - frames[0].translation
    height = float(z @ way)
    across = way - height * z
    distance = float(np.linalg.norm(across))
    if np.linalg.norm(np.cross(*axes)) > _PARALLEL or distance <= _PARALLEL * abs(height):
        raise ModelError(
            f"{at}: gears of this kind have parallel axes at a distance; those of "
            f"{pair[0].name!r} and {pair[1].name!r} are none: leave forces= out"
        )
    along = mesh.along
    if along is None:
        if abs(height) > _PARALLEL * distance:
            raise ModelError(
                f"{at}: the origins of {pair[0].name!r} and {pair[1].name!r} lie {height:g} m "
                'apart along their axes; along="..." says how far the teeth are from the first one'
            )
        along = 0.0
    facing = 1.0 if z @ axes[1] > 0.0 else -1.0
    ratio = facing * senses[0] * senses[1] * coupling.ratio
    if abs(ratio - 1.0) <= _PARALLEL:
        raise ModelError(f"{at}: no gears at a distance turn equally fast in the same sense")
    n = across / distance
    radius = ratio * distance / (ratio - 1.0)  # Of the pitch point from the first axis along n.
    second = radius - distance
    tangential = facing * senses[1] / second
    tooth = np.tan(mesh.helix_angle) * np.sign(radius)
    force = tangential * (np.cross(z, n) - tooth * z)
    towards = np.sign(radius if abs(radius) < abs(second) else -second)
    slope = np.tan(mesh.pressure_angle) / np.cos(mesh.helix_angle)
    pressed = abs(tangential) * slope * towards * n
    point = frames[0].translation + radius * n + along * z
    gears = []
    for sign, joint, (parent, _), sense, frame in zip(
        (-1.0, 1.0), pair, bodies, senses, frames, strict=True
    ):
        body = (joint.id if sense > 0.0 else parent) - 1
        if body < 0:
            continue
        wrenches = []
        for part in (force, pressed):
            whole = sign * np.array([part, np.cross(point - frame.translation, part)])
            wrenches.append((whole @ frame.rotation).ravel())
        place = pinocchio.SE3.Identity() if sense > 0.0 else model.jointPlacements[joint.id]
        placed = place.rotation.copy(), place.translation.copy()
        gears.append(Gear(body, *placed, joint.parts[0].axis, joint.name, sense, *wrenches))
    return Teeth(index, (pair[0].name, pair[1].name), tuple(gears))


def _turned(vectors: Array, axis: Array, angle: Array) -> Array:
    """Return vectors `(N, 3)` turned about an axis by angles `(N, 1)`."""
    along = (vectors @ axis)[:, None] * axis
    across = np.cross(axis, vectors)
    return np.asarray(along + np.cos(angle) * (vectors - along) + np.sin(angle) * across)
