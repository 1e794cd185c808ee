"""Lazy tongs: two descriptions of the same arms, virtual work, and reach in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import tongs

import cardan_dyn as cd

GRAVITY = 9.81
POSITIONS = np.linspace(0.0, 0.8, 9)


@pytest.fixture(scope="module", params=[4, 12])
def count(request: pytest.FixtureRequest) -> int:
    return int(request.param)


def swept(mechanism: cd.Mechanism, speed: float = 0.0, **more: object) -> cd.Sweep:
    scene = cd.Scene(mechanism, drive="slide", gravity=(0.0, -GRAVITY, 0.0), **more)
    return scene.sweep(POSITIONS, speed)


@pytest.mark.slow
def test_arms_turn_as_far_as_each_other_and_reach_in_proportion(count: int) -> None:
    turn = swept(tongs.two_chains(count))
    slopes = tongs.slopes(POSITIONS)
    for k in range(count):
        turned = (slopes - tongs.SLOPE) * (1.0 if k == 0 else 2.0 * (-1.0) ** k)
        for name, sign in (("ja", 1.0), ("jb", -1.0)):
            position = turn.motion.position(f"{name}{k}")
            np.testing.assert_allclose(position, sign * turned, rtol=0.0, atol=1e-15 * count)
    # Of an even number of pairs, the last arm a begins on the other side.
    lower = turn.point(f"a{count - 1}").position
    np.testing.assert_allclose(lower[:, 0], tongs.ARM * np.cos(slopes), rtol=1e-12)
    np.testing.assert_allclose(lower[:, 1], (count - 1) * tongs.ARM * np.sin(slopes), rtol=1e-13)


@pytest.mark.slow
def test_rounding_of_a_pair_does_not_turn_the_next_ones() -> None:
    """Along both chains, rounding in the lowest pair would have the lever of all above it."""
    turn = swept(tongs.two_chains(40))
    turned = 2.0 * (tongs.slopes(POSITIONS) - tongs.SLOPE)
    for k in range(1, 40):
        position = turn.motion.position(f"ja{k}")
        np.testing.assert_allclose(position, turned * (-1.0) ** k, rtol=0.0, atol=2e-14)


@pytest.mark.slow
def test_the_slide_holds_the_weight_by_virtual_work(count: int) -> None:
    """Pairs of 6 kg rise by (k + 1/2) 2 m sin(slope) while the slide moves by 2 m cos(slope)."""
    turn = swept(tongs.two_chains(count))
    expected = 3.0 * GRAVITY * count**2 / np.tan(tongs.slopes(POSITIONS))
    np.testing.assert_allclose(turn.drive_effort, expected, rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drive", "per_slope"), [("ja0", 1.0), ("ja11", -2.0), ("ja4", 2.0), ("p5", 2.0), ("p8", -2.0)]
)
def test_any_joint_holds_the_weight_by_virtual_work(drive: str, per_slope: float) -> None:
    """Arms on the way turn by this many times the slope; joints of others are as far from it."""
    scene = cd.Scene(tongs.two_chains(12), drive=drive, gravity=(0.0, -GRAVITY, 0.0))
    turned = np.linspace(0.0, 0.5, 7)
    turn = scene.sweep(per_slope * turned)
    rise = 3.0 * GRAVITY * 12**2 * tongs.ARM * np.cos(tongs.SLOPE + turned)
    np.testing.assert_allclose(turn.drive_effort, rise / per_slope, rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("pair", [0, 3, 7])
def test_a_cylinder_holds_the_weight_by_virtual_work(pair: int) -> None:
    """From one arm to the other one of the next pair: two loops that need each other."""
    scene = cd.Scene(
        tongs.two_chains(9, cylinder=pair), drive="cylinder", gravity=(0.0, -GRAVITY, 0.0)
    )
    slopes = np.linspace(tongs.SLOPE, 1.0, 7)
    lengths = tongs.cylinder_length(slopes)
    turn = scene.sweep(lengths - lengths[0])
    # Its length grows by ARM² sin(2 slope) / length per radian.
    rise = 3.0 * GRAVITY * 9**2 * tongs.ARM * np.cos(slopes)
    expected = rise * lengths / (tongs.ARM**2 * np.sin(2.0 * slopes))
    np.testing.assert_allclose(turn.drive_effort, expected, rtol=1e-12)
    reach = turn.point("a8").position[:, 1]
    np.testing.assert_allclose(reach, 8.0 * tongs.ARM * np.sin(slopes), rtol=1e-12)


@pytest.mark.slow
def test_every_wrench_is_that_of_the_other_description(count: int) -> None:
    """Arms of the same names in other trees: the wrenches that their joints share."""
    chains, pairs = tongs.two_chains(count), tongs.pair_by_pair(count)
    first, second = swept(chains, 0.4), swept(pairs, 0.4)
    scale = np.max(np.abs(first.drive_effort))
    np.testing.assert_allclose(first.drive_effort, second.drive_effort, rtol=1e-12)
    for k in range(count):
        for name in (f"ja{k}", f"jb{k}", f"p{k}"):
            ours, theirs = first.wrench(name, "world"), second.wrench(name, "world")
            np.testing.assert_allclose(ours.force, theirs.force, rtol=0.0, atol=1e-12 * scale)
            np.testing.assert_allclose(ours.moment, theirs.moment, rtol=0.0, atol=1e-12 * scale)
            np.testing.assert_array_equal(first[name].unique, second[name].unique)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["ja7", "jb5", "p8", "slide"])
def test_outputs_alone_are_those_among_all(output: str) -> None:
    every, alone = (
        swept(tongs.two_chains(10), 0.4, outputs=outputs) for outputs in (None, [output])
    )
    whole, own = (
        np.concatenate([turn[output].force, turn[output].moment], axis=1) for turn in (every, alone)
    )
    unique = every[output].unique
    assert np.array_equal(unique, alone[output].unique) and np.any(unique)
    scale = np.max(np.abs(every.drive_effort))
    np.testing.assert_allclose(own[:, unique], whole[:, unique], rtol=0.0, atol=1e-13 * scale)


@pytest.mark.slow
def test_tongs_in_space_hold_their_balance_and_power() -> None:
    """Skew hinges, pins that are universal joints, balls: free bodies and power prove it."""
    mechanism = tongs.two_chains(7, pin="universal", hinge="0.2 -0.1 1")
    scene = cd.Scene(mechanism, drive="slide", gravity=(0.0, -GRAVITY, 1.0))
    turn = scene.sweep(np.linspace(0.0, 0.2, 7), 0.3)
    assert turn.loop_residual < 1e-13
    assert turn.balance_residual < 1e-12
    assert turn.power_residual < 1e-12
