"""Sweeps and motions made of solutions: shapes, what outputs leave out, what is not unique."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.claims import acting
from testkit.drive_lines import two_lines
from testkit.linkages import coupling, gears
from testkit.planar_linkages import five_bar

import cardan_dyn as cd
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.problem.samples import Targets
from cardan_dyn.core.results.collect import motion_at, sweep_of

COUNT = 5
POSITIONS = np.linspace(0.0, 1.0, COUNT)[:, None]
SPEEDS = np.full((COUNT, 1), 2.0)
ACCELERATIONS = np.full((COUNT, 1), -3.0)
LOADS = {"bearing_out": -2.0}


def solver_of(mechanism: cd.Mechanism, **options: object) -> ProblemSolver:
    return ProblemSolver(checked(mechanism, **options))


def sweep(solver: ProblemSolver, *rates: np.ndarray, positions: np.ndarray = POSITIONS) -> cd.Sweep:
    targets = Targets.of_positions(positions)
    acts = acting(solver, *(rates or (np.zeros_like(positions),) * 2))
    return sweep_of(solver, solver.assemble(targets), acts)


def test_one_drive_has_no_dimension_of_its_own(joint: cd.Mechanism) -> None:
    solver = solver_of(joint, drive="bearing_in", held={"joint_angle": 0.5})
    turn = sweep(solver, SPEEDS, ACCELERATIONS)
    np.testing.assert_array_equal(turn.position, POSITIONS[:, 0])
    np.testing.assert_array_equal(turn.speed, np.full(COUNT, 2.0))
    np.testing.assert_array_equal(turn.acceleration, np.full(COUNT, -3.0))
    assert turn.drive_effort.shape == turn.condition.shape == (COUNT,)
    assert turn.unique.shape == (len(joint.joint_names), 6)
    assert turn.holding_effort["joint_angle"].shape == (COUNT,)


def test_several_drives_are_columns_in_their_order() -> None:
    """Each drive's effort balances the load at its own joint."""
    loads = {"D": -2.0, "A": -5.0}
    solver = solver_of(five_bar(), drive=["D", "A"], loads=loads)
    positions = np.array([[0.0, 0.1], [0.2, 0.0], [0.1, 0.3]])
    turn = sweep(solver, positions=positions)
    np.testing.assert_array_equal(turn.position, positions)
    np.testing.assert_allclose(turn.motion.position("D"), positions[:, 0])
    np.testing.assert_allclose(turn.drive_effort, np.tile([2.0, 5.0], (3, 1)), rtol=1e-13)


def test_residuals_are_those_of_the_solution(joint: cd.Mechanism) -> None:
    solver = solver_of(
        joint, drive="bearing_in", held={"joint_angle": 0.5}, gravity=(0.0, 0.0, -9.81)
    )
    assembled = solver.assemble(Targets.of_positions(POSITIONS))
    acts = acting(solver, SPEEDS, ACCELERATIONS)
    solution = solver.solve(assembled, acts)
    turn = sweep_of(solver, assembled, acts)
    assert turn.loop_residual == np.max(solution.loop_error)
    assert turn.balance_residual == solution.residuals.balance
    assert turn.power_residual == solution.residuals.power
    assert turn.rate_residual == solution.residuals.rate
    assert len({turn.loop_residual, turn.balance_residual, turn.power_residual}) == 3
    magnification = solver.magnification_at(assembled, solution.x)
    np.testing.assert_array_equal(turn.condition, magnification * solution.residuals.cancellation)
    assert turn.unproven == ()


def test_joints_that_no_output_needs_are_nan() -> None:
    mechanism = cd.load(two_lines(2))
    options = {"drive": "bearing_0", "loads": {"left_2": -5.0}, "outputs": ["left_2"]}
    solver = solver_of(mechanism, **options)
    turn = sweep(solver, SPEEDS, ACCELERATIONS)
    motion = motion_at(solver, Targets.of_positions(POSITIONS), SPEEDS, ACCELERATIONS)
    for item in (turn.motion, motion):
        for name in mechanism.coordinates.columns:
            values = (item.position(name), item.velocity(name), item.acceleration(name))
            is_left_out = name.startswith("right_")
            assert np.all(np.isnan([*values, item.ratio(name)])) == is_left_out
            assert np.any(np.isnan(values)) == is_left_out
    assert "right_shaft_2" in " ".join(turn.unproven)
    with pytest.raises(cd.ModelError, match="the drive effort was not asked for"):
        _ = turn.drive_effort


def test_a_motion_alone_is_that_of_the_sweep(shaft: cd.Mechanism) -> None:
    held = {"joint_angle_1": 0.5, "joint_angle_2": 0.3}
    # More samples than one block has.
    positions = np.linspace(-9.0, 9.0, 800)[:, None]
    rates = np.cos(positions), np.sin(positions)
    turn = sweep(solver_of(shaft, drive="bearing_in", held=held), *rates, positions=positions)
    targets = Targets.of_positions(positions)
    motion = motion_at(solver_of(shaft, drive="bearing_in", held=held), targets, *rates)
    assert len(motion) == 800
    for name in shaft.coordinates.columns:
        for quantity in ("position", "velocity", "acceleration", "ratio"):
            expected = getattr(turn.motion, quantity)(name)
            np.testing.assert_allclose(getattr(motion, quantity)(name), expected, atol=1e-11)


