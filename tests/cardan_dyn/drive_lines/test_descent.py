"""Descents to minima that are known."""

import numpy as np
import pytest

from cardan_dyn.practice.drive_lines.design.fork_search import descended


def parabolas(x: np.ndarray) -> np.ndarray:
    """Three parabolas (c, 3); their greatest is least, 0.25, at x = 0.5 between two of them."""
    return np.concatenate([x**2, (x - 1) ** 2, 0.1 * (x - 3) ** 4 / 81], axis=1)


def test_a_kink() -> None:
    unlimited = np.full(1, np.inf)
    for start in (-0.4, 0.2, 1.1):
        found, value = descended(parabolas, np.array([start]), -unlimited, unlimited)
        assert found == pytest.approx([0.5], abs=1e-9)
        assert value == pytest.approx(0.25, abs=1e-9)


def test_limits_hold() -> None:
    found, value = descended(parabolas, np.array([0.9]), np.array([0.7]), np.array([1.2]))
    assert found == pytest.approx([0.7], abs=1e-12)
    assert value == pytest.approx(0.49)
    found, _ = descended(parabolas, np.array([0.7]), np.array([0.7]), np.array([1.2]))
    assert found == pytest.approx([0.7], abs=1e-12)


def test_a_kink_of_three_in_two_dimensions() -> None:
    # Squares of distances from three points: least greatest in the centre of their circle.
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.9]])

    def squares(x: np.ndarray) -> np.ndarray:
        return np.sum((x[:, None] - points) ** 2, axis=-1)

    unlimited = np.full(2, np.inf)
    found, value = descended(squares, np.array([0.9, 0.9]), -unlimited, unlimited)
    # x = 0.5 by symmetry of the first two; y from equal distances to the first and the third.
    y = (0.2**2 + 0.9**2 - 0.2) / 1.8
    assert found == pytest.approx([0.5, y], abs=1e-6)
    assert value == pytest.approx(0.25 + y**2, rel=1e-9)


def test_nothing_is_left_to_descend() -> None:
    zero = np.zeros(1)
    found, value = descended(lambda x: x**2, zero, zero - 1, zero + 1)
    assert found == zero
    assert value == 0.0
