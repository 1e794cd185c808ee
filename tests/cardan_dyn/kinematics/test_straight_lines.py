"""Straight lines from the start: one meaning of a position, whatever the other samples are."""

from __future__ import annotations

import numpy as np
from testkit.planar_linkages import five_bar, solver, values

from cardan_dyn.kinematics.straight_lines import along_lines

ARM = float(np.hypot(0.5, 0.6))


def tips(positions: np.ndarray) -> np.ndarray:
    """Where both arms of the five-bar meet `(N, 2)`: above the line between their pins."""
    a, d = positions.T
    first = 0.4 * np.stack([-np.sin(a), np.cos(a)], axis=1)
    second = 0.4 * np.stack([-np.sin(d), np.cos(d)], axis=1) + np.array([1.0, 0.0])
    between = second - first
    distance = np.linalg.norm(between, axis=1, keepdims=True)
    normal = np.stack([-between[:, 1], between[:, 0]], axis=1) / distance
    return 0.5 * (first + second) + normal * np.sqrt(ARM**2 - 0.25 * distance**2)


def test_positions_in_any_order_and_number() -> None:
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    columns = [mechanism.coordinates.columns[name].start for name in "AD"]
    positions = np.random.default_rng(3).uniform(-0.6, 0.6, (900, 2))
    positions[:2] = [[0.0, 0.0], [9.0 * np.pi, 9.0 * np.pi]]
    reached = along_lines(kinematics, start, columns, positions)
    assert np.all(reached.is_there)
    x = reached.x
    a, b = values(mechanism, x, "A"), values(mechanism, x, "B")
    np.testing.assert_array_equal(x[:, columns], positions)
    along = -0.4 * np.sin(a) + 0.5 * np.cos(a + b) - 0.6 * np.sin(a + b)
    across = 0.4 * np.cos(a) + 0.5 * np.sin(a + b) + 0.6 * np.cos(a + b)
    np.testing.assert_allclose(np.stack([along, across], axis=1), tips(positions), atol=1e-12)
    np.testing.assert_allclose(b[1], -9.0 * np.pi, atol=1.2)
    for index in (0, 1, 500):
        alone = along_lines(kinematics, start, columns, positions[[index]])
        np.testing.assert_allclose(alone.x[0], x[index], atol=1e-13)


def test_lines_end_where_the_loops_open() -> None:
    """The pins move apart until the arms are in line; others are reached all the same."""
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    columns = [mechanism.coordinates.columns[name].start for name in "AD"]
    positions = np.array([[0.1, -0.1], [1.5, -1.5], [0.0, 0.0], [np.inf, 0.0]])
    reached = along_lines(kinematics, start, columns, positions)
    np.testing.assert_array_equal(reached.is_there, [True, False, True, False])
    end = np.arcsin((2.0 * ARM - 1.0) / 0.8)
    np.testing.assert_allclose(reached.x[1, columns], [end, -end], atol=1e-6)
    assert reached.residual[1] > 1e-10


def test_no_positions() -> None:
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    assert along_lines(kinematics, start, [0, 1], np.zeros((0, 2))).x.shape == (0, start.size)
