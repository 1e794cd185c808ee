"""Operations on arrays: against Pinocchio's quaternions, and written out component by component."""

from __future__ import annotations

import itertools

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan_dyn.kit.arrays import (
    cardan_angles,
    cardan_quaternion,
    consecutive,
    cross,
    distinct,
    generic,
    inverse,
    neighbours,
    quaternion_product,
)

INTEGERS = st.integers(-1000, 1000)


def levi_civita() -> np.ndarray:
    """Return the tensor whose contraction with two vectors is their cross product."""
    tensor = np.zeros((3, 3, 3))
    for order in itertools.permutations(range(3)):
        tensor[order] = np.linalg.det(np.eye(3)[list(order)])
    return tensor


@given(st.lists(INTEGERS, min_size=6, max_size=6))
def test_cross_products_of_integers_are_exact(components: list[int]) -> None:
    a, b = np.reshape(components, (2, 3)).astype(float)
    expected = np.einsum("ijk,j,k->i", levi_civita(), a, b)
    np.testing.assert_array_equal(cross(a, b), expected)


@pytest.mark.parametrize("shape", [(3, 4), (3, 2, 5), (3, 0)])
def test_cross_products_are_taken_along_the_first_axis(shape: tuple[int, ...]) -> None:
    a, b = generic(2, int(np.prod(shape))).reshape(2, *shape)
    expected = np.einsum("ijk,j...,k...->i...", levi_civita(), a, b)
    found = cross(a, b)
    assert found.shape == shape
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_quaternion_products_turn_by_the_second_factor_first() -> None:
    """Against products of rotation matrices, and Pinocchio's products."""
    a, b = generic(2, 20).reshape(2, 5, 4)
    a, b = (item / np.linalg.norm(item, axis=1, keepdims=True) for item in (a, b))
    products = quaternion_product(a, b)
    for first, second, product in zip(b, a, products, strict=True):
        turns = [pin.Quaternion(item).matrix() for item in (second, first, product)]
        np.testing.assert_allclose(turns[0] @ turns[1], turns[2], atol=1e-15)
        expected = (pin.Quaternion(second) * pin.Quaternion(first)).coeffs()
        np.testing.assert_allclose(product, expected, atol=1e-15)


def test_quaternion_products_of_the_imaginary_units() -> None:
    """Hamilton's rules: i j = k, j k = i, k i = j, and i i = -1."""
    i, j, k, one = np.eye(4)[:, None, :]
    for first, second, expected in ((i, j, k), (j, k, i), (k, i, j), (i, i, -one), (one, j, j)):
        np.testing.assert_array_equal(quaternion_product(first, second), expected)
    np.testing.assert_array_equal(quaternion_product(j, i), -k)


@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-9, 1e-4, 1.0])
def test_cardan_angles_give_the_rotation_at_and_beside_right_angles_of_the_middle_turn(
    off: float,
) -> None:
    expected = []
    for first, last, side in 3.0 * generic(40, 3):
        about = zip((first, np.copysign(np.pi / 2 - off, side), last), np.eye(3), strict=True)
        x, y, z = (pin.exp3(angle * axis) for angle, axis in about)
        expected.append(x @ y @ z)
    angles = cardan_angles(np.transpose([pin.Quaternion(turn).coeffs() for turn in expected])).T
    assert np.all(np.abs(angles) <= [np.pi, np.pi / 2, np.pi])
    found = [pin.Quaternion(cardan_quaternion(own)).matrix() for own in angles]
    np.testing.assert_allclose(found, expected, atol=1e-14)


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (3, 40), (40, 3), (12, 12), (0, 3)])
def test_generic_numbers_have_full_rank_and_are_always_the_same(rows: int, columns: int) -> None:
    numbers = generic(rows, columns)
    assert numbers.shape == (rows, columns)
    assert np.all(np.abs(numbers) < 1.0)
    if rows:
        assert np.linalg.matrix_rank(numbers) == min(rows, columns)
    np.testing.assert_array_equal(numbers, generic(rows, columns))


def test_generic_numbers_do_not_repeat() -> None:
    """The least distance of 1000 numbers drawn at random between -1 and 1 is about 2e-6."""
    ordered = np.sort(generic(1, 1000)[0])
    assert np.min(np.diff(ordered)) > 1e-8


def test_inverse_placements() -> None:
    placement = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.4, 0.5), np.array([1.0, 2.0, 3.0]))
    expected = placement.inverse().homogeneous
    np.testing.assert_allclose(inverse(placement.homogeneous), expected, atol=1e-15)


@pytest.mark.parametrize(
    ("indices", "expected"),
    [
        ([2, 3, 4], slice(2, 5)),
        ([7], slice(7, 8)),
        ([2, 4], [2, 4]),
        ([1, 3, 2, 4], [1, 3, 2, 4]),
        ([], []),
    ],
)
def test_consecutive_indices_become_a_slice(indices: list[int], expected: object) -> None:
    result = consecutive(np.array(indices, dtype=int))
    if isinstance(expected, slice):
        assert result == expected
    else:
        assert isinstance(result, np.ndarray)
        assert result.tolist() == expected


@pytest.mark.parametrize("shape", [(200, 1), (200, 2), (200, 3), (7, 0), (1, 2)])
def test_distinct_rows_are_those_of_numpy(shape: tuple[int, int]) -> None:
    rows = np.rint(2.0 * generic(*shape))
    chosen, of = distinct(rows)
    _, expected, expected_of = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    np.testing.assert_array_equal(chosen, expected)
    np.testing.assert_array_equal(of, expected_of)


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_neighbours_in_a_row_are_near_each_other(axes: int) -> None:
    """Points of a row lie in a box whose volume is about the share of it in all."""
    points = generic(4096, axes)
    order = neighbours(points, 32)
    np.testing.assert_array_equal(np.sort(order), np.arange(4096))
    boxes = np.ptp(points[order].reshape(-1, 32, axes), axis=1)
    assert np.median(np.prod(boxes / 2.0, axis=1)) < 2.0 * 32 / 4096


def test_points_of_a_path_stay_in_their_order_and_shuffled_ones_do_not() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 1000)
    path = np.stack([np.cos(turn), 0.01 * np.sin(turn), 7.0 + np.sin(2.0 * turn)], axis=1)
    np.testing.assert_array_equal(neighbours(path, 32), np.arange(1000))
    shuffled = path[np.argsort(generic(1000, 1)[:, 0])]
    order = neighbours(shuffled, 32)
    boxes = [np.ptp(rows[:992].reshape(31, 32, 3), axis=1) for rows in (shuffled[order], shuffled)]
    assert np.median(boxes[0][:, 0]) < 0.5 * np.median(boxes[1][:, 0])


def test_equal_points_keep_all_of_them() -> None:
    np.testing.assert_array_equal(np.sort(neighbours(np.ones((100, 2)), 8)), np.arange(100))
