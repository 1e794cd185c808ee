"""Adjustable joints: fixed, unless a scene holds or drives them."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.scene.presets import PRESETS

URDF = Path(cd.__file__).parents[1] / "urdf"
BUNDLED = ("double_shaft_z", "double_shaft_w", "double_shaft_spatial", "drive_line")
POSITIONS = np.linspace(0.0, 7.0, 15)


def scene_of(mechanism: cd.Mechanism, **held: float) -> cd.Scene:
    preset = PRESETS[mechanism.name]
    bent = {joint: float(np.deg2rad(angle)) for joint, angle in preset.held_deg.items()}
    options = {"loads": preset.loads, "gravity": (0.0, 0.0, -9.81)}
    return cd.Scene(mechanism, drive="bearing_in", held={**bent, **held}, **options)


def edited(name: str, joint: str, **origin: str) -> cd.Mechanism:
    """Return a bundled mechanism with another origin of an adjustable joint, which stays fixed."""
    text = (URDF / f"{name}.urdf").read_text()
    start = text.index(f'<joint name="{joint}"')
    end = text.index("</joint>", start)
    stated = " ".join(f'{key}="{value}"' for key, value in origin.items())
    block = re.sub(r"<origin [^>]*/>", f"<origin {stated}/>", text[start:end])
    return cd.load(text[:start] + block + text[end:])


def assert_same(turn: cd.Sweep, expected: cd.Sweep) -> None:
    size = max(np.max(np.abs(expected[name].moment)) for name in expected)
    for name in expected:
        for part in ("force", "moment"):
            first, second = getattr(turn[name], part), getattr(expected[name], part)
            np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-12 * size)
        np.testing.assert_array_equal(turn[name].unique, expected[name].unique)


@pytest.mark.parametrize("name", BUNDLED)
def test_held_at_zero_they_are_as_if_they_were_fixed(name: str) -> None:
    mechanism = cd.load(name)
    alone, held = (
        scene_of(mechanism),
        scene_of(mechanism, **dict.fromkeys(mechanism.adjustable, 0.0)),
    )
    assert alone.mechanism is mechanism
    assert not any(joint in mechanism for joint in mechanism.adjustable)
    assert held.mechanism.base is mechanism
    assert held.mechanism.model.nv == mechanism.model.nv + len(mechanism.adjustable)
    assert_same(held.sweep(POSITIONS, 20.0), alone.sweep(POSITIONS, 20.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "joint", "value", "origin"),
    [
        ("double_shaft_z", "fork_phase", 0.7, {"xyz": "0.9 0 0", "rpy": "0.7 0 0"}),
        ("double_shaft_z", "shaft_length", 0.04, {"xyz": "0.94 0 0"}),
        ("double_shaft_z", "offset_y", -0.03, {"xyz": "0 -0.03 0"}),
        ("double_shaft_w", "offset_z", 0.02, {"xyz": "0 0 0.02"}),
        ("double_shaft_w", "tilt", 0.3, {"xyz": "0 0 0", "rpy": "0 0.3 0"}),
        ("double_shaft_spatial", "fork_phase", -1.2, {"xyz": "0.9 0 0", "rpy": "-1.2 0 0"}),
        ("double_shaft_spatial", "shaft_length", -0.05, {"xyz": "0.85 0 0"}),
        ("drive_line", "fork_phase_1", 0.4, {"xyz": "0.8 0 0", "rpy": "0.4 0 0"}),
        ("drive_line", "fork_phase_2", 1.5, {"xyz": "1 0 0", "rpy": "1.5 0 0"}),
        ("drive_line", "shaft_length", 0.03, {"xyz": "1.03 0 0"}),
    ],
)
def test_holding_one_is_what_editing_the_description_is(
    name: str, joint: str, value: float, origin: dict[str, str]
) -> None:
    turn = scene_of(cd.load(name), **{joint: value}).sweep(POSITIONS, 20.0)
    assert_same(turn, scene_of(edited(name, joint, **origin)).sweep(POSITIONS, 20.0))
    written = cd.load(cd.load(name).to_urdf({joint: value}))
    assert written.description.agrees(edited(name, joint, **origin).description, 1e-14)
    # What holds it is the wrench of its joint along its axis.
    part = "axial" if turn.mechanism.drivable[joint].slides else "torsion"
    np.testing.assert_allclose(turn.holding_effort[joint], getattr(turn[joint], part), atol=1e-9)


def test_thousands_of_designs_are_one_sweep() -> None:
    """A phase of 90° makes a Z arrangement as uneven as its two joints are together."""
    shaft = cd.load("double_shaft_z")
    held = {"joint_angle_1": 0.35, "joint_angle_2": 0.35, "fork_phase": 0.0}
    scene = cd.Scene(shaft, drive="bearing_in", held=held)
    phase = np.array([[0.0], [0.25 * np.pi], [0.5 * np.pi]])
    position = np.linspace(0.0, 2.0 * np.pi, 721)
    ratio = scene.sweep(position, held={"fork_phase": phase}).motion.ratio("bearing_out")
    unevenness = np.ptp(ratio, axis=1)
    assert unevenness[0] < 1e-14
    assert unevenness[0] < unevenness[1] < unevenness[2]
    # Both joints in phase: each multiplies the speed by up to cos β and 1/cos β.
    np.testing.assert_allclose(np.max(ratio[2]), 1.0 / np.cos(0.35) ** 2, rtol=1e-9)


def test_they_may_be_driven() -> None:
    shaft = cd.load("double_shaft_z")
    held = {"joint_angle_1": 0.2, "joint_angle_2": 0.1, "bearing_in": 0.4}
    scene = cd.Scene(shaft, drive="offset_z", held=held, loads={"bearing_out": -10.0})
    low, high = scene.motion_range()
    assert low < -0.5
    assert high > 0.5
    assert scene.sweep(np.linspace(-0.1, 0.1, 5)).power_residual < 1e-12


def test_descriptions_are_written_and_copied_with_them() -> None:
    mechanism = cd.load("drive_line")
    again = cd.load(mechanism.to_urdf())
    assert again.description == mechanism.description
    assert again.adjustable == mechanism.adjustable
    scene = scene_of(mechanism, tilt=0.1)
    copy = pickle.loads(pickle.dumps(scene))
    assert copy.mechanism.model.nv == scene.mechanism.model.nv
    assert_same(copy.sweep(POSITIONS), scene.sweep(POSITIONS))
    other = scene.replace(held={"tilt": None, "fork_phase_1": 0.2})
    assert "tilt" not in other.mechanism
    assert "fork_phase_1" in other.mechanism
    moving = cd.load(scene.mechanism.to_urdf())
    assert moving.joint("tilt").type == "revolute"


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ('type="revolute" adjustable="revolute"', "only fixed joints are adjustable, and its type"),
        ('type="fixed" adjustable="spherical"', "cannot be adjustable 'spherical'; types: prism"),
        ('type="fixed" ajustable="revolute"', "ajustable"),
    ],
)
def test_false_declarations_are_refused(attributes: str, message: str) -> None:
    text = (
        f'<robot name="r"><link name="a"/><link name="b"/><joint name="j" {attributes}>'
        '<parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>'
    )
    with pytest.raises(cd.ModelError, match=message):
        cd.load(text)


def test_false_uses_are_refused() -> None:
    shaft = cd.load("double_shaft_z")
    for arguments in ({"loads": {"fork_phase": 1.0}}, {"near": {"fork_phase": 0.1}}):
        with pytest.raises(cd.ArgumentError, match="'fork_phase' is fixed in this scene; hold it"):
            scene_of(shaft).replace(**arguments)
    loaded = scene_of(shaft, fork_phase=0.1).replace(loads={"fork_phase": 1.0})
    with pytest.raises(cd.ArgumentError, match="'fork_phase' is fixed in this scene; hold it"):
        loaded.replace(held={"fork_phase": None})
    for scene in (scene_of(shaft, fork_phase=0.1), scene_of(shaft)):
        with pytest.raises(cd.ArgumentError, match="'offset_y' is fixed in this scene; hold it"):
            scene.sweep(0.0, held={"offset_y": 0.1})
