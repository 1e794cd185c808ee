"""Damping, friction and springs of a description as elements."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import four_bar, loop

import cardan_dyn as cd

PLUS = four_bar(loop("continuous"))


def rubbing(dynamics: str) -> cd.Mechanism:
    return cd.load(PLUS.replace("</joint>", f"<dynamics {dynamics}/></joint>", 1))


def test_damping_and_friction_become_elements() -> None:
    mechanism = rubbing('damping="2" friction="0.5"')
    assert dict(mechanism.joint_dynamics) == {"a": (2.0, 0.5)}
    assert cd.described_elements(mechanism, transition=0.1) == (
        cd.JointSpring("a", 0.0, 2.0, name="damping of a"),
        cd.JointFriction("a", 0.5, 0.1, name="friction of a"),
    )
    assert cd.described_elements(rubbing('damping="2"')) == (
        cd.JointSpring("a", 0.0, 2.0, name="damping of a"),
    )
    assert cd.described_elements(cd.load(PLUS)) == ()


def test_they_act_only_where_they_are_given_to_a_scene() -> None:
    mechanism, speeds = rubbing('damping="2"'), np.array([1.0, 3.0])
    plain = cd.Scene(mechanism, drive="a")
    damped = plain.replace(elements=cd.described_elements(mechanism))
    without, taken = (scene.sweep([0.3, 0.3], speed=speeds) for scene in (plain, damped))
    np.testing.assert_allclose(taken.drive_effort - without.drive_effort, 2.0 * speeds, atol=1e-12)


def test_they_are_written_and_read_back() -> None:
    mechanism = rubbing('damping="2" friction="0.5"')
    again = cd.load(mechanism.to_urdf())
    assert again.description == mechanism.description
    assert cd.described_elements(again) == cd.described_elements(mechanism)


def test_coordinates_of_joints_with_several_all_rub_and_balls_do_not() -> None:
    text = (
        '<robot name="r"><link name="g"/><link name="h"/><link name="i"/>'
        '<joint name="u" type="universal"><parent link="g"/><child link="h"/><axis xyz="1 0 0"/>'
        '<axis2 xyz="0 1 0"/><dynamics damping="1"/></joint>'
        '<joint name="s" type="spherical"><parent link="h"/><child link="i"/>'
        '<dynamics friction="1"/></joint></robot>'
    )
    mechanism = cd.load(text)
    assert list(mechanism.joint_dynamics) == ["u.turn_1", "u.turn_2"]
    assert [warning.split(": ", 1)[1] for warning in mechanism.warnings] == [
        "damping or friction of 1 joint (u): "
        "Scene(..., elements=described_elements(mechanism)) takes it in, as "
        "`cardan-dyn simulate` and `vibration` do; other scenes are without it",
        "damping or friction of 1 ball (s) left out: wrenches are without it",
    ]


def test_negative_values_are_refused() -> None:
    with pytest.raises(cd.ModelError, match="damping of 'a' is -2, negative"):
        cd.described_elements(rubbing('damping="-2"'))
    with pytest.raises(cd.ModelError, match="stiffness of 'a' is -3, negative"):
        cd.described_elements(rubbing('spring_stiffness="-3"'))


def test_springs_become_elements_and_are_written() -> None:
    mechanism = rubbing('damping="2" spring_stiffness="3" spring_reference="-0.5"')
    assert cd.described_elements(mechanism) == (
        cd.JointSpring("a", 0.0, 2.0, name="damping of a"),
        cd.JointSpring("a", 3.0, 0.0, -0.5, name="spring of a"),
    )
    assert "damping, friction or springs of 1 joint (a): Scene(" in mechanism.warnings[0]
    assert cd.load(mechanism.to_urdf()).description == mechanism.description


def test_a_loop_has_them_too() -> None:
    text = PLUS.replace("</loop>", '<dynamics friction="2" spring_stiffness="3"/></loop>')
    mechanism = cd.load(text)
    name = mechanism.loops[0].joint
    assert dict(mechanism.joint_springs) == {name: (3.0, 0.0)}
    assert dict(mechanism.joint_dynamics) == {name: (0.0, 2.0)}
    assert cd.load(mechanism.to_urdf()).description == mechanism.description


MJCF = """<mujoco><compiler angle="{unit}" autolimits="true"/><default>
  <default class="stiff"><joint stiffness="3 0"/></default></default><worldbody>
  <body name="arm"><inertial pos="0 0 -1" mass="2" diaginertia="1 1 1"/>
    <joint name="h" class="stiff" axis="0 1 0" damping="0.5" frictionloss="0.25"
      ref="{ref}" springref="{springref}"/></body>
  <body name="slider"><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
    <joint name="s" type="slide" axis="1 0 0" stiffness="7" ref="0.2"/></body>
  <body name="ball"><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
    <joint name="b" type="ball"{ball}/></body>
