"""Ends, paths and axes of loops, and the rotations between their ends."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.kinematics.closing.batch_model import BatchModel
from cardan_dyn.kinematics.closing.equations import (
    LoopAxes,
    LoopEnds,
    LoopPaths,
    drift_along,
    rotations_between,
)

AXES = np.array([[1, 0, 0], [0, -1, 0], [0, 0, 1], [0.6, 0, -0.8], [0.36, 0.48, 0.8]], dtype=float)
ANGLES = [0.0, 1e-9, 1e-3, 0.7, 2.0, 3.1, np.pi - 1e-5, np.pi - 1e-8, np.pi]


def stacked(rotations: list[np.ndarray]) -> np.ndarray:
    return np.array(rotations).transpose(1, 2, 0)


@pytest.mark.parametrize("angle", ANGLES)
def test_rotations_are_axes_times_twice_the_sine_of_half_the_angle(angle: float) -> None:
    rng = np.random.default_rng(5)
    second = [pinocchio.exp3(rng.normal(size=3)) for _ in AXES]
    first = [pinocchio.exp3(angle * axis) @ frame for axis, frame in zip(AXES, second, strict=True)]
    found = rotations_between(stacked(first), stacked(second)).T
    expected = 2.0 * np.sin(0.5 * angle) * AXES
    if np.pi - angle < 1e-7:
        # Either direction of the axis of a half turn is right.
        signs = np.sign(np.sum(found * expected, axis=1, keepdims=True))
        expected = signs * expected
    # Towards a half turn the trace plus one, 4 cos² of half the angle, is as small as 1e-10 and
    # keeps an error of about ten roundings: 1e-5 of its root.
    np.testing.assert_allclose(found, expected, atol=1e-14 if angle < 3.0 else 1e-5)


@pytest.mark.parametrize("fixed", ["first", "second"])
def test_one_end_may_be_fixed_and_only_some_samples_half_turns(fixed: str) -> None:
    turns = stacked([pinocchio.exp3(np.array([0.0, 0.0, angle])) for angle in (0.2, np.pi, -1.0)])
    world = np.eye(3)[:, :, None]
    ends = (world, turns) if fixed == "first" else (turns, world)
    sign = -1.0 if fixed == "first" else 1.0
    found = rotations_between(*ends)
    np.testing.assert_allclose(found[:2], 0.0, atol=1e-15)
    expected = 2.0 * np.sin([0.1, 0.5 * np.pi, -0.5])
    np.testing.assert_allclose(found[2, [0, 2]], sign * expected[[0, 2]], rtol=1e-14)
    assert abs(found[2, 1]) == pytest.approx(2.0)


@pytest.fixture(scope="module")
def chain() -> tuple[cd.Mechanism, BatchModel, np.ndarray]:
    mechanism = cd.load(MIXED)
    batch = BatchModel(mechanism, list(range(mechanism.model.njoints - 1)), set(), np.zeros(3))
    return mechanism, batch, rows(mechanism, 3)


def frames(mechanism: cd.Mechanism, x: np.ndarray, index: int) -> list[pinocchio.SE3]:
    data, result = mechanism.model.createData(), []
    for q in mechanism.coordinates.configuration(x):
        pinocchio.forwardKinematics(mechanism.model, data, q)
        result.append(data.oMi[index].copy())
    return result


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("shifted", [False, True])
def test_ends_are_placed_in_their_bodies(
    chain: tuple[cd.Mechanism, BatchModel, np.ndarray], rotated: bool, shifted: bool
) -> None:
    mechanism, batch, x = chain
    rotation = pinocchio.exp3(np.array([0.2, -0.5, 0.9])) if rotated else np.eye(3)
    translation = np.array([0.1, 0.2, -0.3]) * shifted
    plain = np.eye(3), np.array([0.5, 0.0, 0.1]) * shifted
    placed = [(1, *plain), (3, rotation, translation), (2, *plain)]
    ends = LoopEnds.of(*(np.array(item) for item in zip(*placed, strict=True)))
    assert (ends.is_rotated, ends.is_shifted) == (rotated, shifted)
    rotations, positions = ends.placements_on_base(batch.placed(x))
    for index, (body, *placement) in enumerate(placed):
        for sample, frame in enumerate(frames(mechanism, x, body + 1)):
            expected = frame * pinocchio.SE3(*placement)
            found = rotations[:, index, :, sample], positions[:, index, sample]
            np.testing.assert_allclose(found[0], expected.rotation, atol=1e-14)
            np.testing.assert_allclose(found[1], expected.translation, atol=1e-14)
    fixed = LoopEnds.of(np.array([-1]), rotation[None], translation[None])
    rotations, positions = fixed.placements_on_base(np.zeros((3, 0, 12)))
    np.testing.assert_array_equal(rotations[:, 0, :, 0], rotation)
    np.testing.assert_array_equal(positions[:, 0, 0], translation)


def test_axes_change_twists_and_wrenches(
    chain: tuple[cd.Mechanism, BatchModel, np.ndarray],
) -> None:
    mechanism, batch, x = chain
    point = np.array([0.4, 0.0, 0.7])
    matrices = LoopAxes(1, point).matrices(batch.actions(x))
    vector = np.arange(1.0, 7.0)
    for matrix, frame in zip(matrices, frames(mechanism, x, 2), strict=True):
        axes = frame * pinocchio.SE3(np.eye(3), point)
        twist = axes.actInv(pinocchio.Motion(vector)).vector
        np.testing.assert_allclose(vector @ matrix, twist, rtol=1e-12)
        wrench = axes.act(pinocchio.Force(vector)).vector
        np.testing.assert_allclose(matrix @ vector, wrench, rtol=1e-12)


def test_drift_of_two_joints_is_their_motion_product() -> None:
    """The second joint's twist is carried by the first; another one stands on the other side."""
    rng = np.random.default_rng(6)
    twists, rates = rng.normal(size=(2, 3, 6)), rng.normal(size=(2, 3))
    carries = np.zeros((3, 3))
    carries[1, 0] = 1.0
    columns, signs = np.array([[2, 0, 1]]), np.array([[[1.0], [1.0], [-1.0]]])
    ends = np.array([[[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
    (found,) = (
        LoopPaths(slice(1), columns, signs, carries[None], ends).drift(twists, rates).swapaxes(0, 1)
    )
    for sample in range(2):
        first, second = (
            pinocchio.Motion(twists[sample, column] * rates[sample, column]) for column in (2, 0)
        )
        np.testing.assert_allclose(found[sample], first.cross(second).vector, rtol=1e-12)


def test_paths_of_one_length_are_worked_on_together() -> None:
    """Each as it is alone, whatever the others are."""
    signs = np.array([[1.0, 1.0, 0.0, -1.0], [0.0, 1.0, -1.0, 0.0], [-1.0, 0.0, 1.0, 1.0]])
    bodies = np.array([0, 2, 1, 3])
    rng = np.random.default_rng(8)
    twists, rates = rng.normal(size=(5, 4, 6)), rng.normal(size=(5, 4))
    paths = LoopPaths.of(signs, bodies)
    assert [path.columns.tolist() for path in paths] == [[[0, 1, 3], [2, 3, 0]], [[1, 2]]]
    together = drift_along(paths, twists, rates)
    for loop, row in enumerate(signs):
        alone = drift_along(LoopPaths.of(row[None], bodies), twists, rates)
        np.testing.assert_allclose(together[:, [loop]], alone, rtol=0.0, atol=1e-14)
    # Of the second one, no coordinate carries another.
    assert not np.any(together[:, 1])
