"""Fourier sums on periodic grids."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.kit.periodic import (
    MOST_NODES,
    amplitudes,
    derivatives,
    interpolation,
    next_size,
    nodes,
    orders_of,
    resampled,
    shifted,
    tail,
)

PERIOD = np.pi


def wave(x: np.ndarray) -> np.ndarray:
    return 0.3 + np.sin(2.0 * x) - 0.2 * np.cos(8.0 * x)


@pytest.mark.parametrize("count", [9, 15, 31])
def test_derivatives(count: int) -> None:
    x = nodes(count, PERIOD)
    first, second = derivatives(count, PERIOD)
    exact = 2.0 * np.cos(2.0 * x) + 1.6 * np.sin(8.0 * x)
    np.testing.assert_allclose(first @ wave(x), exact, atol=1e-12)
    exact = -4.0 * np.sin(2.0 * x) + 12.8 * np.cos(8.0 * x)
    np.testing.assert_allclose(second @ wave(x), exact, atol=1e-11)


def test_values_between_and_on_the_nodes() -> None:
    x = nodes(15, PERIOD)
    points = np.array([-7.3, 0.0, 0.1, x[4], x[4] + PERIOD, 12.0])
    found = interpolation(points, 15, PERIOD) @ wave(x)
    np.testing.assert_allclose(found, wave(points), atol=1e-13)


def test_resampling_and_amplitudes() -> None:
    values = wave(nodes(9, PERIOD))[:, None]
    np.testing.assert_allclose(resampled(values, 21)[:, 0], wave(nodes(21, PERIOD)), atol=1e-14)
    # With fewer nodes, what they cannot carry is left out.
    rough = 0.3 + np.sin(2.0 * nodes(5, PERIOD))
    np.testing.assert_allclose(resampled(values, 5)[:, 0], rough, atol=1e-15)
    found = amplitudes(values)[:, 0]
    np.testing.assert_allclose(found, [0.3, -1j, 0.0, 0.0, -0.2], atol=1e-15)


def test_tail_is_that_of_the_highest_orders() -> None:
    x = nodes(31, PERIOD)
    assert tail(wave(x)) < 1e-15
    assert tail(wave(x) + 1e-6 * np.sin(30.0 * x)) == pytest.approx(1e-6 / 1.5, rel=0.4)
    # Order 13 of 15 is not among the highest eighth, two of them.
    assert tail(np.sin(26.0 * x)) < 1e-14
    assert tail(np.zeros(15)) == 0.0


def test_orders_are_cycles_per_revolution() -> None:
    assert orders_of(3, PERIOD).tolist() == [0.0, 2.0, 4.0]


def test_sizes_are_odd_and_bounded() -> None:
    assert [next_size(value) % 2 for value in (1, 10, 64, 1e9)] == [1, 1, 1, 1]
    assert next_size(22) == 31
    assert next_size(1e9) == MOST_NODES


def test_an_even_number_has_one_order_without_a_sine() -> None:
    turn = 2.0 * np.pi * np.arange(8) / 8
    values = 1.0 + 3.0 * np.cos(turn + 0.3)[:, None] + 0.5 * np.cos(4.0 * turn)[:, None]
    expected = [1.0, 3.0 * np.exp(0.3j), 0.0, 0.0, 0.5]
    np.testing.assert_allclose(amplitudes(values)[:, 0], expected, atol=1e-15)
    fine = 2.0 * np.pi * np.arange(24) / 24
    between = 1.0 + 3.0 * np.cos(fine + 0.3) + 0.5 * np.cos(4.0 * fine)
    np.testing.assert_allclose(resampled(values, 24)[:, 0], between, atol=1e-14)
    np.testing.assert_allclose(resampled(between, 8), values[:, 0], atol=1e-14)


def test_values_behind_the_nodes() -> None:
    x = nodes(15, PERIOD)
    behind = wave(x + 0.3 * PERIOD / 15)
    np.testing.assert_allclose(shifted(wave(x)[None], 0.3, 1)[0], behind, atol=1e-14)
