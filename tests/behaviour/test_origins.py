"""Lengths and angles of a description, held or driven by name, beside texts that state them."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pytest
from testkit.coordinates import sloped

import cardan_dyn as cd

PHI = np.linspace(0.1, 1.4, 7)
COMPONENTS = {
    **{name: ("xyz", index) for index, name in enumerate("xyz")},
    **{name: ("rpy", index) for index, name in enumerate(("roll", "pitch", "yaw"))},
}
BODY = (
    '<inertial><origin xyz="0.1 0.02 -0.03"/><mass value="2"/>'
    '<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="0"/></inertial>'
)
ARM = f"""<robot name="arm"><link name="base"/><link name="upper">{BODY}</link>
<link name="mount"/><link name="lower">{BODY}</link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
 <origin xyz="0.1 0.2 0.3" rpy="0.4 -0.7 0.9"/><axis xyz="0 0 1"/></joint>
<joint name="plate" type="fixed"><parent link="upper"/><child link="mount"/>
 <origin xyz="0.3 0 0.1" rpy="1.1 0.2 -2.4"/></joint>
<joint name="elbow" type="continuous"><parent link="mount"/><child link="lower"/>
 <origin xyz="0 0.1 0" rpy="-0.3 1.2 0.5"/><axis xyz="0 1 0"/></joint></robot>"""
GEARS = f"""<robot name="gears"><link name="base"/><link name="plate"/>
<link name="small">{BODY}</link><link name="great">{BODY}</link>
<joint name="swing" type="continuous"><parent link="base"/><child link="plate"/>
 <axis xyz="0 0 1"/></joint>
<joint name="motor" type="continuous"><parent link="plate"/><child link="small"/>
 <axis xyz="0 0 1"/></joint>
<joint name="wheel" type="continuous"><parent link="plate"/><child link="great"/>
 <origin xyz="0.12 0 0"/><axis xyz="0 0 1"/></joint>
