"""Offsets and turns against matrices of placements, for samples together and alone."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import cardan_dyn as cd
from cardan_dyn.core.mechanism.frames import Alike, Frames, Offset, Turn, rotations, stepped

CORNER = np.array([0.3, -0.2, 0.1])
SAMPLES = 4


def random_frames() -> tuple[np.ndarray, list[pinocchio.SE3]]:
    """Return a frame `(4, 3, N)` of every sample, origins about `CORNER`, and as placements."""
    pinocchio.seed(1)
    placements = [pinocchio.SE3.Random() for _ in range(SAMPLES)]
    return as_frames(placements), placements


def as_frames(placements: list[pinocchio.SE3]) -> np.ndarray:
    """Return placements as frames `(4, 3, N)`, origins about `CORNER`."""
    frames = [
        np.vstack([placement.rotation.T, placement.translation - CORNER])
        for placement in placements
    ]
    return np.stack(frames, axis=-1)


def test_offsets_in_the_world_are_the_same_for_all_samples() -> None:
    placement = pinocchio.SE3.Random()
    offset = Offset.of(-1, placement.homogeneous, CORNER)
    np.testing.assert_allclose(offset.frame({}), as_frames([placement]), atol=1e-15)


def test_offsets_in_the_frame_of_a_motion_move_with_it() -> None:
    frames, placements = random_frames()
    placement = pinocchio.SE3.Random()
    found = Offset.of(2, placement.homogeneous, CORNER).frame({2: frames})
    np.testing.assert_allclose(found, as_frames([item * placement for item in placements]))


def test_no_offset_is_the_frame_itself() -> None:
    frames, _ = random_frames()
    assert Offset.of(2, np.eye(4), CORNER).frame({2: frames}) is frames


@pytest.mark.parametrize(
    "axis",
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0.6, 0, 0.8], [0.48, -0.6, 0.64]],
    ids=str,
)
@pytest.mark.parametrize("count", [1, SAMPLES])
def test_turns_are_those_of_pinocchio(axis: list[float], count: int) -> None:
    """The frame before a turn may be one for all samples, as of joints on the ground."""
    frames, placements = random_frames()
    angles = np.array([0.0, 1e-9, 2.5, -1.0])
    result = np.empty_like(frames)
    Turn(np.array(axis, dtype=float)).write(
        result, frames[..., :count], np.cos(angles), np.sin(angles)
    )
    turned = []
    for sample, angle in enumerate(angles):
        rotation = pinocchio.AngleAxis(angle, np.array(axis, dtype=float)).toRotationMatrix()
        turned.append(placements[sample % count] * pinocchio.SE3(rotation, np.zeros(3)))
    np.testing.assert_allclose(result, as_frames(turned), atol=1e-15)


def test_rotations_are_those_of_pinocchio() -> None:
    pinocchio.seed(2)
    quaternions = [pinocchio.Quaternion(pinocchio.SE3.Random().rotation) for _ in range(SAMPLES)]
    found = rotations(np.stack([item.coeffs() for item in quaternions], axis=-1))
    for sample, quaternion in enumerate(quaternions):
        np.testing.assert_allclose(found[:, :, sample], quaternion.toRotationMatrix(), atol=1e-15)


@pytest.mark.parametrize("name", ["stewart_platform", "ring_joint", "double_shaft_spatial"])
def test_motions_that_are_placed_together_are_where_each_is_alone(name: str) -> None:
    mechanism = cd.load(name)
    frames = Frames(mechanism.second_reading, mechanism.coordinates)
    x = np.random.default_rng(3).normal(size=(SAMPLES, mechanism.coordinates.size))
    found = frames.placed(mechanism.coordinates.normalised(x))
    alone = np.full_like(found, np.nan)
    for index in range(len(frames.motions)):
        Alike.of([index], frames.motions, frames.starts).place(alone, x)
    np.testing.assert_array_equal(found, alone)
    for sample in range(SAMPLES):
        np.testing.assert_array_equal(frames.placed(x[[sample]])[..., 0], found[..., sample])


def test_legs_of_a_robot_are_placed_together() -> None:
    """Six legs, one of which carries the platform: its ball is three turns."""
    mechanism = cd.load("stewart_platform")
    frames = Frames(mechanism.second_reading, mechanism.coordinates)
    assert len(frames.motions) > 20
    assert len(frames.alike) <= 10


def test_equal_steps_are_slices() -> None:
    for indices in ([3], [0, 1], [2, 5, 8], [0]):
        found = stepped(indices)
        assert found is not None
        assert list(range(10))[found] == indices
    for indices in ([0, 2, 3], [4, 4], [3, 1]):
        assert stepped(indices) is None
