"""Touches of pins: located, none missed, against flights and swings in closed form."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.elements.contact_laws import ContactLaw

MASS = 2.0
BALL = f"""<robot name="ball"><link name="world"/><link name="pin"><inertial>
<mass value="{MASS}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="p" type="planar"><parent link="world"/><child link="pin"/><axis xyz="0 0 1"/></joint>
</robot>"""
ORIGIN, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
DRIVES = ["p.slide_1", "p.slide_2", "p.turn"]


def ball(law: ContactLaw, gravity: float = 0.0, **changes: float) -> cd.Scene:
    contact = cd.PinContact("world", ORIGIN, Z, "pin", ORIGIN, 2e-3, law, **changes)  # type: ignore[arg-type]
    down = (0.0, -gravity, 0.0)
    return cd.Scene(cd.load(BALL), free=DRIVES, elements=[contact], gravity=down)


def test_a_fall_through_the_play_ends_when_and_as_fast_as_gravity_says() -> None:
    found = ball(cd.LinearContact(1e6), 9.81).simulate(0.03)
    touch = found.touches[0]
    assert touch.start == pytest.approx(math.sqrt(2e-3 / 9.81), rel=1e-12)
    assert touch.speed == pytest.approx(math.sqrt(2.0 * 9.81 * 1e-3), rel=1e-12)
    np.testing.assert_allclose(touch.direction, [0.0, -1.0, 0.0], atol=1e-12)
    # The spring swings about where it bears the weight.
    weight, omega = MASS * 9.81, math.sqrt(1e6 / MASS)
    peak = weight + math.hypot(weight, MASS * omega * touch.speed)
    assert touch.peak == pytest.approx(peak, rel=1e-8)
    lasts = 2.0 * (math.pi - math.atan2(MASS * omega * touch.speed, weight)) / omega
    assert touch.end - touch.start == pytest.approx(lasts, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        cd.LinearContact(1e6, 300.0),
        cd.HuntCrossley(1e9, restitution=0.6),
        cd.LankaraniNikravesh(1e9, restitution=0.6),
        cd.ImpactFunction(1e8, exponent=1.3, damping=300.0, full_depth=1e-5),
    ],
)
def test_speeds_from_wall_to_wall_shrink_by_the_restitution_of_the_law(law: ContactLaw) -> None:
    found = ball(law).simulate(0.15, speed={"p.slide_1": 0.3}, rtol=1e-12)
    speeds = [touch.speed for touch in found.touches]
    assert len(speeds) >= 3 and speeds[0] == pytest.approx(0.3, rel=1e-9)
    for before, after in pairwise(speeds):
        assert after / before == pytest.approx(law.restitution(before, MASS), abs=1e-8)
    lost = 0.5 * MASS * (speeds[0] ** 2 - speeds[2] ** 2)
    start, middle = found.at([0.0, found.touches[1].end + 1e-6]).kinetic_energy
    assert start - middle == pytest.approx(lost, rel=1e-6)
    assert found.energy_residual < 1e-8


def test_a_wall_that_follows_slowly_is_left_before_the_play() -> None:
    """The damper alone would pull: the pin leaves while it is still in the wall."""
    law = cd.LinearContact(1e6, 900.0)
    found = ball(law).simulate(0.02, speed={"p.slide_1": 0.3})
    end = found.touches[0].end
    force = found.at([end - 1e-9, end + 1e-9]).element_force[0]
    assert np.all(force.depth > 1e-6)
    assert force.pressure[0] < 0.1 and force.pressure[1] == 0.0


@pytest.mark.slow
def test_grazing_touches_are_not_missed() -> None:
    """A pin on a spring beside the bush's axis that swings a hair beyond the play."""
    beyond = 1e-9
    contact = cd.PinContact("world", ORIGIN, Z, "pin", ORIGIN, 2e-3, cd.LinearContact(1e7))
    spring = cd.JointSpring("p.slide_1", stiffness=200.0, rest=0.0)
    scene = cd.Scene(cd.load(BALL), free=DRIVES, elements=[contact, spring])
    omega = math.sqrt(200.0 / MASS)
    found = scene.simulate(5.0, speed={"p.slide_1": omega * (1e-3 + beyond)}, rtol=1e-12)
    assert len(found.touches) == round(5.0 * omega / math.pi)
    assert 0.0 < min(touch.peak for touch in found.touches) < 1.0


@pytest.mark.slow
def test_friction_turns_the_pin_and_takes_energy() -> None:
    scene = ball(cd.LinearContact(1e6, 100.0), 9.81, friction=0.4, radius=0.05)
    found = scene.simulate(0.06, speed={"p.turn": 5.0})
    impulse = 0.4 * MASS * (9.81 * 0.06 + 0.3)
    assert 5.0 - 0.05 * impulse < found.speed[-1, 2] < 4.99
    assert found.energy_residual < 1e-8
    free = ball(cd.LinearContact(1e6, 100.0), 9.81, radius=0.05)
    assert free.simulate(0.06, speed={"p.turn": 5.0}).speed[-1, 2] == pytest.approx(5.0)


def test_it_ends_after_as_many_touches_as_it_may() -> None:
    found = ball(cd.LinearContact(1e6)).simulate(9.0, speed={"p.slide_1": 0.3}, max_touches=4)
    assert found.reason == "4 touches of pins" and len(found.touches) == 4
    assert found.time[-1] == found.touches[-1].end


def test_a_start_in_the_wall_presses_at_once() -> None:
    law = cd.HuntCrossley(1e9, restitution=0.6)
    found = ball(law).simulate(0.02, position={"p.slide_1": 1.1e-3})
    first = found.touches[0]
    assert first.start == 0.0 and math.isnan(first.speed)
    # The law knows no speed of touch: the spring alone acts, and gives back what it stored.
    away = math.sqrt(2.0 * float(law.energy(1e-4)) / MASS)
    assert found.touches[1].speed == pytest.approx(away, rel=1e-8)


def test_methods_that_leap_over_touches_are_refused() -> None:
    scene = ball(cd.LinearContact(1e6))
    for method in ("Radau", "quadrature", "response"):
        with pytest.raises(cd.ArgumentError, match="every touch is located"):
            scene.simulate(0.01, method=method)
    assert "pins with clearance strike" in scene.plan().simulation
