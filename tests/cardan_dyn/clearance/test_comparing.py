"""The estimate beside the simulation of whole mechanisms."""

from __future__ import annotations

import pickle
import re
from typing import Any

import numpy as np
import pytest
from testkit.pin_rigs import rig as disc
from testkit.pin_rigs import scene

import cardan_dyn as cd
from cardan_dyn import clearance


def compared(
    name: str,
    drive: str,
    joint: str,
    speed: float,
    gap: float,
    stiffness: float,
    friction: float = 0.0,
) -> clearance.ScanComparison:
    scene = cd.Scene(cd.load(name), drive=drive)
    contact = {"clearance": gap, "stiffness": stiffness, "damping_ratio": 0.25}
    scan = clearance.scan(scene, speed, joints=[joint], **contact)
    contact["friction"] = friction
    simulation = clearance.simulate(scene, speed, joints=joint, turns=2.6, rtol=1e-8, **contact)
    return clearance.compare(scan, simulation)


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize(
    ("joint", "speed", "gap", "stiffness", "within"),
    [
        ("coupler_pin", 300.0, 1e-4, 1e8, 0.085),
        ("needle_pin", 150.0, 1e-4, 1e8, 0.1),
        ("rocker_pin", 300.0, 1e-4, 1e8, 0.085),
        ("rocker_bearing", 300.0, 1e-4, 1e8, 0.06),
        ("coupler_pin", 600.0, 1e-4, 1e8, 0.08),
        ("needle_pin", 300.0, 2e-5, 1e8, 0.015),
        ("coupler_pin", 150.0, 1e-4, 1e7, 0.05),
    ],
)
def test_needle_drive_within_a_tenth_where_the_estimate_has_no_doubts(
    joint: str, speed: float, gap: float, stiffness: float, within: float
) -> None:
    """Where the force reverses, the ramp is straight, and tau is great enough."""
    for item in compared("needle_drive", "main_shaft", joint, speed, gap, stiffness):
        reversal = item.reversal
        assert reversal.turn_through < 0.03 and reversal.flown < 0.4 and reversal.tau > 3.0
        assert abs(item.error) < within


@pytest.mark.campaign
@pytest.mark.slow
def test_friction_in_the_bush_brings_the_pin_onto_the_line_of_the_estimate() -> None:
    """Without it, nothing damps the motion along the wall, and no two turns are alike."""
    case = "needle_drive", "main_shaft", "rocker_pin", 300.0, 1e-4, 1e8
    for item, free in zip(compared(*case, friction=0.1), compared(*case), strict=True):
        assert abs(item.error) < 0.03 < 0.055 < abs(free.error)
        assert np.ptp(item.simulated) <= 1e-3 * np.min(item.simulated)


@pytest.mark.slow
def test_slider_crank_turns_its_force_through() -> None:
    """The excess over the force without clearance is a part of what is estimated, and doubted."""
    for item in compared("slider_crank", "crank_bearing", "piston_pin", 150.0, 1e-4, 1e8):
        assert 0.1 < item.reversal.turn_through < 0.3
        assert any("turns through" in doubt for doubt in item.reversal.doubts)
        excess = np.mean(item.simulated) - item.reversal.rigid_ahead
        assert 0.2 < excess / (item.reversal.two_mass_peak - item.reversal.rigid_ahead) < 0.9
        assert item.reversal.least < np.min(item.simulated) <= np.max(item.simulated)
        assert np.max(item.simulated) < item.reversal.peak == item.reversal.greatest


@pytest.mark.slow
def test_small_tau_is_doubted_and_fails() -> None:
    for item in compared("needle_drive", "main_shaft", "rocker_bearing", 600.0, 2e-5, 1e7):
        assert item.reversal.tau < 1.8386 and item.reversal.doubts
        assert item.error < -0.2


@pytest.mark.slow
def test_tables() -> None:
    found = compared("needle_drive", "main_shaft", "coupler_pin", 300.0, 1e-4, 1e8)
    frame = found.to_dataframe()
    assert len(frame) == 2 and set(frame["joint"]) == {"coupler_pin"}
    item = found[0]
    assert frame["error"][0] == pytest.approx(
        item.reversal.estimate / np.mean(item.simulated) - 1.0
    )
    assert "coupler_pin at 0.247 rad" in str(found)


