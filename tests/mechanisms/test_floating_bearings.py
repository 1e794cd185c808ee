"""Bearings of the output shaft with which a universal joint is statically determinate.

In two fixed bearings only the moments of a joint are unique: what its pins carry as forces depends
on how exactly it was built. A shaft whose far end runs in one self-aligning bearing, and that can
move lengthwise, leaves one answer: its bending becomes a pair of forces at joint and bearing.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.shaft_line import ShaftLine, about, across
from testkit.urdf_reader import edited, text

import cardan_dyn as cd

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 73)
SPAN, TORQUE, BETA = 0.4, 70.0, np.deg2rad(35.0)
X, Y, Z = np.eye(3)
MIDDLES = {"universal_joint": "cross", "ring_joint": "ring", "thoma_rig": "cross"}


def add(parent: ElementTree.Element, *elements: str) -> None:
    parent.extend(ElementTree.fromstring(element) for element in elements)


def freed(robot: ElementTree.Element, carried: str) -> None:
    """Take shaft 2 out of its bearing and hang `carried` on the joint's middle part."""
    for tag, name in (("loop", "pin_out"), ("joint", "bearing_out")):
        robot.remove(robot.find(f"{tag}[@name='{name}']"))
    middle = MIDDLES[robot.get("name")]
    add(
        robot,
        f'<joint name="pin_out" type="continuous"><parent link="{middle}"/>'
        f'<child link="{carried}"/><axis xyz="0 0 1"/></joint>',
    )


def far_bearing(robot: ElementTree.Element, carrier: str, where: float) -> None:
    add(
        robot,
        f'<loop name="bearing_out" type="spherical"><predecessor link="{carrier}">'
        f'<origin xyz="{where} 0 0"/></predecessor><successor link="shaft_out">'
        f'<origin xyz="{SPAN} 0 0"/></successor></loop>',
    )


def slide(name: str, parent: str, child: str, where: float) -> str:
    return (
        f'<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{where} 0 0"/><axis xyz="1 0 0"/>'
        '<limit lower="-0.1" upper="0.1" effort="1e5" velocity="1"/></joint>'
    )


def floating_bearing(robot: ElementTree.Element) -> None:
    """The far bearing is self-aligning and slides in the housing."""
    freed(robot, "shaft_out")
    add(robot, '<link name="cage"/>', slide("bearing_float", "housing_out", "cage", SPAN))
    far_bearing(robot, "cage", 0.0)


def spline_and_ball(robot: ElementTree.Element) -> None:
    """The far bearing is self-aligning and fixed; a spline takes up the shaft's length."""
    freed(robot, "sleeve")
    add(robot, '<link name="sleeve"/>', slide("slip", "sleeve", "shaft_out", 0.0))
    far_bearing(robot, "housing_out", SPAN)


def spline_alone(robot: ElementTree.Element) -> None:
    """Shaft 2 in its fixed bearings, with a spline between joint and bearings."""
    loop = robot.find("loop[@name='pin_out']")
    loop.find("successor").set("link", "sleeve")
    add(robot, '<link name="sleeve"/>', slide("slip", "shaft_out", "sleeve", 0.0))


def sweep(form: str, change: Callable[[ElementTree.Element], None] | None = None) -> cd.Sweep:
    urdf = text(form) if change is None else edited(text(form), change)
    scene = cd.Scene(
        cd.load(urdf),
        drive="bearing_in",
        held={"joint_angle": BETA},
        loads={"shaft_out": [0.0, 0.0, 0.0, -TORQUE, 0.0, 0.0]},
    )
    return scene.sweep(POSITIONS)


@pytest.mark.parametrize("form", MIDDLES)
def test_in_fixed_bearings_only_the_moments_are_unique(form: str) -> None:
    turn = sweep(form)
    for name in turn.outputs:
        np.testing.assert_array_equal(turn[name].unique, [False] * 3 + [True] * 3)


@pytest.mark.parametrize("bearings", [floating_bearing, spline_and_ball])
@pytest.mark.parametrize("form", MIDDLES)
def test_bending_becomes_a_pair_of_forces(
    form: str, bearings: Callable[[ElementTree.Element], None]
) -> None:
    """F = M × e₂ / L at the joint, -F at the bearing; the moments of the joint stay as they are."""
    turn = sweep(form, bearings)
    for name in turn.outputs:
        assert np.all(turn[name].unique), name
    shafts = np.array([X, about("z", BETA) @ X])
    (moment,) = ShaftLine.turn(shafts, Y, POSITIONS).moments(TORQUE)
    force = np.cross(moment, shafts[1]) / SPAN
    scale = np.max(np.abs(moment))
    for name in ("bearing_in", "pin_in", "pin_out"):
        computed = turn.wrench(name, "world")
        assert np.max(np.abs(computed.moment - moment)) < 1e-13 * scale, name
        assert np.max(np.abs(computed.force - force)) < 1e-13 * scale / SPAN, name
    computed = turn.wrench("bearing_out", "world")
    assert np.max(np.abs(computed.force + force)) < 1e-13 * scale / SPAN
    assert np.max(np.abs(computed.moment)) < 1e-13 * scale
    # Both bearings of the fixed shaft make the same couple as joint and far bearing here.
    fixed = sweep(form).wrench("bearing_out", "world").moment
    couple = SPAN * np.cross(shafts[1], computed.force)
    assert np.max(np.abs(across(fixed, shafts[1]) - couple)) < 1e-13 * scale


@pytest.mark.parametrize("form", ["universal_joint", "ring_joint"])
def test_a_spline_alone_frees_the_length_only(form: str) -> None:
    """No force along shaft 2, and that for certain; those across it remain a matter of fits."""
    turn = sweep(form, spline_alone)
    for name in ("slip", "bearing_out"):
        np.testing.assert_array_equal(turn[name].unique, [True, False, False, True, True, True])
        assert np.max(np.abs(turn[name].axial)) < 1e-12 * TORQUE
