"""Wrenches split along and across a joint's axis, against projections written out."""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import cardan_dyn as cd
from cardan_dyn.core.results.left_open import named_components
from cardan_dyn.core.results.rods import RodForce
from cardan_dyn.core.results.wrench import JointWrench, StoredComponents

AXES = {
    "x": (1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "in a plane": (0.6, 0.0, -0.8),
    "oblique": (0.36, 0.48, 0.8),
}
ALL_UNIQUE = np.ones(6, dtype=bool)


def wrench(values: np.ndarray, axis: np.ndarray, frame: str = "joint") -> JointWrench:
    sweep = SimpleNamespace(near_singular=lambda *_: "")
    return JointWrench("hinge", frame, StoredComponents(values), axis, lambda: ALL_UNIQUE, sweep)


def random_values(count: int = 9) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(count, 6))


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
@pytest.mark.parametrize("turning", [False, True], ids=["constant", "per sample"])
def test_wrenches_are_split_along_and_across_the_axis(
    axis: tuple[float, ...], turning: bool
) -> None:
    values, direction = random_values(), np.array(axis)
    item = wrench(values, np.tile(direction, (9, 1)) if turning else direction)
    for vectors, along, size, across in (
        (values[:, :3], item.axial, item.shear, item.shear_vector),
        (values[:, 3:], item.torsion, item.bending, item.bending_vector),
    ):
        expected = vectors - np.outer(vectors @ direction, direction)
        np.testing.assert_allclose(along, vectors @ direction, atol=1e-15)
        np.testing.assert_allclose(across, expected, atol=1e-15)
        np.testing.assert_allclose(size, np.sqrt(np.sum(expected**2, axis=1)), atol=1e-15)


@pytest.mark.parametrize("vanishing", [(4,), (5,), (4, 5), (3, 4, 5)])
def test_components_that_vanish_are_not_missed(vanishing: tuple[int, ...]) -> None:
    values = random_values()
    values[:, vanishing] = 0.0
    item = wrench(values, np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(item.bending, np.hypot(values[:, 4], values[:, 5]), rtol=1e-15)
    np.testing.assert_array_equal(item.torsion, values[:, 3])


def test_a_bending_moment_far_smaller_than_the_torsion_keeps_its_digits() -> None:
    axis = np.array([0.36, 0.48, 0.8])
    normal = np.array([0.8, -0.6, 0.0])
    values = np.zeros((1, 6))
    values[0, 3:] = 1e6 * axis + 1e-3 * normal
    # The components themselves are rounded to eps · 1e6 = 2e-10.
    np.testing.assert_allclose(wrench(values, axis).bending_vector, [1e-3 * normal], atol=1e-9)
    np.testing.assert_allclose(wrench(values, axis).bending, [1e-3], atol=1e-9)


COMPONENTS = hnp.arrays(float, (4, 6), elements=st.floats(-1e150, 1e150, allow_subnormal=False))


@given(COMPONENTS, hnp.arrays(float, 3, elements=st.floats(-1.0, 1.0)))
def test_both_shares_add_up_to_the_vector(values: np.ndarray, direction: np.ndarray) -> None:
    length = float(np.linalg.norm(direction))
    axis = direction / length if length > 1e-3 else np.array([0.0, 0.0, 1.0])
    item = wrench(values, axis)
    scale = float(np.max(np.abs(values), initial=1e-300))
    together = item.torsion[:, None] * axis + item.bending_vector
    assert np.max(np.abs(together - item.moment)) <= 1e-14 * scale
    assert np.all(item.shear >= 0.0)
    assert np.all(np.abs(item.shear_vector @ axis) <= 1e-14 * scale)


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_lengths_neither_overflow_nor_vanish(size: float) -> None:
    values = np.zeros((2, 6))
    values[0] = size * np.array([3.0, 4.0, 12.0, 3.0, 4.0, 12.0])
    axes = np.tile([0.0, 0.0, 1.0], (2, 1))
    np.testing.assert_allclose(wrench(values, axes, "world").bending, [5.0 * size, 0.0], rtol=1e-15)
    np.testing.assert_allclose(wrench(values, axes[0]).shear, [5.0 * size, 0.0], rtol=1e-15)
    # The whole moment is √(3² + 4² + 12²) = 13.
    assert f"moment up to {13.0 * size:.4g} N·m" in repr(wrench(values, axes[0]))


def test_grids_of_operating_points_keep_their_shape() -> None:
    values = random_values(24).reshape(2, 3, 4, 6)
    item = wrench(values, np.array([0.6, 0.0, 0.8]))
    assert item.force.shape == item.shear_vector.shape == (2, 3, 4, 3)
    assert item.torsion.shape == item.bending.shape == item.axial.shape == (2, 3, 4)
    expected = np.linalg.norm(item.bending_vector, axis=-1)
    np.testing.assert_allclose(item.bending, expected, rtol=1e-14)
    assert repr(item).startswith(
        "<JointWrench of 'hinge' in joint axes, of the parent on the child: 2 × 3 × 4 samples, "
    )


def test_no_samples_have_a_wrench_without_rows() -> None:
    item = wrench(np.zeros((0, 6)), np.array([1.0, 0.0, 0.0]))
    assert item.bending.shape == item.torsion.shape == (0,)
    assert repr(item).endswith("0 samples, force up to 0 N, moment up to 0 N·m>")


def test_vectors_cannot_be_written_to() -> None:
    item = wrench(random_values(), np.array([1.0, 0.0, 0.0]))
    for array in (item.force, item.moment):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    with pytest.raises(AttributeError):
        item.joint = "other"  # type: ignore[misc]


def test_stored_components() -> None:
    values = random_values()
    values[:, 2] = 0.0
    stored = StoredComponents(values)
    np.testing.assert_array_equal(stored.component(4), values[:, 4])
    np.testing.assert_array_equal(stored.vector(3), values[:, 3:6])
    assert [stored.vanishes(index) for index in range(6)] == [False, False, True] + [False] * 3
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(stored)).values, values)


