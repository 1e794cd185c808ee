"""The same question has the same answer, whatever was asked before.

Of a single drive, guesses follow from the mechanism alone, so that results have the same bits. Of
several drives, earlier sweeps leave guesses, from any of which Newton's method ends at the same
closed position: results agree to its rounding, which the condition of the equations magnifies.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from testkit.ball_rods import WAYS
from testkit.planar_linkages import five_bar

import cardan_dyn as cd
from cardan_dyn.core import compiled
from cardan_dyn.scene.usual_motion import usual_motion

LOAD = 100.0
ROUNDINGS = 16.0
"""How many roundings of an angle of one radian coordinates may differ by."""


def joint() -> cd.Scene:
    held = {"joint_angle": np.deg2rad(50.0)}
    return cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held=held, loads={"bearing_out": -LOAD}
    )


def shaft() -> cd.Scene:
    held = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
    return cd.Scene(
        cd.load("double_shaft_z"), drive="bearing_in", held=held, loads={"bearing_out": -LOAD}
    )


def crank() -> cd.Scene:
    return cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -LOAD})


def needle() -> cd.Scene:
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft", loads={"needle_guide": -LOAD})


def platform() -> cd.Scene:
    legs = [f"leg_{k}" for k in range(1, 7)]
    return cd.Scene(cd.load("stewart_platform"), drive=legs, gravity=(0.0, 0.0, -9.81))


def assert_same(first: cd.Sweep, second: cd.Sweep) -> None:
    rounding = ROUNDINGS * np.finfo(float).eps
    np.testing.assert_allclose(first.motion.q, second.motion.q, rtol=rounding, atol=rounding)
    allowed = rounding * float(np.max(first.condition))
    for part in ("moment", "force"):
        size = max(float(np.max(np.abs(getattr(first[name], part)))) for name in first.outputs)
        for name in first.outputs:
            difference = getattr(first[name], part) - getattr(second[name], part)
            assert np.max(np.abs(difference)) <= allowed * size


def assert_same_bits(found: np.ndarray, expected: np.ndarray) -> None:
    """NumPy adds up products of a single sample in another order than those of several."""
    allowed = 0.0 if compiled.kernel else 1e-14 * float(np.max(np.abs(expected)))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=allowed)


@pytest.mark.parametrize("scene", [joint, shaft, crank, needle])
@pytest.mark.parametrize(
    "before",
    [
        np.linspace(-0.3, 1.1, 7),
        np.linspace(0.0, 2.0 * np.pi, 1000),
        np.linspace(-7.0, 7.0, 20_000),
    ],
    ids=["a part", "a turn", "many turns"],
)
def test_a_sweep_is_the_same_after_other_sweeps(
    scene: Callable[[], cd.Scene], before: np.ndarray
) -> None:
    positions = np.linspace(0.0, 2.0 * np.pi, 181)
    used = scene()
    used.sweep(before)
    expected, found = scene().sweep(positions), used.sweep(positions)
    assert_same_bits(found.motion.x, expected.motion.x)
    np.testing.assert_array_equal(found.motion.turns, expected.motion.turns)
    for name in expected.outputs:
        assert_same_bits(found[name].moment, expected[name].moment)


@pytest.mark.parametrize("scene", [joint, shaft, crank, needle])
def test_positions_have_the_same_bits_whatever_is_asked_beside_them(
    scene: Callable[[], cd.Scene],
) -> None:
    positions = np.random.default_rng(4).uniform(-9.0, 9.0, 40)
    whole, used = scene().sweep(positions), scene()
    for position, x, turns in zip(positions, whole.motion.x, whole.motion.turns, strict=True):
        one = used.sweep(position)
        assert_same_bits(one.motion.x[0], x)
        np.testing.assert_array_equal(one.motion.turns[0], turns)


def test_designs_are_the_same_after_and_among_others() -> None:
    random = np.random.default_rng(5)
    positions, angles = random.uniform(-9.0, 9.0, 3000), random.uniform(0.05, 0.8, 3000)
    used = joint()
    used.sweep(positions, held={"joint_angle": angles})
    some = positions[:40], {"joint_angle": angles[:40]}
    assert_same(joint().sweep(some[0], held=some[1]), used.sweep(some[0], held=some[1]))


@pytest.mark.slow
def test_poses_are_the_same_after_and_among_others() -> None:
    lengths = np.random.default_rng(6).uniform(-0.1, 0.1, (300, 6))
    used = platform()
    whole = used.sweep(lengths)
    again = used.sweep(lengths[:20])
    assert_same(platform().sweep(lengths[:20]), again)
    np.testing.assert_allclose(whole.motion.q[:20], again.motion.q, rtol=0.0, atol=1e-14)


@pytest.mark.slow
def test_positions_asked_one_by_one_are_the_same_as_asked_at_once() -> None:
    """Each is reached from the last one where that is near."""
    time = np.linspace(0.0, 3.0, 60)[:, None]
    lengths = 0.08 * np.sin(time + np.arange(6.0))
    used, whole = platform(), platform().sweep(lengths)
    for index, position in enumerate(lengths):
        one = used.sweep(position)
        np.testing.assert_allclose(one.motion.q, whole.motion.q[[index]], rtol=0.0, atol=1e-14)
        if not index % 20:
            assert_same(platform().sweep(position), one)


def turning_about_a_wrist() -> cd.Scene:
    """A tool on two drives and on a wrist, two of whose axes coincide at 0.5 and 0.5 rad."""
    cosine, sine = np.cos(0.5), np.sin(0.5)
    first = np.array([0.3, 0.5, 0.8]) / np.sqrt(0.98)
    turned = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
    tilted = [[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]]
    last = (np.array(turned) @ tilted).T @ first
    middle = np.cross(first, last) / np.linalg.norm(np.cross(first, last))

    def hinge(tag: str, name: str, ends: str, axis: object) -> str:
        words = " ".join(map(repr, np.asarray(axis, dtype=float).tolist()))
        return f'<{tag} name="{name}" type="continuous">{ends}<axis xyz="{words}"/></{tag}>'

    def joint(name: str, parent: str, child: str, axis: object) -> str:
        return hinge("joint", name, f'<parent link="{parent}"/><child link="{child}"/>', axis)

    return cd.Scene(
        cd.load(
            '<robot name="wrist"><link name="base"/><link name="arm"/><link name="tool"/>'
            '<link name="outer"/><link name="inner"/>'
            + joint("pan", "base", "arm", [0, 0, 1])
            + joint("tilt", "arm", "tool", [1, 0, 0])
            + joint("first", "base", "outer", first)
            + joint("middle", "outer", "inner", middle)
            + hinge("loop", "last", '<predecessor link="inner"/><successor link="tool"/>', last)
            + "</robot>"
        ),
        drive=["pan", "tilt"],
    )


def test_ways_past_both_sides_of_a_singular_position_are_not_taken_for_each_other() -> None:
    """There the first axis turns to different sides, so that a whole turn is between both ends."""
    used = turning_about_a_wrist()
    for offset in (4e-3, 1e-3, 2e-4):
        one, other = (np.array([1.0 + side, 1.0 - side]) for side in (offset, -offset))
        used.sweep(one)
        angles = [
            scene.sweep(other).motion.position("first") for scene in (used, turning_about_a_wrist())
        ]
        np.testing.assert_allclose(angles[0], angles[1], rtol=0.0, atol=1e-12)
        apart = turning_about_a_wrist().sweep(one).motion.position("first") - angles[1]
        assert np.abs(apart) > 6.0


MADE: dict[str, Callable[[], cd.Scene]] = {
    **{
        name: (lambda name=name: usual_motion(cd.load(name), samples=5).scene)
        for name in sorted(cd.bundled_names())
    },
    "five_bar": lambda: cd.Scene(five_bar(), drive=["A", "D"]),
    **{way: (lambda way=way: cd.Scene(cd.load(WAYS[way]()), drive="a")) for way in WAYS},
}
"""Mechanisms of one drive and of several, with balls, gears and idle rods."""
FAST = ("universal_joint", "five_bar")


def assert_equal_to_rounding(first: cd.Sweep, second: cd.Sweep) -> None:
    """Coordinates and wrenches agree to 1e-15 times the condition of their equations.

    How idle rods are turned about their lines is compared in `test_idle_rods.py`.
    """
    allowed = 1e-15 * first.condition
    spinning = {name for rod in first.idle_rods for name in rod}
    for name in set(first.mechanism.coordinates.columns) - spinning:
        one, other = (turn.motion.position(name).reshape(len(turn), -1) for turn in (first, second))
        assert np.all(np.abs(one - other).max(axis=1) <= allowed * (1.0 + np.abs(one).max(axis=1)))
    length = first.mechanism.characteristic_length
    force, moment = (
        max(float(np.max(np.abs(getattr(first[name], part)))) for name in first.outputs)
        for part in ("force", "moment")
    )
    size = max(force, moment / length)
    for name in first.outputs:
        for part, scale in (("force", size), ("moment", size * length)):
            difference = np.abs(getattr(first[name], part) - getattr(second[name], part))
            assert np.all(difference.max(axis=1) <= allowed * scale), (name, part)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name,
            marks=[pytest.mark.slow] * (name not in FAST),
        )
        for name in MADE
    ],
)
def test_before_and_after_another_sweep(name: str) -> None:
    fresh = MADE[name]()
    drives = len(fresh.drives)
    reach = 0.02 if drives > 1 else 1.0
    asked = reach * np.random.default_rng(1).uniform(-1.0, 1.0, (40, drives))
    expected = fresh.sweep(asked, speed=0.7, acceleration=0.3)
    assert_equal_to_rounding(expected, fresh.sweep(asked, speed=0.7, acceleration=0.3))
    way = reach * np.linspace(-0.9, 0.9, 200)[:, None] * np.linspace(1.0, 0.4, drives)
    for before in (way, way[:9], 0.5 * asked[::-1], asked[7:8]):
        used = MADE[name]()
        used.sweep(before)
        assert_equal_to_rounding(expected, used.sweep(asked, speed=0.7, acceleration=0.3))


def test_coordinates_do_not_count_the_turns_of_other_sweeps() -> None:
    """Angles that are not driven lie within half a turn of zero, however far was followed."""
    for before in ([4.0], [-1.0], np.linspace(-6.0, 6.0, 73)):
        used = joint()
        used.sweep(before)
        turn, fresh = used.sweep([-4.63207205]), joint().sweep([-4.63207205])
        np.testing.assert_allclose(turn.motion.x, fresh.motion.x, rtol=0.0, atol=1e-14)
        np.testing.assert_array_equal(turn.motion.turns, fresh.motion.turns)
        passive = np.delete(
            turn.motion.x[0], [turn.mechanism.coordinates.columns["bearing_in"].start]
        )
        assert np.all(np.abs(passive) <= np.pi)
        np.testing.assert_allclose(
            turn.motion.x + 2.0 * np.pi * turn.motion.turns, turn.motion.rows, rtol=0.0, atol=1e-14
        )


def test_two_scenes_that_were_asked_the_same_have_the_same_bits() -> None:
    positions = np.linspace(0.0, 2.0 * np.pi, 181)
    first, second = crank().sweep(positions), crank().sweep(positions)
    np.testing.assert_array_equal(first.motion.q, second.motion.q)
    for name in first.outputs:
        np.testing.assert_array_equal(first[name].moment, second[name].moment)


def elsewhere(name: str) -> list[cd.Scene]:
    """Return scenes of a mechanism that hold its joints, or start its drives, at other places."""
    scene = usual_motion(cd.load(name), samples=5).scene
    mechanism, held = scene.mechanism, scene.held
    if not held:
        first = scene.drives[0]
        return [scene, scene.replace(near={first: 0.05})]
    return [
        cd.Scene(mechanism, drive=scene.drives, held={key: at * share for key, at in held.items()})
        for share in (1.0, 0.5, 1.3, -1.0)
    ]


@pytest.mark.parametrize(
    "name",
    [
        "double_shaft_z",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("elastic_double_shaft", "drive_line", "stewart_platform", "thoma_rig")
        ),
    ],
)
def test_a_scene_is_the_same_after_scenes_that_hold_joints_elsewhere(name: str) -> None:
    count = len(elsewhere(name)[0].drives)
    positions = 0.02 * np.linspace(-1.0, 9.0, 7)[:, None] * np.linspace(1.0, 0.4, count)
    fresh = [elsewhere(name)[k].sweep(positions, speed=3.0) for k in range(len(elsewhere(name)))]
    for order in (1, -1):
        used = [scene.sweep(positions, speed=3.0) for scene in elsewhere(name)[::order]]
        for expected, found in zip(fresh, used[::order], strict=True):
            assert_same_bits(found.motion.x, expected.motion.x)
            assert_same_bits(found.balance_residual, expected.balance_residual)
            for joint_name in expected.outputs:
                assert_same_bits(found[joint_name].moment, expected[joint_name].moment)
                assert_same_bits(found[joint_name].force, expected[joint_name].force)
