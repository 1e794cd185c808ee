"""Turning model: Pinocchio's model of a mechanism whose configurations are coordinate rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from .free_balls import WithBalls


def turning_model(
    mechanism: Mechanism | WithBalls,
    gravity: Array | None = None,
    length: float = 1.0,
    bodies: Sequence[int] | None = None,
) -> Any:
    """Return the model in which revolute joints have their angle as configuration.

    So a row of `Coordinates` is a configuration, and derivatives of angles are velocities.

    Args:
        mechanism: the mechanism.
        gravity: `(3,)` [m/s²]; none if None.
        length: unit of all lengths of the model [m], slides included.
        bodies: those that it consists of, with all between them and the world, ascending; all if
            None.
    """
    source, model = mechanism.model, pinocchio.Model()
    chosen = range(1, source.njoints) if bodies is None else bodies
    own = {0: 0, **{body: index for index, body in enumerate(chosen, start=1)}}
    armature: list[float] = []
    for part in mechanism.coordinates.parts:
        index = part.id
        if index not in own:
            continue
        joint = source.joints[index]
        if part.kind == "revolute":
            joint = pinocchio.JointModelRevoluteUnaligned(part.axis)
        placement = in_lengths(source.jointPlacements[index], length)
        added = model.addJoint(own[source.parents[index]], joint, placement, source.names[index])
        inertia = source.inertias[index].copy()
        inertia.lever, inertia.inertia = inertia.lever / length, inertia.inertia / length**2
        model.inertias[added] = inertia
        unit = 1.0 if part.kind == "prismatic" else length**2
        armature += (source.armature[source.idx_vs[index] :][: part.nv] / unit).tolist()
    model.armature = np.array(armature)
    model.gravity.linear = np.zeros(3) if gravity is None else gravity / length
    return model


def in_lengths(placement: pinocchio.SE3, length: float) -> pinocchio.SE3:
    """Return a placement in another unit of length [m]."""
    return pinocchio.SE3(placement.rotation, placement.translation / length)