@pytest.mark.parametrize(
    ("components", "text"),
    [
        ((), ""),
        ((2, 3, 4), "force z, moment xy"),
        ((0, 1, 2), "force xyz"),
        ((5,), "moment z"),
    ],
)
def test_names_of_flagged_components(components: tuple[int, ...], text: str) -> None:
    flags = np.isin(np.arange(6), components)
    assert named_components(flags) == text


def test_signs_are_those_of_the_parent_on_the_child() -> None:
    """A mass of 2 kg that hangs below its hinge is pulled upwards by the parent."""
    pendulum = cd.load(
        '<robot name="p"><link name="base"/><link name="rod"><inertial><origin xyz="0 -0.4 0"/>'
        '<mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link><joint name="hinge" type="continuous"><parent link="base"/>'
        '<child link="rod"/><axis xyz="0 0 1"/></joint></robot>'
    )
    swing = cd.Scene(pendulum, drive="hinge", gravity=(0.0, -10.0, 0.0)).sweep([0.0, 0.5 * np.pi])
    np.testing.assert_allclose(swing.wrench("hinge", "world").force, [[0, 20, 0]] * 2, atol=1e-14)
    # At a quarter turn the mass stands at (0.4, 0): the parent holds it with +8 N·m about z.
    np.testing.assert_allclose(swing["hinge"].torsion, [0.0, 8.0], atol=1e-14)
    np.testing.assert_allclose(swing.drive_effort, [0.0, 8.0], atol=1e-14)


def test_texts_tell_what_is_known_of_trajectories_and_what_is_not() -> None:
    values = np.full((4, 6), np.nan)
    values[:3] = [[3.0, 4.0, 0.0, 0.0, 0.0, 2.0], [0.0] * 6, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
    for known in (4, 1):
        item = wrench(values[-known:], np.array([0.0, 0.0, 1.0]))
        bearings, tension = item.bearing_forces((0.0, 0.1)), item.force[:, 2]
        rod = RodForce("rod", ("a", "b"), tension, np.stack([tension] * 2, 1), tension, True)
        for told in map(repr, (item, bearings, rod)):
            assert f"not known at 1 of {known}" in told
            assert "nan" not in told and "nothing acts" not in told
        if known == 4:
            assert "force up to 5 N, moment up to 2 N·m" in repr(item)
            assert "at 0 m up to 5 N" in repr(bearings)
            assert "0 to 1 N" in repr(rod)
