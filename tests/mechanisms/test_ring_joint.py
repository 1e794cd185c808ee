"""The universal joint with a ring: it moves and transmits like the cross, its inertia differs."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.jets import Jet, spin
from testkit.shaft_line import ShaftLine, about, single_joint, single_ratio
from testkit.urdf_reader import Reader, text

import cardan_dyn as cd
from cardan_dyn.analytic import joint_forms

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 361)
X, Y, Z = np.eye(3)
BETAS = np.radians([0.0, 1.0, 8.5, 30.0, 50.0, 80.0])
# Section and mean radius of the ring as the description's header states them.
RADIUS, WALL, WIDTH = 0.080, 0.016, 0.030


def scene(form: str, beta: float, load: float = -70.0, **options: object) -> cd.Scene:
    return cd.Scene(
        cd.load(form),
        drive="bearing_in",
        held={"joint_angle": beta},
        loads={"bearing_out": load},
        **options,
    )


@pytest.mark.parametrize("beta", BETAS)
def test_motion_is_that_of_the_cross(beta: float) -> None:
    """Thoma (4), and the cross form at the same positions."""
    ring, cross = (scene(form, beta).sweep(POSITIONS) for form in ("ring_joint", "universal_joint"))
    computed = ring.motion.position("bearing_out")
    assert np.max(np.abs(computed - single_joint(beta, POSITIONS))) < 1e-13
    np.testing.assert_allclose(
        ring.motion.ratio("bearing_out"), single_ratio(beta, POSITIONS), rtol=1e-13
    )
    for name in ("bearing_out", "pin_in", "pin_out"):
        difference = ring.motion.position(name) - cross.motion.position(name)
        assert np.max(np.abs(difference)) < 1e-14


@pytest.mark.parametrize("beta", BETAS)
def test_moments_are_those_of_the_cross(beta: float) -> None:
    """At rest every joint of both forms passes on the same moment, normal to both pin axes."""
    ring, cross = (scene(form, beta).sweep(POSITIONS) for form in ("ring_joint", "universal_joint"))
    line = ShaftLine.turn(np.array([X, about("z", beta) @ X]), Y, POSITIONS)
    (moment,) = line.moments(70.0)
    scale = np.max(np.abs(moment))
    tolerance = 1e-13 / np.cos(beta)
    for name, sign in (
        ("bearing_in", 1.0),
        ("pin_in", 1.0),
        ("pin_out", 1.0),
        ("bearing_out", -1.0),
    ):
        ring_moment = ring.wrench(name, "world").moment
        assert np.max(np.abs(ring_moment - sign * moment)) < tolerance * scale, name
        cross_moment = cross.wrench(name, "world").moment
        assert np.max(np.abs(ring_moment - cross_moment)) < tolerance * scale, name


def test_ring_has_almost_the_inertia_of_a_thin_ring() -> None:
    """m r² about its normal and m r²/2 about a diameter, and what wall and width add to that."""
    reader = Reader(text("ring_joint"))
    ring = reader.body("ring")
    assert ring is not None
    volume = 2.0 * np.pi * RADIUS * WALL * WIDTH
    assert ring.mass == pytest.approx(7850.0 * volume, rel=1e-11)
    assert not np.any(ring.centre)
    polar, diameter = joint_forms.ring_inertia(ring.mass, RADIUS)
    wall, width = ring.mass * WALL**2, ring.mass * WIDTH**2
    exact = np.diag([polar + wall / 4.0, *[diameter + wall / 8.0 + width / 12.0] * 2])
    np.testing.assert_allclose(ring.inertia, exact, rtol=1e-11, atol=1e-16)
    # Thin: both corrections stay below 1 % and 4 %.
    np.testing.assert_allclose(np.diag(ring.inertia), [polar, diameter, diameter], rtol=0.04)
    assert ring.inertia[0, 0] == pytest.approx(polar, rel=0.0101)


@pytest.mark.parametrize("form", ["ring_joint", "universal_joint"])
@pytest.mark.parametrize("beta", np.radians([8.5, 30.0, 60.0]))
def test_inertia_between_the_pins(form: str, beta: float) -> None:
    """M_in - M_out = dL/dt of ring or cross, whose axes are the pins and their normal."""
    speed = 150.0
    turn = scene(form, beta).sweep(POSITIONS, speed=speed)
    frame = pin_frame(beta, speed)
    omega, alpha = spin(frame)
    body = Reader(text(form)).body("ring" if form == "ring_joint" else "cross")
    assert body is not None
    axes = np.stack([axis.value for axis in frame], axis=2)
    inertia = axes @ body.inertia @ axes.transpose(0, 2, 1)
    expected = np.einsum("nij,nj->ni", inertia, alpha)
    expected += np.cross(omega, np.einsum("nij,nj->ni", inertia, omega))
    pins = [turn.wrench(name, "world").moment for name in ("pin_in", "pin_out")]
    scale = np.max(np.abs(pins[0]))
    assert np.max(np.abs(pins[0] - pins[1] - expected)) < 1e-13 * scale
    assert np.max(np.abs(expected)) > 1e-3 * scale


def test_forms_differ_at_speed() -> None:
    """The ring's greater inertia, 8.5 times about its normal, shows in the shaking moment."""
    beta = np.deg2rad(30.0)
    shaken = {}
    for form in ("ring_joint", "universal_joint"):
        turn = scene(form, beta, load=0.0).sweep(POSITIONS, speed=150.0)
        pins = [turn.wrench(name, "world").moment for name in ("pin_in", "pin_out")]
        shaken[form] = np.max(np.linalg.norm(pins[0] - pins[1], axis=1))
    assert shaken["ring_joint"] > 5.0 * shaken["universal_joint"] > 0.0


def pin_frame(beta: float, speed: float) -> tuple[Jet, Jet, Jet]:
    """Normal, input pin and output pin: the axes of ring and cross, shaft 1 at constant speed."""
    zero = np.zeros_like(POSITIONS)
    pin = np.stack([zero, np.cos(POSITIONS), np.sin(POSITIONS)], axis=1)
    shaft_1 = np.broadcast_to(speed * X, pin.shape)
    first = Jet.carried(pin, shaft_1, np.zeros_like(pin))
    shaft_2 = Jet.constant(np.broadcast_to(about("z", beta) @ X, pin.shape))
    second = shaft_2.cross(first).unit()
    return first.cross(second), first, second
