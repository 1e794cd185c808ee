"""What a constrained model says of accelerations, and how far loops are open by Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array
from cardan_dyn.motion.simulation.constrained_model import ConstrainedModel
from cardan_dyn.motion.simulation.turning_model import turning_model


def accelerations(model: ConstrainedModel, x: Array, v: Array, *acting: Array | None) -> Array:
    """The accelerations `(nv,)` alone, see `ConstrainedModel.rates`."""
    return model.rates(x, v, *acting)[len(x) :]


def closure_error(mechanism: cd.Mechanism, x: Array) -> float:
    """The greatest angle [rad], or gap by the characteristic length, between ends of a loop."""
    model = turning_model(mechanism)
    data, errors = model.createData(), [0.0]
    pin.forwardKinematics(model, data, x)
    for loop in mechanism.loops:
        one = data.oMi[loop.predecessor] * loop.predecessor_placement
        other = data.oMi[loop.successor] * loop.successor_placement
        between = pin.log6(one.actInv(other))
        between.linear /= mechanism.characteristic_length
        errors.append(float(np.max(np.abs(between.vector))))
    return max(errors)
