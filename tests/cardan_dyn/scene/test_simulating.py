"""Simulations of a scene, as a user calls them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from testkit.many_drives import linkage
from testkit.simulated import ABOUT_PIN, GRAVITY, WEIGHT, integrated, pendulum

import cardan_dyn as cd

TIMES = np.linspace(0.0, 3.0, 31)


@pytest.fixture(scope="module")
def hanging() -> cd.Scene:
    return cd.Scene(pendulum(), drive="pin", gravity=GRAVITY)


@pytest.mark.parametrize("method", [None, "response", "DOP853", "Radau"])
def test_a_pendulum_against_its_own_equation(hanging: cd.Scene, method: str | None) -> None:
    rtol = 1e-8 if method == "Radau" else 1e-12
    found = hanging.replace(free=hanging.drives).simulate(
        3.0, position=2.0, speed=1.0, method=method, rtol=rtol
    )
    expected = integrated(lambda t, x, v: -WEIGHT / ABOUT_PIN * np.sin(x), 2.0, 1.0, TIMES)
    # Errors of the steps add up over some ten radians.
    np.testing.assert_allclose(found.at(TIMES).position, expected[0], atol=100.0 * rtol)
    np.testing.assert_allclose(found.at(TIMES).speed, expected[1], atol=400.0 * rtol)


def test_tolerances_are_met_at_any_speed(hanging: cd.Scene) -> None:
    """Absolute tolerances of a speed count from the speed at the start."""
    scene = cd.Scene(pendulum(), free="pin", elements=[cd.JointSpring("pin", 0.0, damping=0.1)])
    decay = 0.1 / ABOUT_PIN
    for method in ("response", "DOP853"):
        found = scene.simulate(3.0, speed=1e-6, method=method)
        expected = 1e-6 * np.exp(-decay * TIMES)
        np.testing.assert_allclose(found.at(TIMES).speed, expected, rtol=1e-8)


def test_equilibria_are_where_simulations_rest(hanging: cd.Scene) -> None:
    found = hanging.replace(free=hanging.drives).equilibrium(0.3, loads={"pin": 5.0})
    assert found.position[0] == pytest.approx(np.arcsin(5.0 / WEIGHT), abs=1e-13)
    rest = hanging.replace(free=hanging.drives).simulate(
        1.0, position=found.position[0], loads={"pin": 5.0}
    )
    np.testing.assert_allclose(rest.position, found.position[0], atol=1e-12)


def test_scenes_are_left_as_they_are(hanging: cd.Scene) -> None:
    hanging.replace(free=hanging.drives).simulate(0.1, position=1.0, loads={"pin": 3.0})
    assert not hanging.loads
    effort = hanging.sweep([0.5]).drive_effort
    np.testing.assert_allclose(effort, [WEIGHT * np.sin(0.5)], rtol=1e-14)


def half_of_two_linkages() -> cd.Mechanism:
    """Two four-bars beside each other, of which only the second has mass."""
    first, second = linkage(0, "base"), linkage(1, "base", "3 0 0")
    first = re.sub(r"<inertial>.*?</inertial>", "", first)
    return cd.load(f'<robot name="two"><link name="base"/>{first}{second}</robot>')


def test_what_has_no_mass_is_not_simulated() -> None:
    text = re.sub(r"<inertial>.*?</inertial>", "", linkage(0, "base"))
    scene = cd.Scene(
        cd.load(f'<robot name="one"><link name="base"/>{text}</robot>'), free="crank_0"
    )
    assert scene.plan().simulation == "nothing, no body has mass"
    for given in ({}, {"speed": 1.0}, {"loads": {"crank_0": 1.0}}):
        with pytest.raises(cd.ModelError, match="no body has mass, so that no motion follows"):
            scene.simulate(0.1, **given)


def test_a_plan_says_what_a_simulation_does() -> None:
    """Whatever outputs leave out: all bodies move."""
    scene = cd.Scene(half_of_two_linkages(), drive="crank_0", free="crank_1", outputs=["end_0"])
    assert scene.plan().simulation.startswith("DOP853 in all coordinates")
    assert scene.simulate(0.01, motion={"crank_0": 1.0}).method == "DOP853"
    loaded = cd.Scene(pendulum(), free="pin", loads={"pin": np.array([1.0, 2.0])})
    assert loaded.plan().simulation.startswith("nothing without other loads: loads['pin'] has")
    with pytest.raises(cd.ArgumentError, match="takes one value"):
        loaded.simulate(0.1)
    pulled = loaded.simulate(0.1, loads={"pin": 1.0})
    np.testing.assert_allclose(pulled.at([0.1]).position, 0.5 * 0.1**2 / ABOUT_PIN, rtol=1e-8)
