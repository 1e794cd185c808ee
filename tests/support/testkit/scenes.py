"""Scenes of the bundled shafts, and measures that many tests take."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

import cardan_dyn as cd

URDF = Path(__file__).parents[3] / "urdf"


def text(name: str) -> str:
    return (URDF / f"{name}.urdf").read_text(encoding="utf-8")


def relative(found: np.ndarray, reference: np.ndarray) -> float:
    """Greatest deviation relative to the greatest value of the reference."""
    scale = float(np.max(np.abs(reference)))
    assert scale > 0.0
    return float(np.max(np.abs(found - reference))) / scale


def universal(
    mechanism: cd.Mechanism, beta: float, load: float = -1.0, **options: object
) -> cd.Scene:
    return cd.Scene(
        mechanism,
        drive="bearing_in",
        held={"joint_angle": beta},
        loads={"bearing_out": load},
        **options,
    )


def double(
    mechanism: cd.Mechanism, beta_1: float, beta_2: float, load: float = -1.0, **options: object
) -> cd.Scene:
    return cd.Scene(
        mechanism,
        drive="bearing_in",
        held={"joint_angle_1": beta_1, "joint_angle_2": beta_2},
        loads={"bearing_out": load},
        **options,
    )


class CrossGeometry:
    """The universal joint from its pin axes, in world axes; nothing here knows a formula for it.

    x is the input shaft, z the normal of the plane of the shafts; all arrays `(N, 3)`.
    """

    def __init__(self, beta: float, phi_1: np.ndarray) -> None:
        zero, one = np.zeros_like(phi_1), np.ones_like(phi_1)
        self.e_1 = np.stack([one, zero, zero], axis=1)
        self.e_2 = np.stack([np.cos(beta) * one, np.sin(beta) * one, zero], axis=1)
        # The input fork's pin lies in the plane of the shafts at phi_1 = 0.
        self.pin_1 = np.stack([zero, np.cos(phi_1), np.sin(phi_1)], axis=1)
        pin_2 = np.cross(self.e_2, self.pin_1)
        self.pin_2 = pin_2 / np.linalg.norm(pin_2, axis=1, keepdims=True)
        self.normal = np.cross(self.pin_1, self.pin_2)

    def moment(self, output_torque: float) -> np.ndarray:
        """Moment of the cross on shaft 2: normal to both pins, with this torque about e_2."""
        along = np.sum(self.normal * self.e_2, axis=1, keepdims=True)
        return output_torque * self.normal / along


def forward_accelerations(
    mechanism: cd.Mechanism, turn: cd.Sweep, sample: int, efforts: dict[str, float]
) -> tuple[np.ndarray, pin.Data, list[pin.Force]]:
    """Pinocchio's constrained forward dynamics at one sample, with its joint wrenches.

    Returns:
        Accelerations, data after an RNEA that includes the contact forces, and the contact forces
        in the frames of the welded joints.
    """
    model = mechanism.model
    data = model.createData()
    models = mechanism.constraint_models
    datas = pin.StdVec_RigidConstraintData()
    for item in models:
        datas.append(item.createData())
    pin.initConstraintDynamics(model, data, models, datas)
    tau = np.zeros(model.nv)
    for name, effort in efforts.items():
        tau[model.idx_vs[mechanism.joints[name].id]] += effort
    q, v = turn.motion.q[sample], turn.motion.v[sample]
    settings = pin.ProximalSettings(1e-14, 1e-8, 100)
    a = pin.constraintDynamics(model, data, q, v, tau, models, datas, settings).copy()

    external = pin.StdVec_Force()
    for _ in range(model.njoints):
        external.append(pin.Force.Zero())
    forces = []
    for loop, item in zip(mechanism.loops, datas, strict=True):
        force = item.contact_force
        forces.append(force)
        external[loop.predecessor] += loop.predecessor_placement.act(force)
        # The same force acts on the other body with the opposite sign.
        across = item.c1Mc2.actInv(force)
        external[loop.successor] -= loop.successor_placement.act(across)
    fresh = model.createData()
    pin.rnea(model, fresh, q, v, a, external)
    return a, fresh, forces
