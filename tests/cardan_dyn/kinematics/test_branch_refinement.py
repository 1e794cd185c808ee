"""Branch refinement: open intervals alone are halved, and lost branches are refused."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import four_bar, solver

import cardan_dyn as cd
from cardan_dyn.kinematics.following.branch import BranchTable, halved, nodes_of

MECHANISM = four_bar()
KINEMATICS, START = solver(MECHANISM, "A")
COLUMN = MECHANISM.coordinates.columns["A"].start


def table_at(*positions: float) -> BranchTable:
    """Nodes in the mode of the zero position."""
    nodes, guess = [], START.copy()[None, :]
    for position in positions:
        for share in np.linspace(guess[0, COLUMN], position, 20):
            guess[:, COLUMN] = share
            state = KINEMATICS.close(guess)
            guess = state.x.copy()
        nodes.append(nodes_of(KINEMATICS, state)[0])
    return BranchTable(np.array(positions), np.array(nodes), COLUMN, MECHANISM.coordinates)


def test_only_open_intervals_are_halved() -> None:
    table = table_at(0.0, 0.4, 0.8, 1.2)
    finer, is_open = halved(table, KINEMATICS, np.array([True, False, True]), 1e-3)
    np.testing.assert_allclose(finer.positions, [0.0, 0.2, 0.4, 0.8, 1.0, 1.2])
    assert is_open.tolist() == [False] * 5
    np.testing.assert_allclose(finer.nodes, table_at(*finer.positions).nodes, atol=1e-12)


def test_halves_stay_open_until_their_guesses_are_good_enough() -> None:
    table, is_open = table_at(0.0, 0.8), np.array([True])
    rounds = 0
    while np.any(is_open):
        before = table
        table, is_open = halved(table, KINEMATICS, is_open, 1e-12)
        assert is_open.shape == (table.size - 1,)
        rounds += 1
    assert rounds >= 2
    positions = np.linspace(0.0, 0.8, 201)

    def error(of: BranchTable) -> float:
        guess = of.guess(positions)
        return float(np.max(np.abs(guess - KINEMATICS.close(guess).x)))

    assert error(table) < 4e-12
    assert error(before) > error(table)


def test_closed_intervals_stay_closed() -> None:
    table = table_at(0.0, 0.4, 0.8)
    same, is_open = halved(table, KINEMATICS, np.array([False, True]), 1e-18)
    assert same.size == 4
    assert is_open.tolist() == [False, True, True]


def test_a_node_in_another_mode_is_noticed() -> None:
    table = table_at(0.0, 0.4)
    layout = MECHANISM.coordinates
    guess = table.states[[1]].copy()
    for name, angle in (("D", 2.6), ("B", -1.8), ("C", 4.4)):
        guess[:, layout.columns[name]] = angle
    state = KINEMATICS.close(guess, most=60)
    assert not KINEMATICS.same_side(state, KINEMATICS.evaluate(START[None, :]).inverses)[0]
    mixed = table.with_replaced(np.array([False, True]), nodes_of(KINEMATICS, state))
    with pytest.raises(cd.SingularConfigurationError, match="cannot be resolved near") as caught:
        halved(mixed, KINEMATICS, np.array([True]), 1e-3)
    assert caught.value.position == pytest.approx(0.2)
    expected = KINEMATICS.evaluate(table.states[:1]).condition[0]
    assert caught.value.condition == expected
