"""Drake spins: a ball on the pin in the discrete SAP solver."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator

from ..spin import CROSS, SHAFT, Spin
from .spinning import Spinner

LEVELS = (60.0, 200.0, 600.0, 2000.0)


def _plant(beta: float, step: float) -> MultibodyPlant:
    plant = MultibodyPlant(step)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    bodies = {
        name: plant.AddRigidBody(
            name, SpatialInertia(1.0, [0.0, 0.0, 0.0], UnitInertia(value, value, value))
        )
        for name, value in (("shaft_in", SHAFT), ("cross", CROSS), ("shaft_out", SHAFT))
    }
    turned = RigidTransform(RollPitchYaw(0.0, 0.0, beta), [0.0, 0.0, 0.0])
    for name, parent, place, child, axis in (
        ("bearing_in", plant.world_body(), None, "shaft_in", [1.0, 0.0, 0.0]),
        ("pin_in", bodies["shaft_in"], None, "cross", [0.0, 1.0, 0.0]),
        ("bearing_out", plant.world_body(), turned, "shaft_out", [1.0, 0.0, 0.0]),
    ):
        frame = parent.body_frame()
        if place is not None:
            frame = plant.AddFrame(FixedOffsetFrame(f"{name}_frame", frame, place))
        plant.AddJoint(RevoluteJoint(name, frame, bodies[child].body_frame(), np.array(axis), 0.0))
    tip = [0.0, 0.0, 1.0]
    plant.AddBallConstraint(bodies["cross"], tip, bodies["shaft_out"], tip)
    plant.Finalize()
    return plant


def _prepare(spin: Spin, per_revolution: float) -> Callable[[], float]:
    plant = _plant(spin.beta, spin.duration / round(per_revolution * spin.revolutions))
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    speeds = np.array(spin.start_speeds)

    def run() -> float:
        context.SetTime(0.0)
        plant.SetPositions(context, np.zeros(3))
        plant.SetVelocities(context, speeds)
        simulator.Initialize()
        # Half a step more, so that rounding cannot leave the last step out.
        simulator.AdvanceTo(spin.duration + 0.5 * plant.time_step())
        return float(plant.GetPositions(context)[0])

    return run


def methods() -> list[Spinner]:
    """Return the method."""
    settings = "ball constraint on the pin, discrete"
    return [Spinner("Drake, SAP", version("drake"), settings, LEVELS, _prepare)]
