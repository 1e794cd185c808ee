"""A floating base whose motion is prescribed, and balls that are driven or held entirely."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio
import pytest
from testkit.compound_joints import X, Y, Z, body, joint, loop, robot

import cardan_dyn as cd

BASE = ["base.x", "base.y", "base.z", "base.turn_x", "base.turn_y", "base.turn_z"]
ORIGIN = 'xyz="1 -0.5 0.3" rpy="0.2 0.4 -0.3"'
G = np.array([0.4, -0.3, -9.81])

# An arm of two hinges on the base.
ARM = (
    body("one", 1.1, "0.2 0.1 -0.1"),
    joint("h", "revolute", "platform one", 'xyz="0.1 0.2 0.3" rpy="0.5 0 0.1"', (Y,)),
    body("two", 0.7, "0 0.3 0.1"),
    joint("k", "revolute", "one two", 'xyz="0.4 0 0.1" rpy="0 0.3 0"', (X,)),
)
PLATFORM = body("platform", 3.0, "0.05 -0.1 0.2")


def four_bar() -> tuple[str, ...]:
    """A four-bar in the plane x y of the platform, closed at zero."""
    return (
        body("crank", 0.5, "0 0.15 0"),
        joint("a", "continuous", "platform crank", "", (Z,)),
        body("coupler", 0.8, "0.4 0.1 0.05"),
        joint("b", "continuous", "crank coupler", 'xyz="0 0.3 0"', (Z,)),
        body("rocker", 0.6, "0 0.4 0"),
        joint("d", "continuous", "platform rocker", 'xyz="1 0 0"', (Z,)),
        loop("c", "continuous", "coupler rocker", ('xyz="1 0.5 0"', 'xyz="0 0.8 0"'), (Z,)),
    )


def six_joints() -> tuple[str, ...]:
    """The base as three slides and three hinges with massless links between them."""
    chain = ["ground", "m1", "m2", "m3", "m4", "m5", "platform"]
    kinds = ["prismatic"] * 3 + ["continuous"] * 3
    elements = [body(name) for name in chain[1:-1]]
    for index, (kind, axis) in enumerate(zip(kinds, (X, Y, Z) * 2, strict=True)):
        ends = f"{chain[index]} {chain[index + 1]}"
        origin = "" if index else ORIGIN
        elements.append(joint(f"q{index + 1}", kind, ends, origin, (axis,)))
    return tuple(elements)


def on_floating_base(*elements: str) -> cd.Mechanism:
    floating = joint("base", "floating", "ground platform", ORIGIN)
    return cd.load(robot(PLATFORM, floating, *elements))


def samples(count: int, drives: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return tuple(rng.uniform(-1.2, 1.2, (3, count, drives)))  # type: ignore[return-value]


def columns(angles: np.ndarray) -> np.ndarray:
    """Return `(3, 3)` the axes of the Cardan turns in the frame of the child, as columns."""
    _, y, z = angles
    turn_z = pinocchio.rpy.rpyToMatrix(0.0, 0.0, z)
    turn_y = pinocchio.rpy.rpyToMatrix(0.0, y, 0.0)
    return np.array([turn_z.T @ turn_y.T @ [1, 0, 0], turn_z.T @ [0, 1, 0], [0, 0, 1]]).T


def column_rates(angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the time derivative of `columns`."""
    first, second, third = columns(angles).T
    return np.array(
        [
            -rates[2] * np.cross(third, first) - rates[1] * np.cross(second, first),
            -rates[2] * np.cross(third, second),
            np.zeros(3),
        ]
    ).T


def free_flyer(x: np.ndarray, v: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return position, velocity and acceleration of Pinocchio's free flyer, and its rotation."""
    angles, rates = x[3:], v[3:]
    turns = (pinocchio.exp3(angle * axis) for angle, axis in zip(angles, np.eye(3), strict=True))
    rotation = np.linalg.multi_dot(list(turns))
    spin = columns(angles) @ rates
    spin_rate = columns(angles) @ a[3:] + column_rates(angles, rates) @ rates
    linear = rotation.T @ v[:3]
    # A spatial acceleration is that of the point which passes the origin.
    linear_rate = rotation.T @ a[:3] - np.cross(spin, linear)
    quaternion = pinocchio.Quaternion(rotation).coeffs()
    return (
        np.concatenate([x[:3], quaternion]),
        np.concatenate([linear, spin]),
        np.concatenate([linear_rate, spin_rate]),
        rotation,
    )


def reference_model() -> pinocchio.Model:
    """The arm on a free flyer, from Pinocchio's own reader."""
    limit = '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
    urdf = robot(PLATFORM, *ARM).replace('<link name="ground"/>', "").replace("</joint>", limit)
    model = pinocchio.buildModelFromXML(urdf, pinocchio.JointModelFreeFlyer())
    at = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.2, 0.4, -0.3), np.array([1.0, -0.5, 0.3]))
    model.jointPlacements[1] = at
    model.gravity.linear = G
    return model


