"""Shaft rules: published critical speeds and lengths, eigenvalues, sections by integration."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.linalg import eigh
from testkit.line_data import double_shaft, random_line

from cardan_dyn.drive_lines import (
    Bearing,
    DriveLine,
    DutyPoint,
    Shaft,
    ShaftJoint,
    Spline,
    Tube,
    VerdictRow,
)

RPM = np.pi / 30
INCH = 0.0254


def rows(line: DriveLine, rule: str, **limits: float | str | None) -> list[VerdictRow]:
    return [row for row in line.verdict(limits) if row.rule == rule]


def line(length: float = 1.2, angle: float = 5.0, **shaft: object) -> DriveLine:
    """Two joints in Z; the intermediate shaft has a tube."""
    tube = Tube(outer_diameter=3.5 * INCH, wall=0.12 * INCH, shear_limit=60e6)
    slopes = np.radians([0.0, angle, 0.0])
    given = double_shaft((0.0, 0.0, 0.0), tuple(slopes), length=length)
    middle = Shaft(**{"slope_plan": slopes[1], "length": length, "tube": tube, **shaft})
    return given.replace(shafts=[given.shafts[0], middle, given.shafts[2]])


@pytest.mark.slow
def test_example_of_pss_by_the_constant_of_ae_7() -> None:
    case = line(60 * INCH, spline=Spline()).replace(speed=0.5 * 6251 * RPM)
    share, distance = rows(case, "bending_speed", critical_constant="ae_7")
    assert share.value == pytest.approx(0.5, rel=1e-4)
    assert "AE-7" in share.note
    assert distance.status == "fail"  # In the middle of the zone of the second order.
    straight = line(60 * INCH, angle=2.0).replace(speed=0.5 * 6251 * RPM)
    assert rows(straight, "bending_speed")[1].status == "stated"


@pytest.mark.slow
def test_greatest_length_meets_the_limit() -> None:
    case = line().replace(speed=3000 * RPM)
    length = rows(case, "bending_speed")[0].inverses[1].value
    longest = rows(line(length).replace(speed=3000 * RPM), "bending_speed")[0]
    assert longest.value == pytest.approx(0.75, rel=1e-12)


@pytest.mark.slow
def test_beam_of_its_own_material() -> None:
    # First eigenvalue of a supported beam, pi^2 sqrt(E I / (rho A)) / L^2.
    tube = Tube(outer_diameter=0.09, wall=0.003, modulus=7e10, density=2700.0)
    second = np.pi / 64 * (0.09**4 - 0.084**4)
    area = np.pi / 4 * (0.09**2 - 0.084**2)
    critical = np.pi**2 * np.sqrt(7e10 * second / (2700.0 * area)) / 1.2**2
    case = line(tube=tube).replace(speed=critical / 4)
    assert rows(case, "bending_speed")[0].value == pytest.approx(0.25, rel=1e-9)
    assert "another material" in rows(case, "bending_speed", critical_constant="elbe")[0].broken[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("application", "limit"),
    [("", 0.75), ("agricultural", 0.75), ("industrial", 0.65), ("vehicle", 0.70)],
)
def test_share_by_application(application: str, limit: float) -> None:
    case = line().replace(speed=1.0, application=application)
    assert rows(case, "bending_speed")[0].limit.value == limit


@pytest.mark.slow
@pytest.mark.parametrize(
    ("own", "other"), [("industrial", "automotive"), ("automotive", "industrial")]
)
def test_share_that_the_caller_gives(own: str, other: str) -> None:
    """That of any line comes first, then that of the line's own application; none is passed by."""
    application = {"automotive": "vehicle"}.get(own, own)
    case = line().replace(speed=1.0, application=application)
    general = "bending_speed_share"
    own, other = f"{general}_{own}", f"{general}_{other}"
    for given in ({own: 0.4, general: 0.5}, {other: 0.4, own: 0.5}, {other: 0.5}):
        row = rows(case, "bending_speed", **given)[0]
        assert (row.limit.value, row.source) == (0.5, "the caller")


