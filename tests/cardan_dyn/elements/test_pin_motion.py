"""Pins of contacts one state at a time, against whole arrays and virtual work."""

from __future__ import annotations

import numpy as np
import pinocchio
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import ElementForces
from cardan_dyn.core.elements.one_state import OneState
from cardan_dyn.motion.simulation.turning_model import turning_model


def contact(friction: float = 0.0) -> cd.PinContact:
    """A pin far from the axis of its bush, so that it presses everywhere."""
    return cd.PinContact(
        "left", (0.1, 0.2, 0.3), (0.3, -0.4, 0.8), "right", (-0.2, 0.1, 0.5), 1e-2,
        cd.LinearContact(50.0, 3.0), friction=friction, radius=0.05, transition=0.3,
    )  # fmt: skip


def test_states_one_by_one_are_those_of_whole_arrays_and_do_the_same_work() -> None:
    mechanism = cd.load(MIXED)
    x, v = rows(mechanism, 12, seed=5), np.random.default_rng(6).normal(size=(12, 1))
    v = v * np.random.default_rng(7).normal(size=(12, mechanism.model.nv))
    element = contact(0.4)
    acted = ElementForces(mechanism, [element]).at(x, v)
    each = ElementForces(mechanism, [element]).each(x, v)[0]
    model, pin = turning_model(mechanism), element.motion(mechanism)
    acting = element.on(mechanism, "contact")
    data = model.createData()
    for index in range(len(x)):
        pinocchio.forwardKinematics(model, data, x[index], v[index])
        pinocchio.computeJointJacobians(model, data, x[index])
        place = pin.place(data)
        np.testing.assert_allclose(place.depth, each.depth[index], rtol=1e-12)
        efforts = np.zeros(model.nv)
        state = x[index], v[index]
        numbers = x[index].tolist(), v[index].tolist()
        acting.add(efforts, OneState(0.0, *state, *numbers, model, data))
        np.testing.assert_allclose(efforts @ v[index], acted.power[index], rtol=1e-10, atol=1e-12)
        # What is done on both links is what is stored and turned to heat.
        stored = 50.0 * each.depth[index] * place.growth
        np.testing.assert_allclose(
            -acted.power[index], stored + each.dissipation[index], rtol=1e-10, atol=1e-12
        )


def test_the_proof_finds_the_same_wrenches() -> None:
    mechanism = cd.load("four_bar")
    pin = cd.PinContact(
        "coupler", (0.0, 0.01, 0.0), (0.0, 0.0, 1.0), "frame" if "frame" in mechanism.links
        else mechanism.link_names[0], (0.1, 0.2, 0.0), 1e-3, cd.LinearContact(1e4, 5.0),
        friction=0.2, radius=0.01,
    )  # fmt: skip
    scene = cd.Scene(mechanism, drive="crank_bearing", elements=[pin])
    sweep = scene.sweep(np.linspace(0.0, 6.0, 40), 20.0)
    assert np.min(sweep.element_force[0].pressure) > 0.0
    assert sweep.balance_residual < 1e-13 and sweep.power_residual < 1e-12