def test_a_prescribed_base_is_pinocchios_free_flyer() -> None:
    mechanism = on_floating_base(*ARM)
    scene = cd.Scene(mechanism, drive=[*BASE, "h", "k"], gravity=G)
    x, v, a = samples(9, 8)
    turn = scene.sweep(x, v, a)
    assert turn.balance_residual < 1e-13 and turn.power_residual < 1e-13
    model = reference_model()
    data = model.createData()
    for index in range(len(x)):
        q, qv, qa, rotation = free_flyer(x[index, :6], v[index, :6], a[index, :6])
        efforts = pinocchio.rnea(
            model,
            data,
            np.concatenate([q, x[index, 6:]]),
            np.concatenate([qv, v[index, 6:]]),
            np.concatenate([qa, a[index, 6:]]),
        )
        np.testing.assert_allclose(turn["base"].force[index], efforts[:3], atol=1e-12)
        np.testing.assert_allclose(turn["base"].moment[index], efforts[3:6], atol=1e-12)
        # Efforts are components along the parent's axes, and along the carried ones of the turns.
        expected = [
            *(rotation @ efforts[:3]),
            *(columns(x[index, 3:6]).T @ efforts[3:6]),
            *efforts[6:],
        ]
        np.testing.assert_allclose(turn.drive_effort[index], expected, atol=1e-12)
        np.testing.assert_allclose(turn.motion.position("base")[index], x[index, :6], atol=0.0)


def test_the_moving_base_of_a_closed_four_bar() -> None:
    """Against the same base written with six joints, and against a base that is not solved."""
    found = cd.Scene(
        on_floating_base(*four_bar()), drive=["a", *BASE], gravity=G, loads={"base.turn_y": 4.0}
    )
    single = cd.load(robot(PLATFORM, *six_joints(), *four_bar()))
    drives = ["a", *(f"q{index}" for index in range(1, 7))]
    reference = cd.Scene(single, drive=drives, gravity=G, loads={"q5": 4.0})
    x, v, a = samples(12, 7)
    first, second = found.sweep(x, v, a), reference.sweep(x, v, a)
    np.testing.assert_allclose(first.drive_effort, second.drive_effort, atol=1e-11)
    for name, other in (("base", "q6"), *zip("abcd", "abcd", strict=True)):
        np.testing.assert_array_equal(first[name].unique, second[other].unique)
        np.testing.assert_allclose(first[name].force, second[other].force, atol=1e-11)
        np.testing.assert_allclose(first[name].moment, second[other].moment, atol=1e-11)
    for name, other in zip(BASE, drives[1:], strict=True):
        ratio = first.motion.ratio(name, drive=name)
        np.testing.assert_array_equal(ratio, np.ones(len(x)))
        velocity = second.motion.velocity(other)
        np.testing.assert_array_equal(first.motion.velocity(name), velocity)


def test_a_base_may_be_held_in_part_and_the_response_follows_one_coordinate() -> None:
    held = {"base.x": 0.2, "base.y": -0.1, "base.z": 0.3, "base.turn_y": 0.4, "base.turn_z": -0.7}
    scene = cd.Scene(
        on_floating_base(*ARM), drive="base.turn_x", held={**held, "h": 0.3, "k": -0.4}, gravity=G
    )
    turns = np.linspace(0.0, 2.0 * np.pi, 9)
    sweep = scene.sweep(turns, speed=2.0, acceleration=1.0)
    assert set(sweep.holding_effort) == set(scene.held)
    response = scene.response()
    again = response.sweep(turns, speed=2.0, acceleration=1.0)
    np.testing.assert_allclose(again.drive_effort, sweep.drive_effort, atol=1e-11)
    for name, effort in sweep.holding_effort.items():
        np.testing.assert_allclose(again.holding_effort[name], effort, atol=1e-11)
    # At rest, the held slides carry the weight.
    rotation = pinocchio.rpy.rpyToMatrix(0.2, 0.4, -0.3)
    still = scene.sweep([0.0])
    forces = [still.holding_effort[f"base.{axis}"][0] for axis in "xyz"]
    np.testing.assert_allclose(rotation @ forces, -4.8 * G, atol=1e-12)


