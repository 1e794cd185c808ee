"""Single elements of URDF, read and checked."""

from __future__ import annotations

from xml.etree.ElementTree import fromstring

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from testkit import scenes

import cardan_dyn as cd
from cardan_dyn.core.description import elements

LINKS = {"a": None, "b": None}


def test_types() -> None:
    """What closes a loop may stand in the tree; a loop of six freedoms closes nothing."""
    assert {"floating"} == elements.TREE_TYPES - elements.LOOP_TYPES
    assert elements.LOOP_TYPES < elements.TREE_TYPES
    assert not elements.JOINT_TYPES & elements.ADDED_TYPES


@given(st.lists(st.floats(-1e50, 1e50), min_size=1, max_size=6))
def test_numbers_come_back_to_the_last_bit(values: list[float]) -> None:
    expected = [0.0 if abs(value) < 1e-150 else value for value in values]
    text = " \n\t".join(map(repr, values))
    assert elements.numbers(f" {text} ", len(values), "", "x").tolist() == expected


def test_numbers_have_a_default() -> None:
    assert elements.numbers(None, 2, "3 4.5", "x").tolist() == [3.0, 4.5]


@pytest.mark.parametrize(
    "text", ["", "1", "1 2 3", "1_0 2", "\u0661 2", "1,2", "nan 1", "inf 1", "0x1 2", "1. e2"]
)
def test_what_is_no_pair_of_numbers(text: str) -> None:
    with pytest.raises(cd.ModelError, match=r"axis: .* is not 2 finite numbers"):
        elements.numbers(text, 2, "0 0", "axis")


def test_numbers_beyond_the_range() -> None:
    with pytest.raises(cd.ModelError, match=r"beyond 1e\+50; choose units"):
        elements.numbers("1.1e50", 1, "", "mass")


@given(*[st.floats(-7.0, 7.0)] * 3)
def test_rotation(roll: float, pitch: float, yaw: float) -> None:
    """Against Pinocchio's function."""
    expected = pin.rpy.rpyToMatrix(roll, pitch, yaw)
    np.testing.assert_allclose(elements.rotation(roll, pitch, yaw), expected, atol=1e-15)


