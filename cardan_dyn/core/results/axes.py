"""Axes: where joints are during a sweep, wrenches in other axes, and what of them is unique."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError
from ..problem.problem import Problem
from ..proof.constraints import Constraints, Motion
from ..proof.screws import Screws
from ..proof.self_stress import SelfStressProof
from .wrench import Components, StoredComponents

_TURNING_AXIS = ("spherical", "universal", "floating")
"""Joints whose axis, as the child carries it, turns relative to the parent."""
_MOST_POSITIONS = 1000
"""Positions at which self-stresses are decomposed for flags in other axes: some 50 ms."""
_STANDS = 1e-9
"""Change of a rotation up to which axes stand still: closed loops miss a direction by less."""
_NOTHING = 1e-12
"""Factor on a component, of the greatest of a sum, that counts as none: rounding of rotations."""


def turned(
    sweep: Any, joint: str, frame: str, components: Components
) -> tuple[StoredComponents, Array]:
    """Return the components of a wrench in other axes, and the joint's axis in them.

    Args:
        sweep: that the wrench is of.
        joint: name of the joint.
        frame: `parent`, `world`, or the name of a link.
        components: in the joint's own axes.

    Raises:
        ModelError: the outputs leave out the joint's motion, or there is no such link.
    """
    record, rotation = sweep.mechanism.joints[joint], rotation_to(sweep, joint, frame)
    vectors = [rotation @ components.vector(first)[..., None] for first in (0, 3)]
    axis = record.axis
    if frame != "parent" or record.type in _TURNING_AXIS:
        axis = rotation @ axis
    return StoredComponents(np.concatenate(vectors, axis=-2)[..., 0]), axis


def rotation_to(sweep: Any, joint: str, frame: str) -> Array:
    """Return rotations `(..., 3, 3)` from a joint's own frame to other axes; see `turned`."""
    if frame == "world":
        rotation: Array = sweep.rotation(joint)
    elif frame != "parent":
        rotation = np.swapaxes(sweep.orientation(frame), -1, -2) @ sweep.rotation(joint)
    else:
        # The parent's axes are those of the joint's frame at coordinate zero.
        rotation = sweep.motion.joint_turn(joint)
        refuse_unsolved(joint, rotation)
    return rotation


def refuse_unsolved(joint: str, *values: Array) -> None:
    """Refuse a joint where values that follow from its motion are no numbers.

    Raises:
        ModelError: they are.
    """
    if not all(np.all(np.isfinite(array)) for array in values):
        raise ModelError(
            f"the outputs of the scene leave out joint {joint!r}; name it among the outputs"
        )


def in_fixed_axes(turn: Any, joint: str, of: str) -> dict[str, tuple[Array, bool]]:
    """Return components of a joint's force or moment in axes that stand still.

    These are the parent's where the parent does not turn, or else the world's. What is along the
    joint's axis is left out: it is the same in all axes. Orders are told of these components: the
    size of a vector has others, and axes that turn shift them.

    Args:
        turn: the sweep.
        joint: one of its outputs.
        of: `force` or `moment`.

    Returns:
        Names, as `moment y` or `moment world y`, to values `(N,)`, and whether they follow from the
        laws of motion alone.
    """
    of_parent = turn.rotation(joint) @ np.swapaxes(
        turn._rotation_from_joint(joint, "parent"), -1, -2
    )
    stands = bool(np.max(np.ptp(of_parent, axis=0)) <= _STANDS)
    wrench = turn.wrench(joint, "parent" if stands else "world")
    vectors = getattr(wrench, of)
    along = np.zeros(3) if not wrench.has_axis else np.abs(np.atleast_2d(wrench.axis)).min(axis=0)
    unique = wrench.unique[:3] if of == "force" else wrench.unique[3:]
    return {
        f"{of} {'' if stands else 'world '}{name}": (vectors[:, index], bool(unique[index]))
        for index, name in enumerate("xyz")
        if along[index] < 1.0 - _NOTHING
    }


def unique_of(
    problem: Problem, joint: str, unique: Array, x: Array, maps: Array, are_forces: Array
) -> Array:
    """Return `(k,)` which sums of the components of a wrench are unique, at all positions.

    A sum is unique where no self-stress changes it. Where self-stresses are not decomposed (too
    many positions or loops, motions that were not solved, a rank in doubt), those sums are taken to
    be unique of which all components along the joint's axes are that they consist of.

    Args:
        problem: that was solved.
        joint: name of the joint.
        unique: `(6,)` of the components in the joint's own axes, about its origin.
        x: `(N, size)` coordinates.
        maps: `(..., k, 6)` factors on these components.
        are_forces: `(k,)` which of the sums are forces; the others are moments.
    """
    if np.all(unique) or not len(x):
        return np.ones(len(are_forces), dtype=bool)
    factors = np.broadcast_to(maps.reshape(-1, *maps.shape[-2:]), (len(x), *maps.shape[-2:]))
    flags = None
    if len(x) <= _MOST_POSITIONS and np.all(np.isfinite(x)):
        index = problem.mechanism.frames.joints.index(joint)
        flags = _self_stress(problem).unique_of(index, x, factors, are_forces)
    sizes = np.abs(factors)
    greatest = np.max(sizes, axis=(0, 2))
    if flags is None:
        made_of = np.any(sizes > _NOTHING * greatest[:, None], axis=0)
        flags = ~np.any(made_of & ~unique, axis=1)
    for item in problem.mechanism.undescribed:
        if joint in item.changes:
            changes = np.max(np.abs(factors @ item.changes[joint]), axis=(0, 2))
            flags = flags & (changes <= _NOTHING * greatest)
    return np.asarray(flags)


def _self_stress(problem: Problem) -> SelfStressProof:
    """Return the self-stresses of a problem whose motion is solved."""
    mechanism = problem.mechanism
    known = np.ones(mechanism.model.nv, dtype=bool)
    screws, length = Screws(mechanism.frames), mechanism.characteristic_length
    constraints = Constraints(
        mechanism.description,
        mechanism.coordinates,
        screws,
        length,
        Motion(problem.independent, tuple(problem.held), known),
    )
    return SelfStressProof(
        screws,
        [item.loop for item in constraints.around],
        len(constraints.couplings),
        constraints.coupling_factors,
        problem.passive_columns.tolist(),
        length,
    )
