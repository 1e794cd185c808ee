"""Motions of bases against Pinocchio's forward kinematics."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.many_drives import cranks, on_arms, stacked
from testkit.mixed_chain import rows

import cardan_dyn as cd
from cardan_dyn.dynamics.base_motion import base_motions, base_rotations
from cardan_dyn.kinematics.closing.all_groups import ClosedState

COUNT = 3
GRAVITY = np.array([[1.0, -2.0, -9.81]])


def closed(mechanism: cd.Mechanism) -> tuple[ClosedState, dict[int, int], list[int]]:
    """Return a state, the group of every body, and the bases of all groups."""
    scene = cd.Scene(mechanism, drive=cranks(mechanism))
    kinematics = scene.solver.assembly.kinematics
    state = kinematics.evaluate(rows(mechanism, COUNT))
    groups = [solver.group for solver in kinematics.solvers]
    owners = {body: k for k, group in enumerate(groups) for body in group.inertial_bodies}
    return state, owners, sorted({group.base for group in groups} - {-1})


@pytest.mark.parametrize("mechanism", [stacked(4), on_arms(3)], ids=["stacked", "on arms"])
def test_bases_move_as_pinocchio_says(mechanism: cd.Mechanism) -> None:
    state, owners, bases = closed(mechanism)
    assert len(bases) >= 3
    model, data = mechanism.model, mechanism.model.createData()
    v, a = np.random.default_rng(1).normal(size=(2, COUNT, model.nv))
    motions = base_motions(state, owners, bases, (v, a), GRAVITY)
    rotations = base_rotations(state, owners, bases)
    for sample, q in enumerate(mechanism.coordinates.configuration(state.x)):
        pinocchio.forwardKinematics(model, data, q, v[sample], a[sample])
        for base in bases:
            rotation = data.oMi[base + 1].rotation
            np.testing.assert_allclose(rotations[base][..., sample], rotation, atol=1e-14)
            twist, acceleration = data.v[base + 1].vector, data.a[base + 1].vector.copy()
            acceleration[:3] -= rotation.T @ GRAVITY[0]
            size = np.max(np.abs(acceleration))
            np.testing.assert_allclose(motions[base].twist[sample], twist, atol=1e-14 * size)
            actual = motions[base].acceleration[sample]
            np.testing.assert_allclose(actual, acceleration, atol=1e-14 * size)


def test_the_world_rests_and_accelerates_against_gravity() -> None:
    state, owners, _ = closed(stacked(2))
    rest = np.zeros((COUNT, len(state.x[0])))
    motions = base_motions(state, owners, [], (rest, rest), GRAVITY)
    assert set(motions) == {-1}
    np.testing.assert_array_equal(motions[-1].twist, np.zeros((COUNT, 6)))
    np.testing.assert_array_equal(motions[-1].acceleration, [[-1.0, 2.0, 9.81, 0, 0, 0]] * COUNT)
