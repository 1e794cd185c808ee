"""A URDF's links, joints and couplings are read; namespaces and impossible inertias refused."""

from __future__ import annotations

import re
from xml.etree.ElementTree import fromstring

import numpy as np
import pinocchio as pin
import pytest
from testkit import scenes

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description, Limits, SourceText
from cardan_dyn.core.description.urdf import check_inertia, check_tree, parse, tensor_of

ROBOT = """<robot name="r"><link name="a"/><link name="b"><inertial>
<origin xyz="1 2 3" rpy="0 0 {quarter}"/><mass value="4"/>
<inertia ixx="1" iyy="2" izz="2.5" ixy="0.1" ixz="0.2" iyz="0.3"/></inertial></link>
<joint name="j" type="{kind}" independent="{independent}"><parent link="a"/><child link="b"/>
<origin xyz="0 0 1"/><axis xyz="0 0 2"/>{more}</joint></robot>"""
PLAIN = {"quarter": "0", "kind": "revolute", "independent": "false", "more": ""}


def read(strict: bool = True, **changes: str) -> Description:
    return parse(fromstring(ROBOT.format(**PLAIN | changes)), SourceText("", None), "here", strict)


def test_links() -> None:
    """A quarter turn about z: x of the inertia's frame is y of the link's."""
    description = read(quarter=repr(np.pi / 2))
    massless, link = description.links
    assert massless.mass == 0.0
    assert link.mass == 4.0
    assert link.centre.tolist() == [1.0, 2.0, 3.0]
    expected = tensor_of(2.0, 1.0, 2.5, -0.1, -0.3, 0.2)
    np.testing.assert_allclose(link.inertia, expected, atol=1e-15)


def test_joints() -> None:
    description = read(independent="True")
    (joint,) = description.joints
    assert (joint.name, joint.type, joint.parent, joint.child) == ("j", "revolute", "a", "b")
    assert joint.axis.tolist() == joint.axis_2.tolist() == [0.0, 0.0, 1.0]
    assert joint.origin[:3, 3].tolist() == [0.0, 0.0, 1.0]
    assert joint.limits == Limits()
    assert description.independent_joints == ("j",)
    assert description.notation == "no loops"
    # Of a fixed joint the axis has no meaning, and every one is the same.
    assert read(kind="fixed").joints[0].axis.tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("kind", "more", "limits"),
    [
        ("revolute", "<limit/>", Limits(0.0, 0.0, 0.0, 0.0)),
        ("revolute", '<limit lower="-1" upper="2" velocity="3" effort="4"/>', Limits(-1, 2, 3, 4)),
        ("continuous", '<limit lower="-1" velocity="3"/>', Limits(velocity=3.0, effort=0.0)),
        (
            "prismatic",
            '<limit lower="-inf" upper="inf" velocity="inf" effort="7"/>',
            Limits(effort=7.0),
        ),
        (
            "revolute",
            '<limit lower="-1.79769e+308" upper="1.79769e+308" velocity="1e60" effort="7"/>',
            Limits(effort=7.0),
        ),
    ],
)
def test_limits(kind: str, more: str, limits: Limits) -> None:
    assert read(kind=kind, more=more).joints[0].limits == limits


@pytest.mark.parametrize("text", ["lower='inf'", "upper='-inf'", "effort='Infinity'", "lower='x'"])
def test_limits_that_are_none(text: str) -> None:
    with pytest.raises(cd.ModelError, match=r"here: joint 'j': limit \w+: .* is not 1 finite"):
        read(more=f"<limit {text}/>")


def test_types_that_urdf_lacks() -> None:
    universal = read(kind="universal", more='<axis2 xyz="0 1 0"/>').joints[0]
    assert universal.axis.tolist() == [0.0, 0.0, 1.0]
    assert universal.axis_2.tolist() == [0.0, 1.0, 0.0]
    with pytest.raises(cd.ModelError, match=r"joint 'j': a universal joint needs .* right angles"):
        read(kind="universal", more='<axis2 xyz="0 1 1"/>')
    with pytest.raises(cd.ModelError, match="beyond URDF: cylindrical, spherical, universal"):
        read(kind="ball")


def test_a_universal_joint_of_the_tree_is_two_hinges() -> None:
    """Against a massless link between two hinges, at arbitrary positions and rates."""
    body = '<inertial><origin xyz="0.3 0.2 0.1"/><mass value="2"/>'
    body += '<inertia ixx="1" iyy="1.2" izz="1.3"/></inertial>'
    ends = '<parent link="{}"/><child link="{}"/><axis xyz="{}"/>'
    start = f'<robot name="r"><link name="a"/><link name="b">{body}</link>'
    joint = start + '<joint name="u" type="universal">' + ends.format("a", "b", "0 0 1")
    joint += '<axis2 xyz="0 1 0"/></joint></robot>'
    hinges = start + '<link name="c"/><joint name="s" type="continuous">'
    hinges += ends.format("a", "c", "0 0 1") + '</joint><joint name="t" type="continuous">'
    hinges += ends.format("c", "b", "0 1 0") + "</joint></robot>"
    models = [cd.load(text).model for text in (joint, hinges)]
    step, v, a = np.array([[0.3, 0.7], [1.0, 2.0], [0.5, -0.3]])
    efforts = [
        pin.rnea(model, model.createData(), pin.integrate(model, pin.neutral(model), step), v, a)
        for model in models
    ]
    np.testing.assert_allclose(*efforts, rtol=1e-13)


