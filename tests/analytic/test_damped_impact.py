"""Impacts with a damper, against integration of their equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from analytic import clearance, impact
from analytic.damped_impact import damped_peak, peak_exponents

PAPER = (3.6, 1e7, 0.5e-4, 360e3)


@pytest.mark.parametrize("start", ["rest", "release"])
def test_without_damping_it_is_the_undamped_one(start: str) -> None:
    stiffness = np.array([3e6, 1e7, 1e9])
    expected = impact.reversal(3.6, stiffness, 0.5e-4, 360e3, start=start).peak
    found = damped_peak(3.6, stiffness, 0.5e-4, 360e3, 0.0, start=start)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("zeta", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("stiffness", [1e7, 1e8])
def test_the_peak_is_that_of_the_integrated_equation(zeta: float, stiffness: float) -> None:
    mass, _, half, ramp = PAPER
    begun = impact.reversal(mass, stiffness, half, ramp, start="release")
    damper = 2.0 * zeta * np.sqrt(stiffness * mass)

    def rates(t: float, y: np.ndarray) -> list[float]:
        force = damper * y[1] + stiffness * y[0]
        return [y[1], (ramp * (begun.t_1 + t) - force) / mass]

    def rising(t: float, y: np.ndarray) -> float:
        return float(damper * rates(t, y)[1] + stiffness * y[1])

    rising.direction = -1.0  # type: ignore[attr-defined]
    end = 2.0 * np.pi / np.sqrt(stiffness / mass)
    options = {"rtol": 1e-12, "atol": 1e-18, "events": rising}
    found = solve_ivp(rates, (0.0, end), [0.0, float(begun.v_1)], **options)
    state = found.y_events[0][0]
    expected = damper * state[1] + stiffness * state[0]
    assert damped_peak(mass, stiffness, half, ramp, zeta) == pytest.approx(expected, rel=1e-9)


def test_a_strong_damper_has_its_greatest_force_at_once() -> None:
    begun = impact.reversal(*PAPER, start="release")
    expected = 2.0 * 0.7 * np.sqrt(1e7 * 3.6) * begun.v_1
    assert damped_peak(*PAPER, 0.7) == pytest.approx(float(expected), rel=1e-12)


def test_no_peak_is_no_number() -> None:
    assert np.isnan(damped_peak(3.6, 1e5, 1e-8, 360e3, 0.0))


@pytest.mark.parametrize("zeta", [-0.1, 1.0])
def test_ratios_out_of_range(zeta: float) -> None:
    with pytest.raises(ValueError, match="damping_ratio"):
        damped_peak(*PAPER, zeta)
    with pytest.raises(ValueError, match="damping_ratio"):
        peak_exponents(3.0, zeta)


@pytest.mark.parametrize("start", ["rest", "release"])
@pytest.mark.parametrize("stiffness", [1e7, 1e8])
@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.25, 0.7])
def test_exponents_are_differences_of_peaks(zeta: float, stiffness: float, start: str) -> None:
    values = {"mass": 3.6, "stiffness": stiffness, "play": 0.5e-4, "slope": 360e3}
    found = peak_exponents(clearance.tau(*values.values()), zeta, start=start)
    steps = 1e-4 * np.array([-2.0, -1.0, 1.0, 2.0])
    for name in values:
        changed = {**values, name: values[name] * np.exp(steps)}
        peaks = np.log(damped_peak(*changed.values(), zeta, start=start))
        difference = peaks @ [1.0, -8.0, 8.0, -1.0] / 12e-4
        assert getattr(found, name) == pytest.approx(difference, abs=1e-10)
    assert found.speed == pytest.approx(3.0 * found.slope)


def test_exponents_without_damping_and_without_peak() -> None:
    tau = np.array([1.5, 2.0, 8.0])
    for start in ("rest", "release"):
        expected = impact.peak_exponents(tau, start=start)
        np.testing.assert_allclose(peak_exponents(tau, 0.0, start=start), expected, rtol=1e-12)
    assert np.isnan(peak_exponents(1.5, 0.0).play)


def test_exponents_of_a_force_that_is_greatest_at_once() -> None:
    """2 zeta sqrt(c m) v_1, v_1 from rest cbrt(18 s^2 k / m)."""
    found = peak_exponents(3.0, 0.7, start="rest")
    np.testing.assert_allclose(found, [1.0, 1 / 3, 2 / 3, 1 / 6, 1 / 2], rtol=1e-13)
