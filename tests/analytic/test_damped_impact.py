"""Impacts with a damper, against integration of their equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from analytic import impact
from analytic.damped_impact import damped_peak

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
