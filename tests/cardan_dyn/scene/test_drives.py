"""Drives: which coordinates drive a mechanism, over which range, and which to take first."""

from __future__ import annotations

import math

import numpy as np
import pytest
from testkit.ball_rods import WAYS
from testkit.planar_linkages import (
    described,
    five_bar,
    four_bar,
    geared,
    joint,
    link,
    loop,
    rocker_range,
)

import cardan_dyn as cd
from cardan_dyn.scene.drives import Drives
from cardan_dyn.scene.usual_motion import usual_motion

pytestmark = pytest.mark.usefixtures("loaded_once")


def drives(mechanism: cd.Mechanism) -> Drives:
    return cd.describe(mechanism).drives


def parallelogram_in_line() -> cd.Mechanism:
    """Cranks A and D of length 1, base and coupler of length 2, all on the x axis at zero."""
    return described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (1.0, 0.0)),
        joint("D", "ground", "c", (2.0, 0.0)),
        loop("b", "c", (2.0, 0.0), (1.0, 0.0)),
    )


def limited(mechanism: cd.Mechanism, name: str, low: float, high: float) -> cd.Mechanism:
    words = f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/></joint>'
    before, start, after = mechanism.to_urdf().partition(f'<joint name="{name}"')
    after = after.replace('type="continuous"', 'type="revolute"', 1)
    return cd.load(before + start + after.replace("</joint>", words, 1))


def boom() -> cd.Mechanism:
    """A boom of 2 m on a cylinder from below, whose foot can turn through, with a stick on it."""
    cylinder = (
        '<joint name="P" type="prismatic"><parent link="barrel"/><child link="rod"/>'
        '<origin xyz="1 0 0"/><axis xyz="1 0 0"/>'
        '<limit lower="-0.2" upper="0.3" effort="1" velocity="1"/></joint>'
    )
    plain = described(
        *(link(name) for name in ("boom", "barrel", "rod", "stick")),
        joint("A", "ground", "boom"),
        joint("F", "ground", "barrel", (-0.2, -0.6)),
        cylinder,
        joint("S", "boom", "stick", (2.0, 0.0)),
        loop("rod", "boom", (0.6, 0.3), (1.4, -0.3)),
    )
    return limited(limited(plain, "A", -0.5, 0.9), "S", -2.0, 0.5)


@pytest.mark.slow
def test_what_turns_through_beyond_the_limits_of_others_is_no_crank_but_its_cylinder_drives() -> (
    None
):
    found = drives(boom())
    assert found["F"].turns and found["A"].range == (-0.5, 0.9)
    assert found.default == ("P",) and set(found.held) == {"S"}
    # Which of them came first in the search is another one.
    for name in ("A", "F", "P"):
        assert found[name].instead_of == ("P",), name


def test_a_turn_that_keeps_within_the_limits_of_others_is_one() -> None:
    low, high = rocker_range()
    bar = limited(four_bar(), "D", low - 0.1, high + 0.1)
    assert drives(bar).default == ("A",) and drives(bar)["A"].turns


def test_the_crank_of_a_four_bar_turns_and_its_rocker_swings() -> None:
    found = drives(four_bar())
    assert found.mobility == 1 and found.default == ("A",) and not found.held
    assert found["A"].turns and found["A"].is_grounded and found["A"].ends == "turns through"
    assert found["D"].reach == pytest.approx(rocker_range(), abs=1e-6)
    assert found["D"].determines and not found["D"].turns and found["D"].ends == "loops"
    assert found["D"].instead_of == ("A",) == found["A"].instead_of
    assert found.needed == ("A",)


def test_a_joint_at_the_ground_that_turns_is_preferred_to_those_before_it() -> None:
    """The rocker is described first, and the coupler's pin turns as well."""
    found = drives(
        described(
            *(link(name) for name in "abc"),
            joint("rocker", "ground", "c", (1.0, 0.0)),
            joint("pin", "a", "b", (0.0, 0.3)),
            joint("crank", "ground", "a"),
            loop("b", "c", (1.0, 0.4), (0.0, 0.7)),
        )
    )
    assert found["pin"].turns and not found["rocker"].turns
    assert found.default == ("crank",)
    assert found.reason == "driven at a joint at the ground that turns through: crank"


@pytest.mark.slow
def test_limits_of_the_description_end_a_range() -> None:
    low, high = rocker_range()
    inside = 0.5 * (low + high)
    found = drives(limited(four_bar(), "D", inside, 3.0))["D"]
    assert found.range == pytest.approx((inside, high), abs=1e-6)
    assert found.ends == "limit and loops; starts beyond its limits"
    # Exporters write ±3.14 for a joint that turns.
    assert drives(limited(four_bar(), "A", -3.14, 3.14))["A"].turns
    # Limits that no position of the loops meets are not regarded.
    found = drives(limited(four_bar(), "D", 2.0, 3.0))["D"]
    assert found.range == found.reach == pytest.approx((low, high), abs=1e-6)


