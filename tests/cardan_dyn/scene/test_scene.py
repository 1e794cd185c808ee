"""Scenes: shapes of sweeps, positions closed once, replaced arguments, ranges, assembly modes."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from testkit.drive_lines import two_lines
from testkit.linkages import POSITIONS, RATES, four_bar, loop, slider_crank
from testkit.scenes import double, universal

import cardan_dyn as cd

HELD = {"joint_angle": 0.5}
GRAVITY = (0.0, 0.0, -9.81)
FEW = np.linspace(0.0, 6.0, 15)


def bundled_four_bar(**options: object) -> cd.Scene:
    given = {"drive": "crank_bearing", "gravity": GRAVITY, "loads": {"rocker_bearing": -5.0}}
    return cd.Scene(cd.load("four_bar"), **{**given, **options})


def assert_equal(sweep: cd.Sweep, expected: cd.Sweep) -> None:
    """Compare all results to rounding times the condition number."""
    assert tuple(sweep) == tuple(expected)
    # Some operations with the same rounding each.
    allowed = 100.0 * np.finfo(float).eps * float(np.max(expected.condition))
    for quantity in ("force", "moment"):
        values = {name: getattr(expected[name], quantity) for name in expected}
        size = max(float(np.max(np.abs(value))) for value in values.values())
        for name, value in values.items():
            difference = np.max(np.abs(getattr(sweep[name], quantity) - value))
            assert difference <= allowed * size
            np.testing.assert_array_equal(sweep[name].unique, expected[name].unique)
    effort = expected.drive_effort
    np.testing.assert_allclose(
        sweep.drive_effort, effort, rtol=0.0, atol=allowed * np.max(np.abs(effort)) + 1e-300
    )
    assert sweep.holding_effort.keys() == expected.holding_effort.keys()
    np.testing.assert_allclose(sweep.motion.v, expected.motion.v, atol=allowed * 100.0)
    np.testing.assert_array_equal(sweep.gravity, expected.gravity)
    assert sweep.held == expected.held


FULL: dict[str, Any] = {
    "drive": "bearing_in",
    "held": HELD,
    "loads": {"bearing_out": -2.0, "shaft_out": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]},
    "gravity": GRAVITY,
}
CHANGES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "a load": (
        {"loads": {"bearing_out": -9.0}},
        {"loads": {**FULL["loads"], "bearing_out": -9.0}},
    ),
    "a load per sample": (
        {"loads": {"bearing_out": FEW}},
        {"loads": {**FULL["loads"], "bearing_out": FEW}},
    ),
    "a load more": (
        {"loads": {"pin_in": 1.5}},
        {"loads": {**FULL["loads"], "pin_in": 1.5}},
    ),
    "a load less": ({"loads": {"shaft_out": None}}, {"loads": {"bearing_out": -2.0}}),
    "no loads": ({"loads": None}, {"loads": None}),
    "gravity": ({"gravity": (0.0, 3.0, 0.0)}, {"gravity": (0.0, 3.0, 0.0)}),
    "no gravity": ({"gravity": None}, {"gravity": None}),
    "compliance": (
        {"compliance": {"bearing_in": [1e-8] * 6}},
        {"compliance": {"bearing_in": [1e-8] * 6}},
    ),
    "held": ({"held": {"joint_angle": 0.9}}, {"held": {"joint_angle": 0.9}}),
    "outputs": ({"outputs": ["bearing_in", "pin_in"]}, {"outputs": ["bearing_in", "pin_in"]}),
    "near": ({"near": {"bearing_in": 0.4}}, {"near": {"bearing_in": 0.4}}),
    "driven and held exchanged": (
        {"drive": "joint_angle", "held": {"joint_angle": None, "bearing_in": 0.3}},
        {"drive": "joint_angle", "held": {"bearing_in": 0.3}},
    ),
}
KEEPING = {"a load", "a load per sample", "a load more", "a load less", "no loads"}
KEEPING |= {"gravity", "no gravity", "compliance"}
"""Changes that the motion does not depend on."""


@pytest.mark.parametrize("name", CHANGES)
def test_a_scene_with_changes_equals_a_fresh_one(joint: cd.Mechanism, name: str) -> None:
    changes, options = CHANGES[name]
    scene = cd.Scene(joint, **FULL)
    scene.sweep(FEW)
    positions = 0.1 * FEW if options.get("drive") else FEW
    fresh = cd.Scene(joint, **{**FULL, **options}).sweep(positions, speed=2.0)
    assert_equal(scene.replace(**changes).sweep(positions, speed=2.0), fresh)
    # The scene itself stays as it was.
    assert scene.held == HELD
    assert_equal(scene.sweep(FEW), cd.Scene(joint, **FULL).sweep(FEW))


@pytest.mark.parametrize("name", CHANGES)
def test_what_was_learned_about_the_motion_is_kept_if_it_does_not_change(
    joint: cd.Mechanism, name: str
) -> None:
    scene = cd.Scene(joint, **FULL)
    changed = scene.replace(**CHANGES[name][0])
    assert (changed.solver.assembly is scene.solver.assembly) == (name in KEEPING)


def test_strictness_and_the_mechanism_can_be_replaced(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, **FULL)
    strict = scene.replace(strict=True)
    assert strict.solver.assembly is scene.solver.assembly
    with pytest.raises(cd.IndeterminateError):
        strict.sweep([0.0])
    ring = scene.replace(mechanism=cd.load("thoma_rig"), loads=None)
    assert ring.mechanism.name != joint.name
    assert ring.outputs == tuple(ring.mechanism.joint_names)


def test_another_assembly_mode() -> None:
    scene = bundled_four_bar()
    crossed = scene.replace(branch="B")
    assert crossed.branch == "B"
    assert_equal(crossed.sweep(FEW), bundled_four_bar(branch="B").sweep(FEW))


def test_bad_changes_are_refused(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, **FULL)
    with pytest.raises(TypeError, match="Scene has no argument load"):
        scene.replace(load=3.0)
    with pytest.raises(cd.ArgumentError, match="held is "):
        scene.replace(held=0.5)
    with pytest.raises(cd.ModelError, match="no joint 'lever'"):
        scene.replace(held={"lever": 0.5})
    with pytest.raises(cd.MobilityError):
        scene.replace(held={"joint_angle": None})
    with pytest.raises(cd.ArgumentError, match="driven, free or held, and named once"):
        scene.replace(drive="joint_angle", held={"joint_angle": 0.1})


def test_texts_of_scenes(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, **FULL)
    assert repr(scene) == (
        "<Scene of 'universal_joint': drives bearing_in; held joint_angle 0.5; "
        "loads on bearing_out, shaft_out; gravity [0.0, 0.0, -9.81]>"
    )
    assert repr(scene.replace(loads=None, gravity=None)) == (
        "<Scene of 'universal_joint': drives bearing_in; held joint_angle 0.5>"
    )


def test_copies_are_scenes_of_the_same_arguments(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, **FULL)
    for again in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert type(again) is cd.Scene
        assert repr(again) == repr(scene)
        assert_equal(again.sweep(FEW, speed=1.0), scene.sweep(FEW, speed=1.0))


def test_plans_take_what_the_scene_needs() -> None:
    scene = cd.Scene(cd.load(two_lines(2)), drive="bearing_0", gravity=GRAVITY)
    assert "weight: the scene has no gravity" not in scene.plan().skipped
    assert "weight: the scene has no gravity" in scene.replace(gravity=None).plan().skipped
    assert len(scene.replace(outputs=["left_1"]).plan().skipped) > len(scene.plan().skipped)


def test_responses_come_back_from_a_file_for_a_scene_like_it(
    joint: cd.Mechanism, tmp_path: Path
) -> None:
    scene = cd.Scene(joint, **FULL)
    response = scene.response()
    response.save(tmp_path / "joint.npz")
    # Loads at joints may have other values; they are those of the scene that reads.
    changed = scene.replace(loads={"bearing_out": -9.0})
    again = changed.load_response(tmp_path / "joint.npz").sweep(FEW, speed=2.0)
    for name, wrench in changed.sweep(FEW, speed=2.0).items():
        size = np.max(np.abs(wrench.moment)) + np.max(np.abs(wrench.force))
        np.testing.assert_allclose(again[name].moment, wrench.moment, atol=1e-10 * size)
    with pytest.raises(cd.CardanError):
        scene.replace(held={"joint_angle": 0.9}).load_response(tmp_path / "joint.npz")
    with pytest.raises(cd.CardanError):
        scene.load_response(tmp_path / "missing.npz")


def test_branches_tell_angles_within_half_a_turn(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.5, near={"bearing_in": 7.0})
    modes = scene.branches()
    # The fork of the output shaft fits the cross in two ways, in one and the same pose.
    assert list(modes) == ["A"]
    assert list(modes.variants["A"]) == ["A", "A2"]
    for positions in modes.variants["A"].values():
        # The drive's own position is where the scene starts.
        assert positions["bearing_in"] == 7.0
        passive = [positions[name] for name in ("pin_in", "pin_out", "bearing_out")]
        assert np.all(np.abs(passive) <= np.pi)
    # tan φ₂ = tan φ₁ / cos β; the other mode is half a turn away.
    expected = np.arctan2(np.sin(7.0), np.cos(0.5) * np.cos(7.0))
    assert modes["A"]["bearing_out"] == pytest.approx(expected, abs=1e-12)
    assert modes.variants["A"]["A2"]["bearing_out"] == pytest.approx(expected - np.pi, abs=1e-12)


def test_shapes_of_a_sweep(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held=HELD, loads={"bearing_out": [-1.0, -2.0]})
    for position, speed, shapes in (
        ([0.0, 1.0, 2.0], 0.0, r"position \(3,\), loads\['bearing_out'\] \(2,\)"),
        ([0.0, 1.0], [1.0, 2.0, 3.0], r"position \(2,\), speed \(3,\), loads.* \(2,\)"),
        (np.zeros((2, 3)), 0.0, r"position \(2, 3\), loads\['bearing_out'\] \(2,\)"),
    ):
        message = f"^shapes do not broadcast: {shapes}; for a grid, give each argument an axis"
        with pytest.raises(cd.ArgumentError, match=message):
            scene.sweep(position, speed=speed)
    with pytest.raises(cd.ArgumentError, match="position is empty"):
        scene.sweep([])
    assert scene.sweep(np.zeros((3, 2))).shape == (3, 2)
    both = cd.Scene(joint, drive=["bearing_in", "joint_angle"])
    with pytest.raises(
        cd.ArgumentError, match=r"position has shape \(2, 3\), expected .*\(..., 2\)"
    ):
        both.sweep(np.zeros((2, 3)))
    scene = cd.Scene(joint, drive="bearing_in", held=HELD, loads={"bearing_out": [[1.0]]})
    assert scene.sweep([0.0, 1.0]).shape == (1, 2)
    wrench = cd.Wrench(force=np.zeros((3, 3)))
    scene = cd.Scene(joint, drive="bearing_in", held=HELD, loads={"shaft_out": wrench})
    with pytest.raises(
        cd.ArgumentError, match=r"position \(2,\), loads\['shaft_out'\]\.force \(3,\);"
    ):
        scene.sweep([0.0, 1.0])
    turn = universal(joint, 0.5).sweep(0.25)
    assert len(turn) == 1
    assert turn.drive_effort.shape == turn["bearing_out"].torsion.shape == (1,)
    assert turn["bearing_out"].force.shape == turn["bearing_out"].moment.shape == (1, 3)
    assert turn["bearing_out"].unique.shape == (6,)
    assert turn.motion.q.shape == (1, joint.model.nq)
    with pytest.raises(cd.ArgumentError, match="frames: joint, parent, world"):
        turn.wrench("bearing_out", "link")


def test_positions_closed_once_serve_several_sweeps(
    shaft: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = double(shaft, 0.5, 0.4)
    positions = np.linspace(-9.0, 9.0, 700)
    closed = scene.assemble(positions)
    assert len(closed) == 700
    assert repr(closed) == "<700 assembled positions of 'double_shaft_z'>"
    for rates in ({}, {"speed": 20.0}, {"speed": np.linspace(0.0, 9.0, 700), "acceleration": 3.0}):
        direct, again = scene.sweep(positions, **rates), scene.sweep(closed, **rates)
        # At speed balanced bodies leave the rounding of inertial terms, which condition counts.
        allowed = 10.0 * np.finfo(float).eps * float(np.max(direct.condition))
        greatest = max(np.max(np.abs(direct[name].moment)) for name in shaft.joint_names)
        for name in shaft.joint_names:
            difference = np.max(np.abs(again[name].moment - direct[name].moment))
            assert difference < allowed * greatest
        turned = [sweep.motion.position("bearing_out") for sweep in (again, direct)]
        np.testing.assert_allclose(*turned, rtol=0.0, atol=1e-14)
        assert again.balance_residual < 10.0 * direct.balance_residual
    with pytest.raises(cd.ArgumentError, match=r"position \(700,\), speed \(3,\)"):
        scene.sweep(closed, speed=np.zeros(3))
    with pytest.raises(cd.ArgumentError, match="assembled by another scene"):
        double(shaft, 0.5, 0.4).sweep(closed)
    # Nothing that depends on the position alone is done again.
    monkeypatch.setattr(pin, "forwardKinematics", None)
    scene.sweep(closed, speed=5.0)


def test_range_of_a_rocker_ends_at_its_dead_points() -> None:
    mechanism = cd.load(four_bar(loop("continuous")))
    assert cd.Scene(mechanism, drive="a").motion_range() == (-np.inf, np.inf)
    low, high = cd.Scene(mechanism, drive="d").motion_range()
    limits = []
    for reach in (np.sqrt(8.0) + 0.5, np.sqrt(8.0) - 0.5):
        cosine = (2.0**2 + 2.5**2 - reach**2) / (2.0 * 2.0 * 2.5)
        limits.append(0.5 * np.pi - np.arccos(cosine))
    assert low == pytest.approx(limits[0], abs=1e-9)
    assert high == pytest.approx(limits[1], abs=1e-9)
    # Up to a micrometre of the limits everything is exact; past them nothing is returned.
    scene = cd.Scene(mechanism, drive="d", loads={"a": -1.0})
    near = scene.sweep([low + 1e-6, high - 1e-6])
    assert near.loop_residual < 1e-13
    assert near.power_residual < 1e-10
    with pytest.raises(cd.AssemblyError, match="the nearest position that can be reached is") as e:
        scene.sweep([0.0, high + 1e-3])
    assert e.value.nearest == pytest.approx(high, abs=1e-9)
    with pytest.raises(cd.MobilityError, match="the range of one joint depends"):
        joint = cd.load("universal_joint")
        cd.Scene(joint, drive=["bearing_in", "joint_angle"]).motion_range()


def test_range_of_a_slide() -> None:
    scene = cd.Scene(cd.load(slider_crank(None)), drive="d")
    reach = np.sqrt(1.0 - 0.09)
    low, high = scene.motion_range()
    assert low == pytest.approx(0.7 - reach, abs=1e-9)
    assert high == pytest.approx(1.3 - reach, abs=1e-9)


def test_a_four_bar_has_two_assembly_modes() -> None:
    mechanism = cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(mechanism, drive="a")
    modes = scene.branches()
    assert list(modes) == ["A", "B"]
    assert scene.branch == "A"
    assert modes["A"]["b"] == pytest.approx(0.0, abs=1e-13)
    crossed = cd.Scene(mechanism, drive="a", branch="B")
    assert crossed.branch == "B"
    turn = crossed.sweep(POSITIONS, **RATES)
    assert turn.balance_residual < 1e-13
    # The rocker of the crossed four-bar mirrors the other one about the line tip - pivot.
    open_turn = scene.sweep(POSITIONS, **RATES)
    tip = 0.5 * np.stack([-np.sin(POSITIONS), np.cos(POSITIONS)])
    line = np.arctan2(-tip[1], 2.0 - tip[0])
    ends = [np.pi / 2.0 + sweep.motion.position("d") for sweep in (open_turn, turn)]
    mirrored = [np.stack([2.0 + 2.5 * np.cos(end), 2.5 * np.sin(end)]) - tip for end in ends]
    angles = [np.arctan2(end[1], end[0]) - line for end in mirrored]
    np.testing.assert_allclose(np.sin(angles[0] + angles[1]), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cos(angles[0] + angles[1]), 1.0, atol=1e-12)
    with pytest.raises(cd.ArgumentError, match="branch 'C' does not exist; branches: A, B"):
        cd.Scene(mechanism, drive="a", branch="C")


def test_branches_keep_their_names_whichever_a_scene_is_in() -> None:
    named = [bundled_four_bar(branch=branch).branches() for branch in "AB"]
    for in_a, in_b in zip(named[0].items(), named[1].items(), strict=True):
        assert in_a[0] == in_b[0]
        assert in_a[1] == pytest.approx(in_b[1], abs=1e-9)
        assert all(abs(angle) <= np.pi + 1e-9 for angle in in_a[1].values())
    angles_at_zero = {
        branch: bundled_four_bar(branch=branch).sweep([0.0]).motion.position("rocker_bearing")[0]
        for branch in "AB"
    }
    for branch, angle in angles_at_zero.items():
        assert np.cos(angle - named[0][branch]["rocker_bearing"]) == pytest.approx(1.0)
