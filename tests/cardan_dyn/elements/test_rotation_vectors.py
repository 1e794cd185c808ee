"""Rotation vectors against Pinocchio's logarithm and its derivative."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from cardan_dyn.core.elements.rotation_vectors import (
    greatest_angle,
    left_jacobian_inverse_transposed,
    rotation_vector,
)

AXES = np.array([[0.48, -0.6, 0.64], [1.0, 0.0, 0.0], [0.0, -0.6, -0.8]])


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 0.3, 0.4999, 0.5001, 1.5, 3.1])
def test_vectors_and_their_rates(angle: float) -> None:
    rotations = np.array([pinocchio.exp3(angle * axis) for axis in AXES])
    turn = rotation_vector(rotations)
    np.testing.assert_allclose(turn, angle * AXES, rtol=2e-14, atol=1e-15)
    assert greatest_angle(turn) == pytest.approx(angle, abs=1e-13)
    vectors = np.array([[1.0, 2.0, -3.0], [0.5, 0.0, 1.0], [-1.0, 4.0, 2.0]])
    found = left_jacobian_inverse_transposed(turn, vectors)
    for row, rotation, vector in zip(found, rotations, vectors, strict=True):
        # Pinocchio's derivative is with respect to turns about the turned axes.
        inverse_left = pinocchio.Jlog3(rotation) @ rotation.T
        np.testing.assert_allclose(row, inverse_left.T @ vector, rtol=1e-11, atol=1e-11)