BALL = joint("ball", "spherical", "ground platform", ORIGIN)


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.3, -0.5, 0.9), (0.2, np.pi / 2, 0.1)])
def test_a_held_ball_is_rigid(angles: tuple[float, float, float]) -> None:
    """Also at zero, and with the middle angle at 90°: no angle of it is free."""
    ball = cd.load(robot(PLATFORM, BALL, *four_bar()))
    held = dict(zip(("ball.x", "ball.y", "ball.z"), angles, strict=True))
    scene = cd.Scene(ball, drive="a", held=held, gravity=G)
    turns = np.linspace(0.0, 6.0, 11)
    found = scene.sweep(turns, speed=3.0)
    rotation = pinocchio.rpy.rpyToMatrix(0.2, 0.4, -0.3)
    for angle, axis in zip(angles, np.eye(3), strict=True):
        rotation = rotation @ pinocchio.exp3(angle * axis)
    rpy = " ".join(map(repr, pinocchio.rpy.matrixToRpy(rotation).tolist()))
    fixed = joint("ball", "fixed", "ground platform", f'xyz="1 -0.5 0.3" rpy="{rpy}"')
    welded = cd.Scene(cd.load(robot(PLATFORM, fixed, *four_bar())), drive="a", gravity=G)
    expected = welded.sweep(turns, speed=3.0)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, atol=1e-11)
    for name in "abcd":
        np.testing.assert_allclose(found[name].force, expected[name].force, atol=1e-11)
        np.testing.assert_allclose(found[name].moment, expected[name].moment, atol=1e-11)
    efforts = [found.holding_effort[name] for name in held]
    axes = columns(np.array(angles))
    np.testing.assert_allclose(efforts, (found["ball"].moment @ axes).T, atol=1e-11)


def test_balls_inside_of_loops_can_be_held() -> None:
    """A coupler that a held ball divides is a coupler of one piece."""
    divided = four_bar()
    split = (
        body("coupler", 0.8, "0.4 0.1 0.05"),
        joint("b", "continuous", "crank coupler", 'xyz="0 0.3 0"', (Z,)),
        body("end"),
        joint("ball", "spherical", "coupler end", 'xyz="0.5 0.2 0.1" rpy="0 0 0.3"'),
    )
    inverse = pinocchio.SE3(
        pinocchio.rpy.rpyToMatrix(0.0, 0.0, 0.3), np.array([0.5, 0.2, 0.1])
    ).inverse() * pinocchio.SE3(np.eye(3), np.array([1.0, 0.5, 0.0]))
    xyz = " ".join(map(repr, inverse.translation.tolist()))
    rpy = " ".join(map(repr, pinocchio.rpy.matrixToRpy(inverse.rotation).tolist()))
    closing = loop(
        "c", "continuous", "end rocker", (f'xyz="{xyz}" rpy="{rpy}"', 'xyz="0 0.8 0"'), (Z,)
    )
    fixed = joint("base", "fixed", "ground platform")
    parts = (PLATFORM, fixed, *divided[:2], *split, *divided[4:6], closing)
    held = {"ball.x": 0.0, "ball.y": 0.0, "ball.z": 0.0}
    scene = cd.Scene(cd.load(robot(*parts)), drive="a", held=held, gravity=G)
    whole = cd.Scene(cd.load(robot(PLATFORM, fixed, *divided)), drive="a", gravity=G)
    turns = np.linspace(0.0, 6.0, 9)
    found, expected = scene.sweep(turns, speed=2.0), whole.sweep(turns, speed=2.0)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, atol=1e-11)
    for name in "abd":
        unique = found[name].unique
        np.testing.assert_array_equal(unique, expected[name].unique)
        force, moment = found[name].force[:, unique[:3]], found[name].moment[:, unique[3:]]
        np.testing.assert_allclose(force, expected[name].force[:, unique[:3]], atol=1e-11)
        np.testing.assert_allclose(moment, expected[name].moment[:, unique[3:]], atol=1e-11)
    # Held askew, it is another coupler, which closes as well.
    other = scene.replace(held={"ball.z": 0.1}).sweep(turns)
    assert np.max(np.abs(other.drive_effort - scene.sweep(turns).drive_effort)) > 1e-3


def test_copies_and_pickles_solve_the_same() -> None:
    scene = cd.Scene(on_floating_base(*four_bar()), drive=["a", *BASE], gravity=G)
    x, v, a = samples(3, 7)
    sweep = scene.sweep(x, v, a)
    for made in (copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))):
        again = made(scene)
        assert again.mechanism.base.model.nq == scene.mechanism.base.model.nq
        np.testing.assert_allclose(again.sweep(x, v, a).drive_effort, sweep.drive_effort)
        other = made(sweep)
        np.testing.assert_array_equal(other.motion.position("base.turn_y"), x[:, 5])
        np.testing.assert_array_equal(other["base"].moment, sweep["base"].moment)
    mechanism = pickle.loads(pickle.dumps(scene.mechanism))
    assert mechanism.variant(["base"]) is mechanism
    assert mechanism.base is mechanism.variant([])
    assert mechanism.base.variant(["base", "a"]) is mechanism


def test_balls_of_mjcf() -> None:
    text = (
        "<mujoco><worldbody><body name='a'><joint name='ball' type='ball'/>"
        "<geom type='sphere' size='0.1' mass='2' pos='0.3 0 0'/></body></worldbody></mujoco>"
    )
    scene = cd.Scene(
        cd.load(text), drive="ball.y", held={"ball.x": 0.0, "ball.z": 0.0}, gravity=(0, 0, -10)
    )
    sweep = scene.sweep([0.0, 0.5])
    np.testing.assert_allclose(sweep.drive_effort, -6.0 * np.cos([0.0, 0.5]), rtol=1e-12)