@pytest.mark.slow
def test_soft_centre_bearings_let_rigid_shafts_bounce() -> None:
    tube = Tube(outer_diameter=0.08, wall=0.003)
    given = random_line(3, 1)
    length = given.geometry.lengths[1]

    def found(limits: dict[str, float] | None = None, **bearing: float) -> list[VerdictRow]:
        shaft = Shaft(
            length=length, tube=tube, bearings=[Bearing(distance=0.8 * length, **bearing)]
        )
        behind = dataclasses.replace(given.shafts[2], tube=tube)
        shafts = [given.shafts[0], shaft, behind, given.shafts[3]]
        joints = [ShaftJoint(cross_mass=2.0)] * 3
        case = given.replace(shafts=shafts, joints=joints, speed=10.0)
        return rows(case, "bending_speed", **(limits or {}))

    rigid = found()
    assert [row.where for row in rigid[::2]] == ["shaft_1", "shaft_2"]
    assert all(row.status == "open" and "give stiffness of C1" in row.note for row in rigid)
    *bending, bounce = found(stiffness=1e6)
    assert [row.where for row in bending[::2]] == ["shaft_1", "shaft_2"]
    assert all(row.status == "pass" and "all shafts" in row.broken[0] for row in bending[::2])
    assert bounce.status == "stated" and "bounce_share" in bounce.note
    assert bounce.value < min(row.inverses[0].value for row in bending[::2])
    # So soft that the shafts stay straight: the joint swings with both of them on the bearing.
    *bending, softest = found(stiffness=1e3)
    mass = 7850.0 * np.pi / 4 * (0.08**2 - 0.074**2)
    lengths = given.geometry.lengths[1:3]
    swinging = mass * lengths.sum() / 3 + 2.0
    natural = np.sqrt(1e3 * 0.8**2 / swinging)
    assert softest.value == pytest.approx(natural, rel=1e-3)
    # Tubes bend as they would on no bearing at all, and share no limit with what bounces.
    assert bending[0].value < 0.1 < 10.0 / softest.value
    limit = {"bounce_share": 0.5 * 10.0 / softest.value}
    *_, missed = found(limit, stiffness=1e3)
    (needed,) = missed.inverses
    assert missed.status == "fail" and needed.what == "stiffness of C1"
    assert needed.value == pytest.approx(4e3, rel=2e-3)
    *_, met = found(limit, stiffness=needed.value)
    assert met.value == pytest.approx(missed.limit.value, rel=1e-9)


def test_a_bounce_speed_within_the_duty_cycle_passes_nothing() -> None:
    tube = Tube(outer_diameter=0.08, wall=0.003)
    given = random_line(3, 1)
    length = given.geometry.lengths[1]
    soft = Bearing(distance=0.8 * length, stiffness=1e3)
    shafts = [
        given.shafts[0],
        Shaft(length=length, tube=tube, bearings=[soft]),
        dataclasses.replace(given.shafts[2], tube=tube),
        given.shafts[3],
    ]
    line = given.replace(shafts=shafts, joints=[ShaftJoint(cross_mass=2.0)] * 3, speed=10.0)
    # As in the test above: both shafts stay straight, and their joint swings on the bearing.
    swinging = tube.density * tube.area * given.geometry.lengths[1:3].sum() / 3 + 2.0
    bounce = float(np.sqrt(1e3 * 0.8**2 / swinging))

    def found(*factors: float, **limits: float | None) -> VerdictRow:
        speeds = [factor * bounce for factor in factors]
        duty = [DutyPoint(speed=item, torque=1.0, share=1 / len(speeds)) for item in speeds]
        case = line.replace(speed=speeds[0], duty_cycle=duty)
        return rows(case, "bending_speed", **limits)[-1]

    for factors, part in (((0.7, 1.3), "it lies"), ((0.3, 0.7), "half of it lies")):
        row = found(*factors)
        assert row.status == "open" and row.value == pytest.approx(bounce, rel=1e-3)
        assert f"; {part} within" in row.note and "limits['bounce_share']" in row.note
        assert found(*factors, bounce_share=None).status == "stated"
        assert found(*factors, bounce_share=0.6).status == "fail"
    for factors in ((0.6, 0.9), (0.1, 0.3), (1.2, 3.0)):
        assert found(*factors).status == "stated"
    assert found(0.1, 0.3, bounce_share=0.6).status == "pass"


@pytest.mark.slow
def test_stress_is_that_of_the_section() -> None:
    outer, inner, torque = 3.5 * INCH, 3.26 * INCH, 1500.0
    radii = np.linspace(inner / 2, outer / 2, 20_001)
    polar = np.trapezoid(2 * np.pi * radii**3, radii)
    case = line(angle=1e-6).replace(torque=torque, service_factor=1.2)
    row = next(row for row in rows(case, "tube") if row.where == "shaft_1")
    assert row.value == pytest.approx(1.2 * torque * outer / 2 / polar, rel=1e-6)
    at_limit = rows(case.replace(torque=row.inverses[0].value / 1.2), "tube")[0]
    assert at_limit.value == pytest.approx(60e6, rel=1e-6)


