"""Thoma's rig from its description: torque and bending of shaft 2 by its flywheel alone."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.urdf_reader import Reader, edited, text

import cardan_dyn as cd
from cardan_dyn.analytic import single_joint, thoma

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 721)
SPEED = 2.0 * np.pi * 50.0
ANGLES = np.radians([8.5, 20.0, 45.0])


def sweep(beta: float, urdf: str = "thoma_rig") -> cd.Sweep:
    scene = cd.Scene(cd.load(urdf), drive="bearing_in", held={"joint_angle": beta})
    return scene.sweep(POSITIONS, speed=SPEED)


def flywheel() -> float:
    """Moment of inertia Θ of shaft 2 with its flywheel about its axis, from the file."""
    shaft = Reader(text("thoma_rig")).body("shaft_out")
    assert shaft is not None
    return float(shaft.inertia[0, 0])


def on_shaft_2(turn: cd.Sweep, beta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Moment of the cross on shaft 2 in Thoma's axes: M_t, M_x, M_z."""
    moment = turn.wrench("pin_out", "world").moment
    along = np.array([np.cos(beta), np.sin(beta), 0.0])
    across = np.array([-np.sin(beta), np.cos(beta), 0.0])
    return moment @ along, -moment @ across, -moment[:, 2]


@pytest.mark.parametrize("beta", ANGLES)
def test_moments_of_the_flywheel(beta: float) -> None:
    """Thoma (8), (6) and (7) with the inertia in the file."""
    torque, bending_x, bending_z = on_shaft_2(sweep(beta), beta)
    expected = thoma.rig_moments(beta, POSITIONS, flywheel(), SPEED)
    for computed, reference in zip((torque, bending_x, bending_z), expected, strict=True):
        assert np.max(np.abs(computed - reference)) < 1e-12 * np.max(np.abs(reference))
    second = single_joint.acceleration_ratio(beta, POSITIONS)
    reference = flywheel() * SPEED**2 * second
    assert np.max(np.abs(torque - reference)) < 1e-12 * np.max(np.abs(reference))


@pytest.mark.parametrize("beta", ANGLES)
def test_cross_without_mass_passes_the_moment_on(beta: float) -> None:
    """Same size and direction on both shafts, no force, and no more than the flywheel asks for."""
    turn = sweep(beta)
    first, second = (turn.wrench(name, "world") for name in ("pin_in", "pin_out"))
    scale = np.max(np.abs(second.moment))
    assert np.max(np.abs(first.moment - second.moment)) < 1e-13 * scale
    assert np.max(np.abs(second.force)) < 1e-12 * scale
    # Constant speed: the pulley's inertia takes no torque, the drive works against shaft 2 alone.
    np.testing.assert_allclose(turn.drive_effort, first.moment[:, 0], rtol=0.0, atol=1e-13 * scale)


def test_bending_at_two_and_four_times_the_speed() -> None:
    """Thoma's conclusion at 8.5°: the bending holds the orders 2 and 4, and what is left is small.

    His small-angle forms: M_x ∝ sin 2φ + ½ sin 4φ, M_z ∝ 1 - cos 4φ.
    """
    beta = float(ANGLES[0])
    _, bending_x, bending_z = on_shaft_2(sweep(beta), beta)
    scale = flywheel() * SPEED**2 * np.sin(beta) * 2.0 * np.sin(0.5 * beta) ** 2
    orders_x = np.fft.rfft(bending_x[:-1]).imag * -2.0 / 720.0 / scale
    orders_z = np.fft.rfft(bending_z[:-1]).real * 2.0 / 720.0 / scale
    assert orders_x[2] == pytest.approx(-1.0, abs=0.03)
    assert orders_x[4] == pytest.approx(-0.5, abs=0.03)
    assert orders_z[4] == pytest.approx(0.5, abs=0.03)
    odd = np.concatenate([orders_x[1::2], orders_z[1::2]])
    assert np.max(np.abs(odd)) < 1e-13
    high = np.concatenate([orders_x[6:], orders_z[6:]])
    assert np.max(np.abs(high)) < 0.03


