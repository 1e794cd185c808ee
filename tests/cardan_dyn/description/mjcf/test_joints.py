"""Joints of MJCF: their frames, axes and limits, counted from the initial configuration."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from testkit.mjcf import of_body

import cardan_dyn as cd
from cardan_dyn.description.description import JointDescription, Limits
from cardan_dyn.description.mjcf.elements import Compiler
from cardan_dyn.description.mjcf.reader import joint
from cardan_dyn.description.read import read


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body('<joint type="screw"/>'), "type is 'screw', expected one of hinge, slide"),
        (of_body('<joint axis="0 0 0"/>'), "axis: a vector of zeros has no direction"),
        (of_body('<joint pos="1 2"/>'), "'1 2' is not 3 finite"),
        (of_body('<joint pos="1,2,3"/>'), "is not 3 finite"),
        (of_body('<joint range="nan 1"/>'), "is not 2 finite"),
        (of_body('<joint limited="true"/>'), "range 0 0 does not ascend"),
        (of_body('<joint limited="1"/>'), "limited is '1', expected one of"),
        (
            of_body('<joint range="0 1"/>', head='<compiler autolimits="false"/>'),
            "without autolimits, a range needs limited=",
        ),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


BODY_IN_PARENT = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.4, 0.5), np.array([1.0, 2.0, 3.0]))
FRAME_IN_BODY = pin.SE3(pin.rpy.rpyToMatrix(-0.2, 0.1, 0.7), np.array([0.1, -0.2, 0.3]))


def described(compiler: Compiler | None = None, **attributes: str) -> tuple[JointDescription, str]:
    return joint(
        attributes,
        "j",
        ("a", "b"),
        BODY_IN_PARENT.homogeneous,
        FRAME_IN_BODY.homogeneous,
        compiler or Compiler(),
        "x",
    )


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
    found, warning = described(type=word, pos="0.4 0.5 0.6", axis="0 3 4")
    assert (found.name, found.type, found.parent, found.child) == ("j", kind, "a", "b")
    assert warning == ""
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
    np.testing.assert_array_equal(found.origin[:3, :3], BODY_IN_PARENT.rotation)


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
        in_frame = np.array([0.4, 0.5, 0.6]) + distance * np.array([1.0, 2.0, 2.0])
        in_body = FRAME_IN_BODY.act(in_frame)
        expected = BODY_IN_PARENT.act(in_body)
        np.testing.assert_allclose((moved @ [*in_body, 1.0])[:3], expected, atol=2e-15)


@pytest.mark.parametrize(
    ("compiler", "attributes", "limits"),
    [
        (Compiler(), {"range": "-30 60"}, (-math.pi / 6, math.pi / 3)),
        (Compiler(), {"range": "-30 60", "limited": "true"}, (-math.pi / 6, math.pi / 3)),
        (Compiler(), {"range": "-30 60", "limited": "auto"}, (-math.pi / 6, math.pi / 3)),
        (Compiler(), {"range": "-30 60", "ref": "30"}, (-math.pi / 3, math.pi / 6)),
        (Compiler(angle=1.0), {"range": "-1 2", "ref": "0.5"}, (-1.5, 1.5)),
        (Compiler(), {"type": "slide", "range": "-1 2", "ref": "0.5"}, (-1.5, 1.5)),
        (
            Compiler(autolimits=False),
            {"type": "slide", "range": "-1 2", "limited": "true"},
            (-1.0, 2.0),
        ),
    ],
)
def test_limits_count_from_the_initial_configuration(
    compiler: Compiler, attributes: dict[str, str], limits: tuple[float, float]
) -> None:
    found, warning = described(compiler, **attributes)
    assert (found.limits.lower, found.limits.upper) == pytest.approx(limits, rel=1e-15)
    assert math.isinf(found.limits.velocity) and math.isinf(found.limits.effort)
    assert found.type == ("prismatic" if "type" in attributes else "revolute")
    if "ref" in attributes:
        counted = float(attributes["ref"])
        assert warning == f"x: its coordinate is zero where the file counts {counted:g} (ref)"
    else:
        assert warning == ""


@pytest.mark.parametrize(
    ("compiler", "attributes"),
    [
        (Compiler(), {}),
        (Compiler(), {"range": "-30 60", "limited": "false"}),
        (Compiler(), {"range": "0 0"}),
        (Compiler(), {"range": "1 -1"}),
        (Compiler(autolimits=False), {"range": "0 0"}),
        (Compiler(autolimits=False), {"range": "-1 2", "limited": "false"}),
        (Compiler(), {"type": "ball", "range": "0 30"}),
    ],
)
def test_joints_without_limits(compiler: Compiler, attributes: dict[str, str]) -> None:
    found, _ = described(compiler, **attributes)
    assert found.limits == Limits()


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"type": "screw"}, "type is 'screw', expected one of hinge, slide, ball, free"),
        ({"range": "2 1", "limited": "true"}, "range 2 1 does not ascend"),
        ({"ref": "x"}, "ref: 'x' is not 1 finite"),
        ({"type": "ball", "pos": "1"}, "pos: '1' is not 3 finite"),
        ({"limited": "yes"}, "limited is 'yes', expected one of false, true, auto"),
    ],
)
def test_joints_that_are_refused(attributes: dict[str, str], message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"^x: {message}"):
        described(**attributes)
