"""Joints: types, ends, axes, limits."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from testkit.sdf import model

import cardan_dyn as cd
from cardan_dyn.core.description.description import Limits
from cardan_dyn.practice.formats.sdf.frames import NamedFrames
from cardan_dyn.practice.formats.sdf.joints import Edge, edge
from cardan_dyn.practice.formats.sdf.plain import modern

LINKS = """<pose>0 0 0 0 0 0.7</pose><link name="a"><pose>1 0 0 0.3 0 0</pose></link>
<link name="b"><pose>0 1 0 0 0.5 0</pose></link><frame name="f" attached_to="b"/>"""
Z = "<axis><xyz>0 0 1</xyz></axis>"


def read(kind: str, inside: str, version: tuple[int, int] = (1, 9)) -> tuple[Edge, list[str]]:
    joint = f'<joint name="j" type="{kind}">{inside}</joint>'
    if "<parent>" not in inside:
        joint = joint.replace(">", "><parent>a</parent><child>b</child>", 1)
    element = ElementTree.fromstring(model(LINKS + joint)).find("model")
    assert element is not None
    modern(element, version, "at")
    found = element.find("joint")
    assert found is not None
    joint_found = edge(found, NamedFrames(element, "at"), "at")
    return joint_found, list(joint_found.warnings)


@pytest.mark.parametrize(
    ("kind", "inside", "found"),
    [
        ("revolute", Z, "continuous"),
        ("Revolute", Z, "continuous"),
        ("revolute", "<axis><limit><lower>-1</lower></limit></axis>", "revolute"),
        ("continuous", "<axis><limit><lower>-1</lower></limit></axis>", "continuous"),
        ("prismatic", Z, "prismatic"),
        ("ball", "", "spherical"),
        ("fixed", "", "fixed"),
        ("fixed", Z, "fixed"),
        ("universal", f"{Z}<axis2><xyz>0 -2 0</xyz></axis2>", "universal"),
        ("revolute2", f"{Z}<axis2><xyz>0 -2 0</xyz></axis2>", "universal"),
    ],
)
def test_types(kind: str, inside: str, found: str) -> None:
    joint, warnings = read(kind, inside)
    assert (joint.type, warnings) == (found, [])
    assert (joint.name, joint.parent, joint.child, joint.is_cut) == ("j", "a", "b", False)


TURN = pin.rpy.rpyToMatrix(0.0, 0.0, 0.7)
A, B = TURN @ pin.rpy.rpyToMatrix(0.3, 0, 0), TURN @ pin.rpy.rpyToMatrix(0, 0.5, 0)
S = np.array([2.0, -1.0, 2.0])


@pytest.mark.parametrize(
    ("xyz", "version", "more", "world"),
    [
        ("<xyz>2 -1 2</xyz>", (1, 9), "", B @ S),
        ('<xyz expressed_in="a">2 -1 2</xyz>', (1, 9), "", A @ S),
        ('<xyz expressed_in="__model__">2 -1 2</xyz>', (1, 9), "", TURN @ S),
        ('<xyz expressed_in="f">2 -1 2</xyz>', (1, 7), "", B @ S),
        ('<xyz expressed_in="j">2 -1 2</xyz>', (1, 9), "", B @ S),
        ("<xyz>2 -1 2</xyz>", (1, 4), "", TURN @ S),
        ("<xyz>2 -1 2</xyz>", (1, 5), "", B @ S),
        (
            "<xyz>2 -1 2</xyz>",
            (1, 6),
            "<use_parent_model_frame>1</use_parent_model_frame>",
            TURN @ S,
        ),
        ("<xyz>2 -1 2</xyz>", (1, 6), "<use_parent_model_frame>0</use_parent_model_frame>", B @ S),
        ("", (1, 9), "", B @ np.array([0.0, 0.0, 3.0])),
    ],
)
def test_axes(xyz: str, version: tuple[int, int], more: str, world: np.ndarray) -> None:
    joint, _ = read("prismatic", f"<axis>{xyz}{more}</axis>", version)
    np.testing.assert_allclose(joint.origin[:3, :3] @ joint.axis, world / 3.0, atol=1e-15)


def test_both_axes_of_a_universal_joint() -> None:
    xyz = '<xyz expressed_in="a">{}</xyz>'
    axes = f"<axis>{xyz.format('1 0 0')}</axis><axis2>{xyz.format('0 3 4')}</axis2>"
    joint, _ = read("universal", axes)
    turn = joint.origin[:3, :3]
    np.testing.assert_allclose(turn @ joint.axis, A[:, 0], atol=1e-15)
    np.testing.assert_allclose(turn @ joint.axis_2, A @ [0.0, 0.6, 0.8], atol=1e-15)


def test_frames_may_be_ends() -> None:
    joint, _ = read("ball", "<parent>world</parent><child>f</child><pose>0 0 1 0 0 0</pose>")
    assert (joint.parent, joint.child) == ("world", "b")
    origin = TURN @ [0.0, 1.0, 0.0] + B[:, 2]
    np.testing.assert_allclose(joint.origin[:3, 3], origin, atol=1e-15)


def test_limits_and_what_else_an_axis_says() -> None:
    limit = "<limit><lower>-1</lower><upper>1e16</upper><effort>5</effort><velocity>-1</velocity>"
    joint, warnings = read(
        "prismatic", f"<axis>{limit}</limit><initial_position>0.5</initial_position></axis>"
    )
    assert joint.limits == Limits(-1.0, math.inf, math.inf, 5.0)
    assert "initial_position 0.5 left out" in warnings[0]
    joint, _ = read("continuous", f"<axis>{limit}</limit></axis>")
    assert joint.limits == Limits(effort=5.0)
    joint, _ = read("universal", f"<axis>{limit}</limit></axis><axis2><xyz>1 0 0</xyz></axis2>")
    assert joint.limits == Limits()


def test_a_cut() -> None:
    cut = "<physics><simbody><must_be_loop_joint>{}</must_be_loop_joint></simbody></physics>"
    assert read("ball", cut.format("true"))[0].is_cut
    assert not read("ball", cut.format("0"))[0].is_cut


@pytest.mark.parametrize(
    ("kind", "inside", "message"),
    [
        ("piston", Z, "write a prismatic and a revolute joint in a row"),
        ("hinge", Z, "type 'hinge' is not supported; types: ball, continuous, fixed, gearbox"),
        ("", Z, "type '' is not supported"),
        ("revolute", "", "axis is missing: <axis><xyz>0 0 1</xyz></axis>"),
        ("universal", Z, "cosine is 1, not at right angles"),
        ("universal", f"{Z}<axis2><xyz>0 1 1</xyz></axis2>", "cosine is 0.70.*right angles"),
        ("revolute", "<axis><xyz>0 0 0</xyz></axis>", "axis: xyz: a vector of zeros"),
        ("revolute", "<axis><xyz>0 0</xyz></axis>", "axis: xyz: '0 0' is not 3 finite"),
        (
            "revolute",
            '<axis><xyz expressed_in="g">0 0 1</xyz></axis>',
            "expressed_in: frame 'g' does",
        ),
        ("ball", "<parent>a</parent><child>world</child>", "the world cannot be the child"),
        ("ball", "<parent>a</parent><child>c</child>", "child: frame 'c' does"),
        ("ball", "<parent></parent><child>a</child>", "<parent> is missing or empty"),
        (
            "revolute",
            "<axis><use_parent_model_frame>true</use_parent_model_frame></axis>",
            'write expressed_in="__model__"',
        ),
    ],
)
def test_refused(kind: str, inside: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"at: joint 'j'.*{message}"):
        read(kind, inside)


def test_an_axis_in_a_frame_of_an_older_version() -> None:
    with pytest.raises(cd.ModelError, match=r"expressed_in is known from SDF 1\.7 on"):
        read("revolute", '<axis><xyz expressed_in="a">0 0 1</xyz></axis>', (1, 6))


def test_tree_joints_and_loops() -> None:
    """Both place the joint's frame where it is, also if a fixed joint is reversed."""
    joint, _ = read("fixed", "<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>")
    links = {"a": np.eye(4), "b": np.eye(4)}
    links["a"][:3], links["b"][:3] = (
        np.c_[A, TURN @ [1.0, 0, 0]],
        np.c_[B, TURN @ [0.0, 1, 0]],
    )
    for is_reversed, ends in ((False, "ab"), (True, "ba")):
        tree = joint.joint(links, is_reversed)
        assert (tree.parent, tree.child) == tuple(ends)
        np.testing.assert_allclose(links[ends[0]] @ tree.origin, joint.origin, atol=1e-15)
        np.testing.assert_allclose(joint.origin @ tree.child_placement, links[ends[1]], atol=1e-15)
    loop = joint.loop(links)
    assert (loop.predecessor, loop.successor) == ("a", "b")
    for link, origin in (("a", loop.predecessor_origin), ("b", loop.successor_origin)):
        np.testing.assert_allclose(links[link] @ origin, joint.origin, atol=1e-15)