def test_placement() -> None:
    """A quarter turn about x, then about z: y goes to z, and x to y."""
    quarter = repr(np.pi / 2)
    element = fromstring(f'<joint><origin xyz="1 2 3" rpy="{quarter} 0 {quarter}"/></joint>')
    expected = [[0, 0, 1, 1], [1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(elements.placement(element, "x"), expected, atol=1e-15)
    np.testing.assert_array_equal(elements.placement(fromstring("<joint/>"), "x"), np.eye(4))


def test_names() -> None:
    robot = fromstring('<robot><link name="a"/><joint name="a"/><link name="b"/></robot>')
    assert elements.names(robot, "link", "x") == ["a", "b"]
    with pytest.raises(cd.ModelError, match="x: link names that occur twice: a, b"):
        elements.check_unique(["b", "a", "c", "a", "b"], "link", "x")
    with pytest.raises(cd.ModelError, match="x: a <link> has no name"):
        elements.name_of(fromstring('<link name=""/>'), "x")


def test_links() -> None:
    element = fromstring('<joint><parent link="a"/><child link="c"/></joint>')
    assert elements.link_of(element, "parent", LINKS, "x") == "a"
    with pytest.raises(cd.ModelError, match="x: child link 'c' does not exist; links: a, b"):
        elements.link_of(element, "child", LINKS, "x")
    with pytest.raises(cd.ModelError, match=r'<successor link="..."/> is missing'):
        elements.link_of(element, "successor", LINKS, "x")


def test_size() -> None:
    elements.check_size(elements.MOST_LINKS, "x")
    with pytest.raises(cd.ModelError, match="x: there are 2001 links, the limit is 2000"):
        elements.check_size(elements.MOST_LINKS + 1, "x")


def test_axes() -> None:
    element = fromstring('<loop><axis xyz="0 3 4"/><axis2 xyz="-2 0 0"/></loop>')
    axis, axis_2 = elements.axes_of(element, "universal", "x")
    np.testing.assert_allclose(axis, [0.0, 0.6, 0.8], rtol=1e-15)
    np.testing.assert_array_equal(axis_2, [-1.0, 0.0, 0.0])
    # A second axis of other joints has no meaning.
    axis, axis_2 = elements.axes_of(element, "spherical", "x")
    np.testing.assert_array_equal(axis, axis_2)
    np.testing.assert_array_equal(elements.axis_of(fromstring("<joint/>"), "x"), [1.0, 0.0, 0.0])


@pytest.mark.parametrize(("tilt", "accepted"), [("9e-10", True), ("1.1e-9", False)])
def test_right_angles(tilt: str, accepted: bool) -> None:
    element = fromstring(f'<loop><axis xyz="1 0 0"/><axis2 xyz="{tilt} 1 0"/></loop>')
    if accepted:
        assert elements.axes_of(element, "universal", "x")[1][0] == pytest.approx(9e-10)
    else:
        with pytest.raises(cd.ModelError, match="needs <axis> and <axis2> at right angles"):
            elements.axes_of(element, "universal", "x")


def test_loop() -> None:
    element = fromstring(
        '<loop name="l" type="cylindrical"><predecessor link="b"><origin xyz="1 2 3"/>'
        '</predecessor><successor link="a" xyz="4 5 6"/><axis xyz="0 0 2"/></loop>'
    )
    loop = elements.loop(element, LINKS, "x")
    assert (loop.name, loop.type) == ("l", "cylindrical")
    assert (loop.predecessor, loop.successor) == ("b", "a")
    assert loop.predecessor_origin[:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert loop.successor_origin[:3, 3].tolist() == [4.0, 5.0, 6.0]
    assert loop.axis.tolist() == loop.axis_2.tolist() == [0.0, 0.0, 1.0]
    element.set("type", "floating")
    with pytest.raises(cd.ModelError, match="x: loop 'l': type 'floating' is not supported"):
        elements.loop(element, LINKS, "x")


def with_axis(axis: str) -> str:
    """Return the universal joint with another axis of its first pin."""
    joint = scenes.text("universal_joint")
    assert '<axis xyz="0 1 0"/>' in joint
    return joint.replace('<axis xyz="0 1 0"/>', f'<axis xyz="{axis}"/>', 1)


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ("1e200 1e200 0", "beyond 1e[+]50"),
        ("1e-320 1e-320 0", "has no direction; its length is to be 1"),
        ("1e-320 2e-320 0", "has no direction"),
        ("0 1e-200 0", "has no direction"),
        ("0 0 1e-400", "has no direction"),
    ],
)
def test_axes_without_a_direction(axis: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(with_axis(axis))


@pytest.mark.parametrize("size", ["1e-49", "1e49", "3"])
def test_axes_of_any_other_length(size: str) -> None:
    mechanism = cd.load(with_axis(f"{size} {size} 0"))
    np.testing.assert_allclose(
        mechanism.joint("pin_in").axis, [0.5**0.5, 0.5**0.5, 0.0], atol=1e-16
    )


@pytest.mark.parametrize(
    "prolog",
    [
        '<!DOCTYPE robot SYSTEM "file:///nowhere">',
        '<!DOCTYPE robot PUBLIC "-//x//y" "file:///nowhere">',
        '<!-- <robot> --><!DOCTYPE robot SYSTEM "file:///nowhere">',
        '<?tool <robot ?><!DOCTYPE robot SYSTEM "file:///nowhere">',
        '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///nowhere">]>',
        '<!DOCTYPE robot [<!ENTITY % x PUBLIC "-//x//y" "file:///nowhere"> %x;]>',
    ],
)
def test_documents_that_are_not_read(prolog: str) -> None:
    """Their entities would be read as nothing, whatever stands before the DOCTYPE."""
    with pytest.raises(cd.ModelError, match="x: its DOCTYPE refers to another document, which is"):
        elements.xml_root(f"{prolog}<robot/>", "x")


@pytest.mark.parametrize(
    "prolog",
    [
        "",
        "<!DOCTYPE robot>",
        '<!DOCTYPE robot [<!ENTITY x "0 0">]>',
        '<!DOCTYPE robot [<!ENTITY x "the SYSTEM is PUBLIC">]>',
        '<!-- <!DOCTYPE robot SYSTEM "file:///nowhere"> -->',
    ],
)
def test_texts_that_refer_to_no_other_document(prolog: str) -> None:
    assert elements.xml_root(f'{prolog}<robot name="SYSTEM"/>', "x")[0].get("name") == "SYSTEM"


def test_unique_names() -> None:
    assert elements.unique("a", set()) == "a"
    assert elements.unique("a", {"b"}) == "a"
    assert elements.unique("a", {"a"}) == "a_2"
    assert elements.unique("a", {"a", "a_2", "a_4"}) == "a_3"
