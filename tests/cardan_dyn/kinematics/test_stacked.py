"""Stacked small systems on matrices made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.kinematics.closing.stacked import (
    condition_numbers,
    factorised,
    refined,
    same_side,
    times,
    transposed,
)


def random(*shape: int) -> np.ndarray:
    return np.random.default_rng(7).normal(size=shape)


def test_regular_square_matrices() -> None:
    matrices = random(5, 4, 4)
    inverse, condition = factorised(matrices, None)
    np.testing.assert_allclose(
        matrices @ inverse, np.broadcast_to(np.eye(4), (5, 4, 4)), atol=1e-12
    )
    expected = [np.linalg.cond(matrix, "fro") for matrix in matrices]
    np.testing.assert_allclose(condition, expected, rtol=1e-10)


def test_wide_matrices_get_pseudoinverses() -> None:
    matrices = random(5, 2, 4)
    inverse, condition = factorised(matrices, None)
    np.testing.assert_allclose(inverse, np.linalg.pinv(matrices), atol=1e-12)
    np.testing.assert_allclose(condition, [np.linalg.cond(matrix) for matrix in matrices])


def test_singular_matrices_among_regular_ones() -> None:
    matrices = np.array([np.diag([2.0, 1.0]), [[1.0, 1.0], [0.0, 0.0]], np.zeros((2, 2))])
    inverse, condition = factorised(matrices, None)
    np.testing.assert_allclose(inverse[0], np.diag([0.5, 1.0]), atol=1e-15)
    np.testing.assert_allclose(inverse[1], [[0.5, 0.0], [0.5, 0.0]], atol=1e-15)
    np.testing.assert_array_equal(inverse[2], 0.0)
    assert condition[0] == pytest.approx(2.0)
    assert condition[1] > 1e15 and condition[2] == np.inf


@pytest.mark.parametrize("scale", [None, np.array([[1.0], [2.0]])])
def test_what_is_not_a_number_stays_so_and_spoils_no_other(scale: np.ndarray | None) -> None:
    """Also where another matrix is singular, and of matrices that are not square."""
    square, wide = random(3, 2, 2), random(3, 2, 4)
    square[2] = 0.0
    for matrices in (square, wide):
        matrices[1, 0, 1] = np.nan
        inverse, condition = factorised(matrices, scale)
        np.testing.assert_allclose(matrices[0] @ inverse[0], np.eye(2), atol=1e-12)
        assert np.all(np.isnan(inverse[1])) and np.isnan(condition[1])
    inverse, condition = factorised(square, scale, 1)
    assert np.all(np.isnan(inverse[1])) and np.isnan(condition[1])
    assert np.all(np.isfinite(inverse[[0, 2]])) and np.isfinite(condition[0])


def test_matrices_without_rows_or_without_columns() -> None:
    inverse, condition = factorised(np.zeros((2, 0, 3)), None)
    assert inverse.shape == (2, 3, 0)
    np.testing.assert_array_equal(condition, 1.0)


@pytest.mark.parametrize("columns", [3, 4])
def test_scales_judge_the_condition_but_do_not_change_the_inverse(columns: int) -> None:
    """Slides in millimetres: rows that are a thousand times smaller, scaled back."""
    matrices, scale = random(4, 3, columns), np.array([[1.0], [1000.0], [1.0]])
    inverse, condition = factorised(matrices / scale, scale)
    np.testing.assert_allclose(condition, factorised(matrices, None)[1], rtol=1e-9)
    product = (matrices / scale) @ inverse
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), (4, 3, 3)), atol=1e-9)


def test_condition_numbers_of_diagonal_matrices() -> None:
    matrix = np.diag([1.0, 2.0, 4.0])[None]
    found = condition_numbers(matrix, np.linalg.inv(matrix), None)
    assert found == pytest.approx(np.sqrt((1 + 4 + 16) * (1 + 1 / 4 + 1 / 16)))
    scale = np.array([[4.0], [2.0], [1.0]])
    assert condition_numbers(matrix, np.linalg.inv(matrix), scale) == pytest.approx(3.0)


def test_refinement_squares_the_error_of_an_inverse() -> None:
    matrices = random(6, 5, 5) + 3.0 * np.eye(5)
    right = random(6, 5, 2)
    inverse = np.linalg.inv(matrices) @ (np.eye(5) + 1e-5 * random(6, 5, 5))
    expected = np.linalg.solve(matrices, right)
    before = np.max(np.abs(inverse @ right - expected))
    after = np.max(np.abs(refined(matrices, inverse, right) - expected))
    assert before > 1e-6
    assert after < 1e-3 * before


def test_sides_of_a_singular_configuration() -> None:
    angles = np.array([0.1, 1.0, 2.0, 3.0])
    rows = np.array([[[1.0, np.cos(angle)], [0.0, np.sin(angle)]] for angle in angles])
    mirrored = rows * [[1.0, 1.0], [1.0, -1.0]]
    assert same_side(rows, np.linalg.inv(rows[::-1])).tolist() == [True] * 4
    assert same_side(rows, np.linalg.inv(mirrored)).tolist() == [False] * 4


@pytest.mark.parametrize("p", [0, 1, 3, 6, 13, 42, 49])
def test_sides_are_those_of_determinants(p: int) -> None:
    rows, inverses = random(200, p, p), random(200, p, p + 1)[:, :, 1:]
    expected = np.linalg.det(rows @ inverses) > 0.0
    assert p == 0 or 40 < np.sum(expected) < 160
    np.testing.assert_array_equal(same_side(rows, inverses), expected)
    np.testing.assert_array_equal(same_side(rows[:1], inverses[:1]), expected[:1])
    np.testing.assert_array_equal(same_side(rows, np.repeat(inverses[:1], 200, axis=0)),
                                  same_side(rows, inverses[:1]))  # fmt: skip
    assert (
        same_side(rows[:1], inverses[:0]).shape == same_side(rows[:0], inverses[:0]).shape == (0,)
    )
    if p:
        rows[0, -1, 0], rows[1] = np.nan, 0.0
        with np.errstate(invalid="ignore"):
            assert not np.any(same_side(rows, inverses)[:2])


def test_products_and_transposes() -> None:
    matrices, vectors = random(3, 4, 2), random(3, 2)
    expected = np.array([matrix @ vector for matrix, vector in zip(matrices, vectors, strict=True)])
    np.testing.assert_allclose(times(matrices, vectors), expected, atol=1e-15)
    np.testing.assert_array_equal(transposed(matrices)[1], matrices[1].T)
