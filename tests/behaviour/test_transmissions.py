"""Transmissions: maps between motors and joints against forms by hand, virtual work, and C."""

from __future__ import annotations

import ctypes
import pickle
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit import task_machines as machines
from testkit import transmissions

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array
from cardan_dyn.scene.presets import PRESETS

pytestmark = pytest.mark.usefixtures("loaded_once")

needs_compiler = pytest.mark.skipif(not shutil.which("cc"), reason="there is no compiler")
RANDOM = np.random.default_rng(46)
MOTORS, FOOT = ["left_motor", "right_motor"], ["pitch", "roll"]
LEGS = [f"leg_{k}" for k in range(6)]


@pytest.fixture(scope="module")
def ankle() -> cd.Transmission:
    scene = cd.Scene(cd.load(transmissions.ankle()), drive=MOTORS)
    return scene.transmission(MOTORS, FOOT)


@pytest.fixture(scope="module")
def fitted(ankle: cd.Transmission) -> cd.FittedTransmission:
    return ankle.fitted()


def foot(*shape: int) -> Array:
    return RANDOM.uniform([-0.3, -0.2], [0.3, 0.2], (*shape, 2))


def slopes(joints: Array, way: Array) -> tuple[Array, Array]:
    """∂motors/∂joints of the ankle, and how fast it changes, by 40 digits of the form by hand."""
    with mpmath.workdps(40):

        def motor(k: int, x: object, y: object) -> object:
            return transmissions.ankle_motors(x, y, mpmath)[k]

        def slope(k: int, order: tuple[int, int], x: object, y: object) -> object:
            return mpmath.diff(lambda a, b: motor(k, a, b), (x, y), order)

        at = tuple(map(mpmath.mpf, joints.tolist()))
        first = [[slope(k, order, *at) for order in ((1, 0), (0, 1))] for k in (0, 1)]
        second = [
            [
                sum(
                    rate * slope(k, (one[0] + other[0], one[1] + other[1]), *at)
                    for rate, other in zip(way.tolist(), ((1, 0), (0, 1)), strict=True)
                )
                for one in ((1, 0), (0, 1))
            ]
            for k in (0, 1)
        ]
        return np.array(first, dtype=float), np.array(second, dtype=float)


def test_ankle_both_ways_by_hand(ankle: cd.Transmission) -> None:
    joints = foot(200)
    motors = np.stack(transmissions.ankle_motors(*joints.T), axis=-1)
    assert ankle.actuated_of(joints).position == pytest.approx(motors, abs=1e-12)
    assert ankle.joints_of(motors).position == pytest.approx(joints, abs=1e-12)


def test_rates_and_efforts_of_the_ankle_by_hand(ankle: cd.Transmission) -> None:
    speed, effort = np.array([2.0, -3.0]), np.array([5.0, 7.0])
    for joints in foot(3):
        by_joints, change = slopes(joints, speed)
        motors = np.stack(transmissions.ankle_motors(*joints), axis=-1)
        back = ankle.actuated_of(joints, speed, effort)
        assert back.speed == pytest.approx(by_joints @ speed, abs=1e-12)
        # Virtual work: what motors do is what motors at the joints would do.
        assert back.effort == pytest.approx(np.linalg.solve(by_joints.T, effort), abs=1e-11)
        forth = ankle.joints_of(motors, back.speed, back.effort)
        assert forth.speed == pytest.approx(speed, abs=1e-12)
        assert forth.effort == pytest.approx(effort, abs=1e-12)
        jacobian = ankle.jacobian(motors)
        assert jacobian == pytest.approx(np.linalg.inv(by_joints), abs=1e-12)
        rate = ankle.jacobian_rate(motors, by_joints @ speed)
        assert rate == pytest.approx(-jacobian @ change @ jacobian, abs=1e-11)


def test_efforts_are_those_of_the_sweep(ankle: cd.Transmission) -> None:
    """Loads on the joints need motors that hold them: the statics of all bodies, at rest."""
    mechanism, effort = cd.load(transmissions.ankle()), np.array([5.0, 7.0])
    loads = dict(zip(FOOT, (-effort).tolist(), strict=True))
    motors = RANDOM.uniform(-0.3, 0.3, (20, 2))
    sweep = cd.Scene(mechanism, drive=MOTORS, loads=loads).sweep(motors)
    needed = np.einsum("njk,j->nk", ankle.jacobian(motors), effort)
    assert sweep.drive_effort == pytest.approx(needed, abs=1e-12)
    assert ankle.joints_of(motors, effort=needed).effort == pytest.approx(
        np.broadcast_to(effort, (20, 2)), abs=1e-12
    )


def test_shapes_broadcast(ankle: cd.Transmission) -> None:
    motors = RANDOM.uniform(-0.2, 0.2, (3, 4, 2))
    found = ankle.joints_of(motors, speed=[1.0, 2.0], effort=np.ones((5, 1, 1, 2)))
    assert found.position.shape == (3, 4, 2)
    assert found.speed is not None and found.speed.shape == (3, 4, 2)
    assert found.effort is not None and found.effort.shape == (5, 3, 4, 2)
    assert ankle.joints_of(motors[0, 0]).speed is None
    assert ankle.jacobian(motors).shape == (3, 4, 2, 2)
    assert ankle.jacobian_rate(motors, np.ones((4, 2))).shape == (3, 4, 2, 2)
    assert ankle.reflected_inertia(motors).shape == (3, 4, 2, 2)
    assert not np.any(ankle.jacobian_rate(motors[0, 0], [0.0, 0.0]))


