"""Joints of MJCF: their frames, axes and limits, counted from the initial configuration."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from testkit.mjcf import INERTIAL, of_body

import cardan_dyn as cd
from cardan_dyn.core.description.description import JointDescription, Limits
from cardan_dyn.core.description.read import read

BODY_IN_PARENT = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.4, 0.5), np.array([1.0, 2.0, 3.0]))
FRAME_IN_BODY = pin.SE3(pin.rpy.rpyToMatrix(-0.2, 0.1, 0.7), np.array([0.1, -0.2, 0.3]))


def posed(placement: pin.SE3) -> str:
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
    return f'pos="{" ".join(map(repr, placement.translation.tolist()))}" quat="{w} {x} {y} {z}"'


def described(head: str = "", **attributes: str) -> tuple[JointDescription, list[str]]:
    """Return a joint in a frame of a body, and what is said of where it counts from."""
    stated = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    text = (
        f'<mujoco>{head}<worldbody><body name="b" {posed(BODY_IN_PARENT)}>'
        f'<frame {posed(FRAME_IN_BODY)}><joint name="j" {stated}/></frame>'
        f"{INERTIAL.format('1 1 1')}</body></worldbody></mujoco>"
    )
    description = read(text)
    return description.joints[0], [line for line in description.warnings if "(ref)" in line]


@pytest.mark.parametrize(
    ("word", "kind"),
    [
        ("hinge", "continuous"),
        ("slide", "prismatic"),
        ("ball", "spherical"),
        ("free", "floating"),
    ],
)
def test_types_and_ends(word: str, kind: str) -> None:
    """Initially the child stands where the body stands, whatever the joint."""
    found, said = described(type=word, pos="0.4 0.5 0.6", axis="0 3 4")
    assert (found.name, found.type, found.parent, found.child) == ("j", kind, "world", "b")
    assert said == []
    np.testing.assert_allclose(
        found.origin @ found.child_placement, BODY_IN_PARENT.homogeneous, atol=1e-15
    )
    assert found.limits == Limits()


def test_the_default_is_a_hinge_about_z() -> None:
    found, _ = described()
    assert found.type == "continuous"
    np.testing.assert_allclose(found.axis, FRAME_IN_BODY.rotation[:, 2], atol=1e-15)


@pytest.mark.parametrize("word", ["hinge", "slide", "ball"])
def test_the_joint_stands_at_its_point_in_the_frame_around_it(word: str) -> None:
    """In the parent: the body's placement, the frame's in the body, the point in the frame."""
    found, _ = described(type=word, pos="0.4 0.5 0.6", axis="0 3 4")
    point = BODY_IN_PARENT.act(FRAME_IN_BODY.act(np.array([0.4, 0.5, 0.6])))
    np.testing.assert_allclose(found.origin[:3, 3], point, atol=1e-15)
    np.testing.assert_allclose(found.origin[:3, :3], BODY_IN_PARENT.rotation, atol=1e-15)


@pytest.mark.parametrize("word", ["hinge", "slide"])
def test_axes_are_those_of_the_frame_around_the_joint(word: str) -> None:
    found, _ = described(type=word, axis="0 -3 4")
    expected = FRAME_IN_BODY.rotation @ np.array([0.0, -0.6, 0.8])
    np.testing.assert_allclose(found.axis, expected, atol=1e-15)
    np.testing.assert_array_equal(found.axis_2, found.axis)


def test_a_hinge_leaves_the_points_of_its_axis_where_they_are() -> None:
    found, _ = described(pos="0.4 0.5 0.6", axis="1 2 2")
    turn = pin.SE3(pin.AngleAxis(0.8, found.axis).matrix(), np.zeros(3)).homogeneous
    moved = found.origin @ turn @ found.child_placement
    for distance in (0.0, 1.5):
        in_frame = np.array([0.4, 0.5, 0.6]) + distance * np.array([1.0, 2.0, 2.0]) / 3.0
        in_body = FRAME_IN_BODY.act(in_frame)
        expected = BODY_IN_PARENT.act(in_body)
        np.testing.assert_allclose((moved @ [*in_body, 1.0])[:3], expected, atol=2e-15)


RADIAN, BY_HAND = '<compiler angle="radian"/>', '<compiler autolimits="false"/>'


@pytest.mark.parametrize(
    ("head", "attributes", "limits"),
    [
        ("", {"range": "-30 60"}, (-math.pi / 6, math.pi / 3)),
        ("", {"range": "-30 60", "limited": "true"}, (-math.pi / 6, math.pi / 3)),
        ("", {"range": "-30 60", "limited": "auto"}, (-math.pi / 6, math.pi / 3)),
        ("", {"range": "-30 60", "ref": "30"}, (-math.pi / 3, math.pi / 6)),
        (RADIAN, {"range": "-1 2", "ref": "0.5"}, (-1.5, 1.5)),
        ("", {"type": "slide", "range": "-1 2", "ref": "0.5"}, (-1.5, 1.5)),
        (BY_HAND, {"type": "slide", "range": "-1 2", "limited": "true"}, (-1.0, 2.0)),
    ],
)
def test_limits_count_from_the_initial_configuration(
    head: str, attributes: dict[str, str], limits: tuple[float, float]
) -> None:
    found, said = described(head, **attributes)
    assert (found.limits.lower, found.limits.upper) == pytest.approx(limits, rel=1e-15)
    assert math.isinf(found.limits.velocity) and math.isinf(found.limits.effort)
    assert found.type == ("prismatic" if "type" in attributes else "revolute")
    if "ref" in attributes:
        counted = float(attributes["ref"])
        assert said[0].endswith(f"its coordinate is zero where the file counts {counted:g} (ref)")
    else:
        assert said == []


def test_limits_of_effort_are_those_of_all_actuators_on_a_joint() -> None:
    for kind in ("hinge", "slide"):
        found, _ = described(type=kind, actuatorfrcrange="-7 7")
        assert found.limits == Limits(effort=7.0)
    text = of_body('<joint name="j" actuatorfrcrange="-7 5"/>')
    description = read(text)
    assert description.joints[0].limits == Limits(effort=5.0, least_effort=-7.0)
    off = '<joint name="j" actuatorfrcrange="-7 5" actuatorfrclimited="false"/>'
    assert read(of_body(off)).joints[0].limits == Limits()


@pytest.mark.parametrize(
    ("head", "attributes"),
    [
        ("", {}),
        ("", {"range": "-30 60", "limited": "false"}),
        ("", {"range": "0 0"}),
        (BY_HAND, {"range": "0 0"}),
        (BY_HAND, {"range": "-1 2", "limited": "false"}),
        ("", {"type": "ball", "range": "0 30"}),
    ],
)
def test_joints_without_limits(head: str, attributes: dict[str, str]) -> None:
    found, _ = described(head, **attributes)
    assert found.limits == Limits()


HELD = """<mujoco><worldbody><body name="a" pos="1 0 0"><joint name="j" axis="0 1 0"/>{mass}
<body name="b" pos="0 2 0" euler="20 30 0"><joint name="k" {kind} axis="1 2 2" pos="0.3 0 0.1"
  ref="10"/>{mass}<body name="c" pos="0.1 0 0"><joint name="l" axis="1 0 0"/>{mass}</body></body>
