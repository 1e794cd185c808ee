"""Angle rules: published examples, closed forms of two joints, accelerations of the analysis."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.exhaustive import slopes_line
from testkit.line_data import double_shaft, random_line

from cardan_dyn.analytic.drive_line import residual_angle
from cardan_dyn.drive_lines import DriveLine, Shaft, ShaftJoint, VerdictRow
from cardan_dyn.practice.drive_lines.line.geometry import residual_angles
from cardan_dyn.practice.drive_lines.verdict.angle_rules import inertia_ratio

RPM = np.pi / 30


def rows(line: DriveLine, rule: str, **limits: float | None) -> list[VerdictRow]:
    return [row for row in line.verdict(limits) if row.rule == rule]


def planar(first: float, second: float, **fields: object) -> DriveLine:
    """A Z arrangement in the plan view, of joint angles in degrees."""
    slopes = np.radians([0.0, first, first - second])
    return double_shaft((0.0, 0.0, 0.0), tuple(slopes)).replace(**fields)


def test_example_of_the_catalogue() -> None:
    residual = rows(planar(12.0, 10.0), "uniformity")[0]
    assert np.degrees(residual.value) == pytest.approx(6.6673, abs=5e-5)
    assert np.degrees(residual.rule_value) == pytest.approx(6.6332, abs=5e-5)
    assert residual.status == "fail"
    assert residual.margin == pytest.approx(1.0 - 6.6673 / 3.0, abs=1e-4)
    assert residual.broken == ()  # 0.5 % off, and planar with forks in line
    assert "Klein" in residual.source


def test_allowed_angles_of_the_second_joint_are_those_of_the_product_formula() -> None:
    residual = rows(planar(12.0, 10.0), "uniformity")[0]
    ratio = np.cos(np.radians(3.0))
    expected = np.arccos(np.cos(np.radians(12.0)) / np.array([ratio, 1.0 / ratio]))
    found = [inverse.value for inverse in residual.inverses]
    np.testing.assert_allclose(found, expected, rtol=1e-10)
    assert [inverse.what for inverse in residual.inverses] == [
        "least angle of joint_2",
        "greatest angle of joint_2",
    ]


def test_non_uniformity_and_its_inverse() -> None:
    second = rows(planar(3.0, 0.0), "uniformity")[1]
    assert second.value == pytest.approx(0.0027428, abs=5e-8)
    assert second.inverses[0].value == pytest.approx(np.radians(3.0), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("most", [None, 0.02, np.radians(3.0), 0.4])
def test_a_residual_angle_and_its_own_non_uniformity_pass_together(most: float | None) -> None:
    """Both are limits of one angle: 2.99 degrees pass both, and so at any limit."""
    angle = np.radians(3.0) if most is None else most
    limits = {} if most is None else {"residual_angle": most}
    for share in (0.5, 0.9966, 1 - 1e-9, 1 - 1e-13, 1.0, 1 + 0.7e-9, 1 + 1e-8, 1.01, 2.0):
        first, second = rows(planar(np.degrees(angle * share), 0.0), "uniformity", **limits)[:2]
        assert first.status == second.status == ("pass" if share <= 1 + 1e-9 else "fail")
        assert second.limit.value == pytest.approx(1 / np.cos(angle) - np.cos(angle), rel=1e-9)
    other = rows(planar(2.0, 0.0), "uniformity", non_uniformity=0.001)[0]
    assert np.cos(other.limit.value) == pytest.approx((np.sqrt(0.001**2 + 4) - 0.001) / 2)
    assert rows(planar(9.0, 0.0), "uniformity", residual_angle=None)[1].status == "stated"


def test_rules_that_do_not_apply_fail_no_line() -> None:
    """A coupling shaft of 1 and 3.5 degrees in a line of three joints, and crossed forks."""
    slopes = np.radians(np.cumsum([0.0, 1.0, 3.5, -3.64]))
    shafts = [Shaft(slope_side=slope, length=1.0) for slope in slopes]
    line = DriveLine(shafts=shafts, application="vehicle", speed=150.0)
    found = [row for row in rows(line, "joint_angles") if "difference" in row.quantity]
    assert [row.status for row in found] == ["stated", "stated"]
    assert all("more joints than those of this shaft" in row.note for row in found)
    crossed = double_shaft((0.0, 0.1, 0.0), fork_offset=np.pi / 2).replace(application="vehicle")
    (row,) = (row for row in rows(crossed, "joint_angles") if "difference" in row.quantity)
    assert row.status == "stated"
    two = planar(3.0, 4.1, application="vehicle")
    (row,) = (row for row in rows(two, "joint_angles") if "difference" in row.quantity)
    assert row.status == "fail" and row.limit.value == pytest.approx(np.radians(1.0))


@pytest.mark.parametrize(
    ("rpm", "angle", "status"),
    [(5000, 3.19, "pass"), (5000, 3.21, "fail"), (3500, 4.99, "pass"), (3500, 5.01, "fail")],
)
def test_greatest_angle_by_speed_and_least_angle(rpm: float, angle: float, status: str) -> None:
    line = planar(angle, angle, application="vehicle", speed=rpm * RPM)
    found = {row.quantity: row.status for row in rows(line, "joint_angles")}
    assert found["joint angle at the greatest speed"] == status
    assert found["least joint angle"] == "pass"
    straight = planar(0.4, 0.4, application="vehicle", speed=rpm * RPM)
    assert {row.status for row in rows(straight, "joint_angles") if "least" in row.quantity} == {
        "fail"
    }


def test_spatial_lines_break_the_sum_with_signs() -> None:
    spatial = rows(random_line(3, 2), "uniformity")[0]
    assert any("sums with signs" in text for text in spatial.broken)
    assert not any(
        "sums with signs" in text for text in rows(planar(9.0, 9.0), "uniformity")[0].broken
    )


def test_accelerations_of_the_example_of_pss() -> None:
    # 5, 4, 3, 2 degrees at 2500/min, the first shaft crossed: 749, 2026 and
    # 209 rad/s^2.
    slopes = np.radians(np.cumsum([0.0, 5.0, -4.0, 3.0, -2.0]))
    shafts = [Shaft(slope_plan=slope, length=0.5) for slope in slopes]
    shafts[1] = Shaft(slope_plan=slopes[1], length=0.5, fork_offset=np.pi / 2)
    line = DriveLine(shafts=shafts, speed=2500 * RPM)
    found = rows(line, "accelerations")
    assert [round(row.rule_value) for row in found] == [749, 2026, 209]
    assert [row.status for row in found] == ["fail", "fail", "pass"]
    assert found[1].note == "beyond 2000 rad/s² at most"


@pytest.mark.parametrize("count", [2, 3, 4])
def test_exact_accelerations_are_those_of_the_analysis(count: int) -> None:
    line = random_line(count, 5)
    turn = line.analyse(speed=1.0, torque=1.0, positions=np.linspace(0, np.pi, 1440))
    rate, second = turn.ratio, turn.acceleration
    last, change = rate[:, -1:], second[:, -1:]
    back = (second * last - rate * change) / last**3  # By the rotation of the output shaft.
    torsional, drive, coast = (row.value for row in rows(line.replace(speed=1.0), "accelerations"))
    assert torsional == pytest.approx(np.abs(second[:, -1]).max(), rel=1e-5)
    assert drive == pytest.approx(np.abs(second[:, 1:-1].sum(axis=1)).max(), rel=1e-5)
    assert coast == pytest.approx(np.abs(back[:, 1:-1].sum(axis=1)).max(), rel=1e-5)


def test_one_intermediate_shaft_is_a_single_joint() -> None:
    beta = np.radians(30.0)
    turn = np.linspace(0, np.pi, 200_001)
    ratio = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.sin(turn) ** 2)
    steepest = np.abs(np.gradient(ratio, turn)).max()
    assert inertia_ratio(np.array([beta, 0.1]), np.zeros(2)) == pytest.approx(steepest, rel=1e-5)


def test_allowed_speed_meets_the_limit() -> None:
    line = planar(12.0, 10.0, speed=1000 * RPM)
    row = rows(line, "accelerations")[0]
    at_limit = rows(line.replace(speed=row.inverses[0].value), "accelerations")[0]
    assert at_limit.value == pytest.approx(300.0, rel=1e-12)
    assert at_limit.status == "pass"


@pytest.mark.slow
def test_joint_angles_of_a_vehicle_and_of_any_line() -> None:
    line = planar(7.0, 5.0)
    of_any = {row.quantity: row.status for row in rows(line, "joint_angles")}
    # The greatest angle of the joint is asked for; what holds for vehicles counts for nothing.
    assert of_any.pop("joint angle") == "open" and set(of_any.values()) == {"stated"}
    vehicle = line.replace(application="vehicle")
    judged = {(row.where, row.quantity): row.status for row in rows(vehicle, "joint_angles")}
    assert judged["shaft_1", "difference of both joint angles"] == "fail"
    assert judged["joint_1", "joint angle at the greatest speed"] == "open"


@pytest.mark.parametrize(
    ("degrees", "rpm", "status"),
    [(8.0, 1200, "pass"), (11.4, 1500, "pass"), (11.6, 800, "fail"), (5.9, 3000, "fail"),
     (3.1, 5000, "pass"), (1.0, 6000, "open"), (5.0, 6000, "fail")],
)  # fmt: skip
def test_the_angle_of_a_vehicle_goes_by_its_speed_alone(
    degrees: float, rpm: float, status: str
) -> None:
    """Spicer's table: 11.5 degrees up to 1500/min, 5.8 at 3000, 3.2 at 5000, where it ends."""
    line = planar(degrees, degrees, application="vehicle", speed=rpm * RPM)
    found = [row for row in rows(line, "joint_angles") if row.where == "joint_1"]
    by_speed = [row.status for row in found if "speed" in row.quantity]
    assert by_speed == [status]
    others = {row.quantity for row in found if row.status not in ("open", "stated")}
    assert others <= {"joint angle at the greatest speed", "least joint angle"}


