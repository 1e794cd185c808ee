"""Offsets and turns against matrices of placements, for samples together and alone."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from cardan_dyn.mechanism.frames import Offset, Turn, rotations

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
