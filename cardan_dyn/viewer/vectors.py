"""Vectors of the viewer: where each joint's arrows start, and what they show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..mechanism.joints import Joint
from ..mechanism.mechanism import Mechanism
from ..results.sweep import Sweep

_APART = 0.14
"""Least distance of two joints' moments, as a fraction of the radius of the scene."""


@dataclass(frozen=True)
class Vectors:
    """A joint's wrench and place over the shown samples, in world axes unless said otherwise.

    Attributes:
        name: the joint.
        origin: `(N, 3)` joint origin [m], where forces are drawn.
        axis: `(N, 3)` unit axis.
        rotation: `(N, 3, 3)` from the joint frame.
        anchor: `(N, 3)` point of the joint's axis at which moments are drawn [m]: beside the
            centre of mass of its child, as several joints may share one origin. A moment is the
            same everywhere on a body.
        label: `(N, 3)` where the name stands [m].
        force: `(N, 3)` [N].
        torsion: `(N, 3)` part of the moment along the axis [N·m].
        bending: `(N, 3)` part of the moment across it [N·m].
        moment: `(N, 3)` whole moment in the axes of the joint, which turn with its child [N·m].
        turns: whether the child turns about its axis in a parent that stands still.
    """

    name: str
    origin: Array
    axis: Array
    rotation: Array
    anchor: Array
    label: Array
    force: Array
    torsion: Array
    bending: Array
    moment: Array
    turns: bool

    @property
    def greatest_moment(self) -> float:
        """Greatest size of the moment [N·m]."""
        return float(np.max(np.linalg.norm(self.moment, axis=1)))

    @property
    def greatest_force(self) -> float:
        """Greatest size of the force [N]."""
        return float(np.max(np.linalg.norm(self.force, axis=1)))


def collect(sweep: Sweep, joints: tuple[str, ...], rows: Array, radius: float) -> list[Vectors]:
    """Return the vectors of joints, as far as their motion is known.

    Args:
        sweep: over one dimension.
        joints: names among its outputs.
        rows: which samples.
        radius: of the scene [m].
    """
    found: list[Vectors] = []
    starts: list[Array] = []
    for name in joints:
        joint = sweep.mechanism.joints[name]
        origin, rotation = sweep.origin(name)[rows], sweep.rotation(name)[rows]
        if not (np.all(np.isfinite(origin)) and np.all(np.isfinite(rotation))):
            continue
        wrench = sweep[name]
        moment, force = wrench.moment[rows], wrench.force[rows]
        axis = np.broadcast_to(rotation @ joint.axis, origin.shape)
        along = np.sum(moment * joint.axis, axis=1)[:, None] * joint.axis
        offset = _free(origin[0], axis[0], _offset(sweep.mechanism, joint, radius), starts, radius)
        starts.append(origin[0] + offset * axis[0])
        found.append(
            Vectors(
                name=name,
                origin=origin,
                axis=axis,
                rotation=rotation,
                anchor=origin + offset * axis,
                label=_label(origin, axis, offset, radius),
                force=_turned(rotation, force),
                torsion=_turned(rotation, along),
                bending=_turned(rotation, moment - along),
                moment=moment,
                turns=_turns(sweep, joint, rows),
            )
        )
    return found


def _offset(mechanism: Mechanism, joint: Joint, radius: float) -> float:
    """Return how far along its axis from its origin a joint's moments are drawn [m]."""
    if not joint.parts or joint.type in ("spherical", "universal", "floating"):
        return 0.0
    inertia = mechanism.model.inertias[joint.id]
    distance = float(inertia.lever @ joint.axis) if inertia.mass > 0.0 else 0.0
    return float(np.clip(distance, -radius, radius))


def _free(origin: Array, axis: Array, offset: float, taken: list[Array], radius: float) -> float:
    """Return the offset nearest to a wanted one at which no other joint's moments start."""
    for step in (0, 1, -1, 2, -2, 3, -3):
        tried = offset + step * _APART * radius
        gaps = [np.linalg.norm(origin + tried * axis - other) for other in taken]
        if min(gaps, default=radius) > 0.99 * _APART * radius:
            return tried
    return offset


def _label(origin: Array, axis: Array, offset: float, radius: float) -> Array:
    beyond = 0.32 * radius
    if abs(offset) > 0.2 * radius and abs(axis[0, 2]) < 0.7:
        # Beside a shaft: above it, as the shaft itself lies along the axis.
        return np.asarray(origin + offset * axis + [0.0, 0.0, beyond])
    side = -1.0 if offset < 0.0 else 1.0
    return np.asarray(origin + side * max(beyond, abs(offset) + 0.1 * radius) * axis)


def _turns(sweep: Sweep, joint: Joint, rows: Array) -> bool:
    if joint.type not in ("revolute", "continuous") or not joint.parts:
        return False
    if joint.name in {loop.joint for loop in sweep.mechanism.loops}:
        return False
    angle = sweep.motion.position(joint.name)[rows]
    parent = int(sweep.mechanism.model.parents[joint.id])
    if parent == 0:
        still = True
    else:
        carrier = next(
            (item for item in sweep.mechanism.joints.values() if item.id == parent), None
        )
        still = carrier is not None and not np.any(
            np.ptp(sweep.rotation(carrier.name)[rows], axis=0) > 1e-9
        )
    return still and float(np.ptp(angle)) > 1e-6


def _turned(rotation: Array, vectors: Array) -> Array:
    return np.asarray(
        np.einsum("nij,nj->ni", np.broadcast_to(rotation, (len(vectors), 3, 3)), vectors)
    )
