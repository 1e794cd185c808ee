"""Correctors: what one Newton step leaves, and what the proof of a branch notices."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import COUPLER, four_bar, pin_distance, solver

from cardan_dyn.kinematics.following.branch import (
    BranchFollower,
    BranchTable,
    FullClosure,
    OneNewtonStep,
    nodes_of,
    proven,
    table_of,
)

MECHANISM = four_bar()
KINEMATICS, START = solver(MECHANISM, "A")
COLUMN = MECHANISM.coordinates.columns["A"].start


def first_table() -> BranchTable:
    return table_of(KINEMATICS, KINEMATICS.evaluate(START[None, :]), COLUMN)


def quickly_followed(low: float = -3.0, high: float = 3.0) -> BranchTable:
    followed = BranchFollower(KINEMATICS, 1.0, OneNewtonStep()).follow(first_table(), low, high)
    assert followed.refused is None
    return followed.table


def in_the_other_mode(crank: float) -> np.ndarray:
    """A node where the rocker is mirrored about the line from crank pin to rocker bearing."""
    guess = START.copy()[None, :]
    guess[:, COLUMN] = crank
    guess[:, MECHANISM.coordinates.columns["D"]] = 2.6
    guess[:, MECHANISM.coordinates.columns["B"]] = -1.8
    guess[:, MECHANISM.coordinates.columns["C"]] = 2.6 + 1.8
    state = KINEMATICS.close(guess, most=60)
    assert state.residual[0] < 1e-12
    assert not KINEMATICS.same_side(state, KINEMATICS.evaluate(START[None, :]).inverses)[0]
    return nodes_of(KINEMATICS, state)


def test_one_newton_step_leaves_the_square_of_the_error() -> None:
    passives = np.setdiff1d(np.arange(START.size), [COLUMN])
    errors = []
    for off in (1e-2, 1e-3, 1e-4):
        guess = START.copy()[None, :]
        guess[:, passives] += off * np.array([1.0, -0.5, 0.7])
        state = OneNewtonStep().correct(KINEMATICS, guess)
        errors.append(float(np.max(np.abs(state.x - START))))
        assert OneNewtonStep().is_usable(state).tolist() == [True]
    assert errors[0] / errors[1] == pytest.approx(100.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(100.0, rel=0.05)


def test_full_closure_closes_or_says_that_it_has_not() -> None:
    guess = np.repeat(START[None, :], 2, axis=0)
    guess[:, MECHANISM.coordinates.columns["D"]] += np.array([[0.02], [0.02]])
    state = FullClosure().correct(KINEMATICS, guess)
    np.testing.assert_allclose(pin_distance(MECHANISM, state.x), COUPLER, rtol=1e-14)
    assert FullClosure().is_usable(state).tolist() == [True, True]
    rocker_driven, start = solver(MECHANISM, "D")
    out_of_reach = start.copy()[None, :]
    out_of_reach[:, MECHANISM.coordinates.columns["D"]] = 1.2
    with np.errstate(all="ignore"):
        state = FullClosure().correct(rocker_driven, out_of_reach)
    assert FullClosure().is_usable(state).tolist() == [False]


def test_the_proof_closes_all_new_nodes() -> None:
    rough = quickly_followed()
    table = proven(KINEMATICS, rough, 0.0, 0.0)
    assert table is not None
    np.testing.assert_array_equal(table.positions, rough.positions)
    np.testing.assert_allclose(pin_distance(MECHANISM, table.states), COUPLER, rtol=1e-14)
    assert np.max(np.abs(pin_distance(MECHANISM, rough.states) - COUPLER)) > 1e-9


def test_a_node_in_another_assembly_mode_is_noticed() -> None:
    table = quickly_followed()
    index = table.size // 2 + 1
    chosen = np.arange(table.size) == index
    other = in_the_other_mode(float(table.positions[index]))
    assert proven(KINEMATICS, table.with_replaced(chosen, other), 0.0, 0.0) is None
    # Between the ends of a span that was proven before, nothing is looked at again.
    low, high = table.positions[[index - 1, index + 1]]
    assert proven(KINEMATICS, table.with_replaced(chosen, other), low, high) is not None


def test_a_gap_that_is_too_wide_is_noticed() -> None:
    table = quickly_followed()
    kept = np.ones(table.size, dtype=bool)
    kept[2:6] = False
    gap = table._replace(positions=table.positions[kept], nodes=table.nodes[kept])
    assert proven(KINEMATICS, gap, 0.0, 0.0) is None


def test_a_node_that_is_far_from_closed_is_noticed() -> None:
    table = quickly_followed()
    chosen = np.arange(table.size) == 1
    off = table.nodes[chosen].copy()
    off[0, 0, MECHANISM.coordinates.columns["D"]] += 0.05
    assert proven(KINEMATICS, table.with_replaced(chosen, off), 0.0, 0.0) is None
