"""Energies by hand, and work as an integral."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit import tongs
from testkit.scenes import universal
from testkit.simulated import (
    ABOUT_PIN,
    GRAVITY,
    LENGTH,
    MASS,
    WEIGHT,
    SpinningJoint,
    pendulum,
)

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import ElementForces
from cardan_dyn.motion.simulation.energy import WeightEnergy, element_power, gained, open_efforts
from cardan_dyn.motion.simulation.turning_model import turning_model

X, V, A = np.array([[0.4], [2.0]]), np.array([[3.0], [-1.0]]), np.array([[5.0], [0.0]])


def test_energies_of_a_pendulum() -> None:
    energy = WeightEnergy(pendulum(), np.array(GRAVITY))
    np.testing.assert_allclose(energy.kinetic(X, V), 0.5 * ABOUT_PIN * V[:, 0] ** 2)
    height = -LENGTH * np.cos(X[:, 0])
    np.testing.assert_allclose(energy.potential(X), 9.81 * MASS * height)


def test_kinetic_energy_of_the_universal_joint(joint: cd.Mechanism) -> None:
    turn = universal(joint, 0.8).sweep(np.linspace(0.0, 6.0, 9), 3.0)
    found = WeightEnergy(joint, np.zeros(3)).kinetic(turn.motion.x, turn.motion.v)
    expected = 0.5 * SpinningJoint(0.8).inertia(np.linspace(0.0, 6.0, 9)) * 9.0
    np.testing.assert_allclose(found, expected, rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 25])
def test_energies_of_few_and_many_bodies_are_those_of_one_model(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where bodies are many, without Pinocchio's data, which grow with their third power."""
    mechanism, gravity = tongs.two_chains(count), np.array([0.3, -9.81, 2.0])
    rng = np.random.default_rng(count)
    x, v = rng.normal(size=(2, 4, mechanism.model.nv))
    made: list[int] = []
    create = pin.Model.createData

    def counted(model: pin.Model) -> pin.Data:
        made.append(model.nv)
        return create(model)

    with monkeypatch.context() as patch:
        patch.setattr(pin.Model, "createData", counted)
        energy = WeightEnergy(mechanism, gravity)
        found = energy.kinetic(x, v), energy.potential(x)
    assert max(made, default=0) < 32
    model = turning_model(mechanism, gravity)
    data = model.createData()
    states = list(zip(x, v, strict=True))
    kinetic = [pin.computeKineticEnergy(model, data, *state) for state in states]
    potential = [pin.computePotentialEnergy(model, data, row) for row in x]
    np.testing.assert_allclose(found[0], kinetic, rtol=1e-13)
    np.testing.assert_allclose(found[1], potential, rtol=1e-12)
    mass = sum(inertia.mass for inertia in list(model.inertias)[1:])
    np.testing.assert_allclose(energy.weight, mass * np.linalg.norm(gravity), rtol=1e-14)


def test_open_efforts_do_not_cancel() -> None:
    falling = -WEIGHT * np.sin(X) / ABOUT_PIN
    found = open_efforts(pendulum(), np.array(GRAVITY), X, 0.0 * V, falling)
    np.testing.assert_allclose(found, np.abs(WEIGHT * np.sin(X)))
    found = open_efforts(pendulum(), np.zeros(3), X, V, A)
    np.testing.assert_allclose(found, np.abs(ABOUT_PIN * A), atol=1e-15)


def test_work_is_the_integral_of_power() -> None:
    steps = np.linspace(0.0, 4.0, 9)
    times = np.array([0.0, 0.7, 2.0, 4.0])
    found = gained(lambda t: np.cos(3.0 * t), steps, times, False)
    np.testing.assert_allclose(found, np.sin(3.0 * times) / 3.0, atol=1e-15)
    np.testing.assert_array_equal(gained(np.cos, steps, times, True), 0.0)


def test_work_of_steps_with_kinks_at_their_ends() -> None:
    found = gained(lambda t: np.abs(t - 1.0), np.array([0.0, 1.0, 3.0]), np.array([3.0]), False)
    assert found[0] == pytest.approx(0.5 + 2.0, abs=1e-15)


def test_power_is_asked_for_once_where_times_are_the_ends_of_steps() -> None:
    asked: list[np.ndarray] = []

    def power(times: np.ndarray) -> np.ndarray:
        asked.append(times)
        return np.cos(times)

    steps = np.linspace(0.0, 2.0, 5)
    found = gained(power, steps, steps, False)
    np.testing.assert_allclose(found, np.sin(steps), atol=1e-15)
    points = np.concatenate(asked)
    assert len(np.unique(points)) > 0.75 * len(points)  # All twice would cost twice.
    np.testing.assert_array_equal(gained(power, np.zeros(1), np.zeros(3), False), 0.0)


def test_power_of_elements() -> None:
    mechanism = pendulum()
    elements = [
        cd.JointSpring("pin", 7.0, damping=2.0),
        cd.Actuator("pin", lambda time: 4.0 * time),
    ]
    times = np.array([0.5, 1.0])
    power = element_power(ElementForces(mechanism, elements), X, V, times)
    # Springs keep energy: they are no part of it.
    np.testing.assert_allclose(power, 4.0 * times * V[:, 0] - 2.0 * V[:, 0] ** 2)
