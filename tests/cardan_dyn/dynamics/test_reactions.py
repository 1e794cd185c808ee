"""Reactions as external forces on Pinocchio's tree, their efforts, and what they leave open."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.claims import SCENES, positions
from testkit.drive_lines import drive_line
from testkit.linkages import coupling, gears
from testkit.mixed_chain import MIXED

import cardan_dyn as cd
from cardan_dyn.dynamics.open_tree import LoadCase
from cardan_dyn.dynamics.reactions import (
    UNIQUE_TOLERANCE,
    Reactions,
    ReactionSolver,
    superposed,
    wrenches_in_norm,
)
from cardan_dyn.kinematics.closing.all_groups import ClosedState

COUNT = 4
GRAVITY = np.array([1.0, -2.0, -9.81])
SPEED, ACCELERATION = 3.0, 2.0


def line() -> cd.Scene:
    """A line of joints whose loops are solved one after the other."""
    return cd.Scene(cd.load(drive_line(3)), drive="bearing_0")


def gear_train() -> cd.Scene:
    """Two couplings, of which the second one loads the first."""
    couplings = coupling("g", "a", "b", -3.0), coupling("h", "b", "c", 0.5)
    return cd.Scene(cd.load(gears(*couplings, third=True)), drive="a")


ALL_SCENES = {**SCENES, "line": line, "gear train": gear_train}


@pytest.fixture(scope="module", params=ALL_SCENES)
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return ALL_SCENES[request.param]()


def closed(scene: cd.Scene) -> ClosedState:
    (state,) = scene.assemble(positions(scene)[:COUNT]).blocks
    return state


def rates(scene: cd.Scene, state: ClosedState) -> tuple[np.ndarray, np.ndarray]:
    kinematics = scene.solver.assembly.kinematics
    shape = (COUNT, len(scene.drives))
    v = kinematics.rates(state, np.full(shape, SPEED))
    return v, kinematics.accelerations(state, v, np.full(shape, ACCELERATION))


def load_case(scene: cd.Scene, state: ClosedState, gravity: np.ndarray = GRAVITY) -> LoadCase:
    loads = np.random.default_rng(1).normal(size=(COUNT, scene.mechanism.model.nv))
    return LoadCase(rates(scene, state), loads, [], gravity[None])


def solver(scene: cd.Scene) -> ReactionSolver:
    kinematics = scene.solver.assembly.kinematics
    return ReactionSolver(scene.mechanism, kinematics, set(range(len(kinematics.solvers))))


def loaded_tree(
    scene: cd.Scene, state: ClosedState, case: LoadCase, reactions: Reactions
) -> tuple[np.ndarray, np.ndarray]:
    """Return joint wrenches `(N, n, 6)` and efforts `(N, nv)` of the tree under closure forces."""
    mechanism = scene.mechanism
    model = mechanism.model.copy()
    (model.gravity.linear,) = case.gravity
    for index in mechanism.auxiliary_bodies:
        model.inertias[index] = pinocchio.Inertia.Zero()
    batches = {loop: group.batch for group in state.groups for loop in group.group.loops}
    assert case.dynamics is not None
    data, (v, a) = model.createData(), case.dynamics
    wrenches, efforts = np.empty((COUNT, model.njoints - 1, 6)), np.empty((COUNT, model.nv))
    for sample, q in enumerate(mechanism.coordinates.configuration(state.x)):
        pinocchio.forwardKinematics(model, data, q)
        external = [pinocchio.Force.Zero() for _ in range(model.njoints)]
        for index, loop in enumerate(mechanism.loops):
            force = pinocchio.Force(reactions.closure_forces[index][sample].copy())
            base = data.oMi[batches[index].base + 1]
            force = base.act(pinocchio.SE3(np.eye(3), batches[index].origin).act(force))
            external[loop.successor] += data.oMi[loop.successor].actInv(force)
            external[loop.predecessor] -= data.oMi[loop.predecessor].actInv(force)
        forces = pinocchio.StdVec_Force()
        forces.extend(external)
        efforts[sample] = pinocchio.rnea(model, data, q, v[sample], a[sample], forces)
        wrenches[sample] = [data.f[index].vector for index in range(1, model.njoints)]
    for index, item in enumerate(mechanism.couplings):
        moment = reactions.closure_forces[len(mechanism.loops) + index]
        efforts[:, item.successor_columns] -= moment
        efforts[:, item.predecessor_columns] += item.ratio * moment
    return wrenches, efforts


def test_closure_forces_leave_the_loads_to_the_passive_joints(scene: cd.Scene) -> None:
    """Under them Pinocchio's tree moves as it does with nothing but loads and drive efforts."""
    state, item = closed(scene), solver(scene)
    case = load_case(scene, state)
    (reactions,) = item.solve(state, [case])
    wrenches, efforts = loaded_tree(scene, state, case, reactions)
    scale = np.max(np.abs(wrenches))
    bodies = wrenches.shape[1]
    assert reactions.wrenches.shape == (COUNT, item.size, 6)
    assert np.max(np.abs(reactions.wrenches[:, :bodies] - wrenches)) < 1e-11 * scale
    assert np.max(np.abs(item.efforts(reactions) - efforts)) < 1e-11 * scale
    passives = scene.problem.passive_columns
    assert np.max(np.abs((efforts - case.loads)[:, passives])) < 1e-11 * scale


