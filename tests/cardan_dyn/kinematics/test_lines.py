"""Straight lines from the start: one meaning of a position, whatever the other samples are."""

from __future__ import annotations

import numpy as np
from testkit.planar_linkages import ARM, five_bar, meeting_points, solver, tips, values

from cardan_dyn.core.kinematics.following.lines import along_lines


def test_positions_in_any_order_and_number() -> None:
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    columns = [mechanism.coordinates.columns[name].start for name in "AD"]
    positions = np.random.default_rng(3).uniform(-0.6, 0.6, (900, 2))
    positions[:2] = [[0.0, 0.0], [9.0 * np.pi, 9.0 * np.pi]]
    x, is_there = along_lines(kinematics, start[None], columns, positions)
    assert np.all(is_there)
    b = values(mechanism, x, "B")
    np.testing.assert_array_equal(x[:, columns], positions)
    np.testing.assert_allclose(meeting_points(mechanism, x), tips(positions), atol=1e-12)
    np.testing.assert_allclose(b[1], -9.0 * np.pi, atol=1.2)
    for index in (0, 1, 500):
        alone, _ = along_lines(kinematics, start[None], columns, positions[[index]])
        np.testing.assert_allclose(alone[0], x[index], atol=1e-13)


def test_lines_end_where_the_loops_open() -> None:
    """The pins move apart until the arms are in line; others are reached all the same."""
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    columns = [mechanism.coordinates.columns[name].start for name in "AD"]
    positions = np.array([[0.1, -0.1], [1.5, -1.5], [0.0, 0.0], [np.inf, 0.0]])
    x, is_there = along_lines(kinematics, start[None], columns, positions)
    np.testing.assert_array_equal(is_there, [True, False, True, False])
    end = np.arcsin((2.0 * ARM - 1.0) / 0.8)
    np.testing.assert_allclose(x[1, columns], [end, -end], atol=1e-6)


def test_no_positions() -> None:
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    x, is_there = along_lines(kinematics, start[None], [0, 1], np.zeros((0, 2)))
    assert x.shape == (0, start.size) and is_there.shape == (0,)
