"""Scales of functions, computed by hand for two joints and two columns."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest

from cardan_dyn.core.response.columns import (
    ACCELERATION,
    GRAVITY,
    SPEED_SQUARED,
    Acts,
    Column,
    Layout,
)
from cardan_dyn.core.response.scales import Scales

EPS = float(np.finfo(float).eps)
LENGTH, MASS = 0.5, 3.0
LOAD = Column(Acts.JOINT_LOAD, "a")


def scales(*columns: Column, armature: Sequence[float] = (0.0, 0.0)) -> tuple[Scales, Layout]:
    """Scales of a mechanism of 3 kg and 0.5 m, with two outputs and one effort."""
    mechanism = SimpleNamespace(
        characteristic_length=LENGTH,
        coordinates=SimpleNamespace(rate_scale=np.array([1.0, LENGTH])),
        model=SimpleNamespace(
            inertias=[SimpleNamespace(mass=mass) for mass in (0.0, 1.0, 2.0)],
            armature=np.array(armature),
        ),
    )
    layout = Layout(columns, ("a", "b"), ("a",), ())
    return Scales(mechanism, layout), layout  # type: ignore[arg-type]


def samples(layout: Layout, wrenches: list[list[list[float]]], efforts: list[float]) -> np.ndarray:
    """Three samples, of which the second is the greatest."""
    columns = len(layout.columns)
    values = np.column_stack([np.reshape(wrenches, (columns, -1)), efforts]).ravel()
    return np.stack([0.1 * values, -values, 0.5 * values], axis=1)


def test_functions_are_relative_to_the_greatest_wrench_of_their_joint() -> None:
    measures, layout = scales(SPEED_SQUARED, LOAD)
    values = samples(
        layout,
        [
            [[4.0, 0.0, 20.0, 0.0, 1.0, 8.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.2]],
            [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0, 0.0, 30.0]],
        ],
        [5.0, 40.0],
    )
    wrenches, efforts = layout.split(measures.of(values))
    # Of `a` the force of 20 N is the greatest, 10 N·m with the length of 0.5 m; forces are
    # relative to the same in newtons.
    np.testing.assert_allclose(wrenches[0, 0], [20.0, 20.0, 20.0, 10.0, 10.0, 10.0])
    # `b` carries less than a tenth of it.
    np.testing.assert_allclose(wrenches[0, 1], [2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(efforts[0], [5.0])
    # The greatest of the load's column is the effort of 40 N·m.
    np.testing.assert_allclose(wrenches[1, 0], [8.0, 8.0, 8.0, 4.0, 4.0, 4.0])
    np.testing.assert_allclose(wrenches[1, 1], [60.0, 60.0, 60.0, 30.0, 30.0, 30.0])
    np.testing.assert_allclose(efforts[1], [40.0])


def test_a_column_of_zeros_has_a_scale_nevertheless() -> None:
    measures, layout = scales(LOAD)
    wrenches, efforts = layout.split(measures.of(np.zeros((layout.size, 4))))
    np.testing.assert_allclose(wrenches[0], 2 * [[0.2, 0.2, 0.2, 0.1, 0.1, 0.1]])
    np.testing.assert_allclose(efforts, [[0.1]])


@pytest.mark.parametrize(
    ("column", "term"),
    [
        (SPEED_SQUARED, MASS * LENGTH**2),
        (ACCELERATION, MASS * LENGTH**2),
        (GRAVITY[1], MASS * LENGTH),
    ],
    ids=lambda value: getattr(value, "label", None),
)
def test_rounding_of_weight_and_inertia_is_empty(column: Column, term: float) -> None:
    measures, layout = scales(column, LOAD)
    small, great = 0.9 * EPS * term, 1.1 * EPS * term
    wrenches = np.zeros((2, 2, 6))
    # A force counts with the length.
    wrenches[0, 0, 5], wrenches[0, 1, 0], wrenches[1, 0, 5] = small, great / LENGTH, small
    values = samples(layout, wrenches.tolist(), [small, small])
    is_empty, efforts_empty = layout.split(measures.empty(values))
    assert is_empty[0].tolist() == [6 * [True], 6 * [False]]
    # Nothing but zeros of a load is empty.
    assert is_empty[1].tolist() == [6 * [False], 6 * [True]]
    assert efforts_empty.tolist() == [[True], [False]]


def test_rotors_are_inertia() -> None:
    """Those of turns as they are, those of slides as masses at the length."""
    measures, layout = scales(ACCELERATION, armature=(0.7, 3.0))
    term = MASS * LENGTH**2 + 0.7 + 3.0 * LENGTH**2
    wrenches = np.zeros((1, 2, 6))
    wrenches[0, 0, 5], wrenches[0, 1, 5] = 0.9 * EPS * term, 1.1 * EPS * term
    is_empty, _ = layout.split(measures.empty(samples(layout, wrenches.tolist(), [0.0])))
    assert is_empty[0].tolist() == [6 * [True], 6 * [False]]


def test_cancellation_compares_inertial_terms_with_what_is_left_of_them() -> None:
    measures, layout = scales(SPEED_SQUARED, LOAD)
    wrenches = np.zeros((2, 2, 6))
    wrenches[0, 1, 2], wrenches[1, 0, 3] = 8.0, 100.0
    values = samples(layout, wrenches.tolist(), [3.0, 0.0])
    proven = SimpleNamespace(inertia=np.array([10.0, 60.0, 20.0]))
    # 60 N·m against a force of 8 N at 0.5 m.
    assert measures.cancellation(values, proven) == 1.0 + 60.0 / 4.0  # type: ignore[arg-type]
    assert measures.cancellation(0.0 * values, proven) == 1.0  # type: ignore[arg-type]
    without, layout = scales(LOAD)
    values = np.ones((layout.size, 3))
    assert without.cancellation(values, proven) == 1.0  # type: ignore[arg-type]


def test_only_the_column_of_speed_keeps_the_rounding_of_inertial_terms() -> None:
    measures, layout = scales(LOAD, SPEED_SQUARED, ACCELERATION)
    wrenches, efforts = layout.split(measures.rounding(5.0, 7.0))
    for index, expected in enumerate((0.0, 10.0 * EPS * 5.0 * 7.0, 0.0)):
        np.testing.assert_allclose(wrenches[index], expected)
        np.testing.assert_allclose(efforts[index], expected)
