"""Damping and friction of a description as elements."""

from __future__ import annotations

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
        "damping or friction of 1 joint (u) left out: "
        "Scene(..., elements=described_elements(mechanism)) takes it in",
        "damping or friction of 1 ball (s) left out: wrenches are without it",
    ]


def test_negative_values_are_refused() -> None:
    with pytest.raises(cd.ModelError, match="damping of 'a' is -2, negative"):
        cd.described_elements(rubbing('damping="-2"'))
