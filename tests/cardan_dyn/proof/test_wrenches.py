"""Wrenches in world axes against Pinocchio, and their greatest sizes by hand."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cardan_dyn.proof.wrenches import greatest_size, placed_in_world, taken_about


def wrench(force: list[float], moment: list[float]) -> np.ndarray:
    """Return one wrench of one sample, `(1, 2, 3, 1)`."""
    return np.array([force, moment], dtype=float)[None, :, :, None]


def test_wrenches_are_placed_as_by_pinocchio() -> None:
    pinocchio.seed(1)
    rng = np.random.default_rng(1)
    joints, samples = 3, 4
    forces = rng.normal(size=(joints, 2, 3, samples))
    frames = np.empty((joints, 4, 3, samples))
    expected = np.empty_like(forces)
    for joint, sample in np.ndindex(joints, samples):
        placement = pinocchio.SE3.Random()
        frames[joint, :3, :, sample] = placement.rotation.T
        frames[joint, 3, :, sample] = placement.translation
        force = placement.act(pinocchio.Force(forces[joint, :, :, sample].ravel()))
        expected[joint, :, :, sample] = force.linear, force.angular
    given_frames = forces.copy()
    placed = placed_in_world(forces, frames)
    np.testing.assert_allclose(placed.in_world, expected, atol=1e-13)
    np.testing.assert_array_equal(placed.in_joint_frames, given_frames)


@pytest.mark.parametrize(
    ("force", "moment", "expected"),
    [([3.0, 4.0, 0.0], [0.0, 0.0, 9.0], 10.0), ([3.0, 4.0, 0.0], [0.0, 0.0, -11.0], 11.0)],
)
def test_size_is_that_of_the_moment_or_of_the_force_times_the_length(
    force: list[float], moment: list[float], expected: float
) -> None:
    assert greatest_size(wrench(force, moment), 2.0) == pytest.approx([expected], rel=1e-15)


def test_size_with_moments_about_another_point() -> None:
    """A force of 1 along y at x = 5 has no moment there, and 5 about the origin."""
    at_five = wrench([0.0, 1.0, 0.0], [0.0, 0.0, 5.0])
    assert greatest_size(at_five, 2.0) == pytest.approx([5.0])
    point = np.array([5.0, 0.0, 0.0])[None, :, None]
    assert greatest_size(taken_about(point, at_five), 2.0) == pytest.approx([2.0])


def test_size_is_the_greatest_of_each_sample() -> None:
    wrenches = np.zeros((2, 2, 3, 3))
    wrenches[0, 1, 0] = [1.0, 5.0, 0.0]
    wrenches[1, 0, 1] = [2.0, 1.0, 0.0]
    np.testing.assert_allclose(greatest_size(wrenches, 3.0), [6.0, 5.0, 0.0])


def test_size_of_no_wrenches_is_zero() -> None:
    np.testing.assert_array_equal(greatest_size(np.zeros((0, 2, 3, 4)), 1.0), np.zeros(4))
    np.testing.assert_array_equal(greatest_size(np.zeros((2, 2, 3, 4)), 1.0), np.zeros(4))


@given(
    exponent=st.integers(-900, 900),
    length=st.floats(0.125, 8.0),
    seed=st.integers(0, 1000),
)
@example(exponent=509, length=3.0, seed=0)
def test_size_scales_with_the_wrenches_even_where_squares_overflow_or_vanish(
    exponent: int, length: float, seed: int
) -> None:
    wrenches = np.random.default_rng(seed).normal(size=(3, 2, 3, 2))
    expected = np.ldexp(greatest_size(wrenches, length), exponent)
    with np.errstate(over="ignore"):
        found = greatest_size(np.ldexp(wrenches, exponent), length)
    np.testing.assert_allclose(found, expected, rtol=1e-14)


@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_size_of_what_is_not_finite_is_not_finite(value: float) -> None:
    wrenches = np.ones((2, 2, 3, 1))
    wrenches[1, 0, 2] = value
    assert not np.isfinite(greatest_size(wrenches, 1.0)[0])
