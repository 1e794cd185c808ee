"""Searches for forks against functions whose minima are known."""

import numpy as np
import pytest

from cardan_dyn.practice.drive_lines.design.fork_search import minima


def valleys(offsets: np.ndarray) -> np.ndarray:
    """Squares with the least greatest value 1 at 0.3, -0.5, and a worse minimum 90° away."""
    apart = offsets - np.array([0.3, -0.5])
    smooth = 1.0 + np.sin(apart) ** 2 + 0.2 * np.sin(2 * apart) ** 2
    kinked = 1.0 + np.abs(np.sin(apart[:, :1])) * 0.3
    return np.concatenate([smooth, kinked], axis=1)


def test_free_offsets_reach_the_bottom() -> None:
    found = minima(valleys, valleys, [None, None], 4, np.zeros(2))
    assert valleys(found.offsets)[0].max() == pytest.approx(1.0, abs=1e-9)
    assert found.offsets[0] == pytest.approx([0.3, -0.5], abs=1e-4)
    assert not found.complete


def test_minima_at_kinks() -> None:
    # The greatest of both is least where they are equal: cos²(x - 0.2) = sin²(x + 0.4) / 2.
    def squares(offsets: np.ndarray) -> np.ndarray:
        return np.concatenate([np.cos(offsets - 0.2) ** 2, np.sin(offsets + 0.4) ** 2 / 2], axis=1)

    found = minima(squares, squares, [None], 4, np.zeros(1))
    fine = np.linspace(-np.pi / 2, np.pi / 2, 2_000_001)[:, None]
    least = squares(found.offsets)[0].max()
    assert least == pytest.approx(squares(fine).max(axis=1).min(), abs=1e-6)


def test_steps_are_all_tried() -> None:
    steps = [np.arange(10) * np.pi / 10, np.arange(12) * np.pi / 12]
    found = minima(valleys, valleys, steps, 3, np.zeros(2))
    every = np.array([[x, y] for x in steps[0] for y in steps[1]])
    assert found.complete
    assert found.method == "all 120 choices"
    best = np.sort(valleys(every).max(axis=1))[:3]
    assert valleys(found.offsets).max(axis=1) == pytest.approx(best)


@pytest.mark.slow
def test_too_many_steps_are_searched() -> None:
    steps = [np.arange(400) * np.pi / 400, np.arange(400) * np.pi / 400]
    found = minima(valleys, valleys, steps, 3, np.zeros(2))
    every = np.stack([mesh.ravel() for mesh in np.meshgrid(*steps)], axis=1)
    assert not found.complete
    least = valleys(found.offsets)[0].max()
    assert least == pytest.approx(valleys(every).max(axis=1).min(), rel=1e-12)


def test_steps_and_free_offsets_together() -> None:
    found = minima(valleys, valleys, [np.array([1.0, 0.5]), None], 3, np.zeros(2))
    assert found.offsets[0, 0] == 0.5
    expected = valleys(np.array([[0.5, -0.5]])).max()
    assert valleys(found.offsets)[0].max() == pytest.approx(expected, rel=1e-9)