def test_reflected_inertia_is_that_of_the_kinetic_energy() -> None:
    """At speeds, the energy of links that move, by their own speeds, is ½ v · inertia · v."""
    mechanism = cd.load(transmissions.boom())
    boom = cd.Scene(mechanism, drive="stroke").transmission("stroke", "boom_pin")
    strokes = np.array([-0.2, 0.0, 0.15])
    sweep = cd.Scene(mechanism, drive="stroke").sweep(strokes, speed=1.0)
    energy = np.zeros(3)
    for link in mechanism.description.links:
        if link.mass:
            point = sweep.point(link.name, link.centre)
            energy += 0.5 * link.mass * np.sum(point.velocity**2, axis=-1)
            energy += 0.5 * link.inertia[1, 1] * point.angular_velocity[..., 1] ** 2
    assert 0.5 * boom.reflected_inertia(strokes)[:, 0, 0] == pytest.approx(energy, rel=1e-12)


def test_limits_of_the_ankle(ankle: cd.Transmission) -> None:
    motors = np.array([0.1, -0.2])
    jacobian = ankle.jacobian(motors)
    corners = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]])
    speeds, efforts = ankle.speed_limits(motors), ankle.effort_limits(motors, [30.0, 20.0])
    assert speeds == pytest.approx(12.0 * corners @ jacobian.T, abs=1e-12)
    assert efforts @ jacobian == pytest.approx(corners * [30.0, 20.0], abs=1e-11)
    assert ankle.effort_limits(motors) @ jacobian == pytest.approx(40.0 * corners, abs=1e-11)


@pytest.mark.slow
def test_singular_values_and_borders_of_the_ankle(ankle: cd.Transmission) -> None:
    values = ankle.singular_values([0.1, -0.2])
    assert values == pytest.approx(np.linalg.svd(ankle.jacobian([0.1, -0.2]))[1], rel=1e-13)
    start, end = np.array([-1.5, -1.5]), np.array([1.0, 1.2])
    found = ankle.borders(start, end, samples=65)
    assert [item.kind for item in found] == [1, 1, 2]
    for item in found:
        at = start + item.part * (end - start)
        assert item.position == pytest.approx(at, abs=1e-12)
    scene = cd.Scene(cd.load(transmissions.ankle()), drive=MOTORS)
    for item in found[:2]:
        # A crank and the rod's projection are in line: then the foot is farthest, or nearest.
        off = []
        for y, z in transmissions.MOTORS.values():
            ball = scene.sweep(item.position).point("foot", [-0.05, y, 0.03]).position[0]
            far = float(np.hypot(ball[0], ball[2] - z))
            rod = float(np.sqrt((z - transmissions.SOLE) ** 2 - (ball[1] - y) ** 2))
            off += [far - rod - transmissions.CRANK, far - rod + transmissions.CRANK]
        assert np.min(np.abs(off)) < 1e-9
        assert ankle.singular_values(item.position)[-1] < 1e-10
    # Towards the other kind, speeds grow as the reciprocal of the root of the distance.
    near = [ankle.singular_values(found[2].position - d * (end - start))[0] for d in (1e-4, 1e-6)]
    assert near[1] / near[0] == pytest.approx(10.0, rel=0.05)
    with pytest.raises(cd.SingularConfigurationError, match="can take any effort"):
        ankle.joints_of(found[1].position, effort=[1.0, 1.0])
    with pytest.raises(cd.AssemblyError):
        ankle.joints_of(end)


def test_what_motors_cannot_reach_is_no_way_back(ankle: cd.Transmission) -> None:
    """Joints go there on their own; the motors would have to pass a singular configuration."""
    assert np.all(np.isfinite(ankle.actuated_of([-0.2, 0.1]).position))
    with pytest.raises(cd.SingularConfigurationError, match="do not bring pitch, roll"):
        ankle.actuated_of([1.5, 0.9])


def test_fitted_ankle(ankle: cd.Transmission, fitted: cd.FittedTransmission) -> None:
    motors, joints = RANDOM.uniform(-0.4, 0.4, (500, 2)), foot(500)
    effort = np.array([3.0, 4.0])
    for name, at in ("joints_of", motors), ("actuated_of", joints):
        of = fitted.errors[name]
        assert of.position < 1e-14 and of.jacobian < 1e-13
        one, other = (getattr(maps, name)(at, at, effort) for maps in (ankle, fitted))
        assert other.position == pytest.approx(one.position, abs=1e-14)
        assert other.speed == pytest.approx(one.speed, abs=1e-13)
        assert other.effort == pytest.approx(one.effort, rel=1e-12)
    assert fitted.jacobian(motors) == pytest.approx(ankle.jacobian(motors), abs=1e-13)
    again = pickle.loads(pickle.dumps(fitted))
    assert np.array_equal(again.joints_of(motors[0]).position, fitted.joints_of(motors[0]).position)
    # Which positions are beside one changes no bit of it.
    alone = [fitted.joints_of(each).position for each in motors[:40]]
    assert np.array_equal(fitted.joints_of(motors[:40]).position, alone)
    with pytest.raises(cd.ArgumentError, match=r"right_motor is 0\.41, outside of the range -0\.4"):
        fitted.joints_of([[0.1, 0.2], [0.1, 0.41]])


