"""Chains and trees of many drives: exact, and no larger than their parts."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pinocchio
import pytest
from testkit.many_drives import cranks, on_arms, stacked, tree

import cardan_dyn as cd
from cardan_dyn.core.kinematics import loop_system

GRAVITY = (1.0, -2.0, -9.0)


def moved(mechanism: cd.Mechanism, **options: object) -> cd.Sweep:
    drives = cranks(mechanism)
    rng = np.random.default_rng(0)
    positions = rng.uniform(-0.3, 0.3, (5, len(drives)))
    scene = cd.Scene(mechanism, drive=drives, gravity=GRAVITY, **options)
    speeds, accelerations = rng.normal(size=(2, 5, len(drives)))
    return scene.sweep(positions, speed=speeds, acceleration=accelerations)


@pytest.mark.parametrize("build", [stacked, tree, on_arms])
def test_groups_on_moving_bases_are_those_of_one_group(
    build: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One group of all loops carries all bodies from the world; its wrenches are the same."""
    mechanism = build(4)  # type: ignore[operator]
    link = "rocker_link_3"
    loads = {
        "rocker_2": 3.0,
        link: cd.Wrench([1.0, 2.0, 3.0], [0.5, 0.0, 1.0], frame="world"),
        "crank_link_1": [1.0, 0.0, 2.0, 0.0, 3.0, 0.0],
    }
    sweep = moved(mechanism, loads=loads)
    real = loop_system.partition
    monkeypatch.setattr(loop_system, "partition", lambda *args: real(*args, together=True))
    whole = moved(mechanism, loads=loads)
    assert len(whole) == len(sweep) == 5
    for name in mechanism:
        size = np.max(np.abs(whole[name].moment)) + np.max(np.abs(whole[name].force))
        for part in ("force", "moment"):
            first, second = getattr(sweep[name], part), getattr(whole[name], part)
            np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-11 * size)
        np.testing.assert_array_equal(sweep[name].unique, whole[name].unique)
        for drive in cranks(mechanism):
            np.testing.assert_allclose(
                sweep.motion.ratio(name, drive), whole.motion.ratio(name, drive), atol=1e-11
            )
    np.testing.assert_allclose(sweep.drive_effort, whole.drive_effort, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("build", [stacked, tree, on_arms])
def test_accelerations_are_those_that_pinocchio_finds(build: object) -> None:
    """Under the drives' efforts, Pinocchio's constrained dynamics accelerates as was prescribed."""
    mechanism = build(3)  # type: ignore[operator]
    sweep = moved(mechanism)
    model = mechanism.model.copy()
    model.gravity.linear = np.array(GRAVITY)
    data, welds = model.createData(), mechanism.constraint_models
    constraint_data = pinocchio.StdVec_RigidConstraintData()
    for weld in welds:
        constraint_data.append(weld.createData())
    pinocchio.initConstraintDynamics(model, data, welds, constraint_data)
    settings = pinocchio.ProximalSettings(1e-13, 1e-9, 30)
    columns = [mechanism.coordinates.velocity_columns[name].start for name in cranks(mechanism)]
    for sample in range(len(sweep)):
        efforts = np.zeros(model.nv)
        efforts[columns] = sweep.drive_effort[sample]
        a = pinocchio.constraintDynamics(
            model,
            data,
            sweep.motion.q[sample],
            sweep.motion.v[sample],
            efforts,
            welds,
            constraint_data,
            settings,
        )
        np.testing.assert_allclose(a, sweep.motion.a[sample], rtol=0.0, atol=1e-6)


@pytest.mark.slow
def test_models_are_as_small_as_their_loops() -> None:
    """Pinocchio's data grow with the third power of a model's bodies, so no model has many."""
    for mechanism in (stacked(40), tree(31), on_arms(20)):
        scene = cd.Scene(mechanism, drive=cranks(mechanism))
        solvers = scene.solver.assembly.kinematics.solvers
        assert max(len(solver.group.bodies) for solver in solvers) <= 8
        bodies = sum(len(solver.group.bodies) for solver in solvers)
        assert bodies < 1.2 * mechanism.model.njoints


@pytest.mark.slow
@pytest.mark.campaign
def test_memory_of_many_drives() -> None:
    """A hundred drives: what is kept and what is needed on the way, Pinocchio's data aside."""
    mechanism = stacked(100)
    tracemalloc.start()
    sweep = moved(mechanism)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert sweep.balance_residual < 1e-13
    # Nearly all of it is for a moment: tracing what statics leaves open of loops that stand on each
    # other grows with the square of their number. Without that, 80 MB are enough.
    assert peak < 0.6e9


@pytest.mark.slow
def test_velocity_ratios_that_are_zero_are_not_kept() -> None:
    sweep = moved(stacked(8))
    assert sweep.motion.velocity_ratios.values.shape[1] == 4 * 8
    assert not np.any(sweep.motion.ratio("rocker_3", "crank_2"))
    assert np.all(sweep.motion.ratio("rocker_3", "crank_3"))
