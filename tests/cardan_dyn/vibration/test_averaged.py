"""Modes of linear equations with constant coefficients."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.kit.periodic import nodes
from cardan_dyn.motion.vibration.model.modes import averaged, modes
from cardan_dyn.motion.vibration.model.motion_equation import LocalEquation


def of(mass: object, damping: object, stiffness: object) -> tuple:
    return modes(*(np.array([item], dtype=float) for item in (mass, damping, stiffness)))


@pytest.mark.parametrize("ratio", [0.05, 1e-6])
def test_a_damped_oscillator(ratio: float) -> None:
    omega = 3.0
    found = of([[2.0]], [[4.0 * ratio * omega]], [[2.0 * omega**2]])
    assert found.frequency[0, 0] == pytest.approx(omega * np.sqrt(1.0 - ratio**2))
    expected = 2.0 * np.pi * ratio / np.sqrt(1.0 - ratio**2)
    assert found.log_decrement[0, 0] == pytest.approx(expected, rel=1e-8)
    assert found.amplification[0, 0] == pytest.approx(0.5 / ratio)


def test_a_gyroscopic_rotor() -> None:
    """A q̈ + G J q̇ + c q = 0: ω² ∓ G ω - 1 = 0, circles forwards and backwards."""
    gyro = 0.3
    found = of(np.eye(2), [[0.0, gyro], [-gyro, 0.0]], np.eye(2))
    half = gyro / 2.0
    expected = [np.hypot(1.0, half) - half, np.hypot(1.0, half) + half]
    np.testing.assert_allclose(found.frequency[0], expected, rtol=1e-13)
    np.testing.assert_allclose(np.abs(found.shape[0]), np.ones((2, 2)), rtol=1e-12)
    turns = found.shape[0, 1] / found.shape[0, 0]
    # q_1 + i q_2 = e^{iωt} turns forwards, at the higher frequency.
    np.testing.assert_allclose(turns, [1j, -1j], atol=1e-12)
    assert np.all(np.isinf(found.amplification))


def test_a_creeping_mode_has_no_decrement() -> None:
    found = of([[1.0]], [[5.0]], [[4.0]])
    assert found.frequency[0, 0] == 0.0
    assert found.value[0, 0].real == pytest.approx(-1.0)
    assert np.isnan(found.log_decrement[0, 0])


def test_swinging_modes_come_before_creeping_ones() -> None:
    found = of(np.eye(2), np.diag([5.0, 0.0]), np.diag([4.0, 9.0]))
    np.testing.assert_allclose(found.frequency[0], [3.0, 0.0], atol=1e-12)


def test_means_of_coefficients() -> None:
    """Of cos², over all nodes of a period, a half; one motion is not mixed with another."""
    wave = np.cos(nodes(9, np.pi))[None, :, None, None] ** 2 * np.eye(2)
    equation = LocalEquation(
        np.zeros(0), np.zeros(0), wave, 3.0 * wave, np.stack([wave[0]] * 2), np.zeros(0)
    )
    mass, damping, stiffness = averaged(equation)
    np.testing.assert_allclose(mass, [0.5 * np.eye(2)], atol=1e-15)
    np.testing.assert_allclose(damping, [1.5 * np.eye(2)], atol=1e-15)
    assert stiffness.shape == (2, 2, 2)


def test_of_each_creeping_pair_the_greater_is_kept() -> None:
    """(λ + 1)(λ + 2) and (λ + 10)(λ + 20) of coordinates without coupling."""
    found = of(np.eye(2), np.diag([3.0, 30.0]), np.diag([2.0, 200.0]))
    np.testing.assert_allclose(found.value[0], [-1.0, -10.0], rtol=1e-12)
    np.testing.assert_allclose(found.shape[0], np.eye(2), atol=1e-12)
    # An eigenvalue alone says nothing of ζ, which is 1.06 here.
    assert np.all(np.isnan(found.amplification))


def test_a_slow_mode_swings_beside_one_that_dies_at_once() -> None:
    found = of(np.eye(2), np.diag([1e11, 0.02]), np.eye(2))
    assert found.frequency[0, 0] == pytest.approx(np.sqrt(1.0 - 0.01**2), rel=1e-4)
    assert found.frequency[0, 1] == 0.0
