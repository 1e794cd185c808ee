"""Vectors of the viewer: where each joint's arrows start, and what they show."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ...core.mechanism.joints import Joint
from ...core.mechanism.mechanism import Mechanism
from ...core.results.sweep import Sweep
from ...core.results.wrench import WITHOUT_AXIS
from ...figures.wrenches import PARTS
from ...kit.arrays import NOTHING, Array
from .still import Still

_APART = 0.14
"""Least distance of two joints' moments, as a fraction of the radius of the scene."""
_STANDING_OUT = 3.0
"""How often greater than is usual the greatest arrow may be without hiding others."""
SLIDES = frozenset({"prismatic", "cylindrical"})
"""Types of joints that slide along their axis."""


class Vectors(NamedTuple):
    """A joint's wrench and position over the shown samples, in world axes unless said otherwise.

    Attributes:
        name: the joint.
        origin: `(N, 3)` joint origin [m], where forces are drawn.
        axis: `(N, 3)` unit axis.
        rotation: `(N, 3, 3)` from the joint frame.
        anchor: `(N, 3)` point of the joint's axis at which moments are drawn [m]: beside the
            centre of mass of its child, as several joints may share one origin. A moment is the
            same everywhere on a body.
        force: `(N, 3)` [N].
        moment: `(N, 3)` whole moment in the axes of the joint, which turn with its child [N·m].
        parts: what is drawn of both by its name: `torsion` and `axial` along the axis, `bending`
            and `shear` across it, all `(N, 3)` [N·m, N]; `force` of a joint without an axis.
        slide: `(N,)` position of the child along the axis [m]; zero where it does not slide.
    """

    name: str
    origin: Array
    axis: Array
    rotation: Array
    anchor: Array
    force: Array
    moment: Array
    parts: Mapping[str, Array]
    slide: Array


def collect(
    sweep: Sweep | Still, joints: tuple[str, ...], samples: Array, radius: float
) -> list[Vectors]:
    """Return the vectors of joints.

    Args:
        sweep: over one dimension.
        joints: names among its outputs.
        samples: `(n,)` indices of the samples that are shown.
        radius: of the scene [m].
    """
    vectors: list[Vectors] = []
    starts: list[Array] = []
    for name in joints:
        joint = sweep.mechanism.joints[name]
        origin, rotation = sweep.origin(name)[samples], sweep.rotation(name)[samples]
        wrench = sweep[name]
        moment, force = wrench.moment[samples], wrench.force[samples]
        axis = np.broadcast_to(rotation @ joint.axis, origin.shape)
        parts = {
            name: _turned(rotation, values)
            for whole, names in ((moment, PARTS["moment"]), (force, PARTS["force"]))
            for name, values in zip(names, _divided(whole, joint.axis), strict=True)
        }
        if joint.type in WITHOUT_AXIS:
            parts = {"force": _turned(rotation, force), "bending": _turned(rotation, moment)}
        offset = _free(origin[0], axis[0], beside(sweep.mechanism, joint, radius), starts, radius)
        starts.append(origin[0] + offset * axis[0])
        vectors.append(
            Vectors(
                name=name,
                origin=origin,
                axis=axis,
                rotation=rotation,
                anchor=origin + offset * axis,
                force=_turned(rotation, force),
                moment=moment,
                parts=parts,
                slide=slide(sweep, joint, samples),
            )
        )
    return vectors


def greatest(vectors: Array) -> float:
    """Return the greatest size of vectors `(…, k)`."""
    return float(np.max(np.linalg.norm(vectors, axis=-1), initial=0.0))


def legible(wholes: Iterable[Array]) -> float:
    """Return the size of the longest arrow: the greatest, unless it hides the others.

    That is where it stands out from what is reached in nine tenths of the positions.

    Args:
        wholes: vectors `(N, 3)` of several joints.
    """
    sizes = np.max([np.linalg.norm(vectors, axis=1) for vectors in wholes], axis=0)
    most, usual = float(np.max(sizes)), float(np.quantile(sizes, 0.9))
    return min(most, _STANDING_OUT * usual) if usual > NOTHING * most else most


def _divided(vectors: Array, axis: Array) -> tuple[Array, Array]:
    """Return what of vectors `(N, 3)` is along and across an axis `(3,)`."""
    along = np.outer(vectors @ axis, axis)
    return along, vectors - along


def slide(sweep: Sweep | Still, joint: Joint, samples: Array) -> Array:
    """Return where a joint's child is along its axis `(N,)` [m]; zeros where it does not slide."""
    for name, item in sweep.mechanism.drivable.items():
        if item.joint == joint.name and item.slides and joint.type in SLIDES:
            return np.asarray(sweep.motion.position(name)[samples])
    return np.zeros(len(samples))


def beside(mechanism: Mechanism, joint: Joint, radius: float) -> float:
    """Return how far along its axis from its origin a joint's moments are drawn [m].

    That is beside the centre of mass of its child, as several joints may share one origin.

    Args:
        mechanism: the joint's.
        joint: the joint.
        radius: of the scene, beyond which nothing is drawn [m].
    """
    if not joint.parts or joint.type in ("spherical", "universal", "floating"):
        return 0.0
    inertia = mechanism.model.inertias[joint.id]
    distance = float(inertia.lever @ joint.axis) if inertia.mass > 0.0 else 0.0
    return float(np.clip(distance, -radius, radius))


def _free(origin: Array, axis: Array, offset: float, taken: list[Array], radius: float) -> float:
    """Return the offset nearest to a given one at which no other joint's moments start."""
    for step in (0, 1, -1, 2, -2, 3, -3):
        candidate = offset + step * _APART * radius
        gaps = [np.linalg.norm(origin + candidate * axis - point) for point in taken]
        if min(gaps, default=radius) > (1.0 - NOTHING) * _APART * radius:
            return candidate
    return offset


def _turned(rotation: Array, vectors: Array) -> Array:
    """Return vectors `(N, 3)` in the axes to which rotations `(N, 3, 3)` lead."""
    return np.asarray(np.einsum("...ij,...j->...i", rotation, vectors))
