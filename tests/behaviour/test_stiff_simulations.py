"""Simulations whose steps could be far too short: by springs, by friction, or as they are asked."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import clearance

GRAVITY = (0.0, 0.0, -9.81)


def chain(count: int) -> cd.Mechanism:
    text = '<robot name="chain"><link name="l0"/>'
    for k in range(count):
        text += (
            f'<link name="l{k + 1}"><inertial><origin xyz="0 0 -0.3"/><mass value="1"/><inertia '
            'ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="0 0 {-0.5 if k else 0}"/><axis xyz="0 1 0"/></joint>'
        )
    return cd.load(text + "</robot>")


@pytest.mark.parametrize(
    ("stiffness", "damping", "speed", "rtol"),
    [
        (7.2e7, 440.0, 50.0, 1e-6),
        (2.3e7, 1.3e3, 1e-3, 5e-9),
        (1.6e6, 810.0, 1e-6, 3e-6),
        (1e8, 1e4, 0.0, 1e-7),
        (0.0, 1e4, 10.0, 1e-6),
    ],
)
@pytest.mark.parametrize("count", [1, 2])
def test_steps_are_hardly_more_than_those_of_the_better_method(
    stiffness: float, damping: float, speed: float, rtol: float, count: int
) -> None:
    """Radau, which is taken from the start on, never needs many times fewer."""
    names = [f"j{k}" for k in range(count)]
    spring = cd.JointSpring(names[-1], stiffness, damping=damping)
    scene = cd.Scene(chain(count), drive=names, elements=[spring], gravity=GRAVITY)
    given = {"position": {"j0": 1.0 if count > 1 else 0.0}, "speed": {names[-1]: speed}}
    found = scene.replace(free=scene.drives).simulate(0.5, rtol=rtol, **given)
    implicit = scene.replace(free=scene.drives).simulate(0.5, rtol=rtol, method="Radau", **given)
    assert len(found.time) <= 3 * len(implicit.time) + 150
    end, other = (item.position.reshape(len(item.time), -1)[-1] for item in (found, implicit))
    np.testing.assert_allclose(end, other, atol=1e4 * rtol)


@pytest.mark.parametrize("method", [None, "DOP853", "Radau"])
def test_friction_that_sets_in_at_once_brings_to_rest(method: str | None) -> None:
    """Within 1e-7 rad/s; where it has stopped, weight does not move it, and few steps are left."""
    friction = cd.JointFriction("j0", 8.0, transition=1e-7)
    scene = cd.Scene(chain(1), free="j0", elements=[friction], gravity=GRAVITY)
    found = scene.simulate(2.0, position=0.5, speed=6.0, method=method, rtol=1e-8)
    assert len(found.time) < 500 and found.time[-1] == 2.0
    assert abs(found.speed[-1]) < 1e-7
    # Energy is taken by friction: ½ I w² - m g s (cos - cos) = M (angle turned).
    inertia, weight = 0.02 + 0.09, 9.81 * 0.3
    start, end = 0.5, float(found.position[-1])
    gained = weight * (np.cos(end) - np.cos(start))
    assert 0.5 * inertia * 36.0 + gained == pytest.approx(8.0 * (end - start), rel=1e-5)


def test_too_many_steps_are_said() -> None:
    scene = cd.Scene(chain(1), free="j0", gravity=GRAVITY)
    said: list[str] = []

    def interrupting(_: float, note: str) -> None:
        said.append(note)
        if len(said) > 1200:
            raise KeyboardInterrupt

    found = scene.simulate(2.0, position=1.0, step=1e-9, progress=interrupting)
    assert found.reason == "interrupted" and len(found.time) < 1300
    assert said[0] == "" and "2.0e+09 in all, at this rate until" in said[-1]
    assert found.notes == (said[-1],)
    assert not scene.simulate(2.0, position=1.0, step=1e-2).notes


@pytest.mark.slow
def test_an_interruption_ends_it_at_once() -> None:
    program = """
import signal, cardan_dyn as cd
joint = "<joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>"
inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
link = f"<link name='a'/><link name='b'>{inertial}</inertial></link>"
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = cd.Scene(cd.load(f"<robot name='r'>{link}{joint}</robot>"), free="j")
scene.simulate(1e-8, step=1e-9, speed=1.0)  # Which imports what is needed, however long that takes.
print("begun", flush=True)
found = scene.simulate(1.0, step=1e-9, speed=1.0)
print(found.reason, found.notes, flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    answer, _ = process.communicate(timeout=30.0)
    assert answer.startswith("interrupted") and process.returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "rotor"),
    [
        ("slider_crank", None),
        ("four_bar", 1e-2),
        pytest.param("slider_crank", 1e-2, marks=pytest.mark.campaign),
        pytest.param("four_bar", None, marks=pytest.mark.campaign),
    ],
)
@pytest.mark.parametrize(
    "law",
    [
        cd.LinearContact(1e8, 5e3),
        clearance.HuntCrossley(3e9, restitution=0.6),
        clearance.ImpactFunction(1e8, 1.5, 1e4, 1e-6),
    ],
    ids=["linear", "Hunt-Crossley", "IMPACT"],
)
def test_contacts_keep_energy_as_asked(
    law: clearance.ContactLaw, mechanism: str, rotor: float | None
) -> None:
    scene = cd.Scene(cd.load(mechanism), drive="crank_bearing")
    rtol = 1e-7
    found = clearance.simulate(
        scene, 100.0, joints="crank_pin", clearance=2e-4, law=law, turns=0.4, position=1.1,
        rtol=rtol, rotor=rotor,
    )  # fmt: skip
    assert found.energy_residual <= rtol
    trajectory = found.trajectory
    energy = trajectory.kinetic_energy + trajectory.potential_energy - trajectory.work
    # By hand: relative to the kinetic energy, of which there is most.
    off = np.max(np.abs(energy - energy[0])) / np.max(trajectory.kinetic_energy)
    assert off <= 2.0 * rtol


@pytest.mark.parametrize("amplitude", [1e-5, 1e-7, 1e-9, 1e-14])
def test_motion_that_hardly_moves_has_no_error_of_energy(amplitude: float) -> None:
    """Rounding and the absolute tolerance leave 1e-15 J of a pendulum that weighs 10 N."""
    scene = cd.Scene(chain(2), free=["j0", "j1"], gravity=GRAVITY)
    found = scene.simulate(1.0, position={"j0": amplitude, "j1": -0.5 * amplitude})
    assert np.max(found.kinetic_energy) < 10.0 * amplitude**2
    energy = found.kinetic_energy + found.potential_energy
    assert np.ptp(energy) < 1e-13 and found.energy_residual < 1e-13