</worldbody></mujoco>"""


def test_springs_of_mjcf_rest_where_the_file_counts() -> None:
    """By hand: h rests 90° - 30° beyond its initial place, s 0.2 m behind it."""
    in_radians = (repr(np.pi / 6.0), repr(np.pi / 2.0))
    for unit, ref, springref in (("degree", "30", "90"), ("radian", *in_radians)):
        mechanism = cd.load(MJCF.format(unit=unit, ref=ref, springref=springref, ball=""))
        springs = mechanism.joint_springs
        assert springs["h"] == pytest.approx((3.0, np.pi / 3.0), rel=1e-15)
        assert springs["s"] == (7.0, -0.2)
        assert dict(mechanism.joint_dynamics) == {"h": (0.5, 0.25)}
        assert len([line for line in mechanism.warnings if "described_elements" in line]) == 1
    # At rest in the middle: the drive holds the spring's effort alone.
    scene = cd.Scene(
        mechanism,
        drive=["h", "s"],
        held=dict.fromkeys(("b.x", "b.y", "b.z"), 0.0),
        elements=cd.described_elements(mechanism),
    )
    efforts = scene.sweep([[0.1, 0.05]]).drive_effort[0]
    np.testing.assert_allclose(efforts, [3.0 * (0.1 - np.pi / 3.0), 7.0 * 0.25], rtol=1e-13)


def test_they_are_written_as_mjcf_and_read_back(tmp_path: Path) -> None:
    mechanism = cd.load(MJCF.format(unit="degree", ref="0", springref="40", ball=""))
    again = cd.load(cd.write(mechanism, tmp_path / "again.xml"))
    # Its bodies stand in another order.
    assert dict(again.joint_springs) == dict(mechanism.joint_springs)
    assert dict(again.joint_dynamics) == dict(mechanism.joint_dynamics)
    assert len(mechanism.joint_springs) == 2


@pytest.mark.parametrize(
    ("attributes", "noted"),
    [
        (' damping="1"', "joint 'b': damping 1"),
        (' stiffness="2"', "joint 'b': stiffness 2"),
    ],
)
def test_what_a_ball_of_mjcf_states_is_refused(attributes: str, noted: str) -> None:
    text = MJCF.format(unit="radian", ref="0", springref="0", ball=attributes)
    with pytest.raises(cd.ModelError, match=f"forces that wrenches leave out: {noted}; load"):
        cd.load(text)
    assert cd.load(text, strict=False).warnings[-2].endswith(f"{noted} left out of the wrenches")


@pytest.mark.parametrize(
    ("attribute", "noted"),
    [
        ('damping="0.5 1"', "damping 0.5 1"),
        ('damping="-0.5"', "damping -0.5"),
    ],
)
def test_what_no_element_says_is_refused(attribute: str, noted: str) -> None:
    text = MJCF.format(unit="radian", ref="0", springref="0", ball="")
    with pytest.raises(cd.ModelError, match=f"joint 'h': {noted}; load"):
        cd.load(text.replace('damping="0.5"', attribute))


def test_a_new_zero_moves_the_rest_of_a_spring(tmp_path: Path) -> None:
    mechanism = rubbing('spring_stiffness="3" spring_reference="0.5"')
    closed = cd.assemble(mechanism, near={"a": 0.3})
    moved = cd.load(cd.write(mechanism, tmp_path / "moved.urdf", at=closed))
    stiffness, rest = moved.joint_springs["a"]
    assert (stiffness, rest) == (3.0, pytest.approx(0.2, abs=1e-12))
