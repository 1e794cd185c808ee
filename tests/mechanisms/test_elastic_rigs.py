"""Elastic rigs: the numbers of their headers in their equations of motion, and what they do."""

from __future__ import annotations

import re

import numpy as np
import pytest
from testkit.elastic_rigs import scene
from testkit.urdf_reader import Reader, text

import cardan_dyn as cd
from cardan_dyn import vibration
from cardan_dyn.analytic import whirl

LINES = ("torsional_line_front", "torsional_line_behind", "torsional_line_both")
STEEL_IN_SHEAR = 8e10


def matrices(rig: cd.Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, damping and stiffness of the free coordinates at rest, from one sweep."""
    free = len(rig.free)
    unit = np.eye(free)
    zero = np.zeros_like(unit)
    # Small, so that a twist or tilt changes nothing else.
    small = 1e-6
    parts = [
        np.concatenate([np.zeros((3 * free, 1)), np.concatenate(rows)], axis=1)
        for rows in ((zero, zero, small * unit), (zero, small * unit, zero), (unit, zero, zero))
    ]
    turn = rig.replace(drive=rig.coordinates).sweep(parts[0], speed=parts[1], acceleration=parts[2])
    efforts = turn.drive_effort[:, 1:]
    mass, damping, stiffness = efforts[:free], efforts[free : 2 * free], efforts[2 * free :]
    return mass, damping / small, stiffness / small


def frequencies(rig: cd.Scene) -> np.ndarray:
    mass, _, stiffness = matrices(rig)
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))


def stated(name: str, pattern: str) -> list[float]:
    """Numbers that the header of a description states."""
    found = re.search(pattern, " ".join(text(name).split("-->")[0].split()))
    assert found is not None, pattern
    return [float(group) for group in found.groups()]


def test_tilting_shaft_has_the_numbers_of_its_header() -> None:
    name = "elastic_thoma_rig"
    rig = scene(name, 0.0)
    assert rig.coordinates == ("bearing_in", "tilt_z", "tilt_y")
    mass, damping, stiffness = matrices(rig)
    ((stiff, damped),) = [stated(name, r"= (\d+) N·m/rad with the damping ([\d.]+) N·m·s/rad")]
    diametral, polar = stated(name, r"A = ([\d.]+) kg·m² .* Θ = ([\d.]+) kg·m²")
    (ratio, frequency) = stated(name, r"Θ / A = ([\d.]+): .* = ([\d.]+) rad/s")
    np.testing.assert_allclose(stiffness, stiff * np.eye(2), rtol=1e-6, atol=1e-6 * stiff)
    assert stiff == pytest.approx(1.6e5 * (0.1**2 + 0.54**2), rel=1e-12)
    np.testing.assert_allclose(damping, damped * np.eye(2), rtol=1e-6, atol=1e-6)
    # The ears of its fork make it a trace stiffer about one axis than about the other.
    assert np.diag(mass) == pytest.approx(diametral, rel=2e-4)
    shaft = Reader(text(name)).body("shaft_out")
    assert shaft is not None
    assert shaft.inertia[0, 0] == pytest.approx(polar, abs=5e-5)
    assert polar / diametral == pytest.approx(ratio, abs=5e-4)
    assert frequencies(rig) == pytest.approx(frequency, rel=3e-4)
    assert damped / (2.0 * np.sqrt(stiff * diametral)) == pytest.approx(0.01, rel=2e-3)


def test_elastic_shafts_have_the_stiffness_of_their_dimensions() -> None:
    """k = G π d⁴ / (32 l) of both halves that the description shows."""
    for name in (*LINES, "elastic_double_shaft"):
        robot = Reader(text(name)).robot
        halves = [
            float(half.get("length", "nan"))
            for visual in robot.iter("visual")
            if visual.get("name") == "elastic_shaft_half"
            for half in visual.iter("cylinder")
            if half.get("radius") == "0.0125"
        ]
        springs = [float(item.get("spring_stiffness", "nan")) for item in robot.iter("dynamics")]
        assert len(halves) == 2 * len(springs) > 0
        expected = STEEL_IN_SHEAR * np.pi * 0.025**4 / 32.0 / (2.0 * halves[0])
        assert springs == pytest.approx([expected] * len(springs), rel=1e-11)


@pytest.mark.parametrize("name", [*LINES, "elastic_double_shaft"])
def test_natural_frequencies_are_those_of_the_headers(name: str) -> None:
    pattern = (
        r"frequencies ([\d.]+) and ([\d.]+) rad/s"
        if name == "torsional_line_both"
        else r"frequency sqrt\(.*?\) = ([\d.]+) rad/s"
    )
    assert frequencies(scene(name, 0.0)) == pytest.approx(stated(name, pattern), abs=0.06)


def test_tilting_shaft_follows_the_rotor_with_gyroscopic_term() -> None:
    """Efforts that keep shaft 2 upright are the moments that its whirl has to follow."""
    beta, speed = np.radians(5.0), 140.0
    rig = scene("elastic_thoma_rig", float(beta))
    position = np.zeros((64, 3))
    position[:, 0] = 2.0 * np.pi * np.arange(64) / 64
    turn = rig.replace(drive=rig.coordinates).sweep(position, speed=np.array([speed, 0.0, 0.0]))
    # s = -(tilt_z - i tilt_y), see `analytic.whirl`; what is missing has the other sign.
    moment = np.fft.fft(turn.drive_effort[:, 1] - 1j * turn.drive_effort[:, 2]) / 64
    shaft = Reader(text("elastic_thoma_rig")).body("shaft_out")
    assert shaft is not None
    for order in (2, 4):
        expected = whirl.moments_of_flywheel(beta, order, shaft.inertia[0, 0], speed)
        assert abs(moment[order] - expected.forward) < 1e-9 * abs(expected.forward)
        assert abs(moment[-order] - expected.backward) < 1e-9 * abs(expected.forward)


BETAS = np.radians([1.0, 5.0, 20.0, 45.0, 60.0, 80.0, 88.0])
TORQUE = 100.0


def bending(output_torque: str) -> tuple[cd.Sweep, np.ndarray]:
    """Sweep at rest, and moments M_x, M_z `(B, 64)` of the joint on shaft 2, in axes that rest.

    e_x lies across shaft 2 in the plane of the shafts, e_z normal to it, see `analytic.whirl`.
    """
    rig = scene("elastic_thoma_rig", 0.1)
    position = np.zeros((1, 64, 3))
    position[..., 0] = 2.0 * np.pi * np.arange(64) / 64
    held = {"joint_angle": BETAS[:, None]}
    ratio = (
        rig.replace(drive=rig.coordinates).sweep(position, held=held).motion.ratio("bearing_out")
    )
    # Virtual work: what shaft 2 carries, times how much faster it turns, is what shaft 1 does.
    loads = -TORQUE / ratio if output_torque == "even input" else np.full(ratio.shape, -TORQUE)
    turn = rig.replace(drive=rig.coordinates).sweep(
        position, held=held, loads={"bearing_out": loads}
    )
    moment = turn.wrench("pin_out", "world").moment
    in_plane = np.stack([np.sin(BETAS), -np.cos(BETAS), 0.0 * BETAS], axis=1)
    return turn, np.stack([np.einsum("bpi,bi->bp", moment, in_plane), -moment[..., 2]])


def test_a_constant_input_torque_bends_shaft_2_without_a_fourth_order() -> None:
    """M_x = T sin β (1 + cos 2φ)/2, M_z = T tan β sin 2φ/2 at every joint angle."""
    turn, (bend_x, bend_z) = bending("even input")
    np.testing.assert_allclose(turn.drive_effort[..., 0], TORQUE, rtol=1e-12)
    phi = 2.0 * np.pi * np.arange(64) / 64
    sine, tangent = np.sin(BETAS)[:, None], np.tan(BETAS)[:, None]
    scale = TORQUE * tangent
    expected_x = TORQUE * sine * (1.0 + np.cos(2.0 * phi)) / 2.0
    assert np.max(np.abs(bend_x - expected_x) / scale) < 1e-12
    assert np.max(np.abs(bend_z - scale * np.sin(2.0 * phi) / 2.0) / scale) < 1e-12
    orders = np.abs(np.fft.fft(bend_z - 1j * bend_x) / 64) / scale
    assert np.max(orders[:, [4, -4, 6, -6, 8, -8]]) < 1e-12
    # The second is there, forwards almost alone.
    assert np.min(orders[:, 2]) > 0.25 and np.all(orders[:2, -2] < 1e-2 * orders[:2, 2])


def test_a_constant_output_torque_bends_it_by_orders_that_whirl_forwards() -> None:
    """Orders 2 and 4 in the ratio tan²(β/2): 0.0019 at 5°, 0.031 at 20°; none backwards."""
    turn, (bend_x, bend_z) = bending("even output")
    assert np.all(np.ptp(turn.drive_effort[1:, :, 0], axis=1) > 1e-3 * TORQUE)
    series = np.fft.fft(bend_z - 1j * bend_x) / 64
    # At angles whose series is short enough for 64 positions.
    small = BETAS < 1.1
    ratio = np.abs(series[small, 4] / series[small, 2])
    np.testing.assert_allclose(ratio, np.tan(BETAS[small] / 2.0) ** 2, rtol=1e-9)
    assert ratio[1:3] == pytest.approx([0.0019, 0.031], rel=0.01)
    backward = np.abs(series[small][:, [-2, -4]]) / (TORQUE * np.tan(BETAS[small]))[:, None]
    assert np.max(backward) < 1e-12
    expected = whirl.moments_of_output_torque(BETAS[small], 2, TORQUE).forward
    np.testing.assert_allclose(series[small, 2], expected, rtol=1e-12)


def growth(name: str, ratio: float) -> float:
    """How much greater the twist without damping is in the second half of twenty revolutions."""
    rig = scene(name, float(np.radians(20.0)))
    speed = ratio * float(frequencies(rig.replace(held=dict.fromkeys(rig.held, 0.0)))[0])
    springs = [element for element in rig.elements if not str(element.name).startswith("damping")]
    undamped = rig.replace(elements=springs)
    run = undamped.simulate(40.0 * np.pi / speed, motion={"bearing_in": speed})
    twist = np.abs(run.at(np.linspace(0.0, run.time[-1], 4001)).motion.position(rig.free[0]))
    return float(np.max(twist[2000:]) / np.max(twist[:2000]))


@pytest.mark.slow
def test_spring_in_front_grows_near_its_natural_frequency() -> None:
    assert growth("torsional_line_front", 1.0) > 2.0
    assert growth("torsional_line_front", 1.1) < 1.05


@pytest.mark.slow
def test_spring_behind_never_grows() -> None:
    assert growth("torsional_line_behind", 1.0) < 1.05


@pytest.mark.slow
def test_phased_double_shaft_grows_near_its_natural_frequency() -> None:
    assert growth("elastic_double_shaft", 1.0) > 2.0
    assert growth("elastic_double_shaft", 1.1) < 1.05


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "speed"),
    [
        ("elastic_thoma_rig", 139.0),
        ("torsional_line_front", 150.0),
        ("torsional_line_behind", 100.0),
        ("torsional_line_both", 150.0),
        ("elastic_double_shaft", 100.0),
    ],
)
def test_simulations_stay_on_the_periodic_motion(name: str, speed: float) -> None:
    """Started on it, a simulation over two revolutions goes along it, within 1e-8 of its size."""
    rig = scene(name, float(np.radians(8.5)))
    motion = vibration.periodic_motion(rig, speed)
    start = motion.at([0.0])
    run = rig.simulate(
        4.0 * np.pi / speed,
        position=dict(zip(rig.free, start.position[0, 0], strict=True)),
        speed=dict(zip(rig.free, start.velocity[0, 0], strict=True)),
        motion={"bearing_in": speed},
        rtol=1e-11,
        atol=1e-13,
    )
    times = np.linspace(0.0, run.time[-1], 50)
    expected = motion.at(speed * times).position[0]
    found = run.at(times).motion
    simulated = np.stack([found.position(free) for free in rig.free], axis=1)
    assert np.max(np.abs(simulated - expected)) < 1e-8 * np.max(np.abs(expected))


@pytest.mark.slow
def test_speeds_at_which_motions_are_too_large_are_marked() -> None:
    """At its second order and 20° the twist of the double shaft would exceed a radian."""
    rig = scene("elastic_double_shaft", float(np.radians(20.0)))
    found = vibration.campbell(rig, np.array([130.0, 146.0]))
    assert np.isfinite(found.frequency[0]).all() and np.isnan(found.frequency[1]).all()
    speeds = np.linspace(130.0, 160.0, 7)
    (row,) = vibration.critical_speeds(rig, speeds, orders=(2,), instabilities=False)
    (natural,) = frequencies(scene("elastic_double_shaft", 0.0))
    assert row.speed == pytest.approx(natural / 2.0, rel=0.05)
    assert row.outcome == "open" and row.severity > 0.9
