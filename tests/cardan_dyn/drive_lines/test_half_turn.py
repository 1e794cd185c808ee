"""Positions half a turn later, against positions that are solved one by one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from testkit.line_data import Array, random_line

from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.samples import Targets
from cardan_dyn.drive_lines import Analysis, DriveLine, ShaftJoint, Spline
from cardan_dyn.practice.drive_lines.verdict.half_turn import HalfTurn

FIRST = np.array([0.2, -1.0, 2.9, 40.0])
POSITIONS = np.concatenate([FIRST, FIRST[::-1] + np.pi, FIRST - 4.0 * np.pi, FIRST[:2] + np.pi])
"""Positions with some that are half turns apart, in no order."""
OPTIONS = {"speed": 50.0, "acceleration": 30.0, "gravity": (1.0, 2.0, -9.0), "slipping": "out"}


def rubbing(line: DriveLine) -> DriveLine:
    """The line with friction in its splines."""
    spline = Spline(friction=0.1, radius=0.02)
    shafts = [replace(shaft, spline=shaft.spline and spline) for shaft in line.shafts]
    return line.replace(shafts=shafts)


def even(line: DriveLine) -> DriveLine:
    """The line with a joint of constant velocity."""
    return line.replace(joints=[ShaftJoint(kind="constant_velocity"), *line.joints[1:]])


LINES = {
    "crosses": rubbing(random_line(3, 2, mass=True)),
    "even": rubbing(even(random_line(2, 4, mass=True))),
    "centred": DriveLine.from_toml("pto"),
}


def assert_equal(found: Analysis, exact: Analysis, place: object, at: object) -> None:
    for one, other in ((found, exact), (found.total, exact.total), (found.static, exact.static)):
        names = one._fields if isinstance(one, tuple) else ("rotation", "ratio", "acceleration")
        for name in names:
            values, expected = getattr(one, name)[place], getattr(other, name)[at]
            scale = max(1.0, float(np.max(np.abs(getattr(other, name)), initial=0.0)))
            assert values == pytest.approx(expected, rel=0.0, abs=1e-11 * scale), name


def torques() -> Array:
    return np.linspace(100.0, 300.0, len(POSITIONS))


@pytest.mark.slow
@pytest.mark.parametrize("name", LINES)
def test_positions_do_not_know_of_each_other(name: str) -> None:
    line = LINES[name]
    together = line.analyse(positions=POSITIONS, torque=torques(), **OPTIONS)
    for place, (position, torque) in enumerate(zip(POSITIONS, torques(), strict=True)):
        alone = line.analyse(positions=[position], torque=torque, **OPTIONS)
        assert_equal(together, alone, place, 0)


@pytest.mark.slow
def test_nor_do_those_of_designs_out_of_line() -> None:
    line = LINES["crosses"]
    far = {"offset_y_1": [0.01, 0.0, -0.02], "support_A_z": [0.0, 0.005, 0.01]}
    designs = line.variants(misalignments=far, fork_offsets=np.ones((3, 2)))
    together = line.analyse(positions=POSITIONS, torque=torques(), variants=designs, **OPTIONS)
    for place in range(5):
        alone = line.analyse(
            positions=POSITIONS[[place]], torque=torques()[place], variants=designs, **OPTIONS
        )
        assert_equal(together, alone, (slice(None), place), (slice(None), 0))


def test_what_is_solved_once() -> None:
    half = HalfTurn.of(POSITIONS)
    assert half.positions.tolist() == FIRST.tolist()
    assert half.positions[half.source] + np.pi * half.later == pytest.approx(POSITIONS, abs=1e-14)
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    assert HalfTurn.of(turn).positions.tolist() == turn[:36].tolist()
    assert len(HalfTurn.of(np.linspace(0.0, 2.0 * np.pi, 35, endpoint=False)).positions) == 35
    near = np.array([1.0, 1.0 + 1e-12, 1.0 + np.pi])
    assert HalfTurn.of(near).positions.tolist() == near[:2].tolist()


@pytest.mark.slow
def test_a_turn_is_solved_by_half(monkeypatch: pytest.MonkeyPatch) -> None:
    shapes, original = [], ProblemSolver.assembled_at

    def counting(self: ProblemSolver, targets: Targets, near: Mapping[str, Array]) -> object:
        shapes.append(targets.shape)
        return original(self, targets, near)

    monkeypatch.setattr(ProblemSolver, "assembled_at", counting)
    line = LINES["crosses"].replace(speed=1.0, torque=1.0)
    assert line.analyse().shape == (360,)
    designs = line.variants(fork_offsets=np.ones((4, 2)))
    assert line.analyse(variants=designs).shape == (4, 72)
    assert shapes == [(2, 180), (2, 4, 36)]  # With the torque, and moving.