Called = Callable[..., tuple[int, Array, Array]]


def compiled(source: Path, count: int) -> Called:
    """The functions of a file: from their kind and positions to what they return and write."""
    library = source.with_suffix(".so")
    command = ["cc", "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Werror", "-O2"]
    subprocess.run([*command, "-shared", "-fPIC", source, "-o", library], check=True)
    functions = ctypes.CDLL(str(library))

    def call(name: str, at: Array, alone: bool = False) -> tuple[int, Array, Array]:
        given = np.ascontiguousarray(at, dtype=float)
        found, jacobian = np.full(count, np.nan), np.full((count, count), np.nan)
        written = [item.ctypes.data for item in (given, found, jacobian)]
        if alone:
            written[-1] = 0
        pointers = map(ctypes.c_void_p, written)
        return getattr(functions, name)(*pointers), found, jacobian

    return call


@needs_compiler
def test_ankle_in_c(ankle: cd.Transmission, fitted: cd.FittedTransmission, tmp_path: Path) -> None:
    path = fitted.write_c(tmp_path / "ankle.c", "ankle")
    text = path.read_text(encoding="utf-8")
    assert "left_motor: -0.4 to 0.4 rad" in text
    for error in fitted.errors.values():
        assert f"{error.position:.1e}" in text and f"{error.jacobian:.1e}" in text
    call = compiled(path, 2)
    for name, at in ("joints_of", RANDOM.uniform(-0.4, 0.4, (300, 2))), ("actuated_of", foot(300)):
        found = getattr(ankle, name)(at).position
        for row, values in zip(at, found, strict=True):
            status, position, _ = call(f"ankle_{name}", row)
            assert not status
            assert position == pytest.approx(values, abs=1e-14)
            status, again, nothing = call(f"ankle_{name}", row, alone=True)
            assert not status
            assert np.array_equal(again, position) and np.all(np.isnan(nothing))
    for row in RANDOM.uniform(-0.4, 0.4, (30, 2)):
        _, _, jacobian = call("ankle_joints_of", row)
        assert jacobian == pytest.approx(ankle.jacobian(row), abs=1e-13)
    for edge in [-0.4, 0.4], [0.4, 0.4]:
        assert call("ankle_joints_of", np.array(edge))[0] == 0
    outside = [[0.4000000000000001, 0.0], [0.0, -0.5], [np.nan, 0.0], [0.0, np.inf]]
    with pytest.raises(cd.ArgumentError, match="no name of a function"):
        fitted.write_c(tmp_path / "unused.c", "1st")
    with pytest.raises(cd.ArgumentError, match="name is"):
        fitted.write_c(tmp_path / "unused.c", 1)  # type: ignore[arg-type]
    with pytest.raises(cd.ArgumentError):
        fitted.write_c(tmp_path / "none" / "unused.c")
    for row in outside:
        status, *written = call("ankle_joints_of", np.array(row))
        assert status == 1
        assert all(np.all(np.isnan(item)) for item in written)


@needs_compiler
def test_one_drive_in_c(tmp_path: Path) -> None:
    """A universal joint, over a turn and a half, and a name that would end the comment."""
    text = cd.load("universal_joint").to_urdf().replace('"universal_joint"', '"uni */ joint"', 1)
    scene = cd.Scene(cd.load(text), drive="bearing_in", held={"joint_angle": 0.5})
    maps = scene.transmission("bearing_in", "bearing_out")
    ranges = {"actuated": {"bearing_in": (-6.0, 3.0)}, "joints": {"bearing_out": (-3.0, 6.0)}}
    # Where it cannot be written, nothing is fitted, so that ranges are not looked at either.
    for path, name in ("none/joint.c", "joint"), (".", "joint"), ("joint.c", "a joint"):
        with pytest.raises(cd.ArgumentError, match=r"cannot be written|no name of a function"):
            maps.write_c(tmp_path / path, name, actuated={"none": (0.0, 1.0)})
    assert not any(tmp_path.iterdir())
    call = compiled(maps.write_c(tmp_path / "joint.c", **ranges), 1)  # type: ignore[arg-type]
    for phi in np.linspace(-6.0, 3.0, 60):
        turned = np.arctan2(np.sin(phi) / np.cos(0.5), np.cos(phi))
        turned += 2.0 * np.pi * np.rint((phi - turned) / (2.0 * np.pi))
        status, found, _ = call("transmission_joints_of", np.array([phi]))
        assert not status
        assert found[0] == pytest.approx(turned, abs=1e-12)


def test_ranges_that_cannot_be_fitted(ankle: cd.Transmission) -> None:
    with pytest.raises(cd.AssemblyError, match="positions in the ranges of left_motor, right_mo"):
        ankle.fitted({"left_motor": (-1.0, 1.0)})
    with pytest.raises(cd.SingularConfigurationError, match="positions in the ranges of pitch, r"):
        ankle.fitted(joints={"pitch": (-0.3, 0.9), "roll": (0.0, 0.1)})
    # Nearly at a right angle, the joint leaps: where polynomials lead, it is a half turn off.
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 1.57})
    maps = scene.transmission("bearing_in", "bearing_out")
    with pytest.raises(cd.AccuracyError, match="give smaller ranges"):
        maps.fitted({"bearing_in": (-3.0, 3.0)}, {"bearing_out": (-3.0, 3.0)})


