"""The second reading takes all numbers from the text, whatever numbers the first reader found."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit import scenes
from testkit.disturbing import disturbed
from testkit.linkages import coupling, four_bar, gears, loop
from testkit.mimicking import finger, mimic
from testkit.mixed_chain import MIXED

from cardan_dyn.core.description import second_reading
from cardan_dyn.core.description.description import Description, SourceText
from cardan_dyn.core.description.read import bundled_names, read
from cardan_dyn.core.description.second_reading import reread

ROUNDING = 1e-15
"""Rotations are multiplied in another order than by the first reader; it showed 1e-16 at most."""


TEXTS = {
    **{name: scenes.text(name) for name in bundled_names()},
    "mixed": MIXED,
    "gears": gears(coupling("g", "a", "b", -2.5), coupling("h", "b", "c", 0.1), third=True),
    "mimics": finger(mimic("knuckle", -1.5, 0.4), '<mimic joint="middle"/>'),
}


@pytest.mark.parametrize("urdf", TEXTS.values(), ids=TEXTS.keys())
def test_both_readers_find_the_same_numbers(urdf: str) -> None:
    """The second one starts from a description whose numbers are all wrong."""
    description = read(urdf)
    wrong = disturbed(description)
    assert not wrong.agrees(description, ROUNDING)
    assert reread(wrong).agrees(description, ROUNDING)


ANGLES = st.floats(-7.0, 7.0)
PLACED = """<robot name="r"><link name="a"/><link name="b"><inertial>
<origin xyz="1 2 3" rpy="{rpy}"/><mass value="4"/>
<inertia ixx="1" iyy="2" izz="2.5" ixy="0.1" ixz="0.2" iyz="0.3"/></inertial></link>
<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><origin xyz="4 5 6" rpy="{rpy}"/>
<axis xyz="0 3 4"/><axis2 xyz="-2 0 0"/></joint></robot>"""


@settings(deadline=None, derandomize=True, max_examples=50)
@given(ANGLES, ANGLES, ANGLES)
def test_angles_are_roll_pitch_and_yaw(roll: float, pitch: float, yaw: float) -> None:
    """Against Pinocchio's rotation of these angles."""
    turn = pin.rpy.rpyToMatrix(roll, pitch, yaw)
    urdf = PLACED.format(rpy=f"{roll!r} {pitch!r} {yaw!r}", kind="universal")
    description = reread(read(urdf))
    (joint,), (_, link) = description.joints, description.links
    np.testing.assert_allclose(joint.origin[:3, :3], turn, atol=1e-15)
    assert joint.origin[:3, 3].tolist() == [4.0, 5.0, 6.0]
    tensor = np.array([[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 2.5]])
    np.testing.assert_allclose(link.inertia, turn @ tensor @ turn.T, atol=1e-14)
    assert link.centre.tolist() == [1.0, 2.0, 3.0]
    np.testing.assert_allclose(joint.axis, [0.0, 0.6, 0.8], atol=1e-15)
    np.testing.assert_allclose(joint.axis_2, [-1.0, 0.0, 0.0], atol=1e-15)


def test_only_universal_joints_have_a_second_axis() -> None:
    for kind in ("revolute", "continuous", "prismatic", "planar", "spherical"):
        (joint,) = reread(read(PLACED.format(rpy="0 0 0", kind=kind))).joints
        np.testing.assert_allclose(joint.axis_2, [0.0, 0.6, 0.8], atol=1e-15)


def test_the_axis_of_a_fixed_joint_is_not_read() -> None:
    (joint,) = reread(read(PLACED.format(rpy="0 0 0", kind="fixed"))).joints
    assert joint.axis.tolist() == [1.0, 0.0, 0.0]


def test_attributes_that_are_not_stated_have_their_defaults() -> None:
    urdf = """<robot name="r"><link name="a"/><link name="b"><inertial><mass value="2"/>
    <inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="continuous">
    <parent link="a"/><child link="b"/><origin/></joint></robot>"""
    description = reread(disturbed(read(urdf)))
    assert description == read(urdf)
    assert description.joints[0].axis.tolist() == [1.0, 0.0, 0.0]
    assert description.links[1].inertia.tolist() == np.eye(3).tolist()


@pytest.mark.parametrize("mass", ["0", "1e-320"])
def test_a_mass_of_zero_leaves_the_inertia(mass: str) -> None:
    urdf = f"""<robot name="r"><link name="a"><inertial><origin xyz="1 2 3"/><mass value="{mass}"/>
    <inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"""
    assert reread(disturbed(read(urdf, strict=False))) == read(urdf, strict=False)
    assert read(urdf, strict=False).links[0].inertia.tolist() == np.eye(3).tolist()


ISAAC = (
    '<loop_joint name="c" type="spherical"><link1 link="coupler" rpy="0.1 0.2 0.3" xyz="2 2 0"/>'
    '<link2 link="rocker"><origin xyz="0 2.5 0"/></link2><axis xyz="0 0 1"/></loop_joint>'
)


