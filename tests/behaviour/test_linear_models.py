"""Linear models: against closed forms, differences of the equation of motion, and vibration."""

from __future__ import annotations

import pickle
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import StateSpace
from testkit.coordinates import BARS, agree, all_driven, motion_of, scene_of, sloped

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

pytestmark = pytest.mark.usefixtures("loaded_once")

G, LENGTH, MASS, CART = 9.81, 0.7, 2.0, 5.0
CARRIED = f"""<mujoco><compiler angle="radian"/><worldbody><body name="cart">
<joint name="way" type="slide" axis="1 0 0"/>
<inertial pos="0 0 0" mass="{CART}" diaginertia="1 1 1"/>
<body name="rod"><joint name="pivot" axis="0 -1 0"/>
<inertial pos="0 0 -{LENGTH}" mass="{MASS}" diaginertia="1e-9 1e-9 1e-9"/>
<site name="bob" pos="0 0 -{LENGTH}"/></body></body></worldbody></mujoco>"""
INERTIA = MASS * LENGTH**2 + 1e-9


def cart(**options: Any) -> cd.Scene:
    return cd.Scene(cd.load(CARRIED), gravity=(0, 0, -G), **options)


def test_a_pendulum_on_a_driven_cart() -> None:
    """(I θ̈ + m g l θ) = -m l ẍ, the force on the cart (M + m) ẍ + m l θ̈ with θ small."""
    damper = cd.JointSpring("pivot", 0.0, damping=0.3)
    scene = cart(drive="way", free="pivot", elements=[damper])
    rest = scene.equilibrium({"pivot": 0.1})
    found = scene.linear(
        rest,
        inputs=["load:pivot", "way", "speed:way", "acceleration:way"],
        outputs=["pivot", "pivot.velocity", "pivot.acceleration", "way.drive_effort",
                 "bob.position_x", "tip.velocity_x"],
        points={"tip": ("rod", (0.0, 0.0, -2.0 * LENGTH))},
    )  # fmt: skip
    assert found.states == ("pivot", "speed:pivot")
    stiffness, coupling = -MASS * G * LENGTH / INERTIA, -MASS * LENGTH / INERTIA
    turned = np.array([stiffness, -0.3 / INERTIA])
    agree(found.A, [[0.0, 1.0], turned], 1e-12)
    pushed = np.array([1.0 / INERTIA, 0.0, 0.0, coupling])
    agree(found.B, [np.zeros(4), pushed], 1e-12)
    force = MASS * LENGTH
    rows = [[1, 0], [0, 1], turned, force * turned, [LENGTH, 0], [0, 2 * LENGTH]]
    agree(found.C, rows, 1e-12)
    whole = [0.0, 0.0, 0.0, CART + MASS]
    rows = [np.zeros(4), np.zeros(4), pushed, force * pushed + whole, [0, 1, 0, 0], [0, 0, 1, 0]]
    agree(found.D, rows, 1e-12)


def test_frequencies_of_an_equilibrium_are_eigenvalues() -> None:
    scene = cart(free=["way", "pivot"], elements=[cd.JointSpring("way", 300.0)])
    rest = scene.equilibrium([0.01, 0.1])
    found = scene.linear(rest)
    agree(found.mass, rest.inertia, 1e-14)
    agree(found.stiffness, rest.stiffness, 1e-11)
    assert not found.damping.any()
    poles = np.linalg.eigvals(found.A)
    assert np.abs(poles.real).max() < 1e-12
    np.testing.assert_allclose(np.sort(poles.imag)[2:], rest.frequencies, rtol=1e-11)
    agree(found.B[2:], np.linalg.inv(rest.inertia), 1e-13)
    np.testing.assert_array_equal(found.C, np.eye(2, 4))
    np.testing.assert_array_equal(found.D, np.zeros((2, 2)))