def test_turns_of_rods_that_a_rule_decides_are_no_joints() -> None:
    """Of a rod, hinges that follow its line have a Jacobian; those that follow its spin none."""
    platform = cd.Scene(cd.load(machines.stewart()), drive=machines.LEGS)
    hinges = [f"foot_{k}.{axis}" for k in range(3) for axis in "xy"]
    maps = platform.transmission(machines.LEGS, hinges)
    at, step = [0.03, -0.02, 0.01, 0.02, -0.01, 0.0], 1e-5 * np.eye(6)
    slopes = (maps.joints_of(at + step).position - maps.joints_of(at - step).position) / 2e-5
    np.testing.assert_allclose(maps.jacobian(at), slopes.T, atol=1e-8)
    for name in "foot_2.z", "head_0.x":
        with pytest.raises(cd.ModelError, match=f"'{name}' belongs to a rod that spins idly"):
            platform.transmission(machines.LEGS, [*hinges[:-1], name])
    ankle = cd.Scene(cd.load(machines.ankle()), drive=["motor_l", "motor_r"])
    with pytest.raises(cd.ModelError, match=r"'upper_r\.y'"):
        ankle.transmission(["motor_l", "motor_r"], ["pitch", "upper_r.y"])
    with pytest.raises(cd.ModelError, match=r"'upper_r\.y'"):
        ankle.transmission(["motor_l", "upper_r.y"], ["pitch", "roll"])


def test_hexapod_by_leg_lengths() -> None:
    base, top = transmissions.hexapod_points()
    scene = cd.Scene(cd.load(transmissions.hexapod()), drive=LEGS)
    legs = scene.transmission(LEGS, "pose")
    assert len(legs.joints) == 6
    t = np.array([0.0, 2.0])
    place = np.stack([0.05 * np.sin(t), 0.04 * np.cos(t), 0.03 * np.sin(2 * t)], axis=-1)
    angles = np.stack([0.1 * np.sin(t), 0.08 * np.cos(t), 0.15 * np.sin(0.5 * t)], axis=-1)
    # Lengths of Stewart legs with 50 digits, for R = Rz Ry Rx.
    lengths = np.reshape(
        [
            *(0.665178443569155, 0.682158809109316, 0.66843075162175),
            *(0.688659598473852, 0.726085728748109, 0.69055762509639),
            *(0.620931170760079, 0.684615916785135, 0.69658143788232),
            *(0.693145129909101, 0.63270716374871, 0.68483276091718),
        ],
        (2, 6),
    )
    start = np.linalg.norm(top + np.array([0.0, 0.0, 0.6]) - base, axis=1)
    for number in range(2):
        about = [turn(axis, angles[number, axis]) for axis in range(3)]
        x, y, z = cardan(about[2] @ about[1] @ about[0])
        pose = np.array([*place[number], x, y, z])
        found = legs.actuated_of(pose, np.arange(6.0), np.ones(6))
        assert found.position + start == pytest.approx(lengths[number], abs=1e-14)
        back = legs.joints_of(*found)
        assert back.position == pytest.approx(pose, abs=1e-13)
        assert back.speed == pytest.approx(np.arange(6.0), abs=1e-12)
        assert back.effort == pytest.approx(np.ones(6), abs=1e-12)


def turn(axis: int, angle: float) -> Array:
    cross = np.cross(np.eye(3), np.eye(3)[axis])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def cardan(rotation: Array) -> tuple[float, float, float]:
    """Angles of Rx Ry Rz."""
    return (
        float(np.arctan2(-rotation[1, 2], rotation[2, 2])),
        float(np.arcsin(rotation[0, 2])),
        float(np.arctan2(-rotation[0, 1], rotation[0, 0])),
    )


def test_differential() -> None:
    scene = cd.Scene(cd.load(transmissions.differential()), drive=["motor_1", "motor_2"])
    maps = scene.transmission(["motor_1", "motor_2"], ["pitch", "roll"])
    by_joints = np.array([[1.0, 1.5], [1.0, -1.5]])
    motors = RANDOM.uniform(-20.0, 20.0, (50, 2))
    found = maps.joints_of(motors, motors, [1.0, 2.0])
    joints = np.linalg.solve(by_joints, motors.T).T
    assert found.position == pytest.approx(joints, abs=1e-13)
    assert found.speed == pytest.approx(joints, abs=1e-13)
    assert found.effort == pytest.approx(np.tile(by_joints.T @ [1.0, 2.0], (50, 1)), abs=1e-13)
    assert not np.any(np.abs(maps.jacobian_rate(motors, [3.0, 4.0])) > 1e-12)
    # Carrier, gears and output turn about pitch; gears 1.5 times as fast as the output about it.
    about_pitch = 2e-3 + 2e-3 + 2 * 2e-4
    of_joints = np.array([[about_pitch, 0.0], [0.0, 3e-3 + 2 * 1.5**2 * 2e-4]])
    reflected = np.linalg.inv(by_joints).T @ of_joints @ np.linalg.inv(by_joints)
    assert maps.reflected_inertia([0.3, 0.3]) == pytest.approx(reflected, abs=1e-16)