def massive(line: DriveLine, first: float, second: float) -> DriveLine:
    """The line with inertias of its end shafts."""
    shafts = list(line.shafts)
    for end, inertia in ((0, first), (2, second)):
        shafts[end] = Shaft(mass=5.0, inertia=inertia, centre=0.1, bearings=shafts[end].bearings)
    return line.replace(shafts=shafts)


@pytest.mark.slow
def test_torsional_speeds_are_eigenvalues() -> None:
    """Of two inertias, as nothing between them has any."""
    case = massive(line(torsional_stiffness=4e4, tube=None), 0.5, 0.2).replace(speed=90.0)
    stiffness = 4e4 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    natural = np.sqrt(np.linalg.eigvals(stiffness / np.array([[0.5], [0.2]])).real.max())
    row, zone = rows(case, "torsional_speed")
    assert [inverse.value for inverse in row.inverses] == pytest.approx(
        [natural / 2, natural / 4], rel=1e-9
    )
    assert row.limit.value == 0.1 and "API 617" in row.source
    assert zone.status == "stated"
    for speed, status in ((0.5, "fail"), (0.56, "pass"), (0.54, "fail"), (0.24, "fail")):
        near = rows(case.replace(speed=speed * natural), "torsional_speed")[0]
        assert near.status == status
    taken_out = rows(case.replace(speed=natural / 2), "torsional_speed", torsional_distance=None)
    assert taken_out[0].status == "stated"
    inside = rows(case.replace(speed=natural), "torsional_speed")
    assert [row.status for row in inside] == ["pass", "fail"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "middle", "last", "stiffness", "hertz"),
    [
        (0.1, 0.2, 0.1, 10459.0, (72.79, 102.943)),
        # A flywheel on the middle shaft, by the closed form of three inertias.
        (1.0, 50.0, 1.0, 10459.0, (23.0186, 23.4744)),
        (0.3, 0.02, 2.0, 4e4, (61.9945, 454.4964)),
    ],
)
def test_every_mode_of_the_chain_is_judged(
    first: float, middle: float, last: float, stiffness: float, hertz: tuple[float, float]
) -> None:
    """The inertia of the middle shaft between two springs of twice its stiffness."""
    soft = 2 * stiffness
    p = soft * (last * (first + middle) + first * (middle + last))
    q = first * middle * last
    root = np.sqrt(p**2 - 4 * q * soft**2 * (first + middle + last))
    modes = np.sqrt([(p - root) / (2 * q), (p + root) / (2 * q)])
    assert modes / (2 * np.pi) == pytest.approx(hertz, rel=2e-5)
    inner = {"torsional_stiffness": stiffness, "mass": 20.0, "inertia": middle, "tube": None}
    case = massive(line(angle=4.0, **inner), first, last)
    rng = np.random.default_rng(7)
    for mode, order in ((0, 2), (0, 4), (1, 2), (1, 4)):
        speed = modes[mode] / order
        row = rows(case.replace(speed=speed), "torsional_speed")[0]
        assert row.value < 1e-9 and row.status == "fail"
        assert f"{modes[mode] / 2 / np.pi:.4g} Hz" in row.note and f"order {order} at" in row.note
    for _ in range(4):
        speeds = rng.uniform(0.1, 0.7, 3) * modes[1]
        shares = [0.2, 0.3, 0.5]
        cycle = [
            DutyPoint(share=q, speed=n, torque=1.0, name=f"point {i}")
            for i, (q, n) in enumerate(zip(shares, speeds, strict=True))
        ]
        gaps = np.abs(speeds[:, None] / np.outer([0.5, 0.25], modes).ravel() - 1)
        row, _ = rows(case.replace(duty_cycle=cycle), "torsional_speed")
        assert row.value == pytest.approx(gaps.min(), rel=1e-9)
        assert row.condition == f"point {gaps.min(axis=1).argmin()}"
        assert row.status == ("pass" if gaps.min() >= 0.1 else "fail")
    for mode in modes:
        assert rows(case.replace(speed=mode), "torsional_speed")[1].status == "fail"


