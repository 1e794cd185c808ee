"""Base motion: how the bodies move from which groups of loops hang.

Loops close relative to their base, so only inertia, weight and forces given in world axes need to
know how it moves. Every base is placed by the group that its own inertia belongs to, and moves with
the base of that group, from the world outwards.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Array, cross
from ..kinematics.closing.all_groups import ClosedState
from ..kinematics.closing.batch_model import BaseMotion, placement
from ..kinematics.closing.group_solver import GroupState


def base_motions(
    state: ClosedState,
    group_of: Mapping[int, int],
    bases: Sequence[int],
    dynamics: tuple[Array, Array],
    gravity: Array,
) -> dict[int, BaseMotion]:
    """Return the motions of bases.

    Args:
        state: closed positions.
        group_of: body (0-based) to the index of the group that places it.
        bases: the bases, ascending, and those of the groups that place them among them.
        dynamics: joint velocities and accelerations, each `(N, nv)`.
        gravity: `(N, 3)` or `(1, 3)` [m/s²].

    Returns:
        By base; -1 is the world.
    """
    motions = {-1: BaseMotion.against(gravity, len(state.x))}
    for base in bases:
        group = state.groups[group_of[base]]
        motions[base] = motion_on(group, base, motions[group.batch.base], dynamics)
    return motions


def base_rotations(
    state: ClosedState, group_of: Mapping[int, int], bases: Sequence[int]
) -> dict[int, Array]:
    """Return the rotations `(3, 3, N)` of bases in the world; arguments as of `base_motions`."""
    rotations = {-1: np.eye(3)[:, :, None]}
    for base in bases:
        group = state.groups[group_of[base]]
        rotation, _ = placement(group.actions, group.batch.index_of[base])
        rotations[base] = np.einsum("ijn,jkn->ikn", rotations[group.batch.base], rotation)
    return rotations


def motion_on(
    group: GroupState, body: int, of_base: BaseMotion, dynamics: tuple[Array, Array]
) -> BaseMotion:
    """Return the motion of a body that a group places on its base.

    Args:
        group: the group.
        body: the body (0-based).
        of_base: how the group's base moves.
        dynamics: see `base_motions`.
    """
    batch = group.batch
    joint_twists, joint_accelerations = (
        batch.velocity(rates).reshape(len(rates), -1, 6) for rates in dynamics
    )
    twist, acceleration = (_about(vectors.T, batch.origin[:, None]) for vectors in of_base)
    for index in batch.path(batch.index_of[body]):
        actions = group.actions[:, 6 * index : 6 * index + 6]
        relative, change = (
            (rates[:, [index]] @ actions)[:, 0].T for rates in (joint_twists, joint_accelerations)
        )
        twist = twist + relative
        # The axes of a joint move with its body, which changes its twist.
        acceleration = acceleration + change + _product(twist, relative)
    rotation, position = placement(group.actions, batch.index_of[body])
    return BaseMotion(
        *(_in_frame(_about(vectors, position), rotation) for vectors in (twist, acceleration))
    )


def _about(twist: Array, point: Array) -> Array:
    """Return a twist `(6, N)` about another point, `(3, N)` or `(3, 1)` from the former one."""
    linear, angular = twist[:3], twist[3:]
    return np.concatenate([linear + cross(angular, np.broadcast_to(point, angular.shape)), angular])


def _in_frame(twist: Array, rotation: Array) -> Array:
    """Return a twist `(6, N)` in the axes of a frame, `(N, 6)`."""
    return np.einsum("ijn,kin->nkj", rotation, twist.reshape(2, 3, -1)).reshape(-1, 6)


def _product(twist: Array, other: Array) -> Array:
    """Return the spatial cross product: the rate of a twist `other` that moves with `twist`."""
    linear = cross(twist[3:], other[:3]) + cross(twist[:3], other[3:])
    return np.concatenate([linear, cross(twist[3:], other[3:])])
