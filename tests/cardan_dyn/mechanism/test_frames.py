"""Frames against Pinocchio's forward kinematics, bodies against its inertias."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd

NAMES = ("stewart_platform", "thoma_rig", "slider_crank", "needle_drive")


@pytest.fixture(scope="module", params=["mixed", *NAMES])
def mechanism(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load(MIXED if request.param == "mixed" else request.param)


def reference(mechanism: cd.Mechanism, x: np.ndarray, joint: str) -> tuple[np.ndarray, np.ndarray]:
    """Return rotations and origins of a joint's frame by Pinocchio."""
    data, index = mechanism.model.createData(), mechanism.joints[joint].id
    loop = next((loop for loop in mechanism.loops if loop.joint == joint), None)
    rotations, origins = [], []
    for q in mechanism.coordinates.configuration(x):
        pinocchio.forwardKinematics(mechanism.model, data, q)
        frame = data.oMi[index]
        if not index:
            frame = data.oMi[loop.predecessor] * loop.predecessor_placement
        rotations.append(frame.rotation.copy())
        origins.append(frame.translation.copy())
    return np.array(rotations), np.array(origins)


def test_joint_frames_are_those_of_pinocchio(mechanism: cd.Mechanism) -> None:
    frames, x = frames_of(mechanism), rows(mechanism, 3)
    placed = frames.placed(x)
    all_frames = frames.joint_frames(placed)
    assert sorted(frames.joints) == sorted(mechanism.joints)
    for index, name in enumerate(frames.joints):
        rotations, origins = reference(mechanism, x, name)
        found = frames.joint(x, index)
        np.testing.assert_allclose(found[0], rotations, atol=1e-13)
        np.testing.assert_allclose(found[1], origins, atol=1e-13)
        np.testing.assert_allclose(all_frames[index, :3].transpose(2, 1, 0), rotations, atol=1e-13)
        np.testing.assert_allclose(all_frames[index, 3].T + frames.corner, origins, atol=1e-13)


def test_ends_of_loops_are_those_of_pinocchio(mechanism: cd.Mechanism) -> None:
    frames, x = frames_of(mechanism), rows(mechanism, 2)
    placed, data = frames.placed(x), mechanism.model.createData()
    for index, loop in enumerate(mechanism.loops):
        assert frames.joints[frames.tree + index] == loop.joint
        found = np.broadcast_to(frames.ended(placed, index), (4, 3, len(x)))
        for sample, q in enumerate(mechanism.coordinates.configuration(x)):
            pinocchio.forwardKinematics(mechanism.model, data, q)
            end = data.oMi[loop.successor] * loop.successor_placement
            np.testing.assert_allclose(found[:3, :, sample].T, end.rotation, atol=1e-13)
            origin = found[3, :, sample] + frames.corner
            np.testing.assert_allclose(origin, end.translation, atol=1e-13)


def test_masses_and_centres_are_those_of_pinocchio(mechanism: cd.Mechanism) -> None:
    """A loop's share of its successor's mass lies where the mass of the closed mechanism does."""
    frames, model = frames_of(mechanism), mechanism.model
    welded = set(mechanism.auxiliary_bodies)
    total = sum(
        inertia.mass for index, inertia in enumerate(model.inertias) if index not in {0, *welded}
    )
    assert sum(body.mass for body in frames.bodies) == pytest.approx(total, rel=1e-13)
    successors = {loop.successor for loop in mechanism.loops}
    for index, body in enumerate(frames.bodies):
        joint = mechanism.joints[frames.joints[index]]
        inertia = model.inertias[joint.id]
        np.testing.assert_allclose(body.centre, inertia.lever, atol=1e-14)
        if joint.id not in successors:
            assert body.mass == pytest.approx(inertia.mass, rel=1e-14)
            np.testing.assert_allclose(body.inertia, inertia.inertia, rtol=1e-12, atol=1e-13)


def test_paths_lead_from_the_root_to_a_body(mechanism: cd.Mechanism) -> None:
    frames = frames_of(mechanism)
    for body in range(len(frames.bodies)):
        path = frames.path(body)
        assert path[-1] == body
        assert frames.parents[path[0]] == -1
        assert [frames.parents[step] for step in path[1:]] == path[:-1]
    assert frames.path(-1) == []