@pytest.mark.slow
def test_tubes_and_crosses_are_inertias_of_the_chain() -> None:
    tube = Tube(outer_diameter=0.1, wall=0.004)
    given = random_line(3, 2)
    lengths, shafts = given.geometry.lengths, list(given.shafts)
    for k, fields in (
        (0, {"inertia": 0.04, "mass": 9.0, "torsional_stiffness": 9e4}),
        (1, {"tube": tube}),
        (2, {"tube": tube, "mass": 60.0}),
        (3, {"inertia": 0.06, "mass": 9.0, "torsional_stiffness": 7e4}),
    ):
        shafts[k] = dataclasses.replace(shafts[k], **fields)
    joints = [ShaftJoint(cross_mass=m, cross_span=0.2) for m in (3.0, 4.0, 5.0)]
    case = given.replace(shafts=shafts, joints=joints)
    area, inner = np.pi / 4 * (0.1**2 - 0.092**2), 0.092
    polar = 8.08e10 * np.pi / 32 * (0.1**4 - inner**4)
    of_mass = (0.1**2 + inner**2) / 8
    J = [0.04, 3 * 0.04 / 12, 7850 * area * lengths[1] * of_mass, 4 * 0.04 / 12]
    J += [60 * of_mass, 5 * 0.04 / 12, 0.06]
    c = [9e4, *[2 * polar / lengths[1]] * 2, *[2 * polar / lengths[2]] * 2, 7e4]
    K = np.diag([*c, 0.0]) + np.diag([0.0, *c]) - np.diag(c, 1) - np.diag(c, -1)
    modes = np.sqrt(np.maximum(eigh(K, np.diag(J), eigvals_only=True), 0.0))[1:]
    for mode in modes:
        row = rows(case.replace(speed=mode / 2), "torsional_speed")[0]
        assert row.value < 1e-8 and row.inverses[0].value == pytest.approx(mode / 2, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["constant_velocity", "cross"])
def test_what_nothing_excites_is_no_critical_speed(kind: str) -> None:
    """Joints of constant velocity excite nothing, nor do straight ones: no order, no zone."""
    angle = 5.0 if kind == "constant_velocity" else 0.0
    case = massive(line(angle=angle, torsional_stiffness=4e4), 0.5, 0.2)
    natural = np.sqrt(4e4 * (1 / 0.5 + 1 / 0.2))
    for share in (0.25, 0.5, 1.0):
        joints = [ShaftJoint(kind=kind)] * 2
        (row,) = rows(case.replace(speed=share * natural, joints=joints), "torsional_speed")
        assert row.status == "stated" and "nothing excites torsion" in row.note


def test_a_line_of_one_joint_twists_in_its_end_shafts() -> None:
    tube = Tube(outer_diameter=0.05, wall=0.004)
    ends = [
        Shaft(slope_plan=slope, length=0.4, mass=5.0, inertia=inertia, tube=tube if known else None)
        for slope, inertia, known in ((0.0, 0.5, True), (0.1, 0.2, False))
    ]
    case = DriveLine(shafts=ends, speed=90.0)
    row = rows(case, "torsional_speed")[0]
    inner = 0.042
    stiffness = 8.08e10 * np.pi * (0.05**4 - inner**4) / 32 / 0.4
    natural = np.sqrt(stiffness * (1 / 0.5 + 1 / 0.2))
    assert row.inverses[0].value == pytest.approx(natural / 2, rel=1e-12)
    bare = [dataclasses.replace(shaft, tube=None) for shaft in ends]
    (row,) = rows(case.replace(shafts=bare), "torsional_speed")
    assert row.status == "open" and "torsional_stiffness of input/output" in row.note
    assert not [r for r in rows(case, "tube") if r.where == "output"]
    (row,) = rows(case, "bending_speed")
    assert (row.where, row.status) == ("input", "open") and "give bearings of input" in row.note


