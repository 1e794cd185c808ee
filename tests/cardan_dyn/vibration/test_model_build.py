"""Builds of reduced models: their size, and whether their error is what it says."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import AccuracyError
from cardan_dyn.vibration.model_build import ModelBuild
from cardan_dyn.vibration.periodic_grid import interpolation
from cardan_dyn.vibration.rotating_scene import rotating_scene

RIG = elastic_rigs.elastic_rig()


def build(urdf: str, beta: float) -> ModelBuild:
    return ModelBuild(rotating_scene(elastic_rigs.scene(urdf, beta)))


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
    found = np.einsum("kn,npf,kp->kf", weights, model.coefficients, values)
    assert np.max(np.abs(found - exact)) < 1e-12


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
