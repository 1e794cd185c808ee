"""Centred double joints and joints of constant velocity: statics of free bodies, motion, errors."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from testkit.line_statics import Array, statics

from cardan_dyn import load
from cardan_dyn.analytic import centred_double_joint, drive_line
from cardan_dyn.drive_lines import (
    Bearing,
    Centring,
    DriveLine,
    Shaft,
    ShaftJoint,
    Spline,
    Tube,
    arrangements,
)
from cardan_dyn.kit.errors import ArgumentError, ModelError
from cardan_dyn.practice.drive_lines.design.support_loads import support_loads
from cardan_dyn.practice.drive_lines.line.supports import supports

HALF_PIECE = 0.06


def wide_angle(
    angle: float, centring: Centring | None = None, *, length: float = 1.0, **fields: object
) -> DriveLine:
    """A tractor's wide-angle joint, bent by an angle in degrees, and a telescope behind it.

    With no centring the coupling piece has a bearing on the ground.
    """
    half = {"slope_plan": np.radians(angle / 2), "bearings": [Bearing(distance=HALF_PIECE)]}
    piece = Shaft(length=2 * HALF_PIECE, **({"centring": centring} if centring else half))
    near = [Bearing(name="near", distance=0.15), Bearing(name="far", distance=0.3)]
    end = [Bearing(name="E", distance=0.07), Bearing(name="F", distance=0.19)]
    slope = np.radians(angle)
    return DriveLine(
        shafts=[
            Shaft(bearings=near),
            piece,
            Shaft(length=length, slope_plan=slope, spline=Spline()),
            Shaft(slope_plan=slope, bearings=end),
        ],
        **fields,
    )


def random_centred(seed: int, count: int = 4) -> DriveLine:
    """A spatial line with one centred double joint anywhere, joints of both kinds, and a spline."""
    rng = np.random.default_rng(seed)
    piece = int(rng.integers(1, count))
    kinds = ["cross" if k in (piece, piece + 1) else rng.choice(["cross", "constant_velocity"])
             for k in range(1, count + 1)]  # fmt: skip
    free = [k for k in range(1, count) if k != piece]
    sliding = int(rng.choice(free))
    centring = Centring(
        kind=str(rng.choice(["disc", "ball"])), fixed_to=str(rng.choice(["front", "rear"]))
    )
    if centring.kind == "ball" and rng.random() < 0.7:
        centring = dataclasses.replace(centring, equal_at=rng.uniform(0.0, 1.0))
    shafts = []
    for k in range(count + 1):
        slopes = {"slope_side": rng.uniform(-0.3, 0.3), "slope_plan": rng.uniform(-0.3, 0.3)}
        length = rng.uniform(0.5, 1.2)
        fork = {"fork_offset": rng.uniform(-1.5, 1.5)} if 0 < k < count else {}
        if k == piece:
            length = rng.uniform(0.08, 0.2)
            shafts.append(Shaft(length=length, centring=centring, **fork))
            continue
        bearings, spline = (), None
        if k in (0, count):
            near = rng.uniform(0.05, 0.1)
            bearings = (
                Bearing(name=f"near {k}", distance=near),
                Bearing(name=f"far {k}", distance=near + rng.uniform(0.1, 0.3)),
            )
        else:
            if k == sliding:
                spline = Spline(distance=rng.uniform(0.3, 0.6) * length, friction=0.1, radius=0.02)
            if k != free[-1]:
                place = rng.uniform(0.7, 0.95) * length
                bearings = (Bearing(name=f"centre {k}", distance=place),)
        shafts.append(Shaft(length=length, spline=spline, bearings=bearings, **slopes, **fork))
    return DriveLine(shafts=shafts, joints=[ShaftJoint(kind=str(kind)) for kind in kinds])


def along_left_up(line: DriveLine, shaft: int, force: Array) -> Array:
    axis = line.geometry.directions[shaft]
    left = np.cross([0.0, 0.0, 1.0], axis)
    left /= np.linalg.norm(left)
    return np.array([force @ axis, force @ left, force @ np.cross(axis, left)])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_random_lines_by_the_equilibrium_of_free_bodies(seed: int) -> None:
    line = random_centred(seed)
    held = {item.name: item for item in supports(line).bearings}
    assert line.indeterminate == ()
    positions = np.random.default_rng(seed).uniform(0.0, 2 * np.pi, 5)
    torque = 300.0
    found = line.analyse(speed=0.0, torque=torque, positions=positions)
    loads = support_loads(line).forces(line.fork_phases, positions, torque)
    scale = max(float(np.abs(found.static.bearing_force).max()), 1.0)
    for row, position in enumerate(positions):
        locating = {name: item.locating for name, item in held.items()}
        expected = statics(line, position, locating, torque)
        for column, name in enumerate(found.bearings):
            own = along_left_up(line, held[name].shaft, expected[name])
            np.testing.assert_allclose(
                found.static.bearing_force[row, column], own, atol=1e-9 * scale
            )
            closed = along_left_up(line, held[name].shaft, loads[row, column])
            np.testing.assert_allclose(closed[1:], own[1:], atol=1e-9 * scale)
        (piece,) = line.centred
        size = np.linalg.norm(expected[f"centring {piece}"])
        assert found.static.centring[row, 0] == pytest.approx(size, abs=1e-9 * scale)


@pytest.mark.parametrize("seed", range(2))
def test_friction_of_a_spline_by_the_equilibrium_of_free_bodies(seed: int) -> None:
    line = random_centred(seed + 50)
    held = {item.name: item for item in supports(line).bearings}
    sliding = line.analyse(speed=0.0, torque=200.0, positions=[0.4], slipping="out")
    push = float(sliding.static.spline_friction[0, 0])
    expected = statics(
        line, 0.4, {name: item.locating for name, item in held.items()}, 200.0, push=push
    )
    assert abs(push) > 100.0
    for column, name in enumerate(sliding.bearings):
        own = along_left_up(line, held[name].shaft, expected[name])
        np.testing.assert_allclose(sliding.static.bearing_force[0, column], own, atol=1e-6)


@pytest.mark.slow
def test_the_force_of_a_centring_is_inside_the_joint() -> None:
    """695 N·m at 17.5° twice: 961 N at the near bearing with a disc, 13 933 N by one on the ground.

    Bearings stand at one and two times their span. Own statics of the whole joint: the ground
    bearing bears the piece's couple with a force that the disc keeps inside.
    """
    inside = wide_angle(35.0, Centring()).analyse(speed=0.0, torque=695.0)
    assert inside.static.bearing_radial[:, 0].max() == pytest.approx(961.0, rel=2e-3)
    ground = wide_angle(35.0).analyse(speed=0.0, torque=695.0)
    assert ground.static.bearing_radial[:, 0].max() == pytest.approx(13933.0, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["disc", "ball"])
@pytest.mark.parametrize("degrees", [0.0, 5.0, 20.0, 35.0, 45.0])
def test_motion_is_that_of_the_rule(kind: str, degrees: float) -> None:
    made_for = np.radians(35.0)
    centring = Centring() if kind == "disc" else Centring(kind="ball", equal_at=made_for)
    line = wide_angle(degrees, centring)
    if kind == "ball":
        offset = centred_double_joint.centre_offset(HALF_PIECE, made_for)
        rule = centred_double_joint.centred_joint(HALF_PIECE, offset, np.radians(degrees))
        expected = [float(rule.beta_1), float(rule.beta_2), 0.0]
    else:
        expected = [np.radians(degrees / 2)] * 2 + [0.0]
    np.testing.assert_allclose(line.joint_angles, expected, atol=1e-12)
    positions = np.linspace(0.0, np.pi, 7)
    found = line.analyse(speed=3.0, torque=1.0, positions=positions)
    assert found.loop_residual < 1e-9
    beta = drive_line.residual_angle(expected[:2], [0.0, np.pi / 2])
    fine = line.analyse(speed=3.0, torque=1.0).ratio[:, -1]
    assert fine.max() == pytest.approx(1 / np.cos(beta), abs=1e-7)
    other = wide_angle(degrees, dataclasses.replace(centring, fixed_to="front"))
    np.testing.assert_allclose(other.joint_angles[:2], expected[1::-1], atol=1e-12)


def test_constant_velocity_at_any_angle_and_its_moment() -> None:
    """Ratio 1, and T tan(beta/2) on both shafts: the moment halves the angle between them."""
    shafts = list(wide_angle(30.0, Centring()).shafts)
    ends = [
        shafts[0],
        Shaft(length=0.8, slope_plan=0.5, slope_side=-0.2, spline=Spline()),
        shafts[3],
    ]
    for inertia in (0.0, 0.02):
        ends[1] = dataclasses.replace(
            ends[1], mass=5.0 if inertia else 0.0, inertia=inertia or None
        )
        line = DriveLine(shafts=ends, joints=[ShaftJoint(kind="constant_velocity")] * 2)
        found = line.analyse(speed=100.0, torque=50.0)
        np.testing.assert_array_equal(found.ratio, np.ones_like(found.ratio))
        for side in ("in", "out"):
            np.testing.assert_allclose(
                getattr(found.static, f"torsion_{side}"), 50.0, rtol=0, atol=1e-9
            )
            bending = np.broadcast_to(50.0 * np.tan(line.joint_angles / 2), (360, 2))
            np.testing.assert_allclose(getattr(found.static, f"bending_{side}"), bending, rtol=1e-9)
        assert found.balance_residual < 1e-9 and found.loop_residual < 1e-9
    assert line.phasing().value == 0.0


def test_one_uneven_joint_stays_among_even_ones() -> None:
    line = DriveLine(
        shafts=[
            Shaft(),
            Shaft(length=0.5, slope_plan=0.1, bearings=[Bearing(distance=0.4)]),
            Shaft(length=0.5, slope_plan=0.3, spline=Spline()),
            Shaft(),
        ],
        joints=[
            ShaftJoint(kind="constant_velocity"),
            ShaftJoint(),
            ShaftJoint(kind="constant_velocity"),
        ],
        speed=100.0,
        torque=10.0,
    )
    rows = {row.quantity: row for row in line.verdict() if row.where in ("output", "joint_1")}
    assert rows["residual angle"].value == pytest.approx(line.joint_angles[1], rel=1e-12)
    assert "joints with a cross" in rows["B10 life"].note
    positions = np.linspace(0.0, np.pi, 1440)
    found = line.analyse(positions=positions)
    greatest = rows["torsional acceleration of the output"].value
    assert greatest == pytest.approx(np.abs(found.acceleration[:, -1]).max(), rel=1e-5)


def test_description_and_file_come_back() -> None:
    line = random_centred(3)
    assert DriveLine.from_toml(line.to_toml()) == line
    mechanism = load(line.to_urdf())
    (piece,) = line.centred
    assert f"centring_{piece}" in {loop.name for loop in mechanism.description.loops}


@pytest.mark.slow
def test_rows_of_a_centring() -> None:
    line = wide_angle(35.0, Centring(force_limit=3000.0), torque=695.0, speed=50.0)
    line = line.replace(
        shafts=[
            dataclasses.replace(shaft, spline=shaft.spline and Spline(friction=0.0))
            for shaft in line.shafts
        ]
    )
    found = {row.quantity: row for row in line.verdict() if row.rule == "centred_double_joint"}
    assert found["force in the centring"].status == "fail"
    locating = {item.name: item.locating for item in supports(line).bearings}
    turn = np.radians(np.arange(0.0, 180.0))
    sizes = [np.linalg.norm(statics(line, p, locating, 695.0)["centring 1"]) for p in turn]
    assert found["force in the centring"].value == pytest.approx(max(sizes), rel=1e-4)
    assert found["residual angle of both joints together"].value == pytest.approx(0.0, abs=1e-7)
    table = pytest.importorskip("xarray") and line.analyse().to_xarray()
    assert list(table.coupling_piece.values) == ["shaft_1"]


def test_a_piece_with_a_tube_bends_as_a_mass_at_its_centring() -> None:
    tube = Tube(outer_diameter=0.06, wall=0.003)
    line = wide_angle(20.0, Centring(), speed=50.0)
    shafts = list(line.shafts)
    shafts[2] = dataclasses.replace(shafts[2], tube=tube)
    row = next(r for r in line.replace(shafts=shafts).verdict() if r.rule == "bending_speed")
    # From the centring to the rear joint, simply supported.
    length = 1.0 + HALF_PIECE / np.cos(np.radians(10.0))
    second, area = np.pi / 64 * (0.06**4 - 0.054**4), np.pi / 4 * (0.06**2 - 0.054**2)
    critical = (np.pi / length) ** 2 * np.sqrt(2.1e11 * second / (7850.0 * area))
    assert row.value == pytest.approx(50.0 / critical, rel=1e-5)


def test_a_coupling_piece_weighs_between_beams_what_its_tube_does() -> None:
    tube = Tube(outer_diameter=0.06, wall=0.003)
    line = random_centred(1)
    piece = next(k for k, shaft in enumerate(line.shafts) if shaft.centring is not None)
    inner = range(1, line.count)
    own = dataclasses.replace(line.shafts[piece], tube=tube)
    mass = 7850.0 * np.pi / 4 * (0.06**2 - 0.054**2) * line.geometry.lengths[piece]

    def critical(shaft: Shaft) -> list[float]:
        shafts = [
            shaft if k == piece else dataclasses.replace(each, tube=tube) if k in inner else each
            for k, each in enumerate(line.shafts)
        ]
        rows = line.replace(shafts=shafts, speed=50.0).verdict()
        return [row.value for row in rows if row.rule == "bending_speed"]

    assert 0 < piece - 1 < piece + 1 < line.count  # Beams on both sides.
    weighed = critical(dataclasses.replace(own, tube=None, mass=float(mass)))
    assert critical(own) == pytest.approx(weighed, rel=1e-9)
    assert critical(dataclasses.replace(own, mass=0.0)) != pytest.approx(weighed, rel=1e-5)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Shaft(length=0.1, slope_side=0.1, centring=Centring()), "say where it"),
        (lambda: Shaft(length=0.1, bearings=[Bearing(distance=0.1)], centring=Centring()), "carry"),
        (lambda: Centring(kind="disk"), "did you mean 'disc'"),
        (lambda: Centring(equal_at=0.5), "equal_at"),
        (lambda: ShaftJoint(kind="rzeppa"), "constant_velocity"),
        (lambda: ShaftJoint(kind="constant_velocity", rated_torque=1.0), "is that of a cross"),
        (lambda: DriveLine(shafts=[Shaft(length=1, centring=Centring()), Shaft()]), "two shafts"),
        (
            lambda: wide_angle(30.0, Centring()).replace(
                joints=[ShaftJoint(kind="constant_velocity")] * 3
            ),
            "have a cross",
        ),
        (lambda: wide_angle(80.0, Centring(kind="ball", equal_at=2.9)), "out of the reach"),
    ],
)
def test_what_cannot_be_centred(make: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()  # type: ignore[operator]


def test_designs_do_not_move_a_piece() -> None:
    line = wide_angle(30.0, Centring(), torque=1.0, speed=1.0)
    for change in (
        {"angles": line.joint_angles + 0.01},
        {"misalignments": {"offset_y_1": 1e-3}},
        {"lengths": [0.13, 1.0]},
    ):
        with pytest.raises(ArgumentError, match="moves the coupling piece"):
            line.variants(**change)
    forks = line.analyse(variants=line.variants(fork_offsets=[[0.0, 0.3], [0.2, 0.0]]))
    assert forks.loop_residual < 1e-9


def test_forks_of_a_coupling_piece_are_one_forging() -> None:
    line = wide_angle(35.0, Centring(kind="ball", equal_at=np.radians(30.0)), torque=1.0, speed=1.0)
    slopes = [*line.shafts[:3], dataclasses.replace(line.shafts[3], slope_plan=np.radians(40.0))]
    line = line.replace(shafts=slopes)
    free = line.phasing(fixed=[])
    assert free.fork_offsets[0] != 0.0
    for teeth in (None, 8):
        found = line.phasing(teeth=teeth)
        assert found.fork_offsets[0] == 0.0
        assert free.value < found.value <= found.given_value
    assert "of 4 choices" in line.phasing(teeth={1: 8}).method
    one = line.variants(fork_offsets=[[0.3]]).held
    assert one["fork_offset_1"] == [0.0] and one["fork_offset_2"] == [0.3]
    named = line.variants(fork_offsets=[[0.3, 0.3]]).held
    assert named["fork_offset_1"] == [0.3]


def test_crossed_forks_of_a_coupling_piece_are_told() -> None:
    line = wide_angle(35.0, Centring())
    crossed = [*line.shafts]
    crossed[1] = dataclasses.replace(crossed[1], fork_offset=0.1)
    for given, is_told in ((line, False), (line.replace(shafts=crossed), True)):
        row = next(
            row
            for row in given.verdict()
            if (row.where, row.quantity) == (line.shaft_names[1], "residual angle")
        )
        assert any("coupling piece" in text for text in row.broken) == is_told


def test_inertia_acceleration_is_that_of_the_shafts_between_joints() -> None:
    line = wide_angle(
        35.0, Centring(kind="ball", equal_at=np.radians(20.0)), torque=1.0, speed=50.0
    )
    found = line.analyse(positions=np.linspace(0.0, np.pi, 2001))
    greatest = np.abs(found.acceleration).max(axis=0)
    rows = {row.quantity: row for row in line.verdict() if row.rule == "accelerations"}
    assert rows["inertia acceleration in drive"].value == pytest.approx(greatest[2], rel=1e-4)
    piece = rows["angular acceleration of the coupling piece"]
    assert piece.status == "stated" and piece.value == pytest.approx(greatest[1], rel=1e-4)
    assert piece.value > 2.0 * greatest[2] > 0.0
    even = wide_angle(35.0, Centring(), torque=1.0, speed=50.0).verdict()
    assert next(row.value for row in even if row.quantity == "inertia acceleration in drive") == 0.0


def test_arrangement_has_a_centring() -> None:
    line = arrangements.centred_double_joint(0.6, 0.06, equal_at=0.0)
    offset = centred_double_joint.centred_joint(0.06, 0.0, 0.6)
    np.testing.assert_allclose(line.joint_angles, [offset.beta_1, offset.beta_2], rtol=1e-12)
    assert line.shafts[1].centring.kind == "ball"