def end_shaft(
    places: tuple[float, ...], length: float | None = None, k: int = 0, **shaft: object
) -> list[VerdictRow]:
    """Rows of an end shaft with a tube 40 x 3 mm that turns at 1400/min, of a line of one joint."""
    tube = Tube(outer_diameter=0.04, wall=0.003)
    bearings = [Bearing(distance=place) for place in places]
    ends = [Shaft(slope_plan=slope, length=0.4) for slope in (0.0, 0.1)]
    ends[k] = dataclasses.replace(
        ends[k], **{"length": length, "tube": tube, "bearings": bearings, **shaft}
    )
    case = DriveLine(shafts=ends, speed=1400 * RPM)
    return [row for row in rows(case, "bending_speed") if row.where == case.shaft_names[k]]


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, -1])
def test_a_long_end_shaft_bends(k: int) -> None:
    share, half = end_shaft((0.06, 3.9), 4.0, k)
    # n = 1.2187e8 sqrt(D² + d²) / L² with L in mm: 434/min.
    assert share.rule_value == pytest.approx(1400 * 3840**2 / (1.2187e8 * np.hypot(40, 34)), 1e-4)
    assert 1400 / share.rule_value == pytest.approx(434, abs=0.5)
    assert share.value == pytest.approx(share.rule_value, rel=0.02) and share.status == "fail"
    assert half.quantity.startswith("distance from half")
    # A third bearing in the middle makes two spans that swing against each other: four times it.
    thrice = end_shaft((0.06, 1.98, 3.9), 3.9, k)[0]
    assert share.value / thrice.value == pytest.approx(4.0, rel=0.03)
    elbe = DriveLine(
        shafts=[
            Shaft(
                length=4.0,
                tube=Tube(outer_diameter=0.04, wall=0.003),
                bearings=[Bearing(distance=0.06), Bearing(distance=3.9)],
            ),
            Shaft(slope_plan=0.1, length=0.4),
        ],
        speed=1400 * RPM,
    )
    by_maker = rows(elbe, "bending_speed", critical_constant="elbe")[0]
    assert by_maker.rule_value == pytest.approx(
        1400 * 3840**2 / (1.21e8 * np.hypot(40, 34)), rel=1e-3
    )


@pytest.mark.slow
def test_what_overhangs_its_bearings_bends_too() -> None:
    """The first eigenvalue of a rod with a free end: 3.516 for one that is clamped, at most."""
    section = np.sqrt(2.1e11 / 7850 * (0.04**2 + 0.034**2) / 16)
    clamped = 3.5160 * section / 2.0**2
    for places, length in (((2.0, 2.001), 2.001), ((0.001, 0.002), 2.002)):
        share = end_shaft(places, length)[0]
        assert 1400 * RPM / share.value == pytest.approx(clamped, rel=5e-3)
    heavy = end_shaft((0.06, 3.9), 4.0, mass=4 * 4.0 * 7850 * np.pi / 4 * (0.04**2 - 0.034**2))
    assert heavy[0].value == pytest.approx(2 * end_shaft((0.06, 3.9), 4.0)[0].value, rel=1e-6)


def test_an_end_shaft_without_a_tube_is_part_of_its_machine() -> None:
    assert not end_shaft((0.06, 3.9), 4.0, tube=None)
    (row,) = end_shaft((), 4.0)
    assert row.status == "open" and "give bearings of input" in row.note
    # One bearing: the joint is the other support.
    share = end_shaft((3.84,), 3.84)[0]
    assert 1400 / share.value == pytest.approx(434, abs=0.5)


@pytest.mark.parametrize(
    ("rpm", "degrees", "inertia", "front", "rear"),
    [(1500, 7.0, 0.5, 33.2, 20.7), (1500, 10.0, 0.8, 62.0, 20.9), (3000, 5.0, 0.3, 36.0, 20.6)],
)
def test_the_heavier_end_of_an_intermediate_shaft_counts(
    rpm: float, degrees: float, inertia: float, front: float, rear: float
) -> None:
    """Behind joint 1 the shaft passes on T / g and turns its own inertia, g = cos / (1 - …)."""
    tube = Tube(outer_diameter=0.06, wall=0.003, shear_limit=60e6)
    case = line(0.9, degrees, tube=tube, mass=40.0, inertia=inertia, spline=Spline(friction=0.0))
    case = case.replace(speed=rpm * RPM, torque=300.0)
    (row,) = rows(case, "tube")
    turn, beta = np.linspace(0.0, np.pi, 200_001), np.radians(degrees)
    ratio = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.cos(turn) ** 2)
    change = np.gradient(ratio, turn) * (rpm * RPM) ** 2
    section = np.pi / 16 * (0.06**4 - 0.054**4) / 0.06
    own = np.abs(300.0 / ratio + inertia * change).max() / section
    assert own / 1e6 == pytest.approx(front, abs=0.05)
    assert np.max(300.0 / ratio) / section / 1e6 == pytest.approx(rear, abs=0.1)
    assert row.value == pytest.approx(own, rel=2e-5)
    assert row.status == ("pass" if own < 60e6 else "fail")


