"""Force elements that are drawn: where they are, how long, and in which scenes."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from testkit.drawn import placed

import cardan_dyn as cd
from cardan_dyn.practice.viewer.commands import Drawing
from cardan_dyn.practice.viewer.element_shapes import ARC_RADIUS, draw_elements
from cardan_dyn.practice.viewer.places import Places

ELEMENTS = [
    cd.PointSpring("crank", (0.1, 0.0, 0.0), "base", (0.1, 0.2, 0.0), 500.0, name="coil"),
    cd.Bushing("coupler", "rocker", (0.3, 0.0, 0.0), np.arange(1.0, 7.0)),
    cd.JointSpring("rocker_bearing", 5.0),
    cd.PointSpring("crank", (0.1, 0.0, 0.0), "base", (0.0, 0.2, 0.0), 0.0, 20.0),
    cd.JointFriction("rocker_bearing", 5.0, name="brake"),
    cd.Actuator("rocker_bearing", np.cos, name="motor"),
    cd.Actuator("crank_bearing", lambda time: -2.0 + 0.0 * time, name="other motor"),
]
SAMPLES = np.arange(1, 4)
TIMES = np.linspace(0.0, 3.0, 4)


@pytest.fixture(scope="module")
def turn() -> cd.Sweep:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=ELEMENTS)
    return scene.sweep([0.0, 0.5, 1.0, 1.5], time=TIMES)


@pytest.fixture(scope="module")
def drawing(turn: cd.Sweep) -> Drawing:
    drawing = Drawing(1.0)
    draw_elements(drawing, turn.elements, Places(turn, SAMPLES, 1.0))
    return drawing


def test_a_spring_starts_at_its_first_point_and_is_as_long_as_it_is(
    turn: cd.Sweep, drawing: Drawing
) -> None:
    spring = placed(drawing, "/elements/coil")
    crank = turn.rotation("crank_bearing")[1] @ [0.1, 0.0, 0.0] + turn.origin("crank_bearing")[1]
    np.testing.assert_allclose(spring["position"], crank, atol=1e-15)
    np.testing.assert_allclose(spring["scale"], [1.0, 1.0, turn.element_force["coil"].length[1]])
    x, y, z, w = spring["quaternion"]
    direction = np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])
    np.testing.assert_allclose(crank + direction * spring["scale"][2], [0.1, 0.2, 0.0], atol=1e-12)


def test_every_element_is_drawn_and_named_in_the_legend(turn: cd.Sweep) -> None:
    drawing = Drawing(1.0)
    draw_elements(drawing, turn.elements, Places(turn, SAMPLES, 1.0))
    paths = {path.split("/")[2] for path in drawing.nodes}
    assert paths == {"coil", "1", "2", "3", "brake", "motor", "other motor"}
    assert [item.text for item in drawing.legend] == [
        *("spring", "bushing", "damper", "dry friction"),
        "effort of an actuator, at most 2 N·m",
    ]


def test_thrusts_are_springs_dampers_or_cylinders() -> None:
    ends = ("crank", (0.1, 0.0, 0.0), "base", (0.1, 0.2, 0.0))
    laws = (([[0.0, 9.0], [3.0, -9.0]], "length"), (np.cos, "rate"), (5.0, "time"))
    elements = [cd.PointActuator(*ends, thrust, of=of) for thrust, of in laws]
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=elements)
    drawing = Drawing(1.0)
    draw_elements(drawing, elements, Places(scene.sweep([0.0, 0.5]), np.arange(2), 1.0))
    assert [item.text for item in drawing.legend] == ["spring", "damper", "thrust of an actuator"]


def test_elements_of_a_joint_stand_at_its_axis_and_not_in_each_other(
    turn: cd.Sweep, drawing: Drawing
) -> None:
    axis = turn.rotation("rocker_bearing")[1] @ turn.mechanism.joints["rocker_bearing"].axis
    origin = turn.origin("rocker_bearing")[1]
    heights = []
    for path in ("2/spiral", "brake/ring", "motor"):
        arm = placed(drawing, f"/elements/{path}")["position"] - origin
        np.testing.assert_allclose(np.cross(arm, axis), 0.0, atol=1e-15)
        heights.append(float(arm @ axis))
    assert len({round(height, 6) for height in heights}) == 3


def test_arrows_of_actuators_share_a_scale_and_take_the_time_that_is_shown(
    drawing: Drawing,
) -> None:
    size = placed(drawing, "/elements/motor")["scale"][0]
    assert size == pytest.approx(ARC_RADIUS * np.cos(1.0) / 2.0)
    assert placed(drawing, "/elements/other motor")["scale"][0] == pytest.approx(ARC_RADIUS)


def test_an_axis_of_a_joint_with_several_coordinates_is_the_one_that_turns() -> None:
    text = """<robot name="r"><link name="base"/><link name="arm"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="u" type="universal"><parent link="base"/><child link="arm"/>
      <origin xyz="0 0 2"/><axis xyz="1 0 0"/><axis2 xyz="0 1 0"/></joint></robot>"""
    elements = [cd.JointSpring("u.turn_1", 1.0), cd.JointSpring("u.turn_2", 1.0)]
    scene = cd.Scene(cd.load(text), drive=["u.turn_1", "u.turn_2"], elements=elements)
    drawing = Drawing(1.0)
    draw_elements(drawing, elements, Places(scene.sweep([[0.4, 0.3]]), np.arange(1), 1.0))
    for path, expected in (("0", [1.0, 0.0, 0.0]), ("1", [0.0, np.cos(0.4), np.sin(0.4)])):
        x, y, z, w = placed(drawing, f"/elements/{path}/spiral")["quaternion"]
        axis = np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])
        np.testing.assert_allclose(axis, expected, atol=1e-12)


def test_views_show_them_unless_they_are_switched_off(turn: cd.Sweep) -> None:
    assert "dry friction" in cd.view(turn).html
    assert "dry friction" not in cd.view(turn, elements=False).html
