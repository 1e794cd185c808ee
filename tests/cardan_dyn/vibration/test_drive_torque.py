"""Torque of a drive over its speed."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn import ArgumentError
from cardan_dyn.motion.vibration.motions.driven import drive_torque, torque_at, torque_slope


def test_a_constant_torque() -> None:
    given = drive_torque(3)
    assert torque_at(given, np.ones((2, 3))).tolist() == [[3.0] * 3] * 2
    assert not np.any(torque_slope(given, np.ones(4)))


def test_a_function_and_its_slope() -> None:
    speeds = np.array([[-2.0, 3.0]])
    for given in (lambda speed: speed**2, lambda speed: float(speed) ** 2):
        law = drive_torque(given)
        assert torque_at(law, speeds) == pytest.approx(speeds**2)
        assert torque_slope(law, speeds) == pytest.approx(2.0 * speeds, rel=1e-9)


def test_a_table_is_its_straight_lines() -> None:
    given = drive_torque([[0.0, 3.0], [2.0, 1.0], [4.0, 0.0]])
    speeds = np.array([[0.5, 3.0]])
    assert torque_at(given, speeds) == pytest.approx(np.array([[2.5, 0.5]]))
    assert torque_slope(given, speeds) == pytest.approx(np.array([[-1.0, -0.5]]), rel=1e-9)
    with pytest.raises(ArgumentError, match="torque at 5 rad/s: its table of speed goes from 0 to"):
        torque_at(given, np.array([1.0, 5.0]))


@pytest.mark.parametrize("value", ["much", None, [1.0, 2.0], np.inf])
def test_values_that_are_no_torque(value: object) -> None:
    with pytest.raises(ArgumentError, match="torque"):
        drive_torque(value)
    with pytest.raises(ArgumentError, match="torque at 2 rad/s"):
        torque_at(drive_torque(lambda speed: value), np.array([2.0]))


def test_a_function_that_fails_says_where() -> None:
    with pytest.raises(ArgumentError, match="torque at 2 rad/s fails: ZeroDivisionError"):
        torque_at(drive_torque(lambda speed: 1.0 / 0.0), np.array([2.0]))