def test_the_rear_end_counts_where_the_shaft_swings_against_what_is_behind() -> None:
    """Joint 2 bends twice as much as joint 1: the output lags while the shaft leads."""
    tube = Tube(outer_diameter=0.06, wall=0.003, shear_limit=60e6)
    given = double_shaft((0.0, 0.0, 0.0), (0.0, 0.1, -0.1), length=0.9)
    middle = Shaft(slope_plan=0.1, length=0.9, tube=tube, mass=40.0, inertia=0.5)
    behind = dataclasses.replace(given.shafts[2], mass=40.0, inertia=0.5, centre=0.1)
    case = given.replace(shafts=[given.shafts[0], middle, behind], speed=150.0, torque=0.0)
    (row,) = rows(case, "tube")
    turn = case.analyse().total
    ends = np.abs([turn.torsion_out[:, 0], turn.torsion_in[:, 1]]).max(axis=1)
    assert ends[1] > 1.2 * ends[0]
    section = np.pi / 16 * (0.06**4 - 0.054**4) / 0.06
    assert row.value == pytest.approx(ends[1] / section, rel=1e-3)


def test_end_shafts_turn_themselves_up_in_their_tubes() -> None:
    """A straight line: the drive turns all of it, the load is all that is left behind."""
    tube = Tube(outer_diameter=0.06, wall=0.003, shear_limit=60e6)
    ends = [Shaft(length=0.5, mass=9.0, inertia=inertia, tube=tube) for inertia in (2.0, 3.0)]
    middle = Shaft(length=1.0, tube=tube, mass=4.0, inertia=0.5, spline=Spline(friction=0.0))
    shafts = [ends[0], middle, ends[1]]
    case = DriveLine(shafts=shafts, speed=9.0, torque=100.0, acceleration=50.0)
    section = np.pi / 16 * (0.06**4 - 0.054**4) / 0.06
    found = [row.value * section for row in rows(case, "tube")]
    assert found == pytest.approx([100 + 50 * 5.5, 100 + 50 * 3.5, 100 + 50 * 3.0], rel=1e-9)


@pytest.mark.slow
def test_telescope_of_a_pto() -> None:
    spline = Spline(compressed=1.0, profile=0.5, travel=0.4, shortest=1.02, longest=1.36)
    case = line(1.2, spline=spline).replace(application="agricultural")
    left, longest, overlap = rows(case, "lengths")
    assert left.value == pytest.approx(0.02) and left.status == "fail"
    assert longest.status == "pass" and longest.inverses[0].value == pytest.approx(1.0 + 0.4 / 3)
    assert overlap.value == pytest.approx(0.14) and overlap.status == "fail"
    industrial = rows(case.replace(application="industrial"), "lengths")
    assert {row.status for row in industrial} == {"pass"}


def test_unbalance_in_the_units_of_the_standard() -> None:
    # G16, 20 kg, 3000/min: 1018.6 g mm by 9549 G m / n.
    case = line(mass=20.0).replace(speed=3000 * RPM)
    (row,) = rows(case, "balancing")
    assert row.value * 1e6 == pytest.approx(1018.6, abs=0.1)
    assert "needed" in row.note


@pytest.mark.slow
def test_worst_of_all_speeds_counts() -> None:
    critical = 0.25 / rows(line().replace(speed=1.0), "bending_speed")[0].value * 4
    cycle = [
        DutyPoint(share=0.5, speed=0.5 * critical, torque=1.0, name="half"),
        DutyPoint(share=0.5, speed=0.7 * critical, torque=1.0, name="fast"),
    ]
    share, distance = rows(line().replace(duty_cycle=cycle), "bending_speed")
    assert (share.condition, share.status) == ("fast", "pass")
    assert (distance.condition, distance.status) == ("half", "fail")


def test_inertia_that_is_asked_for_needs_mass() -> None:
    def missing(**end: float) -> str:
        shafts = [Shaft(**end), Shaft(length=1.0, slope_plan=0.2), Shaft(mass=5.0, inertia=0.1)]
        case = DriveLine(shafts=shafts, speed=100.0, torque=50.0)
        return next(row.note for row in case.verdict() if row.rule == "torsional_speed")

    assert missing().startswith("give mass and inertia of the input shaft")
    assert missing(mass=5.0).startswith("give inertia of the input shaft")
