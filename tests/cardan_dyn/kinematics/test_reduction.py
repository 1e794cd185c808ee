"""Bases along the axes."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.kinematics.closing.equations import axis_aligned


def rotated(axes: list[int], seed: int = 0) -> np.ndarray:
    """Return another orthonormal basis of what some axes span."""
    matrix = np.random.default_rng(seed).normal(size=(len(axes), len(axes)))
    return np.eye(6)[:, axes] @ np.linalg.qr(matrix)[0]


@pytest.mark.parametrize("axes", [[2], [0, 1, 5], [3, 4, 5], [0, 1, 2, 3, 4, 5]])
def test_a_space_along_axes_gets_exact_axes(axes: list[int]) -> None:
    np.testing.assert_array_equal(axis_aligned(rotated(axes)), np.eye(6)[:, axes])


@pytest.mark.parametrize("angle", [1e-10, 0.5])
def test_a_tilted_space_stays_as_it_is(angle: float) -> None:
    vectors = rotated([0, 1, 5])
    tilt = np.eye(6)
    tilt[1, 1] = tilt[2, 2] = np.cos(angle)
    tilt[2, 1], tilt[1, 2] = np.sin(angle), -np.sin(angle)
    tilted = tilt @ vectors
    assert axis_aligned(tilted) is tilted


def test_nothing_stays_nothing() -> None:
    assert axis_aligned(np.zeros((6, 0))).shape == (6, 0)
