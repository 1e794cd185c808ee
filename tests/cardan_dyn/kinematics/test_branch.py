"""Branches: covered spans, periods, limits and guesses of linkages known in closed form."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from testkit.planar_linkages import (
    COUPLER,
    four_bar,
    geared,
    pin_distance,
    rocker_range,
    solver,
    values,
)

import cardan_dyn as cd
from cardan_dyn.core.kinematics.following.branch import Branch
from cardan_dyn.core.kinematics.following.lines import Lines

TURN = 2.0 * np.pi


def branch_of(mechanism: cd.Mechanism, drive: str) -> Branch:
    kinematics, start = solver(mechanism, drive)
    return Branch(kinematics, start)


def test_a_new_branch_is_known_where_it_starts() -> None:
    mechanism = four_bar()
    branch = branch_of(mechanism, "A")
    assert branch.span == (0.0, 0.0)
    np.testing.assert_array_equal(branch._table.rows.x, mechanism.coordinates.neutral()[None])
    assert branch.period is None
    assert not np.any(branch.windings)


def test_a_branch_grows_to_both_sides_and_never_shrinks() -> None:
    mechanism = four_bar()
    branch = branch_of(mechanism, "A")
    spans = []
    for low, high in ((-0.5, 1.0), (0.0, 0.3), (-2.0, 0.0), (0.5, 9.0)):
        branch.cover(low, high)
        spans.append(branch.span)
        assert spans[-1][0] <= low < high < spans[-1][1]
    assert spans[0] == spans[1] != spans[2] != spans[3]
    assert (spans[0][1], spans[2][0]) == (spans[2][1], spans[3][0])
    # A step goes a radian at most beyond what was asked for.
    assert spans[3] == pytest.approx((-2.0, 9.0), abs=1.0)
    states = branch._table.rows.x
    np.testing.assert_allclose(pin_distance(mechanism, states), COUPLER, rtol=1e-13)
    assert np.all(np.diff(values(mechanism, states, "A")) > 0.0)
    rocker = values(mechanism, states, "D")
    assert rocker_range()[0] <= np.min(rocker) < np.max(rocker) <= rocker_range()[1]


def test_what_is_covered_already_costs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    branch = branch_of(four_bar(), "A")
    branch.cover(-1.0, 1.0)
    monkeypatch.setattr(Lines, "advance", None)
    branch.cover(-1.0, 1.0)
    branch.cover(0.0, 0.5)


@pytest.mark.parametrize("index", [0, 1])
def test_the_end_of_a_branch_is_told_again_and_again(index: int) -> None:
    branch = branch_of(four_bar(), "D")
    end = rocker_range()[index]
    errors = []
    for beyond in (1.1, 1.5, 1.2):
        with pytest.raises(cd.AssemblyError) as caught:
            branch.cover(*sorted((0.0, beyond * end)))
        errors.append(caught.value)
        assert caught.value.position == beyond * end
        assert caught.value.residual > 1e-10
    assert len({error.nearest for error in errors}) == 1
    assert len({error.finding for error in errors}) == 1
    assert errors[0].nearest == pytest.approx(end, abs=1e-9)
    # What was reached before the error is kept, and the other side can still be covered.
    reached = branch.span[index]
    assert 0.0 < abs(end - reached) < 1e-6
    other = rocker_range()[1 - index]
    branch.cover(*sorted((0.5 * end, 0.5 * other)))
    assert abs(0.5 * other) < abs(branch.span[1 - index]) < abs(other)


@pytest.mark.parametrize(
    ("ratio", "turns"), [(1.0, 1), (-3.0, 1), (0.5, 2), (1.0 / 3.0, 3), (-2.5, 2), (1.0 / 12.0, 12)]
)
def test_wheels_repeat_after_whole_turns_of_both(ratio: float, turns: int) -> None:
    mechanism = geared(ratio)
    branch = branch_of(mechanism, "A")
    assert branch.find_period()
    assert branch.period == pytest.approx(turns * TURN)
    assert values(mechanism, branch.windings, "A") == turns
    assert values(mechanism, branch.windings, "B") == pytest.approx(ratio * turns, abs=1e-12)


@pytest.mark.parametrize("ratio", [1.0 / 13.0, 0.3819660112501051, 1.0 + 1e-6])
def test_wheels_that_do_not_repeat_within_twelve_turns(ratio: float) -> None:
    branch = branch_of(geared(ratio), "A")
    assert not branch.find_period()
    assert branch.period is None


def test_a_crank_turns_through_and_its_rocker_does_not() -> None:
    mechanism = four_bar()
    crank, rocker = branch_of(mechanism, "A"), branch_of(mechanism, "D")
    assert crank.find_period()
    windings = {name: float(values(mechanism, crank.windings, name)) for name in "ABDC"}
    assert windings == {"A": 1.0, "B": -1.0, "D": 0.0, "C": 0.0}
    with pytest.raises(cd.AssemblyError):
        rocker.find_period()


def test_a_period_is_found_within_a_span_that_is_longer() -> None:
    branch = branch_of(four_bar(), "A")
    branch.cover(-5.0, 6.0)
    span = branch.span
    assert branch.find_period()
    assert branch.period == pytest.approx(TURN)
    assert branch.span == span


def test_no_period_is_sought_that_is_longer_than_positions_need() -> None:
    branch = branch_of(geared(1.0 / 3.0), "A")
    assert not branch.find_period(within=2.9 * np.pi)
    assert branch.span[1] < 3.0 * np.pi
    assert branch.find_period(within=3.1 * np.pi)
    assert branch.period == pytest.approx(3.0 * TURN)


def test_limits_are_dead_points_or_infinite() -> None:
    low, high = rocker_range()
    rocker = branch_of(four_bar(), "D")
    assert rocker.limit(3.0) == pytest.approx(high, abs=1e-9)
    assert rocker.limit(-3.0) == pytest.approx(low, abs=1e-9)
    crank = branch_of(four_bar(), "A")
    assert crank.limit(9.0) == np.inf
    assert crank.limit(-9.0) == -np.inf
    # Within the known span as well, the direction from the start decides.
    assert (crank.limit(-8.0), crank.limit(8.0)) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("before", "beyond"), [(1e-3, 1e-8), (1e-6, 1e-3), (1e-8, 1.0), (1e-3, 100.0)]
)
def test_a_dead_point_is_refused_alike_from_near_and_far(before: float, beyond: float) -> None:
    branch, (_, high) = branch_of(four_bar(), "D"), rocker_range()
    branch.cover(0.0, high - before)
    with pytest.raises(cd.AssemblyError) as caught:
        branch.cover(0.0, high + beyond)
    assert caught.value.nearest == pytest.approx(high, abs=1e-9)
    assert caught.value.position > high


def test_a_limit_is_also_where_modes_meet() -> None:
    """All links of the parallelogram are in line there."""
    parallelogram = branch_of(four_bar(1.0, 1.0, 2.0), "A")
    assert parallelogram.limit(2.0) == pytest.approx(0.5 * np.pi, abs=5e-6)
    assert parallelogram.limit(-2.0) == pytest.approx(-0.5 * np.pi, abs=5e-6)
    with pytest.raises(cd.SingularConfigurationError, match="assembly modes meet"):
        parallelogram.cover(0.0, 2.0)


@pytest.mark.parametrize("drive", ["A", "D"])
def test_one_newton_step_closes_a_guess(drive: str) -> None:
    """Up to dead points of the drive, of which nodes are as near as the limit is known."""
    branch = branch_of(four_bar(), drive)
    low, high = (-3.0, 3.0) if drive == "A" else rocker_range()
    if drive == "D":
        low, high = low + 1e-8, high - 1e-8
    branch.cover(low, high)
    x = branch._table.rows.x
    np.testing.assert_allclose(pin_distance(four_bar(), x), COUPLER, rtol=1e-13)
    positions = np.linspace(low, high, 3000)
    state = branch.kinematics.close(branch.guess(positions))
    assert np.max(state.correction) < 5e-8
    assert np.median(state.correction) < 1e-9
    assert len(x) < 200


def test_a_dead_point_is_neared_beyond_the_last_node() -> None:
    branch, (_, high) = branch_of(four_bar(), "D"), rocker_range()
    branch.limit(3.0)
    positions = high - np.array([1e-7, 1e-8, 3e-9, 2e-9])
    branch.cover(0.0, positions[-1])
    closed = branch.kinematics.close(branch.guess(positions))
    assert np.all(closed.correction < 1e-3)
    # Near the dead point the crank moves like the root of the distance, in the same mode.
    at_end = values(four_bar(), branch.at(positions[-1])[None], "A")
    ahead = np.abs(values(four_bar(), closed.x, "A") - at_end)[:-1]
    ratio = ahead / (np.sqrt([1e-7, 1e-8, 3e-9]) - np.sqrt(2e-9))
    np.testing.assert_allclose(ratio, ratio[0], rtol=0.1)


def test_guesses_do_not_depend_on_what_was_asked_before_or_beside() -> None:
    positions = np.random.default_rng(2).uniform(-3.0, 3.0, 50)
    at_once, in_turn, far = (branch_of(four_bar(), "A") for _ in range(3))
    at_once.cover(-3.0, 3.0)
    far.cover(0.0, 9.0)
    far.cover(-20.0, 0.0)
    expected = at_once.guess(positions)
    np.testing.assert_array_equal(far.guess(positions), expected)
    for position, row in zip(positions, expected, strict=True):
        in_turn.cover(position, position)
        np.testing.assert_array_equal(in_turn.guess(np.array([position]))[0], row)
    # Nodes are positions like any other.
    nodes = values(four_bar(), at_once._table.rows.x, "A")[1:-1]
    np.testing.assert_array_equal(far.guess(nodes), at_once.guess(nodes))


def test_states_near_the_start_do_not_depend_on_what_was_asked_before() -> None:
    fresh, used = (branch_of(four_bar(), "A") for _ in range(2))
    used.cover(-20.0, 0.0)
    used.cover(0.0, 9.0)
    near = fresh.states(2.0)
    assert 1.5 < np.max(np.abs(values(four_bar(), near, "A"))) <= 2.0
    np.testing.assert_array_equal(used.states(2.0), near)


def test_branches_that_begin_alike_are_one() -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "A")
    first = Branch.shared(kinematics, start, mechanism.kept)
    assert Branch.shared(solver(mechanism, "A")[0], start, mechanism.kept) is first
    assert Branch.shared(solver(mechanism, "D")[0], start, mechanism.kept) is not first


def test_threads_may_share_a_branch() -> None:
    branch, alone = branch_of(four_bar(), "A"), branch_of(four_bar(), "A")
    ends = np.linspace(0.5, 12.0, 24) * np.array([1.0, -1.0] * 12)

    def asked(end: float) -> np.ndarray:
        branch.cover(end, end)
        return branch.guess(np.linspace(0.0, end, 9))

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(asked, ends.tolist()))
    alone.cover(float(ends.min()), float(ends.max()))
    for end, rows in zip(ends, found, strict=True):
        np.testing.assert_array_equal(rows, alone.guess(np.linspace(0.0, end, 9)))


def test_a_single_position_is_closed() -> None:
    mechanism = four_bar()
    x = branch_of(mechanism, "A").at(0.7)
    assert values(mechanism, x, "A") == 0.7
    np.testing.assert_allclose(pin_distance(mechanism, x[None]), COUPLER, rtol=1e-14)


def test_guesses_are_exact_in_the_drive() -> None:
    mechanism = four_bar()
    branch = branch_of(mechanism, "A")
    branch.cover(-1.0, 2.0)
    positions = np.linspace(-1.0, 2.0, 33)
    np.testing.assert_array_equal(values(mechanism, branch.guess(positions), "A"), positions)


@pytest.mark.parametrize(
    ("angle_deg", "most"), [(8.5, 4), (30.0, 6), (43.5, 7), (60.0, 10), (80.0, 18), (89.4, 44)]
)
def test_steps_that_lead_over_a_turn(angle_deg: float, most: int) -> None:
    """Both sides take theirs together, and are bounded by how sharply joints turn."""
    held = {"joint_angle": np.deg2rad(angle_deg)}
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held=held)
    assembly = scene.solver.assembly
    branch = Branch(assembly.kinematics, assembly.start)
    close, rounds = type(branch.kinematics).close, []

    def counted(kinematics: object, x: np.ndarray, **options: object) -> object:
        rounds.append(len(x))
        return close(kinematics, x, **options)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(branch.kinematics), "close", counted)
        branch.cover(-np.pi, np.pi)
    assert len(rounds) <= most
    assert set(rounds) == {2}


@pytest.mark.parametrize("target", [-1.7, 1.7, 6.4])
def test_a_branch_never_goes_on_where_modes_meet(target: float) -> None:
    branch = branch_of(four_bar(1.0, 1.0, 2.0), "A")
    with pytest.raises(cd.SingularConfigurationError) as caught:
        branch.cover(min(target, 0.0), max(target, 0.0))
    assert caught.value.position == pytest.approx(np.copysign(0.5 * np.pi, target), abs=5e-6)
    assert np.max(np.abs(branch.span)) < 0.5 * np.pi


def test_a_singular_start_is_refused_at_once() -> None:
    parallelogram = four_bar(1.0, 1.0, 2.0)
    kinematics, flat = solver(parallelogram, "A")
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        flat[parallelogram.coordinates.columns[name]] = 0.5 * np.pi * sign
    branch = Branch(kinematics, flat)
    with pytest.raises(cd.SingularConfigurationError):
        branch.cover(0.5 * np.pi - 0.1, 0.5 * np.pi)
    assert len(branch._table.rows.x) == 1
