"""The drive line of three joints with a centre bearing, against pins and shafts as vectors."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.shaft_line import ShaftLine, about, across, dot, single_joint, single_ratio
from testkit.urdf_reader import Reader, text

import cardan_dyn as cd
from cardan_dyn.analytic import drive_line, support_forces

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 361)
X, Y, Z = np.eye(3)
FRONT, REAR, BEARING = 0.8, 1.0, 0.62
ANGLES = {
    "3-5-4": (3.0, -5.0, 4.0),
    "one sense": (8.0, 12.0, 5.0),
    "steep": (-25.0, 30.0, 20.0),
    "straight rear": (6.0, 0.0, 0.0),
}
# Input fork in the plane, the forks of each shaft in line: joint 2 is driven a quarter turn on.
PHASES = np.array([0.0, 0.5, 1.0]) * np.pi


def scene(degrees: tuple[float, ...], load: float = -200.0, **options: object) -> cd.Scene:
    held = {f"joint_angle_{k}": float(np.deg2rad(beta)) for k, beta in enumerate(degrees, 1)}
    return cd.Scene(
        cd.load("drive_line"),
        drive="bearing_in",
        held=held,
        loads={"bearing_out": load},
        **options,
    )


def shaft_line(degrees: tuple[float, ...]) -> ShaftLine:
    headings = np.radians(np.concatenate([[0.0], np.cumsum(degrees)]))
    shafts = np.array([about("z", heading) @ X for heading in headings])
    return ShaftLine.turn(shafts, Y, POSITIONS, (0.0, 0.0))


@pytest.fixture(scope="module", params=ANGLES)
def degrees(request: pytest.FixtureRequest) -> tuple[float, ...]:
    return ANGLES[request.param]


@pytest.fixture(scope="module")
def turn(degrees: tuple[float, ...]) -> cd.Sweep:
    return scene(degrees).sweep(POSITIONS)


def test_lengths_are_those_of_the_file() -> None:
    reader = Reader(text("drive_line"))
    assert reader.origin("fork_phase_1").tolist() == [FRONT, 0.0, 0.0]
    assert reader.origin("fork_phase_2").tolist() == [REAR, 0.0, 0.0]
    for name in ("pin_2_in", "slip"):
        assert not reader.origin(name).any()
    assert reader.origin("bearing_float").tolist() == [BEARING, 0.0, 0.0]


def test_motion_composes_single_joints(degrees: tuple[float, ...], turn: cd.Sweep) -> None:
    """tan φ' = tan φ / cos β joint by joint, and the closed form of the whole line."""
    angle, ratio = POSITIONS, np.ones_like(POSITIONS)
    betas = np.abs(np.radians(degrees))
    for index, beta in enumerate(betas):
        ratio = ratio * single_ratio(beta, angle, normal=index == 1)
        angle = single_joint(beta, angle, normal=index == 1)
    computed = turn.motion.position("bearing_out")
    assert np.max(np.abs(computed - angle)) < 1e-13
    np.testing.assert_allclose(turn.motion.ratio("bearing_out"), ratio, rtol=1e-13)
    closed = drive_line.output_angle(betas, PHASES, POSITIONS)
    assert np.max(np.abs(computed - closed)) < 1e-13
    closed = drive_line.speed_ratio(betas, PHASES, POSITIONS)
    np.testing.assert_allclose(turn.motion.ratio("bearing_out"), closed, rtol=1e-13)
    np.testing.assert_allclose(turn.drive_effort, 200.0 * ratio, rtol=1e-12)


def test_nothing_slides_and_everything_is_unique(turn: cd.Sweep) -> None:
    for name in ("slip", "bearing_float"):
        assert np.max(np.abs(turn.motion.position(name))) < 1e-14
    assert np.all([turn[name].unique for name in turn.outputs])


