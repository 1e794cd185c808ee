"""Bodies that are drawn: which points they sweep, and how often they are animated."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from scipy.spatial.transform import Rotation
from testkit.drawn import placed

import cardan_dyn as cd
from cardan_dyn.practice.viewer.bodies import GROUND, PALETTE, Bodies
from cardan_dyn.practice.viewer.commands import Drawing

SAMPLES = np.arange(0, 25, 2)


def paths(drawing: Drawing) -> list[str]:
    return [item.path for item in drawing.objects]


def test_points_contain_every_joint_and_every_corner(loaded_turn: cd.Sweep) -> None:
    bodies = Bodies(loaded_turn, SAMPLES, visuals=True)
    points = bodies.points()
    for name in loaded_turn.mechanism.joints:
        for origin in loaded_turn.origin(name)[SAMPLES]:
            assert np.min(np.linalg.norm(points - origin, axis=1)) < 1e-15
    # The first sample's corners of the input shaft, placed by hand.
    shaft = next(shape for shape in bodies.shapes if shape.link == "shaft_in")
    rotation, origin = (f("bearing_in")[0] for f in (loaded_turn.rotation, loaded_turn.origin))
    for corner in shaft.corners():
        placed = rotation @ corner + origin
        assert np.min(np.linalg.norm(points - placed, axis=1)) < 1e-12


def test_each_shape_is_drawn_once_under_its_body(loaded_turn: cd.Sweep) -> None:
    bodies = Bodies(loaded_turn, SAMPLES, visuals=True)
    drawing = Drawing(1.0)
    bodies.draw(drawing)
    drawn = paths(drawing)
    assert len(drawn) == len(set(drawn)) == len(bodies.shapes) > 3
    assert all(path.startswith("/mechanism/") for path in drawn)


def test_bodies_without_visuals_have_shapes_between_their_joints() -> None:
    turn = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep([0.0, 1.0])
    bodies = Bodies(turn, np.arange(2), visuals=False)
    assert bodies.shapes == []
    drawing = Drawing(1.0)
    bodies.draw(drawing)
    assert {path.rpartition("/")[0] for path in paths(drawing)} == {
        *("/mechanism/crank", "/mechanism/coupler", "/mechanism/rocker"),
        *("/bearings/crank_bearing", "/bearings/rocker_bearing"),
    }
    # Each link reaches both of its joints, and little beyond; so does what the camera sees.
    seen = bodies.points()
    for link, joints in (
        ("crank", ("crank_bearing", "crank_pin")),
        ("coupler", ("crank_pin", "rocker_pin")),
        ("rocker", ("rocker_pin", "rocker_bearing")),
    ):
        cloud = world(drawing, f"/mechanism/{link}/shape")
        ends = np.array([turn.origin(name)[0] for name in joints])
        gaps = np.linalg.norm(cloud[:, None] - ends, axis=2)
        assert np.max(np.min(gaps, axis=0)) < 0.03  # Forks hold pins that are 8 mm thick.
        low, high = np.min(ends, axis=0) - 0.03, np.max(ends, axis=0) + 0.03
        assert np.all((cloud > low) & (cloud < high))
        assert np.all(cloud > np.min(seen, axis=0) - 1e-9)
        assert np.all(cloud < np.max(seen, axis=0) + 1e-9)


def world(drawing: Drawing, path: str) -> np.ndarray:
    """Return the points of an object at the first sample."""
    (item,) = (item for item in drawing.objects if item.path == path)
    node = placed(drawing, path.rpartition("/")[0])
    turn = Rotation.from_quat(node["quaternion"]).as_matrix()
    return np.asarray(item.surface[0] @ turn.T + node["position"])


def test_colors_are_those_of_links_whatever_else_is_drawn() -> None:
    ball = "<visual><geometry><sphere radius='0.01'/></geometry></visual>"
    text = """<robot name="r"><link name="a"/><link name="b">{}</link><link name="c"/>
      <joint name="j" type="continuous"><parent link="a"/><child link="b"/>
      <axis xyz="0 0 1"/></joint>
      <joint name="k" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/>
      <axis xyz="0 0 1"/></joint></robot>"""
    colors = []
    for shape in ("", ball):
        turn = cd.Scene(cd.load(text.format(shape)), drive=["j", "k"]).sweep([[0, 0], [1, 1]])
        drawing = Drawing(1.0)
        Bodies(turn, np.arange(2), visuals=True).draw(drawing)
        colors.append({item.path: item.color.css for item in drawing.objects})
    assert colors[0]["/mechanism/b/shape"] == colors[1]["/mechanism/b/b 0"] == PALETTE[1].css
    assert colors[0]["/mechanism/c/shape"] == colors[1]["/mechanism/c/shape"] == PALETTE[2].css
    assert colors[0]["/bearings/j/shape"] == GROUND.css


def test_a_floor_alone_leaves_the_bearings_of_the_ground() -> None:
    model = """<mujoco model="m"><worldbody><geom type="plane" size="0 0 1"/><body name="b">
      <joint name="j" axis="0 1 0"/><inertial pos="0 0 -1" mass="1" diaginertia="1 1 1"/></body>
      </worldbody></mujoco>"""
    turn = cd.Scene(cd.load(model), drive="j").sweep([0.0, 1.0])
    bodies = Bodies(turn, np.arange(2), visuals=True)
    drawing = Drawing(1.0)
    bodies.draw(drawing)
    assert {"/mechanism/world/world 0", "/bearings/j/shape", "/mechanism/b/shape"} <= set(
        paths(drawing)
    )
    floor = next(item for item in drawing.objects if item.path == "/mechanism/world/world 0")
    assert floor.color.opacity < 0.5
    # It says nothing of the size of the scene.
    assert np.max(np.abs(bodies.points())) < 1.5


UNIVERSAL = """<robot name="u"><link name="a"/><link name="b"/><link name="c"/>
<joint name="bearing" type="continuous"><parent link="a"/><child link="b"/>
<axis xyz="1 0 0"/></joint>
<joint name="u" type="universal"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/>
<axis xyz="0 1 0"/><axis2 xyz="0 0 1"/></joint></robot>"""


def test_a_universal_joint_has_a_cross_that_turns_with_both_sides() -> None:
    names = ["bearing", "u.turn_1", "u.turn_2"]
    positions = np.random.default_rng(3).uniform(-1.0, 1.0, (5, 3))
    turn = cd.Scene(cd.load(UNIVERSAL), drive=names).sweep(positions)
    drawing = Drawing(1.0)
    Bodies(turn, np.arange(5), visuals=True).draw(drawing)
    pose = drawing.nodes["/mechanism/c u"]
    axes = Rotation.from_quat(pose.quaternion).as_matrix()
    # The first axis is carried by the input, the second one by the output.
    for sample, (first, second, _) in enumerate(positions):
        shaft = Rotation.from_rotvec([first, 0.0, 0.0])
        np.testing.assert_allclose(axes[sample][:, 0], shaft.apply([0.0, 1.0, 0.0]), atol=1e-12)
        carried = shaft * Rotation.from_rotvec([0.0, second, 0.0])
        np.testing.assert_allclose(axes[sample][:, 1], carried.apply([0.0, 0.0, 1.0]), atol=1e-12)
    np.testing.assert_allclose(pose.position, np.tile([1.0, 0.0, 0.0], (5, 1)), atol=1e-12)


def test_housings_of_a_drive_line_stand_where_its_bearings_are() -> None:
    line = cd.drive_lines.DriveLine.from_toml("rolling_mill")
    turn = line.scene().sweep([0.0, 1.0])
    drawing = Drawing(1.0)
    Bodies(turn, np.arange(2), visuals=True).draw(drawing)
    housings = [path for path in paths(drawing) if path.startswith("/bearings/")]
    supports = [name for name in turn.mechanism.joints if name.startswith("support_")]
    assert len(supports) == 4
    assert sorted(housings) == sorted(f"/bearings/{name}/shape" for name in supports)
    for name in supports:
        cloud = world(drawing, f"/bearings/{name}/shape")
        # The housing is about its bearing, and its foot is below.
        middle = cloud[:, :2].min(axis=0) / 2.0 + cloud[:, :2].max(axis=0) / 2.0
        np.testing.assert_allclose(middle, turn.origin(name)[0, :2], atol=0.05)
        assert cloud[:, 2].max() > turn.origin(name)[0, 2] > cloud[:, 2].min() + 0.2
    assert not any("sleeve" in path or "place" in path for path in paths(drawing))


def linear(css: str) -> np.ndarray:
    """Return red, green and blue in proportion to their light."""
    values = np.array([int(css[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(light: np.ndarray) -> np.ndarray:
    """Return colours in CIELAB, whose distances are those that eyes see."""
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.clip(light, 0.0, 1.0) @ np.transpose(to_xyz) / [0.9505, 1.0, 1.089]).T
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=1)


# Red, green and blue as eyes without one kind of cones see them (Machado, Oliveira and Fernandes,
# IEEE Transactions on Visualization and Computer Graphics 15, 2009, severity 1).
PROTAN = [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
]
DEUTAN = [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
]


def test_the_palette_is_seen_by_all_eyes_on_both_backgrounds() -> None:
    light = np.array([linear(color.css) for color in (*PALETTE, GROUND)])
    luminance = light @ [0.2126, 0.7152, 0.0722]
    for background in ("#f0f4f9", "#191e25"):
        other = linear(background) @ [0.2126, 0.7152, 0.0722]
        ratio = (np.maximum(luminance, other) + 0.05) / (np.minimum(luminance, other) + 0.05)
        assert np.min(ratio) >= 2.9
    for eyes in (np.eye(3), PROTAN, DEUTAN):
        seen = lab(light[:-1] @ np.transpose(eyes))
        neighbours = np.linalg.norm(seen - np.roll(seen, -1, axis=0), axis=1)
        assert np.min(neighbours) > 15.0


def test_missing_meshes_are_noted_with_what_stands_in() -> None:
    mesh = "<visual><geometry><mesh filename='/none/b.stl'/></geometry></visual>"
    turn = cd.Scene(
        cd.load(
            f"""<robot name="r"><link name="a"/><link name="b">{mesh}</link>
      <joint name="j" type="continuous"><parent link="a"/><child link="b"/>
      <axis xyz="0 0 1"/></joint>
      </robot>"""
        ),
        drive="j",
    ).sweep([0.0, 1.0])
    bodies = Bodies(turn, np.arange(2), visuals=True)
    drawing = Drawing(1.0)
    bodies.draw(drawing)
    missing, stand_in = bodies.notes
    assert missing.startswith("a mesh was not found: '/none/b.stl' (link 'b'); looked in /")
    assert stand_in == "made up from joints: b"
    assert "/mechanism/b/shape" in paths(drawing)


def test_loops_are_known_by_name(loaded_turn: cd.Sweep) -> None:
    names = {item.get("name") for item in loops(loaded_turn)}
    assert Bodies(loaded_turn, SAMPLES, visuals=False).loops == names


def loops(turn: cd.Sweep) -> list[ElementTree.Element]:
    return ElementTree.fromstring(turn.mechanism.description.source.text).findall("loop")