def advanced(scene: cd.Scene, state: Array, efforts: Array) -> Array:
    """Return the rate of a state `(2 n,)` by the equation of motion."""
    position, speed = np.split(state, 2)
    given = (position[0], speed[0]) if len(position) == 1 else (position, speed)
    needed = efforts - scene.bias(*given)[0]
    return np.concatenate([speed, np.linalg.solve(scene.mass_matrix(given[0])[0], needed)])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "universal", "stewart"])
def test_driven_motions_by_differences(name: str) -> None:
    scene = scene_of(name)
    motion = motion_of(scene, 3)
    turn = all_driven(scene).sweep(*motion)
    found, count = scene.linear(turn), len(scene.coordinates)
    assert found.A.shape == (3, 2 * count, 2 * count) and found.B.shape == (3, 2 * count, count)
    state, efforts = np.concatenate([motion[0][1], motion[1][1]]), turn.drive_effort[1]
    efforts = np.reshape(efforts, count)
    np.testing.assert_allclose(advanced(scene, state, efforts)[count:], motion[2][1], rtol=1e-9)
    size = 1e-5 if name == "stewart" else 1e-3
    columns = [
        sloped(lambda by, e=e: advanced(scene, state + by * e, efforts), size)
        for e in np.eye(2 * count)
    ]
    agree(found[1].A, np.stack(columns, axis=-1), 1e-7 if name == "stewart" else 1e-9)
    agree(found[1].B[count:] @ scene.mass_matrix(as_row(motion[0][1]))[0], np.eye(count), 1e-12)


def as_row(values: Array) -> Any:
    return values[0] if len(values) == 1 else values


def test_along_a_simulation() -> None:
    """A free motion, of which nothing is left to be driven."""
    spring = cd.JointSpring("d", 30.0, damping=2.0)
    scene = cd.Scene(cd.load(BARS), free="a", gravity=(0, -G, 0), elements=[spring])
    course = scene.simulate(0.5, speed=2.0).at([0.1, 0.3])
    found = scene.linear(course, outputs=["a", "coupler.velocity_x"])
    assert found.A.shape == (2, 2, 2)
    for sample in range(2):
        state = np.array([course.position[sample], course.speed[sample]])
        columns = [
            sloped(lambda by, e=e, state=state: advanced(scene, state + by * e, np.zeros(1)))
            for e in np.eye(2)
        ]
        agree(found[sample].A, np.stack(columns, axis=-1), 1e-10)


def test_outputs_of_a_closed_chain_by_differences() -> None:
    spring = cd.JointSpring("d", 30.0, damping=2.0, rest=0.3, name="spring")
    still = cd.Wrench((0.0, 0.0, 0.0))
    scene = cd.Scene(
        cd.load(BARS), free="a", gravity=(0, -G, 0), elements=[spring], loads={"coupler": still}
    )
    rest = scene.equilibrium(0.3)
    columns = ["d.velocity", "d.acceleration", "c.force_x", "d.moment_z", "tip.position_x",
               "tip.velocity_y"]  # fmt: skip
    inputs = ["load:a", "load:coupler.force_y", "stiffness:spring", "gravity.y"]
    points = {"tip": ("coupler", (0.3, 0.2, 0.0))}
    found = scene.linear(rest, inputs=inputs, outputs=columns, points=points)
    assert found.outputs == tuple(columns) and found.inputs == tuple(inputs)

    def read(
        state: Array, load: float = 0.0, force: float = 0.0, more: float = 0.0, g: float = 0.0
    ):
        stiffer = cd.JointSpring("d", 30.0 + more, damping=2.0, rest=0.3)
        other = scene.replace(
            drive="a", free=None, gravity=(0, g - G, 0), elements=[stiffer],
            loads={"coupler": cd.Wrench((0.0, force, 0.0)), "a": load},
        )  # fmt: skip
        needed = other.sweep(state[0], state[1]).drive_effort[0]
        rate = -needed / other.mass_matrix(state[0])[0, 0, 0]
        turn = other.sweep(state[0], state[1], rate)
        tip = turn.point("coupler", points["tip"][1])
        return np.array(
            [
                turn.motion.velocity("d")[0],
                turn.motion.acceleration("d")[0],
                turn["c"].force[0, 0],
                turn["d"].moment[0, 2],
                tip.position[0, 0],
                tip.velocity[0, 1],
            ]
        )

    state = np.array([rest.position[0], 0.0])
    moved = [sloped(lambda by, e=e: read(state + by * e)) for e in np.eye(2)]
    pushed = [
        sloped(lambda by, name=name: read(state, **{name: by}), 0.1)
        for name in ("load", "force", "more", "g")
    ]
    for matrix, expected in ((found.C, moved), (found.D, pushed)):
        for row, by_differences in zip(matrix, np.stack(expected, axis=-1), strict=True):
            size = max(1.0, np.abs(row).max())
            np.testing.assert_allclose(row, by_differences, rtol=0, atol=1e-8 * size)