def test_moments_along_the_line(degrees: tuple[float, ...], turn: cd.Sweep) -> None:
    moments = shaft_line(degrees).moments(200.0)
    scale = np.max(np.abs(moments))
    for index, moment in enumerate(moments, 1):
        for name in (f"pin_{index}_in", f"pin_{index}_out"):
            computed = turn.wrench(name, "world").moment
            assert np.max(np.abs(computed - moment)) < 1e-12 * scale, name
    for name, moment in (("bearing_in", moments[0]), ("bearing_out", -moments[-1])):
        assert np.max(np.abs(turn.wrench(name, "world").moment - moment)) < 1e-12 * scale
    # The spline slides on the rear shaft and sees the moment of joint 3, where its origin is.
    assert np.max(np.abs(turn.wrench("slip", "world").moment - moments[2])) < 1e-12 * scale


def test_forces_along_the_line(degrees: tuple[float, ...], turn: cd.Sweep) -> None:
    """Rear shaft: P = (M₂ - M₃) × e₃ / L. Front shaft: moments about joint 1 give the bearing.

    M₁ - M₂ + c e₂ × C - L₁ e₂ × P = 0 for the bearing force C across e₂; joint 1 takes the rest.
    """
    line = shaft_line(degrees)
    moment_1, moment_2, moment_3 = line.moments(200.0)
    _, e_2, e_3, _ = line.shafts
    rear = np.cross(moment_2 - moment_3, e_3) / REAR
    bearing = (np.cross(moment_2 - moment_1, e_2) + FRONT * across(rear, e_2)) / BEARING
    scale = np.max(np.abs([moment_1, moment_2, moment_3])) / BEARING
    expected = {
        "pin_2_out": rear,
        "slip": rear,
        "pin_3_in": rear,
        "bearing_out": -rear,
        "centre_bearing": bearing,
        "pin_1_out": rear - bearing,
        "bearing_in": rear - bearing,
    }
    for name, force in expected.items():
        computed = turn.wrench(name, "world").force
        assert np.max(np.abs(computed - force)) < 1e-12 * scale, name
    assert np.max(np.abs(bearing)) > 0.02 * scale
    for name in ("slip", "bearing_float"):
        assert np.max(np.abs(turn[name].axial)) < 1e-12 * scale, name
    assert np.max(np.abs(turn["centre_bearing"].moment)) < 1e-13 * scale


def test_bearings_are_those_of_the_closed_form(degrees: tuple[float, ...], turn: cd.Sweep) -> None:
    spans = support_forces.Spans(a=0.13, b=0.214, e=0.214, f=0.13)
    axes, torque = np.array(shaft_line(degrees).shafts), turn.drive_effort
    closed = support_forces.line_support_forces(
        axes, POSITIONS, torque, [FRONT, REAR], [BEARING], spans, [0.0, 0.0]
    )
    force = turn.wrench("centre_bearing", "world").force
    scale = np.max(np.abs(force))
    assert np.max(np.abs(closed.centres[:, 0] + force)) < 1e-12 * scale
    # The far and near bearings of both end shafts together carry what stands across these.
    for name, axis, pair in (
        ("bearing_in", axes[0], (closed.A, closed.B)),
        ("bearing_out", axes[-1], (closed.E, closed.F)),
    ):
        whole = across(turn.wrench(name, "world").force, axis)
        assert np.max(np.abs(sum(pair) + whole)) < 1e-12 * scale, name
    moments = support_forces.line_moments(axes, POSITIONS, torque, [0.0, 0.0])
    for index in (1, 2, 3):
        computed = turn.wrench(f"pin_{index}_out", "world").moment
        assert np.max(np.abs(moments[:, index - 1] - computed)) < 1e-12 * np.max(np.abs(computed))


