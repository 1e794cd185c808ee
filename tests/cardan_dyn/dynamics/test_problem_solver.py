"""The problem solver: blocks of samples, what it shares and refuses, copies of it."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from testkit.alone import without_tapes
from testkit.claims import acting, coupled_wheels, four_bar, positions, universal
from testkit.planar_linkages import three_cranks

import cardan_dyn as cd
from cardan_dyn.core.dynamics import problem_solver
from cardan_dyn.core.dynamics.inverse_dynamics import Solution
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.dynamics.taped import TapedSolver
from cardan_dyn.core.elements.link_loads import WRENCH_COMPONENTS
from cardan_dyn.core.problem.samples import Targets


def solver(scene: cd.Scene) -> ProblemSolver:
    """Return a solver of the scene's problem that shares nothing with it."""
    return ProblemSolver(scene.problem)


def rates(where: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.full_like(where, 3.0), np.full_like(where, -1.0)


def test_a_solution_in_blocks_is_that_in_one(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = four_bar()
    where = positions(scene)
    item = solver(scene)
    whole = item.solve(item.assemble(Targets.of_positions(where)), acting(item, *rates(where)))
    monkeypatch.setattr(problem_solver, "LARGE_BLOCK", 8)
    assembled = item.assemble(Targets.of_positions(where))
    # Blocks of equal size: 30 samples in four blocks of seven or eight.
    sizes = [span.stop - span.start for span in assembled.spans]
    assert sizes == [7, 8, 7, 8]
    assert [len(block.x) for block in assembled.blocks] == sizes
    assert assembled.spans[0].start == 0
    assert [span.start for span in assembled.spans[1:]] == [
        span.stop for span in assembled.spans[:-1]
    ]
    blocked = item.solve(assembled, acting(item, *rates(where)))
    for name in ("x", "v", "a", "wrenches", "efforts"):
        expected = getattr(whole, name)
        scale = np.max(np.abs(expected))
        np.testing.assert_allclose(getattr(blocked, name), expected, rtol=0.0, atol=1e-11 * scale)


def test_loads_that_vary_are_divided_among_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The torque of a crank without mass is its varying load, at every sample."""
    count = 30
    load = np.linspace(-1.0, 2.0, count)
    wrench = np.zeros((count, 6))
    wrench[:, 5] = load**2
    pendulum = """<robot name="arm"><link name="base"/><link name="arm"/>
      <joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>
        <axis xyz="0 0 1"/></joint></robot>"""
    scene = cd.Scene(cd.load(pendulum), drive="hinge", loads={"hinge": load, "arm": wrench})
    monkeypatch.setattr(problem_solver, "LARGE_BLOCK", 8)
    item, where = solver(scene), np.linspace(0.0, 1.0, count)[:, None]
    solution = item.solve(
        item.assemble(Targets.of_positions(where)), acting(item, 0.0 * where, 0.0 * where)
    )
    np.testing.assert_allclose(solution.efforts[:, 0], -load - load**2, atol=1e-14)
    with pytest.raises(cd.ArgumentError, match=r"position \(7,\), loads\['hinge'\] \(30,\)"):
        scene.sweep(where[:7, 0])


def test_positions_that_are_closed_in_turn_are_closed_whenever_they_are_read() -> None:
    scene = four_bar()
    item, where = solver(scene), positions(scene)
    in_turn = item.assembled_in_turn(Targets.of_positions(where))
    kept = item.assemble(Targets.of_positions(where))
    assert len(in_turn) == len(kept) == len(where)
    states = list(in_turn.blocks)
    assert in_turn.blocks[0] is not in_turn.blocks[0]
    assert kept.blocks[0] is kept.blocks[0]
    assert len(list(kept.blocks)) == len(list(kept.blocks)) == len(states)
    for state, other in zip(states, kept.blocks, strict=True):
        np.testing.assert_array_equal(state.x, other.x)


def test_assembled_positions_cannot_be_written_and_are_named() -> None:
    assembled = solver(four_bar()).assemble(Targets.of_positions(np.array([[0.5], [0.6]])))
    assert repr(assembled) == "<2 assembled positions of 'four_bar'>"
    for array in (assembled.targets.positions, assembled.turns):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0


def test_copies_of_assembled_positions_are_closed_anew() -> None:
    assembled = solver(four_bar()).assemble(Targets.of_positions(np.array([[0.5], [0.6]])))
    restored = pickle.loads(pickle.dumps(assembled))
    assert restored.solver is not assembled.solver
    np.testing.assert_array_equal(restored.targets.positions, assembled.targets.positions)
    for state, other in zip(assembled.blocks, restored.blocks, strict=True):
        np.testing.assert_allclose(other.x, state.x, atol=1e-13)


def test_copies_of_a_solver_solve_the_same_problem() -> None:
    item = solver(four_bar())
    for restored in (copy.copy(item), copy.deepcopy(item), pickle.loads(pickle.dumps(item))):
        assert restored is not item
        assert restored.problem.drives == item.problem.drives
        assert restored.problem.mechanism.name == "four_bar"
    with pytest.raises(cd.ImmutableError):
        item.problem = None  # type: ignore[assignment]


def test_positions_of_another_solver_are_refused() -> None:
    first, second = solver(four_bar()), solver(four_bar())
    assembled = first.assemble(Targets.of_positions(np.array([[0.5]])))
    first.refuse_others(assembled)
    with pytest.raises(cd.ArgumentError, match="assembled by another scene; assemble them again"):
        second.refuse_others(assembled)


def test_what_is_redundant_does_not_depend_on_what_was_asked_for() -> None:
    """Of linkages that only their lengths let move, single positions say little."""
    scene = cd.Scene(three_cranks(), drive="A", loads={"D": -1.0})
    assembled = scene.assemble([0.05, 0.1])
    expected = scene.sweep(assembled).drive_effort
    known = scene.solver.assembly.kinematics.reductions
    scene.sweep(np.linspace(-0.5, 0.9, 40))
    assert scene.solver.assembly.kinematics.reductions is known
    np.testing.assert_allclose(scene.sweep(assembled).drive_effort, expected, rtol=1e-9)
    np.testing.assert_allclose(expected, 1.0, rtol=1e-9)


def test_similar_problems_share_the_assembly() -> None:
    scene = four_bar()
    first = solver(scene)
    same_motion = scene.replace(gravity=(0.0, 0.0, 0.0), loads={"rocker_bearing": 7.0})
    assert ProblemSolver(same_motion.problem, like=first).assembly is first.assembly
    assert ProblemSolver(same_motion.problem).assembly is not first.assembly
    fewer_outputs = scene.replace(outputs=["crank_bearing"])
    assert ProblemSolver(fewer_outputs.problem, like=first).assembly is not first.assembly


def test_solved_couplings_and_known_efforts() -> None:
    wheels = solver(coupled_wheels())
    assert wheels.couplings == {0: "mesh"}
    assert wheels.has_mass
    assert all(wheels.knows_effort(name) for name in ("in", "swing"))
    alone = solver(universal(outputs=[]))
    assert alone.couplings == {}
    # Virtual work gives the efforts of drives, not of held joints.
    assert alone.knows_effort("bearing_in")
    assert not alone.knows_effort("joint_angle")


UNIQUE = np.array([[True] * 6, [True, False, True, True, True, False]])


def test_indeterminate_outputs_of_strict_problems_are_refused() -> None:
    options = {"outputs": ["crank_bearing", "rocker_bearing"]}
    strict = solver(four_bar(strict=True, **options))
    strict.refuse_indeterminate(np.ones((2, 6), dtype=bool))
    message = "four_bar: the laws of motion leave open: rocker_bearing: force y, moment z. Give"
    with pytest.raises(cd.IndeterminateError, match=message) as caught:
        strict.refuse_indeterminate(UNIQUE)
    assert caught.value.components == {"rocker_bearing": ["force y", "moment z"]}
    with pytest.raises(cd.IndeterminateError, match="crank_bearing: moment z; rocker_bearing: f"):
        strict.refuse_indeterminate(UNIQUE & np.array([True] * 5 + [False]))
    names = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
    assert names == WRENCH_COMPONENTS


@pytest.mark.parametrize(
    "options", [{}, {"strict": True, "compliance": {"crank_bearing": np.ones(6)}}]
)
def test_problems_with_a_rule_accept_indeterminate_outputs(options: dict[str, object]) -> None:
    item = solver(four_bar(outputs=["crank_bearing", "rocker_bearing"], **options))
    item.refuse_indeterminate(UNIQUE)


@pytest.mark.parametrize("is_taped", [True, False])
def test_what_is_solved_is_proven(is_taped: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without closure forces, loads and weights are not in balance: on tapes and alone."""
    if not is_taped:
        without_tapes(monkeypatch)
    scene = four_bar()
    item, where = solver(scene), positions(scene)
    assembled = item.assemble(Targets.of_positions(where))
    roles = item.taped._roles
    blocks = tuple(block._replace(is_balanced=False) for block in roles.blocks)
    item.taped._roles = roles._replace(blocks=blocks)
    with pytest.raises(cd.AccuracyError, match="please report"):
        item.solve(assembled, acting(item, *rates(where)))


@pytest.mark.parametrize("is_taped", [True, False])
def test_flags_of_what_is_solved_are_proven(
    is_taped: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A planar four-bar does not determine its forces out of the plane."""
    if not is_taped:
        without_tapes(monkeypatch)
    scene = four_bar()
    item, where = solver(scene), positions(scene)
    assembled = item.assemble(Targets.of_positions(where))

    def flagged(found: Callable[..., Solution]) -> Callable[..., Solution]:
        def solved(*arguments: Any) -> Solution:
            solution = found(*arguments)
            return solution._replace(influence=np.zeros_like(solution.influence))

        return solved

    monkeypatch.setattr(TapedSolver, "solution", flagged(TapedSolver.solution))
    with pytest.raises(cd.AccuracyError, match="flagged unique, but changes"):
        item.solve(assembled, acting(item, *rates(where)))
