"""Harmonic balance against shooting, and its Jacobian against differences."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

from cardan_dyn.motion.vibration.model.motion_equation import MotionEquation, motion_equation
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import (
    course_of,
    found_near,
    jacobian,
    solved,
)

BETA = np.radians(30.0)


@pytest.fixture(scope="module")
def model() -> MotionEquation:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), BETA)
    return motion_equation(rotating_scene(scene), 0.2)


@pytest.mark.slow
def test_motions_are_those_of_shooting(model: MotionEquation) -> None:
    speed = np.array([0.21, 0.7, 1.4])
    groups = found_near(model, speed, np.zeros((3, model.count, 1)))
    assert sum(len(found.index) for found in groups) == 3
    for found in groups:
        assert np.all(found.sign == 1)
        for item, place in enumerate(found.index):
            q, rate = found.course.q[item, 0], found.course.rate[item, 0]
            expected = periodic(SpringInFront(BETA, speed[place]), np.r_[q, rate])
            np.testing.assert_allclose(np.r_[q, rate], expected.start, atol=2e-12)
            assert found.model.count == len(found.course.q[item])


def test_jacobian_against_differences(model: MotionEquation) -> None:
    speed, count = np.array([0.8]), model.count
    q = 0.05 * np.sin(2.0 * model.positions)[None, :, None]
    equation = model.along(course_of(q, speed, model.period))
    matrix = jacobian(equation, speed, model.period)[0]
    direction = np.random.default_rng(5).normal(size=(1, count, 1))
    sides = [
        model.along(course_of(q + sense * 1e-5 * direction, speed, model.period)).efforts
        for sense in (1.0, -1.0)
    ]
    difference = (sides[0] - sides[1])[0, :, 0] / 2e-5
    expected = matrix @ direction[0, :, 0]
    np.testing.assert_allclose(difference, expected, atol=1e-7 * np.max(np.abs(expected)))


def test_motions_that_are_larger_than_asked_do_not_converge(model: MotionEquation) -> None:
    # At a forced resonance without damping the motion is larger than 0.2 rad.
    _, converged = solved(model, np.array([0.5, 1.4]), np.zeros((2, model.count, 1)))
    assert converged.tolist() == [False, True]


def test_nodes_grow_with_the_orders_of_the_motion(model: MotionEquation) -> None:
    speed = np.array([0.05, 3.0])
    groups = found_near(model.on(9), speed, np.zeros((2, 9, 1)))
    counts = {int(place): found.model.count for found in groups for place in found.index}
    assert counts[0] > counts[1]
