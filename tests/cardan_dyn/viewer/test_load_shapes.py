"""Loads as the viewer draws them: where they act, how great they are, which way they go."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from testkit.drawn import placed

import cardan_dyn as cd
from cardan_dyn.practice.viewer.commands import Drawing
from cardan_dyn.practice.viewer.load_shapes import draw_drives, draw_gravity, draw_loads
from cardan_dyn.practice.viewer.places import Places

SAMPLES = np.arange(5)


def drawn(sweep: cd.Sweep) -> Drawing:
    drawing = Drawing(1.0)
    draw_loads(drawing, sweep, Places(sweep, SAMPLES, 1.0))
    assert bool(drawing.seen) == bool(drawing.objects)
    return drawing


def turned_z(quaternion: np.ndarray) -> np.ndarray:
    x, y, z, w = quaternion
    return np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])


def test_a_moment_goes_about_the_axis_of_its_joint(loaded_turn: cd.Sweep) -> None:
    """−10 N·m: the arc goes against the sense of the joint."""
    drawing = drawn(loaded_turn)
    arc = placed(drawing, "/loads/bearing_out moment")
    axis = loaded_turn.rotation("bearing_out")[0] @ loaded_turn.mechanism.joint("bearing_out").axis
    np.testing.assert_allclose(turned_z(arc["quaternion"]), -axis, atol=1e-12)
    offset = arc["position"] - loaded_turn.origin("bearing_out")[0]
    np.testing.assert_allclose(np.cross(offset, axis), 0.0, atol=1e-12)


def test_forces_end_where_they_act_and_are_as_long_as_they_are_great() -> None:
    scene = cd.Scene(
        cd.load("four_bar"),
        drive="crank_bearing",
        loads={
            "rocker": cd.Wrench(force=(0.0, -8.0, 0.0), frame="world"),
            "coupler": cd.Wrench(force=(4.0, 0.0, 0.0), moment=(0.0, 0.0, 1.0)),
        },
    )
    sweep = scene.sweep(np.linspace(0.3, 2.0, 5))
    drawing = drawn(sweep)
    assert {item.path for item in drawing.objects} == {
        *("/loads/rocker force", "/loads/coupler force", "/loads/coupler moment"),
    }
    great, small = (placed(drawing, f"/loads/{name} force") for name in ("rocker", "coupler"))
    assert small["scale"][0] == pytest.approx(0.5 * great["scale"][0])
    np.testing.assert_allclose(turned_z(great["quaternion"]), [0.0, -1.0, 0.0], atol=1e-12)
    tip = great["position"] + great["scale"][0] * turned_z(great["quaternion"])
    # The links' frames are those of the joints that move them.
    np.testing.assert_allclose(tip, sweep.origin("rocker_bearing")[0], atol=1e-12)
    along = sweep.rotation("crank_pin")[0] @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(turned_z(small["quaternion"]), along, atol=1e-12)


def test_a_load_that_vanishes_is_not_drawn() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": 0.0})
    assert drawn(scene.sweep(np.linspace(0.3, 2.0, 5))).objects == []


def test_a_load_that_varies_changes_its_sense() -> None:
    scene = cd.Scene(
        cd.load("four_bar"),
        drive="crank_bearing",
        loads={"rocker_bearing": np.array([2.0, 1.0, 0.0, -1.0, -4.0])},
    )
    drawing = drawn(scene.sweep(np.linspace(0.3, 2.0, 5)))
    pose = drawing.nodes["/loads/rocker_bearing moment"]
    z = [turned_z(quaternion)[2] for quaternion in pose.quaternion]
    np.testing.assert_allclose(z, [1.0, 1.0, 1.0, -1.0, -1.0], atol=1e-12)
    # Small ones are drawn large enough for their sense to be seen, and none not at all.
    np.testing.assert_allclose(
        pose.scale[:, 0] / pose.scale[-1, 0], [0.5, 0.35, 0.0, 0.35, 1.0], atol=1e-4
    )


def test_the_arcs_of_drives_close_to_each_other_are_smaller() -> None:
    """They do not bury a robot: those of three joints, two of them half as far apart as usual."""
    joints = "".join(
        f'<link name="l{number}"/><joint name="j{number}" type="continuous">'
        f'<parent link="l{number - 1}"/><child link="l{number}"/><origin xyz="{x} 0 0"/></joint>'
        for number, x in ((1, 0.0), (2, 1.0), (3, 0.15))
    )
    robot = cd.load(f'<robot name="robot"><link name="l0"/>{joints}</robot>')
    turn = cd.Scene(robot, drive=["j1", "j2", "j3"]).sweep(np.zeros((3, 3)))
    drawing = Drawing(1.0)
    draw_drives(drawing, Places(turn, np.arange(3), drawing.size), turn.drives)
    alone, one, other = (float(drawing.nodes[f"/drive/j{n}"].scale[0, 0]) for n in (1, 2, 3))
    assert one == other == pytest.approx(0.075)
    assert alone > 2.0 * one


@pytest.mark.parametrize("axis", [1, 2])
def test_gravity_starts_beside_a_mechanism_where_it_reaches_highest(axis: int) -> None:
    """Lower down, the scales of the picture would cover it."""
    drawing, gravity = Drawing(2.0), -9.81 * np.eye(3)[axis]
    draw_gravity(drawing, gravity, np.array([[-1.0, -2.0, -3.0], [4.0, 5.0, 6.0]]))
    arrow = placed(drawing, "/loads/gravity")
    np.testing.assert_allclose(turned_z(arrow["quaternion"]), -np.eye(3)[axis], atol=1e-12)
    assert arrow["position"][axis] == pytest.approx([-1.0, 5.0, 6.0][axis])
    assert arrow["position"][0] < -1.0
