"""Axes: where joints are during a sweep, and wrenches turned into axes other than the joint's."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..frozen import read_only
from ..problem.problem import Problem
from ..proof.constraints import Constraints
from ..proof.constraints import Motion as Prescribed
from ..proof.self_stress import SelfStressProof
from ..proof.twists import Twists
from .motion import Motion
from .wrench import Components, StoredComponents

_TURNING_AXIS = ("spherical", "universal", "floating")
"""Joints whose axis, as the child carries it, turns relative to the parent."""
_MOST_POSITIONS = 1000
"""Positions at which self-stresses are decomposed for flags in other axes: some 50 ms."""
_NOTHING = 1e-12
"""Component of a unit vector that counts as none: rounding of rotations."""


def solved_placement(motion: Motion, joint: str) -> tuple[Array, Array]:
    """Return rotations `(N, 3, 3)` and origins `(N, 3)` [m] of a joint's frame in the world.

    Raises:
        ModelError: its motion was not solved.
    """
    rotation, origin = motion.joint_placement(joint)
    _refuse_unsolved(joint, rotation, origin)
    return read_only(rotation), read_only(origin)


def _refuse_unsolved(joint: str, *values: Array) -> None:
    """Refuse a joint where values that follow from its motion are no numbers."""
    if not all(np.all(np.isfinite(array)) for array in values):
        raise ModelError(
            f"the outputs of the scene leave out joint {joint!r}; name it among the outputs"
        )


def turned(
    joint: str,
    frame: str,
    components: Components,
    motion: Motion,
    rotation_of: Callable[[str], Array],
) -> tuple[StoredComponents, Array]:
    """Return the components of a wrench in other axes, and the joint's axis in them.

    Args:
        joint: name of the joint.
        frame: `parent` or `world`.
        components: in the joint's own axes.
        motion: of the sweep.
        rotation_of: see `Sweep.rotation`.

    Raises:
        ModelError: the outputs leave out the joint's motion.
    """
    force, moment = components.vector(0), components.vector(3)
    record = motion.mechanism.joints[joint]
    rotation = rotation_to(joint, frame, motion, rotation_of)
    vectors = [np.matmul(rotation, vector[..., None])[..., 0] for vector in (force, moment)]
    axis = record.axis
    if frame == "world" or record.type in _TURNING_AXIS:
        axis = rotation @ axis
    return StoredComponents(np.concatenate(vectors, axis=-1)), axis


def rotation_to(
    joint: str, frame: str, motion: Motion, rotation_of: Callable[[str], Array]
) -> Array:
    """Return rotations `(..., 3, 3)` from a joint's own frame to other axes; see `turned`."""
    if frame == "world":
        return rotation_of(joint)
    # The parent's axes are those of the joint's frame at coordinate zero.
    rotation = motion.joint_turn(joint)
    _refuse_unsolved(joint, rotation)
    return rotation


def unique_in(problem: Problem, joint: str, unique: Array, rotation: Array, x: Array) -> Array:
    """Return `(6,)` which components of a wrench are unique in other axes, at all positions.

    A component is unique where no self-stress changes it. Where self-stresses are not decomposed
    (too many positions or loops, motions that were not solved, a rank in doubt), those components
    are taken to be unique of which all components along the joint's axes are that they consist of.

    Args:
        problem: that was solved.
        joint: name of the joint.
        unique: `(6,)` in the joint's own axes.
        rotation: `(..., 3, 3)` from these to the other axes.
        x: `(N, size)` coordinates.
    """
    if np.all(unique) or not len(x):
        return unique
    rotations = np.broadcast_to(rotation.reshape(-1, 3, 3), (len(x), 3, 3))
    flags = None
    if len(x) <= _MOST_POSITIONS and np.all(np.isfinite(x)):
        frames = problem.mechanism.frames
        flags = _self_stress(problem).unique_in(frames.joints.index(joint), x, rotations)
    if flags is None:
        made_of = np.any(np.abs(rotations) > _NOTHING, axis=0)
        flags = np.concatenate([~np.any(made_of & ~half, axis=1) for half in np.split(unique, 2)])
    return read_only(np.asarray(flags))


def _self_stress(problem: Problem) -> SelfStressProof:
    """Return the self-stresses of a problem whose motion is solved."""
    mechanism = problem.mechanism
    known = np.ones(mechanism.model.nv, dtype=bool)
    twists, length = Twists(mechanism.frames), mechanism.characteristic_length
    constraints = Constraints(
        mechanism.description,
        mechanism.coordinates,
        twists,
        length,
        Prescribed(problem.independent, tuple(problem.held), known),
    )
    return SelfStressProof(
        twists,
        constraints.loops,
        constraints.known_coupling_factors,
        problem.passive_columns,
        length,
    )
