"""Closure forces as external forces on Pinocchio's tree, and self-stresses in balance."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio
import pytest
from testkit.claims import SCENES, positions
from testkit.mixed_chain import rows
from testkit.planar_linkages import three_cranks

import cardan_dyn as cd
from cardan_dyn.dynamics.closure_forces import ClosureForces
from cardan_dyn.kinematics.closing.all_groups import ClosedState
from cardan_dyn.kinematics.closing.batch_model import BatchModel
from cardan_dyn.kinematics.closing.group_solver import GroupState

COUNT, SIZE = 3, 2


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return SCENES[request.param]()


def groups(scene: cd.Scene, closed: bool = False) -> Iterator[tuple[np.ndarray, GroupState]]:
    """Yield coordinates and the state there of every group with loops or couplings."""
    state: ClosedState
    if closed:
        (state,) = scene.assemble(positions(scene)[:COUNT]).blocks
    else:
        state = scene.solver.assembly.kinematics.evaluate(rows(scene.mechanism, COUNT))
    for group_state in state.groups:
        if group_state.group.loops or group_state.group.couplings:
            yield state.x, group_state


def joint_wrenches(
    mechanism: cd.Mechanism, x: np.ndarray, batch: BatchModel, forces: dict[int, np.ndarray]
) -> np.ndarray:
    """Return what closure forces add to the wrenches of all bodies' joints, `(N, n, 6)`.

    Args:
        mechanism: the mechanism.
        x: coordinates.
        batch: in whose base's axes, and about whose origin, the forces are.
        forces: per loop `(N, 6)`.
    """
    model = mechanism.model.copy()
    for index in range(model.njoints):
        model.inertias[index] = pinocchio.Inertia.Zero()
    data, result = model.createData(), np.zeros((len(x), model.njoints - 1, 6))
    zero = np.zeros(model.nv)
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q)
        shift = data.oMi[batch.base + 1] * pinocchio.SE3(np.eye(3), batch.origin)
        external = [pinocchio.Force.Zero() for _ in range(model.njoints)]
        for index, values in forces.items():
            loop, force = mechanism.loops[index], shift.act(pinocchio.Force(values[sample]))
            external[loop.successor] += data.oMi[loop.successor].actInv(force)
            external[loop.predecessor] -= data.oMi[loop.predecessor].actInv(force)
        forces_on = pinocchio.StdVec_Force()
        forces_on.extend(external)
        pinocchio.rnea(model, data, q, zero, zero, forces_on)
        result[sample] = [data.f[index].vector for index in range(1, model.njoints)]
    return result


def loop_forces(group: GroupState) -> dict[int, np.ndarray]:
    rng = np.random.default_rng(2)
    return {loop: rng.normal(size=(COUNT, 6, SIZE)) for loop in group.group.loops}


def test_wrenches_on_the_path_of_a_loop_are_those_of_external_forces(scene: cd.Scene) -> None:
    mechanism = scene.mechanism
    closure = ClosureForces(mechanism)
    for x, group in groups(scene):
        for local, (loop, forces) in enumerate(loop_forces(group).items()):
            joints, added = closure.on_path(group, local, loop, forces)
            wrenches = np.zeros((COUNT, closure.size, 6, SIZE))
            wrenches[:, joints] = added
            for column in range(SIZE):
                expected = joint_wrenches(mechanism, x, group.batch, {loop: forces[..., column]})
                actual = wrenches[:, : expected.shape[1], :, column]
                np.testing.assert_allclose(actual, expected, atol=1e-12)


def test_wrenches_of_fixed_loops_are_the_closure_forces_in_their_frames() -> None:
    scene = SCENES["gears"]()
    mechanism = scene.mechanism
    closure = ClosureForces(mechanism)
    bodies = mechanism.model.njoints - 1
    assert closure.size == bodies + 1
    assert closure.fixed_loops == {0: bodies}
    assert ClosureForces(SCENES["four-bar"]().mechanism).fixed_loops == {}
    ((x, group),) = [item for item in groups(scene) if item[1].group.loops]
    forces = loop_forces(group)[0]
    joints, added = closure.on_path(group, 0, 0, forces)
    assert np.arange(closure.size)[joints][-1] == bodies
    loop, data = mechanism.loops[0], mechanism.model.createData()
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(mechanism.model, data, q)
        base = data.oMi[group.batch.base + 1]
        shift = base * pinocchio.SE3(np.eye(3), group.batch.origin)
        end = data.oMi[loop.successor] * loop.successor_placement
        force = shift.act(pinocchio.Force(forces[sample, :, 0].copy()))
        np.testing.assert_allclose(added[sample, -1, :, 0], end.actInv(force).vector, atol=1e-12)


def test_multipliers_work_along_the_coordinates_as_their_rows_say(scene: cd.Scene) -> None:
    """Of virtual work: the efforts of the forces are the transposed closure matrix times them."""
    mechanism = scene.mechanism
    closure, loops = ClosureForces(mechanism), len(mechanism.loops)
    subspace = scene.solver.reactions.subspace
    owners = scene.solver.reactions.along.owners
    for _, group in groups(scene):
        multipliers = np.random.default_rng(5).normal(
            size=(COUNT, group.passive_rows.shape[2], SIZE)
        )
        forces = closure.of_multipliers(group, multipliers)
        efforts = np.zeros((COUNT, mechanism.model.nv, SIZE))
        for local, loop in enumerate(group.group.loops):
            joints, added = closure.on_path(group, local, loop, forces[loop])
            wrenches = np.zeros((COUNT, closure.size, 6, SIZE))
            wrenches[:, joints] = added
            efforts += np.einsum("nkic,ki->nkc", wrenches[:, owners], subspace)
        for index in group.group.couplings:
            coupling = mechanism.couplings[index]
            # A joint has to exert against a coupling what the coupling exerts on it.
            efforts[:, coupling.successor_columns] -= forces[loops + index]
            efforts[:, coupling.predecessor_columns] += coupling.ratio * forces[loops + index]
        for columns, matrix in (
            (group.group.passives, group.passive_rows),
            (group.group.known, group.known_rows),
        ):
            np.testing.assert_allclose(efforts[:, columns], matrix @ multipliers, atol=1e-11)


@pytest.mark.parametrize(("name", "count"), [("universal", 3), ("four-bar", 3), ("spatial", 0)])
def test_self_stresses_act_along_no_passive_coordinate(name: str, count: int) -> None:
    scene = SCENES[name]()
    mechanism = scene.mechanism
    closure = ClosureForces(mechanism)
    reactions = scene.solver.reactions
    total = 0
    for x, group in groups(scene, closed=True):
        for item in closure.self_stresses(group):
            columns = next(iter(item.forces.values())).shape[2]
            total += columns
            wrenches = np.zeros((COUNT, closure.size, 6, columns))
            wrenches[:, item.joints] = item.spread
            chosen = wrenches[:, reactions.along.owners[group.group.passives]]
            units = reactions.subspace[group.group.passives]
            efforts = np.einsum("nkic,ki->nkc", chosen, units)
            np.testing.assert_allclose(efforts, 0.0, atol=1e-9)
            assert np.linalg.matrix_rank(wrenches[0].reshape(-1, columns)) == columns
            for column in range(columns):
                forces = {loop: values[..., column] for loop, values in item.forces.items()}
                expected = joint_wrenches(mechanism, x, group.batch, forces)
                actual = wrenches[:, : expected.shape[1], :, column]
                np.testing.assert_allclose(actual, expected, atol=1e-9)
    assert total == count


def test_redundant_couplings_stress_each_other_and_no_joint() -> None:
    source = SCENES["gears"]().mechanism.description.source.text
    cut = source.index("<coupling")
    second = source[cut:].replace("</robot>", "").replace('"mesh"', '"second"')
    mechanism = cd.load(source.replace("</robot>", second + "</robot>"))
    scene = cd.Scene(mechanism, drive=["in", "swing"])
    closure = ClosureForces(mechanism)
    (state,) = scene.assemble(positions(scene)[:COUNT]).blocks
    stresses = [
        item
        for group in state.groups
        if group.group.couplings
        for item in closure.self_stresses(group)
    ]
    (item,) = [item for item in stresses if len(item.forces) == 2]
    first, second_moment = (item.forces[index] for index in sorted(item.forces))
    np.testing.assert_allclose(first, -second_moment, atol=1e-14)
    assert item.joints.size == 0


def test_a_self_stress_of_several_loops_adds_up_at_the_joints_that_they_share() -> None:
    mechanism = three_cranks()
    scene = cd.Scene(mechanism, drive="A")
    closure = ClosureForces(mechanism)
    (state,) = scene.assemble(np.linspace(0.1, 0.5, COUNT)[:, None]).blocks
    (group,) = [item for item in state.groups if item.group.loops]
    stresses = closure.self_stresses(group)
    (item,) = [item for item in stresses if len(item.forces) == 2]
    forces = {loop: values[..., 0] for loop, values in item.forces.items()}
    expected = joint_wrenches(mechanism, state.x, group.batch, forces)
    wrenches = np.zeros_like(expected)
    wrenches[:, item.joints] = item.spread[..., 0]
    np.testing.assert_allclose(wrenches, expected, atol=1e-10)
    # The cranks carry forces along themselves, which add up to zero, as their moments do.
    names = [mechanism[name].id - 1 for name in "ADE"]
    along = wrenches[:, names, 1] / wrenches[:, names[:1], 1]
    np.testing.assert_allclose(along, np.tile([1.0, -2.0, 1.0], (COUNT, 1)), atol=1e-9)
    np.testing.assert_allclose(wrenches[:, names, 0], 0.0, atol=1e-10)