@pytest.mark.slow
def test_what_does_not_belong_together_is_refused() -> None:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    contact = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
    short = clearance.simulate(scene, 300.0, joints="coupler_pin", turns=0.3, rtol=1e-7, **contact)
    scan = clearance.scan(scene, 300.0, joints=["coupler_pin"], **contact)
    with pytest.raises(cd.ArgumentError, match="simulate more turns"):
        clearance.compare(scan, short)
    other = clearance.scan(scene, 300.0, joints=["needle_pin"], **contact)
    with pytest.raises(cd.ArgumentError, match="no joint of the simulation"):
        clearance.compare(other, short)
    faster = clearance.scan(scene, 301.0, joints=["coupler_pin"], **contact)
    with pytest.raises(cd.ArgumentError, match="of 301 rad/s, the simulation of 300"):
        clearance.compare(faster, short)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"clearance": 2e-4}, "a clearance of 0.0002 m, the scan one of 0.0001"),
        ({"stiffness": 2e8}, "a stiffness of 2e+08 N/m, the scan one of 1e+08"),
        ({"damping_ratio": 0.3}, "a damping of"),
        (
            {"law": cd.HuntCrossley(1e8, 1.0, 0.5), "stiffness": None, "damping_ratio": 0.0},
            "the law HuntCrossley, the scan that of a linear contact",
        ),
    ],
)
def test_contacts_that_differ_are_not_compared(change: dict[str, Any], said: str) -> None:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    contact: dict[str, Any] = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
    scan = clearance.scan(scene, 300.0, joints=["coupler_pin"], **contact)
    other = clearance.simulate(
        scene, 300.0, joints="coupler_pin", turns=0.01, **{**contact, **change}
    )
    with pytest.raises(cd.ArgumentError, match=re.escape(said)):
        clearance.compare(scan, other)


def test_what_is_no_scan_or_no_simulation_is_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="scan is 3, expected a scan"):
        clearance.compare(3, 3)  # type: ignore[arg-type]
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    scan = clearance.scan(scene, 300.0, joints="coupler_pin", clearance=1e-4, stiffness=1e8)
    with pytest.raises(cd.ArgumentError, match=r"expected one of clearance\.simulate"):
        clearance.compare(scan, scan)  # type: ignore[arg-type]


@pytest.mark.slow
def test_bearings_of_a_pin() -> None:
    """Thoma's rig with a disc for a cross, both bearings of a pin open: each has its share."""
    rig = scene(disc(0.5, (1.5e-4, 1.5e-4, 3e-4)), np.radians(20.0))
    contact = {"radius": 0.05, "clearance": 4e-5, "stiffness": 1e7, "damping_ratio": 0.25}
    scan = clearance.scan(rig, 150.0, joints="cross", bearings="pin_in", **contact)
    law = clearance.LinearContact.of_ratio(1e7, 0.25, scan["cross"].mean_mass)
    given = {"clearance": 4e-5, "law": law, "radius": 0.05}
    simulation = clearance.simulate(rig, 150.0, joints="pin_in", turns=1.45, rtol=1e-6, **given)
    found = clearance.compare(scan, simulation)
    assert [item.joint for item in found] == ["pin_in+"] * 4 + ["pin_in-"] * 4
    (doubt,) = scan["cross"].doubts
    assert "no interval is known" in doubt
    for item in found:
        assert not item.reversal.doubts
        assert item.reversal.rigid_ahead < item.reversal.estimate
        assert abs(item.error) < 0.05


@pytest.mark.slow
def test_it_does_not_matter_at_which_times_a_simulation_is_looked_at() -> None:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    contact = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
    simulation = clearance.simulate(
        scene, 300.0, joints="coupler_pin", turns=2.3, rtol=1e-7, **contact
    )
    scan = clearance.scan(scene, 300.0, joints=["coupler_pin"], **contact)
    wanted = clearance.compare(scan, simulation)
    for other in (simulation.evenly(20), simulation.at([0.01, 0.0])):
        for one, two in zip(wanted, clearance.compare(scan, other), strict=True):
            np.testing.assert_array_equal(two.simulated, one.simulated)
        assert other.energy_residual == simulation.energy_residual


