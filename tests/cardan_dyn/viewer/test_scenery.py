"""The scene as a whole: what is drawn, its legend, its scales and what the camera sees."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from scipy.spatial.transform import Rotation
from testkit.drawn import placed
from testkit.kinematics import at_zero

import cardan_dyn as cd
from cardan_dyn.practice.viewer.load_shapes import LOAD
from cardan_dyn.practice.viewer.scenery import (
    COLORS,
    LOOP,
    Parts,
    Scenery,
    build,
    has_axis,
)
from cardan_dyn.practice.viewer.still import Still

SAMPLES = np.arange(25)
BODIES = {"mechanism", "bearings"}
"""Roots of what is drawn of bodies whatever is shown besides."""
ALL, NONE = (Parts(*[drawn] * len(Parts._fields)) for drawn in (True, False))


def scenery(turn: cd.Sweep, parts: Parts = NONE, joints: tuple[str, ...] = ()) -> Scenery:
    return build(turn, joints or turn.outputs, parts, SAMPLES)


def roots(scene: Scenery) -> set[str]:
    """First steps of the paths of all objects and labels."""
    drawn = [*scene.drawing.objects, *scene.drawing.labels]
    return {item.path.split("/")[1] for item in drawn}


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        ("visuals", {"mechanism"}),
        ("moments", {"torsion", "bending"}),
        ("axes", {"axes"}),
        ("traces", {"moment", "traces"}),
        ("labels", {"labels"}),
        ("loads", {"loads", "drive"}),
    ],
)
def test_each_part_is_drawn_alone(part: str, expected: set[str], loaded_turn: cd.Sweep) -> None:
    drawn = roots(scenery(loaded_turn, NONE._replace(**{part: True})))
    assert drawn == (expected if part == "visuals" else expected | BODIES)


def test_forces_are_drawn_where_there_are_any(loaded_turn: cd.Sweep) -> None:
    only_forces = NONE._replace(forces=True)
    # A torque alone: the joint passes no force.
    still = scenery(loaded_turn, only_forces)
    assert roots(still) == BODIES and still.scales == ()
    turn = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(
        np.linspace(0.0, 6.0, 25), speed=10.0
    )
    moving = scenery(turn, only_forces)
    assert roots(moving) == {*BODIES, "axial", "shear"}
    assert moving.drawing.legend[1] == (
        COLORS["shear"].css,
        "shear: force across the joint axis",
        "shear",
    )
    (scale,) = moving.scales
    assert (scale.kind, scale.unit, scale.longest) == ("force", "N", None)
    name = max(turn, key=lambda name: np.max(turn[name].shear))
    greatest = np.max(moving.drawing.nodes[f"/shear/{name}"].scale)
    assert greatest * scale.per_metre == pytest.approx(np.max(turn[name].shear))


def test_arrows_beyond_what_is_usual_are_cut_and_their_scale_says_so() -> None:
    """Near a dead point of the rocker the forces grow beyond all bounds."""
    scene = cd.Scene(cd.load("four_bar"), drive="rocker_bearing", loads={"crank_bearing": -20.0})
    low, high = scene.motion_range()
    turn = scene.sweep(np.linspace(low + 1e-6 * (high - low), high - 1e-6 * (high - low), 25))
    drawn = scenery(turn, NONE._replace(forces=True))
    (scale,) = drawn.scales
    force = turn["crank_bearing"].shear
    assert scale.longest is not None and 50.0 * scale.longest < np.max(force)
    lengths = drawn.drawing.nodes["/shear/crank_bearing"].scale[:, 0]
    expected = np.minimum(force, scale.longest) / scale.per_metre
    np.testing.assert_allclose(lengths, expected, rtol=1e-6)


def test_a_load_is_not_drawn_again_as_what_its_joint_carries() -> None:
    """The moment about the axis of a pin without friction is the load on it, and no more."""
    bar = cd.load("four_bar")
    friction = cd.JointFriction("rocker_bearing", 1.0)
    for elements, expected in (([], False), ([friction], True)):
        scene = cd.Scene(
            bar, drive="crank_bearing", loads={"rocker_bearing": -20.0}, elements=elements
        )
        turn = scene.sweep(np.linspace(0.0, 6.0, 25), speed=10.0)
        nodes = scenery(turn, ALL).drawing.nodes
        assert "/loads/rocker_bearing moment" in nodes and "/torsion/crank_bearing" in nodes
        assert ("/torsion/rocker_bearing" in nodes) == expected
    alone = scenery(turn, ALL._replace(loads=False)).drawing.nodes
    assert "/torsion/rocker_bearing" in alone


def test_the_axis_of_a_slide_is_its_stroke() -> None:
    turn = cd.Scene(cd.load("slider_crank"), drive="crank_bearing").sweep(np.linspace(0.0, 6.0, 25))
    drawn = scenery(turn, NONE._replace(axes=True)).drawing
    (surface,) = (item.surface for item in drawn.objects if item.path == "/axes/piston_guide")
    position, thick = turn.motion.position("piston_guide"), 0.005 * drawn.size
    heights = drawn.size * surface[0][:, 2]
    expected = [np.min(position) - thick, np.max(position) + thick]
    assert [np.min(heights), np.max(heights)] == pytest.approx(expected)
    places = drawn.nodes["/axes/piston_guide"].position
    assert np.ptp(places, axis=0) == pytest.approx(0.0, abs=1e-12)  # It stays with the guide.


def test_what_swings_as_in_a_mode_is_not_drawn_as_driven(loaded_turn: cd.Sweep) -> None:
    parts = NONE._replace(loads=True)
    samples = np.arange(len(loaded_turn))
    swinging = build(loaded_turn, (), parts, samples, frozenset({"bearing_in"}))
    assert "drive" not in roots(swinging) and "drive" in roots(scenery(loaded_turn, parts))


def test_the_rounding_of_moments_is_not_drawn_beside_forces() -> None:
    """A weight that hangs on the line of its guide: its moment is the rounding of a product."""
    text = (
        '<robot name="weight"><link name="base"/><link name="block"><inertial>'
        '<origin xyz="0.252 0.336 0.56"/><mass value="7"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link><joint name="guide" type="prismatic">'
        '<parent link="base"/><child link="block"/><origin xyz="0 0 0" rpy="0.3 0.2 0.1"/>'
        '<axis xyz="0.36 0.48 0.8"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        "</robot>"
    )
    mechanism = cd.load(text)
    down = at_zero(mechanism)[1].rotation @ [-3.6, -4.8, -8.0]
    turn = cd.Scene(mechanism, drive="guide", gravity=down).sweep(np.linspace(0.0, 1.0, 25))
    assert 0.0 < np.max(np.abs(turn["guide"].moment)) < 1e-12
    drawn = scenery(turn, NONE._replace(forces=True, moments=True))
    assert roots(drawn) == {*BODIES, "axial"}


def test_legend_names_what_is_drawn(loaded_turn: cd.Sweep) -> None:
    scene = scenery(loaded_turn, ALL)
    legend = {item.color: item.text for item in scene.drawing.legend}
    assert "torsion" in legend[COLORS["torsion"].css] and "bending" in legend[COLORS["bending"].css]
    assert legend[LOOP.css] == "joint that closes a loop" and legend[LOAD.css].startswith(
        "load, not to the scale"
    )
    assert {item.part for item in scene.drawing.legend} == {
        *("axes", "torsion", "bending", "moment", "loads", "drive"),
    }
    colors = {item.text: item.color for item in scene.drawing.labels}
    assert set(colors) == set(loaded_turn.outputs)
    assert colors["pin_out"] == LOOP.css != colors["bearing_in"]
    without_loop = scenery(loaded_turn, ALL, ("bearing_in",))
    assert LOOP.css not in {item.color for item in without_loop.drawing.legend}


def test_arrows_are_as_long_as_their_scale_says(loaded_turn: cd.Sweep) -> None:
    scene = scenery(loaded_turn, ALL._replace(traces=False))
    (scale,) = (item for item in scene.scales if item.kind == "moment")
    (length,) = np.unique(placed(scene.drawing, "/torsion/bearing_in")["scale"])
    assert length * scale.per_metre == pytest.approx(abs(loaded_turn["bearing_in"].torsion[0]))


def test_the_camera_sees_arrows_and_axes(loaded_turn: cd.Sweep) -> None:
    bare, full = (scenery(loaded_turn, parts).points for parts in (NONE, ALL))
    assert np.min(full[:, 0]) < np.min(bare[:, 0])
    assert np.max(full[:, 2]) > np.max(bare[:, 2])


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("revolute", True), ("prismatic", True), ("spherical", False), ("fixed", False)],
)
def test_joints_with_an_axis(kind: str, expected: bool, joint: cd.Mechanism) -> None:
    assert has_axis(dataclasses.replace(joint.joints["pin_in"], type=kind)) is expected


def test_bearings_carry_what_moves_on_what_stands_still(loaded_turn: cd.Sweep) -> None:
    # The frame of the output bearing hangs on a joint that is held, and stands still.
    assert scenery(loaded_turn, NONE).bearings == ("bearing_in", "bearing_out")
    assert scenery(loaded_turn, NONE, ("pin_in", "pin_out")).bearings == ("pin_in", "pin_out")


def test_bearings_of_a_still_are_on_the_ground() -> None:
    still = Still(cd.assemble(cd.load("four_bar"), near={"crank_bearing": 0.7}))
    scene = build(still, still.outputs, ALL, np.arange(1))
    assert scene.bearings == ("crank_bearing", "rocker_bearing")


def test_drives_and_gravity_are_arrows() -> None:
    mechanism = cd.load("stewart_platform")
    legs = [f"leg_{k}" for k in range(1, 7)]
    turn = cd.Scene(mechanism, drive=legs, gravity=(0.0, 3.0, -4.0)).sweep(np.zeros((25, 6)))
    scene = scenery(turn, NONE._replace(loads=True))
    drawn = {item.path for item in scene.drawing.objects}
    assert {"/loads/gravity", *(f"/drive/{leg}" for leg in legs)} <= drawn
    for path, direction in (
        ("/loads/gravity", np.array([0.0, 0.6, -0.8])),
        ("/drive/leg_1", turn.rotation("leg_1")[0] @ mechanism.joints["leg_1"].axis),
    ):
        arrow = Rotation.from_quat(placed(scene.drawing, path)["quaternion"])
        np.testing.assert_allclose(arrow.apply([0.0, 0.0, 1.0]), direction, atol=1e-12)
    # Gravity stands beside the mechanism, and the camera sees it.
    tail = placed(scene.drawing, "/loads/gravity")["position"]
    assert tail[0] < min(turn.origin(name)[0, 0] for name in mechanism.joints)
    assert np.min(scene.points[:, 0]) == pytest.approx(tail[0])


def test_a_drive_that_turns_is_an_arc_about_its_axis(loaded_turn: cd.Sweep) -> None:
    scene = scenery(loaded_turn, NONE._replace(loads=True))
    pose = placed(scene.drawing, "/drive/bearing_in")
    axis = Rotation.from_quat(pose["quaternion"]).apply([0.0, 0.0, 1.0])
    joint = loaded_turn.mechanism.joints["bearing_in"]
    np.testing.assert_allclose(axis, loaded_turn.rotation("bearing_in")[0] @ joint.axis, atol=1e-12)
    assert "/loads/gravity" not in {item.path for item in scene.drawing.objects}


def test_only_shafts_in_fixed_bearings_have_traces(loaded_turn: cd.Sweep) -> None:
    nodes = scenery(loaded_turn, NONE._replace(traces=True)).drawing.nodes
    traced = {path.split("/")[2] for path in nodes if path.startswith("/traces/")}
    # The bearing of the output is carried by the joint angle, which is held, and stands still as
    # well; the cross is carried by a shaft that turns.
    assert traced <= {"bearing_in", "bearing_out"} and "bearing_out" in traced


def test_a_moment_along_its_axis_leaves_no_trace() -> None:
    turn = cd.Scene(
        cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -60.0}
    ).sweep(np.linspace(0.0, 6.0, 25))
    assert np.ptp(turn["crank_bearing"].torsion) > 1.0
    assert roots(scenery(turn, NONE._replace(traces=True))) == BODIES


def test_points_move_on_their_paths() -> None:
    turn = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(np.linspace(0, 6.0, 97))
    pin = turn.origin("crank_pin")
    scene = build(turn, (), NONE, SAMPLES, paths={"pin": pin})
    point = scene.drawing.nodes["/paths/pin point"]
    np.testing.assert_allclose(point.position, pin[SAMPLES], atol=1e-12)
    (wire,) = (item for item in scene.drawing.objects if item.path == "/paths/pin")
    # A wire along the circle about the bearing of the crank.
    away = np.linalg.norm(wire.surface[0] - turn.origin("crank_bearing")[0], axis=1)
    radius = np.linalg.norm(pin[0] - turn.origin("crank_bearing")[0])
    np.testing.assert_allclose(away, radius, atol=1.01 * 0.005 * scene.drawing.size)
    assert ("path of pin", "paths") in {item[1:] for item in scene.drawing.legend}
