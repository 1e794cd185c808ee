"""Senses of whirl."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn.motion.vibration.model.modes import WhirlSense, clear_senses, sense_name
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene

SHAPES = np.array([[1.0, 1.0, 1.0, 2.0], [-1j, 1j, 0.5, -1j]])
"""Circles in both senses, a line and an ellipse of y and z."""


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_circles_lines_and_ellipses(sense: float) -> None:
    rotating = rotating_scene(
        elastic_rigs.scene(elastic_rigs.elastic_rig(), np.radians(5.0), ["tilt_y", "tilt_z"])
    )
    # From y to z is forward about x; u e^{iωt} with u_z = -i u_y turns from y to z.
    found = WhirlSense(rotating, np.zeros(2), sense, 16).of(SHAPES)
    np.testing.assert_allclose(found, sense * np.array([1.0, -1.0, 0.0, 0.8]), atol=0.01)


def test_ellipses_of_centre_and_rotation_are_weighed() -> None:
    """By the radii of the circles in either sense of which each consists, u ± i v in y and z."""
    scene = cd.Scene(
        cd.load(elastic_rigs.sliding_rotor(1.7, 0.3, 0.4, 0.7)),
        drive="turn",
        free=["x", "y", "z", "yaw"],
    )
    shapes = np.random.default_rng(5).normal(size=(4, 8, 2)) @ np.array([1.0, 1.0j])
    found = WhirlSense(rotating_scene(scene), np.zeros(4), 1.0, 16).of(shapes)
    _, y, z, yaw = shapes
    circles = [
        (weight, np.abs(u + 1j * v) ** 2, np.abs(u - 1j * v) ** 2)
        for weight, u, v in ((1.7, y + 0.3 * yaw, z), (1.8 / 3.0, 0.0 * yaw, yaw))
    ]
    ahead, behind = (sum(item[0] * item[side] for item in circles) for side in (1, 2))
    np.testing.assert_allclose(found, (ahead - behind) / (ahead + behind), atol=1e-12)


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
    found = WhirlSense(rotating, np.zeros(2), 1.0, 16).of(SHAPES)
    np.testing.assert_allclose(found, [1.0, -1.0, 0.0, 0.8], atol=0.01)


def test_torsion_does_not_whirl() -> None:
    """Nor does rounding, of twists that are out of phase."""
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, fork_inertia=0.2)
    rotating = rotating_scene(elastic_rigs.scene(line, 0.2))
    shapes = np.array([[1.0, 1.0], [1j, -0.3j]])
    found = WhirlSense(rotating, np.array([0.01, 0.02]), 1.0, 16).of(shapes)
    np.testing.assert_array_equal(found, [0.0, 0.0])


def test_names() -> None:
    assert [sense_name(value) for value in (0.9, -0.5, 0.02)] == ["forward", "backward", "planar"]
    assert sense_name(np.nan) == ""


def test_clear_senses() -> None:
    senses = clear_senses(np.array([[0.9, -0.5], [1e-17, -0.05]]))
    np.testing.assert_array_equal(senses, [[1.0, -1.0], [0.0, 0.0]])


def test_modes_of_one_frequency_are_parted_into_circles() -> None:
    """Whatever combinations a solver returns; a third mode of its own frequency stays."""
    scene = elastic_rigs.scene(elastic_rigs.rotor(), 0.0)
    sense = WhirlSense(rotating_scene(scene), np.zeros(2), 1.0, 16)
    mixed = np.array([[1.0, 0.3 + 0.2j], [0.4j, 1.0]])
    value = np.array([-1.0 + 300j, -1.0 + (300.0 + 1e-9) * 1j])
    parted = sense.parted(value, mixed)
    np.testing.assert_allclose(sense.of(parted), [-1.0, 1.0], atol=1e-14)
    # From y to z is forward: z follows a quarter of a turn behind.
    np.testing.assert_allclose(parted[1] / parted[0], [1j, -1j], atol=1e-14)
    np.testing.assert_array_equal(np.max(np.abs(parted), axis=0), 1.0)
    for other in ([300j, 301j], [-1.0, -1.0], [300j, -1.0 + 300j]):
        np.testing.assert_array_equal(sense.parted(np.array(other), mixed), mixed)


def test_torsion_of_one_frequency_is_left_as_it_is() -> None:
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0)
    rotating = rotating_scene(elastic_rigs.scene(line, 0.0))
    mixed = np.array([[1.0, 0.3 + 0.2j], [0.4j, 1.0]])
    found = WhirlSense(rotating, np.zeros(2), 1.0, 16).parted(np.array([1j, 1j]), mixed)
    np.testing.assert_array_equal(found, mixed)
