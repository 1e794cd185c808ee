"""Opened scenes: what is free, and how it gives way, by experiments with forces."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.motion.clearance.opened_joint import OpenedJoint
from cardan_dyn.motion.clearance.opened_scene import Opened, OpenPin, opened

LAW = cd.LinearContact(1e8)


def clearance(joint: str, reach: float | None = None) -> OpenPin:
    return OpenPin(joint, 2e-4, LAW, 0.0, 0.0, reach)


def loose(name: str, drive: str, joint: str, reach: float | None = None, **more: float) -> Opened:
    return opened(cd.Scene(cd.load(name), drive=drive), [clearance(joint, reach)], **more)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "drive", "joint"),
    [
        ("slider_crank", "crank_bearing", "crank_pin"),
        ("slider_crank", "crank_bearing", "piston_pin"),
        ("four_bar", "crank_bearing", "rocker_pin"),
        ("needle_drive", "main_shaft", "coupler_pin"),
    ],
)
def test_a_short_push_moves_the_pin_by_its_reduced_mass(name: str, drive: str, joint: str) -> None:
    """Differences of simulated motions with and without a force between pin and bush."""
    found = loose(name, drive, joint)
    tight = cd.Scene(cd.load(name), drive=drive)
    x = tight.sweep([0.7]).motion.rows[0]
    mobility = OpenedJoint(tight.solver, None, joint).mobility(x)

    slides = [f"{joint}.slide_1", f"{joint}.slide_2"]
    # A short time: what the push moves grows with its square, and the next term with its fourth.
    time, moved = 1e-4, np.empty((2, 2))
    for column, slide in enumerate(slides):
        ends = []
        for push in (1.0, -1.0):
            motion = found.scene.simulate(
                time, position={found.drive: 0.7}, motion={found.drive: 0.0},
                loads={slide: push}, rtol=1e-12,
            )  # fmt: skip
            ends.append([motion.motion.position(joint)[-1, k] for k in range(2)])
        moved[:, column] = (np.array(ends[0]) - np.array(ends[1])) / time**2
    # Both are matrices of the same quantity, along axes that are turned against each other.
    np.testing.assert_allclose(
        np.linalg.eigvalsh(0.5 * (moved + moved.T)), np.linalg.eigvalsh(mobility.matrix), rtol=1e-6
    )


def test_freedoms_of_the_pins_of_a_universal_joint() -> None:
    """The cross tilts and turns on if one pin is open, as the loops leave it."""
    mechanism = cd.load("universal_joint")
    pins = ["pin_in", "pin_out"]
    scene = cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": 0.35})
    one = opened(scene, [clearance(pins[0], 0.03)])
    assert len(one.scene.coordinates) == 1 + 2
    both = opened(scene, [clearance(pin, 0.03) for pin in pins])
    assert len(both.scene.coordinates) == 1 + 5
    assert [len(indices) for indices in both.contacts.values()] == [2, 2]
    with pytest.raises(cd.ModelError, match="hold the pin"):
        opened(scene, [clearance(pins[0])])


def test_arguments_of_the_scene_are_kept() -> None:
    mechanism = cd.load("slider_crank")
    spring = cd.JointSpring("crank_pin", 3.0, rest=0.2)
    scene = cd.Scene(
        mechanism, drive="crank_bearing", loads={"piston_guide": -5.0, "crank_pin": 0.5},
        gravity=(0.0, -9.81, 0.0), elements=[spring],
    )  # fmt: skip
    found = opened(scene, [clearance("crank_pin")])
    assert dict(found.scene.loads) == {"piston_guide": -5.0, "crank_pin.turn": 0.5}
    np.testing.assert_array_equal(found.scene.gravity, [0.0, -9.81, 0.0])
    assert found.scene.elements[0].joints == ("crank_pin.turn",)
    assert found.contacts == {"crank_pin": (1,)}
    # With the pin in the middle, both move as one: efforts of the drive agree.
    at = {"crank_bearing": 0.4, "crank_pin.slide_1": 0.0, "crank_pin.slide_2": 0.0}
    positions = [at[name] for name in found.scene.coordinates]
    plain = found.scene.replace(elements=[spring.__class__("crank_pin.turn", 3.0, rest=0.2)])
    plain = plain.replace(drive=plain.coordinates)
    efforts = plain.sweep([positions], [[7.0, 0.0, 0.0]]).drive_effort[0]
    assert efforts[0] == pytest.approx(scene.sweep([0.4], 7.0).drive_effort[0], rel=1e-12)


def test_a_rotor_turns_with_the_drive() -> None:
    plain = loose("slider_crank", "crank_bearing", "crank_pin")
    heavy = loose("slider_crank", "crank_bearing", "crank_pin", rotor=0.7)
    a = [
        item.scene.replace(drive=item.scene.coordinates)
        .sweep([[0.4, 0.0, 0.0]], 0.0, [[2.0, 0.0, 0.0]])
        .drive_effort[0, 0]
        for item in (plain, heavy)
    ]
    assert a[1] - a[0] == pytest.approx(1.4, rel=1e-12)
    slide = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    assert slide.mechanism.description.joints[0].name == "crank_bearing"


def test_joints_of_gears_are_refused() -> None:
    text = """<robot name="geared"><link name="base"/>
    <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
    iyz="0"/></inertial></link>
    <link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
    iyz="0"/></inertial></link>
    <joint name="first" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    </joint>
    <joint name="second" type="continuous"><parent link="base"/><child link="b"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/><mimic joint="first" multiplier="-2"/></joint>
    </robot>"""
    scene = cd.Scene(cd.load(text), drive="first")
    with pytest.raises(cd.ModelError, match="a coupling depends on it"):
        opened(scene, [clearance("second")])
