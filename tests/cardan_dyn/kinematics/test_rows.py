"""Rows: interpolation, extrapolation and derivatives, against known functions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from testkit.planar_linkages import four_bar, solver

from cardan_dyn.core.kinematics.following.branch import Branch
from cardan_dyn.core.kinematics.following.lines import Rows, quintic


def polynomials(degree: int) -> list[Polynomial]:
    """One per coordinate."""
    coefficients = np.random.default_rng(5).uniform(-1.0, 1.0, (3, degree + 1))
    return [Polynomial(row) for row in coefficients]


def evaluated(curves: list[Polynomial], positions: np.ndarray) -> np.ndarray:
    return np.stack([curve(positions) for curve in curves], axis=1)


def rows_on(curves: list[Polynomial], positions: object) -> Rows:
    at = np.asarray(positions, dtype=float)
    x, first, second = ([curve.deriv(order) for curve in curves] for order in range(3))
    return Rows(evaluated(x, at), evaluated(first, at), 0.5 * evaluated(second, at))


def between(curves: list[Polynomial], nodes: object, positions: np.ndarray) -> np.ndarray:
    """What quintics between nodes are at positions."""
    rows, at = rows_on(curves, nodes), np.asarray(nodes, dtype=float)
    left = at[1:-1].searchsorted(positions)
    share = (positions - at[left]) / np.diff(at)[left]
    return quintic(rows.of(slice(-1)).quintics(np.diff(at), rows.of(slice(1, None))), left, share)


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4, 5])
def test_polynomials_up_to_degree_five_are_interpolated_exactly(degree: int) -> None:
    curves = polynomials(degree)
    positions = np.linspace(-1.0, 1.0, 41)
    guess = between(curves, [-1.0, -0.3, 0.9, 1.0], positions)
    np.testing.assert_allclose(guess, evaluated(curves, positions), rtol=0.0, atol=1e-14)


def test_the_error_at_degree_six_falls_with_its_sixth_power() -> None:
    curves = polynomials(6)

    def error(width: float) -> float:
        middle = np.array([0.5 * width])
        guess = between(curves, [0.0, width], middle)
        return float(np.max(np.abs(guess - evaluated(curves, middle))))

    assert error(1.0) / error(0.5) == pytest.approx(64.0, rel=1e-6)


def test_extrapolation_is_exact_to_degree_two() -> None:
    curves = polynomials(2)
    found = rows_on(curves, [-1.0, 0.2]).after(np.array([-0.4, 0.7]))
    np.testing.assert_allclose(found, evaluated(curves, np.array([-1.4, 0.9])), atol=1e-14)


def test_extrapolation_misses_the_cubic_term() -> None:
    curves = [Polynomial([0.0, 0.0, 0.0, 2.0])]
    np.testing.assert_allclose(rows_on(curves, [0.0]).after(np.array([0.3])), 0.0)
    # Seen back from 0.3 as well: the remainder of a cubic is 2 h³, whatever it starts from.
    back = rows_on(curves, [0.3]).after(np.array([-0.3]))
    assert back[0, 0] == pytest.approx(2.0 * 0.3**3)


def test_a_single_node_is_repeated() -> None:
    kinematics, start = solver(four_bar(), "A")
    guess = Branch(kinematics, start).guess(np.array([0.1, 0.7]))
    column = four_bar().coordinates.columns["A"].start
    np.testing.assert_array_equal(guess[:, column], [0.1, 0.7])
    rest = np.delete(guess, column, axis=1)
    np.testing.assert_array_equal(rest, np.delete(np.stack([start] * 2), column, axis=1))


@pytest.mark.parametrize("drive", ["A", "D"])
def test_derivatives_of_nodes_equal_central_differences(drive: str) -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, drive)
    column = mechanism.coordinates.columns[drive].start
    step = 1e-3
    guess = np.repeat(start[None, :], 5, axis=0)
    guess[:, column] = 0.1 + step * np.arange(-2.0, 3.0)
    state = kinematics.close(guess)
    rows = Rows.along(kinematics, state, np.ones((5, 1)))
    # Differences of fourth order, so that their own error stays near rounding.
    first = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) @ state.x / (12.0 * step)
    second = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) @ state.x / (12.0 * step**2)
    np.testing.assert_array_equal(rows.x, state.x)
    np.testing.assert_allclose(rows.first[2], first, atol=1e-9)
    np.testing.assert_allclose(2.0 * rows.second[2], second, atol=1e-7)
