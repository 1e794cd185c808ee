"""Energies by hand."""

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
from cardan_dyn.core.dynamics.open_tree import OpenTree
from cardan_dyn.motion.simulation.turning_model import turning_model

X, V, A = np.array([[0.4], [2.0]]), np.array([[3.0], [-1.0]]), np.array([[5.0], [0.0]])


def test_energies_of_a_pendulum() -> None:
    energy = OpenTree(pendulum(), np.array(GRAVITY))
    np.testing.assert_allclose(energy.kinetic(X, V), 0.5 * ABOUT_PIN * V[:, 0] ** 2)
    height = -LENGTH * np.cos(X[:, 0])
    np.testing.assert_allclose(energy.potential(X), 9.81 * MASS * height)


def test_kinetic_energy_of_the_universal_joint(joint: cd.Mechanism) -> None:
    turn = universal(joint, 0.8).sweep(np.linspace(0.0, 6.0, 9), 3.0)
    found = OpenTree(joint, np.zeros(3)).kinetic(turn.motion.x, turn.motion.v)
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
        energy = OpenTree(mechanism, gravity)
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
    found = OpenTree(pendulum(), np.array(GRAVITY)).efforts(X, 0.0 * V, falling)
    np.testing.assert_allclose(found, np.abs(WEIGHT * np.sin(X)))
    found = OpenTree(pendulum(), np.zeros(3)).efforts(X, V, A)
    np.testing.assert_allclose(found, np.abs(ABOUT_PIN * A), atol=1e-15)
