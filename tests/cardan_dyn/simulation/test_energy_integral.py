"""Energy integrals against elliptic functions of the pendulum."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from cardan_dyn.simulation.energy_functions import EnergyFunctions, NotSuitableError
from cardan_dyn.simulation.energy_integral import EnergyIntegral
from cardan_dyn.simulation.fourier import Fourier

RATE = 3.0
"""Angular frequency of small swings [rad/s]; the inertia is 2."""


def integral(position: float, speed: float, torque: float = 0.0) -> EnergyIntegral:
    inertia = Fourier(np.array([[2.0 + 0.0j, 0.0]]), 1.0)
    # -2 ω² sin φ is the real part of 2i ω² exp(iφ).
    force = Fourier(np.array([[torque + 0.0j, 2.0j * RATE**2]]), 1.0)
    return EnergyIntegral(EnergyFunctions(inertia, force, 1e-14), position, speed)


@pytest.mark.parametrize("reach", [0.01, 1.0, 3.0])
def test_swings_are_elliptic(reach: float) -> None:
    law = integral(reach, 0.0)
    modulus = np.sin(0.5 * reach) ** 2
    assert law.swings
    assert law.period == pytest.approx(4.0 * ellipk(modulus) / RATE, rel=1e-13)
    times = np.linspace(0.0, 10.0 * law.period, 57)
    sn, cn, dn, _ = ellipj(ellipk(modulus) - RATE * times, modulus)
    found = law.at(times)
    # Phases count from the start of a swing: errors are those of the period times their number.
    tolerance = 1e-12 * reach
    np.testing.assert_allclose(
        found.position, 2.0 * np.arcsin(np.sqrt(modulus) * sn), atol=10 * tolerance
    )
    speed = -2.0 * np.sqrt(modulus) * RATE * cn
    np.testing.assert_allclose(found.speed, speed, atol=100 * tolerance)
    assert np.min(dn) > 0.0
    np.testing.assert_allclose(found.acceleration, -(RATE**2) * np.sin(found.position), atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_turns_are_elliptic(sign: float) -> None:
    speed = 2.5 * RATE
    law = integral(0.0, sign * speed)
    modulus = (2.0 * RATE / speed) ** 2
    assert not law.swings
    period = 4.0 * ellipk(modulus) / speed
    assert law.period == pytest.approx(period, rel=1e-13)
    times = np.linspace(0.0, 0.9 * 0.5 * period, 20)
    _, _, dn, phase = ellipj(0.5 * speed * times, modulus)
    found = law.at(times)
    np.testing.assert_allclose(found.position, sign * 2.0 * phase, atol=1e-12)
    np.testing.assert_allclose(found.speed, sign * speed * dn, rtol=1e-12)
    # A thousand turns cost no accuracy beyond that of the period.
    late = law.at(np.array([1000.0 * law.period]))
    assert late.position[0] == pytest.approx(sign * 2000.0 * np.pi, abs=1e-9)


@pytest.mark.parametrize("speed", [1e-3, 1e-7, -1e-7, 1e-9])
def test_swings_that_begin_close_to_their_end(speed: float) -> None:
    """The end is v² / (2 a) further, which leaves no digits to the cosine of the phase."""
    law = integral(1.0, speed)
    resting = integral(1.0, 0.0)
    # Moving on for v / |a| is to come to rest there, or to have done so.
    later = speed / (RATE**2 * np.sin(1.0))
    times = np.linspace(0.5, 1.5, 9)
    # Reach and period differ by the square of the speed.
    allowed = 1e-13 + speed**2
    np.testing.assert_allclose(
        law.at(times).position, resting.at(times - later).position, atol=5.0 * allowed
    )
    assert law.at(np.zeros(1)).speed[0] == pytest.approx(speed, rel=1e-13, abs=1e-14)


def test_it_stays_in_equilibrium() -> None:
    law = integral(0.0, 0.0)
    assert law.period == np.inf
    np.testing.assert_array_equal(law.at(np.array([0.0, 9.0])).position, 0.0)


def test_a_torque_moves_where_it_swings_and_speeds_up_what_turns() -> None:
    law = integral(0.5, 0.0, torque=2.0)
    positions = law.at(np.linspace(0.0, law.period, 400)).position
    ends = [float(np.min(positions)), float(np.max(positions))]
    energy = [-2.0 * RATE**2 * np.cos(end) - 2.0 * end for end in ends]
    assert energy[0] == pytest.approx(energy[1], abs=1e-2)
    with pytest.raises(NotSuitableError, match="constant torque"):
        integral(0.0, 50.0, torque=2.0)


def test_what_comes_to_rest_on_top_is_refused() -> None:
    with pytest.raises(NotSuitableError, match=r"maximum|extremum"):
        integral(0.0, 2.0 * RATE * (1.0 + 1e-15))
