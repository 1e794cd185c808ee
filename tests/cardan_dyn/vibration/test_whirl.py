"""Senses of whirl."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
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


def test_ellipses_of_centre_and_rotation_are_weighed() -> None:
    """By the radii of the circles in either sense of which each consists, u ± i v in y and z."""
    scene = cd.Scene(
        cd.load(elastic_rigs.sliding_rotor(1.7, 0.3, 0.4, 0.7)),
        drive=["turn", "x", "y", "z", "yaw"],
    )
    shapes = np.random.default_rng(5).normal(size=(4, 8, 2)) @ np.array([1.0, 1.0j])
    found = WhirlSense(rotating_scene(scene), np.zeros(4), 1.0).of(shapes)
    _, y, z, yaw = shapes
    circles = [
        (weight, np.abs(u + 1j * v) ** 2, np.abs(u - 1j * v) ** 2)
        for weight, u, v in ((1.7, y + 0.3 * yaw, z), (1.8 / 3.0, 0.0 * yaw, yaw))
    ]
    ahead, behind = (sum(item[0] * item[side] for item in circles) for side in (1, 2))
    np.testing.assert_allclose(found, (ahead - behind) / (ahead + behind), atol=1e-12)


def test_torsion_does_not_whirl() -> None:
    rotating = rotating_scene(elastic_rigs.scene(elastic_rigs.torsional_line(), 0.2))
    found = WhirlSense(rotating, np.zeros(1), 1.0).of(np.array([[1.0 + 0j]]))
    assert abs(found[0]) < 1e-12


def test_names() -> None:
    assert [sense_name(value) for value in (0.9, -0.5, 0.02)] == ["forward", "backward", "planar"]