def test_pulley_is_large_and_takes_no_part() -> None:
    """58 times the inertia of shaft 2; at constant speed half of it would do as well."""
    shaft_1 = Reader(text("thoma_rig")).body("shaft_in")
    assert shaft_1 is not None
    inertia = float(shaft_1.inertia[0, 0])
    assert inertia / flywheel() == pytest.approx(58.0, abs=0.5)

    def halved(robot: ElementTree.Element) -> None:
        element = robot.find("link[@name='shaft_in']/inertial/inertia")
        assert element is not None
        element.set("ixx", repr(0.5 * inertia))

    beta = float(ANGLES[1])
    lighter = edited(text("thoma_rig"), halved)
    bundled, halved_inertia = (sweep(beta, urdf) for urdf in ("thoma_rig", lighter))
    scale = np.max(np.abs(bundled.drive_effort))
    assert np.max(np.abs(bundled.drive_effort - halved_inertia.drive_effort)) < 1e-13 * scale
    # The inertia matters as soon as the speed changes.
    scene = cd.Scene(cd.load("thoma_rig"), drive="bearing_in", held={"joint_angle": beta})
    faster = scene.sweep(POSITIONS, speed=SPEED, acceleration=100.0)
    assert np.mean(faster.drive_effort) > 0.99 * inertia * 100.0


def springs(rates: tuple[float, float]) -> tuple[np.ndarray, float]:
    """Compliance against (force, moment) at the joint's centre, and Σ k x / Σ k x².

    Two springs across the shaft at x₁ and x₂, as the description's header puts them together.
    """
    distances = np.array([0.1, 0.54])
    k = np.array(rates)
    moment = float(k @ distances)
    stiffness = np.array([[k.sum(), moment], [moment, float(k @ distances**2)]])
    return np.linalg.inv(stiffness), moment / stiffness[1, 1]


def test_bearings_on_springs() -> None:
    """With elastic bearings the forces are unique in a new sense: least elastic energy.

    By hand: the rigid bearing of shaft 1 keeps the joint's centre in place, so shaft 2 tilts about
    it, and both springs push back in proportion to rate and distance. They exert
    F = M Σ k x / Σ k x², which the cross balances, in each of both directions separately.
    """
    beta = float(ANGLES[2])
    (upright, ratio_y), (level, ratio_z) = springs((4e6, 7e6)), springs((9e6, 2e6))
    compliance = np.zeros((6, 6))
    compliance[np.ix_([1, 5], [1, 5])] = upright
    # A moment about y tilts the shaft towards -z.
    sign = np.diag([1.0, -1.0])
    compliance[np.ix_([2, 4], [2, 4])] = sign @ level @ sign
    scene = cd.Scene(
        cd.load("thoma_rig"),
        drive="bearing_in",
        held={"joint_angle": beta},
        compliance={"bearing_out": compliance},
    )
    turn = scene.sweep(POSITIONS, speed=SPEED)
    rigid = sweep(beta)
    elastic = turn.wrench("bearing_out", "parent")
    moment = rigid.wrench("bearing_out", "parent").moment
    scale = np.max(np.abs(moment))
    assert np.max(np.abs(elastic.moment - moment)) < 1e-12 * scale
    expected = np.stack(
        [0.0 * moment[:, 0], ratio_y * moment[:, 2], -ratio_z * moment[:, 1]], axis=1
    )
    assert np.max(np.abs(elastic.force - expected)) < 1e-12 * np.max(np.abs(expected))
    assert np.max(np.abs(expected)) > scale
    for name in ("pin_out", "pin_in", "bearing_in"):
        difference = turn.wrench(name, "world").force + turn.wrench("bearing_out", "world").force
        assert np.max(np.abs(difference)) < 1e-12 * np.max(np.abs(expected)), name
