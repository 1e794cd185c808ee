"""Branches: covered spans, periods, limits and guesses of linkages known in closed form."""

from __future__ import annotations

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
from cardan_dyn.kinematics.closing.all_groups import ClosedState, Kinematics
from cardan_dyn.kinematics.following.branch import Branch
from cardan_dyn.kinematics.following.lines import Lines, Rows

TURN = 2.0 * np.pi


def branch_of(mechanism: cd.Mechanism, drive: str) -> Branch:
    kinematics, start = solver(mechanism, drive)
    return Branch(kinematics, start)


def test_a_new_branch_is_known_where_it_starts() -> None:
    mechanism = four_bar()
    branch = branch_of(mechanism, "A")
    assert branch.span == (0.0, 0.0)
    np.testing.assert_array_equal(branch.states(), mechanism.coordinates.neutral()[None])
    assert branch.period is None
    assert not np.any(branch.windings)


def test_a_branch_grows_to_both_sides_and_never_shrinks() -> None:
    mechanism = four_bar()
    branch = branch_of(mechanism, "A")
    for low, high, span in (
        (-0.5, 1.0, (-0.5, 1.0)),
        (0.0, 0.3, (-0.5, 1.0)),
        (-2.0, 0.0, (-2.0, 1.0)),
        (0.5, 9.0, (-2.0, 9.0)),
    ):
        branch.cover(low, high)
        assert branch.span == span
    states = branch.states()
    np.testing.assert_allclose(pin_distance(mechanism, states), COUPLER, rtol=1e-13)
    assert np.all(np.diff(values(mechanism, states, "A")) > 0.0)
    rocker = values(mechanism, states, "D")
    assert rocker_range()[0] <= np.min(rocker) < np.max(rocker) <= rocker_range()[1]


def test_what_is_covered_already_costs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    branch = branch_of(four_bar(), "A")
    branch.cover(-1.0, 1.0)
    monkeypatch.setattr(branch, "kinematics", None)
    branch.cover(-1.0, 1.0)
    branch.cover(0.0, 0.5)
    assert branch.span == (-1.0, 1.0)


@pytest.mark.parametrize("index", [0, 1])
def test_the_error_at_the_end_of_a_branch_is_kept(index: int) -> None:
    branch = branch_of(four_bar(), "D")
    end = rocker_range()[index]
    errors = []
    for beyond in (1.1, 1.5, 1.2):
        with pytest.raises(cd.AssemblyError) as caught:
            branch.cover(*sorted((0.0, beyond * end)))
        errors.append(caught.value)
    assert len(set(map(id, errors))) == 3
    assert str(errors[0]) == str(errors[1])
    assert errors[0].nearest == pytest.approx(end, abs=1e-9)
    # What was reached before the error is kept, and the other side can still be covered.
    reached = branch.span[index]
    assert 0.0 < abs(end - reached) < 1e-6
    other = rocker_range()[1 - index]
    branch.cover(*sorted((0.5 * end, 0.5 * other)))
    assert branch.span[1 - index] == 0.5 * other


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
    assert branch.find_period()
    assert branch.period == pytest.approx(TURN)
    assert branch.span == (-5.0, 6.0)


def test_limits_are_dead_points_or_infinite() -> None:
    low, high = rocker_range()
    rocker = branch_of(four_bar(), "D")
    assert rocker.limit(3.0) == pytest.approx(high, abs=1e-9)
    assert rocker.limit(-3.0) == pytest.approx(low, abs=1e-9)
    crank = branch_of(four_bar(), "A")
    assert crank.limit(9.0) == np.inf
    assert crank.limit(-9.0) == -np.inf
    assert crank.span == (-9.0, 9.0)
    # Within the known span as well, the direction from the start decides.
    assert (crank.limit(-8.0), crank.limit(8.0)) == (-np.inf, np.inf)


@pytest.mark.parametrize("before", [1e-3, 1e-6, 1e-8])
@pytest.mark.parametrize("beyond", [1e-8, 1e-3, 1.0, 100.0])
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


def guess_error(branch: Branch, positions: np.ndarray) -> float:
    guess = branch.guess(positions)
    return float(np.max(branch.kinematics.close(guess).correction))


def test_refinement_stops_at_rounding_or_at_the_limit_of_nodes() -> None:
    mechanism = four_bar()
    positions = np.linspace(-3.0, 3.0, 200)
    errors, sizes = [], []
    for node_limit in (0, 140, 2000):
        branch = branch_of(mechanism, "A")
        branch.cover(-3.0, 3.0)
        coarse = len(branch.states())
        branch.refine(branch.kinematics, node_limit)
        errors.append(guess_error(branch, positions))
        sizes.append(len(branch.states()))
        assert sizes[-1] >= coarse
    assert errors[2] < 1e-14 < errors[1] < errors[0] < 1e-2
    assert sizes[0] < 30 <= sizes[1] < sizes[2] < 2000
    np.testing.assert_allclose(pin_distance(mechanism, branch.states()), COUPLER, rtol=1e-13)


def test_refinement_waits_until_the_limit_has_doubled() -> None:
    branch = branch_of(four_bar(), "A")
    branch.cover(-3.0, 3.0)
    branch.refine(branch.kinematics, 140)
    size = len(branch.states())
    branch.refine(branch.kinematics, 379)
    assert len(branch.states()) == size
    branch.refine(branch.kinematics, 380)
    assert len(branch.states()) > size


