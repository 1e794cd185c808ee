"""Vectors that are drawn: sums, directions and distances from the sweep's own wrenches."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.viewer.vectors import Vectors, collect, greatest, legible

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
            item.parts["torsion"] + item.parts["bending"], in_world.moment[SAMPLES], atol=1e-12
        )
        np.testing.assert_allclose(item.force, in_world.force[SAMPLES], atol=1e-12)
        for along, across in (("torsion", "bending"), ("axial", "shear")):
            beside = np.sum(item.parts[across] * item.axis, axis=1)
            np.testing.assert_allclose(beside, 0.0, atol=1e-12)
            np.testing.assert_allclose(np.cross(item.parts[along], item.axis), 0.0, atol=1e-12)
        np.testing.assert_allclose(item.moment, loaded_turn[name].moment[SAMPLES])


def test_axial_and_shear_make_up_the_force_and_a_ball_has_it_whole() -> None:
    mechanism = cd.load("stewart_platform")
    legs = [name for name in mechanism.joints if name.startswith("leg_")]
    turn = cd.Scene(mechanism, drive=legs, gravity=(0.0, 0.0, -9.81)).sweep(np.zeros((3, 6)))
    kinds = set()
    for item in collect(turn, turn.outputs, np.arange(3), RADIUS):
        whole = turn.wrench(item.name, "world").force
        if mechanism.joints[item.name].type == "spherical":
            assert set(item.parts) == {"force", "bending"}
            np.testing.assert_allclose(item.parts["force"], whole, atol=1e-9)
        else:
            np.testing.assert_allclose(item.parts["axial"] + item.parts["shear"], whole, atol=1e-9)
        kinds |= set(item.parts)
    assert kinds == {"torsion", "bending", "axial", "shear", "force"}


def test_a_peak_that_stands_alone_does_not_hide_the_other_arrows() -> None:
    calm, none = np.full((20, 3), [3.0, 0.0, 4.0]), np.zeros((20, 3))
    assert legible([calm, none]) == 5.0
    twice, lonely, short = calm.copy(), calm.copy(), none.copy()
    twice[7] *= 2.0
    lonely[7] *= 1e6
    short[7] = calm[7]
    assert legible([none, twice]) == 10.0
    assert legible([lonely, none]) == pytest.approx(15.0)
    assert legible([none, short]) == 5.0  # Nothing else is there that it could hide.


def test_greatest_sizes(vectors: dict[str, Vectors]) -> None:
    # Statically, shaft 2 carries 10 N·m along its axis and at most 10 tan β across it.
    assert greatest(vectors["bearing_out"].moment) == pytest.approx(10.0 / np.cos(0.6))
    for item in vectors.values():
        assert greatest(item.force) == np.max(np.sqrt(np.sum(item.force**2, axis=1)))


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
