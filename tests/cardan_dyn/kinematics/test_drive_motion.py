"""What a drive moves by itself."""

from __future__ import annotations

from decimal import Decimal, getcontext

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.core.kinematics.following.drive_motion import TURN, turned_back


def test_whole_turns_are_taken_off_exactly() -> None:
    """Against decimal numbers of fifty digits; a product of floats is off by 1e-10 here."""
    getcontext().prec = 50
    turn = 2 * Decimal("3.14159265358979323846264338327950288419716939937510")
    rng = np.random.default_rng(0)
    for most in (1, 100, 10_000, 1_000_000):
        for of_period in (1, 3):
            angles = rng.uniform(-TURN, TURN, 200) + TURN * rng.integers(-most, most, 200)
            periods = np.floor(angles / (of_period * TURN))
            left = turned_back(angles, periods, of_period * TURN)
            exact = [
                Decimal(float(angle)) - Decimal(float(count)) * of_period * turn
                for angle, count in zip(angles, periods, strict=True)
            ]
            np.testing.assert_allclose(left, [float(item) for item in exact], rtol=0.0, atol=4e-15)


def test_guesses_stay_near_after_many_turns(joint: cd.Mechanism) -> None:
    """One Newton step closes each."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.6})
    turns = np.linspace(0.0, 200.0 * TURN, 900)
    scene.sweep(turns)
    sizes: list[int] = []
    evaluate = GroupSolver.evaluate

    def counted(solver: GroupSolver, x: np.ndarray, *arguments: object) -> object:
        sizes.append(len(x))
        return evaluate(solver, x, *arguments)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(GroupSolver, "evaluate", counted)
        scene.sweep(turns)
    assert sum(sizes) <= 2.02 * len(turns)