def lever(*, mass: float = 1.0) -> cd.Mechanism:
    """A slider-crank with a slider of a mass."""
    text = (
        '<robot name="crank"><link name="base"/><link name="crank"><inertial>'
        '<mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link><link name="rod"><inertial><origin xyz="0.1 0 0"/><mass value="0.2"/>'
        '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<link name="slider"><inertial><mass value="{mass!r}"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="crank"/>'
        '<axis xyz="0 0 1"/></joint><joint name="pin" type="continuous"><parent link="crank"/>'
        '<child link="rod"/><origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>'
        '<joint name="guide" type="prismatic"><parent link="base"/><child link="slider"/>'
        '<origin xyz="0.4 0 0"/><axis xyz="1 0 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        '<loop name="wrist" type="continuous"><predecessor link="rod"><origin xyz="0.3 0 0"/>'
        '</predecessor><successor link="slider"/><axis xyz="0 0 1"/></loop></robot>'
    )
    return cd.load(text)


SPRING, STRONGER = cd.JointSpring("guide", 100.0, 1.0), cd.JointSpring("guide", 100.0, 2.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mass": 2.0}, "description"),
        ({"loads": {"guide": 5.0}}, "loads"),
        ({"loads": {"slider": [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]}}, "loads"),
        ({"gravity": [0.0, -9.81, 0.0]}, "gravity"),
        ({"elements": [STRONGER]}, "elements"),
        ({"elements": []}, "elements"),
        ({"rotor": 0.02}, "rotor"),
    ],
)
def test_scenes_that_differ_are_not_compared(change: dict[str, Any], said: str) -> None:
    """Of copies of the same scene, everything is alike; what is given twice alike as well."""
    contact: dict[str, Any] = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}

    def both(mass: float = 1.0, rotor: float | None = None, **given: Any) -> tuple[Any, ...]:
        acts = {"elements": [SPRING], **given}
        made = cd.Scene(lever(mass=mass), drive="turn", **acts)
        scanned = clearance.scan(made, 100.0, joints="wrist", rotor=rotor, **contact)
        return scanned, clearance.simulate(
            made, 100.0, joints="wrist", turns=0.02, rotor=rotor, position=0.3, **contact
        )

    scan, own = both()
    with pytest.raises(cd.ArgumentError, match="too short"):
        clearance.compare(scan, pickle.loads(pickle.dumps(own)).evenly(5))
    others, simulation = both(**change)
    for pair in ((scan, simulation), (others, own)):
        with pytest.raises(cd.ArgumentError, match=f"differ in their {said};"):
            clearance.compare(*pair)
    again, simulation = both()
    with pytest.raises(cd.ArgumentError, match="too short"):
        clearance.compare(scan, simulation)
    assert again.made_of == scan.made_of


@pytest.mark.slow
def test_pin_bearings_that_differ_are_not_compared() -> None:
    rig = scene(disc(0.5, (1.5e-4, 1.5e-4, 3e-4)), np.radians(20.0))
    contact: dict[str, Any] = {
        **{"radius": 0.05, "clearance": 4e-5, "stiffness": 1e7, "damping_ratio": 0.25},
        "bearings": "pin_in",
    }
    scan = clearance.scan(rig, 150.0, joints="cross", **contact)
    law = clearance.LinearContact.of_ratio(1e7, 0.25, scan["cross"].mean_mass)
    given = {"clearance": 4e-5, "law": law, "radius": 0.05}
    simulation = clearance.simulate(rig, 150.0, joints="pin_in", turns=0.02, **given)
    with pytest.raises(cd.ArgumentError, match="too short"):
        clearance.compare(scan, simulation)
    changes: list[tuple[dict[str, Any], str]] = [
        ({"radius": 0.04}, "bearings 0.05 m from its origin, the scan a radius of 0.04 m"),
        ({"damping_ratio": 0.3}, "a damping of"),
        ({"clearance": 5e-5}, "a clearance of"),
        ({"stiffness": 2e7}, "a stiffness of"),
        ({"bearings": ["pin_in", "pin_out"]}, "bearings move together"),
        ({"rotor": 0.1}, "differ in their rotor"),
    ]
    for change, said in changes:
        other = clearance.scan(rig, 150.0, joints="cross", **{**contact, **change})
        with pytest.raises(cd.ArgumentError, match=said):
            clearance.compare(other, simulation)
