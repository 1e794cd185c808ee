"""Verdict case: operating points, limits that replace others, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn.analytic.limits import LIMITS, Limit
from cardan_dyn.drive_lines import DriveLine, DutyPoint, ShaftJoint
from cardan_dyn.kit.errors import ArgumentError
from cardan_dyn.practice.drive_lines.verdict.case import Case
from cardan_dyn.practice.drive_lines.verdict.solving import LineSolver


def case(line: DriveLine, **limits: object) -> Case:
    return Case(line, limits, None, lambda: LineSolver(line, line.mechanism))


def line(**fields: object) -> DriveLine:
    return double_shaft((0.0, 0.1, 0.0)).replace(**fields)


def test_points_are_those_of_the_line_and_of_its_duty_cycle() -> None:
    cycle = [DutyPoint(share=1.0, speed=-300.0, torque=-900.0)]
    found = case(line(speed=100.0, torque=50.0, duty_cycle=cycle))
    assert [(p.name, p.speed, p.torque, p.steady) for p in found.points] == [
        ("rated", 100.0, 50.0, True),
        ("duty 1", 300.0, -900.0, False),
    ]
    assert found.fastest == (300.0, found.points[1]) and found.strongest == (900.0, found.points[1])
    assert case(line()).fastest[0] is None and case(line()).strongest[0] is None
    only = case(line(duty_cycle=cycle))
    assert [p.name for p in only.points] == ["duty 1"]


def test_limits_are_replaced_and_taken_out() -> None:
    own = Limit(0.1, "rad", "the customer")
    found = case(line(), residual_angle=own, non_uniformity=0.5, half_critical_to=None)
    assert found.limit("residual_angle") is own
    assert found.limit("non_uniformity").value == 0.5
    assert found.limit("non_uniformity").source == "the caller"
    assert found.limit("half_critical_to") is None
    assert found.limit("half_critical_from") is LIMITS["half_critical_from"]
    assert "take" in found.why_not("half_critical_to")
    assert found.limit("least_joint_angle") is None
    assert "vehicle" in found.why_not("least_joint_angle")


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"residual_angel": 1.0}, "did you mean 'residual_angle'"),
        ({"adhesion": 1.0}, "no limit of the verdict"),
        ({"residual_angle": np.nan}, "finite number"),
        ({"residual_angle": "3 deg"}, "finite number"),
        ({"residual_angle": True}, "finite number"),
        ({"critical_constant": "elbow"}, "did you mean 'elbe'"),
        ({"critical_constant": 0.0}, "more than 0"),
        ({"half_critical_from": 0.6}, "not below half_critical_to"),
        ({"residual_angle": Limit(3.0, "deg", "us")}, "unit 'deg', expected 'rad'"),
        ({"telescope_overlap": Limit(0.1, "m", "us")}, "bound 'most', expected 'least'"),
        ([1.0], "mapping"),
    ],
)
def test_wrong_limits_are_refused(limits: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        line().verdict(limits)


def test_an_analysis_says_speed_torque_and_forces() -> None:
    given = line(speed=1.0, torque=1.0)
    analysis = given.analyse(speed=200.0, torque=70.0)
    found = Case(given, None, analysis, lambda: LineSolver(given, given.mechanism))
    assert (found.points[0].speed, found.points[0].torque) == (200.0, pytest.approx(70.0))


def test_forces_of_an_analysis_count_besides() -> None:
    given = random_line(2, 1, mass=True).replace(speed=1.0, torque=1.0)
    # Ten times its weight, which no load case of the verdict has.
    analysis = given.analyse(gravity=(0.0, 0.0, -98.1))
    found = Case(given, None, analysis, lambda: LineSolver(given, given.mechanism))
    sizes, cases = found.worst("bearing_radial")
    assert sizes == pytest.approx(analysis.total.bearing_radial.max(axis=0), rel=1e-12)
    assert {item.how for item in cases} == {"the analysis"}


def test_other_analyses_are_refused() -> None:
    three = random_line(3, 1).analyse(speed=1.0, torque=1.0)
    given = line(speed=1.0, torque=1.0)
    many = given.analyse(variants=given.variants(fork_offsets=np.zeros((2, 1))))
    for analysis, message in ((three, "another line"), (many, "many designs"), (7, "is 7")):
        with pytest.raises(ArgumentError, match=message):
            given.verdict(analysis=analysis)


@pytest.mark.slow
def test_forces_without_torque_say_what_is_missing() -> None:
    assert case(line()).no_forces == "give torque"
    # What is known acts, and what is not known may add to it.
    heavy = case(random_line(2, 1, mass=True).replace(torque=1.0))
    assert (heavy.no_forces, heavy.lacking) == ("", "give speed")
    assert heavy.worst("bearing_radial")[0].min() > 0.0
    cycle = [DutyPoint(share=1.0, speed=1.0, torque=1.0)]
    assert case(line(speed=1.0, duty_cycle=cycle)).lacking == "give torque"


def test_what_acts_at_one_point_and_is_unknown_at_another_passes_nothing() -> None:
    joints = [ShaftJoint(torque_limit=1e3, pulsating_limit=1e3)] * 2
    cycle = [DutyPoint(share=1.0, speed=1.0, torque=1.0)]
    half = line(speed=90.0, duty_cycle=cycle, joints=joints)
    for given, status in ((half, "open"), (half.replace(torque=5.0), "pass")):
        rows = [row for row in given.verdict() if row.rule == "static_ratings"]
        assert {row.status for row in rows} == {status}
