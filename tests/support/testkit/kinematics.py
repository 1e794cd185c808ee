"""Where the parts of a mechanism are, for tests."""

from __future__ import annotations

import pinocchio as pin

import cardan_dyn as cd
from cardan_dyn.core.mechanism.frames import Frames


def frames_of(mechanism: cd.Mechanism) -> Frames:
    """Return the frames of a mechanism's description."""
    return Frames(mechanism.description, mechanism.coordinates)


def at_zero(mechanism: cd.Mechanism) -> list[pin.SE3]:
    """Return the placements of all bodies of the model, with every joint at zero."""
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, pin.neutral(mechanism.model))
    return [placement.copy() for placement in data.oMi]