def test_residual_of_three_joints_in_a_plane() -> None:
    """Main positions: ratio cos β₂ / (cos β₁ cos β₃), and its inverse a quarter turn on."""
    cosines = np.cos(np.radians(ANGLES["3-5-4"]))
    expected = cosines[1] / (cosines[0] * cosines[2])
    turn = scene(ANGLES["3-5-4"]).sweep([0.0, 0.5 * np.pi, np.pi])
    ratio = turn.motion.ratio("bearing_out")
    np.testing.assert_allclose(ratio, [expected, 1.0 / expected, expected], rtol=1e-14)
    # 3² + 4² = 5² leaves a quarter of a degree of the 5°.
    residual = np.degrees(np.arccos(min(expected, 1.0 / expected)))
    assert residual == pytest.approx(
        np.degrees(drive_line.residual_angle(np.radians([3.0, 5.0, 4.0]), PHASES)), rel=1e-8
    )
    assert 0.1 < residual < 0.15


def test_centre_bearing_balances_the_front_shaft() -> None:
    """At speed, with masses and weight: Newton and Euler of the front shaft alone.

    It turns about its own axis, on which its centre of mass lies, so only its weight and the
    change of its spin have to be balanced by both joints and the centre bearing.
    """
    gravity, speed, acceleration = 9.81, 250.0, -600.0
    degrees = ANGLES["one sense"]
    turn = scene(degrees, gravity=(0.0, 0.0, -gravity)).sweep(
        POSITIONS, speed=speed, acceleration=acceleration
    )
    front_shaft = Reader(text("drive_line")).body("tube_1")
    assert front_shaft is not None and not np.any(front_shaft.centre[1:])
    axis = shaft_line(degrees).shafts[1]
    wrenches = {
        name: turn.wrench(name, "world") for name in ("pin_1_out", "centre_bearing", "pin_2_in")
    }
    inwards, bearing, outwards = wrenches.values()
    weight = front_shaft.mass * gravity * np.array([0.0, 0.0, -1.0])
    forces = inwards.force + bearing.force - outwards.force + weight
    scale = np.max(np.abs(outwards.force))
    assert np.max(np.abs(forces)) < 1e-12 * scale
    moments = (
        inwards.moment
        - outwards.moment
        + np.cross(BEARING * axis, bearing.force)
        - np.cross(FRONT * axis, outwards.force)
        + np.cross(front_shaft.centre[0] * axis, weight)
    )
    # Rotation of the front shaft: one joint in the plane, with exact derivatives.
    beta = np.deg2rad(degrees[0])
    ratio = single_ratio(beta, POSITIONS)
    slope = -(ratio**2) * np.sin(beta) ** 2 * np.sin(2.0 * POSITIONS) / np.cos(beta)
    spin = front_shaft.inertia[0, 0] * (ratio * acceleration + slope * speed**2)
    expected = spin[:, None] * axis
    assert np.max(np.abs(moments - expected)) < 1e-12 * np.max(np.abs(outwards.moment))
    assert np.max(np.abs(expected)) > 0.05 * np.max(np.abs(outwards.moment))
    # The bearing carries weight and slides on its seat without friction.
    assert np.max(np.abs(dot(bearing.force, axis))) < 1e-12 * scale
    assert np.mean(bearing.force[:, 2]) > 0.4 * front_shaft.mass * gravity


def test_bearing_cage_hangs_on_the_frame() -> None:
    """What the shaft gives to the cage goes through the slide to the frame, with its weight."""
    gravity = 9.81
    turn = scene(ANGLES["steep"], gravity=(0.0, 0.0, -gravity)).sweep(POSITIONS, speed=200.0)
    cage = Reader(text("drive_line")).body("bearing_cage")
    assert cage is not None
    frame, shaft = turn.wrench("bearing_float", "world"), turn.wrench("centre_bearing", "world")
    difference = frame.force - shaft.force - cage.mass * gravity * Z
    assert np.max(np.abs(difference)) < 1e-12 * np.max(np.abs(shaft.force))
    # Both have their origin in the centre of the bearing.
    assert np.max(np.abs(frame.moment)) < 1e-12 * np.max(np.abs(shaft.force))
