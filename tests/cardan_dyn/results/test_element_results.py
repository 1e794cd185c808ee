"""Results of elements: found by index and by name, in the shape of the samples."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import cardan_dyn as cd

SPRING = cd.PointSpring("crank", (0.1, 0, 0), "rocker", (0.1, 0, 0), 500.0, 3.0, 0.2, name="coil")
TORSION = cd.JointSpring("rocker_bearing", 5.0, 0.3, 0.2)
PUSH = cd.Actuator("rocker_bearing", np.cos)
BUSHING = cd.Bushing("coupler", "rocker", (0.3, 0.0, 0.0), np.arange(1.0, 7.0), name="rubber")


@pytest.fixture(scope="module")
def scene() -> cd.Scene:
    elements = [SPRING, TORSION, PUSH, BUSHING]
    return cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=elements)


def test_elements_are_found_by_index_and_by_name(scene: cd.Scene) -> None:
    forces = scene.sweep([0.1, 0.2, 0.3]).element_force
    assert list(forces) == ["coil", 1, 2, "rubber"]
    assert len(forces) == 4
    assert forces["coil"] is forces[0]
    assert forces["rubber"] is forces[3]
    assert ("coil" in forces, 3 in forces, "lost" in forces, 4 in forces) == (
        *[True] * 2,
        False,
        False,
    )
    for wrong in ("lost", 4, -1, [1]):
        with pytest.raises(cd.ModelError, match=r"no element .*; elements: "):
            forces[wrong]
    assert repr(forces) == "<ElementResults of 1, 2, coil, rubber>"


def test_a_scene_without_elements_has_none() -> None:
    turn = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep([0.1, 0.2])
    assert len(turn.element_force) == 0
    np.testing.assert_array_equal(turn.elastic_energy, np.zeros(2))
    with pytest.raises(cd.ModelError, match="no element 0; the scene has no elements"):
        turn.element_force[0]


def test_results_have_the_shape_of_the_samples(scene: cd.Scene) -> None:
    position, speed = np.linspace(0.0, 6.0, 5)[:, None], np.array([0.0, 1.0, 2.0])
    grid = scene.sweep(position, speed, time=np.full((5, 1), 0.5))
    forces = grid.element_force
    assert forces["coil"].tension.shape == forces["coil"].length.shape == (5, 3)
    assert forces["coil"].force.shape == (5, 3, 3)
    assert forces["rubber"].wrench.shape == forces["rubber"].deformation.shape == (5, 3, 6)
    assert grid.elastic_energy.shape == (5, 3)
    np.testing.assert_allclose(forces[2].effort, np.cos(0.5))
    # By hand, from the motion that the sweep shows.
    angle = grid.motion.position("rocker_bearing")
    rate = grid.motion.velocity("rocker_bearing")
    np.testing.assert_allclose(forces[1].effort, -5.0 * (angle - 0.2) - 0.3 * rate, rtol=1e-12)
    total = sum(force.energy for force in forces.values())
    np.testing.assert_allclose(grid.elastic_energy, total)
    with pytest.raises(ValueError, match="read-only"):
        forces["coil"].tension[0] = 0.0


def test_copies_have_the_same_results(scene: cd.Scene) -> None:
    turn = scene.sweep([0.1, 0.2], speed=3.0, time=[1.0, 2.0])
    again = pickle.loads(pickle.dumps(turn))
    forces = pickle.loads(pickle.dumps(turn.element_force))
    for name, force in turn.element_force.items():
        for one, other, third in zip(force, again.element_force[name], forces[name], strict=True):
            np.testing.assert_array_equal(one, other)
            np.testing.assert_array_equal(one, third)
    np.testing.assert_array_equal(again.time, [1.0, 2.0])