def test_isaac_writes_placements_at_the_sides_themselves() -> None:
    urdf = four_bar("").replace("</robot>", f"{ISAAC}</robot>")
    (found,) = reread(disturbed(read(urdf))).loops
    np.testing.assert_allclose(
        found.predecessor_origin[:3, :3], pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), atol=1e-15
    )
    assert found.predecessor_origin[:3, 3].tolist() == [2.0, 2.0, 0.0]
    assert found.successor_origin[:3, 3].tolist() == [0.0, 2.5, 0.0]


@pytest.mark.parametrize("isaac_first", [True, False])
def test_of_two_notations_that_of_urdf_plus_is_read(isaac_first: bool) -> None:
    elsewhere = ISAAC.replace('xyz="2 2 0"', 'xyz="9 9 9"')
    plus = four_bar(loop("spherical"))
    before, after = ("<loop ", f"{elsewhere}<loop ") if isaac_first else ("</loop>",) * 2
    urdf = plus.replace(before, after if isaac_first else f"</loop>{elsewhere}", 1)
    (found,) = reread(disturbed(read(urdf))).loops
    assert found.predecessor_origin[:3, 3].tolist() == [2.0, 2.0, 0.0]


def test_loops_of_a_file_beside_the_urdf_keep_their_numbers(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(PLACED.format(rpy="0 0 0", kind="fixed"), encoding="utf-8")
    (tmp_path / "r.yaml").write_text(
        "closed_loop: [[a, b]]\njoint_name: [j]\njoint_type: [revolute]", encoding="utf-8"
    )
    description = read(tmp_path / "r.urdf")
    wrong = disturbed(description)
    found = reread(wrong)
    assert found.loops == wrong.loops
    # The file gives the joint another type, by which its axis counts.
    assert found.joints[0].type == "revolute"
    assert found.joints == description.joints


MJCF = '<mujoco><worldbody><body><joint/><geom size="1"/></body></worldbody></mujoco>'


def test_mjcf_is_read_from_where_mujoco_puts_its_bodies() -> None:
    first = read(MJCF)
    assert not disturbed(first).agrees(first, 1e-6)
    assert reread(disturbed(first)).agrees(first, 1e-14)


@pytest.mark.parametrize("held", ["a", "b"])
def test_joints_of_a_body_of_mjcf_of_which_one_is_held(held: str) -> None:
    """Links between the joints of a body stand before the later ones have moved."""
    first = read(
        '<mujoco><worldbody><body pos="0 0 1"><joint name="a" type="slide" axis="1 0 0"/>'
        '<joint name="b" pos="0.1 0 0"/><joint name="c" axis="0 1 0"/><geom size="1"/></body>'
        f'</worldbody><equality><joint joint1="{held}" polycoef="0.3 0 0 0 0"/></equality></mujoco>'
    )
    assert not disturbed(first).agrees(first, 1e-6)
    assert reread(disturbed(first)).agrees(first, 1e-14)


def test_a_description_without_a_text_stays_as_it_is() -> None:
    description = replace(read(TEXTS["mixed"]), source=None)
    assert reread(description) is description


def test_what_is_no_number_stays_as_it_is() -> None:
    """Names, types, limits, order, drives and warnings are those of the first reader."""
    first = read(MIXED)
    description: Description = reread(first)
    for field in fields(Description):
        if field.name not in ("links", "joints", "loops", "couplings"):
            assert getattr(description, field.name) is getattr(first, field.name)
    for rereaded, joint in zip(description.joints, first.joints, strict=True):
        assert rereaded.limits is joint.limits
        assert rereaded.child_placement is joint.child_placement


def test_a_text_without_what_the_first_reader_found() -> None:
    description = read(TEXTS["universal_joint"])
    cut = TEXTS["universal_joint"].replace("<mass ", "<weight ")
    with pytest.raises(ValueError, match="<inertial> has no <mass>, which the first reader found"):
        reread(replace(description, source=SourceText(cut, None)))


def test_numbers_that_stand_in_both_readings_differ_in_memory() -> None:
    """No array of the second reading is one of the first."""
    first = read(MIXED)
    second = reread(first)
    for ours, theirs in zip(second.joints, first.joints, strict=True):
        assert not np.shares_memory(ours.origin, theirs.origin)
        assert not np.shares_memory(ours.axis, theirs.axis)


def test_the_second_reader_uses_nothing_of_the_first() -> None:
    """Of the package it takes the records and errors alone: no function that could be wrong."""
    taken = {
        item.__module__
        for item in vars(second_reading).values()
        if getattr(item, "__module__", "").startswith("cardan_dyn.")
    }
    others = {"cardan_dyn.core.description.description", "cardan_dyn.kit.errors"}
    assert taken == {*others, second_reading.__name__}
