"""Rod spins: rates without them, and accelerations that are their derivatives."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.ball_rods import ALONG, WAYS

import cardan_dyn as cd


def spin_and_line(
    mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the angular velocity of the rod, and the line between its balls, in world axes."""
    body, placement = mechanism.link("rod")
    model, data = mechanism.model, mechanism.model.createData()
    q = mechanism.coordinates.configuration(x)[0]
    pinocchio.forwardKinematics(model, data, q, v)
    rotation = data.oMi[body].rotation
    return rotation @ data.v[body].angular, rotation @ placement.rotation @ ALONG


@pytest.mark.parametrize("way", ["balls", "hinges"])
def test_rates_leave_the_rod_without_spin(way: str) -> None:
    """Pinocchio's angular velocity of the rod has no part along the line between its balls."""
    mechanism = cd.load(WAYS[way]())
    kinematics = cd.Scene(mechanism, drive="a").solver.assembly.kinematics
    state = kinematics.evaluate(mechanism.coordinates.neutral()[None, :])
    v = kinematics.rates(state, np.ones((1, 1)))
    spin, line = spin_and_line(mechanism, state.x, v[0])
    assert abs(spin @ line) < 1e-14
    assert np.linalg.norm(spin) > 0.3


@pytest.mark.parametrize("way", ["balls", "hinges"])
@pytest.mark.parametrize("acceleration", [0.0, 2.0])
def test_accelerations_are_derivatives_of_the_rates(way: str, acceleration: float) -> None:
    mechanism = cd.load(WAYS[way]())
    coordinates = mechanism.coordinates
    kinematics = cd.Scene(mechanism, drive="a").solver.assembly.kinematics
    x = coordinates.neutral()[None, :]
    state = kinematics.evaluate(x)
    v = kinematics.rates(state, np.ones((1, 1)))
    a = kinematics.accelerations(state, v, np.full((1, 1), acceleration))

    def rates(time: float) -> np.ndarray:
        moved = x + time * coordinates.derivative(x, v)
        moved += 0.5 * time**2 * coordinates.curvature(x, v, a)
        speed = np.full((1, 1), 1.0 + acceleration * time)
        return kinematics.rates(kinematics.evaluate(coordinates.normalised(moved)), speed)

    step = 1e-4
    np.testing.assert_allclose((rates(step) - rates(-step)) / (2.0 * step), a, atol=1e-6)


def test_steps_towards_closed_loops_do_not_spin_the_rod() -> None:
    mechanism = cd.load(WAYS["balls"]())
    kinematics = cd.Scene(mechanism, drive="a").solver.assembly.kinematics
    x = mechanism.coordinates.neutral()[None, :]
    x[:, mechanism.coordinates.columns["a"]] += 0.02
    (group,) = kinematics.evaluate(x).groups
    step = group.step(group.error)
    v = np.zeros(mechanism.model.nv)
    v[group.group.passives] = step[0]
    spin, line = spin_and_line(mechanism, x, v)
    assert abs(spin @ line) < 1e-15
    assert np.linalg.norm(spin) > 1e-3