def test_what_the_author_drives_comes_first() -> None:
    text = four_bar().to_urdf().replace('<joint name="D"', '<joint name="D" independent="true"', 1)
    found = drives(cd.load(text))
    assert found.default == ("D",) and found.reason == "driven where the description says: D"


def test_several_drives_each_with_the_others_at_rest() -> None:
    found = drives(five_bar())
    assert found.mobility == 2
    assert set(found.default) | set(found.held) == set(found.needed)
    # Crank A with D at rest is a four-bar of crank 0.4, coupler and rocker of the other two rods.
    scene = cd.Scene(five_bar(), drive="A", held={"D": 0.0})
    assert found["A"].reach == pytest.approx(scene.motion_range())
    assert set(found["B"].instead_of) == set(found.needed)


@pytest.mark.slow
@pytest.mark.parametrize("way", sorted(WAYS))
def test_idle_rods_need_no_drive(way: str) -> None:
    found = drives(cd.load(WAYS[way]()))
    assert found.mobility == 1 and len(found.default) == 1
    assert found.default[0] in ("a", "d")
    assert len(usual_motion(cd.load(WAYS[way]()), samples=9).sweep()) == 9


def test_a_follower_of_a_coupling_is_not_taken() -> None:
    found = drives(geared(2.0))
    assert found.mobility == 1 and found.default == ("A",)
    assert found["B"].determines and found["B"].instead_of == ("A",)


def test_a_singular_zero_is_left_by_a_small_step() -> None:
    mechanism = parallelogram_in_line()
    with pytest.raises(cd.SingularConfigurationError):
        cd.Scene(mechanism, drive="A")
    found = drives(mechanism)
    assert found.is_moved and found.default
    assert found.start.loop_residual < 1e-10
    # The bars are in line again half a turn on: nothing but that ends the range.
    assert found.default[0] in ("A", "D")
    scene = cd.Scene(mechanism, **found.arguments)  # type: ignore[arg-type]
    low, high = found[found.default[0]].range or (0.0, 0.0)
    assert high - low == pytest.approx(math.pi, abs=1e-3)
    assert len(scene.sweep(np.linspace(low + 0.1, high - 0.1, 5))) == 5
    assert "°" in usual_motion(mechanism, samples=5).said


def test_dead_points_are_no_start_for_a_drive() -> None:
    found = drives(cd.load("slider_crank"))
    assert not found["piston_guide"].determines
    assert str(found["piston_guide"]) == "starts in a dead point"
    assert found["piston_guide"].range is None and not found["piston_guide"].turns


def test_presets_hold_what_they_hold() -> None:
    found = drives(cd.load("universal_joint"))
    assert found.default == ("bearing_in",) and found.needed == ("bearing_in", "joint_angle")
    assert found.held == {"joint_angle": pytest.approx(np.deg2rad(35.0))}
    # The cross cannot tilt against the input fork by more than the joint's angle.
    assert found["pin_in"].reach == pytest.approx(np.deg2rad((-35.0, 35.0)), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", cd.bundled_names())
def test_arguments_make_scenes(name: str) -> None:
    mechanism = cd.load(name)
    found = drives(mechanism)
    scene = cd.Scene(mechanism, **found.arguments)  # type: ignore[arg-type]
    assert scene.drives == found.default and dict(scene.held) == pytest.approx(dict(found.held))


def test_all_joints_of_a_tree_are_drives_but_not_its_base() -> None:
    arm = described(
        link("a"), link("b"),
        joint("base", "ground", "a").replace("continuous", "floating"), joint("B", "a", "b"),
    )  # fmt: skip
    found = drives(arm)
    assert found.mobility == 7 and found.default == ("B",)
    assert len(found.held) == 6 and not any(found.held.values())
    assert len(usual_motion(arm, samples=5).sweep()) == 5


def test_a_locked_mechanism_has_no_drive() -> None:
    """A triangle of bars."""
    found = drives(
        described(
            *(link(name) for name in "ac"),
            joint("A", "ground", "a"),
            joint("D", "ground", "c", (1.0, 0.0)),
            loop("a", "c", (0.5, 1.0), (-0.5, 1.0)),
        )
    )
    assert found.mobility == 0 and not found.default and found.reason == "nothing can move"
    assert not any(item.determines for item in found.values())


@pytest.mark.slow
def test_described_configurations_are_where_ranges_begin() -> None:
    mechanism = four_bar()
    other = cd.Scene(mechanism, drive="A", branch="B").configuration()
    found = cd.describe(other).drives
    assert found["D"].start == pytest.approx(other.positions["D"])
    assert found["D"].reach != pytest.approx(rocker_range(), abs=1e-3)


def test_texts_and_wrong_names() -> None:
    found = drives(cd.load("four_bar"))
    lines = str(found).splitlines()
    assert lines[0] == (
        "Drives of 'four_bar': mobility 1, driven as its preset says: crank_bearing"
    )
    assert lines[1] == "  crank_bearing   turns through; default"
    assert lines[-1] == "  rocker_pin      starts in a dead point"
    assert "-0.05631 to 0.5954 rad (loops); instead" in lines[3]
    with pytest.raises(cd.ArgumentError, match="crank_bearing"):
        found["crank"]
