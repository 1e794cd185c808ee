"""Builds of reduced models: their size, and whether their error is what it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

from cardan_dyn import AccuracyError
from cardan_dyn.kit.periodic import interpolation, nodes
from cardan_dyn.motion.vibration.model.build import FINE, ROUGH, ModelBuild
from cardan_dyn.motion.vibration.model.reduced_model import ReducedModel
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import course_of

RIG = elastic_rigs.elastic_rig()


def build(urdf: str, beta: float) -> ModelBuild:
    return ModelBuild(rotating_scene(elastic_rigs.scene(urdf, beta)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("urdf", "free", "half"), [(elastic_rigs.torsional_line(), 1, 0.4), (RIG, 2, 0.1)]
)
def test_error_holds_between_the_nodes(urdf: str, free: int, half: float) -> None:
    builder = build(urdf, 0.5)
    model = builder.model(np.zeros(free), np.full(free, half))
    assert model.divisor == 2
    assert model.error < 2e-13
    random = np.random.default_rng(4)
    drive, q = random.uniform(0.0, 9.0, 30), random.uniform(-half, half, (30, free))
    exact = builder.efforts.terms(np.column_stack([drive, q])).flat()
    weights = interpolation(drive, model.count, model.period)
    values = model.basis.values(q / half)
    found = np.einsum("kn,npf,pk->kf", weights, model.coefficients, values)
    assert np.max(np.abs(found - exact)) < 1e-12


def test_error_of_a_coarse_model_is_said() -> None:
    """Quadratic polynomials leave about what the third order of a swing by 0.4 rad is."""
    builder = build(elastic_rigs.torsional_line(), 0.5)
    half = 0.4
    model = builder._built(np.zeros((31, 1)), np.array([half]), (2,), 2)
    random = np.random.default_rng(6)
    drive, q = random.uniform(0.0, np.pi, 200), random.uniform(-half, half, (200, 1))
    exact = builder.efforts.terms(np.column_stack([drive, q])).mass[:, 0, 0]
    weights = interpolation(drive, model.count, model.period)
    values = model.basis.values(q / half)
    found = np.einsum("kn,npf,pk->kf", weights, model.coefficients, values)[:, 0]
    gap = np.max(np.abs(found - exact)) / np.max(exact)
    assert model.error > 0.3 * gap > 1e-4


def test_unbalance_takes_the_whole_revolution() -> None:
    heavy = '<link name="shaft_out"><inertial>'
    unbalanced = RIG.replace(heavy, f'{heavy}<origin xyz="0.1 0.01 0"/>')
    assert unbalanced != RIG
    model = build(unbalanced, 0.1).model(np.zeros(2), np.full(2, 0.05))
    assert (model.divisor, model.period) == (1, pytest.approx(2.0 * np.pi))


def test_wider_ranges_take_higher_degrees() -> None:
    builder = build(elastic_rigs.torsional_line(), 0.5)
    sizes = [len(builder.model(np.zeros(1), np.array([half])).basis.nodes) for half in (0.05, 0.9)]
    assert sizes[0] < 12 < sizes[1]


def test_what_is_not_smooth_within_its_range_is_refused() -> None:
    # Tilted by a right angle, the joint locks.
    with pytest.raises(AccuracyError, match="no smooth functions of the free coordinates"):
        build(RIG, 0.3).model(np.zeros(2), np.full(2, 1.25))


@pytest.mark.slow
def test_a_model_about_a_large_motion() -> None:
    """Against the shaft's equations by hand, at places between those of the model."""
    beta, speed, half, turns = 0.8, 0.9, np.full(2, 0.02), nodes(31, np.pi)

    def motion(x: np.ndarray) -> np.ndarray:
        return np.stack([0.4 * np.cos(2.0 * x) - 0.2, 0.5 * np.sin(2.0 * x)], axis=-1)

    builder = build(RIG, beta)
    with pytest.raises(AccuracyError):
        builder.model(np.zeros(2), np.full(2, 0.6))
    model = builder.along(motion(turns), half, 2)
    assert model.error < 1e-11
    np.testing.assert_allclose(model.centre, motion(model.positions), atol=1e-14)
    way = 0.7 * half * np.stack([np.sin(4.0 * model.positions), np.cos(2.0 * model.positions)], 1)
    course = course_of((model.centre + way)[None], np.array([speed]), model.period)
    equation, system = model.equation(course), TiltingShaft(beta, speed)
    missing = [
        course.bend[0, k] - system(phi, course.q[0, k], course.rate[0, k])
        for k, phi in enumerate(model.positions)
    ]
    expected = speed**2 * np.einsum("nij,nj->ni", equation.mass[0], np.array(missing))
    np.testing.assert_allclose(equation.efforts[0], expected, atol=1e-10)


@pytest.mark.slow
def test_rough_models_are_small() -> None:
    builder = build(RIG, 0.3)
    fine, rough = (
        builder.model(np.zeros(2), np.full(2, 0.2), wanted=wanted) for wanted in (FINE, ROUGH)
    )
    assert fine.error < 1e-12
    assert 1e-9 < rough.error < 1e-3
    assert 4 * rough.coefficients.size < fine.coefficients.size


@pytest.mark.slow
def test_too_many_polynomials_are_said_to_be() -> None:
    # At a steep joint two tilts take more polynomials than are tried.
    builder = build(RIG, np.radians(70.0))
    with pytest.raises(AccuracyError, match="polynomials, more than"):
        builder.model(np.zeros(2), np.full(2, 0.3))


def test_nodes_are_not_added_where_degrees_leave_the_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    builder = build(RIG, 0.5)
    sizes: list[int] = []
    built = ModelBuild._built

    def low(self: ModelBuild, *given: object) -> tuple[tuple[int, ...], float]:
        return (6, 6), 1e-10

    def counted(self: ModelBuild, q: np.ndarray, *given: Any) -> ReducedModel:
        sizes.append(len(q))
        return built(self, q, *given)

    monkeypatch.setattr(ModelBuild, "_degrees", low)
    monkeypatch.setattr(ModelBuild, "_built", counted)
    assert 1e-12 < builder.along(np.zeros((15, 2)), np.full(2, 0.02), 2).error < 1e-9
    assert max(sizes) <= 63
