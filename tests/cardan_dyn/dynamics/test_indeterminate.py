"""Rules for indeterminate closure forces against dense least squares of every sample."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan_dyn.dynamics.indeterminate import LeastEnergy, LeastNorm, SelfStress, influence

SAMPLES, CASES, LENGTH = 3, 2, 0.3
SCALE = np.repeat([LENGTH, 1.0], 3)


def self_stress(rng: np.random.Generator, joints: Sequence[int], size: int) -> SelfStress:
    spread = rng.normal(size=(SAMPLES, len(joints), 6, size))
    return SelfStress({0: np.zeros((SAMPLES, 6, size))}, np.array(joints, dtype=int), spread)


def dense(items: Sequence[SelfStress], count: int) -> np.ndarray:
    """Return what all amounts together add to all wrenches, `(N, 6 b, k)`."""
    columns = []
    for item in items:
        full = np.zeros((SAMPLES, count, 6, item.spread.shape[3]))
        full[:, item.joints] = item.spread
        columns.append(full.reshape(SAMPLES, 6 * count, -1))
    return np.concatenate(columns, axis=2)


def least_squares(matrix: np.ndarray, wrenches: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the amounts `(N, k, c)` with the least weighted squares of wrenches plus changes."""
    right = wrenches.reshape(SAMPLES, -1, CASES)
    return np.stack(
        [
            np.linalg.lstsq(weights @ rows, -weights @ values, rcond=None)[0]
            for rows, values in zip(matrix, right, strict=True)
        ]
    )


@st.composite
def connections(draw: st.DrawFn) -> tuple[int, list[tuple[list[int], int]]]:
    """Joints, and self-stresses with the joints that they load and their sizes."""
    count = draw(st.integers(1, 6))
    loaded = st.lists(st.integers(0, count - 1), min_size=1, max_size=count, unique=True)
    items = draw(st.lists(st.tuples(loaded.map(sorted), st.integers(1, 2)), max_size=4))
    return count, items


@given(connections(), st.integers(0, 100))
@settings(max_examples=40, deadline=None)
def test_least_norm_is_the_least_squares_solution(
    layout: tuple[int, list[tuple[list[int], int]]], seed: int
) -> None:
    count, described = layout
    rng = np.random.default_rng(seed)
    items = [self_stress(rng, joints, size) for joints, size in described]
    if not items:
        return
    matrix = dense(items, count)
    if matrix.shape[2] > np.min(np.linalg.matrix_rank(matrix)):
        return  # Amounts are not determined then.
    wrenches = rng.normal(size=(SAMPLES, count, 6, CASES))
    rule = LeastNorm(LENGTH, frozenset(range(count)))
    amounts = rule.amounts(wrenches, items, {})
    expected = least_squares(matrix, wrenches, np.diag(np.tile(SCALE, count)))
    assert [amount.shape[1] for amount in amounts] == [size for _, size in described]
    np.testing.assert_allclose(np.concatenate(amounts, axis=1), expected, rtol=1e-6, atol=1e-8)


def test_eliminating_an_unknown_connects_its_neighbours() -> None:
    """The first of them loads all joints, the others a joint each: a star becomes a clique."""
    rng = np.random.default_rng(11)
    items = [self_stress(rng, range(4), 2), *(self_stress(rng, [joint], 1) for joint in range(4))]
    wrenches = rng.normal(size=(SAMPLES, 4, 6, CASES))
    amounts = LeastNorm(LENGTH, frozenset(range(4))).amounts(wrenches, items, {})
    expected = least_squares(dense(items, 4), wrenches, np.diag(np.tile(SCALE, 4)))
    np.testing.assert_allclose(np.concatenate(amounts, axis=1), expected, rtol=1e-9)


def test_joints_that_are_not_counted_do_not_matter() -> None:
    rng = np.random.default_rng(4)
    items = [self_stress(rng, [0, 1, 2], 2), self_stress(rng, [1, 2, 3], 1)]
    wrenches = rng.normal(size=(SAMPLES, 4, 6, CASES))
    rule = LeastNorm(LENGTH, frozenset({0, 1, 3}))
    weights = np.diag(np.concatenate([SCALE, SCALE, np.zeros(6), SCALE]))
    expected = least_squares(dense(items, 4), wrenches, weights)
    amounts = np.concatenate(rule.amounts(wrenches, items, {}), axis=1)
    np.testing.assert_allclose(amounts, expected, rtol=1e-9)
    wrenches[:, 2] = 1e3
    again = np.concatenate(rule.amounts(wrenches, items, {}), axis=1)
    np.testing.assert_array_equal(again, amounts)


