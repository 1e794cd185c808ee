"""Force rules: catalogue formulas of the planar double shaft, statics of spatial lines."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from testkit.line_data import FAN, NEAR, SPAN, double_shaft, random_line

from cardan_dyn.analytic.support_forces import Spans, planar_support_forces
from cardan_dyn.drive_lines import Bearing, DriveLine, DutyPoint, Shaft, Spline, VerdictRow


def frictionless(shaft: Shaft) -> Shaft:
    """The shaft with a spline that slides freely."""
    spline = shaft.spline and dataclasses.replace(shaft.spline, friction=0.0)
    return dataclasses.replace(shaft, spline=spline)


def rows(line: DriveLine, rule: str) -> list[VerdictRow]:
    return [row for row in line.verdict() if row.rule == rule]


def test_bearings_of_the_catalogue() -> None:
    slopes = (0.0, float(np.radians(12.0)), 0.0)
    line = double_shaft((0.0, 0.0, 0.0), slopes).replace(torque=400.0)
    found = {row.where: row for row in rows(line, "bearing_forces") if "across" in row.quantity}
    spans = Spans(a=SPAN[0], b=NEAR[0], e=NEAR[1], f=SPAN[1])
    beta = np.radians(12.0)
    positions = planar_support_forces(beta, beta, 400.0, 0.9, spans, "Z")
    for name in "ABEF":
        printed = max(float(getattr(position, name)) for position in positions)
        assert found[name].value == pytest.approx(printed, rel=1e-6)
        assert found[name].rule_value == pytest.approx(printed, rel=1e-6)
        assert found[name].broken == ()


@pytest.mark.parametrize("count", [2, 3, 4])
def test_statics_agree_with_the_mechanism(count: int) -> None:
    line = random_line(count, 7).replace(torque=250.0)
    across = [row for row in rows(line, "bearing_forces") if "across" in row.quantity]
    assert len(across) == count + 2
    for row in across:
        assert row.value == pytest.approx(row.rule_value, rel=1e-10)


def test_limits_and_the_torque_they_allow() -> None:
    line = double_shaft((0.0, 0.1, 0.0)).replace(torque=400.0)
    bearings = [
        Bearing(distance=0.06, radial_limit=100.0, axial_limit=1.0),
        Bearing(distance=0.18),
    ]
    line = line.replace(shafts=[Shaft(bearings=bearings), *line.shafts[1:]])
    row = next(row for row in rows(line, "bearing_forces") if row.where == "B")
    assert row.status == "fail"
    allowed = rows(line.replace(torque=row.inverses[0].value), "bearing_forces")
    assert next(r for r in allowed if r.where == "B").value == pytest.approx(100.0, rel=1e-9)
    assert next(r for r in allowed if r.where == "A").status == "open"


def test_couples_before_and_behind_a_joint() -> None:
    slopes = (0.0, float(np.radians(20.0)), 0.0)
    line = double_shaft((0.0, 0.0, 0.0), slopes).replace(torque=100.0)
    before, behind, *_ = rows(line, "fork_couples")
    assert before.value == pytest.approx(100 * np.tan(np.radians(20.0)), rel=1e-6)
    assert behind.value == pytest.approx(100 * np.sin(np.radians(20.0)), rel=1e-6)
    steep = (0.0, float(np.radians(60.0)), 0.0)
    behind = rows(double_shaft((0.0, 0.0, 0.0), steep).replace(torque=100.0), "fork_couples")[1]
    assert behind.value > 1.05 * behind.rule_value
    assert "45°" in behind.broken[0]


def test_inertia_grows_with_the_square_of_the_speed() -> None:
    line = random_line(2, 3, mass=True)
    cycle = [
        DutyPoint(share=0.5, speed=100.0, torque=10.0, name="slow"),
        DutyPoint(share=0.5, speed=400.0, torque=10.0, name="fast"),
    ]
    line = line.replace(shafts=[frictionless(shaft) for shaft in line.shafts])
    found = rows(line.replace(duty_cycle=cycle), "bearing_forces")
    worst = [
        line.analyse(speed=400.0, torque=torque, gravity=(0.0, 0.0, -9.81)) for torque in (0, 10)
    ]
    most = np.max([item.total.bearing_radial.max(axis=0) for item in worst], axis=0)
    expected = dict(zip(worst[0].bearings, most, strict=True))
    for row in found:
        if "across" in row.quantity:
            assert row.value == pytest.approx(expected[row.where], rel=2e-4)
            assert row.condition == "fast"
            assert "massless" in row.broken[0]


def test_friction_of_a_sliding_spline() -> None:
    slopes = (0.0, float(np.radians(25.0)), 0.0)
    line = double_shaft((0.0, 0.0, 0.0), slopes, friction=0.1, radius=0.02).replace(torque=300.0)
    (row,) = rows(line, "axial_force")
    slipping = line.analyse(speed=1.0, slipping="out").total.spline_friction
    assert row.value == pytest.approx(np.abs(slipping).max(), rel=1e-6)
    assert row.rule_value == pytest.approx(300 * 0.1 / 0.02 * np.cos(np.radians(25.0)))


def test_lines_without_closed_form_and_without_hold() -> None:
    line = random_line(3, 4).replace(torque=1.0)
    shafts = [Shaft(slope_side=line.shafts[0].slope_side), *line.shafts[1:]]
    row = rows(line.replace(shafts=shafts), "bearing_forces")[0]
    assert row.rule_value is None and "no closed form" in row.broken[-1]
    loose = line.replace(shafts=[line.shafts[0], Shaft(length=0.5), *line.shafts[2:]])
    (row,) = rows(loose, "bearing_forces")
    assert row.status == "open" and "hold" in row.note


def sliding(limit: float, **fields: object) -> DriveLine:
    """A double shaft in Z, whose spline pushes with 50 kN against locating bearings."""
    given = double_shaft((0.0, 0.0, 0.0), (0.0, 0.1, 0.0), friction=0.1, radius=0.02)
    ends = [
        dataclasses.replace(
            shaft,
            bearings=[
                dataclasses.replace(item, axial_limit=limit if place == 0 else None)
                for place, item in enumerate(shaft.bearings)
            ],
        )
        for shaft in (given.shafts[0], given.shafts[2])
    ]
    return given.replace(shafts=[ends[0], given.shafts[1], ends[1]], torque=1e4, **fields)


@pytest.mark.slow
def test_locating_bearings_bear_the_push_of_the_spline() -> None:
    """μ T / r = 50 kN along the shaft fail bearings for 5 kN; statics of an end shaft say F cos."""
    found = [row for row in rows(sliding(5e3), "bearing_forces") if "along" in row.quantity]
    assert [row.status for row in found] == ["fail", "fail"]
    for row in found:
        # Its own friction varies with the torque of the middle shaft, up to T / cos; across the
        # joint the pin's reaction to the bending moment comes along as well.
        assert row.value == pytest.approx(50e3, rel=0.02)
        assert "spline of shaft_1" in row.note
        at_limit = sliding(5e3).replace(torque=row.inverses[0].value)
        again = [r for r in rows(at_limit, "bearing_forces") if "along" in r.quantity]
        assert next(r for r in again if r.where == row.where).value == pytest.approx(5e3, rel=1e-9)
    assert {r.status for r in rows(sliding(60e3), "bearing_forces") if "along" in r.quantity} == {
        "pass"
    }
    shock = rows(sliding(60e3, service_factor=1.5), "bearing_forces")
    assert {r.status for r in shock if "along" in r.quantity} == {"fail"}


def test_what_is_not_known_of_a_spline_passes_no_bearing() -> None:
    line = sliding(60e3)
    middle = dataclasses.replace(line.shafts[1], spline=Spline())
    unknown = line.replace(shafts=[line.shafts[0], middle, line.shafts[2]])
    for row in rows(unknown, "bearing_forces"):
        assert row.status == "open"
    (row,) = rows(unknown, "axial_force")
    assert row.note == "give friction and radius of the spline"
    free = unknown.replace(shafts=[frictionless(shaft) for shaft in unknown.shafts])
    assert {r.status for r in rows(free, "bearing_forces") if "along" in r.quantity} == {"pass"}


def test_weight_and_running_up_load_bearings() -> None:
    """A heavy straight line: half of its weight at each end; a fast run up, own statics."""
    ends = [Bearing(distance=0.1, radial_limit=1.0), Bearing(distance=0.3)]
    spline = Spline(friction=0.0)
    shafts = [
        Shaft(bearings=ends),
        Shaft(length=1.0, mass=40.0, inertia=0.5, transverse_inertia=3.4, spline=spline),
        Shaft(bearings=ends, mass=5.0, inertia=2.0, centre=0.1),
    ]
    line = DriveLine(shafts=shafts, speed=100.0, torque=0.0, acceleration=300.0)
    found = {row.where: row for row in rows(line, "bearing_forces") if "across" in row.quantity}
    # 20 kg hang 0.1 m before the near bearing, whose span is 0.2 m.
    assert found["B"].value == pytest.approx(20.0 * 9.81 * 1.5, rel=1e-9)
    assert found["A"].value == pytest.approx(20.0 * 9.81 * 0.5, rel=1e-9)
    assert found["E"].value == pytest.approx((20.0 * 1.5 + 5.0) * 9.81, rel=1e-9)
    assert found["B"].status == "fail"
    # Running up, joint 2 turns 2 kg·m² and joint 1 the shaft's 0.5 besides.
    torque = {row.where: row.value for row in rows(line, "static_ratings")}
    assert torque == pytest.approx({"joint_1": 300.0 * 2.5, "joint_2": 300.0 * 2.0}, rel=1e-9)


@pytest.mark.slow
def test_a_spline_slides_under_all_of_its_torque() -> None:
    """Running up 25 kg·m² at 40 rad/s² on top of 200 N·m: μ T / r = 0.1 · 1200 / 0.025 = 4800 N."""
    text = FAN.replace("torque_nm = 800", "torque_nm = 200").replace("s2 = 10", "s2 = 40")
    straight = text.replace("slope_side_deg = 3", "slope_side_deg = 0")
    # The tube has some 0.01 kg·m² besides; bent by 3°, joints vary the torque.
    for given, rel in ((straight, 3e-4), (text, 3e-3)):
        case = DriveLine.from_toml(given.replace("axial_limit_kn = 9", "axial_limit_kn = 2"))
        along = [row for row in rows(case, "bearing_forces") if "along" in row.quantity]
        assert [row.status for row in along] == ["fail", "fail"]
        assert [row.value for row in along] == pytest.approx([4800.0, 4800.0], rel=rel)
        assert "running up" in along[0].note
        (row,) = rows(case, "axial_force")
        assert row.value == pytest.approx(4800.0, rel=rel)


@pytest.mark.slow
@pytest.mark.parametrize("slipping", ["out", "in"])
def test_friction_loads_bearings_across_as_well(slipping: str) -> None:
    """Every row against analyses of all load cases, at positions between the samples."""
    case = DriveLine.from_toml(FAN.replace("slope_side_deg = 3", "slope_side_deg = 14"))
    found = {(row.where, row.quantity): row.value for row in rows(case, "bearing_forces")}
    worst = {}
    for torque in (800.0, 0.0):
        for rate in (10.0, -10.0):
            total = case.analyse(
                torque=torque, acceleration=rate, slipping=slipping, gravity=(0.0, 0.0, -9.81),
                positions=np.linspace(0.0, np.pi, 721),
            )  # fmt: skip
            sizes = {"across": total.total.bearing_radial, "along": total.total.bearing_axial}
            for way, size in sizes.items():
                for name, most in zip(total.bearings, np.abs(size).max(axis=0), strict=True):
                    worst[name, way] = max(worst.get((name, way), 0.0), float(most))
    for (name, way), most in worst.items():
        row = found.get((name, f"force {way} the shaft"), 0.0)
        assert row >= most * (1.0 - 1e-9) - 1e-6


@pytest.mark.slow
def test_a_line_that_starts_under_torque_is_at_rest() -> None:
    """Crosses that spin lighten the truck's centre bearing a little: 12 kN·m at rest count."""
    line = DriveLine.from_toml("truck")
    row = next(row for row in rows(line, "bearing_forces") if row.where == "centre")
    most = {}
    for speed in (0.0, 200 * np.pi / 30, line.speed):
        found = line.analyse(
            speed=speed, torque=1.5 * 8000.0, slipping="out", gravity=(0.0, 0.0, -9.81),
            positions=np.linspace(0.0, np.pi, 3601),
        )  # fmt: skip
        index = found.bearings.index("centre")
        most[speed] = float(found.total.bearing_radial[:, index].max())
    assert max(most, key=lambda speed: most[speed]) == 0.0
    assert row.value >= most[0.0] * (1.0 - 1e-9) and "at rest" in row.note


