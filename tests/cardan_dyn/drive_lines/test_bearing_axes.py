"""Axes of bearings against axes made of the shafts' directions."""

import numpy as np
import pytest
from testkit.line_data import along_points, random_line

from cardan_dyn.drive_lines.bearing_axes import bearing_axes


def test_axes_of_the_data() -> None:
    line = random_line(3, seed=1)
    found = bearing_axes(line.geometry, {}, [(0, 0.0), (2, 0.0), (3, 0.4)])
    assert found.shape == (1, 3, 3, 3)
    # Forces along a shaft are along x of its place; one to the left has no upward part.
    for axes, shaft in zip(found[0, :2], (0, 2), strict=True):
        assert axes[0] == pytest.approx([1, 0, 0], abs=1e-15)
        in_world = axes @ line.geometry.frames[shaft].T
        assert in_world[0] == pytest.approx(line.geometry.directions[shaft])
        assert in_world[1, 2] == pytest.approx(0.0, abs=1e-15)
        assert in_world[2, 2] > 0.5
    c, s = np.cos(0.4), np.sin(0.4)
    straight = bearing_axes(line.geometry, {}, [(3, 0.0)])[0, 0]
    assert found[0, 2] == pytest.approx(straight @ [[1, 0, 0], [0, c, -s], [0, s, c]])


def test_joint_angles_and_planes_turn_what_is_behind_them() -> None:
    line = random_line(3, seed=2)
    angle, plane = np.array([0.05, -0.1]), np.array([0.4, -2.0])
    held = {"joint_angle_1": angle[:, None], "joint_plane_2": plane[:, None]}
    places = [(shaft, 0.0) for shaft in range(4)]
    found = bearing_axes(line.geometry, held, places)
    for design in range(2):
        angles = line.joint_angles + np.array([angle[design], 0, 0])
        planes = line.geometry.plane_offsets + np.array([0, plane[design], 0])
        other = along_points(line, angles, planes).geometry
        for shaft in range(4):
            axis = other.directions[shaft]
            left = np.cross([0, 0, 1], axis)
            left /= np.linalg.norm(left)
            # Frames of a line of points come from their vectors, not from angles.
            in_world = found[design, shaft] @ other.frames[shaft].T
            expected = np.stack([axis, left, np.cross(axis, left)])
            assert in_world == pytest.approx(expected, abs=1e-13)
