"""Arguments of scans."""

from __future__ import annotations

from typing import Any

import pytest

import cardan_dyn as cd
from cardan_dyn import ArgumentError
from cardan_dyn.clearance import PinGeometry
from cardan_dyn.motion.clearance.arguments import (
    clearance_of,
    damping_ratio_of,
    period_of,
    pins_of,
    refuse_unknown,
    speed_of,
    start_of,
)

PIN = PinGeometry(0.02, 0.01)


def test_good_ones_come_back() -> None:
    assert damping_ratio_of(0) == 0.0
    assert start_of("rest") == "rest"
    assert speed_of(-3) == -3.0
    assert clearance_of({"a": 1e-4}, "a", 1.0) == clearance_of(1e-4, "a", 1.0) == 1e-4


@pytest.mark.parametrize(
    ("call", "given", "match"),
    [
        (speed_of, 0.0, "speed is 0"),
        (speed_of, 1e-200, "speed is 1e-200, and so are inertia forces"),
        (speed_of, [1.0, 2.0], r"speed has shape \(2,\), expected a number"),
        (speed_of, "fast", "speed"),
        (damping_ratio_of, -0.1, "from 0 to below 1"),
        (start_of, None, "start is None"),
    ],
)
def test_bad_ones_do_not(call: Any, given: Any, match: str) -> None:
    with pytest.raises(ArgumentError, match=match):
        call(given)


def test_of_joints() -> None:
    with pytest.raises(ArgumentError, match=r"clearance\['a'\] is 0"):
        clearance_of({"a": 0.0}, "a", 1.0)
    with pytest.raises(ArgumentError, match="clearance has no value for joint 'b'"):
        clearance_of({"a": 1e-4}, "b", 1.0)
    with pytest.raises(ArgumentError, match="clearance"):
        clearance_of(PIN, "a", 1.0)


def test_of_scenes() -> None:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft", outputs=["needle_pin"])
    problem = scene.solver.problem
    pins, left_out = pins_of(problem, None)
    assert pins == ["needle_pin"]
    assert left_out["rocker_pin"] == "it is no output of the scene"
    assert period_of(scene.solver) == pytest.approx(6.283185307179586)
    crank = cd.load("slider_crank")
    slide = cd.Scene(crank, drive="piston_guide", near={"crank_bearing": 1.0})
    with pytest.raises(ArgumentError, match="piston_guide does not come back"):
        period_of(slide.solver)


def test_names_of_no_joint_are_refused() -> None:
    refuse_unknown(["a", "b"], clearance={"a": 1.0}, stiffness=3.0, law=None)
    with pytest.raises(ArgumentError, match="clearance names 'c', which is no joint; a, b"):
        refuse_unknown(["a", "b"], stiffness=1.0, clearance={"a": 1.0, "c": 2.0})


def test_free_coordinates_are_refused_in_words() -> None:
    """Whether or not a position is given, of which a sweep would ask."""
    scene = cd.Scene(cd.load("slider_crank"), free="crank_bearing")
    given = {"joints": "crank_pin", "clearance": 1e-4, "stiffness": 1e7}
    for call in (cd.clearance.scan, cd.clearance.simulate):
        with pytest.raises(
            cd.MobilityError, match=r"clearance in joints needs .* crank_bearing is free"
        ):
            call(scene, 50.0, **given)
    with pytest.raises(cd.MobilityError, match="crank_bearing is free"):
        cd.clearance.simulate(scene, 50.0, position=1.0, **given)
