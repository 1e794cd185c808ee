"""Generic states: closed configurations whose ranks are those of the motion."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import drive_line, two_lines
from testkit.hinge_loops import bennett, description, hinge, robot
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.far import GenericStates, generic_states
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.core.kinematics.loops.structure import Structure


def states_of(text: str) -> list[GenericStates | GroupSolver]:
    mechanism = cd.load(text)
    start = mechanism.coordinates.neutral()
    return generic_states(Structure(mechanism), 100, start)


def test_all_states_are_closed_and_regular() -> None:
    (states,) = states_of(robot(description(bennett())))
    assert isinstance(states, GenericStates)
    assert len(states.group.x) >= 4
    assert np.max(states.group.residual) < 1e-12
    values = np.linalg.svd(states.group.scaled_rows, compute_uv=False)
    assert np.all(values[:, 2] > 1e-3)
    assert np.all(values[:, 3] < 1e-10)
    assert (states.rank, states.rank_at_start) == (3, 3)
    # They are different configurations.
    assert np.max(np.ptp(states.group.x, axis=0)) > 1e-2


def test_singular_zeros_are_left_out() -> None:
    flat = [hinge((x, 0.0, 0.0), (0.0, 0.0, 1.0)) for x in (0.0, 1.0, 3.0, 2.0)]
    (states,) = states_of(robot(description(flat)))
    assert isinstance(states, GenericStates)
    assert (states.rank, states.rank_at_start) == (3, 2)
    values = np.linalg.svd(states.group.scaled_rows, compute_uv=False)
    assert np.all(values[:, 2] > 1e-6)


def test_independent_sets_are_apart() -> None:
    (line,) = states_of(drive_line(3))
    assert isinstance(line, GenericStates)
    assert line.group.group.loops == (0, 1, 2)
    # Both lines hang on one drive.
    (lines,) = states_of(two_lines(2))
    assert isinstance(lines, GenericStates)
    apart = states_of(robot(description(bennett(), "a_"), description(bennett(), "b_")))
    assert len(apart) == 2


def test_large_sets_come_back_as_solvers() -> None:
    mechanism = cd.load(drive_line(3))
    start = mechanism.coordinates.neutral()
    (solver,) = generic_states(Structure(mechanism), 9, start)
    assert isinstance(solver, GroupSolver)
    assert solver.group.passives.size == 10


def test_loops_that_cannot_be_closed_are_refused() -> None:
    with pytest.raises(cd.AssemblyError, match="four_bar: the loops cannot be closed"):
        states_of(four_bar(loop("continuous"), rocker="9.0"))


def test_open_chains_have_none() -> None:
    assert states_of(four_bar("")) == []
