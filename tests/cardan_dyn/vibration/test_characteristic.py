"""Torque of a drive over its speed."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn import ArgumentError
from cardan_dyn.motion.vibration.motions.driven import Characteristic


def test_a_constant_torque() -> None:
    given = Characteristic(3)  # type: ignore[arg-type]
    assert given(7.0) == 3.0
    assert given.at(np.ones((2, 3))).tolist() == [[3.0] * 3] * 2
    assert not np.any(given.slope(np.ones(4)))


def test_a_function_and_its_slope() -> None:
    given = Characteristic(lambda speed: speed**2)
    speeds = np.array([[-2.0, 3.0]])
    assert given.at(speeds) == pytest.approx(speeds**2)
    assert given.slope(speeds) == pytest.approx(2.0 * speeds, rel=1e-9)


@pytest.mark.parametrize("value", ["much", None, [1.0, 2.0], np.inf])
def test_values_that_are_no_torque(value: object) -> None:
    with pytest.raises(ArgumentError, match="torque"):
        Characteristic(value)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="torque at 2 rad/s"):
        Characteristic(lambda speed: value)(2.0)  # type: ignore[arg-type, return-value]


def test_a_function_that_fails_says_where() -> None:
    with pytest.raises(ArgumentError, match="torque at 2 rad/s fails: ZeroDivisionError"):
        Characteristic(lambda speed: 1.0 / 0.0)(2.0)
