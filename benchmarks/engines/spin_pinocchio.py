"""Pinocchio spins by hand: `constraintDynamics` and DOP853, the output held by a ball at its end.

Nothing closes the loop again after a step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

from ..spin import CROSS, SHAFT, Spin
from .spinning import Spinner

LEVELS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def _model() -> pin.Model:
    model = pin.Model()
    kinds = pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ()
    joint = 0
    for index, inertia in enumerate((SHAFT, CROSS, SHAFT)):
        joint = model.addJoint(joint, kinds[index], pin.SE3.Identity(), f"joint_{index}")
        body = pin.Inertia(1.0, np.zeros(3), inertia * np.eye(3))
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    model.gravity.setZero()
    return model


def _prepare(spin: Spin, tolerance: float) -> Callable[[], float]:
    model = _model()
    data = model.createData()
    cosine, sine = float(np.cos(spin.beta)), float(np.sin(spin.beta))
    tip = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    bearing = pin.SE3(np.eye(3), np.array([cosine, sine, 0.0]))
    ball = pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, 3, tip, 0, bearing)
    contacts, contact_data = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    contacts.append(ball)
    contact_data.append(ball.createData())
    pin.initConstraintDynamics(model, data, contacts, contact_data)
    # The row along the shaft is redundant; two proximal iterations reach rounding.
    settings = pin.ProximalSettings(0.0, 1e-8, 2)
    rest, dynamics = np.zeros(3), pin.constraintDynamics
    start = np.array([0.0, 0.0, spin.beta, *spin.start_speeds[:2], 0.0])

    def derivative(_: float, state: np.ndarray) -> np.ndarray:
        v = state[3:]
        a = dynamics(model, data, state[:3], v, rest, contacts, contact_data, settings)
        return np.concatenate((v, a))

    def run() -> float:
        options = {"method": "DOP853", "rtol": tolerance, "atol": tolerance}
        return float(solve_ivp(derivative, (0.0, spin.duration), start, **options).y[0, -1])

    return run


def methods() -> list[Spinner]:
    """Return the method."""
    settings = "constraintDynamics, ball at the bearing, solve_ivp DOP853; no projection"
    return [Spinner("Pinocchio by hand", pin.__version__, settings, LEVELS, _prepare)]