def test_points_of_lengths_that_are_driven_or_held() -> None:
    """Of names with a colon, coordinates as well as those of lengths."""
    length, points = "origin:b.x", {"tip": ("coupler", (0.3, 0.2, 0.0))}
    columns = ["tip.position_x", "tip.velocity_y"]
    driven = cd.Scene(cd.load(BARS.replace('"a"', '"own:a"')), drive=["own:a", length])

    def read(state: Array) -> list[float]:
        position, speed = np.split(state, 2)
        tip = driven.sweep(position, speed).point(*points["tip"])
        return [tip.position[..., 0].item(), tip.velocity[..., 1].item()]

    state = np.array([0.3, 0.01, 2.0, 0.1])
    turn = driven.sweep(*np.split(state, 2))
    found = driven.linear(turn, outputs=columns, points=points)[0]
    assert found.states == ("own:a", length, "speed:own:a", f"speed:{length}")
    moved = [sloped(lambda by, e=e: np.array(read(state + by * e))) for e in np.eye(4)]
    agree(found.C, np.stack(moved, axis=-1), 1e-9)

    held = driven.replace(drive=["own:a"], held={length: 0.01})
    turn = held.sweep([[0.3]], speed=[[2.0]])
    by_length = held.linear(turn, inputs=[length], outputs=columns[:1], points=points)[0]
    across = found.C[0, 1] - by_length.D[0, 0]
    assert abs(across) < 1e-12
    for name in (length, "origin:c.successor.x"):
        with pytest.raises(cd.CardanError, match=name):
            held.linear(turn, inputs=[name], outputs=columns, points=points)


def test_patterns_as_inputs() -> None:
    scene = scene_of("four_bar")
    turn = scene.sweep([0.3, 0.5], speed=2.0)
    found = scene.linear(turn, inputs=["mass:*", "gravity.y", "*a"])
    links = [f"mass:{name}" for name in scene.mechanism.links]
    assert found.inputs == (*links, "gravity.y", "load:a")
    agree(found.B, scene.linear(turn, inputs=found.inputs).B, 1e-15)


def test_couplings_and_held_joints_as_outputs() -> None:
    scene = cd.Scene(
        cd.load("universal_joint"),
        free="bearing_in",
        held={"joint_angle": 0.4},
        elements=[cd.JointSpring("bearing_out", 50.0, rest=0.3)],
    )
    rest = scene.equilibrium(0.2)
    found = scene.linear(rest, inputs=["load:bearing_out", "joint_angle"],
                         outputs=["joint_angle.holding_effort", "bearing_out"])  # fmt: skip
    by = rest.sweep.derivative("bearing_in", "acceleration:bearing_in", "load:bearing_out")
    parts = {name: item.holding_effort["joint_angle"][0] for name, item in by.items()}
    gained = parts["acceleration:bearing_in"]
    expected = [parts["bearing_in"] + gained * found.A[1, 0], gained * found.A[1, 1]]
    agree(found.C[0], expected, 1e-12)
    assert found.D[0, 0] == pytest.approx(parts["load:bearing_out"] + gained * found.B[1, 0])
    ratio = rest.sweep.motion.ratio("bearing_out")[0]
    np.testing.assert_allclose(found.C[1], [ratio, 0.0], rtol=1e-13, atol=1e-15)


