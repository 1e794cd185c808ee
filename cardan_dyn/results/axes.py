"""Axes: where joints are during a sweep, and wrenches turned into axes other than the joint's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError, ModelError
from ..frozen import read_only
from .wrench import Components, StoredComponents

if TYPE_CHECKING:
    from .sweep import Sweep

_TURNING_AXIS = ("spherical", "universal", "floating")
"""Joints whose axis, as the child carries it, turns relative to the parent."""


def solved_placement(sweep: Sweep, joint: str) -> tuple[Array, Array]:
    """Return rotations `(N, 3, 3)` and origins `(N, 3)` [m] of a joint's frame in the world.

    Raises:
        ModelError: its motion was not solved.
    """
    rotation, origin = sweep.motion.joint_placement(joint)
    if not (np.all(np.isfinite(rotation)) and np.all(np.isfinite(origin))):
        raise ModelError(
            f"the outputs of the scene leave out joint {joint!r}; name it among the outputs"
        )
    return read_only(rotation), read_only(origin)


def turned(
    sweep: Sweep, joint: str, frame: str, components: Components
) -> tuple[StoredComponents, Array]:
    """Return the components of a wrench in other axes, and the joint's axis in them.

    Args:
        sweep: over one dimension.
        joint: name of the joint.
        frame: `parent` or `world`.
        components: in the joint's own axes.

    Raises:
        ArgumentError: the sweep has several dimensions.
        ModelError: the outputs leave out the joint's motion.
    """
    force, moment = components.vector(0), components.vector(3)
    if force.ndim != 2:
        raise ArgumentError(
            "only sweeps over one dimension turn wrenches into other axes, not those of "
            f"shape {force.shape[:-1]}"
        )
    record = sweep.mechanism.joints[joint]
    rotation = sweep.rotation(joint) if frame == "world" else _parent_rotation(sweep, joint)
    vectors = [np.einsum("nij,nj->ni", rotation, vector) for vector in (force, moment)]
    axis = record.axis
    if frame == "world" or record.type in _TURNING_AXIS:
        axis = rotation @ axis
    return StoredComponents(np.concatenate(vectors, axis=1)), axis


def _parent_rotation(sweep: Sweep, joint: str) -> Array:
    """Return rotations `(N, 3, 3)` from a joint's own frame to its frame at coordinate zero."""
    if not sweep.mechanism.joints[joint].parts:
        return np.broadcast_to(np.eye(3), (len(sweep), 3, 3))
    # The joint's frame at coordinate zero is fixed to its parent.
    frames = sweep.mechanism.frames
    index = frames.joints.index(joint)
    first_motion = next(motion for motion in frames.motions if motion.joint == index)
    at_zero, parent = first_motion.placement[:3, :3], frames.parents[index]
    if parent >= 0:
        at_zero = sweep.rotation(frames.joints[parent]) @ at_zero
    return np.asarray(np.swapaxes(at_zero, -1, -2) @ sweep.rotation(joint))
