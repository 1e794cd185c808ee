"""`<constraint>` as it is proposed for ROS: types, frames, axes, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.other_notations import CONSTRAINT, PLUS, TREE

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.second_reading import reread

UNIVERSAL = CONSTRAINT.format(kind="universal", more='<child_axis xyz="0 0.5 0"/>')


def constrained(text: str) -> Description:
    return read(TREE.format(text))


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        *((kind, kind) for kind in ("revolute", "prismatic", "spherical")),
        *((f"{kind}_joint", kind) for kind in ("revolute", "prismatic", "spherical")),
        ("link", "fixed"),
    ],
)
def test_types(kind: str, expected: str) -> None:
    description = constrained(CONSTRAINT.format(kind=kind, more=""))
    (found,) = description.loops
    assert (found.name, found.type) == ("c", expected)
    assert (found.predecessor, found.successor) == ("coupler", "rocker")
    assert found.predecessor_origin[:3, 3].tolist() == [2.0, 2.0, 0.0]
    assert found.successor_origin[:3, 3].tolist() == [0.0, 2.5, 0.0]
    if expected in ("revolute", "prismatic"):
        assert found.axis.tolist() == found.axis_2.tolist() == [0.0, 0.0, 1.0]
    assert description.notation == "ROS <constraint>"
    assert reread(description).loops[0].type == expected


def test_a_universal_joint_has_an_axis_on_each_side() -> None:
    for text in (UNIVERSAL, UNIVERSAL.replace("universal", "universal_joint")):
        description = constrained(text)
        (found,) = description.loops
        assert found.type == "universal"
        assert (found.axis.tolist(), found.axis_2.tolist()) == ([0, 0, 1], [0, 1, 0])
        assert reread(description).loops == description.loops


def test_a_loop_between_a_link_and_itself_is_refused() -> None:
    text = CONSTRAINT.format(kind="revolute", more="").replace('link="coupler"', 'link="rocker"')
    with pytest.raises(cd.ModelError, match="loop 'c' connects 'rocker' and 'rocker'"):
        cd.load(TREE.format(text))


def test_what_is_not_stated_has_a_default() -> None:
    text = '<constraint name="c" type="revolute"><child link="rocker"/><parent link="coupler"/>'
    description = constrained(f"{text}</constraint>")
    (found,) = description.loops
    np.testing.assert_array_equal(found.predecessor_origin, np.eye(4))
    np.testing.assert_array_equal(found.successor_origin, np.eye(4))
    assert found.axis.tolist() == [1.0, 0.0, 0.0]
    assert reread(description).loops == description.loops


def test_both_sides_may_state_the_same_axis() -> None:
    for axis in ("0 0 1", "0 0 -3"):
        text = CONSTRAINT.format(kind="revolute", more=f'<child_axis xyz="{axis}"/>')
        assert constrained(text).loops[0].axis.tolist() == [0.0, 0.0, 1.0]


def test_two_notations_say_the_same() -> None:
    text = CONSTRAINT.format(kind="revolute", more="").replace('name="c"', 'name="other"')
    description = read(PLUS.replace("</robot>", f"{text}</robot>"))
    assert description.notation == (
        "URDF+ <loop>; ROS <constraint> closes the same links and is not used"
    )
    assert reread(description).loops == description.loops


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('type="revolute"', "", "type None is not supported; types: link, prismatic"),
        ('type="revolute"', 'type="ball"', "type 'ball' is not supported"),
        ('type="revolute"', 'type="revolut"', "did you mean 'revolute'"),
        ('link="coupler"', 'link="copler"', "parent link 'copler' does not exist; .*'coupler'"),
        ('<child link="rocker"/>', "", '<child link="..."/> is missing'),
        ('xyz="2 2 0"', 'xyz="2 2"', "origin xyz: '2 2' is not 3 finite"),
        ('xyz="0 0 2"', 'xyz="0 0 0"', "the parent_axis .* has no direction"),
        ("</constraint>", '<child_axis xyz="0 1 1"/></constraint>', "share the axis of a hinge"),
        ("</constraint>", "<parent_origin/></constraint>", "there are 2 <parent_origin>"),
        ("<child_origin", "<child_orign", "did you mean 'child_origin'"),
        ("<parent_axis xyz", "<parent_axis xzy", "did you mean 'xyz'"),
        ('name="c"', "", "a <constraint> has no name"),
        ('name="c"', 'name="a"', "names that occur twice: a"),
    ],
)
def test_refused(old: str, new: str, message: str) -> None:
    text = CONSTRAINT.format(kind="revolute", more="")
    assert old in text
    with pytest.raises(cd.ModelError, match=message):
        constrained(text.replace(old, new))


def test_axes_of_a_universal_joint_are_at_right_angles() -> None:
    with pytest.raises(cd.ModelError, match="needs <parent_axis> and <child_axis> at right angles"):
        constrained(UNIVERSAL.replace("0 0.5 0", "0 1 1"))