@pytest.mark.slow
def test_what_statics_leaves_open_passes_nothing() -> None:
    """A third bearing on the output shaft; without a spline, two that hold the line along."""
    spline = FAN[FAN.index("spline = ") : FAN.index("[[shafts]]\nmass_kg = 300")]
    third = "  { distance_mm = 500, radial_limit_kn = 8 },\n]"
    assert third in FAN
    fourth = "  { distance_mm = 700, radial_limit_kn = 8 },\n]"
    more = FAN.replace(third, third.replace("]", fourth))
    cases = {
        "as it is": (FAN, set()),
        "third bearing": (more, {"E1 across", "E2 across", "E3 across"}),
        "no spline": (FAN.replace(spline, ""), {f"{name} across" for name in "ABEF"}),
    }
    for given, wanted in cases.values():
        line = DriveLine.from_toml(given)
        opened = [row for row in line.verdict().open if row.rule == "bearing_forces"]
        names = {f"{row.where} {row.quantity.split()[1]}" for row in opened}
        assert wanted <= names and bool(wanted) == bool(names)
        assert line.verdict().passed == (not wanted)
        for row in opened:
            assert line.indeterminate[0] in row.note and "leave out" in row.note
            assert row.value is not None and row.limit is not None


def test_an_analysis_counts_besides_the_worst_case() -> None:
    line = sliding(5e3)
    harmless = line.analyse(speed=1.0, torque=1e4)
    assert not line.verdict(analysis=harmless).passed
    pulled = line.analyse(speed=1.0, torque=1e4, slipping="out")
    worst = [row for row in line.verdict(analysis=pulled) if "along" in row.quantity]
    most = np.abs(pulled.static.bearing_axial).max()
    assert max(row.value for row in worst if row.rule == "bearing_forces") >= most * (1 - 1e-12)


def test_a_bearing_that_stands_for_those_of_an_end_shaft_passes_nothing() -> None:
    given = double_shaft((0.0, 0.0, 0.0), (0.0, 0.1, 0.0))
    bare = dataclasses.replace(given.shafts[0], bearings=())
    case = given.replace(shafts=[bare, *given.shafts[1:]], torque=100.0)
    assumed = [row for row in rows(case, "bearing_forces") if row.where not in ("E", "F")]
    assert assumed and {row.status for row in assumed} == {"open"}
    assert all("give the shaft's own bearings" in row.note for row in assumed)
