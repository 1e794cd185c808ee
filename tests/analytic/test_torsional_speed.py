"""Torsional frequencies, and zones of instability by the monodromy matrix of the full equation.

(J_1 + J_2 eta^2) theta'' + J_2 eta eta' theta'^2 + c (theta - Omega t) = 0 is integrated over half
a turn about its own periodic motion; the ends of a zone are where the trace of the matrix is -2.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from cardan_dyn.analytic import single_joint
from cardan_dyn.analytic import torsional_speed as ts


def half_turn(beta, share, speed, state, steps=250):
    """Deviation p = theta - Omega t and its rate after half a turn; c = J_1 + J_2 = 1."""
    cosine, square = np.cos(beta), np.sin(beta) ** 2
    step = np.pi / speed / steps

    def slope(time, state):
        angle, rate = speed * time + state[0], speed + state[1]
        sine, cos = np.sin(angle), np.cos(angle)
        below = (cosine * cos) ** 2 + sine**2
        ratio, change = cosine / below, -2 * cosine * square * sine * cos / below**2
        inertia = (1 - share) + share * ratio**2
        return np.array([state[1], -(share * ratio * change * rate**2 + state[0]) / inertia])

    for i in range(steps):
        t = i * step
        k_1 = slope(t, state)
        k_2 = slope(t + step / 2, state + step / 2 * k_1)
        k_3 = slope(t + step / 2, state + step / 2 * k_2)
        k_4 = slope(t + step, state + step * k_3)
        state = state + step / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
    return state


def monodromy_trace(beta, share, speed):
    """Trace of the derivative of half a turn, by the complex step, about the periodic motion."""
    periodic = np.zeros(2)
    for _ in range(20):
        perturbed = periodic[:, None] + 1e-30j * np.eye(2)
        after = half_turn(beta, share, speed, perturbed)
        matrix, missed = after.imag / 1e-30, after[:, 0].real - periodic
        if np.max(np.abs(missed)) < 1e-13:
            return np.trace(matrix)
        periodic = periodic - np.linalg.solve(matrix - np.eye(2), missed)
    raise AssertionError


def zone_ends(beta, share):
    half = share * beta**2 / 4
    assert monodromy_trace(beta, share, 1.0) < -2
    return tuple(
        brentq(lambda r: monodromy_trace(beta, share, r) + 2, 1.0, 1 + side * 3 * half, xtol=1e-10)
        for side in (-1, 1)
    )


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, 0.2])
def test_first_zone_is_that_of_the_full_equation(share):
    """The error of the first order in beta^2 is of the second."""
    errors = []
    for degrees in (15.0, 7.5):
        beta = np.radians(degrees)
        zone = ts.parametric_zone(beta, share)
        exact = zone_ends(beta, share)
        errors.append(np.abs(np.subtract(zone[:2], exact)))
        assert np.max(errors[-1]) < 0.05 * zone.damping
        if (degrees, share) == (15.0, 0.5):
            assert exact == pytest.approx((0.9911629395, 1.0084989812), abs=2e-9)
    assert np.all(errors[1] < errors[0] / 10)


def test_damping_closes_the_zone():
    """Under viscous damping, multipliers shrink by exp(-zeta pi): the growth rate is a beta^2/4."""
    beta, share = np.radians(10.0), 0.5
    trace = abs(monodromy_trace(beta, share, 1.0))
    growth = np.arccosh(trace / 2) / np.pi
    assert growth == pytest.approx(ts.parametric_zone(beta, share).damping, rel=0.03)


def test_two_and_three_inertias_in_closed_form():
    J_1, J_2, c = 0.7, 0.2, 4e4
    f = np.sqrt(c * (J_1 + J_2) / (J_1 * J_2)) / (2 * np.pi)
    assert ts.chain_frequencies([J_1, J_2], [c]) == pytest.approx([2 * np.pi * f], rel=1e-14)
    assert ts.chain_frequencies([np.inf, 0.2], [c]) == pytest.approx([np.sqrt(c / 0.2)])
    # Holzer: J_1 J_2 J_3 x^2 - p x + c_1 c_2 (J_1 + J_2 + J_3) = 0 without the root 0.
    rng = np.random.default_rng(4)
    J, c = rng.uniform(0.05, 5.0, (20, 3)), 10 ** rng.uniform(3, 5, (20, 2))
    first, second, third = J.T
    p = c[:, 0] * third * (first + second) + c[:, 1] * first * (second + third)
    product = J.prod(axis=1)
    root = np.sqrt(p**2 - 4 * product * c.prod(axis=1) * J.sum(axis=1))
    squares = np.stack([p - root, p + root], axis=1) / (2 * product)[:, None]
    assert ts.chain_frequencies(J, c) == pytest.approx(np.sqrt(squares), rel=1e-9)


def test_light_inertias_cost_no_digits_of_the_low_modes():
    """A chain of equal parts between walls, omega_k = 2 sqrt(c / J) sin(k pi / 2 (n + 1))."""
    modes = np.arange(1, 8)
    wave = 2 * np.sqrt(3e4 / 0.2) * np.sin(modes * np.pi / 16)
    found = ts.chain_frequencies([np.inf, *[0.2] * 7, np.inf], [3e4] * 8)
    assert found == pytest.approx([0.0, *wave], rel=1e-12, abs=1e-9)
    light = ts.chain_frequencies([0.5, 1e-9, 0.3], [8e4, 8e4])
    assert light[0] == pytest.approx(np.sqrt(4e4 * (1 / 0.5 + 1 / 0.3)), rel=1e-8)


def test_orders_of_the_joint():
    """At modest angles the acceleration has orders 2 and 4; order 6 is 1.6e-3 of order 2."""
    phi = 2 * np.pi * np.arange(64) / 64
    spectrum = np.abs(np.fft.rfft(single_joint.acceleration_ratio(0.3, phi)))
    present = np.flatnonzero(spectrum > 1e-2 * np.max(spectrum))
    assert present.tolist() == [2, 4]
    speeds = ts.critical_speeds(200.0)
    assert [200.0 / speed for speed in speeds] == present.tolist()


def test_middle_of_the_zones():
    assert ts.parametric_speed(120.0, [1, 2, 3]) == pytest.approx([120.0, 60.0, 40.0])


def test_shapes_nan_and_bad_arguments():
    zone = ts.parametric_zone([[0.1], [np.nan]], np.linspace(0, 1, 3))
    assert all(value.shape == (2, 3) for value in zone)
    assert np.isnan(zone.least).tolist() == [[False] * 3, [True] * 3]
    chains = ts.chain_frequencies([[1.0, 2.0, 3.0], [1.0, np.nan, 3.0]], [1.0, 2.0])
    assert np.isnan(chains).tolist() == [[False] * 2, [True] * 2]
    assert np.isnan(ts.parametric_speed(1.0, [1, np.nan])).tolist() == [False, True]
    for call, message in (
        (lambda: ts.chain_frequencies([0.0, 1.0], [1.0]), r"inertias\[0\] = 0\.0 .*\(0, inf\]"),
        (lambda: ts.chain_frequencies([1.0, 1.0], [1.0, 1.0]), r"stiffnesses of shape \(2,\)"),
        (lambda: ts.chain_frequencies([1.0], []), r"n of 2 or more"),
        (lambda: ts.critical_speeds(-1.0), "frequency"),
        (lambda: ts.parametric_speed(1.0, 1.5), r"zone = 1\.5 .*1, 2, 3"),
        (lambda: ts.parametric_zone(0.1, 1.5), r"share = 1\.5"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
