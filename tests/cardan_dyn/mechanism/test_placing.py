"""Turns and balls against Pinocchio's, for samples together and alone."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.kinematics import frames_of

import cardan_dyn as cd
from cardan_dyn.core.mechanism.frames import Frames, rotations

SAMPLES = 4
HINGE = """<robot name="hinge"><link name="ground"/><link name="body"/>
<joint name="pin" type="continuous"><parent link="ground"/><child link="body"/>
<origin xyz="1 2 3" rpy="0.3 -0.2 0.5"/><axis xyz="{} {} {}"/></joint></robot>"""


@pytest.mark.parametrize(
    "axis",
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0.6, 0, 0.8], [0.48, -0.6, 0.64]],
    ids=str,
)
def test_turns_are_those_of_pinocchio(axis: list[float]) -> None:
    mechanism = cd.load(HINGE.format(*axis))
    frames, angles = frames_of(mechanism), np.array([0.0, 1e-9, 2.5, -1.0])
    found, origins = frames.joint(angles[:, None], 0)
    start = mechanism.description.joints[0].origin
    for sample, angle in enumerate(angles):
        rotation = pinocchio.AngleAxis(angle, np.array(axis, dtype=float)).toRotationMatrix()
        np.testing.assert_allclose(found[sample], start[:3, :3] @ rotation, atol=1e-15)
    np.testing.assert_array_equal(origins, [[1.0, 2.0, 3.0]] * SAMPLES)
    # Seen from where it has turned to, its start has turned back.
    back = frames.turned(angles[:, None], 0)
    np.testing.assert_allclose(
        found @ back.transpose(0, 2, 1), [start[:3, :3]] * SAMPLES, atol=1e-15
    )
    if axis == [0, 0, 1]:
        assert np.all(back[:, 2] == axis)


def test_rotations_are_those_of_pinocchio() -> None:
    pinocchio.seed(2)
    quaternions = [pinocchio.Quaternion(pinocchio.SE3.Random().rotation) for _ in range(SAMPLES)]
    found = rotations(np.stack([item.coeffs() for item in quaternions], axis=-1))
    for sample, quaternion in enumerate(quaternions):
        np.testing.assert_allclose(found[:, :, sample], quaternion.toRotationMatrix(), atol=1e-15)


@pytest.mark.parametrize("name", ["stewart_platform", "ring_joint", "double_shaft_spatial"])
def test_motions_are_placed_alike_alone_and_together(name: str) -> None:
    mechanism = cd.load(name)
    frames = Frames(mechanism.second_reading, mechanism.coordinates)
    x = np.random.default_rng(3).normal(size=(SAMPLES, mechanism.coordinates.size))
    found = frames.placed(mechanism.coordinates.normalised(x))
    for index in range(len(frames.motions)):
        path = frames.motions_to(index)
        np.testing.assert_array_equal(found[path], frames.placed(x, path)[path])
    for sample in range(SAMPLES):
        np.testing.assert_array_equal(frames.placed(x[[sample]])[..., 0], found[..., sample])
