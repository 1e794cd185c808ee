"""What the page tells beside the picture: slider, state and numbers."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.viewer.commands import Arrays, Place
from cardan_dyn.practice.viewer.mode_shapes import mode_sweep
from cardan_dyn.practice.viewer.readings import course, readings
from cardan_dyn.practice.viewer.still import Still

FOUR_BAR = cd.load("four_bar")


def told(sweep: cd.Sweep | Still, joints: tuple[str, ...] | None = None) -> dict[str, Any]:
    """What is told of all samples, its arrays read back."""
    samples, arrays = np.arange(len(sweep)), Arrays()
    along = course(sweep, samples, timed=False)
    data = readings(sweep, sweep.outputs if joints is None else joints, samples, arrays, along)
    content = base64.b64decode(arrays.base64())

    def read(value: Any) -> Any:
        if isinstance(value, Place):
            return np.frombuffer(content, f"<{value.kind}", value.size, value.at)
        if isinstance(value, dict):
            return {key: read(item) for key, item in value.items()}
        return [read(item) for item in value] if isinstance(value, list) else value

    return read(data)


def turn(**options: Any) -> cd.Sweep:
    speed = options.pop("speed", 0.0)
    scene = cd.Scene(FOUR_BAR, drive="crank_bearing", **options)
    return scene.sweep(np.linspace(0.0, 2.0 * np.pi, 9), speed=speed)


def test_a_drive_that_turns_is_told_in_degrees_without_a_time() -> None:
    along = told(turn(loads={"rocker_bearing": 3.0}))["course"]
    assert (along["name"], along["unit"], along["seconds"]) == ("crank_bearing", "°", None)
    np.testing.assert_allclose(along["values"], 45.0 * np.arange(9))


def test_speeds_tell_when_each_sample_is_passed() -> None:
    along = told(turn(speed=4.0))["course"]
    np.testing.assert_allclose(along["seconds"], np.linspace(0.0, 0.5 * np.pi, 9))
    # Against the positions, nobody would get there.
    assert told(turn(speed=-4.0))["course"]["seconds"] is None


def test_slides_are_told_in_metres() -> None:
    block = cd.load(
        '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>'
    )
    scene = cd.Scene(block, drive="j")
    along = told(scene.sweep(np.linspace(0.0, 0.05, 3)))["course"]
    assert along["unit"] == "m"
    np.testing.assert_allclose(along["values"], [0.0, 0.025, 0.05])
    # Downwards as well: the slider goes along with the drive.
    assert told(scene.sweep([2.0, 0.0]))["course"]["values"].tolist() == [2.0, 0.0]


def test_a_simulation_is_told_in_seconds() -> None:
    scene = cd.Scene(FOUR_BAR, free="crank_bearing", gravity=(0.0, -9.81, 0.0))
    sweep = scene.simulate(0.5, position=0.3).evenly(11).sweep
    along = course(sweep, np.arange(11), timed=True)
    assert (along.name, along.unit) == ("time", "s")
    np.testing.assert_allclose(along.values, np.linspace(0.0, 0.5, 11))


def test_what_closes_without_a_drive_that_advances_has_a_phase() -> None:
    scene = cd.Scene(FOUR_BAR, drive="crank_bearing")
    swing = scene.sweep(0.3 * np.sin(np.linspace(0.0, 2.0 * np.pi, 9)))
    along = course(swing, np.arange(9), timed=False)
    assert (along.name, along.unit) == ("phase", "°")
    half = course(swing, np.arange(4), timed=False)
    assert (half.name, half.unit) == ("course", "%")
    np.testing.assert_allclose(half.values, [0.0, 100 / 3, 200 / 3, 100.0])


def test_one_sample_and_a_still_have_no_course() -> None:
    one = cd.Scene(FOUR_BAR, drive="crank_bearing").sweep([0.3])
    still = Still(cd.assemble(FOUR_BAR, near={"crank_bearing": 0.7}))
    for sweep in (one, still):
        assert course(sweep, np.arange(1), timed=False).values is None
    assert told(still)["state"] == [] and all(not item["series"] for item in told(still)["joints"])


def test_the_state_names_drive_speed_loads_held_and_gravity() -> None:
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": np.pi / 6.0},
        loads={"bearing_out": np.array([-1.0, -2.0])},
        gravity=(0.0, 0.0, -9.81),
    )
    rows = {row["kind"]: row for row in told(scene.sweep([0.0, 0.5], speed=10.0))["state"]}
    assert set(rows) == {"drive", "speed", "load", "held", "gravity"}
    assert rows["speed"]["value"] == 10.0 and rows["speed"]["unit"] == "rad/s"
    assert rows["held"]["value"] == pytest.approx(30.0) and rows["held"]["unit"] == "°"
    np.testing.assert_array_equal(rows["load"]["values"], [-1.0, -2.0])
    assert (rows["load"]["joint"], rows["load"]["node"]) == ("bearing_out", "bearing_out moment")
    assert rows["gravity"]["value"] == pytest.approx(9.81)


def test_loads_on_links_are_told_by_their_sizes() -> None:
    load = cd.Wrench(force=(3.0, 4.0, 0.0))
    (row,) = (
        item for item in told(turn(loads={"rocker": load}))["state"] if item["kind"] == "load"
    )
    assert (row["name"], row["value"], row["unit"]) == ("rocker, force", 5.0, "N")
    assert (row["joint"], row["node"]) == ("", "rocker force")


def test_rounding_of_an_axis_opens_nothing() -> None:
    """Descriptions whose frames are turned have axes like this one."""
    text = FOUR_BAR.to_urdf().replace('xyz="0.0 0.0 1.0" />', 'xyz="1e-17 0 1" />')
    assert "1e-17" in text
    mechanism = cd.load(text)
    assert mechanism.joints["crank_bearing"].axis[0] == pytest.approx(1e-17, rel=1e-12)
    scene = cd.Scene(mechanism, drive="crank_bearing", loads={"rocker_bearing": -3.0})
    joints = {item["name"]: item for item in told(scene.sweep([0.1, 0.2]))["joints"]}
    series = {item["name"]: item["unique"] for item in joints["crank_bearing"]["series"]}
    assert series["torsion"] and series["shear"] and not (series["bending"] or series["axial"])


def test_the_numbers_of_a_joint_are_those_of_the_sweep() -> None:
    sweep = turn(loads={"rocker_bearing": -3.0}, speed=5.0)
    joints = {item["name"]: item for item in told(sweep)["joints"]}
    series = {item["name"]: item for item in joints["crank_bearing"]["series"]}
    wrench = sweep["crank_bearing"]
    assert set(series) == {"torsion", "bending", "force", "axial", "shear", "drive"}
    # Curves that cover each other have the first one's colour: that of the arrow, which is the
    # shear of a force that is all shear.
    assert list(series).index("shear") < list(series).index("force")
    assert series["torsion"]["color"] == "#c2185b"
    assert series["drive"]["means"] == "effort of the drive"
    for name in ("torsion", "shear"):
        np.testing.assert_allclose(series[name]["values"], getattr(wrench, name), rtol=1e-6)
    np.testing.assert_allclose(series["drive"]["values"], sweep.drive_effort, rtol=1e-6)
    assert (series["torsion"]["unit"], series["force"]["unit"]) == ("N·m", "N")
    # A flat linkage of four hinges: what acts across its plane, and the tilts, stay open.
    assert series["torsion"]["unique"] and series["shear"]["unique"]
    assert not (series["bending"]["unique"] or series["axial"]["unique"])
    assert joints["crank_bearing"]["open"] == (
        "Not unique: force z, moment xy, chosen by least norm."
    )
    assert (joints["crank_bearing"]["parent"], joints["crank_bearing"]["child"]) == (
        *("base", "crank"),
    )
    assert joints["rocker_pin"]["type"] == "continuous, closes a loop"
    assert {joints["rocker_pin"]["parent"], joints["rocker_pin"]["child"]} == {"coupler", "rocker"}


def test_rounding_is_told_as_zero_and_only_what_is_shown_is_told() -> None:
    (pin,) = told(turn(loads={"rocker_bearing": -3.0}), ("crank_pin",))["joints"]
    assert pin["name"] == "crank_pin"
    series = {item["name"]: item for item in pin["series"]}
    assert not np.any(series["torsion"]["values"])  # A pin without friction.


def test_a_ball_has_sizes_alone() -> None:
    mechanism = cd.load("stewart_platform")
    legs = [name for name in mechanism.joints if name.startswith("leg_")]
    scene = cd.Scene(mechanism, drive=legs, gravity=(0.0, 0.0, -9.81))
    sweep = scene.sweep(np.array([[0.0] * 6, [0.01] * 6]))
    joints = {item["name"]: item for item in told(sweep)["joints"]}
    ball = next(name for name, joint in mechanism.joints.items() if joint.type == "spherical")
    assert [item["name"] for item in joints[ball]["series"]] == ["moment", "force"]


def test_a_slide_tells_its_stroke() -> None:
    turn = cd.Scene(cd.load("slider_crank"), drive="crank_bearing").sweep(
        np.linspace(0.0, 6.28, 63)
    )
    strokes = {item["name"]: item["stroke"] for item in told(turn)["joints"]}
    ends = turn.motion.position("piston_guide")
    assert strokes.pop("piston_guide") == [np.min(ends), np.max(ends)]
    assert not any(strokes.values())


def test_a_mode_says_how_large_it_is_drawn() -> None:
    from testkit import elastic_rigs

    rig = elastic_rigs.scene(elastic_rigs.elastic_rig(), 0.2)
    swing = mode_sweep(rig, [1.0, 0.5j], size=0.05, samples=37)
    data = readings(
        swing,
        swing.outputs,
        np.arange(37),
        Arrays(),
        course(swing, np.arange(37), timed=False),
        set(rig.free),
    )
    assert "tilt_z swings by 2.865° to both sides" in data["mode"]
    assert "no size of its own" in data["mode"]
    kinds = {row["name"]: row["kind"] for row in data["state"] if row["kind"] in ("drive", "swing")}
    assert kinds == {"bearing_in": "drive", "tilt_z": "swing", "tilt_y": "swing"}
    assert not any(joint["series"] for joint in data["joints"])
    assert told(swing)["mode"] == "" and any(item["series"] for item in told(swing)["joints"])


def test_a_mode_is_shown_over_its_phase() -> None:
    from testkit import elastic_rigs

    rig = elastic_rigs.scene(elastic_rigs.elastic_rig(), 0.2)
    swing = mode_sweep(rig, [1.0, 1.0j], size=0.05, samples=13)
    assert course(swing, np.arange(13), timed=False).name == "phase"
    turning = mode_sweep(rig, [1.0, 1.0j], size=0.05, turns=1, samples=13)
    assert course(turning, np.arange(13), timed=False).name == "bearing_in"
