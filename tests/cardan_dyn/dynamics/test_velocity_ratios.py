"""Velocity ratios without those that are zero."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from cardan_dyn.core.dynamics.velocity_ratios import VelocityRatios

COUNT, COORDINATES, DRIVES = 4, 5, 3
DEPENDS = np.array(
    [[True, False, False], [True, True, False], [False, False, True], [False] * 3, [True] * 3]
)


def dense() -> np.ndarray:
    values = np.random.default_rng(0).normal(size=(COUNT, COORDINATES, DRIVES))
    return values * DEPENDS


@pytest.mark.parametrize("depends", [None, DEPENDS])
def test_ratios_are_those_of_the_array(depends: np.ndarray | None) -> None:
    ratios = VelocityRatios.of(dense(), depends)
    assert ratios.values.shape == (COUNT, 15 if depends is None else np.sum(DEPENDS))
    assert ratios.drives == DRIVES
    for drive in range(DRIVES):
        for columns in (slice(0, 1), slice(1, 4), slice(0, COORDINATES)):
            actual = ratios.of_coordinates(columns, drive)
            np.testing.assert_array_equal(actual, dense()[:, columns, drive])


@pytest.mark.parametrize("depends", [None, DEPENDS])
def test_ratios_of_unsolved_coordinates_are_not_numbers(depends: np.ndarray | None) -> None:
    ratios = VelocityRatios.of(dense(), depends).without([1, 3])
    expected = dense()
    expected[:, [1, 3]] = np.nan
    for drive in range(DRIVES):
        actual = ratios.of_coordinates(slice(0, COORDINATES), drive)
        np.testing.assert_array_equal(actual, expected[:, :, drive])


def test_blocks_are_joined_in_order() -> None:
    blocks = [VelocityRatios.of(dense()[part], DEPENDS) for part in (slice(0, 1), slice(1, 4))]
    joined = VelocityRatios.joined(blocks)
    np.testing.assert_array_equal(joined.values, VelocityRatios.of(dense(), DEPENDS).values)


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))]
)
def test_copies_are_equal_and_closed_to_writing(copied: object) -> None:
    ratios = VelocityRatios.of(dense(), DEPENDS)
    again = copied(ratios)  # type: ignore[operator]
    for first, second in zip(ratios, again, strict=True):
        np.testing.assert_array_equal(first, second)
        assert not second.flags.writeable
