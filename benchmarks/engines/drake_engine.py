"""Drake: a ball constraint in the discrete SAP solver, and least squares of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    DiscreteContactApproximation,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import JacobianWrtVariable, RevoluteJoint, SpatialInertia, UnitInertia

from .common import Method, pin_angles, split


def _chain(step: float) -> MultibodyPlant:
    plant = MultibodyPlant(step)
    if step:
        plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    inertia = SpatialInertia(1.0, [0.0, 0.0, 0.0], UnitInertia(0.01, 0.02, 0.02))
    parent = plant.world_body()
    for name, joint, axis in (
        ("shaft_in", "bearing_in", [1.0, 0.0, 0.0]),
        ("cross", "pin_in", [0.0, 1.0, 0.0]),
        ("shaft_out", "pin_out", [0.0, 0.0, 1.0]),
    ):
        body = plant.AddRigidBody(name, inertia)
        plant.AddJoint(
            RevoluteJoint(
                joint, parent.body_frame(), body.body_frame(), np.array(axis), damping=0.0
            )
        )
        parent = body
    return plant


def _loaded(plant: MultibodyPlant, moment: np.ndarray) -> Value:
    force = ExternallyAppliedSpatialForce()
    force.body_index = plant.GetBodyByName("shaft_out").index()
    force.p_BoBq_B = np.zeros(3)
    force.F_Bq_W = SpatialForce(moment, np.zeros(3))
    return Value([force])


class _Reactions:
    """Moments on the cross and on the output shaft from the reaction port, in world axes."""

    def __init__(self, plant: MultibodyPlant) -> None:
        self.plant = plant
        self.port = plant.get_reaction_forces_output_port()
        joints = [plant.GetJointByName(name) for name in ("pin_in", "pin_out")]
        self.indices = [int(joint.index()) for joint in joints]
        self.frames = [joint.frame_on_child() for joint in joints]

    def __call__(self, context: object) -> list[np.ndarray]:
        reactions = self.port.Eval(context)
        return [
            frame.CalcRotationMatrixInWorld(context) @ reactions[index].rotational()
            for index, frame in zip(self.indices, self.frames, strict=True)
        ]


def _least_squares(beta: float, phi: np.ndarray) -> Callable[[], np.ndarray]:
    plant = _chain(0.0)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    reactions = _Reactions(plant)
    port = plant.get_applied_spatial_force_input_port()
    efforts = plant.get_applied_generalized_force_input_port()
    body, world = plant.GetBodyByName("shaft_out").body_frame(), plant.world_frame()
    axis = np.array([np.cos(beta), np.sin(beta), 0.0])
    across = np.array([[-np.sin(beta), np.cos(beta), 0.0], [0.0, 0.0, 1.0]]).T

    def run() -> np.ndarray:
        q = np.stack([phi, *pin_angles(beta, phi)], axis=1)
        moments = np.empty((2, len(phi), 3))
        for sample, row in enumerate(q):
            plant.SetPositions(context, row)
            jacobian = plant.CalcJacobianAngularVelocity(
                context, JacobianWrtVariable.kQDot, body, world, world
            )
            passive = jacobian[:, 1:].T
            bearing = np.linalg.lstsq(passive @ across, passive @ axis, rcond=None)[0]
            moment = across @ bearing - axis
            port.FixValue(context, _loaded(plant, moment))
            efforts.FixValue(context, np.array([-jacobian[:, 0] @ moment, 0.0, 0.0]))
            moments[:, sample] = reactions(context)
        return split(moments[0], moments[1], beta)

    return run


def _sap(beta: float, phi: np.ndarray) -> Callable[[], np.ndarray]:
    plant = _chain(1e-3)
    # A ball on the world is not safe; on a body that is welded to the world, it is.
    stub = plant.AddRigidBody(
        "stub", SpatialInertia(1.0, [0.0, 0.0, 0.0], UnitInertia(1.0, 1.0, 1.0))
    )
    end = np.array([np.cos(beta), np.sin(beta), 0.0])
    plant.WeldFrames(plant.world_frame(), stub.body_frame(), RigidTransform(end))
    plant.AddBallConstraint(
        plant.GetBodyByName("shaft_out"), [1.0, 0.0, 0.0], stub, [0.0, 0.0, 0.0]
    )
    drive = plant.GetJointByName("bearing_in")
    plant.Finalize()
    context = plant.CreateDefaultContext()
    reactions = _Reactions(plant)
    port = plant.get_applied_spatial_force_input_port()
    drive.Lock(context)
    port.FixValue(context, _loaded(plant, -end))

    def run() -> np.ndarray:
        q = np.stack([phi, *pin_angles(beta, phi)], axis=1)
        moments = np.empty((2, len(phi), 3))
        for sample, row in enumerate(q):
            plant.SetPositions(context, row)
            plant.SetVelocities(context, np.zeros(3))
            plant.ExecuteForcedEvents(context)  # A discrete plant samples its reactions.
            moments[:, sample] = reactions(context)
        return split(moments[0], moments[1], beta)

    return run


def methods() -> list[Method]:
    """Return both methods."""
    installed = version("drake")
    return [
        Method(
            "Drake, SAP",
            installed,
            "ball constraint at the bearing, time step 1 ms; loop closed by the user",
            _sap,
        ),
        Method(
            "Drake, least squares",
            installed,
            "loop closed and closure forces solved by the user, reaction port",
            _least_squares,
        ),
    ]