<coupling name="teeth" forces="none"><predecessor link="small"/><successor link="great"/>
 <ratio value="-0.5"/></coupling></robot>"""


def edited(text: str, changes: Mapping[str, float]) -> cd.Mechanism:
    """Return the mechanism of a text whose numbers are greater by some amounts."""
    robot = ElementTree.fromstring(text)
    for name, by in changes.items():
        joint, component = name.removeprefix("origin:").rsplit(".", 1)
        named, _, end = joint.partition(".")
        place = next(item for item in robot if item.get("name") == named and item.tag != "link")
        if end:
            place = place.find(end)
        origin = place.find("origin")
        if origin is None:
            origin = ElementTree.SubElement(place, "origin")
        key, index = COMPONENTS[component]
        numbers = [float(word) for word in origin.get(key, "0 0 0").split()]
        numbers[index] += float(by)
        origin.set(key, " ".join(map(repr, numbers)))
    return cd.load(ElementTree.tostring(robot, encoding="unicode"))


def assert_same(found: cd.Sweep, expected: cd.Sweep) -> None:
    """Wrenches of all joints of a description, drive efforts and motions agree to rounding."""
    size = max(np.abs(expected[name].force).max() for name in expected)
    size = max(size, max(np.abs(expected[name].moment).max() for name in expected))
    for name in expected:
        unique = expected[name].unique
        np.testing.assert_array_equal(found[name].unique, unique)
        for part, own in (("force", unique[:3]), ("moment", unique[3:])):
            values, wanted = (getattr(sweep[name], part)[..., own] for sweep in (found, expected))
            np.testing.assert_allclose(values, wanted, rtol=0.0, atol=1e-11 * size)
    effort = expected.drive_effort
    np.testing.assert_allclose(found.drive_effort, effort, rtol=0.0, atol=1e-11 * size)


CASES: dict[str, tuple[str, dict[str, Any], dict[str, float]]] = {
    "lengths of a linkage": (
        "four_bar",
        {"drive": "crank_bearing", "loads": {"rocker_bearing": -5.0}, "gravity": (0, -9.81, 0)},
        {
            "origin:rocker_pin.successor.x": 0.011,
            "origin:crank_pin.x": -0.006,
            "origin:rocker_pin.predecessor.y": 0.004,
            "origin:rocker_bearing.y": -0.02,
        },
    ),
    "all of a placement": (
        ARM,
        {"drive": ["shoulder", "elbow"], "gravity": (0.0, 0.0, -9.81)},
        {
            **{f"origin:elbow.{name}": 0.1 + 0.07 * k for k, name in enumerate(COMPONENTS)},
            "origin:plate.roll": 0.3,
            "origin:plate.z": -0.2,
            "origin:shoulder.pitch": 0.25,
            "origin:shoulder.roll": -0.4,
        },
    ),
    "the phase of a fork": (
        "universal_joint",
        {
            "drive": "bearing_in",
            "held": {"joint_angle": 0.4},
            "loads": {"bearing_out": -100.0},
        },
        {"origin:pin_in.roll": 0.5},
    ),
    "feet and balls of a platform": (
        "stewart_platform",
        {"drive": [f"leg_{k}" for k in range(1, 7)], "gravity": (0.0, 0.0, -9.81)},
        {
            "origin:base_2_x.x": 0.03,
            "origin:base_2_x.yaw": 0.02,
            "origin:ball_3.successor.y": 0.02,
            "origin:ball_4.predecessor.z": -0.01,
        },
    ),
    "the distance of gears": (
        GEARS,
        {"drive": "motor", "held": {"swing": 0.3}, "gravity": (0.0, -9.81, 0.0)},
        {"origin:wheel.x": 0.02, "origin:motor.yaw": 0.3},
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_holding_one_is_what_a_text_with_it_is(case: str) -> None:
    source, arguments, changes = CASES[case]
    text = source if source.startswith("<") else cd.load(source).to_urdf()
    held = {**arguments.get("held", {}), **dict.fromkeys(changes, 0.0)}
    scene = cd.Scene(cd.load(source), **{**arguments, "held": held})
    drives = len(scene.drives)
    rows = PHI if drives == 1 else 0.02 * PHI[:, None] * np.arange(1, drives + 1)
    given = {"speed": 3.0, "acceleration": 0.7}
    assert_same(
        scene.sweep(rows, **given), cd.Scene(cd.load(source), **arguments).sweep(rows, **given)
    )
    found = scene.sweep(rows, held=changes, **given)
    expected = cd.Scene(edited(text, changes), **arguments).sweep(rows, **given)
    assert_same(found, expected)
    again = pickle.loads(pickle.dumps(scene)).sweep(rows, held=changes, **given)
    assert_same(again, expected)
    assert_same(
        cd.Scene(cd.load(source), **{**arguments, "held": {**held, **changes}}).sweep(
            rows, **given
        ),
        expected,
    )


@pytest.mark.parametrize("case", CASES)
def test_what_is_held_is_written_as_a_text_with_it(case: str) -> None:
    source, arguments, changes = CASES[case]
    mechanism = cd.load(source)
    written = cd.load(mechanism.to_urdf(changes))
    expected = edited(mechanism.to_urdf(), changes)
    assert written.description.agrees(expected.description, 1e-14)
    assert not mechanism.description.agrees(expected.description, 1e-3)
    held = cd.Scene(mechanism, **{**arguments, "held": {**arguments.get("held", {}), **changes}})
    drives = len(held.drives)
    rows = PHI if drives == 1 else 0.02 * PHI[:, None] * np.arange(1, drives + 1)
    found = cd.Scene(written, **arguments).sweep(rows, speed=3.0)
    effort = held.sweep(rows, speed=3.0).drive_effort
    np.testing.assert_allclose(
        found.drive_effort, effort, rtol=0.0, atol=1e-12 * np.abs(effort).max()
    )
    # A scene's own mechanism, in which they are joints, is written as the one that was loaded.
    assert held.mechanism.to_urdf(changes) == mechanism.to_urdf(changes)


def test_what_is_no_length_is_not_written() -> None:
    bar = cd.load("four_bar")
    for name, value, error, message in (
        ("crank_bearing", 0.1, cd.ModelError, "'crank_bearing' says no length or angle"),
        ("mass:crank", 0.1, cd.ModelError, "'mass:crank' says no length or angle"),
        ("origin:crank.x", 0.1, cd.ModelError, "joints are"),
        ("origin:crank_pin.u", 0.1, cd.ArgumentError, "name a component"),
        ("origin:crank_pin.x", [0.1, 0.2], cd.ArgumentError, "expected a number"),
    ):
        with pytest.raises(error, match=message):
            bar.to_urdf({name: value})


def test_derivatives_by_what_is_held_are_those_by_what_is_fixed() -> None:
    """One is of a joint's coordinate, the other of the numbers of a tree."""
    for case in ("lengths of a linkage", "all of a placement"):
        source, arguments, changes = CASES[case]
        mechanism = cd.load(source)
        rows = PHI if case.startswith("lengths") else PHI[:, None] * [1.0, -0.6]
        plain = cd.Scene(mechanism, **arguments).sweep(rows, speed=3.0).derivative(*changes)
        scene = cd.Scene(mechanism, **arguments, held=dict.fromkeys(changes, 0.0))
        held = scene.sweep(rows, speed=3.0).derivative(*changes)
        for name in changes:
            size = max(1.0, np.abs(plain[name].drive_effort).max())
            found, expected = held[name].drive_effort, plain[name].drive_effort
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * size)
            for joint in mechanism.joints:
                found, expected = held[name][joint].moment, plain[name][joint].moment
                np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11 * size)


