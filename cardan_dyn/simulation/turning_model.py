"""Turning model: Pinocchio's model of a mechanism whose configurations are coordinate rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio

from ..arrays import Array
from ..mechanism.mechanism import Mechanism


def turning_model(mechanism: Mechanism, gravity: Array | None = None) -> Any:
    """Return the model in which revolute joints have their angle as configuration.

    So a row of `Coordinates` is a configuration, and derivatives of angles are velocities.

    Args:
        mechanism: the mechanism.
        gravity: `(3,)` [m/s²]; none if None.
    """
    source, model = mechanism.model, pinocchio.Model()
    for part in mechanism.coordinates.parts:
        index = part.id
        joint = source.joints[index]
        if part.kind == "revolute":
            joint = pinocchio.JointModelRevoluteUnaligned(part.axis)
        added = model.addJoint(
            source.parents[index], joint, source.jointPlacements[index], source.names[index]
        )
        model.inertias[added] = source.inertias[index]
    model.gravity.linear = np.zeros(3) if gravity is None else gravity
    return model
