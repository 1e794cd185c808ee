"""Simulations of scenes of every kind: all methods agree, and inverse dynamics confirms them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from testkit.ball_rods import as_balls, as_hinges
from testkit.linkages import coupling, four_bar, gears, loop, rack
from testkit.many_drives import cranks, stacked
from testkit.mimicking import efforts, finger, mimic
from testkit.simulated import GRAVITY, integrated

import cardan_dyn as cd

TIMES = np.linspace(0.0, 1.0, 11)
KNOTS = np.linspace(0.0, 1.0, 41)


def tilt(time: float) -> tuple[float, float, float]:
    return 0.4 + 0.1 * math.sin(time), 0.1 * math.cos(time), -0.1 * math.sin(time)


def confirmed(found: cd.Trajectory, energy: float) -> None:
    some = found.evenly(9)
    # Rounding times condition numbers of at most some hundreds.
    assert some.effort_residual < 1e-12
    assert some.loop_residual < 1e-13
    assert found.energy_residual < energy


def where_all_kinds_of_forces_act(method: str, rtol: float) -> cd.Trajectory:
    """A falling four-bar with a spring, friction, a distant spring, an actuator and loads."""
    elements = [
        cd.JointSpring("d", 5.0, damping=0.5, rest=0.1),
        cd.JointFriction("b", 0.5, transition=0.1),
        cd.PointSpring("ground", (0, 1, 0), "coupler", (1, 1, 0), 20.0, 1.0, 0.5),
        cd.Actuator("a", lambda t: math.sin(3.0 * t)),
    ]
    bars = cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(bars, free="a", gravity=GRAVITY, elements=elements)
    loads = {
        "d": lambda t, position, speed: -0.3 * speed["d"],
        "coupler": lambda t: cd.Wrench((1.0, 2.0, 0.0), (0.0, 0.0, math.sin(t)), "world"),
    }
    return scene.simulate(1.0, speed=3.0, loads=loads, method=method, rtol=rtol)


@pytest.fixture(scope="module")
def accurate() -> cd.Trajectory:
    return where_all_kinds_of_forces_act("DOP853", 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["response", "DOP853", "Radau"])
def test_methods_agree_where_all_kinds_of_forces_act(method: str, accurate: cd.Trajectory) -> None:
    rtol = 1e-7 if method == "Radau" else 1e-9
    found = where_all_kinds_of_forces_act(method, rtol)
    np.testing.assert_allclose(
        found.at(TIMES).position, accurate.at(TIMES).position, atol=100.0 * rtol
    )
    confirmed(found, 100.0 * rtol)


@pytest.mark.slow
@pytest.mark.parametrize(
    "motion",
    [tilt, [lambda t, k=k: tilt(t)[k] for k in range(3)], (KNOTS, 0.4 + 0.1 * np.sin(KNOTS))],
)
def test_one_of_two_drives_is_moved(joint: cd.Mechanism, motion: Any) -> None:
    scene = cd.Scene(joint, drive="joint_angle", free="bearing_in", gravity=GRAVITY)
    found = scene.simulate(1.0, speed=12.0, motion={"joint_angle": motion}, rtol=1e-11)
    some = found.at(TIMES)
    told = np.array([tilt(time) for time in TIMES])
    # A spline of step 1/40 errs by its sixth and fourth power.
    for column, part in enumerate((some.position, some.speed, some.acceleration)):
        np.testing.assert_allclose(part[:, 0], told[:, column], atol=1e-7)
    driven = scene.replace(drive=scene.coordinates)
    effort = driven.sweep(some.position, some.speed, some.acceleration).drive_effort
    assert np.max(np.abs(effort[:, 1])) < 1e-12 * np.max(np.abs(effort[:, 0]))
    confirmed(found, 1e-8)


def test_a_drive_of_constant_speed_begins_where_it_is(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="joint_angle", free="bearing_in")
    found = scene.simulate(
        1.0, position=[0.4, 0.2], speed={"bearing_in": 9.0}, motion={"joint_angle": 0.3}
    )
    np.testing.assert_allclose(found.position[:, 0], 0.4 + 0.3 * found.time, atol=1e-14)
    assert found.position[0, 1] == pytest.approx(0.2, abs=1e-15)


@pytest.mark.parametrize("method", ["response", "DOP853", "Radau"])
def test_gears_under_a_constant_torque(method: str) -> None:
    trains = coupling("m", "a", "b", -0.5), coupling("n", "b", "c", 3.0)
    scene = cd.Scene(cd.load(gears(*trains, third=True)), free="a", loads={"c": -0.2})
    found = scene.simulate(1.0, speed=3.0, method=method).at(TIMES)
    acceleration = 0.3 / (0.025 * (1.0 + 0.25 + 2.25))
    expected = 3.0 * TIMES + 0.5 * acceleration * TIMES**2
    np.testing.assert_allclose(found.position, expected, atol=1e-9)
    np.testing.assert_allclose(found.motion.position("c"), -1.5 * expected, atol=1e-9)


def test_a_rack_falls_with_its_wheel() -> None:
    scene = cd.Scene(cd.load(rack("wheel", "rack")), free="b", gravity=(-9.81, 0.0, 0.0))
    found = scene.simulate(1.0)
    acceleration = -9.81 / (1.0 + 0.025 / 0.3**2)
    assert found.position[-1] == pytest.approx(0.5 * acceleration, rel=1e-9)


def test_joints_that_mimic_move_as_plain_pinocchio_says() -> None:
    text = finger(mimic("knuckle", 0.5, 0.2), mimic("knuckle", 0.03, 0.1))
    ratios, offsets = np.array([1.0, 0.5, 0.03]), np.array([0.0, 0.2, 0.1])
    scene = cd.Scene(cd.load(text), free="knuckle")

    def acceleration(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        q = offsets + ratios * x[0]
        rest, moved = (
            float(ratios @ efforts(text, q, v[0] * ratios, a * ratios)) for a in (0.0, 1.0)
        )
        return np.array([(0.5 - rest) / (moved - rest)])

    weight = (0.0, 0.0, -9.81)
    found = scene.replace(gravity=weight).simulate(
        1.0, speed=3.0, loads={"knuckle": 0.5}, rtol=1e-12
    )
    expected = integrated(acceleration, np.zeros(1), np.array([3.0]), TIMES)
    np.testing.assert_allclose(found.at(TIMES).position, expected[0], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("form", [as_balls, as_hinges])
def test_rods_between_balls(form: Any) -> None:
    scene = cd.Scene(cd.load(form()), free="a", gravity=(0.0, 0.0, -9.81))
    found = scene.simulate(1.0, speed=4.0, rtol=1e-11)
    assert found.energy_residual < 1e-9
    assert found.evenly(9).loop_residual < 1e-13


def test_loops_on_moving_bodies() -> None:
    mechanism = stacked(2)
    drives = cranks(mechanism)
    scene = cd.Scene(mechanism, free=drives, gravity=GRAVITY)
    confirmed(scene.simulate(0.5, speed=[2.0, -1.0], rtol=1e-11), 1e-9)


@pytest.mark.parametrize("outputs", [[], ["rocker_bearing"]])
def test_outputs_change_no_motion(outputs: list[str]) -> None:
    bars = cd.load("four_bar")
    whole = cd.Scene(bars, free="crank_bearing", gravity=GRAVITY)
    part = cd.Scene(bars, free="crank_bearing", gravity=GRAVITY, outputs=outputs)
    for method in (None, "DOP853"):
        found = part.simulate(0.5, speed=5.0, method=method, rtol=1e-11).at(0.5)
        expected = whole.simulate(0.5, speed=5.0, method=method, rtol=1e-11).at(0.5)
        assert found.position[0] == pytest.approx(expected.position[0], abs=1e-11)
        assert list(found) == outputs