def test_as_vibration_linearises_a_rotating_blade() -> None:
    """A flapping blade on a hub: stiffness and mass about the motion, which rests in the hub."""
    text = """<mujoco><compiler angle="radian"/><worldbody><body name="hub">
<joint name="spin" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<body name="blade" pos=".3 0 0"><joint name="flap" axis="0 -1 0"/><joint name="lag" axis="0 0 1"/>
<inertial pos=".8 0 0" mass="2" diaginertia=".01 .2 .2"/></body></body></worldbody></mujoco>"""

    def bladed(rest: float) -> cd.Scene:
        flap = cd.JointSpring("flap", 40.0, damping=0.5, rest=rest)
        elements = [flap, cd.JointSpring("lag", 90.0, rest=-rest)]
        return cd.Scene(cd.load(text), drive="spin", free=["flap", "lag"], elements=elements)

    omega, arm, inertia = 7.0, 2.0 * 0.8, 0.2 + 2.0 * 0.8**2
    scene = bladed(0.1)
    known = cd.vibration.linearise(scene, omega)
    assert np.ptp(known.motion, axis=0).max() < 1e-9 < np.abs(known.motion).min()
    turn = all_driven(scene).sweep([known.position[0], *known.motion[0]], speed=[omega, 0, 0])
    found = scene.linear(turn)[0]
    assert found.states == ("flap", "lag", "speed:flap", "speed:lag")
    agree(found.mass, known.mass[0], 1e-9)
    agree(found.stiffness, known.stiffness[0], 1e-9)
    agree(found.damping, known.damping[0], 1e-9)
    # Straight out: centrifugal stiffness, of flapping with the blade's own turning as well.
    scene = bladed(0.0)
    found = scene.linear(all_driven(scene).sweep([0.4, 0.0, 0.0], speed=[omega, 0, 0]))[0]
    flap = 40.0 + omega**2 * (0.3 * arm + 2.0 * 0.8**2 + 0.2 - 0.01)
    lag = 90.0 + omega**2 * 0.3 * arm
    agree(found.stiffness, np.diag([flap, lag]), 1e-12)
    agree(found.mass, np.diag([inertia, inertia]), 1e-12)


def test_samples_copies_and_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of("four_bar")
    turn = scene.sweep(np.linspace(0.0, 1.0, 6).reshape(2, 3), speed=2.0)
    found = scene.linear(turn, outputs=["a", "d.velocity"])
    assert found.A.shape == (2, 3, 2, 2) and found.D.shape == (2, 3, 2, 1)
    assert "2 × 3 samples" in repr(found) and "d.velocity" in repr(found)
    alone = found[1, 2]
    again = pickle.loads(pickle.dumps(alone))
    np.testing.assert_array_equal(again.A, found.A[1, 2])
    with pytest.raises(ValueError, match="read-only"):
        again.A[:] = 0.0
    with pytest.raises(cd.ArgumentError, match="no samples"):
        alone[0]
    with pytest.raises(cd.ArgumentError, match=r"model\[k\]"):
        found.to_scipy()
    state_space = alone.to_scipy()
    assert isinstance(state_space, StateSpace)
    np.testing.assert_array_equal(state_space.C, alone.C)
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(cd.MissingExtraError, match="pip install control"):
        alone.to_control()
    told: dict[str, Any] = {}
    control = SimpleNamespace(ss=lambda *given, **names: told.update(names) or given)
    monkeypatch.setitem(sys.modules, "control", control)
    given = alone.to_control()
    np.testing.assert_array_equal(given[1], alone.B)
    assert told == {
        "states": ["a", "speed_a"], "inputs": ["load_a"], "outputs": ["a", "d_velocity"],
    }  # fmt: skip
    empty = scene.linear(turn, inputs=[], outputs=[])
    assert empty.B.shape == (2, 3, 2, 0) and empty.C.shape == (2, 3, 0, 2)