</body></worldbody><equality><joint joint1="k" polycoef="0.4 0 0 0 0"/></equality></mujoco>"""


@pytest.mark.parametrize("kind", ["", 'type="slide"'])
def test_a_joint_that_an_equality_holds_is_fixed_there(kind: str) -> None:
    """Against the same joint that moves, at that position."""
    text = HELD.format(kind=kind, mass=INERTIAL.format("1 1.5 2"))
    free = text[: text.index("<equality>")] + "</mujoco>"
    description = read(text)
    assert [joint.type for joint in description.joints] == ["continuous", "fixed", "continuous"]
    assert any("an equality holds it at 0.4" in line for line in description.warnings)
    gravity = (1.0, 2.0, -9.0)
    held = cd.Scene(cd.load(text), drive=["j", "l"], gravity=gravity).sweep([[0.3, -0.2]])
    moved = cd.Scene(cd.load(free), drive=["j", "l"], held={"k": 0.4}, gravity=gravity)
    np.testing.assert_allclose(
        held.drive_effort, moved.sweep([[0.3, -0.2]]).drive_effort, rtol=1e-13
    )


def test_a_coupling_of_a_joint_that_is_held_is_refused() -> None:
    text = HELD.format(kind="", mass=INERTIAL.format("1 1 1"))
    more = '<joint joint1="j" joint2="k"/></equality>'
    with pytest.raises(cd.ModelError, match="a coupling of two joints that move"):
        read(text.replace("</equality>", more))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body('<joint type="screw"/>'), "invalid keyword: 'screw'"),
        (of_body('<joint axis="0 0 0"/>'), "axis too small in joint"),
        (of_body('<joint pos="1 2"/>'), "'pos' does not have enough data"),
        (of_body('<joint pos="1,2,3"/>'), "bad format in attribute 'pos'"),
        (of_body('<joint pos="nan 0 0"/>'), "a number is not finite"),
        (of_body('<joint limited="true"/>'), "range"),
        (of_body('<joint limited="1"/>'), "invalid keyword: '1'"),
        (of_body('<joint range="0 1"/>', head=BY_HAND), "joint has `range` but not `limited`"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"^MJCF text: .*{message}"):
        read(text)
