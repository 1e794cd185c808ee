"""Loads that jump, at the very times at which they do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import cardan_dyn as cd


def beyond(joint: str, place: float) -> Callable[..., float]:
    def load(time: float, position: dict[str, float], speed: dict[str, float]) -> float:
        return -40.0 if position[joint] > place else 0.0

    return load


def motor(time: float, position: dict[str, float], speed: dict[str, float]) -> float:
    return 3.0 if time < 0.25 else 3.5


@pytest.mark.parametrize("method", ["response", "DOP853"])
@pytest.mark.parametrize("rtol", [1e-10, 1e-6])
@pytest.mark.parametrize(
    ("name", "crank", "moved", "place"),
    [
        ("slider_crank", "crank_bearing", "piston_guide", -0.045),
        ("four_bar", "crank_bearing", "rocker_pin", 0.4),
    ],
)
def test_accelerations_and_wrenches_belong_to_one_side_of_a_jump(
    name: str, crank: str, moved: str, place: float, rtol: float, method: str
) -> None:
    """Held to inverse dynamics with the constant load of that side, for which nothing drives."""
    mechanism = cd.load(name)
    passed = cd.Event(lambda time, position, speed: position[moved] - place)
    run = cd.Scene(mechanism, free=crank).simulate(
        1.0,
        speed=30.0,
        loads={moved: beyond(moved, place), crank: motor},
        events=passed,
        rtol=rtol,
        method=method,
    )
    times = [0.25, *(event.time for event in run.events)]
    assert len(times) > 6
    driven = cd.Scene(mechanism, drive=crank)
    for time in times:
        there = run.at(time)
        pressing = float(there.loads[moved][0])
        assert pressing in (-40.0, 0.0)
        turning = 3.0 if time < 0.25 else 3.5
        loads = {moved: pressing, crank: turning}
        motion = there.position, there.speed, there.acceleration
        assert abs(driven.sweep(*motion, loads=loads).drive_effort[0]) < 1e-8
        np.testing.assert_allclose(there.loads[crank], turning)
