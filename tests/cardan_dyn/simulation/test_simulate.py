"""Simulate: which method is taken, what is refused, and how a simulation ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from testkit.linkages import four_bar, loop, slider_crank

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

GRAVITY = (0.0, -9.81, 0.0)


@pytest.fixture(scope="module")
def bars() -> cd.Scene:
    return cd.Scene(cd.load(four_bar(loop("continuous"))), free="a", gravity=GRAVITY)


@pytest.fixture(scope="module")
def two(joint: cd.Mechanism) -> cd.Scene:
    return cd.Scene(joint, drive=["bearing_in", "joint_angle"], near={"joint_angle": 0.3})


@pytest.mark.parametrize(
    ("options", "method"),
    [
        ({}, "quadrature"),
        ({"loads": {"d": 3.0}}, "quadrature"),
        ({"loads": {"d": lambda t: 3.0}}, "response"),
        ({"loads": {"a": 3.0}}, "response"),
        ({"step": 0.01}, "DOP853"),
    ],
)
def test_the_first_method_that_suits(bars: cd.Scene, options: Any, method: str) -> None:
    assert bars.simulate(0.2, speed=4.0, **options).method == method


def test_what_is_no_scalar_is_simulated_in_all_coordinates(two: cd.Scene) -> None:
    assert two.replace(free=two.drives).simulate(0.1, speed=[4.0, 0.0]).method == "DOP853"
    assert (
        two.replace(free="bearing_in").simulate(0.1, speed=4.0, motion={"joint_angle": 0.0}).method
        == "DOP853"
    )
    sliding = cd.Scene(cd.load(slider_crank(None)), free="d", near={"d": -0.05})
    assert sliding.simulate(0.01).method == "DOP853"


@pytest.mark.slow
@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853", "Radau"])
@pytest.mark.parametrize("of_scene", [{}, {"d": 50.0}])
def test_loads_act_instead_of_those_of_the_scene(
    bars: cd.Scene, method: str, of_scene: dict[str, float]
) -> None:
    """A method that took the scene's would be wrong without a word."""
    scene, reference = bars.replace(loads=of_scene), bars.replace(loads={"d": 2.0})
    found = scene.simulate(1.0, speed=3.0, loads={"d": 2.0}, method=method)
    expected = reference.simulate(1.0, speed=3.0, method="DOP853", rtol=1e-12)
    assert found.position[-1] == pytest.approx(expected.position[-1], abs=1e-8)
    np.testing.assert_array_equal(found.loads["d"], 2.0)


@pytest.mark.parametrize(
    ("method", "options", "message"),
    [
        ("quadrature", {"loads": {"d": lambda t: 1.0}}, "constant loads"),
        ("quadrature", {"step": 0.1}, "no steps of a given length"),
        ("quadrature", {"loads": {"a": 1.0}}, "a constant torque speeds the drive up"),
        ("Radau", {"step": 0.1}, "no steps of a given length"),
    ],
)
def test_methods_that_would_leave_something_out(
    bars: cd.Scene, method: str, options: Any, message: str
) -> None:
    with pytest.raises(cd.ArgumentError, match=f"method '{method}' does not suit .*{message}"):
        bars.simulate(0.2, speed=9.0, method=method, **options)


@pytest.mark.parametrize("method", ["quadrature", "response"])
def test_two_drives_are_no_scalar(two: cd.Scene, method: str) -> None:
    moved = two.replace(free="bearing_in"), {"motion": {"joint_angle": 0.1}}
    for scene, options in ((two.replace(free=two.drives), {}), moved):
        with pytest.raises(cd.ArgumentError, match="it takes one free coordinate and no drive"):
            scene.simulate(0.2, method=method, **options)


