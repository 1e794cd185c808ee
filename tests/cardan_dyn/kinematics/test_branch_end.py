"""Branch ends: limits extrapolated from the last nodes, and what their errors say."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import four_bar, rocker_range, solver

import cardan_dyn as cd
from cardan_dyn.kinematics.following.branch import (
    LOWER,
    UPPER,
    Attempt,
    BranchTable,
    limit,
    nodes_of,
    refused,
)


def near_dead_point(distance: float, before: float = 1e-3) -> BranchTable:
    """Nodes of a joint at √(1 - t), whose range ends at t = 1; the drive is coordinate 0."""
    layout = four_bar().coordinates
    positions = np.array([1.0 - distance - before, 1.0 - distance])
    nodes = np.zeros((2, 3, layout.size))
    nodes[:, 0, 0], nodes[:, 1, 0] = positions, 1.0
    nodes[:, 0, 2] = np.sqrt(1.0 - positions)
    nodes[:, 1, 2] = -0.5 * (1.0 - positions) ** -0.5
    nodes[:, 2, 2] = -0.25 * (1.0 - positions) ** -1.5
    return BranchTable(positions, nodes, 0, layout)


def parallelogram_before_its_end(drive: str = "A") -> tuple[object, BranchTable]:
    """Assembly modes meet at π/2, where all links are in line."""
    mechanism = four_bar(1.0, 1.0, 2.0)
    kinematics, start = solver(mechanism, drive)
    layout = mechanism.coordinates
    positions = 0.5 * np.pi - np.array([2e-6, 1e-6])
    states = np.repeat(start[None, :], 2, axis=0)
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        states[:, layout.columns[name].start] = sign * positions
    state = kinematics.evaluate(states)
    table = BranchTable(positions, nodes_of(kinematics, state), layout.columns["A"].start, layout)
    return kinematics, table


def test_ends_know_what_lies_beyond_them() -> None:
    table = near_dead_point(0.25, before=0.5)
    low, high = table.span
    assert LOWER.is_before(low - 1e-9, table)
    assert UPPER.is_before(high + 1e-9, table)
    for inside in (low, 0.5 * (low + high), high):
        assert not LOWER.is_before(inside, table)
        assert not UPPER.is_before(inside, table)


@pytest.mark.parametrize("distance", [1e-9, 1e-7, 2e-5])
def test_a_dead_point_is_found_from_the_square_root_before_it(distance: float) -> None:
    kinematics, _ = solver(four_bar(), "A")
    found = limit(kinematics, near_dead_point(distance), UPPER, 1.0)
    assert abs(found - 1.0) < 1e-8 * distance + 4e-16


def test_a_limit_far_from_the_last_node_is_not_believed() -> None:
    kinematics, _ = solver(four_bar(), "A")
    table = near_dead_point(2e-5)
    # The same curve in a unit of 0.1: its slope is still steep, the distance 2e-4 units.
    assert limit(kinematics, table, UPPER, 0.1) == table.span[1]


def test_meeting_modes_are_found_where_the_margin_vanishes() -> None:
    kinematics, table = parallelogram_before_its_end()
    found = limit(kinematics, table, UPPER, 1.0)
    assert found == pytest.approx(0.5 * np.pi, abs=1e-8)
    # Seen from the other end, the margin grows: nothing can be said but where the node is.
    assert limit(kinematics, table, LOWER, 1.0) == table.span[0]


def test_a_single_node_is_its_own_limit() -> None:
    kinematics, table = parallelogram_before_its_end()
    single = table._replace(positions=table.positions[1:], nodes=table.nodes[1:])
    assert limit(kinematics, single, UPPER, 1.0) == single.span[1]


@pytest.mark.parametrize(
    ("residual", "condition", "singular"),
    [(1e-3, 1e4, False), (1e-3, 1e13, True), (1e-13, 1e4, True)],
)
def test_open_loops_and_ambiguous_ways_on_are_different_errors(
    residual: float, condition: float, singular: bool
) -> None:
    kinematics, table = parallelogram_before_its_end()
    attempt = Attempt(1.6, residual, condition)
    end = refused(kinematics, table, UPPER, 1.0, attempt)
    assert end[:2] == UPPER[:2]
    reached = limit(kinematics, table, UPPER, 1.0)
    if singular:
        assert isinstance(end.error, cd.SingularConfigurationError)
        assert end.error.position == reached
        assert end.error.condition == kinematics.evaluate(table.states[1:]).condition[0]
    else:
        assert isinstance(end.error, cd.AssemblyError)
        assert (end.error.position, end.error.nearest) == (1.6, reached)
        assert end.error.residual == residual
    assert "assembly modes meet" in end.error.finding


def test_limits_of_a_rocker_are_those_of_its_triangle() -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "D")
    column = mechanism.coordinates.columns["D"].start
    low, _ = rocker_range()
    guess = start.copy()[None, :]
    nodes = []
    for distance in np.geomspace(0.2, 1e-6, 40):
        guess[:, column] = low + distance
        state = kinematics.close(guess)
        guess = state.x.copy()
        nodes.append(nodes_of(kinematics, state)[0])
    nodes = np.array(nodes[::-1])
    table = BranchTable(nodes[:, 0, column], nodes, column, mechanism.coordinates)
    assert limit(kinematics, table, LOWER, 1.0) == pytest.approx(low, abs=1e-11)
