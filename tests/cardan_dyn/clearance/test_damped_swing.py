"""Damped swings: against the complex roots of the equation, in 50 digits."""

from __future__ import annotations

from itertools import islice

import mpmath
import numpy as np
import pytest

from cardan_dyn.clearance.damped_swing import DampedSwing

VALUE, RATE, FREQUENCY = 0.7, -3.0, 5.0
RATIOS = [0.0, 1e-3, 0.25, 0.999, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.01, 1.3, 4.0, 100.0]


def exact(ratio: float, order: int, time: float) -> mpmath.mpf:
    """A derivative of the swing by its two roots, which are apart in 50 digits or coincide."""
    with mpmath.workdps(50):
        frequency, decay = mpmath.mpf(FREQUENCY), mpmath.mpf(ratio * FREQUENCY)
        root = mpmath.sqrt(decay**2 - frequency**2)
        first, second, t = -decay + root, -decay - root, mpmath.mpf(time)
        if first == second:
            slope = RATE - first * VALUE
            return mpmath.re(
                mpmath.exp(first * t)
                * (first**order * (VALUE + slope * t) + order * first ** (order - 1) * slope)
            )
        a = (RATE - second * VALUE) / (first - second)
        b = VALUE - a
        return mpmath.re(
            a * first**order * mpmath.exp(first * t) + b * second**order * mpmath.exp(second * t)
        )


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("order", range(5))
def test_derivatives(ratio: float, order: int) -> None:
    swing = DampedSwing(ratio * FREQUENCY, FREQUENCY, VALUE, RATE)
    times = np.array([0.0, 1e-3, 0.1, 0.7, 3.0])
    wanted = np.array([float(exact(ratio, order, time)) for time in times])
    # The way to a value is as long as those of a swing without damping, or of the slow decay.
    scale = np.maximum(np.abs(wanted), FREQUENCY**order * np.exp(-ratio * FREQUENCY * times))
    np.testing.assert_array_less(np.abs(swing.at(order, times) - wanted), 2e-12 * scale + 1e-300)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("order", [0, 1, 4])
def test_zeros_are_all_sign_changes(ratio: float, order: int) -> None:
    swing = DampedSwing(ratio * FREQUENCY, FREQUENCY, VALUE, RATE)
    times = np.linspace(0.0, 4.0, 4001)[1:]
    values = swing.at(order, times)
    changes = times[1:][values[1:] * values[:-1] < 0.0]
    zeros = [zero for zero in islice(swing.zeros(order), 12) if 1e-3 <= zero <= 4.0]
    assert len(zeros) == len(changes)
    np.testing.assert_allclose(zeros, changes, atol=1e-3)
    for zero in zeros:
        slope = abs(float(exact(ratio, order + 1, zero)))
        assert abs(float(exact(ratio, order, zero))) <= 1e-12 * slope * max(zero, 1.0)


@pytest.mark.parametrize("ratio", [0.0, 1e-3, 0.25])
def test_bounds(ratio: float) -> None:
    swing = DampedSwing(ratio * FREQUENCY, FREQUENCY, VALUE, RATE)
    for order in (2, 3):
        later = np.max(np.abs(swing.at(order, np.linspace(1.0, 10.0, 2001))))
        assert later <= swing.bound(order, 1.0) <= 1.6 * later
    assert DampedSwing(5.0, 5.0, 1.0, 0.0).bound(2, 0.0) == np.inf


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("length", [1e-6, 0.5, 300.0])
def test_panels_are_close_enough_for_quadrature(ratio: float, length: float) -> None:
    swing = DampedSwing(ratio * FREQUENCY, FREQUENCY, VALUE, RATE)
    bounds = swing.panels(length)
    assert (bounds[0], bounds[-1]) == (0.0, length)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.diff(bounds)[:, None]
    rates = swing.at(1, bounds[:-1, None] + half * (1.0 + nodes))
    lost = 2.0 * ratio * FREQUENCY * np.sum(half * weights * rates**2)
    # x'' + 2 α x' + ω² x = 0 times x', integrated.
    x, v = swing.at(0, length), swing.at(1, length)
    begun = 0.5 * (RATE**2 + FREQUENCY**2 * VALUE**2)
    assert lost == pytest.approx(begun - 0.5 * (v**2 + FREQUENCY**2 * x**2), abs=1e-10)
