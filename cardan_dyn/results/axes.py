"""Axes: where joints are during a sweep, and wrenches turned into axes other than the joint's."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..frozen import read_only
from ..mechanism.mechanism import Mechanism
from .motion import Motion
from .wrench import Components, StoredComponents

_TURNING_AXIS = ("spherical", "universal", "floating")
"""Joints whose axis, as the child carries it, turns relative to the parent."""


def solved_placement(motion: Motion, joint: str) -> tuple[Array, Array]:
    """Return rotations `(N, 3, 3)` and origins `(N, 3)` [m] of a joint's frame in the world.

    Raises:
        ModelError: its motion was not solved.
    """
    rotation, origin = motion.joint_placement(joint)
    if not (np.all(np.isfinite(rotation)) and np.all(np.isfinite(origin))):
        raise ModelError(
            f"the outputs of the scene leave out joint {joint!r}; name it among the outputs"
        )
    return read_only(rotation), read_only(origin)


def turned(
    mechanism: Mechanism,
    joint: str,
    frame: str,
    components: Components,
    rotation_of: Callable[[str], Array],
) -> tuple[StoredComponents, Array]:
    """Return the components of a wrench in other axes, and the joint's axis in them.

    Args:
        mechanism: the joint's.
        joint: name of the joint.
        frame: `parent` or `world`.
        components: in the joint's own axes.
        rotation_of: see `Sweep.rotation`.

    Raises:
        ModelError: the outputs leave out the joint's motion.
    """
    force, moment = components.vector(0), components.vector(3)
    record = mechanism.joints[joint]
    rotation = rotation_of(joint)
    if frame == "parent":
        rotation = _from_zero(mechanism, joint, rotation, rotation_of)
    vectors = [np.einsum("...ij,...j->...i", rotation, vector) for vector in (force, moment)]
    axis = record.axis
    if frame == "world" or record.type in _TURNING_AXIS:
        axis = rotation @ axis
    return StoredComponents(np.concatenate(vectors, axis=-1)), axis


def _from_zero(
    mechanism: Mechanism, joint: str, rotation: Array, rotation_of: Callable[[str], Array]
) -> Array:
    """Return rotations `(N, 3, 3)` from a joint's own frame to its frame at coordinate zero.

    The latter stays with the parent.
    """
    if not mechanism.joints[joint].parts:
        return np.broadcast_to(np.eye(3), rotation.shape)
    frames = mechanism.frames
    index = frames.joints.index(joint)
    first_motion = next(motion for motion in frames.motions if motion.joint == index)
    at_zero, parent = first_motion.placement[:3, :3], frames.parents[index]
    if parent >= 0:
        at_zero = rotation_of(frames.joints[parent]) @ at_zero
    return np.asarray(np.swapaxes(at_zero, -1, -2) @ rotation)
