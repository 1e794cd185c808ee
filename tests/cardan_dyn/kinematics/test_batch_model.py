"""Batches of bodies against plain Pinocchio, and long chains against both."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.kinematics.closing import batch_model
from cardan_dyn.kinematics.closing.batch_model import (
    BaseMotion,
    BatchModel,
    LongChain,
    UnitTwists,
    placement,
)

ORIGIN = np.array([0.3, -0.7, 1.1])
COUNT = 4

KINDS = {"batch": BatchModel, "long chain": LongChain}


@pytest.fixture(scope="module", params=["mixed", "thoma_rig", "stewart_platform", "ring_joint"])
def mechanism(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load(MIXED if request.param == "mixed" else request.param)


@pytest.fixture(params=KINDS)
def batch(
    request: pytest.FixtureRequest, mechanism: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> BatchModel:
    # However short the chain is, its own recursions place its bodies.
    monkeypatch.setattr(batch_model, "_MOST_PLACED", 0)
    bodies = list(range(mechanism.model.njoints - 1))
    return KINDS[request.param](mechanism, bodies, set(bodies), ORIGIN)


def rates(mechanism: cd.Mechanism) -> tuple[np.ndarray, np.ndarray]:
    v, a = np.random.default_rng(3).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    return v, a


def shifted(frame: pinocchio.SE3) -> pinocchio.SE3:
    return pinocchio.SE3(frame.rotation, frame.translation - ORIGIN)


def test_actions_are_those_of_placements(mechanism: cd.Mechanism, batch: BatchModel) -> None:
    x, data = rows(mechanism, COUNT), mechanism.model.createData()
    actions = batch.actions(x)
    assert actions.shape == (COUNT, 6 * len(batch), 6)
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(mechanism.model, data, q)
        for body in range(len(batch)):
            frame = shifted(data.oMi[body + 1])
            block = actions[sample, 6 * body : 6 * body + 6]
            np.testing.assert_allclose(block, frame.action.T, atol=1e-12)
            rotation, position = placement(actions, body)
            np.testing.assert_allclose(rotation[:, :, sample], frame.rotation, atol=1e-12)
            np.testing.assert_allclose(position[:, sample], frame.translation, atol=1e-12)


def test_closing_loops_makes_no_data_of_free_flyers() -> None:
    """They grow with the third power of six times the bodies, and take longer than all else."""
    mechanism = cd.load("stewart_platform")
    scene = cd.Scene(mechanism, drive=[f"leg_{index}" for index in range(1, 7)])
    (solver,) = scene.solver.assembly.kinematics.solvers
    assert len(solver.batch) == mechanism.model.njoints - 1
    for speed in (0.0, 0.1):
        scene.sweep(np.linspace(0.0, 0.01, 300)[:, None] * np.ones(6), speed=speed)
        (calls,) = vars(solver.batch._of_thread).values()
        assert calls.copies == 1
        assert calls.data.J.shape[1] == mechanism.model.nv
        assert calls.placements.shape == (len(solver.batch), 12)
        assert calls.forces.shape == (len(solver.batch), 6)


def test_wrenches_are_those_of_the_open_tree(mechanism: cd.Mechanism, batch: BatchModel) -> None:
    x, (v, a) = rows(mechanism, COUNT), rates(mechanism)
    model = mechanism.model.copy()
    model.gravity.linear = np.zeros(3)
    for index in mechanism.auxiliary_bodies:
        model.inertias[index] = pinocchio.Inertia.Zero()
    data = model.createData()
    found, _ = batch.inverse_dynamics(BaseMotion(*np.zeros((2, COUNT, 6))), x, v, a)
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.rnea(model, data, q, v[sample], a[sample])
        expected = np.array([data.f[index].vector for index in range(1, model.njoints)])
        scale = np.max(np.abs(expected))
        np.testing.assert_allclose(found[sample], expected, rtol=0.0, atol=1e-12 * scale)


def test_many_samples_at_once_are_those_one_by_one(mechanism: cd.Mechanism) -> None:
    """To the last bit: so results do not depend on how samples are divided into blocks."""
    bodies = list(range(mechanism.model.njoints - 1))
    batch = BatchModel(mechanism, bodies, set(bodies), ORIGIN)
    count = batch_model._FEWEST_TOGETHER + 1
    x, random = rows(mechanism, count), np.random.default_rng(5)
    v, a = random.normal(size=(2, count, mechanism.model.nv))
    base = BaseMotion(*random.normal(size=(2, count, 6)))

    def found(samples: slice) -> list[np.ndarray]:
        own = BaseMotion(base.twist[samples], base.acceleration[samples])
        given = x[samples], v[samples], a[samples]
        return [
            batch.actions(x[samples]),
            *batch.inverse_dynamics(own, *given),
        ]

    at_once = found(slice(None))
    for k in range(count):
        for whole, one in zip(at_once, found(slice(k, k + 1)), strict=True):
            np.testing.assert_array_equal(whole[k], one[0])


def test_gravity_is_that_of_each_sample(mechanism: cd.Mechanism, batch: BatchModel) -> None:
    x, (v, a) = rows(mechanism, COUNT), rates(mechanism)
    model = mechanism.model.copy()
    for index in mechanism.auxiliary_bodies:
        model.inertias[index] = pinocchio.Inertia.Zero()
    data, several = model.createData(), np.random.default_rng(7).normal(size=(COUNT, 3))
    for gravity in (several, several[:1]):
        base = BaseMotion.against(gravity, COUNT)
        found, _ = batch.inverse_dynamics(base, x, v, a)
        for sample, q in enumerate(mechanism.coordinates.configuration(x)):
            model.gravity.linear = gravity[sample % len(gravity)]
            pinocchio.rnea(model, data, q, v[sample], a[sample])
            expected = np.array([data.f[index].vector for index in range(1, model.njoints)])
            scale = np.max(np.abs(expected))
            np.testing.assert_allclose(found[sample], expected, rtol=0.0, atol=1e-12 * scale)


@pytest.mark.parametrize("name", ["universal_joint", "double_shaft_z", "stewart_platform"])
def test_a_call_is_for_several_samples_of_few_bodies(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mechanism = cd.load(name)
    bodies, count = list(range(mechanism.model.njoints - 1)), 1000
    batch = BatchModel(mechanism, bodies, set(bodies), ORIGIN)
    counted = {"forwardKinematics": 0}
    for function in counted:
        plain = getattr(pinocchio, function)

        def counting(*arguments: object, plain=plain, function=function) -> object:  # type: ignore[no-untyped-def]
            counted[function] += 1
            return plain(*arguments)

        monkeypatch.setattr(pinocchio, function, counting)
    batch.actions(rows(mechanism, count))
    copies = {"universal_joint": 6, "double_shaft_z": 3, "stewart_platform": 1}[name]
    assert set(counted.values()) == {count // copies + count % copies}


def test_unit_twists_are_the_jacobian(mechanism: cd.Mechanism) -> None:
    bodies = list(range(mechanism.model.njoints - 1))
    batch = BatchModel(mechanism, bodies, set(), np.zeros(3))
    x, data = rows(mechanism, COUNT), mechanism.model.createData()
    every = np.arange(mechanism.model.nv)
    actions = batch.actions(x)
    for chosen in (every, every[::2]):
        found = UnitTwists(batch, chosen).of(actions)
        for sample, q in enumerate(mechanism.coordinates.configuration(x)):
            jacobian = pinocchio.computeJointJacobians(mechanism.model, data, q)
            np.testing.assert_allclose(found[sample], jacobian[:, chosen].T, atol=1e-12)


def test_some_bodies_of_a_mechanism() -> None:
    mechanism = cd.load(MIXED)
    ids = {name: mechanism[name].id - 1 for name in mechanism}
    bodies = [ids["turn"], ids["slide"], ids["swing"]]
    batch = BatchModel(mechanism, bodies, {ids["swing"]}, ORIGIN)
    assert len(batch) == 3
    assert batch.index_of == {body: index for index, body in enumerate(bodies)}
    assert batch.parents.tolist() == [-1, 0, 1]
    np.testing.assert_allclose(batch.mass, [0.0, 0.0, 2.0])
    assert batch.has_mass
    assert not BatchModel(mechanism, bodies, set(), ORIGIN).has_mass
    columns = mechanism.coordinates.velocity_columns
    expected = np.full(mechanism.model.nv, -1)
    for index, name in enumerate(("turn", "slide", "swing")):
        expected[columns[name]] = index
    np.testing.assert_array_equal(batch.moved_body, expected)
    np.testing.assert_array_equal(batch.subspace[columns["slide"]], [[0.6, 0.0, 0.8, 0, 0, 0]])
    np.testing.assert_array_equal(batch.subspace[columns["turn"]], [[0, 0, 0, 0.36, 0.48, 0.8]])
    assert not np.any(batch.subspace[columns["ball"]])
