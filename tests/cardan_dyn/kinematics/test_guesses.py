"""Guesses near closed positions, periods, and which closure rows are redundant."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from testkit import planar_linkages
from testkit.many_drives import cranks, linkage, stacked
from testkit.planar_linkages import (
    COUPLER,
    described,
    five_bar,
    four_bar,
    geared,
    link,
    pin_distance,
    rocker_range,
    values,
)
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly import Assembly
from cardan_dyn.core.kinematics.following.branch import Branch
from cardan_dyn.core.kinematics.following.guesses import Guess, Guesses
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.problem.samples import Targets

TURN = 2.0 * np.pi


def guesses_of(mechanism: cd.Mechanism, *drives: str, **options: object) -> Guesses:
    return Assembly(checked(mechanism, drive=list(drives), **options))._guesses


def five_bar_and_four_bar() -> cd.Mechanism:
    """A five-bar linkage whose two cranks are driven, and a four-bar linkage beside it."""
    text = five_bar().to_urdf().replace("</robot>", linkage(0, "ground", "5 0 0") + "</robot>")
    return cd.load(text)


def branch_of(guesses: Guesses) -> Branch:
    """The branch of the only drive."""
    assert guesses.branch is not None
    return guesses.branch


def closed(guesses: Guesses, guess: Guess) -> np.ndarray:
    """Closed coordinates from a guess, whole turns included in the angles."""
    state = guesses.kinematics.close(guess.x, guess.turns)
    assert np.max(state.residual) < 1e-10
    return state.x + TURN * guess.turns


def test_guesses_for_one_drive_are_nearly_closed() -> None:
    mechanism = four_bar()
    guesses = guesses_of(mechanism, "A")
    positions = np.linspace(-2.0, 3.0, 50)[:, None]
    guess = guesses.at(Targets.of_positions(positions))
    np.testing.assert_array_equal(values(mechanism, guess.x, "A"), positions[:, 0])
    np.testing.assert_allclose(pin_distance(mechanism, guess.x), COUPLER, rtol=1e-2)
    x = closed(guesses, guess)
    np.testing.assert_allclose(x, guess.x, atol=1e-2)
    np.testing.assert_allclose(pin_distance(mechanism, x), COUPLER, rtol=1e-13)
    low, high = rocker_range()
    rocker = values(mechanism, x, "D")
    assert low <= np.min(rocker) < np.max(rocker) <= high


def test_guesses_are_the_same_for_few_samples_and_for_many() -> None:
    guesses, used = guesses_of(four_bar(), "A"), guesses_of(four_bar(), "A")
    positions = np.linspace(-9.0, 9.0, 6_000)[:, None]
    few = guesses.at(Targets.of_positions(positions[::300]))
    used.at(Targets.of_positions(positions[2900:]))
    many = used.at(Targets.of_positions(positions))
    np.testing.assert_array_equal(many.x[::300], few.x)
    np.testing.assert_array_equal(many.turns[::300], few.turns)
    assert np.max(used.kinematics.close(many.x).correction) < 5e-8


def test_a_motion_that_repeats_is_followed_over_one_period_only() -> None:
    mechanism = four_bar()
    guesses = guesses_of(mechanism, "A")
    positions = np.array([[0.3], [0.3 + 10.0 * TURN], [0.3 - 4000.0 * TURN]])
    guess = guesses.at(Targets.of_positions(positions))
    assert branch_of(guesses).period == pytest.approx(TURN)
    low, high = branch_of(guesses).span
    assert high - low < 1.5 * TURN
    np.testing.assert_array_equal(values(mechanism, guess.x, "A"), positions[:, 0])
    # The crank's position is exact as it is; the coupler turns backwards relative to the crank.
    assert not np.any(values(mechanism, guess.turns, "A"))
    assert not np.any(values(mechanism, guess.turns, "D"))
    relative = values(mechanism, guess.turns, "B")
    np.testing.assert_array_equal(relative - relative[0], [0.0, -10.0, 4000.0])
    x = closed(guesses, guess)
    moved = values(mechanism, x, "B") + values(mechanism, x, "A")
    np.testing.assert_allclose(moved, moved[0], atol=1e-10)


def test_known_periods_are_used_for_any_positions(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.7)
    scene.response()
    branch = branch_of(scene.solver.assembly._guesses)
    known = branch.span
    scene.sweep([6.2, -6.2])
    assert branch.span == known


def test_positions_within_a_turn_need_no_period() -> None:
    guesses = guesses_of(four_bar(), "A")
    guesses.at(Targets.of_positions(np.array([[-3.0], [3.0]])))
    assert branch_of(guesses).period is None
    guesses.at(Targets.of_positions(np.array([[-3.0], [3.3]])))
    assert branch_of(guesses).period == pytest.approx(TURN)


def test_wheels_that_do_not_repeat_are_followed_a_thousand_turns_at_most() -> None:
    mechanism = geared(0.3819660112501051)
    guesses = guesses_of(mechanism, "A")
    guess = guesses.at(Targets.of_positions(np.array([[0.0], [20.0 * TURN]])))
    assert branch_of(guesses).period is None
    np.testing.assert_allclose(
        values(mechanism, closed(guesses, guess), "B")[1],
        0.3819660112501051 * 20.0 * TURN,
        rtol=1e-12,
    )
    message = "does not repeat within a few turns of 'A', so 1001 turns cannot be followed; "
    with pytest.raises(cd.AssemblyError, match=message + "sweep over at most 1000") as caught:
        guesses.at(Targets.of_positions(np.array([[0.0], [1001.0 * TURN]])))
    assert caught.value.position == pytest.approx(1001.0 * TURN)
    assert caught.value.nearest == pytest.approx(1000.0 * TURN)
    assert caught.value.residual == 0.0


def test_a_period_that_cannot_be_turned_through_is_refused() -> None:
    with pytest.raises(cd.AssemblyError, match="cannot be closed"):
        branch_of(guesses_of(four_bar(), "D")).find_period()


def test_positions_out_of_reach_are_refused_again_and_again() -> None:
    guesses = guesses_of(four_bar(), "D")
    _, high = rocker_range()
    for _ in range(2):
        with pytest.raises(cd.AssemblyError) as caught:
            guesses.at(Targets.of_positions(np.array([[0.0], [high + 0.1]])))
        assert caught.value.nearest == pytest.approx(high, abs=1e-9)
    guess = guesses.at(Targets.of_positions(np.array([[0.0], [high - 1e-3]])))
    assert np.max(np.abs(closed(guesses, guess) - guess.x)) < 1e-2


@pytest.mark.parametrize(("along_path", "error"), [(True, 1e-12), (False, 1e-4)])
def test_several_drives_are_followed_together(along_path: bool, error: float) -> None:
    mechanism = five_bar()
    guesses = guesses_of(mechanism, "A", "D")
    angle = np.linspace(0.0, TURN, 30)
    positions = 0.3 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    guess = guesses.at(Targets.of_positions(positions), along_path)
    assert not np.any(guess.turns)
    x = closed(guesses, guess)
    for column, name in enumerate("AD"):
        np.testing.assert_array_equal(values(mechanism, x, name), positions[:, column])
    np.testing.assert_allclose(x, guess.x, atol=error)
    np.testing.assert_allclose(
        x, closed(guesses, guesses.at(Targets.of_positions(positions), not along_path)), atol=1e-12
    )


def test_drives_that_meet_in_no_group_are_followed_one_by_one() -> None:
    """Positions in any order, over any number of turns; each drive decides its own linkage."""
    mechanism = stacked(3)
    guesses = guesses_of(mechanism, *cranks(mechanism))
    alone = guesses_of(stacked(1), "crank_0")
    rng = np.random.default_rng(0)
    positions = rng.uniform(-9.0, 9.0, (40, 3))
    positions[7, 1] += 1000.0 * TURN
    guess = guesses.at(Targets.of_positions(positions))
    x = closed(guesses, guess)
    for index in range(3):
        expected = closed(alone, alone.at(Targets.of_positions(positions[:, [index]])))
        for joint in ("crank", "middle", "rocker"):
            actual = values(mechanism, x, f"{joint}_{index}")
            wanted = values(alone._problem.mechanism, expected, f"{joint}_0")
            np.testing.assert_allclose(actual, wanted, rtol=0.0, atol=1e-9)


def test_drives_that_meet_are_followed_beside_others() -> None:
    mechanism = five_bar_and_four_bar()
    guesses = guesses_of(mechanism, "A", "crank_0", "D")
    angle = np.linspace(0.0, TURN, 30)
    positions = 0.3 * np.stack([np.sin(angle), 20.0 * angle, np.cos(angle)], axis=1)
    guess = guesses.at(Targets.of_positions(positions))
    x = closed(guesses, guess)
    for column, name in enumerate(("A", "crank_0", "D")):
        np.testing.assert_array_equal(values(mechanism, x, name), positions[:, column])
    five, four = guesses_of(five_bar(), "A", "D"), guesses_of(stacked(1), "crank_0")
    for other, columns, joint in ((five, [0, 2], "B"), (four, [1], "rocker_0")):
        expected = closed(other, other.at(Targets.of_positions(positions[:, columns])))
        wanted = values(other._problem.mechanism, expected, joint)
        np.testing.assert_allclose(values(mechanism, x, joint), wanted, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_a_drive_out_of_reach_is_named_with_its_sample() -> None:
    mechanism = five_bar_and_four_bar()
    guesses = guesses_of(mechanism, "A", "rocker_0", "D")
    positions = np.zeros((5, 3))
    positions[3, 1] = 2.0
    message = r"drive 'rocker_0' cannot be brought to 2 \(sample 3\); it moves only between"
    with pytest.raises(cd.AssemblyError, match=message) as caught:
        guesses.at(Targets.of_positions(positions))
    assert caught.value.sample == 3
    # What the other drives have learned is kept.
    assert np.max(np.abs(closed(guesses, guesses.at(Targets.of_positions(0.1 * positions))))) < 10.0


def test_without_passive_joints_nothing_is_followed() -> None:
    mechanism = described(
        link("a"),
        link("b"),
        planar_linkages.joint("A", "ground", "a"),
        planar_linkages.joint("B", "a", "b"),
    )
    guesses = guesses_of(mechanism, "B", held={"A": 0.7})
    guess = guesses.at(Targets.of_positions(np.array([[1.0], [5e6]])))
    np.testing.assert_array_equal(values(mechanism, guess.x, "B"), [1.0, 5e6])
    np.testing.assert_array_equal(values(mechanism, guess.x, "A"), [0.7, 0.7])
    assert "_parts" not in vars(guesses)
    np.testing.assert_array_equal(values(mechanism, guesses._start, "B"), 0.0)


def test_blocks_of_guesses_hold_the_same_samples() -> None:
    guess = guesses_of(four_bar(), "A").at(Targets.of_positions(np.linspace(0.0, 20.0, 9)[:, None]))
    block = guess.of_samples(slice(2, 5))
    np.testing.assert_array_equal(block.x, guess.x[2:5])
    np.testing.assert_array_equal(block.turns, guess.turns[2:5])


def test_redundant_rows_follow_from_the_start_alone() -> None:
    """A parallelogram with a third rocker, whose loop adds an equation too many.

    Where all links are in line, as at the start, fewer rows are independent than elsewhere.
    """
    third = (
        link("e"),
        planar_linkages.joint("E", "ground", "e", (1.0, 0.0)),
        '<loop name="F" type="continuous"><predecessor link="b"><origin xyz="1 0 0"/>'
        '</predecessor><successor link="e"><origin xyz="0 1 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>',
    )
    fresh, used = (guesses_of(four_bar(1.0, 1.0, 2.0, *third), "A") for _ in range(2))
    used.at(Targets.of_positions(np.array([[0.0], [1.0]])))
    used.at(Targets.of_positions(np.array([[-0.1], [1.5]])))
    rows, others = (item.kinematics.reductions[0].rows for item in (fresh, used))
    assert [own.shape for own in rows] == [(6, 3), (6, 3)]
    for own, other in zip(rows, others, strict=True):
        np.testing.assert_array_equal(own, other)


def test_threads_that_share_a_guesses_get_what_each_would_get_alone() -> None:
    mechanism = four_bar()
    guesses = guesses_of(mechanism, "A")
    blocks = [
        Targets.of_positions(np.linspace(-0.4 * k, 0.9 * k, 40)[:, None]) for k in range(1, 9)
    ]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(guesses.at, blocks))
    for block, guess in zip(blocks, together, strict=True):
        other = guesses_of(mechanism, "A")
        alone = closed(other, other.at(block))
        np.testing.assert_allclose(closed(guesses, guess), alone, atol=1e-12)