def test_drive_efforts_are_those_of_virtual_work(scene: cd.Scene) -> None:
    """Energy theorem of the tree: joint efforts times rates, with the closure forces cut."""
    state, item = closed(scene), solver(scene)
    case = load_case(scene, state)
    (reactions,) = item.solve(state, [case])
    exerted = item.efforts(reactions) - case.loads
    assert case.dynamics is not None
    v, a = case.dynamics
    model = scene.mechanism.model.copy()
    (model.gravity.linear,) = case.gravity
    for index in scene.mechanism.auxiliary_bodies:
        model.inertias[index] = pinocchio.Inertia.Zero()
    data = model.createData()
    q = scene.mechanism.coordinates.configuration(state.x)
    tree = np.array([pinocchio.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
    power = np.sum((tree - case.loads) * v, axis=1)
    np.testing.assert_allclose(np.sum(exerted * v, axis=1), power, rtol=1e-9)


def test_cases_are_solved_together_and_superposed(scene: cd.Scene) -> None:
    """Reactions are linear in the loads, so the reactions to several loads add up."""
    state, item = closed(scene), solver(scene)
    moving = load_case(scene, state)
    loads = np.random.default_rng(2).normal(size=(1, scene.mechanism.model.nv))
    loaded = LoadCase(None, loads, [], np.zeros((1, 3)))
    both = item.solve(state, [moving, loaded])
    whole = moving._replace(loads=moving.loads - 3.0 * loads)
    for reactions, case in (
        (both[0], moving),
        (both[1], loaded),
        (superposed(both, [1.0, -3.0]), whole),
    ):
        (alone,) = item.solve(state, [case])
        scale = np.max(np.abs(alone.wrenches))
        for actual, expected in zip(
            (reactions.wrenches, *reactions.closure_forces),
            (alone.wrenches, *alone.closure_forces),
            strict=True,
        ):
            np.testing.assert_allclose(actual, expected, rtol=0.0, atol=1e-11 * scale)
        np.testing.assert_array_equal(reactions.influence, alone.influence)
        assert reactions.indeterminate_couplings == alone.indeterminate_couplings


@pytest.mark.parametrize("name", ["universal", "four-bar"])
def test_the_least_norm_is_orthogonal_to_every_self_stress(name: str) -> None:
    """Otherwise some amount of one of them would make the norm smaller."""
    scene = SCENES[name]()
    state, item = closed(scene), solver(scene)
    (reactions,) = item.solve(state, [load_case(scene, state)])
    length = scene.mechanism.characteristic_length
    squares = np.repeat([length**2, 1.0], 3)
    stresses = [stress for group in state.groups for stress in item._closure.self_stresses(group)]
    assert stresses
    counted = sorted(wrenches_in_norm(scene.mechanism))
    for stress in stresses:
        columns = stress.spread.shape[3]
        changes = np.zeros((COUNT, item.size, 6, columns))
        changes[:, stress.joints] = stress.spread
        weighted = reactions.wrenches[:, counted] * squares
        products = np.einsum("nji,njis->ns", weighted, changes[:, counted])
        size = np.max(np.abs(weighted)) * np.max(np.abs(changes))
        assert np.max(np.abs(products)) < 1e-11 * size


def test_components_with_influence_are_those_that_are_open() -> None:
    """A planar four-bar leaves force z and the moments about x and y open."""
    scene = SCENES["four-bar"]()
    state, item = closed(scene), solver(scene)
    (reactions,) = item.solve(state, [load_case(scene, state)])
    axis = next(iter(scene.mechanism.description.joints)).axis
    out = np.abs(axis) > 0.5
    expected = np.concatenate([out, ~out])
    for open_components in reactions.influence > UNIQUE_TOLERANCE:
        assert open_components.tolist() == expected.tolist()
    assert reactions.indeterminate_couplings == set()


def test_redundant_couplings_are_indeterminate() -> None:
    single = cd.load(gears(coupling("g", "a", "b", 2.0)))
    double = cd.load(gears(coupling("g", "a", "b", 2.0), coupling("h", "a", "b", 2.0)))
    moments = []
    for mechanism, indeterminate in ((single, set()), (double, {0, 1})):
        scene = cd.Scene(mechanism, drive="a")
        (state,) = scene.assemble(np.zeros((1, 1))).blocks
        loads = np.zeros((1, 2))
        loads[0, mechanism.coordinates.velocity_columns["b"]] = -6.0
        case = LoadCase(None, loads, [], np.zeros((1, 3)))
        (reactions,) = solver(scene).solve(state, [case])
        assert reactions.indeterminate_couplings == indeterminate
        moments.append(sum(reactions.closure_forces)[0, 0])
        # The drive turns the wheel b twice as fast, so it carries twice its load.
        efforts = solver(scene).efforts(reactions)[0]
        np.testing.assert_allclose(efforts, [12.0, -6.0], atol=1e-12)
    # The couplings hold the load together, however they share it.
    np.testing.assert_allclose(moments, [6.0, 6.0], atol=1e-12)


def test_each_joint_counts_once_in_the_norm(joint: cd.Mechanism) -> None:
    mixed = cd.load(MIXED)
    bodies = mixed.model.njoints - 1
    expected = {item.id - 1 for item in mixed.joints.values() if item.parts} | {bodies}
    assert wrenches_in_norm(mixed) == expected
    # The universal joint has two bodies, of which only the outer one counts.
    (inner, outer) = (part.id - 1 for part in mixed["cross"].parts)
    assert outer in expected
    assert inner not in expected
    assert len(expected) == bodies
    assert wrenches_in_norm(joint) == set(range(joint.model.njoints - 1))


def test_solved_joints_are_those_of_known_bodies_and_solved_fixed_loops() -> None:
    scene = SCENES["gears"]()
    mechanism, item = scene.mechanism, solver(scene)
    names, indices = item.solved(scene.solver.assembly.needed)
    assert sorted(names) == sorted(mechanism.joints)
    for name, index in zip(names, indices.tolist(), strict=True):
        assert index == scene.problem.wrench_index(name)
    kinematics = scene.solver.assembly.kinematics
    none = ReactionSolver(mechanism, kinematics, set())
    needed = scene.solver.assembly.needed._replace(known_bodies={mechanism["in"].id - 1})
    assert none.solved(needed)[0] == ["in"]


def test_unit_twists_of_the_coordinates(scene: cd.Scene) -> None:
    """Pinocchio's joint subspaces, of turns and slides about the axes of the description."""
    mechanism = scene.mechanism
    subspace = solver(scene).subspace
    data = mechanism.model.createData()
    q = mechanism.coordinates.configuration(closed(scene).x[:1])[0]
    pinocchio.computeJointJacobians(mechanism.model, data, q)
    for joint_index in range(1, mechanism.model.njoints):
        jacobian = pinocchio.getJointJacobian(
            mechanism.model, data, joint_index, pinocchio.ReferenceFrame.LOCAL
        )
        start = mechanism.model.idx_vs[joint_index]
        columns = slice(start, start + mechanism.model.nvs[joint_index])
        np.testing.assert_allclose(subspace[columns], jacobian[:, columns].T, atol=1e-14)
