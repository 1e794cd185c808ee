"""Collected: whole sweeps from their blocks, what is refused of them, and what memory they take."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from testkit.claims import acting, four_bar, positions

import cardan_dyn as cd
from cardan_dyn.core.dynamics import problem_solver
from cardan_dyn.core.dynamics.collected import Evidence, Rows, kept
from cardan_dyn.core.dynamics.inverse_dynamics import Solution
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.samples import Targets
from cardan_dyn.kit.threads import on_cores

COUNT = 30


@pytest.fixture(scope="module")
def solution() -> Solution:
    """Return one that knows all that any keeps."""
    scene = four_bar()
    solver, where = ProblemSolver(scene.problem), positions(scene)
    rates = np.full_like(where, 3.0), np.full_like(where, -1.0)
    assembled = solver.assemble(Targets.of_positions(where))
    return solver.solve(assembled, acting(solver, *rates))


def concluded(*blocks: Solution) -> Solution:
    rows = Rows(COUNT * len(blocks))
    for index, block in enumerate(blocks):
        rows.put(slice(COUNT * index, COUNT * (index + 1)), kept(block))
    return Evidence.concluded([Evidence.of(block, np.zeros((COUNT, 1))) for block in blocks], rows)


def test_blocks_are_put_in_their_order(solution: Solution) -> None:
    other = solution._replace(
        v=2.0 * solution.v,
        loop_error=solution.loop_error + 1e-10,
        closure_condition=solution.closure_condition + 1.0,
        influence=solution.influence + 1.0,
        indeterminate_couplings={3},
    )
    first = solution._replace(indeterminate_couplings={1})
    whole = concluded(first, other)
    for name in ("x", "v", "a", "wrenches", "efforts"):
        expected = np.concatenate([getattr(first, name), getattr(other, name)])
        np.testing.assert_array_equal(getattr(whole, name), expected)
    ratios = [item.velocity_ratios.values for item in (first, other)]
    np.testing.assert_array_equal(whole.velocity_ratios.values, np.concatenate(ratios))
    assert np.max(whole.loop_error) == np.max(other.loop_error)
    assert np.max(whole.closure_condition) == np.max(other.closure_condition)
    np.testing.assert_array_equal(whole.influence, other.influence)
    assert whole.indeterminate_couplings == {1, 3}
    assert whole.residuals.balance == solution.residuals.balance
    assert len(whole.residuals.imbalance) < COUNT


def test_errors_are_those_of_the_worst_sample(solution: Solution) -> None:
    error = np.zeros(COUNT)
    error[2] = 1e-3
    bad = solution._replace(residuals=solution.residuals._replace(rate_error=error))
    worse = solution._replace(residuals=solution.residuals._replace(rate_error=2.0 * error))
    with pytest.raises(cd.AccuracyError, match=r"the rate residual is 2\.0e-03"):
        concluded(solution, bad, solution, worse, bad)
    array = solution.a.copy()
    array[3, 0] = np.inf
    with pytest.raises(cd.AccuracyError, match="the accelerations of the joints cannot be"):
        concluded(bad, solution._replace(a=array), solution)


GRID = {"drive": "bearing_in", "held": {"joint_angle": 0.5}}
PAIR = {"drive": ["bearing_in", "joint_angle"]}


def of_one_drive(scene: cd.Scene, count: int) -> cd.Sweep:
    return scene.sweep(np.linspace(0.0, 40.0, count), 5.0)


def of_a_grid(scene: cd.Scene, count: int) -> cd.Sweep:
    angle = np.linspace(0.1, 1.0, count // 500)[:, None]
    return scene.sweep(np.linspace(0.0, 6.0, 500), held={"joint_angle": angle})


def of_two_drives(scene: cd.Scene, count: int) -> cd.Sweep:
    rng = np.random.default_rng(0)
    turn, angle = rng.uniform(0.0, 6.0, count), rng.uniform(0.1, 1.0, count)
    return scene.sweep(np.stack([turn, angle], axis=-1))


@pytest.mark.parametrize(
    ("options", "sweep"),
    [(GRID, of_one_drive), (GRID, of_a_grid), (PAIR, of_two_drives)],
    ids=["one drive", "grid", "two drives"],
)
def test_memory_beyond_what_is_returned_does_not_grow(
    joint: cd.Mechanism, options: dict[str, object], sweep: Callable[[cd.Scene, int], cd.Sweep]
) -> None:
    """For each core, that is: here for one."""
    loads = {"bearing_out": -100.0}
    scene = cd.Scene(joint, loads=loads, outputs=["bearing_out"], **options)  # type: ignore
    sweep(scene, 2_000)
    beyond = []
    for count in (50_000, 100_000):
        tracemalloc.start()
        with on_cores(1):
            result = sweep(scene, count)
        returned, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert result.condition.size == count
        beyond.append(peak - returned)
    assert max(beyond) < 16e6
    # What half of the samples take is some 15 MB.
    assert beyond[1] - beyond[0] < 4e6


def test_elements_act_in_every_block(monkeypatch: pytest.MonkeyPatch) -> None:
    """Times broadcast with positions, and what elements need as proof is known of all samples."""
    elements = [cd.JointSpring("bearing_out", 5.0, 0.1), cd.Actuator("bearing_out", np.sin)]
    held, where = {"joint_angle": 0.5}, np.linspace(0.0, 6.0, 40)[:, None]
    times = np.linspace(0.0, 1.0, 9)
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held=held, elements=elements)
    scene.sweep(where, speed=3.0, time=times)  # All that is learned of the motion.
    whole = scene.sweep(where, speed=3.0, time=times)
    monkeypatch.setattr(problem_solver, "LARGE_BLOCK", 32)
    parts = scene.sweep(where, speed=3.0, time=times)
    np.testing.assert_allclose(parts.drive_effort, whole.drive_effort, rtol=0.0, atol=1e-12)
    assert parts.balance_residual == pytest.approx(whole.balance_residual, abs=1e-14)
    assert parts.power_residual == pytest.approx(whole.power_residual, abs=1e-14)
