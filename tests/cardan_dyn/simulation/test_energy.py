"""Work as an integral, and power of elements."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.simulated import pendulum

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import ElementForces
from cardan_dyn.motion.simulation.energy import gained

X, V = np.array([[0.4], [2.0]]), np.array([[3.0], [-1.0]])


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
    power = ElementForces(mechanism, elements).supplied(X, V, times)
    # Springs keep energy: they are no part of it.
    np.testing.assert_allclose(power, 4.0 * times * V[:, 0] - 2.0 * V[:, 0] ** 2)
