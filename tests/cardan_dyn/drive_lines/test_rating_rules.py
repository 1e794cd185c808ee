"""Rating rules: published ratings, inverses put back, duty cycles and torques of later joints."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn.drive_lines import DriveLine, DutyPoint, Shaft, ShaftJoint, VerdictRow

RPM = np.pi / 30
HOUR = 3600.0


def rows(line: DriveLine, rule: str) -> list[VerdictRow]:
    return [row for row in line.verdict() if row.rule == rule]


def line(angle: float, joint: ShaftJoint, **fields: object) -> DriveLine:
    """Two joints in Z, of an angle in degrees."""
    slopes = (0.0, float(np.radians(angle)), 0.0)
    return double_shaft((0.0, 0.0, 0.0), slopes).replace(joints=[joint, ShaftJoint()], **fields)


def test_life_at_the_makers_reference() -> None:
    # AISCO rates at 5000 h, 100/min and 3 degrees.
    case = line(3.0, ShaftJoint(rated_torque=800.0), speed=100 * RPM, torque=800.0)
    row = rows(case, "joint_life")[0]
    assert row.value / HOUR == pytest.approx(5000.0, rel=1e-9)
    assert row.status == "open" and "life" in row.note
    asked = rows(case.replace(life=5001 * HOUR), "joint_life")[0]
    assert asked.status == "fail" and asked.limit.bound == "least"


def test_kleins_case_needs_another_rating() -> None:
    case = line(
        7.0, ShaftJoint(rated_torque=1.0), speed=1450 * RPM, torque=1000.0, life=2000 * HOUR
    )
    needed = rows(case, "joint_life")[0].inverses[0]
    assert needed.value == pytest.approx(2185.0, abs=0.5)
    enough = case.replace(joints=[ShaftJoint(rated_torque=needed.value), ShaftJoint()])
    assert rows(enough, "joint_life")[0].value == pytest.approx(2000 * HOUR, rel=1e-12)


@pytest.mark.parametrize("field", ["rated_torque", "capacity"])
def test_life_goes_by_the_torque_that_occurs(field: str) -> None:
    """A mower behind one joint: its inertia makes several times the given torque."""
    beta, speed, torque, inertia = np.radians(35.0), 1000 * RPM, 430.0, 1.2
    shafts = [Shaft(mass=20.0, inertia=0.6), Shaft(slope_plan=beta, mass=40.0, inertia=inertia)]
    joint = ShaftJoint(**{field: 1300.0 if field == "rated_torque" else 0.4})
    mower = DriveLine(shafts=shafts, joints=[joint], speed=speed, torque=torque, life=1000 * HOUR)
    (row,) = rows(mower, "joint_life")
    # Ratio and acceleration of a single joint, in textbooks' closed form.
    phi = np.linspace(0.0, np.pi, 20_000, endpoint=False)
    ratio = np.cos(beta) / (1.0 - (np.sin(beta) * np.cos(phi)) ** 2)
    rise = -(ratio**2) / np.cos(beta) * np.sin(beta) ** 2 * np.sin(2.0 * phi)
    behind = torque / ratio + inertia * speed**2 * rise
    sides = np.abs([behind * ratio, behind]) ** (10 / 3)
    damage = 1000.0 * 35.0 * sides.mean(axis=1).min()
    given = 1000.0 * 35.0 * torque ** (10 / 3)
    constant = 1.5e6 * 1300.0 ** (10 / 3) if field == "rated_torque" else 0.4e20
    assert row.value / HOUR == pytest.approx(constant / damage, rel=1e-6)
    assert row.rule_value / HOUR == pytest.approx(constant / given, rel=1e-9)
    assert row.value < 0.2 * row.rule_value
    assert row.status == "fail" and "+" in row.broken[0] and "T_eq" in row.note
    cycle = [DutyPoint(share=1.0, speed=speed, torque=torque)]
    (of_cycle,) = rows(mower.replace(duty_cycle=cycle), "duty_cycle")
    assert of_cycle.value == pytest.approx(row.value, rel=1e-12)
    # The rating that is asked for is one that passes.
    enough = ShaftJoint(**{field: row.inverses[0].value})
    (passed,) = rows(mower.replace(joints=[enough]), "joint_life")
    assert passed.status == "pass" and passed.value == pytest.approx(1000 * HOUR, rel=1e-9)


@pytest.mark.parametrize("field", ["rated_torque", "capacity"])
def test_required_rating_of_a_duty_cycle(field: str) -> None:
    cycle = [
        DutyPoint(share=0.2, speed=2000 * RPM, torque=300.0),
        DutyPoint(share=0.5, speed=900 * RPM, torque=-700.0, name="coast"),
        DutyPoint(share=0.3, speed=0.0, torque=0.0, name="rest"),
    ]
    fields = {"duty_cycle": cycle, "life": 1234 * HOUR, "service_factor": 1.5}
    (row,) = rows(line(8.0, ShaftJoint(**{field: 900.0}), **fields), "duty_cycle")
    joint = ShaftJoint(**{field: row.inverses[0].value})
    (enough,) = rows(line(8.0, joint, **fields), "duty_cycle")
    assert enough.value == pytest.approx(1234 * HOUR, rel=1e-12)
    assert enough.status == "pass"
    # Damage by hand: n beta T^(10/3), in the units of the catalogues.
    damage = 0.2 * 2000 * 8 * 300.0 ** (10 / 3) + 0.5 * 900 * 8 * 700.0 ** (10 / 3)
    if field == "rated_torque":
        assert row.value / HOUR == pytest.approx(
            1.5e6 * 900.0 ** (10 / 3) / (1.5 * damage), rel=1e-9
        )
    else:
        per_knm = damage * 1e-10 * 1.5
        assert row.value / HOUR == pytest.approx(900.0 * 1e10 / per_knm, rel=1e-9)


@pytest.mark.slow
def test_one_joint_has_one_life_by_both_ratings() -> None:
    """L_C = 1.5e-4 T_D^(10/3) with T_D in kN·m is the same joint, whatever the shock factor."""
    for shock in (None, 1.5, 3.0):
        fields = {"speed": 90.0, "torque": 700.0, "service_factor": shock, "life": 2e6}
        joint = ShaftJoint(rated_torque=1300.0, capacity=1.5e-4 * 1.3 ** (10 / 3))
        one, two = (row for row in rows(line(8.0, joint, **fields), "joint_life")[:2])
        assert one.value == pytest.approx(two.value, rel=1e-12)
        n_beta = 90.0 / RPM * 8.0
        expected = 1.5e6 / n_beta * (1.3 / 0.7) ** (10 / 3) / (shock or 1.0)
        assert one.value / HOUR == pytest.approx(expected, rel=1e-12)
        needed = [item.inverses[0].value for item in (one, two)]
        assert 1.5e-4 * (needed[0] / 1e3) ** (10 / 3) == pytest.approx(needed[1], rel=1e-12)


def test_a_cycle_at_rest_has_no_life() -> None:
    cycle = [DutyPoint(share=1.0, speed=0.0, torque=10.0)]
    (row,) = rows(line(8.0, ShaftJoint(rated_torque=1.0), duty_cycle=cycle), "duty_cycle")
    assert row.status == "stated" and "never turns" in row.note


def test_later_joints_bear_more_torque() -> None:
    # Behind a joint the torque varies between T cos beta and T / cos beta.
    case = line(30.0, ShaftJoint(torque_limit=100.0), torque=100.0)
    first, _, second, _ = rows(case, "static_ratings")
    # Each is between the even shaft and the one between them, with the torque of both.
    assert first.value == pytest.approx(100.0 / np.cos(np.radians(30.0)), rel=1e-9)
    assert first.status == "fail"
    assert second.value == pytest.approx(100.0 / np.cos(np.radians(30.0)), rel=1e-9)
    assert second.rule_value == 100.0
    assert "+15.5 %" in second.broken[0]


def test_without_torque_inertia_alone_acts() -> None:
    idle = random_line(2, 1, mass=True).replace(speed=200.0, torque=0.0)
    row = rows(idle, "static_ratings")[0]
    assert row.value > 0.0 and row.rule_value == 0.0
    assert "inertia alone" in row.broken[0]


def test_a_duty_cycle_counts_instead_of_the_rated_point() -> None:
    cycle = [DutyPoint(share=1.0, speed=100.0, torque=1.0)]
    fields = {"speed": 200.0, "torque": 1e3, "life": HOUR, "duty_cycle": cycle}
    case = line(5.0, ShaftJoint(rated_torque=100.0), **fields)
    assert rows(case, "joint_life")[0].status == "stated"
    assert rows(case, "duty_cycle")[0].status == "pass"


def test_service_factor_and_sense_of_the_torque() -> None:
    joint = ShaftJoint(torque_limit=151.0, pulsating_limit=160.0, reversing_limit=140.0)
    case = line(1.0, joint, torque=100.0, service_factor=1.5)
    assert [row.status for row in rows(case, "static_ratings")[:2]] == ["pass", "pass"]
    turned = rows(case.replace(reversing=True), "static_ratings")[1]
    assert turned.status == "fail" and turned.limit.value == 140.0
    assert turned.value == pytest.approx(150.0, rel=1e-3)
    (design,) = rows(case, "design_torque")
    assert design.value == pytest.approx(150.0)


@pytest.mark.slow
def test_a_duty_cycle_that_drives_and_brakes_reverses_the_torque() -> None:
    """Straight shafts pass on the torque: from -600 to 1000 N·m, whatever `reversing` says."""
    cycle = [
        DutyPoint(share=0.5, speed=100.0, torque=1000.0),
        DutyPoint(share=0.5, speed=100.0, torque=-600.0),
    ]
    joint = ShaftJoint(torque_limit=5e3, pulsating_limit=1500.0, reversing_limit=900.0)
    row = rows(line(0.0, joint, duty_cycle=cycle), "static_ratings")[1]
    # Haigh's straight line between amplitudes of 900 at no mean and of 750 at a mean of 750 N·m.
    amplitude, mean = 800.0, 200.0
    borne = 900.0 + (750.0 - 900.0) * mean / 750.0
    assert row.quantity == "shock torque, reversing"
    assert row.value / row.limit.value == pytest.approx(
        (amplitude + mean * (900.0 - 750.0) / 750.0) / 900.0, rel=1e-9
    )
    assert (row.status == "pass") == (amplitude <= borne)
    weak = dataclasses.replace(joint, reversing_limit=760.0)
    assert rows(line(0.0, weak, duty_cycle=cycle), "static_ratings")[1].status == "fail"
    # Where little of it reverses, by the same line, on the scale of the torque that occurs.
    braked = [cycle[0], dataclasses.replace(cycle[1], torque=-100.0)]
    row = rows(line(0.0, joint, duty_cycle=braked), "static_ratings")[1]
    assert row.quantity == "shock torque, pulsating" and row.limit.value == 1500.0
    assert row.value / 1500.0 == pytest.approx((550.0 + 450.0 * 150.0 / 750.0) / 900.0, rel=1e-9)
    assert "100 N·m in the other sense" in row.note
    one_way = [dataclasses.replace(point, torque=abs(point.torque)) for point in cycle]
    row = rows(line(0.0, joint, duty_cycle=one_way), "static_ratings")[1]
    assert row.quantity == "shock torque, pulsating" and row.limit.value == 1500.0


def test_inertia_within_a_turn_reverses_the_torque() -> None:
    """The shaft between the joints turns unevenly and drives them back by more than 100 N·m."""
    case = line(15.0, ShaftJoint(torque_limit=1e4, pulsating_limit=300.0), torque=100.0)
    middle = dataclasses.replace(case.shafts[1], mass=200.0, inertia=1.0)
    shafts = [case.shafts[0], middle, case.shafts[2]]
    row = rows(case.replace(shafts=shafts, speed=3000 * RPM), "static_ratings")[1]
    assert row.quantity == "shock torque, reversing" and row.status == "fail"


def test_precision_joint_of_jw_winco() -> None:
    # 27 N m at 30 degrees ask for 61 N m by the chart, 27 x 2.2 by the table.
    case = line(30.0, ShaftJoint(din_808="plain", table_torque=60.0), torque=27.0, speed=230 * RPM)
    speed, torque = rows(case, "precision_joint")
    assert torque.value == pytest.approx(59.4) and torque.status == "pass"
    assert speed.status == "pass"
    fast = rows(case.replace(speed=1001 * RPM), "precision_joint")[0]
    assert fast.status == "fail"


def test_efficiency_of_rubbing_pins() -> None:
    joint = ShaftJoint(pin_radius=0.01, pin_friction=0.1, cross_span=0.08)
    (row,) = rows(line(10.0, joint), "efficiency")
    assert row.value == pytest.approx(1 - 4 / np.pi * 0.1 * 0.25 * np.radians(10.0))


def test_says_what_is_missing() -> None:
    notes = {
        row.rule: row.note for row in line(5.0, ShaftJoint()).verdict() if row.status == "open"
    }
    assert "torque" in notes["static_ratings"]
    assert "rated_torque" in notes["joint_life"]