def test_many_threads_and_models_of_pinocchio() -> None:
    scene = scene_of("four_bar")
    mechanism = cd.from_pinocchio(scene.mechanism.model, scene.mechanism.constraint_models)
    again = cd.Scene(mechanism, drive="a", gravity=scene.gravity)
    turns = (item.sweep(0.4, speed=3.0) for item in (scene, again))
    first, second = (item.linear(turn) for item, turn in zip((scene, again), turns, strict=True))
    agree(first.A, second.A, 1e-9)


def test_refusals() -> None:
    scene = scene_of("universal")
    turn = scene.sweep([0.3, 0.4], speed=1.0)
    held = cd.Scene(scene.mechanism, drive="bearing_in", held={"joint_angle": 0.3})
    for given, kind, words in (
        ({"at": 0.3}, cd.ArgumentError, "expected an equilibrium"),
        ({"at": scene_of("four_bar").sweep(0.1)}, cd.ArgumentError, "of this scene"),
        ({"at": held.sweep(0.1)}, cd.ArgumentError, "of this scene"),
        ({"inputs": ["nothing"]}, cd.ModelError, "nothing that the scene"),
        ({"inputs": ["load:nothing"]}, cd.ModelError, "name a joint"),
        ({"inputs": ["bearing_in"]}, cd.ArgumentError, "is found, and no input"),
        ({"inputs": ["acceleration:joint_angle"]}, cd.ArgumentError, "is found, and no input"),
        ({"outputs": ["nothing"]}, cd.ArgumentError, "says no output"),
        ({"outputs": ["nothing.velocity"]}, cd.ModelError, "coordinates are"),
        ({"outputs": ["nothing.force_x"]}, cd.ModelError, "no joint"),
        ({"outputs": ["nothing.position_x"]}, cd.ModelError, "no link"),
        ({"outputs": ["bearing_in.drive_effort"]}, cd.ArgumentError, "move as given"),
        ({"outputs": ["bearing_in.holding_effort"]}, cd.ModelError, "there are none"),
        ({"outputs": ["bearing_out.force_x"]}, cd.IndeterminateError, "moves?|laws of motion"),
        ({"points": 3}, cd.ArgumentError, "points"),
        (
            {"outputs": ["tip.position_x"], "points": {"tip": ("cross",)}},
            cd.ArgumentError,
            r"expected a link or \(link",
        ),
        (
            {"outputs": ["tip.position_x"], "points": {"tip": ("cross", (0, np.nan, 0))}},
            cd.ArgumentError,
            "points",
        ),
        (
            {"outputs": ["cross.position_x"], "inputs": ["origin:pin_in.x"]},
            cd.CardanError,
            "origin:pin_in.x",
        ),
    ):
        with pytest.raises(kind, match=words):
            scene.linear(**{"at": turn, **given})
    part = cd.Scene(cd.load(BARS), drive="a", outputs=["a"])
    with pytest.raises(cd.ModelError, match="asked for"):
        part.linear(part.sweep(0.3), outputs=["d.force_x"])
    light = cd.load(
        '<robot name="light"><link name="base"/><link name="arm"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="tip"/>'
        '<joint name="a" type="continuous"><parent link="base"/><child link="arm"/></joint>'
        '<joint name="b" type="continuous"><parent link="arm"/><child link="tip"/></joint></robot>'
    )
    both = cd.Scene(light, drive=["a", "b"])
    with pytest.raises(cd.ModelError, match="nothing that has mass moves with 'b'"):
        both.linear(both.sweep([0.0, 0.0]))