def test_every_drive_has_a_motion(two: cd.Scene) -> None:
    scene = two.replace(free="bearing_in")
    with pytest.raises(cd.ArgumentError, match=r"drives joint_angle, of which nothing says how"):
        scene.simulate(0.2, speed=1.0)
    with pytest.raises(
        cd.ArgumentError, match=r"motion\['bearing_in'\]: the joint is free; drives"
    ):
        scene.simulate(0.2, motion={"joint_angle": 0.1, "bearing_in": 1.0})
    with pytest.raises(cd.MobilityError, match="scene drives all it has: bearing_in, joint_angle"):
        two.simulate(0.2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"duration": 0.0}, "duration is 0, expected a positive number"),
        ({"duration": -1.0}, "duration is -1, expected a positive number"),
        ({"duration": math.nan}, "duration is not finite"),
        ({"duration": [1.0, 2.0]}, r"duration has shape \(2,\), expected a number"),
        ({"rtol": 1e-15}, "rtol is 1e-15, below rounding; the least is 2.5e-14"),
        ({"rtol": 1.0}, "rtol is 1; expected a fraction"),
        ({"rtol": "fine"}, "rtol is not"),
        ({"atol": 0.0}, "atol is 0, expected a positive number"),
        ({"step": -0.1}, "step is -0.1, expected a positive number"),
        ({"method": "Euler"}, "method 'Euler' is unknown; methods: "),
        ({"method": 3}, "method 3 is unknown"),
        ({"position": math.inf}, "position is not finite"),
        ({"speed": [[1.0], [1.0, 2.0]]}, "speed is not an array of real numbers"),
        ({"loads": {"d": [1.0, 2.0]}}, r"loads\['d'\] has shape \(2,\); a simulation takes one"),
        ({"loads": {"crank": np.zeros((2, 6))}}, r"loads\['crank'\]: a simulation takes one wre"),
        ({"loads": {"d": lambda t, x: 0.0}}, r"loads\['d'\]: a function of 2 arguments"),
        ({"loads": {"d": lambda t: math.nan}}, r"loads\['d'\] returned nan at time 0 s"),
        (
            {"motion": {"d": 1.0}},
            r"motion\['d'\]: the joint is no drive of the scene; drives: none",
        ),
        ({"events": 3}, "events is 3"),
        ({"progress": 3}, "progress is 3"),
    ],
)
def test_what_is_wrong_is_said(bars: cd.Scene, options: dict[str, Any], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        bars.simulate(options.pop("duration", 1.0), **options)


@pytest.mark.parametrize("argument", ["position", "speed", "loads"])
def test_unknown_names(bars: cd.Scene, argument: str) -> None:
    value = (lambda t: 1.0) if argument == "loads" else 1.0
    with pytest.raises(cd.ModelError, match="'x'"):
        bars.simulate(1.0, **{argument: {"x": value}})


def late(value: object) -> Any:
    def load(time: float) -> Any:
        if time > 0.5:
            if isinstance(value, BaseException):
                raise value
            return value
        return 0.3

    return load


@pytest.mark.slow
@pytest.mark.parametrize("method", ["response", "DOP853", "Radau"])
@pytest.mark.parametrize(
    ("value", "message"),
    [(math.nan, "returned nan at time"), ("x", "'x'"), (ValueError("no"), "ValueError: no")],
)
def test_loads_that_fail_later(bars: cd.Scene, method: str, value: object, message: str) -> None:
    with pytest.raises(cd.SimulationError, match=message) as caught:
        bars.simulate(1.0, speed=4.0, loads={"d": late(value)}, method=method, rtol=1e-8)
    error = caught.value
    assert error.time == error.trajectory.time[-1]
    assert 0.0 < error.time <= 0.5
    assert message in error.trajectory.reason
    expected = bars.simulate(0.5, speed=4.0, loads={"d": 0.3}).at(error.time).position[0]
    assert error.trajectory.position[-1] == pytest.approx(expected, abs=1e-5)
    assert error.trajectory.energy_residual < 1e-4


@pytest.mark.parametrize("method", ["response", "DOP853"])
def test_loads_that_fail_in_the_first_step(bars: cd.Scene, method: str) -> None:
    def load(time: float) -> float:
        return 0.0 if time == 0.0 else math.nan

    with pytest.raises(cd.SimulationError, match="ended at 0 s of 1 s") as caught:
        bars.simulate(1.0, position=0.3, speed=4.0, loads={"d": load}, method=method)
    trajectory = caught.value.trajectory
    assert trajectory.time.tolist() == [0.0]
    assert trajectory.at(0.0).position[0] == pytest.approx(0.3, abs=1e-15)


@pytest.mark.parametrize("method", ["response", "DOP853", "Radau"])
@pytest.mark.parametrize("where", ["loads", "progress"])
def test_an_interruption_keeps_what_was_computed(bars: cd.Scene, method: str, where: str) -> None:
    def progress(fraction: float) -> None:
        if fraction > 0.5:
            raise KeyboardInterrupt

    options = {"progress": progress} if where == "progress" else {}
    load = late(KeyboardInterrupt()) if where == "loads" else lambda t: 0.3
    kept = bars.simulate(1.0, speed=4.0, loads={"d": load}, method=method, rtol=1e-8, **options)
    assert kept.reason == "interrupted"
    assert 0.0 < kept.time[-1] < 1.0
    expected = bars.simulate(1.0, speed=4.0, loads={"d": 0.3}).at(0.2).position[0]
    assert kept.at(0.2).position[0] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853", "Radau"])
def test_events_end_every_method(bars: cd.Scene, method: str) -> None:
    def quarter(time: float, position: Any, speed: Any) -> float:
        return position["a"] - 0.5 * math.pi

    events = [cd.Event(quarter, terminal=True), cd.Event(lambda t: t - 0.01, name="early")]
    ended = bars.simulate(2.0, speed=4.0, events=events, method=method)
    assert ended.reason == "event 'quarter'"
    assert [event.name for event in ended.events] == ["early", "quarter"]
    assert ended.events[0].time == pytest.approx(0.01, abs=1e-15)
    assert ended.time[-1] == ended.events[1].time
    assert ended.position[-1] == pytest.approx(0.5 * math.pi, abs=1e-12)
