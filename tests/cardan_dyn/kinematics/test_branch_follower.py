"""Branch follower: both ways of correcting, targets hit, dead points and meeting modes refused."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import (
    COUPLER,
    four_bar,
    pin_distance,
    rocker_range,
    solver,
    values,
)

import cardan_dyn as cd
from cardan_dyn.kinematics.following.branch import (
    LOWER,
    UPPER,
    BranchFollower,
    BranchTable,
    Followed,
    FullClosure,
    OneNewtonStep,
    proven,
    table_of,
)

CORRECTORS = (OneNewtonStep(), FullClosure())


def begin(mechanism: cd.Mechanism, drive: str) -> tuple[object, BranchTable]:
    kinematics, start = solver(mechanism, drive)
    column = mechanism.coordinates.columns[drive].start
    return kinematics, table_of(kinematics, kinematics.evaluate(start[None, :]), column)


def follow(
    mechanism: cd.Mechanism, drive: str, low: float, high: float, corrector: object
) -> Followed:
    kinematics, table = begin(mechanism, drive)
    return BranchFollower(kinematics, 1.0, corrector).follow(table, low, high)


@pytest.mark.parametrize("corrector", CORRECTORS, ids=lambda item: type(item).__name__)
@pytest.mark.parametrize(("low", "high"), [(-7.0, 5.0), (0.0, 0.3), (-2.0, 0.0)])
def test_targets_are_reached_exactly(low: float, high: float, corrector: object) -> None:
    followed = follow(four_bar(), "A", low, high, corrector)
    assert followed.refused is None
    assert followed.table.span == (low, high)
    assert np.all(np.diff(followed.table.positions) > 0.0)
    assert np.max(np.diff(followed.table.positions)) <= np.pi / 4.0 + 1e-12


def test_nodes_of_the_careful_way_are_closed_and_continuous() -> None:
    mechanism = four_bar()
    table = follow(mechanism, "A", -7.0, 7.0, FullClosure()).table
    np.testing.assert_allclose(pin_distance(mechanism, table.states), COUPLER, rtol=1e-13)
    # The rocker never leaves the range of its triangle: the assembly mode stays the same.
    low, high = rocker_range()
    rocker = values(mechanism, table.states, "D")
    assert low - 1e-12 < np.min(rocker) < np.max(rocker) < high + 1e-12


def test_both_ways_lead_to_the_same_branch() -> None:
    mechanism = four_bar()
    kinematics, first = begin(mechanism, "A")
    tables = [
        BranchFollower(kinematics, 1.0, corrector).follow(first, -3.0, 3.0).table
        for corrector in CORRECTORS
    ]
    quick = proven(kinematics, tables[0], 0.0, 0.0)
    assert quick is not None
    positions = np.linspace(-3.0, 3.0, 50)
    closed = [kinematics.close(table.guess(positions)).x for table in (quick, tables[1])]
    np.testing.assert_allclose(closed[0], closed[1], rtol=0.0, atol=1e-13)


def test_the_old_table_stays_as_it_was() -> None:
    kinematics, first = begin(four_bar(), "A")
    follower = BranchFollower(kinematics, 1.0, FullClosure())
    follower.follow(first, -1.0, 1.0)
    assert first.span == (0.0, 0.0)
    longer = follower.follow(first, 0.0, 1.0).table
    farther = follower.follow(longer, 0.0, 2.0).table
    assert longer.span == (0.0, 1.0)
    np.testing.assert_array_equal(farther.positions[: longer.size], longer.positions)
    np.testing.assert_array_equal(farther.nodes[: longer.size], longer.nodes)


@pytest.mark.parametrize(("end", "index"), [(LOWER, 0), (UPPER, 1)])
def test_a_dead_point_is_refused_where_crank_and_coupler_are_in_line(
    end: object, index: int
) -> None:
    dead_point = rocker_range()[index]
    targets = [0.0, 0.0]
    targets[index] = 2.0 * dead_point
    followed = follow(four_bar(), "D", *targets, FullClosure())
    assert followed.refused is not None
    assert followed.refused.node == end.node
    error = followed.refused.error
    assert isinstance(error, cd.AssemblyError)
    assert error.nearest == pytest.approx(dead_point, abs=1e-9)
    assert end.sign * (error.position - dead_point) > 0.0
    # What was reached is kept, and lies within the range.
    reached = followed.table.span[index]
    assert 0.0 < end.sign * (dead_point - reached) < 1e-6
    np.testing.assert_allclose(pin_distance(four_bar(), followed.table.states), COUPLER, rtol=1e-9)


@pytest.mark.parametrize("target", [-1.7, 1.7, 6.4])
def test_a_branch_never_goes_on_where_modes_meet(target: float) -> None:
    parallelogram = four_bar(1.0, 1.0, 2.0)
    low, high = min(target, 0.0), max(target, 0.0)
    followed = follow(parallelogram, "A", low, high, FullClosure())
    assert followed.refused is not None
    assert isinstance(followed.refused.error, cd.SingularConfigurationError)
    assert followed.refused.error.position == pytest.approx(
        np.copysign(0.5 * np.pi, target), abs=5e-6
    )
    assert np.max(np.abs(followed.table.positions)) < 0.5 * np.pi


def test_a_singular_start_is_refused_at_once() -> None:
    parallelogram = four_bar(1.0, 1.0, 2.0)
    layout = parallelogram.coordinates
    kinematics, flat = solver(parallelogram, "A")
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        flat[layout.columns[name]] = 0.5 * np.pi * sign
    column = layout.columns["A"].start
    table = table_of(kinematics, kinematics.evaluate(flat[None, :]), column)
    low = 0.5 * np.pi - 0.1
    followed = BranchFollower(kinematics, 1.0, FullClosure()).follow(table, low, 0.5 * np.pi)
    assert followed.refused is not None
    assert followed.refused.node == LOWER.node
    assert isinstance(followed.refused.error, cd.SingularConfigurationError)
    assert followed.table.size == 1
