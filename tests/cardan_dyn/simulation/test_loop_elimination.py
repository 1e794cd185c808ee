"""Loop elimination: as exact as all equations at once, at a cost linear in the number of loops."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio
import pytest
from testkit.rows_of_loops import parallelograms, spatial, tower

import cardan_dyn as cd
from cardan_dyn.mechanism.welds import constraint_models
from cardan_dyn.simulation.closed_directions import ClosedDirections, rank_of
from cardan_dyn.simulation.loop_elimination import LoopElimination
from cardan_dyn.simulation.turning_model import turning_model

GRAVITY = np.array([0.3, -9.81, 0.2])
Array = np.ndarray


class Linkage:
    """A row of loops that is closed and moves, solved in both ways."""

    def __init__(self, mechanism: cd.Mechanism, state: Array, held: int | None = None) -> None:
        self.model = turning_model(mechanism, GRAVITY)
        nv = self.model.nv
        prescribed = np.array([] if held is None else [held], dtype=int)
        self.heavy = np.zeros(nv)
        self.heavy[prescribed] = 1e15
        self.model.armature = self.heavy
        constraints = constraint_models(self.model, mechanism.loops)
        none = np.zeros((0, nv))
        every = ClosedDirections(self.model, constraints, none, prescribed, rank=nv)
        rows = every.jacobian(state)[:, every.free]
        weighted = np.linalg.solve(np.linalg.cholesky(every.metric(state)), rows.T)
        values = np.linalg.svd(weighted, compute_uv=False)
        self.rank = rank_of(values)
        self.at_once = ClosedDirections(self.model, constraints, none, prescribed, rank=self.rank)
        data, least = self.model.createData(), float(values[self.rank - 1]) ** 2
        self.in_turn = LoopElimination(self.model, data, constraints, least)
        random = np.random.default_rng(3)
        self.x, self.v = self.at_once.closed(state, random.normal(size=nv))
        self.efforts = random.normal(size=nv)
        self.efforts[prescribed] = 0.0

    def displaced(self, size: float) -> Array:
        """Return a configuration whose loops are open."""
        way = np.random.default_rng(4).normal(size=self.model.nv)
        way[self.heavy > 0.0] = 0.0
        return np.asarray(pinocchio.integrate(self.model, self.x, size * way))


def _closed(mechanism: cd.Mechanism, drives: str | list[str], positions: Array) -> Array:
    motion = cd.Scene(mechanism, drive=drives, outputs=[]).sweep(positions).motion
    named = mechanism.coordinates.named
    return np.array([motion.position(name)[0] for name in sorted(named, key=_column(mechanism))])


def _column(mechanism: cd.Mechanism) -> Callable[[str], int]:
    return lambda name: mechanism.coordinates.named[name].column


def _parallelograms(count: int) -> Linkage:
    mechanism = parallelograms(count)
    return Linkage(mechanism, _closed(mechanism, "pivot_0", np.array([0.4])))


def _tower(count: int, held: int | None = None) -> Linkage:
    mechanism = tower(count)
    drives = [f"left_joint_{k}" for k in range(count)]
    angles = np.array([[0.3 * (-1) ** k for k in range(count)]])
    return Linkage(mechanism, _closed(mechanism, drives, angles), held)


def _held(count: int) -> Linkage:
    return _tower(count + 1, held=0)


LINKAGES = [_parallelograms, _held, _tower]


@pytest.mark.parametrize("count", [1, 3, 20])
@pytest.mark.parametrize("made", LINKAGES)
def test_accelerations_are_those_of_all_equations_at_once(
    made: Callable[[int], Linkage], count: int
) -> None:
    linkage = made(count)
    told = np.zeros(int(np.count_nonzero(linkage.heavy)))
    state = linkage.x, linkage.v, linkage.efforts
    for _ in range(2):  # The second call must not see the first one.
        found = linkage.in_turn.accelerations(*state)
        assert found is not None
        expected = linkage.at_once.forced(*state, told)
        size = np.max(np.abs(expected))
        np.testing.assert_allclose(found, expected, atol=3e-12 * size, rtol=0.0)


@pytest.mark.parametrize("made", LINKAGES)
def test_what_drifted_is_closed_as_nearly_as_by_all_equations(
    made: Callable[[int], Linkage],
) -> None:
    linkage = made(16)
    x, v = linkage.displaced(1e-6), linkage.v + 1e-6 * linkage.efforts
    found = linkage.in_turn.displacement(x)
    assert found is not None
    step, gap = found
    assert 1e-7 < gap < 1e-4
    closed = np.asarray(pinocchio.integrate(linkage.model, x, step))
    again = linkage.in_turn.displacement(closed)
    assert again is not None
    assert again[1] < 1e-9
    change = linkage.in_turn.slowing(closed, v)
    assert change is not None
    expected, slowed = linkage.at_once.closed(x, v)
    np.testing.assert_allclose(closed, expected, atol=1e-9)
    np.testing.assert_allclose(v + change, slowed, atol=1e-9)
    assert np.max(np.abs(linkage.at_once.jacobian(closed) @ (v + change))) < 1e-12


def test_weak_closures_are_left_to_all_equations() -> None:
    # All bars are in line at a right angle.
    mechanism = parallelograms(16)
    linkage = _parallelograms(16)
    flat = _closed(mechanism, "pivot_0", np.array([np.pi / 2 - 1e-5]))
    moving = np.random.default_rng(5).normal(size=flat.size)
    assert linkage.in_turn.accelerations(flat, moving, linkage.efforts) is None
    assert linkage.in_turn.accelerations(linkage.x, linkage.v, linkage.efforts) is not None


def test_nothing_moves_where_nothing_acts() -> None:
    mechanism = parallelograms(13)
    scene = cd.Scene(mechanism, free="pivot_0", outputs=[])
    still = scene.simulate(1.0, position=0.4, method="DOP853")
    np.testing.assert_array_equal(still.speed, 0.0)
    # Rounding of the start is a gap, which is closed.
    np.testing.assert_allclose(still.position, 0.4, rtol=0.0, atol=1e-15)


def test_states_beyond_all_numbers_are_left_as_well() -> None:
    linkage = _parallelograms(3)
    beyond = np.full(linkage.model.nv, np.nan)
    assert linkage.in_turn.accelerations(linkage.x, beyond, linkage.efforts) is None
    assert linkage.in_turn.displacement(beyond) is None
    assert linkage.in_turn.slowing(linkage.x, beyond) is None


@pytest.mark.parametrize("made", [parallelograms, spatial])
def test_simulations_of_many_loops_take_no_more_calls_per_step_than_of_few(
    made: Callable[[int], cd.Mechanism], monkeypatch: pytest.MonkeyPatch
) -> None:
    def counted(count: int) -> tuple[float, int]:
        calls = {"lcaba": 0, "constraintDynamics": 0}
        with monkeypatch.context() as patched:
            for name in calls:
                called = getattr(pinocchio, name)

                def noted(
                    *given: object, name: str = name, called: Callable[..., object] = called
                ) -> object:
                    calls[name] += 1
                    return called(*given)

                patched.setattr(pinocchio, name, noted)
            scene = cd.Scene(made(count), free="pivot_0", gravity=(0, -9.81, 0), outputs=[])
            trajectory = scene.simulate(0.3, position=0.4, method="DOP853", rtol=1e-9)
            begun = calls["constraintDynamics"]
            trajectory.at([0.1, 0.2])
        assert calls["constraintDynamics"] == begun <= 1
        assert trajectory.energy_residual < 1e-8
        assert np.max(trajectory.loop_residual) < 1e-12
        return calls["lcaba"] / trajectory.evaluations, len(trajectory.time)

    (few, steps), (many, more_steps) = counted(16), counted(32)
    assert few < 2.5
    assert many < 3.5
    assert more_steps <= steps + 2


def test_free_motion_of_many_loops_needs_no_effort() -> None:
    scene = cd.Scene(parallelograms(16), free="pivot_0", gravity=(0, -9.81, 0))
    trajectory = scene.simulate(0.5, position=0.4, method="DOP853", rtol=1e-10)
    assert trajectory.effort_residual < 1e-12