def test_self_stresses_that_load_no_joint_have_the_amount_zero() -> None:
    """As of redundant couplings, whose moments are in balance with each other."""
    item = SelfStress(
        {1: np.ones((SAMPLES, 1, 2))}, np.zeros(0, dtype=int), np.zeros((SAMPLES, 0, 6, 2))
    )
    wrenches = np.ones((SAMPLES, 2, 6, CASES))
    (amount,) = LeastNorm(LENGTH, frozenset({0, 1})).amounts(wrenches, [item], {})
    np.testing.assert_array_equal(amount, np.zeros((SAMPLES, 2, CASES)))


def compliances(rng: np.random.Generator, *joints: int) -> dict[int, np.ndarray]:
    roots = {joint: 1e-4 * rng.normal(size=(6, 6)) for joint in joints}
    return {joint: root @ root.T for joint, root in roots.items()}


def weights_of(flexible: dict[int, np.ndarray], count: int) -> np.ndarray:
    """Return the block-diagonal root of all joints' compliances."""
    result = np.zeros((6 * count, 6 * count))
    for joint, compliance in flexible.items():
        span = slice(6 * joint, 6 * joint + 6)
        result[span, span] = np.linalg.cholesky(compliance).T
    return result


def test_least_energy_is_the_least_squares_solution_of_the_compliances() -> None:
    rng = np.random.default_rng(5)
    items = [self_stress(rng, [0, 1, 2], 2), self_stress(rng, [1, 3], 2)]
    wrenches = rng.normal(size=(SAMPLES, 4, 6, CASES))
    flexible = compliances(rng, 0, 1, 3)
    rule = LeastEnergy(LENGTH, frozenset(range(4)), flexible)
    assert rule.oriented == {0, 1, 3}
    amounts = np.concatenate(rule.amounts(wrenches, items, {}), axis=1)
    expected = least_squares(dense(items, 4), wrenches, weights_of(flexible, 4))
    np.testing.assert_allclose(amounts, expected, rtol=1e-6)


def test_compliances_stay_with_the_parents_axes() -> None:
    """In the joint's axes, turned by R, the compliance C is Rᵀ C R for force and moment alike."""
    rng = np.random.default_rng(6)
    items = [self_stress(rng, [0, 1], 2)]
    wrenches = rng.normal(size=(SAMPLES, 2, 6, CASES))
    flexible = compliances(rng, 0, 1)
    angles = np.array([0.3, 1.0, -2.0])
    rotations = np.zeros((SAMPLES, 3, 3))
    rotations[:, 2, 2] = 1.0
    rotations[:, 0, 0] = rotations[:, 1, 1] = np.cos(angles)
    rotations[:, 0, 1], rotations[:, 1, 0] = -np.sin(angles), np.sin(angles)
    rule = LeastEnergy(LENGTH, frozenset({0, 1}), flexible)
    (amounts,) = rule.amounts(wrenches, items, {1: rotations})
    for sample, rotation in enumerate(rotations):
        both = np.kron(np.eye(2), rotation)
        turned = {0: flexible[0], 1: both.T @ flexible[1] @ both}
        rows = weights_of(turned, 2) @ dense(items, 2)[sample]
        right = weights_of(turned, 2) @ wrenches[sample].reshape(-1, CASES)
        expected = np.linalg.lstsq(rows, -right, rcond=None)[0]
        np.testing.assert_allclose(amounts[sample], expected, rtol=1e-6)


@pytest.mark.parametrize("counted", [[0, 1], [1]])
def test_what_compliances_leave_open_is_of_least_norm(counted: list[int]) -> None:
    """One joint of rank two: two of four amounts follow from energy, two from the norm."""
    rng = np.random.default_rng(7)
    items = [self_stress(rng, [0, 1], 4)]
    wrenches = rng.normal(size=(SAMPLES, 2, 6, CASES))
    root = 1e-4 * rng.normal(size=(6, 2))
    rule = LeastEnergy(LENGTH, frozenset(counted), {0: root @ root.T})
    (amounts,) = rule.amounts(wrenches, items, {})
    matrix, scale = dense(items, 2), np.zeros((2, 6))
    scale[counted] = SCALE
    for sample in range(SAMPLES):
        energy_rows = root.T @ matrix[sample][:6]
        particular = np.linalg.lstsq(energy_rows, -root.T @ wrenches[sample, 0], rcond=None)[0]
        free = np.linalg.svd(energy_rows)[2][2:].T
        norm_rows = scale.reshape(-1, 1) * matrix[sample]
        norm_right = scale.reshape(-1, 1) * wrenches[sample].reshape(-1, CASES)
        rest = np.linalg.lstsq(norm_rows @ free, -norm_right - norm_rows @ particular, rcond=None)
        expected = particular + free @ rest[0]
        np.testing.assert_allclose(amounts[sample], expected, rtol=1e-6)


