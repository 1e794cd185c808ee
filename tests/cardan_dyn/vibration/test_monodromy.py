"""Monodromy matrices against exponentials, Mathieu's functions and tight tolerances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.special import mathieu_a, mathieu_b

from cardan_dyn.kit.periodic import nodes
from cardan_dyn.motion.vibration.model.motion_equation import LocalEquation
from cardan_dyn.motion.vibration.motions.stability import first_order, gauss, monodromy


def test_gauss_points_integrate_to_their_order() -> None:
    points, inner, outer = gauss(8)
    for power in range(16):
        assert outer @ points**power == pytest.approx(1.0 / (power + 1.0), abs=1e-15)
    for power in range(8):
        exact = points ** (power + 1) / (power + 1.0)
        np.testing.assert_allclose(inner @ points**power, exact, atol=1e-15)


def test_constant_coefficients() -> None:
    matrix = np.array([[0.0, 1.0], [-7.0, -0.4]])
    found, change = monodromy(np.tile(matrix, (1, 15, 1, 1)), np.pi)
    np.testing.assert_allclose(found[0], expm(np.pi * matrix), atol=1e-14)
    assert change < 1e-13


@pytest.mark.parametrize("q", [0.5, 5.0])
def test_mathieus_equation_at_its_edges(q: float) -> None:
    """y'' + (a - 2 q cos 2x) y = 0 over π: the trace is ±2 at characteristic values."""
    x = nodes(15, np.pi)
    for value, trace in (
        (mathieu_a(2, q), 2.0),
        (mathieu_b(2, q), 2.0),
        (mathieu_a(1, q), -2.0),
        (mathieu_b(3, q), -2.0),
    ):
        matrix = np.zeros((1, 15, 2, 2))
        matrix[..., 0, 1] = 1.0
        matrix[0, :, 1, 0] = 2.0 * q * np.cos(2.0 * x) - value
        found, _ = monodromy(matrix, np.pi)
        assert np.trace(found[0]) == pytest.approx(trace, abs=1e-11)
        assert np.linalg.det(found[0]) == pytest.approx(1.0, abs=1e-12)


def test_elements_are_halved_where_coefficients_are_sharp() -> None:
    """A stiffness with a bump a twentieth of a radian wide: single elements do not resolve it."""
    count = 255

    def stiffness(x: np.ndarray) -> np.ndarray:
        return 1.3 + 30.0 * np.exp(200.0 * (np.cos(2.0 * x) - 1.0))

    matrix = np.zeros((1, count, 2, 2))
    matrix[..., 0, 1] = 1.0
    matrix[0, :, 1, 0] = -stiffness(nodes(count, np.pi))
    found, change = monodromy(matrix, np.pi)

    def rate(x: float, y: np.ndarray) -> np.ndarray:
        return np.r_[y[2:], -stiffness(np.asarray(x)) * y[:2]]

    run = solve_ivp(
        rate, (0.0, np.pi), np.eye(2).ravel(), "DOP853", rtol=3e-14, atol=1e-16, max_step=0.005
    )
    np.testing.assert_allclose(found[0].ravel(), run.y[:, -1], atol=3e-13)
    assert change < 1e-10


def test_two_coordinates_against_an_integration() -> None:
    count, speed = 21, np.array([0.7])
    x = nodes(count, np.pi)
    mass = np.zeros((count, 2, 2))
    mass[:, 0, 0], mass[:, 1, 1] = 1.0 + 0.2 * np.cos(2.0 * x), 2.0
    mass[:, 0, 1] = mass[:, 1, 0] = 0.3 * np.sin(2.0 * x)
    damping = np.tile([[0.1, 0.4], [-0.4, 0.05]], (count, 1, 1))
    stiffness = np.tile([[2.0, 0.1], [0.0, 3.0]], (count, 1, 1))
    empty = np.zeros((1, 0))
    equation = LocalEquation(empty, empty, mass[None], damping[None], stiffness[None], empty)
    found, _ = monodromy(first_order(equation, speed), np.pi)

    def rate(phi: float, y: np.ndarray) -> np.ndarray:
        state = y.reshape(4, 4)
        c, s = np.cos(2.0 * phi), np.sin(2.0 * phi)
        here = np.array([[1.0 + 0.2 * c, 0.3 * s], [0.3 * s, 2.0]])
        pull = stiffness[0] @ state[:2] / 0.49 + damping[0] @ state[2:] / 0.7
        return np.concatenate([state[2:], -np.linalg.solve(here, pull)]).ravel()

    run = solve_ivp(rate, (0.0, np.pi), np.eye(4).ravel(), "DOP853", rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(found[0], run.y[:, -1].reshape(4, 4), atol=1e-11)


def test_a_drive_that_turns_backwards_meets_the_coefficients_in_that_order() -> None:
    count = 21
    x = nodes(count, np.pi)
    spring, damping = 2.0 + 0.5 * np.cos(2.0 * x) + 0.9 * np.sin(4.0 * x), 0.2 + 0.1 * np.sin(2 * x)
    empty = np.zeros((2, 0))
    equation = LocalEquation(
        empty,
        empty,
        *(np.tile(item[:, None, None], (2, 1, 1, 1)) for item in (np.ones(count), damping, spring)),
        empty,
    )
    speed = np.array([0.7, -0.7])
    found, _ = monodromy(first_order(equation, speed), np.pi)

    for row, pace in enumerate(speed):

        def rate(time: float, y: np.ndarray, pace: float = pace) -> list[float]:
            phi = pace * time
            push = (2.0 + 0.5 * np.cos(2.0 * phi) + 0.9 * np.sin(4.0 * phi)) * y[0]
            return [y[1], -push - (0.2 + 0.1 * np.sin(2.0 * phi)) * y[1]]

        ends = [
            solve_ivp(rate, (0.0, np.pi / 0.7), begin, rtol=1e-12, atol=1e-14).y[:, -1]
            for begin in ([1.0, 0.0], [0.0, 0.7])
        ]
        expected = np.array([[1.0], [1.0 / 0.7]]) * np.array(ends).T
        np.testing.assert_allclose(found[row], expected, atol=1e-9)
    assert np.linalg.det(found[1]) == pytest.approx(np.exp(-0.2 * np.pi / 0.7), rel=1e-9)
