"""Vectors that are drawn: sums, directions and distances from the sweep's own wrenches."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.viewer.vectors import Vectors, collect

SAMPLES = np.arange(0, 25, 2)
RADIUS = 0.5


@pytest.fixture(scope="module")
def vectors(loaded_turn: cd.Sweep) -> dict[str, Vectors]:
    collected = collect(loaded_turn, loaded_turn.outputs, SAMPLES, RADIUS)
    assert [item.name for item in collected] == list(loaded_turn.outputs)
    return {item.name: item for item in collected}


def test_torsion_and_bending_make_up_the_moment(
    vectors: dict[str, Vectors], loaded_turn: cd.Sweep
) -> None:
    for name, item in vectors.items():
        in_world = loaded_turn.wrench(name, "world")
        np.testing.assert_allclose(
            item.torsion + item.bending, in_world.moment[SAMPLES], atol=1e-12
        )
        np.testing.assert_allclose(item.force, in_world.force[SAMPLES], atol=1e-12)
        np.testing.assert_allclose(np.sum(item.bending * item.axis, axis=1), 0.0, atol=1e-12)
        np.testing.assert_allclose(np.cross(item.torsion, item.axis), 0.0, atol=1e-12)
        np.testing.assert_allclose(item.moment, loaded_turn[name].moment[SAMPLES])


def test_greatest_sizes(vectors: dict[str, Vectors]) -> None:
    # Statically, shaft 2 carries 10 N·m along its axis and at most 10 tan β across it.
    assert vectors["bearing_out"].greatest_moment == pytest.approx(10.0 / np.cos(0.6))
    for item in vectors.values():
        assert item.greatest_force == np.max(np.sqrt(np.sum(item.force**2, axis=1)))


def test_only_shafts_in_fixed_bearings_turn(vectors: dict[str, Vectors]) -> None:
    assert vectors["bearing_in"].turns
    # Its bearing is carried by the joint angle, which is held: it stands still as well.
    assert vectors["bearing_out"].turns
    # The cross is carried by a shaft that turns; a held joint does not turn.
    assert not vectors["pin_in"].turns
    assert not vectors["joint_angle"].turns


def test_moments_start_on_the_axis_apart_from_each_other(vectors: dict[str, Vectors]) -> None:
    starts = [item.anchor[0] for item in vectors.values()]
    for item in vectors.values():
        np.testing.assert_allclose(np.cross(item.anchor - item.origin, item.axis), 0.0, atol=1e-12)
    for index, start in enumerate(starts):
        for other in starts[:index]:
            assert np.linalg.norm(start - other) > 0.13 * RADIUS


def test_joints_left_out_of_the_solution_are_left_out() -> None:
    scene = cd.Scene(
        cd.load("double_shaft_z"),
        drive="bearing_in",
        held={"joint_angle_1": 0.3, "joint_angle_2": 0.3},
        loads={"bearing_out": -1.0},
        outputs=["bearing_in"],
    )
    (item,) = collect(scene.sweep([0.0, 0.5]), ("bearing_in",), np.arange(2), 1.0)
    assert item.name == "bearing_in" and item.force.shape == (2, 3)