def test_a_cylinder_that_pulls_less_than_it_pushes_does_so_at_the_joint() -> None:
    """Its arm is the ratio of speeds; where it shortens as the boom rises, both ends change."""
    text = transmissions.boom().replace('effort="120000"', 'effort="120000" least_effort="-8e4"')
    scene = cd.Scene(cd.load(text), drive="stroke")
    boom, stroke = scene.transmission("stroke", "boom_pin"), np.linspace(-0.3, 0.2, 5)
    per_stroke = 1.0 / boom.joints_of(stroke, 1.0).speed
    ends = np.sort(np.multiply.outer(per_stroke, [-8e4, 1.2e5]), axis=-1)
    assert boom.effort_limits(stroke) == pytest.approx(ends, rel=1e-12)
    (joint,) = boom.reduced(boom.joints_of(0.0).position).mechanism.description.joints
    least, greatest = joint.limits.efforts
    assert [least, greatest] == pytest.approx(boom.effort_limits(0.0), rel=1e-12)
    assert least != -greatest
    with pytest.raises(cd.ArgumentError, match="give one position of boom_pin"):
        boom.reduced([0.1])


def test_boom_with_a_cylinder() -> None:
    """Law of cosines between boom's pin, cylinder's pin and piston's pin; moment by the arm."""
    scene = cd.Scene(cd.load(transmissions.boom()), drive="stroke", gravity=(0.0, 0.0, -9.81))
    boom = scene.transmission("stroke", "boom_pin")
    x, z = transmissions.BOOM
    side, far = float(np.hypot(x, z)), transmissions.POST
    first = np.sqrt(
        side**2 + far**2 - 2 * side * far * np.cos(transmissions.ARM - np.arctan2(z, x))
    )
    stroke = np.linspace(-0.3, 0.2, 11)
    inside = np.arccos((side**2 + far**2 - (first + stroke) ** 2) / (2 * side * far))
    angle = inside - transmissions.ARM + np.arctan2(z, x)
    arm = side * far * np.sin(inside) / (first + stroke)
    found = boom.joints_of(stroke, 0.3, 3e4)
    assert found.position == pytest.approx(angle, abs=1e-13)
    assert found.speed == pytest.approx(0.3 / arm, rel=1e-13)
    assert found.effort == pytest.approx(3e4 * arm, rel=1e-13)
    assert boom.effort_limits(stroke)[:, 1] == pytest.approx(1.2e5 * arm, rel=1e-13)
    assert boom.speed_limits(stroke) == pytest.approx(
        np.stack([-0.4 / arm, 0.4 / arm], axis=-1), rel=1e-13
    )
    assert boom.singular_values(stroke)[:, 0] == pytest.approx(
        scene.mechanism.characteristic_length / arm, rel=1e-13
    )
    fit = boom.fitted({"stroke": (-0.3, 0.2)}, {"boom_pin": (angle[0], angle[-1])})
    assert fit.actuated_of(angle[1:-1]).position == pytest.approx(stroke[1:-1], abs=1e-12)