def test_refinement_step_by_step_makes_the_nodes_of_one_at_once() -> None:
    """What is exact between two nodes is not tried again."""
    at_once, stepwise = (branch_of(four_bar(), "A") for _ in range(2))
    for branch in (at_once, stepwise):
        branch.cover(-3.0, 3.0)
    at_once.refine(at_once.kinematics, 5000)
    for node_limit in (140, 380, 900, 2000, 5000):
        stepwise.refine(stepwise.kinematics, node_limit)
    np.testing.assert_allclose(stepwise.states(), at_once.states(), rtol=0.0, atol=1e-14)
    assert not stepwise.may_refine(10**9)
    # What is followed later is not known to be exact, in contrast to what was known before.
    stepwise.cover(-3.1, 3.1)
    size = len(stepwise.states())
    stepwise.refine(stepwise.kinematics, 10**9)
    assert len(stepwise.states()) > size
    drive = stepwise._table.drive_column
    positions = stepwise.states()[:, drive]
    inside = positions[np.abs(positions) <= 3.0]
    np.testing.assert_array_equal(inside, at_once.states()[:, drive])


def test_guesses_are_exact_in_the_drive() -> None:
    mechanism = four_bar()
    branch = branch_of(mechanism, "A")
    branch.cover(-1.0, 2.0)
    positions = np.linspace(-1.0, 2.0, 33)
    np.testing.assert_array_equal(values(mechanism, branch.guess(positions), "A"), positions)


def mirrored(branch: Branch, rows: np.ndarray) -> np.ndarray:
    """The same crank angles, with the rocker mirrored about the line between its pins."""
    layout, guess = branch.kinematics.coordinates, rows.copy()
    for name, angle in (("D", 2.6), ("B", -1.8), ("C", 4.4)):
        guess[:, layout.columns[name]] = angle
    state = branch.kinematics.close(guess, most=60)
    assert np.max(state.residual) < 1e-12
    start = branch.kinematics.evaluate(branch.states()[[0]])
    assert not np.any(branch.kinematics.same_side(state, start.inverses))
    return state.x


@pytest.mark.parametrize(
    ("angle_deg", "most"), [(8.5, 4), (30.0, 4), (43.5, 5), (60.0, 7), (80.0, 10), (89.4, 21)]
)
def test_rounds_that_lead_over_a_turn(
    angle_deg: float, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Several lengths are tried in a round, so that none is lost to a step that was too long.

    Nodes that are so far apart that they prove nothing are mended, and not followed with care.
    """
    held = {"joint_angle": np.deg2rad(angle_deg)}
    joint = cd.load("universal_joint")
    scene = cd.Scene(joint, drive="bearing_in", held=held)
    step, to_ends, rounds, ways = Kinematics.newton_step, Lines.to_ends, [], []

    def counted(kinematics: Kinematics, x: np.ndarray) -> ClosedState:
        rounds.append(len(x))
        return step(kinematics, x)

    def followed(lines: Lines, rows: Rows, quick: bool) -> None:
        ways.append(quick)
        to_ends(lines, rows, quick)

    monkeypatch.setattr(Kinematics, "newton_step", counted)
    monkeypatch.setattr(Lines, "to_ends", followed)
    scene.sweep(np.linspace(-np.pi, np.pi, 9))
    assert ways == [True]
    assert 0 < len(rounds) <= most


@pytest.mark.parametrize("fault", ["another mode", "a gap"])
def test_what_the_quick_way_cannot_prove_is_followed_with_care(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mechanism = four_bar()
    branch, good = branch_of(mechanism, "A"), branch_of(mechanism, "A")
    good.cover(-3.0, 3.0)
    to_ends, ways = Lines.to_ends, []

    def faulty(lines: Lines, rows: Rows, quick: bool) -> None:
        to_ends(lines, rows, quick)
        ways.append(quick)
        if quick and fault == "a gap":
            del lines.nodes[1:3]
        elif quick:
            of_lines, nodes = lines.nodes[1]
            lines.nodes[1] = of_lines, mirrored(branch, nodes)

    monkeypatch.setattr(Lines, "to_ends", faulty)
    branch.cover(-3.0, 3.0)
    assert ways == [True, False]
    positions = np.linspace(-3.0, 3.0, 50)
    closed = [item.kinematics.close(item.guess(positions)).x for item in (branch, good)]
    np.testing.assert_allclose(*closed, rtol=0.0, atol=1e-13)


def test_a_branch_that_cannot_be_resolved_is_refused() -> None:
    branch = branch_of(four_bar(), "A")
    branch.cover(0.0, 2.0)

    class Astray:
        """The kinematics, which close the loops in the other mode."""

        def __getattr__(self, name: str) -> object:
            return getattr(branch.kinematics, name)

        def close(self, x: np.ndarray) -> object:
            state = branch.kinematics.close(mirrored(branch, x))
            return state._replace(correction=np.full(len(x), 0.1))

    with pytest.raises(cd.SingularConfigurationError, match="cannot be resolved near") as caught:
        branch.refine(Astray(), 200)
    assert 0.0 < caught.value.position < 2.0


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
    assert len(branch.states()) == 1
