"""A plane four-bar linkage as a body in space: what is unique, and how to make all of it unique.

Four parallel hinges make 20 constraints on the 18 freedoms of three links and yet leave one free:
three are too many, and they blur what acts out of the plane. A ball in place of one hinge and a
cylinder in place of another take those three away.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.urdf_reader import Reader, edited, text

import cardan_dyn as cd

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 73)
HINGES = ("crank_bearing", "crank_pin", "rocker_bearing", "rocker_pin")
IN_PLANE, OUT_OF_PLANE = [0, 1, 5], [2, 3, 4]


def sweep(urdf: str) -> cd.Sweep:
    scene = cd.Scene(
        cd.load(urdf),
        drive="crank_bearing",
        loads={"rocker_bearing": -60.0},
        gravity=(0.0, -9.81, -3.0),
    )
    return scene.sweep(POSITIONS, speed=30.0, acceleration=-45.0)


def add(parent: ElementTree.Element, xml: str) -> None:
    parent.append(ElementTree.fromstring(xml))


def cylinder_as_slide_and_hinge(robot: ElementTree.Element) -> None:
    """The rocker slides along its bearing, and the loop is a ball."""
    robot.find("loop[@name='rocker_pin']").set("type", "spherical")
    bearing = robot.find("joint[@name='rocker_bearing']")
    bearing.find("parent").set("link", "sleeve")
    origin = bearing.find("origin")
    xyz = origin.get("xyz")
    origin.set("xyz", "0 0 0")
    add(robot, '<link name="sleeve"/>')
    add(
        robot,
        '<joint name="rocker_slide" type="prismatic"><parent link="base"/><child link="sleeve"/>'
        f'<origin xyz="{xyz}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1e4" velocity="10"/></joint>',
    )


def ball_as_three_hinges(robot: ElementTree.Element) -> None:
    """The crank's pin is a gimbal, and the loop is a cylinder."""
    robot.find("loop[@name='rocker_pin']").set("type", "cylindrical")
    pin = robot.find("joint[@name='crank_pin']")
    pin.find("child").set("link", "gimbal_1")
    for index, (parent, child, axis) in enumerate(
        (("gimbal_1", "gimbal_2", "1 0 0"), ("gimbal_2", "coupler", "0 1 0")), 1
    ):
        add(robot, f'<link name="gimbal_{index}"/>')
        add(
            robot,
            f'<joint name="gimbal_hinge_{index}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="0 0 0"/><axis xyz="{axis}"/></joint>',
        )


def coupler_between_two_loops(robot: ElementTree.Element) -> None:
    """The coupler hangs in a cylindrical and in a spherical loop, and floats in the tree."""
    pin = robot.find("joint[@name='crank_pin']")
    crank_end, at_zero = pin.find("origin"), [0.08, 0.0, 0.0]
    rpy = crank_end.get("rpy")
    add(
        robot,
        '<loop name="crank_pin" type="cylindrical">'
        f'<predecessor link="crank"><origin xyz="{crank_end.get("xyz")}" rpy="{rpy}"/>'
        '</predecessor><successor link="coupler"><origin xyz="0 0 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>',
    )
    robot.find("loop[@name='rocker_pin']").set("type", "spherical")
    pin.set("name", "float")
    pin.set("type", "floating")
    pin.find("parent").set("link", "base")
    # With the crank at zero its axes are those of the base, its origin too.
    crank_end.set("xyz", " ".join(map(str, at_zero)))
    pin.remove(pin.find("axis"))


VARIANTS: dict[str, Callable[[ElementTree.Element], None]] = {
    "slide and hinge, ball loop": cylinder_as_slide_and_hinge,
    "gimbal, cylinder loop": ball_as_three_hinges,
    "cylinder loop, ball loop": coupler_between_two_loops,
}


@pytest.fixture(scope="module")
def plane() -> cd.Sweep:
    return sweep("four_bar")


def test_only_the_plane_is_unique(plane: cd.Sweep) -> None:
    for name in HINGES:
        assert np.all(plane[name].unique[IN_PLANE]), name
        assert not np.any(plane[name].unique[OUT_OF_PLANE]), name


@pytest.mark.parametrize("variant", VARIANTS)
def test_ball_and_cylinder_make_it_determinate(variant: str, plane: cd.Sweep) -> None:
    turn = sweep(edited(text("four_bar"), VARIANTS[variant]))
    for name in turn.outputs:
        assert np.all(turn[name].unique), name
    # Both move alike, so the forces in the plane do not change.
    difference = turn.motion.position("rocker_bearing") - plane.motion.position("rocker_bearing")
    assert np.max(np.abs(difference)) < 1e-13
    for name in HINGES:
        computed, expected = turn.wrench(name, "world"), plane.wrench(name, "world")
        scale = np.max(np.abs(expected.force[:, :2]))
        assert np.max(np.abs(computed.force[:, :2] - expected.force[:, :2])) < 1e-12 * scale, name
    scale = np.max(np.abs(plane.drive_effort))
    assert np.max(np.abs(turn.drive_effort - plane.drive_effort)) < 1e-12 * scale
    assert turn.balance_residual < 1e-12


def test_forces_out_of_the_plane_are_those_of_statics(plane: cd.Sweep) -> None:
    """A cylinder carries no axial force, a ball no moment: one bearing alone carries weight."""
    ball = sweep(edited(text("four_bar"), cylinder_as_slide_and_hinge))
    reader = Reader(text("four_bar"))
    crank, coupler, rocker = (reader.body(name) for name in ("crank", "coupler", "rocker"))
    assert crank is not None and coupler is not None and rocker is not None
    weight = 3.0  # per kilogram, against z
    expected = {
        "rocker_bearing": 0.0,
        "rocker_pin": weight * rocker.mass,
        "crank_pin": weight * (rocker.mass + coupler.mass),
        "crank_bearing": weight * (rocker.mass + coupler.mass + crank.mass),
    }
    for name, force in expected.items():
        computed = ball.wrench(name, "world").force[:, 2]
        np.testing.assert_allclose(
            computed, force, rtol=1e-12, atol=1e-12 * expected["crank_bearing"]
        )
    pin = ball["rocker_pin"]
    assert np.max(np.abs(pin.moment)) < 1e-12 * np.max(np.linalg.norm(pin.force, axis=1))
    # Least norm lets both bearings carry weight.
    assert np.max(np.abs(plane.wrench("rocker_bearing", "world").force[:, 2])) > 1.0
