"""Tolerances of the kinematics: far from rounding, and far from what mechanisms have."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly import Assembly
from cardan_dyn.core.kinematics.closing.all_groups import ClosedState
from cardan_dyn.core.kinematics.tolerances import (
    CLOSURE_TOLERANCE,
    RANK_TOLERANCE,
    SAFE_CORRECTION,
    SINGULAR_CONDITION,
)
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.problem.samples import Targets

MARGIN = 1e3
"""How far, at least, values have to stay away from a tolerance on either side of it."""
SCENES: dict[str, dict[str, object]] = {
    "four_bar": {"drive": "crank_bearing"},
    "universal_joint": {"drive": "bearing_in", "held": {"joint_angle": 0.7}},
    "needle_drive": {"drive": "main_shaft"},
    "slider_crank": {"drive": "crank_bearing"},
}


@pytest.fixture(scope="module", params=SCENES)
def state(request: pytest.FixtureRequest) -> ClosedState:
    problem = checked(cd.load(request.param), **SCENES[request.param])
    assembly = Assembly(problem)
    positions = np.linspace(0.1, 6.2, 50)[:, None]
    return assembly.close(assembly.guesses(Targets.of_positions(positions)), positions)


def test_singular_values_are_clearly_zero_or_not(state: ClosedState) -> None:
    for group in state.groups:
        if group.group.passives.size:
            values = np.linalg.svd(group.scaled_rows, compute_uv=False)
            relative = values / values[:, :1]
            is_zero = relative < RANK_TOLERANCE
            assert np.min(relative[~is_zero]) > MARGIN * RANK_TOLERANCE
            assert np.max(relative[is_zero], initial=0.0) < RANK_TOLERANCE / MARGIN


def test_rounding_is_far_below_the_tolerances() -> None:
    assert min(RANK_TOLERANCE, CLOSURE_TOLERANCE) > MARGIN * np.finfo(float).eps


def test_closed_loops_are_far_closer_than_the_tolerance(state: ClosedState) -> None:
    assert np.max(state.residual) < CLOSURE_TOLERANCE / MARGIN


def test_regular_positions_are_far_from_singular(state: ClosedState) -> None:
    assert np.max(state.condition) < SINGULAR_CONDITION / MARGIN
    digits = -np.log10(np.finfo(float).eps * SINGULAR_CONDITION)
    assert 3.0 < digits < 4.0


def test_guesses_of_branches_are_safe(state: ClosedState) -> None:
    assert np.max(state.correction) < SAFE_CORRECTION


def test_an_open_loop_is_refused_even_by_little() -> None:
    scene = universal(cd.load("universal_joint"), 0.7)
    assembly = scene.solver.assembly
    positions = np.array([[0.4]])
    guess = assembly.guesses(Targets.of_positions(positions))
    moved = guess.x.copy()
    column = cd.load("universal_joint").coordinates.columns["bearing_out"].start
    moved[:, column] += 0.02
    with pytest.raises(cd.AssemblyError, match="away from where the branch leads"):
        assembly.close(guess._replace(x=moved), positions)
    nearer = guess.x.copy()
    nearer[:, column] += 0.002
    assert assembly.close(guess._replace(x=nearer), positions).residual[0] < CLOSURE_TOLERANCE
