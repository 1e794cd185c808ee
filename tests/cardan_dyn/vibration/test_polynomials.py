"""Interpolation by polynomials of several coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.motion.vibration.model.polynomials import Polynomials, polynomials, size_of


@pytest.mark.parametrize("degrees", [(6,), (5, 5), (8, 2), (4, 3, 2)])
def test_monomials_within_the_degrees_are_exact(degrees: tuple[int, ...]) -> None:
    basis = Polynomials(degrees)
    random = np.random.default_rng(2)
    points = random.uniform(-1.0, 1.0, (40, len(degrees)))
    for powers in basis.powers:
        values, exact = (np.prod(x**powers, axis=1) for x in (basis.nodes, points))
        found = basis.values(points).T @ basis.coefficients(values[:, None])[:, 0]
        np.testing.assert_allclose(found, exact, atol=2e-13)


def test_gradients_against_complex_steps() -> None:
    basis = Polynomials((7, 4))
    points = np.array([[0.3, -0.8], [-0.9, 0.1], [1.0, 1.0]])
    values, gradients = basis.with_gradients(points)
    np.testing.assert_array_equal(values, basis.values(points))
    for column in range(2):
        stepped = points.astype(complex)
        stepped[:, column] += 1e-100j
        expected = basis.values(stepped).imag / 1e-100
        np.testing.assert_allclose(gradients[column], expected, rtol=1e-13, atol=1e-13)


def test_a_smooth_function_converges_geometrically() -> None:
    def function(x: np.ndarray) -> np.ndarray:
        return 1.0 / (3.0 + x[:, 0] + 0.5 * x[:, 1])

    points = np.random.default_rng(3).uniform(-1.0, 1.0, (50, 2))
    errors = []
    for degree in (4, 8, 16):
        basis = polynomials((degree, degree))
        coefficients = basis.coefficients(function(basis.nodes)[:, None])[:, 0]
        errors.append(np.max(np.abs(basis.values(points).T @ coefficients - function(points))))
    assert errors[1] < 0.05 * errors[0]
    assert errors[2] < 0.01 * errors[1]


def test_sizes() -> None:
    assert size_of((5,)) == 6
    assert size_of((3, 3)) == 10
    assert size_of((4, 2)) == len(
        {(i, j) for i in range(5) for j in range(3) if i / 4 + j / 2 <= 1}
    )
    assert polynomials((5,)) is polynomials((5,))


@pytest.mark.parametrize("degrees", [(12, 12), (9, 10, 9), (5, 5, 5, 4)])
def test_rounding_of_samples_is_hardly_magnified(degrees: tuple[int, ...]) -> None:
    """The greatest sum of sizes of Lagrange's polynomials."""
    basis = polynomials(degrees)
    points = np.cos(np.random.default_rng(4).uniform(0.0, np.pi, (2000, len(degrees))))
    lagrange = basis.values(points).T @ basis.coefficients(np.eye(len(basis.nodes)))
    assert np.max(np.sum(np.abs(lagrange), axis=1)) < 130.0