def test_rigid_joints_alone_are_decided_by_the_norm() -> None:
    rng = np.random.default_rng(8)
    items = [self_stress(rng, [0, 1], 2), self_stress(rng, [1, 2], 1)]
    wrenches = rng.normal(size=(SAMPLES, 3, 6, CASES))
    counted = frozenset(range(3))
    elastic = LeastEnergy(LENGTH, counted, {1: np.zeros((6, 6))})
    expected = LeastNorm(LENGTH, counted).amounts(wrenches, items, {})
    for amount, reference in zip(elastic.amounts(wrenches, items, {}), expected, strict=True):
        np.testing.assert_allclose(amount, reference, rtol=1e-8)


def test_compliances_that_only_rounding_feels_decide_nothing() -> None:
    """A self-stress that loads a flexible joint by 1e-12 of what it loads others."""
    rng = np.random.default_rng(9)
    item = self_stress(rng, [0, 1], 1)
    item.spread[:, 0, :3] *= 1e-12
    item.spread[:, 0, 3:] = 0.0
    flexible = np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    flexible_everywhere = {0: flexible, 1: np.diag([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])}
    item.spread[:, 1, 5] = 0.0
    wrenches = rng.normal(size=(SAMPLES, 2, 6, CASES))
    rule = LeastEnergy(LENGTH, frozenset({0, 1}), flexible_everywhere)
    (amount,) = rule.amounts(wrenches, [item], {})
    (expected,) = LeastNorm(LENGTH, frozenset({0, 1})).amounts(wrenches, [item], {})
    np.testing.assert_allclose(amount, expected, rtol=1e-8)


def test_wrenches_and_sizes_of_self_stresses() -> None:
    item = self_stress(np.random.default_rng(10), [4, 1], 2)
    amount = np.random.default_rng(1).normal(size=(SAMPLES, 2, CASES))
    expected = np.einsum("njis,nsc->njic", item.spread, amount)
    np.testing.assert_allclose(item.wrenches(amount), expected, rtol=1e-12)
    np.testing.assert_array_equal(item.rows([1]), item.spread[:, 1])
    np.testing.assert_array_equal(item.size(), np.abs(item.spread).max(axis=(0, 3)))


def test_influence_is_the_greatest_change_with_forces_times_the_length() -> None:
    zero = np.zeros((1, 2, 6, 1))
    first = SelfStress({}, np.array([0, 2]), zero.copy())
    second = SelfStress({}, np.array([2, 3]), zero.copy())
    first.spread[0, 0, 0], first.spread[0, 1, 4] = -2.0, 3.0
    second.spread[0, 0, 4], second.spread[0, 1, 2] = -5.0, 1.0
    expected = np.zeros((5, 6))
    expected[0, 0], expected[2, 4], expected[3, 2] = 2.0 * LENGTH, 5.0, LENGTH
    np.testing.assert_allclose(influence([first, second], 5, LENGTH), expected)
    np.testing.assert_array_equal(influence([], 2, LENGTH), np.zeros((2, 6)))


@pytest.mark.parametrize("unit", [1e-10, 1e10])
def test_the_unit_of_length_does_not_matter(unit: float) -> None:
    """In units so small, forces and reciprocals of lengths change, and moments do not."""
    rng = np.random.default_rng(13)
    item = self_stress(rng, [0, 1, 2], 3)
    wrenches = rng.normal(size=(SAMPLES, 3, 6, CASES))
    flexible = compliances(rng, 0, 2)
    rule = LeastEnergy(LENGTH, frozenset(range(3)), flexible)
    (expected,) = rule.amounts(wrenches, [item], {})
    factors = np.repeat([1.0 / unit, 1.0], 3)
    scaled = item._replace(spread=item.spread * factors[:, None])
    soft = {joint: value / factors[:, None] / factors for joint, value in flexible.items()}
    rule = LeastEnergy(LENGTH * unit, frozenset(range(3)), soft)
    (amounts,) = rule.amounts(wrenches * factors[:, None], [scaled], {})
    np.testing.assert_allclose(amounts, expected, rtol=1e-6)


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_the_scale_of_compliances_does_not_matter(factor: float) -> None:
    rng = np.random.default_rng(12)
    items = [self_stress(rng, [0, 1, 2], 3)]
    wrenches = rng.normal(size=(SAMPLES, 3, 6, CASES))
    flexible = compliances(rng, 0, 2)
    scaled = {joint: factor * value for joint, value in flexible.items()}
    (expected,) = LeastEnergy(LENGTH, frozenset(range(3)), flexible).amounts(wrenches, items, {})
    (amounts,) = LeastEnergy(LENGTH, frozenset(range(3)), scaled).amounts(wrenches, items, {})
    np.testing.assert_allclose(amounts, expected, rtol=1e-6)
