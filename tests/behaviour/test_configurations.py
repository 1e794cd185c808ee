"""Configurations as starts and as zeros, branches of scenes that leave loops out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.many_drives import cranks, linkage, on_arms

import cardan_dyn as cd

FREE = (
    '<robot name="r"><link name="g"/><link name="a"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="f" type="floating">'
    '<parent link="g"/><child link="a"/></joint></robot>'
)


def two_linkages(mimic: str = '<mimic joint="crank_0" multiplier="1"/>') -> cd.Mechanism:
    """Two linkages side by side; the crank of the second one follows that of the first."""
    second = linkage(1, "base", "0 0 1").replace(
        '<joint name="crank_1" type="continuous">',
        f'<joint name="crank_1" type="continuous">{mimic}',
    )
    parts = linkage(0, "base", "0 0 0") + second
    return cd.load(f'<robot name="two"><link name="base"/>{parts}</robot>')


@pytest.mark.slow
def test_complete_configurations_are_taken_back() -> None:
    mechanism = cd.load("stewart_platform")
    there = cd.assemble(mechanism, near={"leg_1": 0.05})
    for start in (there, there.positions):
        np.testing.assert_allclose(cd.assemble(mechanism, near=start).x, there.x, atol=1e-15)
    legs = [name for name in mechanism if name.startswith("leg_")]
    scene = cd.Scene(mechanism, drive=legs, near=there)
    np.testing.assert_allclose(scene.configuration().x, there.x, atol=1e-15)
    np.testing.assert_array_equal(scene.near["ball_2"], there.positions["ball_2"])
    again = scene.replace(loads={"leg_1": 3.0})
    np.testing.assert_allclose(again.configuration().x, there.x, atol=1e-15)
    assert scene.sweep([[there.positions[leg] for leg in legs]]).loop_residual < 1e-14


def test_quaternions_and_angles_of_balls_say_the_same() -> None:
    mechanism = cd.load(FREE)
    quaternion = Rotation.from_euler("XYZ", [0.3, -0.5, 1.2]).as_quat()
    by_quaternion = cd.assemble(mechanism, near={"f": [1.0, 2.0, 3.0, *quaternion]})
    by_angles = cd.assemble(mechanism, near={"f": [1.0, 2.0, 3.0, 0.3, -0.5, 1.2]})
    names = ("f.x", "f.y", "f.z", "f.turn_x", "f.turn_y", "f.turn_z")
    by_name = cd.assemble(
        mechanism, near=dict(zip(names, (1.0, 2.0, 3.0, 0.3, -0.5, 1.2), strict=True))
    )
    again = cd.Scene(mechanism, drive="f.x", held=dict.fromkeys(names[1:], 0.0))
    assert again.configuration().positions["f"].shape == (6,)
    for item in (by_quaternion, by_angles, by_name):
        np.testing.assert_array_equal(item.origin("f"), [1.0, 2.0, 3.0])
        expected = Rotation.from_quat(quaternion).as_matrix()
        np.testing.assert_allclose(item.rotation("f"), expected, atol=1e-15)
    both = cd.Scene(
        mechanism,
        drive="f.x",
        held=dict(zip(names[1:], (2.0, 3.0, 0.3, -0.5, 1.2), strict=True)),
        near={"f.x": 1.0},
    )
    np.testing.assert_allclose(
        both.configuration().positions["f"], by_name.positions["f"], atol=1e-15
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([1.0, 2.0], r"near\['f'\] has shape \(2,\), expected \(7,\); or name one of its coord"),
        ([0.0] * 6 + [2.0], "the quaternion .* has length 2, expected 1"),
        ([[0.0] * 7], r"'f' is a floating joint; name one of its coordinates"),
    ],
)
def test_wrong_rows_are_refused(given: list[object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        cd.assemble(cd.load(FREE), near={"f": given})  # type: ignore[dict-item]


@pytest.mark.slow
def test_configurations_become_zeros(tmp_path: Path) -> None:
    mechanism = cd.load("stewart_platform")
    there = cd.assemble(mechanism, near={"leg_1": 0.05})
    zero = cd.assemble(cd.load(cd.write(mechanism, tmp_path / "there.urdf", at=there)))
    for joint in mechanism:
        np.testing.assert_allclose(zero.origin(joint), there.origin(joint), atol=1e-14)


def test_mimics_hold_in_files_of_another_zero(tmp_path: Path) -> None:
    """Their offset is part of the new zero; it is not counted twice."""
    mechanism = two_linkages('<mimic joint="crank_0" multiplier="0.5" offset="0.3"/>')
    there = cd.assemble(mechanism, near={"crank_0": 0.4})
    again = cd.load(cd.write(mechanism, tmp_path / "there.urdf", at=there))
    old = cd.assemble(mechanism, near={"crank_0": 0.6})
    new = cd.assemble(again, near={"crank_0": 0.2})
    for joint in mechanism:
        np.testing.assert_allclose(new.origin(joint), old.origin(joint), atol=1e-11)


@pytest.mark.campaign
@pytest.mark.slow
def test_names_of_branches_do_not_depend_on_outputs() -> None:
    mechanism = two_linkages()
    options = {"drive": "crank_0", "near": {"crank_0": 0.4}, "loads": {"rocker_1": -5.0}}
    full = cd.Scene(mechanism, **options).branches()
    for outputs in (["end_1"], ["end_0"]):
        few = cd.Scene(mechanism, **options, outputs=outputs)
        assert dict(few.branches()) == dict(full)
        for name in full:
            every = cd.Scene(mechanism, **options, branch=name)
            some = every.replace(outputs=outputs)
            first, second = (scene.sweep([0.4])[outputs[0]] for scene in (every, some))
            np.testing.assert_allclose(first.force, second.force, rtol=1e-9, atol=1e-9)
            a, b = every.configuration(), some.configuration()
            np.testing.assert_allclose(a.x, b.x, atol=1e-9)


def test_flips_that_a_mimic_follows_are_poses() -> None:
    """A flipped yoke that nothing counts is a variant; one that turns another link is a pose."""
    mechanism = cd.load("universal_joint")
    held = {"joint_angle": 0.5}
    assert len(cd.Scene(mechanism, drive="bearing_in", held=held).branches()) == 1
    leaf = (
        '<link name="leaf"/><joint name="leaf" type="continuous"><parent link="base"/>'
        '<child link="leaf"/><origin xyz="3 0 0"/><axis xyz="0 0 1"/>'
        '<mimic joint="bearing_out" multiplier="1"/></joint></robot>'
    )
    text = mechanism.to_urdf().replace("</robot>", leaf)
    text = text.replace('<parent link="base"/>', f'<parent link="{mechanism.description.root}"/>')
    branches = cd.Scene(cd.load(text), drive="bearing_in", held=held).branches()
    assert len(branches) == 2
    turned = branches["B"]["leaf"] - branches["A"]["leaf"]
    assert abs(turned) == pytest.approx(np.pi)


def test_outputs_on_moving_bases_have_their_weights() -> None:
    """What carries the wanted joints has to be placed, whether or not its loops are wanted."""
    mechanism = on_arms(3)
    drives = cranks(mechanism)
    options = {"drive": drives, "gravity": (1.0, -2.0, -9.0)}
    positions = np.full((2, len(drives)), 0.1)
    rates = {"speed": np.arange(1.0, 1.0 + len(drives)), "acceleration": 0.5}
    full = cd.Scene(mechanism, **options).sweep(positions, **rates)
    for name in ("middle_2", "end_1", "arm_1", "rocker_0"):
        some = cd.Scene(mechanism, **options, outputs=[name]).sweep(positions, **rates)
        for part in ("force", "moment"):
            first, second = getattr(full[name], part), getattr(some[name], part)
            np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-11)


def test_positions_are_taken_from_configurations(tmp_path: Path) -> None:
    mechanism = cd.load("four_bar")
    there = cd.assemble(mechanism, near={"crank_bearing": 0.7})
    angle = there["crank_bearing"]
    near = cd.Scene(mechanism, drive="crank_bearing", near=there)
    assert dict(near.near) == dict(there)
    held = cd.Scene(mechanism, drive="rocker_bearing", near=dict(there))
    assert held.configuration()["crank_bearing"] == pytest.approx(angle)
    swing = cd.Scene(mechanism, free="crank_bearing", gravity=(0, -9.81, 0))
    assert swing.simulate(0.01, position=there).motion.position("crank_bearing")[0] == angle
    again = cd.load(cd.write(mechanism, tmp_path / "there.urdf", at=dict(there)))
    assert cd.assemble(again)["crank_bearing"] == 0.0


def test_simulations_begin_in_configurations_of_their_scenes() -> None:
    shaft = cd.load("universal_joint")
    scene = cd.Scene(shaft, free="bearing_in", held={"joint_angle": 0.3})
    moved = cd.Scene(shaft, drive="bearing_in", held={"joint_angle": 0.3}, near={"bearing_in": 0.4})
    run = scene.simulate(0.01, position=moved.configuration())
    assert run.motion.position("bearing_in")[0] == pytest.approx(0.4)
    elsewhere = scene.replace(held={"joint_angle": 0.2}).configuration()
    with pytest.raises(cd.ArgumentError, match="the scene holds this joint"):
        scene.simulate(0.01, position=elsewhere)
