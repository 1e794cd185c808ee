"""Small motions of matrices whose spectra are known."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.motion.simulation.equilibrium import small_motions


def test_springs_and_masses_apart() -> None:
    found = small_motions(np.diag([8.0, 3.0]), np.diag([2.0, 3.0]), 1e-12)
    assert found.stability == "stable"
    np.testing.assert_allclose(found.frequencies, [1.0, 2.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("least", "stability", "count"),
    [(1e-9, "stable", 2), (9e-13, "indifferent", 1), (-9e-13, "indifferent", 1)],
)
def test_a_stiffness_within_its_noise_is_none(least: float, stability: str, count: int) -> None:
    found = small_motions(np.diag([least, 1e4]), np.diag([1e-3, 1.0]), 1e-12)
    assert found.stability == stability
    assert len(found.frequencies) == count
    assert small_motions(np.diag([-1e-9, 1e4]), np.eye(2), 1e-12).stability == "unstable"


@pytest.mark.parametrize(("push", "stability"), [(1.9, "stable"), (2.1, "unstable")])
def test_ziegler_s_column_flutters(push: float, stability: str) -> None:
    """Two equal masses on springs of stiffness 1: squares 1 and 1 meet at the load 2."""
    stiffness = np.array([[2.0 - push, push - 1.0], [-1.0, 1.0]])
    found = small_motions(stiffness, np.array([[2.0, 1.0], [1.0, 1.0]]), 1e-12)
    assert found.stability == stability
    # det(K - w² M) = w⁴ - (6 - 2 P) w² + 1.
    squares = np.roots([1.0, 2.0 * push - 6.0, 1.0])
    expected = np.sort(np.sqrt(squares.real)) if stability == "stable" else []
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-12)


def test_flutter_needs_no_negative_stiffness() -> None:
    found = small_motions(np.array([[1.0, 0.5], [-0.5, 1.0]]), np.eye(2), 1e-12)
    assert found.stability == "unstable"
    assert found.frequencies.size == 0


def test_what_has_no_inertia_follows() -> None:
    """Two springs in series on a mass: 2 and 6 make 1.5."""
    stiffness = np.array([[8.0, -6.0], [-6.0, 6.0]])
    found = small_motions(stiffness, np.diag([0.0, 1.5]), 1e-12)
    assert found.stability == "stable"
    np.testing.assert_allclose(found.frequencies, [1.0], rtol=1e-12)
    assert small_motions(np.diag([-1.0, 1.0]), np.diag([0.0, 1.0]), 1e-12).stability == "unstable"
    nothing = small_motions(np.eye(2), np.zeros((2, 2)), 1e-12)
    assert nothing.stability == "stable"
    assert nothing.frequencies.size == 0
