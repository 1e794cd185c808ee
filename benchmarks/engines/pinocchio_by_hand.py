"""Pinocchio without the library: one loop over samples, closure forces solved by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from .common import Method, pin_angles


def _model() -> pin.Model:
    model = pin.Model()
    parent = 0
    for name, joint in (
        ("bearing_in", pin.JointModelRX()),
        ("pin_in", pin.JointModelRY()),
        ("pin_out", pin.JointModelRZ()),
    ):
        parent = model.addJoint(parent, joint, pin.SE3.Identity(), name)
        inertia = pin.Inertia(1.0, np.zeros(3), np.eye(3))
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    model.gravity.setZero()
    return model


def prepare(beta: float | np.ndarray, phi: np.ndarray) -> Callable[[], np.ndarray]:
    """Return what computes D₁, B₁, D₂, B₂ `(N, 4)`; the joint angle may be one per sample."""
    model = _model()
    data = model.createData()
    sine, cosine = (np.broadcast_to(values, phi.shape) for values in (np.sin(beta), np.cos(beta)))
    axes = np.stack([cosine, sine, 0.0 * sine], axis=1)
    planes = np.zeros((len(phi), 3, 2))
    planes[:, 0, 0], planes[:, 1, 0], planes[:, 2, 1] = -sine, cosine, 1.0
    rest = np.zeros(3)
    forces = pin.StdVec_Force()
    for _ in range(model.njoints):
        forces.append(pin.Force.Zero())

    def run() -> np.ndarray:
        q = np.stack([phi, *pin_angles(beta, phi)], axis=1)
        result = np.empty((len(phi), 4))
        for row, axis, across, out in zip(q, axes, planes, result, strict=True):
            # Columns of the last joint's Jacobian, in world axes about the joint's centre.
            turning = pin.computeJointJacobians(model, data, row)[3:]
            bearing = np.linalg.solve(turning[:, 1:].T @ across, turning[:, 1:].T @ axis)
            moment = across @ bearing - axis
            local = data.oMi[3].rotation.T @ moment
            forces[3] = pin.Force(np.zeros(3), local)
            pin.rnea(model, data, row, rest, rest, forces)
            first, last = data.f[1].angular, data.f[3].angular
            out[:] = first[0], np.hypot(first[1], first[2]), last[0], np.hypot(last[1], last[2])
        return result

    return run


def methods() -> list[Method]:
    """Return the method."""
    settings = "loop closed and closure forces solved by the user"
    return [Method("Pinocchio by hand", pin.__version__, settings, prepare)]
