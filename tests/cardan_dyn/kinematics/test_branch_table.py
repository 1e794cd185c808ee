"""Branch table: interpolation, extrapolation and derivatives, against known functions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from testkit.planar_linkages import described, four_bar, joint, link, solver

import cardan_dyn as cd
from cardan_dyn.kinematics.following.branch import BranchTable
from cardan_dyn.kinematics.following.lines import Rows

DRIVE = 1


@pytest.fixture(scope="module")
def coordinates() -> cd.mechanism.coordinates.Coordinates:
    joints = joint("A", "ground", "a"), joint("B", "a", "b"), joint("D", "b", "c")
    return described(*(link(name) for name in "abc"), *joints).coordinates


def polynomials(degree: int) -> list[Polynomial]:
    """One per coordinate; that of the drive is its position itself."""
    coefficients = np.random.default_rng(5).uniform(-1.0, 1.0, (3, degree + 1))
    curves = [Polynomial(row) for row in coefficients]
    curves[DRIVE] = Polynomial([0.0, 1.0])
    return curves


def evaluated(curves: list[Polynomial], positions: np.ndarray) -> np.ndarray:
    return np.stack([curve(positions) for curve in curves], axis=1)


def rows_on(curves: list[Polynomial], positions: object) -> Rows:
    at = np.asarray(positions, dtype=float)
    x, first, second = ([curve.deriv(order) for curve in curves] for order in range(3))
    return Rows(evaluated(x, at), evaluated(first, at), 0.5 * evaluated(second, at))


def table_on(curves: list[Polynomial], positions: object, coordinates: object) -> BranchTable:
    return BranchTable(rows_on(curves, positions), DRIVE, coordinates)


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4, 5])
def test_polynomials_up_to_degree_five_are_interpolated_exactly(
    coordinates: object, degree: int
) -> None:
    curves = polynomials(degree)
    table = table_on(curves, [-1.0, -0.3, 0.9, 1.0], coordinates)
    positions = np.linspace(-1.0, 1.0, 41)
    guess = table.guess(positions)
    np.testing.assert_allclose(guess, evaluated(curves, positions), rtol=0.0, atol=1e-14)
    np.testing.assert_array_equal(guess[:, DRIVE], positions)


def test_the_error_at_degree_six_falls_with_its_sixth_power(coordinates: object) -> None:
    curves = polynomials(6)

    def error(width: float) -> float:
        middle = np.array([0.5 * width])
        table = table_on(curves, [0.0, width], coordinates)
        return float(np.max(np.abs(table.guess(middle) - evaluated(curves, middle))))

    assert error(1.0) / error(0.5) == pytest.approx(64.0, rel=1e-6)


def test_a_single_node_is_repeated(coordinates: object) -> None:
    table = table_on(polynomials(3), [0.5], coordinates)
    guess = table.guess(np.array([0.1, 0.7]))
    np.testing.assert_array_equal(guess[:, DRIVE], [0.1, 0.7])
    np.testing.assert_array_equal(guess[:, [0, 2]], table.states[[0, 0]][:, [0, 2]])


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


def test_quaternions_of_guesses_have_unit_length() -> None:
    layout = cd.load("stewart_platform").coordinates
    x, first, second = np.random.default_rng(3).uniform(0.1, 0.3, (3, 2, layout.size))
    column = layout.columns["leg_1"].start
    x[:, column] = [0.0, 1.0]
    guess = BranchTable(Rows(x, first, second), column, layout).guess(np.array([0.2, 0.6]))
    for name in ("ball_2", "ball_6"):
        norms = np.linalg.norm(guess[:, layout.columns[name]], axis=1)
        np.testing.assert_allclose(norms, 1.0, rtol=1e-15)


def test_new_nodes_are_sorted_in_and_leave_the_old_table_alone(coordinates: object) -> None:
    curves = polynomials(4)
    table = table_on(curves, [0.0, 1.0], coordinates)
    longer = table.with_nodes(rows_on(curves, [2.0, -1.0, 0.5]))
    np.testing.assert_array_equal(longer.positions, [-1.0, 0.0, 0.5, 1.0, 2.0])
    for found, expected in zip(longer.rows, rows_on(curves, longer.positions), strict=True):
        np.testing.assert_array_equal(found, expected)
    assert (longer.span, longer.size) == ((-1.0, 2.0), 5)
    assert (table.span, table.size) == ((0.0, 1.0), 2)
    for item in (table, longer):
        for array in item.rows:
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0.0


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
