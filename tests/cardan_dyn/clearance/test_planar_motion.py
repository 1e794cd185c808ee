"""Pins in the plane of their bush, against closed forms and equations written by hand."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.loose_slider_crank import LooseSliderCrank

import cardan_dyn as cd
from cardan_dyn.analytic.damped_impact import damped_peak, flight
from cardan_dyn.core.response.operating_points import solved_motion
from cardan_dyn.motion.clearance.forces import ForceSource
from cardan_dyn.motion.clearance.opened_joint import OpenedJoint, Plane
from cardan_dyn.motion.clearance.planar_motion import PlanarModel

PERIOD = 2.0 * np.pi
PHI = PERIOD / 240 * np.arange(240)


def plane_of_mass(mass: float, force: np.ndarray) -> Plane:
    """A point of a mass that a force moves."""
    eye = np.tile(np.eye(2), (len(force), 1, 1))
    return Plane(eye / mass, 0.0 * eye, force, PERIOD)


@pytest.mark.parametrize("speed", [50.0, -50.0])
def test_a_force_that_rotates_makes_the_pin_ride_round(speed: float) -> None:
    """In a circle of radius r: p = F + m r Ω², r = s + p / c."""
    mass, size, c, clearance = 2.0, 3000.0, 1e8, 4e-4
    force = size * np.stack([np.cos(PHI), np.sin(PHI)], axis=1)
    model = PlanarModel(plane_of_mass(mass, force), clearance, cd.LinearContact(c, 2e3), speed)
    found = model.run(3.0)
    expected = (size + mass * speed**2 * 0.5 * clearance) / (1.0 - mass * speed**2 / c)
    np.testing.assert_allclose(found.pressure[found.time > 0.1], expected, rtol=1e-3)
    assert found.touches == []
    assert found.end - found.time[0] == pytest.approx(3.0 * PERIOD / abs(speed), rel=1e-6)


@pytest.mark.parametrize("speed", [50.0, -50.0])
def test_a_pin_is_pushed_by_the_force_at_the_drives_position(speed: float) -> None:
    """At Ω t; backwards as well, where masses and forces come in the opposite order."""
    mass, c, gap = 2.0 + np.sin(PHI), 1e8, 1e-4
    force = 1e3 * np.stack([2.0 + np.cos(PHI), np.sin(PHI + 0.4)], axis=1)
    eye = np.eye(2)[None]
    plane = Plane(eye / mass[:, None, None], np.zeros((240, 2, 2)), force, PERIOD)
    model = PlanarModel(plane, gap, cd.LinearContact(c), speed)
    for part in (0.0, 0.125, 0.75):
        time = part * PERIOD / abs(speed)
        at = speed * time
        x, y = 2.0 + np.cos(at), np.sin(at + 0.4)
        pushed = 1e3 * complex(x, y)
        expected = -pushed / abs(pushed) * (0.5 * gap + abs(pushed) / c)
        assert model.seat(time) == pytest.approx(expected, rel=1e-12)
        slope = model._acceleration(time, 0j, 0j, is_pressed=False)
        assert slope == pytest.approx(-pushed / (2.0 + np.sin(at)), rel=1e-6)


@pytest.mark.parametrize("ratio", [0.1, 0.3])
def test_along_a_line_it_is_the_two_mass_model(ratio: float) -> None:
    """Where a force goes to and fro in one direction, with a ramp that hardly bends."""
    mass, c, clearance, speed, size = 2.0, 1e8, 2e-5, 20.0, 4e4
    force = np.stack([size * np.sin(PHI), 0.0 * PHI], axis=1)
    law = cd.LinearContact(c, 2.0 * ratio * np.sqrt(c * mass))
    found = PlanarModel(plane_of_mass(mass, force), clearance, law, speed).run(1.0)
    numbers = mass, c, 0.5 * clearance, size * speed, ratio
    flown = flight(*numbers)
    reversal = np.pi / speed
    touched, struck = found.touches[0]
    assert touched - reversal == pytest.approx(float(flown.t_1), rel=5e-3)
    assert struck == pytest.approx(float(flown.v_1), rel=5e-3)
    peak, when = found.greatest(touched, touched + 3e-4)
    assert touched < when < touched + 3e-4
    assert peak == pytest.approx(float(damped_peak(*numbers)), rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "clearance"), [(300.0, 1e-4), (-120.0, 5e-5)])
def test_slider_crank_by_equations_written_by_hand(speed: float, clearance: float) -> None:
    """Lagrange's equations of the loose rod and piston, integrated by SciPy from the same start."""
    c, d = 1e8, 8e3
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    source = ForceSource(scene)
    motion = solved_motion(source.solver, PHI, np.ones(240), np.zeros(240))
    opened = OpenedJoint(scene.solver, None, "crank_pin")
    found = source.forces(speed, {"crank_pin": opened}, refuse=True)[1]["crank_pin"]
    force = found.world[::3, 0]
    plane = opened.plane(motion.rows, motion.v, force, PERIOD)
    model = PlanarModel(plane, clearance, cd.LinearContact(c, d), speed)
    begin = 1.0 / abs(speed)
    hand = LooseSliderCrank.bundled(speed, clearance, c, d)

    def place(time: float) -> np.ndarray:
        """Piston and rod for the pin where it begins, riding on: along y and -x of the crank."""
        angle, seat = speed * time, model.seat(time)
        x, y = -seat.imag, seat.real
        pin = np.array(
            [
                (hand.crank + x) * np.cos(angle) - y * np.sin(angle),
                (hand.crank + x) * np.sin(angle) + y * np.cos(angle),
            ]
        )
        psi = np.arcsin(-pin[1] / hand.rod)
        return np.array([pin[0] + hand.rod * np.cos(psi), psi])

    # Where the tables have their places, from one to the next.
    begin = round(begin * model._per_time) / model._per_time
    step = 1.0 / model._per_time
    rates = (place(begin + step) - place(begin - step)) / (2.0 * step)
    found = model.run(0.9, begin)
    expected = hand.forces(speed * begin, np.concatenate([place(begin), rates]), found.time - begin)
    # Where it jumps, a time may be before or after.
    steady = np.append(np.diff(found.time) > 0.0, True) & np.insert(
        np.diff(found.time) > 0.0, 0, True
    )
    off = np.abs(found.pressure - expected)[steady] / np.max(expected)
    assert np.quantile(off, 0.98) < 0.02 and np.median(off) < 2e-3
    assert found.greatest(begin, found.end)[0] == pytest.approx(np.max(expected), rel=5e-3)


def test_the_symmetric_part_of_what_opposes_rates_is_the_change_of_the_mass() -> None:
    """Kinetic energy: ė M ë + Ω ė C ė = ė f, in which the gyroscopic part does no work."""
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    motion = solved_motion(scene.solver, PHI, np.ones(240), np.zeros(240))
    opened = OpenedJoint(scene.solver, None, "coupler_pin")
    plane = opened.plane(motion.rows, motion.v, np.zeros((240, 3)), PERIOD)
    mass = np.linalg.inv(plane.mobility)
    fine = np.array([mass[(k + np.arange(-2, 3)) % 240] for k in range(240)])
    change = np.einsum("k,nkij->nij", np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0, fine)
    change /= PERIOD / 240
    symmetric = 0.5 * (plane.gyration + plane.gyration.transpose(0, 2, 1))
    np.testing.assert_allclose(symmetric, change, atol=1e-4 * np.max(np.abs(symmetric)))
    assert np.max(np.abs(plane.gyration - symmetric)) > 0.1
