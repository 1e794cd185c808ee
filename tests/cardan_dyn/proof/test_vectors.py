"""Products of vectors of floats and of arrays, and greatest sizes where squares overflow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cardan_dyn.core.proof.vectors import (
    ZERO,
    Vector,
    add,
    combine,
    component,
    components,
    cross,
    dot,
    greatest,
    greatest_norm,
    norm,
    ratio,
    scale,
    subtract,
    times,
    total,
)

NAN, INF = math.nan, math.inf


def vectors(values: np.ndarray) -> list[Vector]:
    """Return `(k, 3)` numbers as vectors of floats, or `(k, 3, N)` as vectors of arrays."""
    if values.ndim == 2:
        return [(x, y, z) for x, y, z in values.tolist()]
    return [(x, y, z) for x, y, z in values]


def as_array(vector: Vector, shape: tuple[int, ...]) -> np.ndarray:
    """Return a vector of which some components may be known to be zero as `(3,)` or `(3, N)`."""
    return np.array([np.broadcast_to(part, shape[1:]) for part in vector])


@pytest.mark.parametrize("shape", [(3,), (3, 4)])
def test_products_are_those_of_numpy(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    arrays = rng.normal(size=(5, *shape))
    arrays[4] = 0.0
    for i, j in np.ndindex(5, 5):
        (first, second), (a, b) = arrays[[i, j]], vectors(arrays[[i, j]])
        np.testing.assert_array_equal(add(a, b), first + second)
        np.testing.assert_array_equal(subtract(a, b), first - second)
        np.testing.assert_allclose(cross(a, b), np.cross(first, second, axis=0), atol=1e-15)
        np.testing.assert_allclose(dot(a, b), np.sum(first * second, axis=0), atol=1e-15)
        np.testing.assert_allclose(norm(a), np.linalg.norm(first, axis=0), rtol=1e-15)
        for factor in (0.0, 1.0, -1.0, 2.5):
            np.testing.assert_array_equal(as_array(scale(a, factor), shape), factor * first)


@pytest.mark.parametrize("shape", [(3,), (3, 4)])
def test_components_and_the_vectors_that_have_them(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    axes, a = rng.normal(size=(3, *shape)), rng.normal(size=shape)
    x, y, z = vectors(axes)
    for factors in ((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), (-1.0, 2.0, 0.5)):
        expected = np.tensordot(factors, axes, 1)
        found = as_array(combine((x, y, z), factors), shape)
        np.testing.assert_allclose(found, expected, atol=1e-15)
        (own,) = vectors(a[None])
        np.testing.assert_allclose(component(own, factors), np.tensordot(factors, a, 1), atol=1e-15)
    np.testing.assert_allclose(components((x, y, z), own), np.sum(axes * a, axis=1), atol=1e-14)


def test_zero_is_left_out() -> None:
    a = (np.ones(2), 2.0, np.ones(2))
    assert add(a, ZERO) is a
    assert add(ZERO, a) is a
    assert subtract(a, ZERO) is a
    assert scale(a, 1.0) is a
    for nothing in (cross(a, ZERO), scale(a, 0.0), scale(ZERO, 3.0), combine([a], [0.0])):
        assert nothing is ZERO
    assert dot(a, ZERO) == norm(ZERO) == greatest_norm([ZERO]) == 0.0
    assert [times(3.0, factor) for factor in (0.0, 1.0, -1.0, 2.0)] == [0.0, 3.0, -3.0, 6.0]
    assert total([]) == 0.0
    assert total([0.0, 2.0, 0.0, 3.0]) == 5.0
    assert subtract(ZERO, (1.0, -2.0, 3.0)) == (-1.0, 2.0, -3.0)


@pytest.mark.parametrize("values", [[NAN, 1.0], [1.0, NAN, 2.0], [1.0, NAN], [-INF, NAN]])
def test_the_greatest_of_what_is_not_a_number_is_none(values: list[float]) -> None:
    assert math.isnan(greatest(values))
    arrays = [np.array([value, 5.0]) for value in values]
    for mixed in (arrays, [*arrays, 3.0], [NAN, *arrays[:1]]):
        assert np.isnan(greatest(mixed)[0])


def test_the_greatest_absolute_value() -> None:
    assert greatest([]) == 0.0
    assert greatest([1.0, -3.0, 2.0]) == 3.0
    assert greatest([-INF, 1.0]) == INF
    found = greatest([2.0, np.array([-1.0, -4.0]), np.array([0.5, 5.0]), 0.0])
    np.testing.assert_array_equal(found, [2.0, 5.0])


def test_ratios_of_zero_and_of_very_small_numbers() -> None:
    assert ratio(1.0, 4.0) == 0.25
    assert ratio(0.0, 0.0) == ratio(0.0, 5.0) == 0.0
    assert ratio(2.0, 0.0) > 1e299
    assert ratio(1e-305, 0.0) < 1e-4
    assert math.isnan(ratio(NAN, 1.0))


def test_norms_are_greatest_of_each_sample() -> None:
    values = np.zeros((2, 3, 3))
    values[0, 0] = [3.0, 0.0, 1.0]
    values[0, 1] = [4.0, 0.0, 0.0]
    values[1, 2] = [0.0, 7.0, 0.0]
    np.testing.assert_allclose(greatest_norm(vectors(values)), [5.0, 7.0, 1.0], rtol=1e-15)
    assert greatest_norm([]) == 0.0
    np.testing.assert_array_equal(greatest_norm(vectors(np.zeros((2, 3, 4)))), np.zeros(4))


@given(exponent=st.integers(-900, 900), seed=st.integers(0, 1000))
@example(exponent=509, seed=0)
def test_norms_scale_with_vectors_even_where_squares_overflow_or_vanish(
    exponent: int, seed: int
) -> None:
    values = np.random.default_rng(seed).normal(size=(3, 3, 2))
    expected = np.ldexp(greatest_norm(vectors(values)), exponent)
    found = greatest_norm(vectors(np.ldexp(values, exponent)))
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    one = greatest_norm(vectors(np.ldexp(values[..., 0], exponent)))
    np.testing.assert_allclose(one, expected[0], rtol=1e-14)


@pytest.mark.parametrize("value", [INF, NAN])
def test_the_norm_of_what_is_not_finite_is_not_finite(value: float) -> None:
    assert not math.isfinite(greatest_norm([(1.0, 2.0, 3.0), (0.0, value, 1.0)]))
    with np.errstate(invalid="ignore"):
        found = greatest_norm([(np.ones(2), np.ones(2), np.array([value, 1.0]))])
    assert np.isfinite(found).tolist() == [False, True]
