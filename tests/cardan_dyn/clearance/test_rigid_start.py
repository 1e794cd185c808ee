"""Where simulations of clearance begin."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import clearance
from cardan_dyn.motion.clearance.opened_joint import OpenedJoint
from cardan_dyn.motion.clearance.opened_scene import OpenPin, opened
from cardan_dyn.motion.clearance.simulating import RigidStart


def scene() -> cd.Scene:
    return cd.Scene(cd.load("slider_crank"), drive="crank_bearing")


def test_it_begins_where_no_force_is_near_a_reversal() -> None:
    begun = RigidStart(scene(), 200.0, ["crank_pin", "piston_pin"])
    sweep = scene().sweep(np.linspace(0.0, 2.0 * np.pi, 721), 200.0)
    there = scene().sweep([begun.position], 200.0)
    for name in begun.joints:
        sizes = np.linalg.norm(sweep[name].force[:, :2], axis=1)
        assert np.linalg.norm(there[name].force[0, :2]) > 0.9 * np.max(sizes)


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["crank_pin", "piston_pin", "crank_bearing"])
@pytest.mark.parametrize("law", [cd.LinearContact(1e8), cd.HuntCrossley(1e11, restitution=0.6)])
def test_pins_begin_pressed_by_the_force_without_play_and_move_with_it(
    joint: str, law: cd.LinearContact
) -> None:
    begun = RigidStart(scene(), 200.0, joint, 0.8)
    clearances = [OpenPin(joint, 1e-4, law, 0.0, 0.0, None)]
    found = opened(scene(), clearances)
    start = begun.state(found, clearances, is_free=False)
    # Touches that the start does not know give the spring alone.
    motion = found.scene.simulate(1e-7, **start, rtol=1e-10)
    force = motion.at([0.0]).element_force[0]
    tight = scene().sweep([0.8], 200.0)
    expected = tight.wrench(joint, "world").force[0]
    # Of a joint whose bush moves, the clearance of its pin turns the bush a little.
    near = 1e-9 if joint != "piston_pin" else 1e-3
    np.testing.assert_allclose(force.force[0], expected, atol=near * np.linalg.norm(expected))
    # The wall presses as its force does a little later: it is followed, not struck.
    later = motion.at([1e-7]).element_force[0]
    expected = scene().sweep([0.8 + 200.0 * 1e-7], 200.0).wrench(joint, "world").force[0]
    change = expected - tight.wrench(joint, "world").force[0]
    np.testing.assert_allclose(
        later.force[0] - force.force[0], change, atol=0.05 * np.linalg.norm(change)
    )


def mean(masses: list[float], sizes: list[float]) -> float:
    """The geometric mean, in which a force counts as much as it is great."""
    return float(np.exp(np.average(np.log(masses), weights=sizes)))


@pytest.mark.slow
def test_damping_follows_from_the_masses_that_the_force_moves_over_a_turn() -> None:
    """By experiments at eight positions: what a push along the force moves in a short time."""
    found = opened(scene(), [OpenPin("crank_pin", 1e-4, cd.LinearContact(1e8), 0.0, 0.0, None)])
    axes = [part.axis[:2] for part in found.scene.mechanism.joint("crank_pin").parts[:2]]
    masses, sizes = [], []
    for phi in 0.25 * np.pi * np.arange(8):
        force = scene().sweep([phi], 200.0)["crank_pin"].force[0]
        turn = scene().sweep([phi]).motion.position("crank_pin")[0]
        # Slides act along the axes of the bush, the wrench is given along those of the pin.
        away = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ force[:2]
        sizes.append(float(np.linalg.norm(away)))
        away = away / sizes[-1]
        along = {f"crank_pin.slide_{k + 1}": float(axes[k] @ away) for k in range(2)}
        ends = []
        for sign in (1.0, -1.0):
            loads = {name: sign * value for name, value in along.items()}
            motion = found.scene.simulate(
                1e-4,
                position={found.drive: phi},
                motion={found.drive: 0.0},
                loads=loads,
                rtol=1e-12,
            )
            place = motion.motion.position("crank_pin")[-1, :2]
            ends.append(sum(place[k] * value for k, value in enumerate(along.values())))
        masses.append(1e-4**2 / (ends[0] - ends[1]))
    begun = RigidStart(scene(), 200.0, "crank_pin", 0.8)
    assert begun.reduced_mass("crank_pin") == pytest.approx(mean(masses, sizes), rel=1e-6)
    assert np.ptp(masses) > 0.05 * np.mean(masses)


@pytest.mark.slow
def test_a_damping_ratio_means_one_damper_in_scans_and_simulations() -> None:
    """Wherever the simulation begins, and at every reversal."""
    contact = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.2}
    for joint, rotor in (("piston_pin", None), ("crank_bearing", None), ("piston_pin", 0.01)):
        scanned = clearance.scan(scene(), 200.0, joints=joint, rotor=rotor, **contact)[joint]
        dampers = [item.damping for item in scanned.reversals]
        for position in (None, 0.3, 2.0):
            found = clearance.simulate(
                scene(), 200.0, joints=joint, rotor=rotor, position=position, turns=1e-3, **contact
            )
            law = found.contact(joint).law
            assert isinstance(law, cd.LinearContact)
            assert dampers == pytest.approx([law.damping] * len(dampers), rel=1e-7)
        assert len(dampers) > 1


@pytest.mark.slow
@pytest.mark.parametrize("pins", [["pin_in"], ["pin_out"], ["pin_in", "pin_out"]])
def test_bearings_begin_pressed_by_the_moment_that_they_pass_on(pins: list[str]) -> None:
    """Shaft 2 begins to accelerate as it does without clearance."""
    tight = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": np.radians(20.0)}
    )
    begun = RigidStart(tight, 150.0, pins, 0.7)
    law = cd.LinearContact(1e8)
    clearances = [OpenPin(pin, 1e-5, law, 0.0, 0.0, 0.05) for pin in pins]
    found = opened(tight, clearances)
    motion = found.scene.simulate(1e-7, **begun.state(found, clearances, is_free=False))
    expected = tight.sweep([0.7], 150.0).motion.acceleration("bearing_out")[0]
    at = motion.at([0.0])
    assert at.motion.acceleration("bearing_out")[0] == pytest.approx(expected, rel=0.02)
    first, second = at.element_force[0], at.element_force[1]
    assert first.pressure[0] > 100.0
    np.testing.assert_allclose(first.force, -second.force, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_damping_follows_from_the_mass_of_a_drive_that_gives_way() -> None:
    """By hand: the force turns the rotor as well, by its moment about the crank's bearing."""
    masses = {}
    for rotor in (None, 1e9, 0.01, 0.0):
        masses[rotor] = RigidStart(scene(), 200.0, "crank_pin", 0.8, rotor=rotor).reduced_mass(
            "crank_pin"
        )
    # Beside such a rotor, the rest is known to that part of its inertia that is rounding.
    assert masses[1e9] == pytest.approx(masses[None], rel=1e-6)
    positions = 0.25 * np.pi * np.arange(8)
    forces = scene().sweep(positions, 200.0).wrench("crank_pin", "world").force
    crank = 0.0074013863873 + 4.9746767871 * 0.0006829987718**2
    opened_pin = OpenedJoint(scene().solver, None, "crank_pin")
    states = scene().sweep(positions).motion.rows
    for rotor in (0.01, 0.0):
        expected, sizes = [], []
        for phi, force, x in zip(positions, forces, states, strict=True):
            sizes.append(float(np.linalg.norm(force)))
            away = force / sizes[-1]
            lever = 0.045 * (np.cos(phi) * away[1] - np.sin(phi) * away[0])
            fixed = opened_pin.mobility(x).reduced_mass(away)
            expected.append(1.0 / (1.0 / fixed + lever**2 / (crank + rotor)))
        assert masses[rotor] < 0.99 * masses[None]
        assert masses[rotor] == pytest.approx(mean(expected, sizes), rel=1e-9)
    for rotor in (None, 0.01):
        found = clearance.simulate(
            scene(),
            200.0,
            joints="crank_pin",
            clearance=1e-4,
            stiffness=1e8,
            damping_ratio=0.2,
            position=0.8,
            rotor=rotor,
            turns=1e-3,
        )
        (contact,) = found.trajectory.elements
        wanted = 0.4 * np.sqrt(1e8 * masses[rotor])
        assert contact.law.damping == pytest.approx(wanted, rel=1e-9)  # type: ignore[attr-defined]