def test_what_is_left_out_is_said() -> None:
    robot = ROBOT.format(**PLAIN | {"more": '<dynamics damping="2" friction="0"/>'})
    assert cd.load(robot).warnings == (
        "URDF text: damping or friction of 1 joint (j): "
        "Scene(..., elements=described_elements(mechanism)) takes it in, as "
        "`cardan-dyn simulate` and `vibration` do; other scenes are without it",
    )
    assert read(more="<dynamics/>").warnings == ()


def test_couplings() -> None:
    text = ROBOT.format(**PLAIN).replace(
        "</robot>",
        '<coupling name="c"><predecessor link="a"/><successor link="b"/>{}</coupling></robot>',
    )
    coupling = parse(
        fromstring(text.format('<ratio value="-2"/>')), SourceText("", None), "x", True
    ).couplings[0]
    assert (coupling.predecessor, coupling.successor, coupling.ratio) == ("a", "b", -2.0)
    for ratio, message in (
        ('<ratio value="0"/>', "a ratio of zero would hold the successor"),
        ("", "ratio value: None is not 1 finite"),
        ("<ratio/>", "ratio value: None is not 1 finite"),
    ):
        with pytest.raises(cd.ModelError, match=f"x: coupling 'c': {message}"):
            parse(fromstring(text.format(ratio)), SourceText("", None), "x", True)


def test_a_mass_of_zero() -> None:
    text = ROBOT.format(**PLAIN).replace('mass value="4"', 'mass value="0"')
    with pytest.raises(cd.ModelError, match=r"mass 0 kg is not positive.*strict=False\) accepts"):
        parse(fromstring(text), SourceText("", None), "x", True)
    description = parse(fromstring(text), SourceText("", None), "x", False)
    rotor = description.links[1]
    assert rotor.mass == 0.0
    heavy = parse(fromstring(ROBOT.format(**PLAIN)), SourceText("", None), "x", True).links[1]
    np.testing.assert_array_equal(rotor.inertia, heavy.inertia)
    assert description.warnings == ("x: link 'b': mass 0 kg: an inertia without mass",)
    start, end = text.index("<inertia "), text.index("/>", text.index("<inertia "))
    description = parse(
        fromstring(text[:start] + "<inertia" + text[end:]), SourceText("", None), "x", False
    )
    assert description.links[1].is_massless
    assert description.warnings == ("x: link 'b': mass 0 kg: taken as massless",)


def test_trees() -> None:
    joint = read().joints[0]
    check_tree(["a", "b"], [joint], "x")
    with pytest.raises(cd.ModelError, match="exactly one root link; links without a parent: a, c"):
        check_tree(["a", "b", "c"], [joint], "x")


@pytest.mark.parametrize(
    ("moments", "message"),
    [
        ((1.0, 2.0, 3.0), ""),
        ((1.0, 2.0, 3.0 + 1e-9), ""),
        ((1.0, 2.0, 3.0 + 1e-8), "violate the triangle inequality"),
        ((-1e-10, 1.0, 1.0), ""),
        ((-1e-8, 1.0, 1.0), "negative principal moment -1e-08"),
        ((0.0, 0.0, 0.0), ""),
    ],
)
def test_inertias(moments: tuple[float, ...], message: str) -> None:
    """Rounding in a file is accepted; turned axes change nothing."""
    turn = np.linalg.qr(np.array([[1.0, 2.0, 3.0], [0.0, 1.0, 4.0], [5.0, 6.0, 0.0]]))[0]
    tensor = (turn * np.array(moments)) @ turn.T
    fault = check_inertia(1.0, tensor, "x", False, "none")
    assert message in fault
    assert bool(fault) is bool(message)
    if message:
        with pytest.raises(cd.ModelError, match=r"strict=False\) accepts it"):
            check_inertia(1.0, tensor, "x", True, "none")


@pytest.mark.parametrize("tensor", [np.full((3, 3), np.nan), np.diag([np.inf, 1.0, 1.0])])
def test_inertias_beyond_all_numbers(tensor: np.ndarray) -> None:
    with pytest.raises(cd.ModelError, match="link 'a': the inertia has no principal moments"):
        check_inertia(1.0, tensor, "link 'a'", False, "none")


JOINT = scenes.text("universal_joint")


def changed(old: str, new: str) -> str:
    """Return the universal joint with one piece of text replaced."""
    assert old in JOINT
    return JOINT.replace(old, new, 1)


@pytest.mark.parametrize(
    ("urdf", "message"),
    [
        (
            changed("<robot ", '<robot xmlns="http://a/b" '),
            "outermost element is <{http://a/b}robot>",
        ),
        (
            changed("<joint ", '<joint xmlns="http://a/b" '),
            "<joint> stands in the namespace 'http://a/b'",
        ),
        (
            changed("<inertial>", '<inertial xmlns="http://a/b">'),
            "<inertial> stands in the namespace 'http://a/b'",
        ),
        (
            changed(
                "</robot>", '<x:macro xmlns:x="http://www.ros.org/wiki/xacro" name="m"/></robot>'
            ),
            "<xacro:macro> is to be processed first",
        ),
    ],
)
def test_namespaces(urdf: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=re.escape(message)):
        cd.load(urdf)


def test_extensions_of_others_are_left_alone() -> None:
    extra = '<g:joint_states xmlns:g="http://a/b"><g:joint name="x"/></g:joint_states>'
    extra += '<velocity_ratios><joint name="x"/><joint name="y"/></velocity_ratios>'
    assert (
        cd.load(changed("</robot>", f"{extra}</robot>")).joint_names == cd.load(JOINT).joint_names
    )
