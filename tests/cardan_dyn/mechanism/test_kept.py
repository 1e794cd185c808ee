"""What scenes share through their mechanism: the latest values, which make no difference."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Mapping

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.kinematics import loop_system
from cardan_dyn.kinematics.loops.groups import partition
from cardan_dyn.mechanism.kept import _MOST, Kept

LEGS = [f"leg_{index}" for index in range(1, 7)]


def test_a_value_is_made_once_and_the_latest_ones_stay() -> None:
    kept, made = Kept(), []

    def value(key: int) -> list[int]:
        def make() -> list[int]:
            made.append(key)
            return [key]

        return kept.of("kind", key, make)

    first = value(0)
    for key in range(1, _MOST):
        value(key)
    assert value(0) is first
    value(_MOST)
    assert made == list(range(_MOST + 1))
    # The one that was asked for longest ago had to go; the first was asked for again.
    assert value(0) is first
    assert value(1) == [1]
    assert made[-1] == 1


def test_kinds_do_not_mix_and_errors_are_not_kept() -> None:
    kept = Kept()
    assert kept.of("a", 1, lambda: "a") == "a"
    assert kept.of("b", 1, lambda: "b") == "b"
    with pytest.raises(ZeroDivisionError):
        kept.of("c", 1, lambda: 1 / 0)
    assert kept.of("c", 1, lambda: 2.0) == 2.0


@pytest.mark.parametrize(
    ("name", "drive", "held", "near"),
    [
        ("universal_joint", "bearing_in", {"joint_angle": 0.8}, {}),
        ("universal_joint", "bearing_in", {"joint_angle": 0.8}, {"bearing_in": 0.7}),
        ("double_shaft_w", "bearing_in", {"joint_angle_1": 0.3, "joint_angle_2": -0.2}, {}),
        ("stewart_platform", LEGS, {}, {"leg_1": 0.02}),
    ],
)
def test_scenes_start_alike_whatever_the_mechanism_has_seen(
    name: str, drive: str | list[str], held: Mapping[str, float], near: Mapping[str, float]
) -> None:
    """To the last bit: what is kept is what would be computed."""
    seen = cd.load(name)
    others = [{**held, **{joint: 0.9 * value for joint, value in held.items()}}, held]
    for values in others:
        cd.Scene(seen, drive=drive, held=values, near=near)
    cd.Scene(seen, drive=drive, held=held, outputs=[])
    again = cd.Scene(seen, drive=drive, held=held, near=near).solver.assembly
    fresh = cd.Scene(cd.load(name), drive=drive, held=held, near=near).solver.assembly
    np.testing.assert_array_equal(again.start, fresh.start)
    assert [group.key for group in again.groups] == [group.key for group in fresh.groups]
    solvers = zip(again.kinematics.solvers, fresh.kinematics.solvers, strict=True)
    for ours, theirs in zip(again.kinematics.reductions, fresh.kinematics.reductions, strict=True):
        for first, second in zip(ours.rows, theirs.rows, strict=True):
            np.testing.assert_array_equal(first, second)
    assert not any(ours is theirs for ours, theirs in solvers)


def test_scenes_share_what_solves_their_loops() -> None:
    joint = cd.load("universal_joint")
    scenes = [
        cd.Scene(joint, drive="bearing_in", held={"joint_angle": angle}) for angle in (0.3, 0.4)
    ]
    first, second = (scene.solver.assembly.kinematics.solvers for scene in scenes)
    assert all(a is b for a, b in zip(first, second, strict=True))


def test_a_design_is_divided_into_groups_like_the_one_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ranks depend on where joints rest, and are found again there; groups follow from them."""
    counted = []

    def divided(*given: object, **named: object) -> object:
        counted.append(given)
        return partition(*given, **named)

    monkeypatch.setattr(loop_system, "partition", divided)
    line = cd.load("drive_line")

    def groups(angle: float) -> list[object]:
        held = {"joint_angle_1": angle, "joint_angle_2": -0.2, "joint_angle_3": 0.15}
        scene = cd.Scene(line, drive="bearing_in", held=held)
        return [group.key for group in scene.solver.assembly.groups]

    first, before = groups(0.1), len(counted)
    assert before > 1
    assert groups(0.12) == first
    assert len(counted) == before


def test_a_mechanism_goes_with_its_last_scene() -> None:
    """No circle of references keeps it, and Pinocchio's data with it, for the garbage collector."""
    gc.collect()
    gc.disable()
    try:
        joint = cd.load("universal_joint")
        scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
        scene.sweep([0.1], speed=1.0)
        known = weakref.ref(joint)
        del joint, scene
        assert known() is None
    finally:
        gc.enable()
