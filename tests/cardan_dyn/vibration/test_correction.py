"""Corrections of periodic motions by sweeps of their scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import AccuracyError, VibrationError
from cardan_dyn.kit.periodic import resampled
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.correction import _refuse_singular, along, corrected
from cardan_dyn.motion.vibration.motions.harmonic_balance import course_of, solved
from cardan_dyn.motion.vibration.motions.models import Motions
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


@pytest.mark.slow
@pytest.mark.parametrize("by", [1e-6, 1e-4])
def test_small_errors_are_corrected(search: MotionSearch, motions: Motions, by: float) -> None:
    found, residual = corrected(search.models.efforts, disturbed(motions, by))
    np.testing.assert_allclose(found.course.q, motions.course.q, atol=1e-12)
    assert np.max(residual) < 1e-10


def test_residual_is_that_of_the_scene(search: MotionSearch, motions: Motions) -> None:
    found, residual = corrected(search.models.efforts, motions)
    course = found.course
    position = np.column_stack([found.model.positions, course.q[1, :, 0]])
    speed, acceleration = course.velocities[1], course.accelerations[1]
    sweep = search.rotating.driven.sweep(
        position, speed, np.column_stack([0.0 * acceleration, acceleration])
    )
    scale = found.model.equation(course).scale[1, 0]
    assert np.max(np.abs(sweep.drive_effort[:, 1])) / scale <= residual[1] * (1.0 + 1e-6) + 1e-15


def test_efforts_between_the_nodes(search: MotionSearch, motions: Motions) -> None:
    moved = disturbed(motions, 1e-3)
    shifted = along(search.models.efforts, moved.model, moved.course, 1.0)
    here = along(search.models.efforts, moved.model, moved.course)
    # A whole step leads to the next node.
    np.testing.assert_allclose(shifted, np.roll(here, -1, axis=1), atol=1e-11)


def test_orders_that_nodes_do_not_carry_are_noticed(search: MotionSearch, motions: Motions) -> None:
    """With 15 nodes efforts vanish at these, and leave some 1e-8 between them; with 9, 1e-5."""
    fine = motions.model.on(45)
    q = resampled(motions.course.q, 45, 1)
    coarse = {}
    for step in (3, 5):
        model = replace(fine, centre=fine.centre[::step], coefficients=fine.coefficients[::step])
        found = solved(model, motions.course.speed, q[:, ::step])
        assert np.all(found.converged)
        coarse[45 // step] = replace(motions, model=model, middle=model, course=found.course)
    _, residual = corrected(search.models.efforts, coarse[15])
    assert np.all((residual > 1e-10) & (residual < 1e-7))
    with pytest.raises(AccuracyError, match="do not vanish along the periodic motion") as caught:
        corrected(search.models.efforts, coarse[9])
    assert caught.value.residual > caught.value.tolerance


def test_equations_that_are_stiff_are_not_singular() -> None:
    """Stiff scenes with many orders have conditions of 1e7 and more; equations that lack a
    direction one of 1e16."""
    speed = np.array([0.7, 0.8])
    matrices = [np.diag([1.0, 1.0, least]) for least in (1e-9, 1e-15)]
    _refuse_singular(np.stack([matrices[0]] * 2), speed)
    with pytest.raises(VibrationError, match="not isolated") as caught:
        _refuse_singular(np.stack(matrices), speed)
    assert caught.value.speed == 0.8


def test_large_errors_are_refused(search: MotionSearch, motions: Motions) -> None:
    with pytest.raises(AccuracyError, match="do not vanish along the periodic motion"):
        corrected(search.models.efforts, disturbed(motions, 0.8))
