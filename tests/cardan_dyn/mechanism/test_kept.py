"""What scenes share through their mechanism: the latest values, which make no difference."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Mapping

import numpy as np
import pytest
from testkit import tongs

import cardan_dyn as cd
from cardan_dyn.core.kinematics import loop_system
from cardan_dyn.core.kinematics.following.lines import Lines
from cardan_dyn.core.kinematics.loops.groups import partition
from cardan_dyn.core.mechanism.kept import MOST, Kept
from cardan_dyn.kit.arrays import Array

LEGS = [f"leg_{index}" for index in range(1, 7)]


def test_a_value_is_made_once_and_the_latest_ones_stay() -> None:
    kept, made = Kept(), []

    def value(key: int) -> list[int]:
        def make() -> list[int]:
            made.append(key)
            return [key]

        return kept.of("kind", key, make)

    first = value(0)
    for key in range(1, MOST):
        value(key)
    assert value(0) is first
    value(MOST)
    assert made == list(range(MOST + 1))
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


def test_kinds_are_forgotten_one_by_one() -> None:
    kept, made = Kept(), []
    for kind in ("a", "b"):
        kept.of(kind, 1, lambda: 0)
    kept.forget("a", "none of this kind")
    for kind in ("a", "b"):
        kept.of(kind, 1, lambda kind=kind: made.append(kind))
    assert made == ["a"]


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


@pytest.mark.slow
def test_solvers_of_a_long_chain_stay_for_its_next_scene() -> None:
    """However many groups it has."""
    chain = tongs.two_chains(40)
    first, second = (
        cd.Scene(chain, drive="slide", gravity=(0.0, -weight, 0.0)).solver.assembly.kinematics
        for weight in (1.0, 2.0)
    )
    assert len(first.solvers) > MOST
    assert all(a is b for a, b in zip(first.solvers, second.solvers, strict=True))


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


def counted_lines(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that gets an item for every step along lines in general."""
    counted, advance = [], Lines.advance

    def counting(lines: Lines, line: Array) -> Array:
        counted.append(len(line))
        return advance(lines, line)

    monkeypatch.setattr(Lines, "advance", counting)
    return counted


def spun(mechanism: cd.Mechanism, angle: float = 0.8, **named: object) -> cd.Scene:
    return cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": angle}, **named)


@pytest.mark.parametrize(
    "positions",
    [np.linspace(0.0, 2.0 * np.pi, 25), [0.3], [-0.2, 1.4], np.linspace(-9.0, 9.0, 2000)],
    ids=["a turn", "one", "both sides", "turns"],
)
def test_a_branch_is_followed_once_for_all_scenes_that_ask_alike(
    positions: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last bit as by a mechanism that has seen nothing, and without a step along lines."""
    seen, counted = cd.load("universal_joint"), counted_lines(monkeypatch)
    spun(seen).sweep(positions, speed=2.0)
    first = len(counted)
    assert first > 0
    again = spun(seen).sweep(positions, speed=2.0)
    assert len(counted) == first
    fresh = spun(cd.load("universal_joint")).sweep(positions, speed=2.0)
    assert len(counted) == 2 * first
    np.testing.assert_array_equal(again.motion.q, fresh.motion.q)
    np.testing.assert_array_equal(again["bearing_out"].moment, fresh["bearing_out"].moment)


@pytest.mark.parametrize(
    ("name", "drive", "others"),
    [
        ("universal_joint", "bearing_in", {"held": {"joint_angle": 0.7}}),
        ("universal_joint", "bearing_in", {"near": {"bearing_in": 0.5}}),
        ("universal_joint", "bearing_out", {}),
        ("four_bar", "crank_bearing", {"branch": "B"}),
    ],
    ids=["held", "near", "drive", "mode"],
)
def test_branches_that_begin_elsewhere_are_not_shared(
    name: str, drive: str, others: Mapping[str, object]
) -> None:
    seen, positions = cd.load(name), np.linspace(0.1, 3.0, 9)
    if name == "four_bar":
        cd.Scene(seen, drive=drive).sweep(positions)
    else:
        spun(seen).sweep(positions)
        others = {"held": {"joint_angle": 0.8}, **others}
    found = cd.Scene(seen, drive=drive, **others).sweep(positions).motion.q
    expected = cd.Scene(cd.load(name), drive=drive, **others).sweep(positions).motion.q
    np.testing.assert_array_equal(found, expected)


def test_a_branch_is_shared_whatever_was_asked_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its nodes follow from the mechanism alone."""
    seen, counted = cd.load("universal_joint"), counted_lines(monkeypatch)
    scene = spun(seen)
    scene.sweep(np.linspace(0.0, 1.0, 5000))
    scene.sweep([-20.0, 20.0])
    before = len(counted)
    found = spun(seen).sweep([1.5])
    assert len(counted) == before
    fresh = spun(cd.load("universal_joint")).sweep([1.5])
    np.testing.assert_array_equal(found.motion.q, fresh.motion.q)


def test_positions_out_of_reach_are_refused_again() -> None:
    seen, errors = cd.load("four_bar"), []
    for _ in range(2):
        with pytest.raises(cd.CardanError) as caught:
            cd.Scene(seen, drive="rocker_bearing").sweep([2.0])
        errors.append(str(caught.value))
    assert errors[0] == errors[1]


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
