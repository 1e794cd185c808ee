"""Reduced models against equations by hand, with complex steps."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

from cardan_dyn.motion.vibration.model.build import ModelBuild
from cardan_dyn.motion.vibration.model.reduced_model import Course, ReducedModel
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import course_of

BETA, SPEED = np.radians(20.0), 0.8
SYSTEM = TiltingShaft(BETA, SPEED, 0.3, 1.2, 1.5, 0.02)
STEP = 1e-100


@pytest.fixture(scope="module")
def model() -> ReducedModel:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02), BETA)
    return ModelBuild(rotating_scene(scene)).model(np.zeros(2), np.full(2, 0.25))


@pytest.fixture(scope="module")
def course(model: ReducedModel) -> Course:
    x = 2.0 * model.positions
    q = np.stack([0.1 * np.cos(x) + 0.02, 0.12 * np.sin(x) - 0.05 * np.cos(2.0 * x)], axis=1)
    return course_of(q[None], np.array([SPEED]), model.period)


@pytest.mark.slow
def test_efforts_are_mass_times_what_is_missing(model: ReducedModel, course: Course) -> None:
    equation = model.equation(course)
    missing = np.array(
        [
            course.bend[0, k] - SYSTEM(phi, course.q[0, k], course.rate[0, k])
            for k, phi in enumerate(model.positions)
        ]
    )
    expected = SPEED**2 * np.einsum("nij,nj->ni", equation.mass[0], missing)
    np.testing.assert_allclose(equation.efforts[0], expected, atol=1e-12)
    np.testing.assert_allclose(model.efforts(course), equation.efforts, atol=1e-15)


@pytest.mark.slow
def test_scale_is_that_of_terms_that_cancel(model: ReducedModel, course: Course) -> None:
    """Along a free motion efforts vanish, and their terms do not."""
    bend = np.array(
        [SYSTEM(phi, course.q[0, k], course.rate[0, k]) for k, phi in enumerate(model.positions)]
    )[None]
    equation = model.equation(course._replace(bend=bend))
    inertia = np.abs(SPEED**2 * np.einsum("nij,nj->ni", equation.mass[0], bend[0]))
    # All other terms together are as great as that of the accelerations.
    assert np.all(equation.scale[0] >= 2.0 * np.max(inertia, axis=0) - 1e-12)
    assert np.all(equation.scale[0] < 20.0 * np.max(inertia, axis=0))


def test_derivatives_against_complex_steps(model: ReducedModel, course: Course) -> None:
    """Of r = M (q̈ - f) where r vanishes: -M ∂f; the accelerations follow the equation here."""
    bend = np.array(
        [SYSTEM(phi, course.q[0, k], course.rate[0, k]) for k, phi in enumerate(model.positions)]
    )[None]
    equation = model.equation(course._replace(bend=bend))
    assert np.max(np.abs(equation.efforts)) < 1e-12
    for k, phi in enumerate(model.positions):
        q, rate = (item[0, k].astype(complex) for item in (course.q, course.rate))
        for column in range(2):
            step = np.eye(2)[column] * 1j * STEP
            stiff = SPEED**2 * SYSTEM(phi, q + step, rate).imag / STEP
            damp = SPEED * SYSTEM(phi, q, rate + step).imag / STEP
            mass = equation.mass[0, k]
            np.testing.assert_allclose(
                equation.stiffness[0, k, :, column], -mass @ stiff, atol=2e-11
            )
            np.testing.assert_allclose(equation.damping[0, k, :, column], -mass @ damp, atol=1e-12)


def test_more_nodes_carry_the_same_functions(model: ReducedModel) -> None:
    finer = model.on(3 * model.count)

    def at(part: ReducedModel) -> Course:
        shape = (1, part.count, 2)
        still, bend = np.full(shape, 0.07), np.full(shape, 0.3)
        return Course(still, np.full(shape, -0.2), bend, np.array([SPEED]))

    for name in ("efforts", "mass", "damping", "stiffness", "slope"):
        coarse, fine = (getattr(part.equation(at(part)), name) for part in (model, finer))
        np.testing.assert_allclose(fine[:, ::3], coarse, atol=1e-13)


def test_models_on_as_many_nodes_are_made_once(model: ReducedModel) -> None:
    assert model.on(model.count) is model
    assert model.on(3 * model.count) is model.on(3 * model.count)


def test_many_motions_are_those_one_by_one(model: ReducedModel, course: Course) -> None:
    """They are computed in parts."""
    count = 400
    sizes = np.linspace(0.1, 1.0, count)[:, None, None]
    every = Course(*(sizes * item for item in course[:3]), np.linspace(0.5, 2.0, count))
    found = model.equation(every)
    for row in (0, 123, count - 1):
        one = model.equation(Course(*(item[row : row + 1] for item in every)))
        for first, second in zip(found, one, strict=True):
            np.testing.assert_allclose(first[row], second[0], rtol=1e-12, atol=1e-15)
