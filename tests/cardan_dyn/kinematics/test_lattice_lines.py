"""Lattice lines: from neighbour to neighbour, each to its end, however many at a time."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.kinematics.following import lattice as lattice_lines
from cardan_dyn.kinematics.following.lattice import count_of, lines_to


@pytest.fixture(params=[[[0, 1, 2]], [[2], [0, 1]]], ids=["at once", "in two legs"])
def legs(request: pytest.FixtureRequest) -> list[list[int]]:
    return request.param


@pytest.fixture
def nearest() -> np.ndarray:
    return np.rint(np.random.default_rng(0).uniform(-6.0, 9.0, (300, 3)))


def test_lines_lead_from_neighbour_to_neighbour(nearest: np.ndarray, legs: list[list[int]]) -> None:
    lines, line_of = lines_to(nearest, legs)
    np.testing.assert_array_equal(lines.points[lines.ends[line_of]], nearest)
    assert len(np.unique(lines.points, axis=0)) == len(lines.points)
    step = lines.points[lines.second] - lines.points[lines.first]
    assert np.max(np.abs(step)) == 1.0
    assert np.all(lines.lead_there(np.ones(len(lines.first), dtype=bool)))


def test_a_line_is_as_good_as_its_steps(nearest: np.ndarray, legs: list[list[int]]) -> None:
    lines, _ = lines_to(nearest, legs)
    # Without any step that ends there, only lines to other points are left.
    closed = int(lines.ends[7])
    there = lines.lead_there(lines.second != closed)
    assert not there[7]
    assert 0 < np.sum(~there) < len(there)


def test_pieces_do_not_matter(
    nearest: np.ndarray, legs: list[list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, line_of = lines_to(nearest, legs)
    is_good = np.random.default_rng(1).uniform(size=len(whole.first)) < 0.95
    expected = whole.lead_there(is_good)
    for most in (1, 50):
        monkeypatch.setattr(lattice_lines, "_MOST_PASSED", most)
        lines, of = lines_to(nearest, legs)
        np.testing.assert_array_equal(of, line_of)
        for name in ("points", "first", "second", "ends"):
            np.testing.assert_array_equal(getattr(lines, name), getattr(whole, name))
        np.testing.assert_array_equal(lines.lead_there(is_good), expected)


def test_points_are_counted(nearest: np.ndarray) -> None:
    assert count_of(nearest) == len(np.unique(nearest, axis=0))
    assert count_of(np.zeros((4, 2))) == 1


def test_the_start_itself_is_a_line() -> None:
    lines, line_of = lines_to(np.zeros((2, 2)), [[0, 1]])
    np.testing.assert_array_equal(line_of, [0, 0])
    assert len(lines.points) == len(lines.first) == 1
    assert np.all(lines.lead_there(np.ones(1, dtype=bool)))