@pytest.mark.parametrize(
    ("outputs", "knows_drive", "held"),
    [
        (["bearing_out"], False, ["joint_angle_2", "joint_angle_3"]),
        (["bearing_in"], True, ["joint_angle_1", "joint_angle_2", "joint_angle_3"]),
        ([], True, []),
    ],
)
def test_efforts_are_known_as_far_as_outputs_need_them(
    outputs: list[str], knows_drive: bool, held: list[str]
) -> None:
    """The closure forces of the last universal joint do not act on the first held joint."""
    line = cd.load("drive_line")
    angles = {name: 0.2 for name in line.joints if name.startswith("joint_angle")}
    options = {"drive": "bearing_in", "held": angles, "loads": {"bearing_out": -3.0}}
    turn = sweep(solver_of(line, **options, outputs=outputs))
    whole = sweep(solver_of(line, **options))
    assert list(turn.holding_effort) == held
    for name in held:
        expected = whole.holding_effort[name]
        np.testing.assert_allclose(turn.holding_effort[name], expected, atol=1e-12)
    if knows_drive:
        np.testing.assert_allclose(turn.drive_effort, whole.drive_effort, rtol=1e-12)
    else:
        with pytest.raises(cd.ModelError, match="the drive effort was not asked for"):
            _ = turn.drive_effort


def test_couplings_have_their_own_flags() -> None:
    train = coupling("ab", "a", "b", -2.0), coupling("bc", "b", "c", -3.0)
    loads = {"b": -1.0, "c": -4.0}
    turn = sweep(solver_of(cd.load(gears(*train, third=True)), drive="a", loads=loads))
    np.testing.assert_allclose(turn.coupling_moment["bc"], 4.0, rtol=1e-14)
    np.testing.assert_allclose(turn.coupling_moment["ab"], 1.0 - 3.0 * 4.0, rtol=1e-14)
    assert turn.coupling_unique == {"ab": True, "bc": True}
    doubled = gears(*train, coupling("second", "b", "c", -3.0), third=True)
    turn = sweep(solver_of(cd.load(doubled), drive="a", loads=loads))
    assert turn.coupling_unique == {"ab": True, "bc": False, "second": False}
    together = turn.coupling_moment["bc"] + turn.coupling_moment["second"]
    np.testing.assert_allclose(together, 4.0, rtol=1e-13)


def test_strict_problems_refuse_what_is_not_unique(joint: cd.Mechanism) -> None:
    solver = solver_of(joint, drive="bearing_in", held={"joint_angle": 0.5}, strict=True)
    with pytest.raises(cd.IndeterminateError, match="bearing_in: force x, force y, force z"):
        sweep(solver)


def test_loads_with_another_count_of_samples_are_refused(joint: cd.Mechanism) -> None:
    options = {"drive": "bearing_in", "held": {"joint_angle": 0.5}}
    scene = cd.Scene(joint, **options, loads={"bearing_out": [1.0, 2.0]})
    with pytest.raises(cd.ArgumentError, match=r"position \(5,\), loads\['bearing_out'\] \(2,\)"):
        scene.sweep(POSITIONS[:, 0])


def test_a_grid_has_what_its_samples_have_in_a_row(joint: cd.Mechanism) -> None:
    solver = solver_of(joint, drive="bearing_in", held={"joint_angle": 0.5}, loads=LOADS)
    targets = Targets.of_positions(np.linspace(0.0, 1.0, 6)[:, None])
    speeds = np.linspace(1.0, 2.0, 6)[:, None]
    acts = acting(solver, speeds, -speeds)
    assembled = solver.assemble(targets)
    flat = sweep_of(solver, assembled, acts)
    rates = speeds.reshape(2, 3, 1)
    acts = acts._replace(speeds=rates, accelerations=-rates)
    on_grid = targets.positions.reshape(2, 3, 1)
    assembled = solver.assemble(targets._replace(shape=(2, 3), given=on_grid))
    grid = sweep_of(solver, assembled, acts)
    assert grid.shape == (2, 3)
    for name in ("position", "speed", "acceleration", "drive_effort", "condition"):
        expected = getattr(flat, name).reshape(2, 3)
        np.testing.assert_array_equal(getattr(grid, name), expected)
    holding = flat.holding_effort["joint_angle"].reshape(2, 3)
    np.testing.assert_array_equal(grid.holding_effort["joint_angle"], holding)
    for name in joint.joint_names:
        np.testing.assert_array_equal(grid[name].force, flat[name].force.reshape(2, 3, 3))
        for quantity in ("position", "velocity", "acceleration", "ratio"):
            expected = getattr(flat.motion, quantity)(name).reshape(2, 3)
            np.testing.assert_array_equal(getattr(grid.motion, quantity)(name), expected)


def test_nothing_of_a_sweep_can_be_written_to(joint: cd.Mechanism) -> None:
    solver = solver_of(joint, drive="bearing_in", held={"joint_angle": 0.5})
    turn = sweep(solver)
    arrays = (turn.unique, turn.condition, turn.drive_effort, turn.position, turn.motion.a)
    for array in (*arrays, *turn.holding_effort.values()):
        assert not array.flags.writeable