def test_speed_and_angle_by_size() -> None:
    # Dana: joint 2040 at 10 degrees may turn at 2000/min.
    joints = [ShaftJoint(size="2040"), ShaftJoint(largest_n_beta=1.0, largest_speed=1.0)]
    line = planar(10.0, 10.0, joints=joints, speed=2000 * RPM)
    found = rows(line, "n_beta")
    assert [row.status for row in found] == ["pass", "pass", "fail", "fail"]
    assert found[1].margin == pytest.approx(0.0, abs=1e-12)
    assert found[1].inverses[0].value == pytest.approx(np.radians(10.0))
    assert "2040" in found[1].source
    assert "1.5 m" in found[1].broken[0]  # It has 0.9 m.


def test_slopes_are_compared_with_sums_of_squares() -> None:
    line = double_shaft((0.0, 0.2, 0.0), (0.0, 0.2, 0.0))
    (row,) = rows(line, "slopes")
    exact = np.arctan(np.hypot(np.tan(0.2), np.tan(0.2)))
    assert row.value == pytest.approx(abs(np.hypot(0.2, 0.2) - exact), rel=1e-9)


def test_a_size_in_no_table_is_said_to_be_so() -> None:
    line = planar(5.0, 5.0, joints=[ShaftJoint(size="2056"), ShaftJoint(size="2055")], speed=100.0)
    found = {(row.where, row.quantity): row for row in rows(line, "n_beta")}
    for quantity in ("speed", "speed times angle"):
        row = found["joint_1", quantity]
        assert row.status == "open"
        assert ("size '2056' is none of Dana's" in row.note) == (quantity == "speed")
        assert found["joint_2", quantity].status == "pass"


def test_rounding_of_angles_is_zero() -> None:
    """Residual angles are roots of differences, so that rounding leaves some 1e-8 of them."""
    raw = []
    for seed in range(20):
        found = slopes_line(4, np.random.default_rng(seed)).phasing()
        if found.bound == 0.0:
            assert found.value == 0.0
            raw.append(residual_angle(found.line.joint_angles, found.line.fork_phases))
    assert 0.0 < max(raw) < 1e-7
    differences = []
    for slope in np.linspace(0.1, 0.6, 20):
        line = double_shaft((0.0, 0.0, 0.0), (0.0, slope, 2.0 * slope))
        differences.append(np.ptp(line.joint_angles))
        (row,) = (row for row in line.verdict() if row.quantity.startswith("difference"))
        assert row.value == 0.0
    assert max(differences) > 0.0


def test_angles_that_differ_by_more_than_rounding_stay() -> None:
    found = residual_angles(np.array([0.3, 0.3 + 1e-9]), np.array([0.0, np.pi / 2]))
    assert found[-1] == pytest.approx(np.sqrt(0.6e-9), rel=0.05)
