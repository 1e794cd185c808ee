"""Surfaces against their areas, volumes and distances; directions against rotation matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan_dyn.practice.viewer import shapes


def volume(surface: tuple[np.ndarray, np.ndarray]) -> float:
    """Volume that a closed surface with outward faces contains, by the divergence theorem."""
    vertices, faces = surface
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def turned(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Turn a vector by a quaternion x, y, z, w."""
    axial, w = quaternion[:3], quaternion[3]
    return vector + 2.0 * np.cross(axial, np.cross(axial, vector) + w * vector)


def test_rod_is_a_prism_with_outward_faces() -> None:
    vertices, faces = shapes.rod(0.3, -1.0, 2.0)
    assert np.min(vertices[:, 2]) == -1.0 and np.max(vertices[:, 2]) == 2.0
    np.testing.assert_allclose(np.max(np.hypot(vertices[:, 0], vertices[:, 1])), 0.3)
    # A prism on a regular polygon of 20 corners.
    area = 20 / 2 * 0.3**2 * np.sin(2.0 * np.pi / 20)
    assert volume((vertices, faces)) == pytest.approx(3.0 * area)


def test_arrow_has_unit_length_and_a_head() -> None:
    vertices, faces = shapes.arrow(0.02)
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    assert np.min(vertices[:, 2]) == 0.0 and np.max(vertices[:, 2]) == 1.0
    np.testing.assert_allclose(radius[vertices[:, 2] == 1.0], 0.0)
    neck = 1.0 - 9.0 * 0.02
    assert np.max(radius) == pytest.approx(3.2 * 0.02)
    np.testing.assert_allclose(vertices[radius > 0.03, 2], neck)
    polygon = 20 / 2 * np.sin(2.0 * np.pi / 20)
    shaft, cone = neck * 0.02**2, (1.0 - neck) * (3.2 * 0.02) ** 2 / 3.0
    assert volume((vertices, faces)) == pytest.approx(polygon * (shaft + cone))


def test_wire_keeps_its_distance_from_the_curve() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0]])
    vertices, faces = shapes.path(points, 0.1)
    # Two steps have a length; each is a prism of three sides with six corners.
    assert vertices.shape == (12, 3) and faces.shape == (12, 3)
    np.testing.assert_allclose(np.hypot(vertices[:6, 1], vertices[:6, 2]), 0.1)
    np.testing.assert_allclose(np.hypot(vertices[6:, 0] - 1.0, vertices[6:, 2]), 0.1)
    assert set(faces[:6].ravel()) == set(range(6)) and set(faces[6:].ravel()) == set(range(6, 12))
    assert [len(part) for part in shapes.path(points[1:3], 0.1)] == [0, 0]


@given(st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=1, max_size=6))
def test_directions_are_reached(directions: list[tuple[float, float, float]]) -> None:
    vectors = np.array(directions)
    lengths = np.linalg.norm(vectors, axis=1)
    if np.min(lengths) < 1e-3:
        return
    vectors /= lengths[:, None]
    for quaternion, direction in zip(shapes.towards(vectors), vectors, strict=True):
        assert np.linalg.norm(quaternion) == pytest.approx(1.0)
        z = turned(quaternion, np.array([0.0, 0.0, 1.0]))
        # A direction opposite to the one from which is turned is missed by 1.4e-6 rad at most.
        np.testing.assert_allclose(z, direction, atol=2e-6)


def test_opposite_directions_have_a_turn() -> None:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    for quaternion, direction in zip(shapes.towards(axes), axes, strict=True):
        z = turned(quaternion, np.array([0.0, 0.0, 1.0]))
        np.testing.assert_allclose(z, direction, atol=1e-15)


def test_quaternions_turn_as_their_matrices_do() -> None:
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    matrices = np.array([np.eye(3), [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]])
    unturned, about_z = shapes.quaternions(matrices)
    np.testing.assert_allclose(np.abs(unturned), [0.0, 0.0, 0.0, 1.0], atol=1e-15)
    expected = [0.0, 0.0, np.sin(angle / 2.0), np.cos(angle / 2.0)]
    np.testing.assert_allclose(about_z * np.sign(about_z[3]), expected, atol=1e-15)


def test_short_vectors_keep_the_last_direction() -> None:
    x, y, z = np.eye(3)
    tiny = 1e-6 * z
    directions, lengths = shapes.filled(np.array([tiny, 2.0 * x, tiny, -3.0 * y, tiny]), 1e-3)
    np.testing.assert_array_equal(directions, [x, x, x, -y, -y])
    np.testing.assert_allclose(lengths, [1e-6, 2.0, 1e-6, 3.0, 1e-6])
    directions, _ = shapes.filled(np.array([tiny, -tiny]), 1e-3)
    np.testing.assert_array_equal(directions, [z, z])


def test_extremes_are_the_corners_of_a_box() -> None:
    corners = np.array(np.meshgrid([-1.0, 1.0], [-2.0, 2.0], [-3.0, 3.0])).reshape(3, 8).T
    inside = np.random.default_rng(1).uniform(-0.9, 0.9, (500, 3))
    chosen = shapes.extremes(np.concatenate([inside, corners]))
    assert {tuple(point) for point in chosen} == {tuple(point) for point in corners}


def test_directions_of_a_turning_vector_are_reached_by_neighbouring_quaternions() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    for tilt in (0.0, 0.7, np.pi / 2):
        directions = np.stack(
            [np.cos(turn), np.sin(turn) * np.cos(tilt), np.sin(turn) * np.sin(tilt)], axis=1
        )
        quaternions = shapes.towards(directions)
        x, y, z, w = quaternions.T
        turned_z = np.stack(
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1
        )
        np.testing.assert_allclose(turned_z, directions, atol=1e-14)
        neighbours = np.abs(np.sum(quaternions[1:] * quaternions[:-1], axis=1))
        assert np.min(neighbours) > 0.99


def test_a_swept_profile_and_a_ring_look_outwards() -> None:
    profile = np.array([[1.0, 0.0], [2.0, 0.0], [2.0, 0.5], [1.0, 0.5]])
    for (vertices, faces), share in (
        (shapes.swept(profile, np.linspace(0.2, 1.2, 200)), 1.0 / (2.0 * np.pi)),
        (shapes.ring(1.0, 2.0, 0.0, 0.5), 1.0),
        (shapes.joined(*[shapes.swept(profile, np.linspace(0.0, 1.0, 200))] * 2), 1.0 / np.pi),
    ):
        enclosed = np.sum(np.linalg.det(vertices[faces])) / 6.0
        # Volume of the ring: pi (2² - 1²) / 2. A polygon of 20 sides has 1.6 % less.
        assert enclosed == pytest.approx(share * 1.5 * np.pi, rel=0.02)