def test_four_bar_knee() -> None:
    """The crank's second rate, from a table of 50 digits; borders where crank and coupler align."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    knee = scene.transmission("crank_bearing", "rocker_bearing")
    at = np.radians(60.0)
    # With ω = 20 and α = 5, the rocker of the same lengths has 119.13243205445085 rad/s².
    ratio = 0.1845104442283111
    assert knee.jacobian(at) == pytest.approx(np.array([[ratio]]), rel=1e-13)
    rate = (119.13243205445085 - 5.0 * ratio) / 20.0
    assert knee.jacobian_rate(at, 20.0) == pytest.approx(np.array([[rate]]), rel=1e-13)
    # Crank 80, coupler 400, rocker 250, frame 470 mm: crank and coupler in line at 480 and 320.
    along = [
        np.arccos((470**2 + length**2 - 250**2) / (2 * 470 * length)) + turned
        for length, turned in ((480.0, 0.0), (320.0, np.pi))
    ]
    found = knee.borders(0.0, 2.0 * np.pi)
    assert [item.kind for item in found] == [1, 1]
    assert [item.position for item in found] == pytest.approx(along, abs=1e-12)
    # The rocker turns back there: its ends, counted from the start, by the same triangles.
    back = scene.transmission("rocker_bearing", "crank_bearing")
    inside = [np.arccos((470**2 + 250**2 - length**2) / (2 * 470 * 250)) for length in (480, 320)]
    ends = np.array([item.position for item in back.borders(-1.5, 1.5)])
    assert [item.kind for item in back.borders(-1.5, 1.5)] == [2, 2]
    assert np.ptp(ends) == pytest.approx(np.ptp(inside), abs=1e-13)
    assert ends == pytest.approx(np.sort(knee.joints_of(along).position), abs=1e-13)
    # Beyond them, another crank position brings the rocker to the same place.
    there = knee.joints_of(2.0).position
    back = knee.actuated_of(there).position
    assert knee.joints_of(back).position == pytest.approx(there, abs=1e-13)
    assert along[1] - 2.0 * np.pi < back < along[0]


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_bundled_mechanisms(name: str) -> None:
    preset = PRESETS[name]
    held = {joint: np.radians(angle) for joint, angle in preset.held_deg.items()}
    scene = cd.Scene(cd.load(name), drive=list(preset.drive), held=held)
    near = RANDOM.uniform(-0.02, 0.02, (3, len(scene.drives)))
    motion = scene.sweep(near).motion
    moving = [
        joint
        for joint in scene.mechanism.drivable
        if joint not in held
        and scene.mechanism.joints[scene.mechanism.drivable[joint].joint].type != "spherical"
        and np.min(np.abs(motion.ratio(joint, 0))) > 0.1
    ]
    tried = 0
    unit = np.zeros(len(near[0]))
    unit[0] = 1.0
    feels = scene.sweep(near, acceleration=unit).drive_effort.reshape(near.shape)
    for joint in moving[:2]:
        wanted = [joint, *scene.drives[1:]]
        maps = scene.transmission(scene.drives, wanted)
        size = 1e-13 * np.abs(feels).max()
        assert maps.reflected_inertia(near)[..., 0] == pytest.approx(feels, abs=size)
        forth = maps.joints_of(near, 1.0 + 0.0 * near, 2.0 + 0.0 * near)
        assert forth.position[:, 0] == pytest.approx(motion.position(joint), abs=1e-12)
        try:
            back = maps.actuated_of(*forth)
        except cd.SingularConfigurationError:
            continue  # The scene starts where this joint decides nothing.
        tried += 1
        assert back.position == pytest.approx(near, abs=1e-11)
        assert back.speed == pytest.approx(1.0 + 0.0 * near, abs=1e-11)
        assert back.effort == pytest.approx(2.0 + 0.0 * near, abs=1e-10)
    assert tried


def test_what_floats_may_be_found() -> None:
    scene = cd.Scene(cd.load(transmissions.hexapod()), drive=LEGS)
    legs = RANDOM.uniform(-0.02, 0.02, (3, 6))
    assert scene.transmission(LEGS, LEGS).joints_of(legs).position == pytest.approx(legs)


def test_other_assembly_modes_and_starts() -> None:
    bar = cd.load("four_bar")
    for scene in (
        cd.Scene(bar, drive="crank_bearing", branch="B"),
        cd.Scene(bar, drive="crank_bearing", near={"crank_bearing": 2.0}),
        cd.Scene(bar, free="crank_bearing"),
        cd.Scene(bar, drive="rocker_bearing"),
        cd.Scene(cd.load(bar.to_urdf()), drive="crank_bearing", outputs=[]),
    ):
        maps = scene.transmission("crank_bearing", "rocker_bearing")
        at = scene.configuration()["crank_bearing"]
        start = maps.joints_of(at).position
        assert start == pytest.approx(scene.configuration()["rocker_bearing"], abs=1e-13)
        assert maps.actuated_of(start).position == pytest.approx(at, abs=1e-12)


def test_a_leg_of_a_floating_robot() -> None:
    mechanism = cd.load(transmissions.ankle_on_a_base())
    base: dict[str, Any] = {"base": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}
    joints = foot(5)
    motors = np.stack(transmissions.ankle_motors(*joints.T), axis=-1)
    for held in base, {**base, "length": 0.07}:
        scene = cd.Scene(mechanism, drive=MOTORS, held=held)
        maps = scene.transmission(MOTORS, FOOT)
        assert maps.actuated_of(joints).position == pytest.approx(motors, abs=1e-13)
        tree = maps.reduced()
        left = tree.left_out(joints)
        whole, alone = (
            cd.Scene(item, drive=FOOT, held=held).sweep(joints, acceleration=1.0).drive_effort
            for item in (mechanism, tree.mechanism)
        )
        assert whole - alone == pytest.approx(left.inertia.sum(axis=-1), abs=1e-15)
    with pytest.raises(cd.MobilityError, match="8 decide where the mechanism is; name as many"):
        cd.Scene(mechanism, drive=["base", *MOTORS]).transmission(MOTORS, FOOT)
    # Or what floats is on both sides.
    maps = cd.Scene(mechanism, free=["base", *MOTORS]).transmission(
        ["base", *MOTORS], ["base", *FOOT]
    )
    at = np.array([0.1, 0.2, 0.3, 0.1, 0.2, 0.3])
    found = maps.actuated_of(np.concatenate([at, joints[0]]))
    assert found.position == pytest.approx(np.concatenate([at, motors[0]]), abs=1e-13)


def test_an_ankle_in_one_joint(ankle: cd.Transmission) -> None:
    scene = cd.Scene(cd.load(transmissions.ankle_in_one_joint()), drive=MOTORS)
    maps = scene.transmission(MOTORS, "both")
    assert maps.joints == ("both.turn_1", "both.turn_2")
    joints = foot(5)
    assert maps.actuated_of(joints).position == pytest.approx(
        ankle.actuated_of(joints).position, abs=1e-13
    )
    one, two = ankle.reduced().armature, maps.reduced().armature
    assert list(one.values()) == pytest.approx(list(two.values()), rel=1e-13)
    (joint,) = maps.reduced().mechanism.description.joints
    assert joint.armature == pytest.approx(tuple(two.values()))
    # With one of its coordinates held, the joint keeps the armature that it has there.
    roll = scene.replace(drive="left_motor", held={"both.turn_1": 0.1})
    tree = roll.transmission("left_motor", "both.turn_2").reduced()
    (joint,) = tree.mechanism.description.joints
    assert joint.armature == (0.0, tree.armature["both.turn_2"])
    with pytest.raises(cd.ModelError, match="both cannot be kept"):
        scene.transmission(MOTORS, ["both.turn_1", "left_motor"]).reduced()


def test_what_pinocchio_loaded(ankle: cd.Transmission) -> None:
    first = cd.load(transmissions.ankle())
    mechanism = cd.from_pinocchio(first.model, first.constraint_models)
    scene = cd.Scene(mechanism, drive=MOTORS, gravity=(0.0, 0.0, -9.81))
    maps, joints = scene.transmission(MOTORS, FOOT), foot(5)
    assert maps.actuated_of(joints).position == pytest.approx(
        ankle.actuated_of(joints).position, abs=1e-12
    )


def test_held_joints_differ_by_sample() -> None:
    """A universal joint at several angles, by its closed form."""
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5})
    maps = scene.transmission("bearing_in", "bearing_out")
    phi, angles = np.linspace(-1.2, 1.2, 7), np.array([[0.0], [0.3], [0.5]])
    turned = np.arctan2(np.sin(phi), np.cos(phi) * np.cos(angles))
    ratio = np.cos(angles) / (1.0 - np.sin(angles) ** 2 * np.cos(phi) ** 2)
    held = {"joint_angle": angles}
    found = maps.joints_of(phi, speed=2.0, effort=3.0, held=held)
    assert found.position == pytest.approx(turned, abs=1e-14)
    assert found.speed == pytest.approx(2.0 * ratio, abs=1e-13)
    assert found.effort == pytest.approx(3.0 / ratio, abs=1e-13)
    assert maps.jacobian(phi, held)[..., 0, 0] == pytest.approx(ratio, abs=1e-14)
    assert maps.actuated_of(turned, held=held).position == pytest.approx(
        np.broadcast_to(phi, turned.shape), abs=1e-13
    )
    one = maps.joints_of(0.7, held={"joint_angle": 0.3}).position
    assert np.shape(one) == () and one == pytest.approx(
        np.arctan2(np.sin(0.7), np.cos(0.7) * np.cos(0.3))
    )
    with pytest.raises(cd.ArgumentError, match="what is fitted holds"):
        range_ = (-1.0, 1.0)
        maps.fitted({"bearing_in": range_}, {"bearing_out": range_}).joints_of(0.0, held=held)


def test_fitted_linear_maps() -> None:
    motors = ["motor_1", "motor_2"]
    scene = cd.Scene(cd.load(transmissions.differential()), drive=motors)
    maps = scene.transmission(motors, FOOT)
    ranges = dict.fromkeys(motors, (-3.0, 2.0)), dict.fromkeys(FOOT, (-1.0, 1.0))
    fit = maps.fitted(*ranges)
    assert fit.jacobian([[1.0, 2.0], [0.0, 0.0]]) == pytest.approx(maps.jacobian(np.eye(2)))
    assert fit.ranges["motor_1"] == (-3.0, 2.0)
    assert maps.reduced().armature == pytest.approx({"pitch": 4e-4, "roll": 2 * 1.5**2 * 2e-4})
    same = scene.transmission(motors, motors[::-1]).fitted(ranges[0], ranges[0])
    assert np.array_equal(same.jacobian([1.0, 1.0]).round(12), [[0.0, 1.0], [1.0, 0.0]])


@needs_compiler
@pytest.mark.parametrize("count", [pytest.param(3, marks=pytest.mark.slow), 6])
def test_hexapod_in_c(count: int, tmp_path: Path) -> None:
    """The way back by hand: a leg is as long as its ball is far from its foot."""
    driven = LEGS[:: 6 // count]
    held = {leg: 0.0 for leg in LEGS if leg not in driven}
    scene = cd.Scene(cd.load(transmissions.hexapod()), drive=driven, held=held)
    names = [f"pose.{name}" for name in ("x", "y", "z", "turn_x", "turn_y", "turn_z")]
    names = names if count == 6 else names[2:5]
    maps = scene.transmission(driven, names)
    ranges = dict.fromkeys(driven, (-0.03, 0.03)), dict.fromkeys(names, (-0.02, 0.02))
    fit = maps.fitted(*ranges)
    assert max(error.position for error in fit.errors.values()) < 1e-14
    call = compiled(fit.write_c(tmp_path / "hexapod.c"), count)
    base, top = transmissions.hexapod_points()
    legs = RANDOM.uniform(-0.03, 0.03, (100, count))
    poses = maps.joints_of(legs).position
    for row, wanted in zip(legs, poses, strict=True):
        status, found, jacobian = call("transmission_joints_of", row)
        assert not status
        assert found == pytest.approx(wanted, abs=1e-14)
        assert jacobian == pytest.approx(maps.jacobian(row), abs=1e-13)
    for row in RANDOM.uniform(-0.02, 0.02, (100, count)) if count == 6 else ():
        status, found, _ = call("transmission_actuated_of", row)
        assert not status
        turn = Rotation.from_euler("XYZ", row[3:])
        height = np.array([0.0, 0.0, 0.6])
        balls = turn.apply(top) + row[:3] + height
        lengths, first = (np.linalg.norm(ends - base, axis=1) for ends in (balls, top + height))
        assert found == pytest.approx(lengths - first, abs=1e-15)


def test_copies_and_pickles(ankle: cd.Transmission) -> None:
    again = pickle.loads(pickle.dumps(ankle))
    assert repr(again) == repr(ankle)
    assert np.array_equal(again.jacobian([0.1, 0.2]), ankle.jacobian([0.1, 0.2]))


def test_refusals(ankle: cd.Transmission) -> None:
    scene = cd.Scene(cd.load(transmissions.ankle()), drive=MOTORS)
    with pytest.raises(cd.ModelError, match="rihgt"):
        scene.transmission(["left_motor", "rihgt"], FOOT)
    with pytest.raises(cd.MobilityError, match="joints names 1 coordinates, and 2 decide"):
        scene.transmission(MOTORS, "pitch")
    with pytest.raises(cd.MobilityError, match="joints names 1 coordinates"):
        scene.transmission(MOTORS, ["pitch", "pitch"])
    with pytest.raises(cd.MobilityError):
        scene.transmission(["left_motor", "left_top.x"], FOOT)
    dependent = scene.transmission(MOTORS, ["left_motor", "left_top.x"])
    with pytest.raises(cd.MobilityError):
        dependent.actuated_of([0.0, 0.0])
    with pytest.raises(cd.ArgumentError, match="held"):
        scene.replace(held={"roll": 0.0}, drive="left_motor").transmission("left_motor", "roll")
    with pytest.raises(cd.ArgumentError, match=r"actuated is not finite at index \[1\]"):
        ankle.joints_of([0.0, np.nan])
    with pytest.raises(cd.ArgumentError, match=r"joints has shape \(\), expected \(..., 2\)"):
        ankle.actuated_of(0.0)
    with pytest.raises(cd.ArgumentError, match=r"speed has shape \(3,\)"):
        ankle.joints_of([0.0, 0.0], speed=[1.0, 2.0, 3.0])
    with pytest.raises(cd.ArgumentError, match="roll"):
        ankle.joints_of([0.0, 0.0], held={"roll": 0.0})
    with pytest.raises(AttributeError, match="joints_of"):
        ankle.forward_kinematics  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"scene\.transmission"):
        scene.motor_map  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(cd.ArgumentError, match="limits"):
        ankle.speed_limits([0.0, 0.0], [1.0, -1.0])
    with pytest.raises(cd.ArgumentError, match=r"limits has shape \(3,\), expected \(2,\)"):
        ankle.speed_limits([0.0, 0.0], [1.0, 1.0, 1.0])
    with pytest.raises(cd.ModelError, match="pithc"):
        ankle.fitted(joints={"pithc": (0.0, 1.0)})
    with pytest.raises(cd.ArgumentError, match="is no range"):
        ankle.fitted(joints={"pitch": (0.1, 0.1)})
    with pytest.raises(cd.ArgumentError, match="nothing of the line"):
        ankle.borders([2.0, 2.0], [3.0, 3.0])
    bar = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    knee = bar.transmission("crank_bearing", "rocker_bearing")
    with pytest.raises(cd.ArgumentError, match="does not limit velocity"):
        knee.speed_limits(0.0)
    with pytest.raises(cd.ArgumentError, match="say between which positions"):
        knee.fitted()
    with pytest.raises(cd.ModelError, match="cannot be kept without motors and loops"):
        bar.transmission("crank_bearing", "rocker_pin").reduced()


def test_reduced_tree(ankle: cd.Transmission, tmp_path: Path) -> None:
    reduced = ankle.reduced()
    assert reduced.cut == ("left_crank", "left_rod", "right_crank", "right_rod")
    assert sorted(reduced.mechanism.joints) == FOOT
    joints = foot(10)
    gravity = (1.0, 2.0, -9.81)
    # What the tree has and what it leaves out is the whole, at the joints.
    whole = cd.Scene(cd.load(transmissions.ankle()), drive=FOOT, gravity=gravity)
    left = reduced.left_out(joints, gravity)
    for path in tmp_path / "ankle.urdf", tmp_path / "ankle.xml":
        cd.write(reduced.mechanism, path)
        tree = cd.Scene(cd.load(path), drive=FOOT, gravity=gravity)
        for one in np.eye(2):
            every, alone = (
                scene.sweep(joints, acceleration=one).drive_effort for scene in (whole, tree)
            )
            assert every - alone == pytest.approx(left.gravity + left.inertia @ one, abs=1e-14)
    # Each joint can do what motors do to it, as URDF and the motors of MJCF say.
    corners = ankle.effort_limits([0.0, 0.0]), ankle.speed_limits([0.0, 0.0])
    most = [np.abs(each).max(axis=0) for each in corners]
    written = cd.load(tmp_path / "ankle.urdf").description.joints
    limits = [(joint.limits.effort, joint.limits.velocity) for joint in written]
    assert np.all(np.array(limits) < [100.0, 20.0])  # Which are those of the joints.
    assert [*zip(*limits, strict=True)] == [pytest.approx(of, rel=1e-12) for of in most]
    driven = ElementTree.parse(tmp_path / "ankle.xml").findall("actuator/motor")
    ranges = [[float(word) for word in motor.get("ctrlrange", "").split()] for motor in driven]
    assert ranges == [pytest.approx([-effort, effort]) for effort in most[0]]
    # Where it was made, only the coupling of joints is left out.
    there = ankle.reduced([0.1, -0.1])
    assert np.diagonal(there.left_out([0.1, -0.1]).inertia) == pytest.approx([0.0, 0.0], abs=1e-16)
    motors = ankle.actuated_of([0.1, -0.1]).position
    backward = np.linalg.inv(ankle.jacobian(motors))
    of_motors = ankle.reflected_inertia(motors)
    tree = cd.Scene(there.mechanism, drive=FOOT)
    of_tree = np.array([tree.sweep([0.1, -0.1], acceleration=a).drive_effort[0] for a in np.eye(2)])
    total = of_tree + there.left_out([0.1, -0.1]).inertia
    assert total == pytest.approx(backward.T @ of_motors @ backward, abs=1e-15)
