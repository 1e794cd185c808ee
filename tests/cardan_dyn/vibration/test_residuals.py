"""Residuals of periodic motions, by sweeps of their scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import AccuracyError, VibrationError, vibration
from cardan_dyn.kit.periodic import resampled
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import Motions, course_of, solved
from cardan_dyn.motion.vibration.motions.residuals import _refuse_singular, residuals
from cardan_dyn.motion.vibration.motions.search import MotionSearch


@pytest.fixture(scope="module")
def search() -> MotionSearch:
    return MotionSearch(
        rotating_scene(elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(30.0)))
    )


@pytest.fixture(scope="module")
def motions(search: MotionSearch) -> Motions:
    (found,) = search.primary(np.array([0.7, 0.8]))
    return found


def disturbed(motions: Motions, by: float) -> Motions:
    wave = by * np.cos(6.0 * motions.model.positions)[None, :, None]
    course = motions.course
    moved = course_of(course.q + wave, course.speed, motions.model.period)
    return replace(motions, course=moved)


def test_residual_is_that_of_the_scene(search: MotionSearch, motions: Motions) -> None:
    disturbance = disturbed(motions, 1e-9)
    residual, course = residuals(disturbance), disturbance.course
    position = np.column_stack([motions.model.positions, course.q[1, :, 0]])
    sweep = search.rotating.driven.sweep(position, course.velocities[1], course.accelerations[1])
    left = np.max(np.abs(sweep.drive_effort[:, 1])) / disturbance.equation.scale[1, 0]
    assert 0.9 * residual[1] <= left <= residual[1] * (1.0 + 1e-6)
    assert np.all(residuals(motions) < 1e-3 * residual)


def test_orders_that_nodes_do_not_carry_are_noticed(motions: Motions) -> None:
    """With 15 nodes efforts vanish at these, and leave some 1e-8 between them; with 9, 1e-5."""
    q = resampled(motions.course.q, 45, 1)
    coarse = {}
    for step in (3, 5):
        model = motions.model.on(45 // step)
        found, converged = solved(model, motions.course.speed, q[:, ::step])
        assert np.all(converged)
        coarse[45 // step] = replace(motions, model=model, course=found.course)
    residual = residuals(coarse[15])
    assert np.all((residual > 1e-10) & (residual < 1e-7))
    with pytest.raises(AccuracyError, match="do not vanish along the periodic motion") as caught:
        residuals(coarse[9])
    assert caught.value.residual > caught.value.tolerance


def test_a_motion_that_vanishes_has_a_residual() -> None:
    """A shaft in line is not moved at all; what is left is rounding of nothing."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), 0.0)
    found = vibration.linearise(scene, 0.7)
    assert np.max(np.abs(found.motion)) < 1e-14
    # Gyroscopic moments part the frequencies of both whirls, whose product stays.
    assert np.prod(found.modes().frequency) == pytest.approx(1.0, rel=1e-3)
    assert vibration.periodic_motion(scene, 0.7).residual[0] < 1e-6


def test_equations_that_are_stiff_are_not_singular() -> None:
    """Stiff scenes with many orders have conditions of 1e7 and more; equations that lack a
    direction one of 1e16."""
    speed = np.array([0.7, 0.8])
    matrices = [np.diag([1.0, 1.0, least]) for least in (1e-9, 1e-15)]
    _refuse_singular(np.stack([matrices[0]] * 2), speed)
    with pytest.raises(VibrationError, match="not isolated") as caught:
        _refuse_singular(np.stack(matrices), speed)
    assert caught.value.speed == 0.8


def test_large_errors_are_refused(motions: Motions) -> None:
    with pytest.raises(AccuracyError, match="do not vanish along the periodic motion"):
        residuals(disturbed(motions, 0.8))
