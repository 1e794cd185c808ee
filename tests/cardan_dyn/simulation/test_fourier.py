"""Fourier series against the functions that they were sampled from."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.kit.periodic import Fourier

PERIOD = 3.0
FREQUENCY = 2.0 * np.pi / PERIOD
POINTS = np.random.default_rng(0).uniform(-20.0, 20.0, 50)
ROUNDING = 1e-13
"""Some eps times the greatest phase, 40, and values up to 3."""


def values(x: np.ndarray) -> np.ndarray:
    waves = np.cos(FREQUENCY * x), np.sin(3.0 * FREQUENCY * x)
    return np.stack([1.5 + waves[0], waves[1] - 0.2 * waves[0]])


@pytest.fixture
def series() -> Fourier:
    return Fourier.of(values(PERIOD / 16 * np.arange(16)), PERIOD)


def test_values_between_samples(series: Fourier) -> None:
    np.testing.assert_allclose(series(POINTS), values(POINTS), atol=ROUNDING)
    np.testing.assert_allclose(series.at(POINTS[3]), values(POINTS)[:, 3], atol=ROUNDING)


@pytest.mark.parametrize("count", [15, 16])
def test_odd_and_even_numbers_of_samples(count: int) -> None:
    series = Fourier.of(values(PERIOD / count * np.arange(count)), PERIOD)
    np.testing.assert_allclose(series(POINTS), values(POINTS), atol=ROUNDING)


def test_the_derivative_is_that_of_the_waves(series: Fourier) -> None:
    x = POINTS
    expected = [-np.sin(FREQUENCY * x), 3.0 * np.cos(3.0 * FREQUENCY * x)]
    expected[1] = expected[1] + 0.2 * np.sin(FREQUENCY * x)
    np.testing.assert_allclose(
        series.derivative()(x), FREQUENCY * np.array(expected), atol=10.0 * ROUNDING
    )


def test_a_linear_part_is_kept() -> None:
    series = Fourier(np.array([[0.0 + 0.0j, 1.0]]), FREQUENCY, np.array([2.0]))
    np.testing.assert_allclose(series(POINTS)[0], 2.0 * POINTS + np.cos(FREQUENCY * POINTS))
    np.testing.assert_allclose(series.derivative()(np.zeros(1)), [[2.0]], atol=1e-15)
    grid = 0.3 + PERIOD / 8 * np.arange(8)
    np.testing.assert_allclose(series.on_grid(0.3, 8), series(grid), atol=ROUNDING)


def test_the_integral_gains_the_area(series: Fourier) -> None:
    nodes, weights = np.polynomial.legendre.leggauss(30)
    area = 0.35 * values(0.2 + 0.35 * (1.0 + nodes)) @ weights
    gained = series.integral()(np.array([0.9])) - series.integral()(np.array([0.2]))
    np.testing.assert_allclose(gained[:, 0], area, atol=ROUNDING)


def test_short_gains_keep_their_digits(series: Fourier) -> None:
    """Differences of values would be wrong by 1e-16 / 1e-12."""
    way = 1e-12
    slope = series.derivative()(np.array([0.4]))[:, 0]
    np.testing.assert_allclose(
        series.gained(np.array([0.4]), np.array([way]))[:, 0] / way, slope, rtol=1e-10
    )


@pytest.mark.parametrize("count", [8, 9, 64])
def test_a_grid_from_anywhere(series: Fourier, count: int) -> None:
    grid = -1.1 + PERIOD / count * np.arange(count)
    np.testing.assert_allclose(series.on_grid(-1.1, count), values(grid), atol=ROUNDING)


def test_harmonics_that_are_multiples_of_one() -> None:
    """They and the many in between that are none."""
    coefficients = np.zeros((2, 121), dtype=complex)
    coefficients[0, ::3] = np.exp(-0.2 * np.arange(41.0)) * (1.0 + 0.5j)
    coefficients[1, 6] = 1.0
    series = Fourier(coefficients, FREQUENCY, np.array([0.0, 0.4]))
    waves = np.exp(1j * FREQUENCY * np.outer(np.arange(121.0), POINTS))
    expected = (coefficients @ waves).real + np.outer([0.0, 0.4], POINTS)
    np.testing.assert_allclose(series(POINTS), expected, atol=10.0 * ROUNDING)
    np.testing.assert_allclose(series.at(POINTS[7]), expected[:, 7], atol=10.0 * ROUNDING)
    gains = series(POINTS + 0.5) - series(POINTS)
    ways = np.full(len(POINTS), 0.5)
    np.testing.assert_allclose(series.gained(POINTS, ways), gains, atol=30.0 * ROUNDING)
    bent = gains - 0.5 * series.derivative()(POINTS)
    np.testing.assert_allclose(series.bent(POINTS, ways), bent, atol=300.0 * ROUNDING)


def test_many_values_are_those_of_few(series: Fourier) -> None:
    points = np.linspace(-20.0, 20.0, 40_000)
    np.testing.assert_allclose(series(points), values(points), atol=ROUNDING)


def test_the_tail_tells_whether_there_were_enough_samples() -> None:
    def sampled(count: int) -> np.ndarray:
        x = 2.0 * np.pi * np.arange(count) / count
        return Fourier.of(1.0 / (1.2 + np.cos(x))[None, :], 2.0 * np.pi).tail()

    assert sampled(16)[0] > 1e-4
    assert sampled(256)[0] < 1e-14
    assert Fourier.of(np.zeros((1, 8)), 1.0).tail()[0] == 0.0


def test_shortening_drops_what_is_small(series: Fourier) -> None:
    short = series.shortened(1e-12)
    assert short.coefficients.shape[1] == 4
    np.testing.assert_allclose(short(POINTS), values(POINTS), atol=ROUNDING)
    assert Fourier(np.zeros((2, 5), complex), 1.0).shortened(0.1).coefficients.shape == (2, 1)