def test_derivatives_by_one_angle_beside_others_that_are_held() -> None:
    """Angles count in the order of a text, however far those before them are turned."""
    held = {"origin:elbow.yaw": 0.8, "origin:elbow.roll": -0.5, "origin:elbow.x": 0.1}
    scene = cd.Scene(cd.load(ARM), drive=["shoulder", "elbow"], gravity=(0, 0, -9.81), held=held)
    rows = PHI[:, None] * [1.0, -0.6]
    step = 1e-3
    for name in ("origin:elbow.pitch", "origin:elbow.y", "origin:plate.yaw"):
        found = scene.sweep(rows).derivative(name).drive_effort
        moved = scene.replace(held={name: 0.0})
        at = [moved.sweep(rows, held={name: k * step}).drive_effort for k in (-2, -1, 1, 2)]
        differences = (8.0 * (at[2] - at[1]) - (at[3] - at[0])) / (12.0 * step)
        np.testing.assert_allclose(found, differences, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("yaw", [0.0, np.pi / 4, -np.pi / 4])
def test_derivatives_by_angles_that_turn_the_axes_of_held_ones(yaw: float) -> None:
    """Axes along x, y or z are kept as such, and turn away from there or come to lie there."""
    text = ARM.replace('rpy="-0.3 1.2 0.5"', f'rpy="0 0 {yaw!r}"')
    assert text != ARM
    arm, rows, step = cd.load(text), np.array([[0.2, 0.3]]), 1e-3
    for held, name in (("pitch", "yaw"), ("roll", "yaw"), ("roll", "pitch")):
        scene = cd.Scene(
            arm,
            drive=["shoulder", "elbow"],
            gravity=(1, 2, -9.81),
            held={f"origin:elbow.{held}": 0.1},
        )
        found = scene.sweep(rows).derivative(f"origin:elbow.{name}").drive_effort
        moved = scene.replace(held={f"origin:elbow.{name}": 0.0})
        differences = sloped(
            lambda by, moved=moved, name=name: (
                moved.sweep(rows, held={f"origin:elbow.{name}": by}).drive_effort
            ),
            step,
        )
        np.testing.assert_allclose(found, differences, rtol=0.0, atol=1e-9)


def test_held_lengths_deform_bushings_that_texts_take_along() -> None:
    """Undeformed is what the zero of a description says, or `origin_b`."""
    name, half = "origin:shoulder.x", 0.5 * np.eye(6)
    for place in (None, (0.4, 0.2, 0.3)):
        rubber = cd.Bushing("upper", "base", (0.2, 0.0, 0.0), 100.0 * half, origin_b=place)

        def effort(by: float = 0.0, rubber: cd.Bushing = rubber, **options: Any) -> cd.Sweep:
            arm = cd.load(ARM.replace('xyz="0.1 0.2 0.3"', f'xyz="{0.1 + by!r} 0.2 0.3"'))
            scene = cd.Scene(arm, drive=["shoulder", "elbow"], elements=[rubber], **options)
            return scene.sweep([[0.3, 0.1]])

        texts = sloped(lambda by, effort=effort: effort(by).drive_effort)
        places = sloped(lambda by, effort=effort: effort(held={name: by}).drive_effort)
        assert effort().derivative(name).drive_effort == pytest.approx(texts, abs=1e-8)
        held = effort(held={name: 0.0}).derivative(name).drive_effort
        assert held == pytest.approx(places, abs=1e-8)
        assert (np.abs(texts - places).max() > 1.0) == (place is None)


def test_designs_are_samples_and_lengths_are_driven() -> None:
    name = "origin:rocker_pin.successor.x"
    bar = cd.load("four_bar")
    lengths = np.array([[-0.01], [0.0], [0.02]])
    scene = cd.Scene(bar, drive="crank_bearing", held={name: 0.0})
    many = scene.sweep(PHI, speed=4.0, held={name: lengths})
    for row, length in enumerate(lengths[:, 0]):
        one = cd.Scene(edited(bar.to_urdf(), {name: length}), drive="crank_bearing")
        expected = one.sweep(PHI, speed=4.0).drive_effort
        np.testing.assert_allclose(many.drive_effort[row], expected, rtol=0.0, atol=1e-12)
    # A cylinder in the rocker's place, with virtual work for its force.
    driven = cd.Scene(
        bar, drive=name, held={"crank_bearing": 0.7}, loads={"rocker_bearing": -5.0}
    ).sweep(np.linspace(-0.01, 0.02, 5))
    work = 5.0 * driven.motion.ratio("rocker_bearing")
    np.testing.assert_allclose(driven.drive_effort, work, rtol=0.0, atol=1e-11)


def test_open_drawings_are_closed_by_what_moves_and_not_by_lengths() -> None:
    """Drawn with all bars in line, a loop of 0.1, 0.25, 0.25 and 0.2 m is open by 0.1 m."""
    hinge = (
        '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/>'
        '<origin xyz="{} 0 0"/><axis xyz="0 0 1"/></joint>'
    )
    text = (
        '<robot name="open"><link name="base"/><link name="a"/><link name="b"/><link name="c"/>'
        + hinge.format("one", "base", "a", 0)
        + hinge.format("two", "a", "b", 0.1)
        + hinge.format("three", "base", "c", 0.2)
        + '<loop name="pin" type="continuous"><axis xyz="0 0 1"/><predecessor link="b">'
        '<origin xyz="0.25 0 0"/></predecessor><successor link="c"><origin xyz="0.25 0 0"/>'
        "</successor></loop></robot>"
    )
    lengths = dict.fromkeys(["origin:two.x", "origin:pin.predecessor.x", "origin:three.x"], 0.0)
    mechanism, position = cd.load(text), np.linspace(0.0, 1.0, 5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # Which of two assemblies is meant.
        plain, held = (
            cd.Scene(mechanism, drive="one", held=given).sweep(position).motion.position("three")
            for given in ({}, lengths)
        )
    np.testing.assert_allclose(held, plain, rtol=0.0, atol=1e-12)


def test_models_of_pinocchio_have_them() -> None:
    model = pinocchio.buildSampleModelManipulator()
    other = pinocchio.Model(model)
    name = model.names[3]
    placement = other.jointPlacements[3]
    by = {f"origin:{name}.{axis}": value for axis, value in zip("xz", (0.05, -0.02), strict=True)}
    placement.translation = placement.translation + np.array([0.05, 0.0, -0.02])
    other.jointPlacements[3] = placement
    gravity = (0.0, 0.0, -9.81)
    first, second = (cd.from_pinocchio(item) for item in (model, other))
    drives = list(cd.Scene(first, drive=list(first.joints), gravity=gravity).drives)
    rows = 0.1 * np.arange(len(drives)) + PHI[:, None]
    found = cd.Scene(first, drive=drives, gravity=gravity, held=by).sweep(rows)
    expected = cd.Scene(second, drive=drives, gravity=gravity).sweep(rows)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=0.0, atol=1e-11)


def test_numbers_of_mjcf_have_them() -> None:
    pytest.importorskip("mujoco", reason="MJCF is read by MuJoCo")
    text = """<mujoco><worldbody><body name="a" pos="0 0 0.1">
      <joint name="one" axis="0 1 0"/><inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      <body name="b" pos="{} 0 0" euler="0 0 20"><joint name="two" axis="0 1 0" pos="0.02 0 0"/>
      <inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></body></worldbody>
      </mujoco>"""
    given: dict[str, Any] = {"drive": ["one", "two"], "gravity": (0.0, 0.0, -9.81)}
    rows = PHI[:, None] * [1.0, -0.6]
    scene = cd.Scene(cd.load(text.format(0.3)), **given, held={"origin:two.x": 0.07})
    expected = cd.Scene(cd.load(text.format(0.37)), **given).sweep(rows).drive_effort
    np.testing.assert_allclose(scene.sweep(rows).drive_effort, expected, rtol=0.0, atol=1e-12)


def test_the_proof_reads_lengths_from_the_text_and_changes_from_what_is_held() -> None:
    bar, name = cd.load("four_bar"), "origin:crank_pin.x"
    wrong = cd.load(bar.to_urdf().replace('xyz="0.08 0.0 0.0"', 'xyz="0.081 0.0 0.0"'))
    assert wrong.description != bar.description
    first, second = (
        cd.Scene(item, drive="crank_bearing", held={name: 0.01}) for item in (bar, wrong)
    )
    assert first.sweep(PHI, speed=9.0).balance_residual < 1e-13
    # As if the solution had read another length.
    second.mechanism.__dict__["second_reading"] = first.mechanism.second_reading
    with pytest.raises(cd.CardanError):
        second.sweep(PHI, speed=9.0)


def test_joints_keep_their_order() -> None:
    plain = cd.load(GEARS)
    held = cd.Scene(plain, drive="swing", free="motor", held={"origin:motor.y": 0.1}).mechanism
    names = [name for name in held.model.names if not name.startswith("origin:")]
    assert names == list(plain.model.names)


@pytest.mark.slow
@pytest.mark.parametrize("rotor", [None, 0.01])
def test_clearance_opens_pins_beside_them(rotor: float | None) -> None:
    """With a rotor, no text states what is simulated."""
    held = {"origin:rocker_pin.successor.x": 0.02, "origin:rocker_bearing.yaw": 0.1}
    bar = cd.load("four_bar")
    longer = edited(bar.to_urdf(), held)
    given = {"joints": ["crank_pin"], "clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.3}
    found, expected = (
        cd.clearance.simulate(
            cd.Scene(item, drive="crank_bearing", **extra), 20.0, turns=0.002, rotor=rotor, **given
        )
        for item, extra in ((bar, {"held": held}), (longer, {}))
    )
    # Across the plane, forces are not unique.
    force, wanted = (
        np.hypot(*item.trajectory["rocker_bearing"].force[[0, -1], :2].T)
        for item in (found, expected)
    )
    np.testing.assert_allclose(force, wanted, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("origin:elbw.x", "'origin:elbw.x': joints are "),
        ("origin:elbow.length", "name a component: "),
        ("origin:elbow", "joints are "),
        ("origin:upright.pitch", "at a pitch of 90°, roll and yaw turn about the same axis"),
    ],
)
def test_what_says_none_is_refused(name: str, message: str) -> None:
    upright = ARM.replace("plate", "upright").replace("1.1 0.2 -2.4", f"1.1 {np.pi / 2.0} -2.4")
    with pytest.raises(cd.CardanError, match=message):
        cd.Scene(cd.load(upright), drive=["shoulder", "elbow"], held={name: 0.0})


def test_false_uses_are_refused() -> None:
    name = "origin:crank_pin.x"
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    with pytest.raises(cd.ArgumentError, match="fixed in this scene; hold it there as well"):
        scene.sweep(PHI, held={name: 0.01})
    with pytest.raises(cd.ArgumentError, match="fixed in this scene; hold it there as well"):
        scene.replace(loads={name: 1.0})
    with pytest.raises(cd.ModelError, match="is adjustable, and rigid unless a scene holds"):
        scene.sweep(PHI)[name] if name in scene.mechanism else scene.mechanism.joint(name)
    with pytest.raises(cd.AssemblyError):
        scene.replace(held={name: 0.0}).sweep(PHI, held={name: 1.0})
    # A hinge that is no longer parallel to the others opens its loop.
    with pytest.raises(cd.CardanError):
        scene.replace(held={"origin:crank_pin.roll": 0.1})


def upright_bar(angle: float, other: float = np.pi / 2.0) -> str:
    """Return a four-bar whose axes are turned by a right angle, as exporters write it."""
    return f"""<robot name="upright"><link name="base"/>
<link name="crank"><inertial><origin xyz="0.05 0.02 0"/><mass value="0.4"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3"/></inertial></link>
<link name="coupler"><inertial><origin xyz="0.1 0 0.02"/><mass value="1.3"/>
<inertia ixx="0.01" iyy="0.02" izz="0.02"/></inertial></link>
<link name="rocker"><inertial><origin xyz="0 -0.1 0"/><mass value="0.9"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial></link>
<joint name="A" type="continuous"><parent link="base"/><child link="crank"/>
<origin rpy="{angle} 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
<origin xyz="0 0.1 0" rpy="{2.0 * angle} 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="D" type="continuous"><parent link="base"/><child link="rocker"/>
<origin xyz="0.3 0 0" rpy="{-other} 0 0"/><axis xyz="0 0 1"/></joint>
<loop name="C" type="continuous">
<predecessor link="coupler"><origin xyz="0.3 -0.15 0"/></predecessor>
<successor link="rocker"><origin xyz="0 -0.25 0"/></successor><axis xyz="0 0 1"/></loop></robot>"""


@pytest.mark.parametrize("other", [1.5708, np.pi / 2.0])
def test_lengths_of_a_plane_that_was_rounded_can_vary(other: float) -> None:
    """Axes that meet 300 km away close loops as well as parallel ones, but for given lengths."""
    rounded, exact = cd.load(upright_bar(1.5708, other)), cd.load(upright_bar(np.pi / 2.0))
    names = ["origin:A.z", "origin:B.y", "origin:C.predecessor.x", "origin:C.successor.y"]
    names += ["origin:D.x", "origin:D.z", "origin:B.yaw"]
    found, expected = (
        cd.Scene(item, drive="A", gravity=(0.0, 0.0, -9.81)).sweep(PHI, speed=3.0)
        for item in (rounded, exact)
    )
    size = np.abs(expected.drive_effort).max()
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, atol=1e-12 * size)
    by, wanted = found.derivative(*names), expected.derivative(*names)
    for name in names:
        effort, efforts = by[name].drive_effort, wanted[name].drive_effort
        np.testing.assert_allclose(effort, efforts, atol=1e-12 * max(size, np.abs(efforts).max()))
        held = [
            cd.Scene(item, drive="A", gravity=(0.0, 0.0, -9.81), held={name: 0.01})
            .sweep(PHI, speed=3.0)
            .drive_effort
            for item in (rounded, exact)
        ]
        np.testing.assert_allclose(*held, atol=1e-12 * size)
