"""Senses of whirl."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn.vibration.rotating_scene import rotating_scene
from cardan_dyn.vibration.whirl import WhirlSense, sense_name

SHAPES = np.array([[1.0, 1.0, 1.0, 2.0], [-1j, 1j, 0.5, -1j]])
"""Circles in both senses, a line and an ellipse of y and z."""


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_circles_lines_and_ellipses(sense: float) -> None:
    rotating = rotating_scene(
        elastic_rigs.scene(elastic_rigs.elastic_rig(), np.radians(5.0), ["tilt_y", "tilt_z"])
    )
    # From y to z is forward about x; u e^{iωt} with u_z = -i u_y turns from y to z.
    found = WhirlSense(rotating, np.zeros(2), sense).of(SHAPES)
    np.testing.assert_allclose(found, sense * np.array([1.0, -1.0, 0.0, 0.8]), atol=0.01)


def test_a_heavy_housing_changes_no_sense() -> None:
    """It moves with the shaft on the same circles, but does not turn."""
    urdf = elastic_rigs.elastic_rig()
    light = '<link name="housing_out"/>'
    heavy = light.replace("/>", ">") + (
        '<inertial><mass value="9"/><inertia ixx="50" iyy="50" izz="50" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )
    assert light in urdf
    rotating = rotating_scene(
        elastic_rigs.scene(urdf.replace(light, heavy), np.radians(5.0), ["tilt_y", "tilt_z"])
    )
    found = WhirlSense(rotating, np.zeros(2), 1.0).of(SHAPES)
    np.testing.assert_allclose(found, [1.0, -1.0, 0.0, 0.8], atol=0.01)


def test_torsion_does_not_whirl() -> None:
    """Nor does rounding, of twists that are out of phase."""
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, fork_inertia=0.2)
    rotating = rotating_scene(elastic_rigs.scene(line, 0.2))
    shapes = np.array([[1.0, 1.0], [1j, -0.3j]])
    found = WhirlSense(rotating, np.array([0.01, 0.02]), 1.0).of(shapes)
    np.testing.assert_array_equal(found, [0.0, 0.0])


def test_names() -> None:
    assert [sense_name(value) for value in (0.9, -0.5, 0.02)] == ["forward", "backward", "planar"]
