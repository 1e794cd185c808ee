"""Energy integrals against elliptic functions of the pendulum."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from cardan_dyn.kit.periodic import Fourier
from cardan_dyn.motion.simulation.energy_functions import EnergyFunctions, NotSuitableError
from cardan_dyn.motion.simulation.energy_integral import EnergyIntegral

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
    np.testing.assert_allclose(found.x, 2.0 * np.arcsin(np.sqrt(modulus) * sn), atol=10 * tolerance)
    speed = -2.0 * np.sqrt(modulus) * RATE * cn
    np.testing.assert_allclose(found.v, speed, atol=100 * tolerance)
    assert np.min(dn) > 0.0
    np.testing.assert_allclose(found.a, -(RATE**2) * np.sin(found.x), atol=1e-12)


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
    np.testing.assert_allclose(found.x, sign * 2.0 * phase, atol=1e-12)
    np.testing.assert_allclose(found.v, sign * speed * dn, rtol=1e-12)
    # A thousand turns cost no accuracy beyond that of the period.
    late = law.at(np.array([1000.0 * law.period]))
    assert late.x[0] == pytest.approx(sign * 2000.0 * np.pi, abs=1e-9)


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
    np.testing.assert_allclose(law.at(times).x, resting.at(times - later).x, atol=5.0 * allowed)
    assert law.at(np.zeros(1)).v[0] == pytest.approx(speed, rel=1e-13, abs=1e-14)


@pytest.mark.parametrize("reach", [1e-8, 1e-5, 1e-2])
def test_short_swings_have_the_period_of_any(reach: float) -> None:
    """Sums of harmonics leave the force there few digits; those of the period do not need them."""
    modulus = np.sin(0.5 * reach) ** 2
    inertia = Fourier(np.array([[2.0 + 0.0j, 0.0]]), 1.0)
    # The same pendulum, which hangs at 0.7.
    force = Fourier(np.array([[0.0, 2.0j * RATE**2 * np.exp(-0.7j)]]), 1.0)
    functions = EnergyFunctions(inertia, force, 1e-14)
    for start in ((0.7 + reach, 0.0), (0.7, 2.0 * RATE * np.sqrt(modulus))):
        law = EnergyIntegral(functions, *start)
        assert law.period == pytest.approx(4.0 * ellipk(modulus) / RATE, rel=1e-14)
        assert law.reach == pytest.approx(reach, abs=1e-15)


@pytest.mark.parametrize(("position", "speed"), [(1.0, 0.0), (0.2, 1.0), (-3.0, 5.0), (0.0, 9.0)])
def test_how_late_a_motion_may_be_grows_with_its_periods(position: float, speed: float) -> None:
    law = integral(position, speed)
    times = np.array([0.0, 1.0, 1e3, 1e6, 1e9]) * law.period
    late = law.late(times)
    expected = pendulum_at(position, speed, times + 0.3 * law.period)
    off = np.abs(law.at(times + 0.3 * law.period).x - expected[0])
    assert np.all(off <= 1e-13 * (1.0 + np.abs(expected[0])) + law.fastest * late)
    # A part of rounding of every period, and none of what has not begun.
    assert late[0] == 0.0
    np.testing.assert_allclose(late[2:] / times[2:], late[2] / times[2], rtol=2e-3)
    assert 1e-15 < late[-1] / times[-1] < 1e-12


def test_what_nothing_pushes_is_late_by_the_error_of_its_inertia() -> None:
    inertia = Fourier(np.array([[2.0 + 0.0j, 0.3j]]), 1.0)
    none = Fourier(np.zeros((1, 2), dtype=complex), 1.0)
    law = EnergyIntegral(EnergyFunctions(inertia, none, 1e-14), 0.3, 5.0)
    times = np.array([1.0, 1e4, 1e9])
    np.testing.assert_allclose(law.late(times), 1e-14 * times, rtol=1e-12)


def test_how_long_it_stays_counts_for_no_more_than_a_period() -> None:
    """However fast a pendulum turns, its upright position is an unstable one."""
    law = integral(0.0, 1e9)
    assert law.doubt < 1e-13 * law.period


def test_it_stays_in_equilibrium() -> None:
    law = integral(0.0, 0.0)
    assert law.period == np.inf
    np.testing.assert_array_equal(law.at(np.array([0.0, 9.0])).x, 0.0)


def test_a_torque_moves_where_it_swings_and_speeds_up_what_turns() -> None:
    law = integral(0.5, 0.0, torque=2.0)
    positions = law.at(np.linspace(0.0, law.period, 400)).x
    ends = [float(np.min(positions)), float(np.max(positions))]
    energy = [-2.0 * RATE**2 * np.cos(end) - 2.0 * end for end in ends]
    assert energy[0] == pytest.approx(energy[1], abs=1e-2)
    with pytest.raises(NotSuitableError, match="constant torque"):
        integral(0.0, 50.0, torque=2.0)


def test_what_comes_to_rest_on_top_is_refused() -> None:
    with pytest.raises(NotSuitableError, match=r"maximum|extremum"):
        integral(0.0, 2.0 * RATE * (1.0 + 1e-15))


def pendulum_at(position: float, speed: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and speeds of a pendulum of rate RATE from exactly this start, by 50 digits."""
    with mpmath.workdps(50):
        sense = -1 if speed < 0.0 else 1
        turns = mpmath.nint(mpmath.mpf(position) / (2 * mpmath.pi))
        begun = sense * (mpmath.mpf(position) - 2 * mpmath.pi * turns)
        energy = (mpmath.mpf(speed) / (2 * RATE)) ** 2 + mpmath.sin(begun / 2) ** 2
        root = mpmath.sqrt(energy)
        found = []
        for time in times.tolist():
            if energy < 1:
                first = mpmath.asin(mpmath.mpf(max(-1, min(1, mpmath.sin(begun / 2) / root))))
                place = mpmath.ellipf(first, energy) + RATE * mpmath.mpf(time)
                sn, cn = (mpmath.ellipfun(name, place, m=energy) for name in ("sn", "cn"))
                angle, rate = 2 * mpmath.asin(root * sn), 2 * root * RATE * cn
            else:
                place = mpmath.ellipf(begun / 2, 1 / energy) + RATE * root * mpmath.mpf(time)
                half = mpmath.ellipk(1 / energy)
                passed = mpmath.nint(place / (2 * half))
                rest = place - 2 * half * passed
                sn, cn, dn = (
                    mpmath.ellipfun(name, rest, m=1 / energy) for name in ("sn", "cn", "dn")
                )
                angle = 2 * (mpmath.atan2(sn, cn) + mpmath.pi * passed)
                rate = 2 * root * RATE * dn
            found.append((float(sense * angle + 2 * mpmath.pi * turns), float(sense * rate)))
    positions, speeds = np.array(found).T
    return positions, speeds


def near_separatrix(random: np.random.Generator, kind: int) -> tuple[float, float]:
    """A start whose energy is 1e-1 to 1e-12 from that of the unstable equilibrium, relative."""
    distance = 10.0 ** random.uniform(-12.0, -1.0) * random.choice([-1.0, 1.0])
    sign = random.choice([-1.0, 1.0])
    if kind == 0:  # Released at rest beside the equilibrium.
        return float(np.pi + sign * np.sqrt(abs(distance))), 0.0
    if kind == 1:  # Pushed on top of it.
        return float(np.pi), float(sign * 2.0 * RATE * np.sqrt(abs(distance)))
    position = float(random.uniform(-3.0, 3.0) if kind == 2 else random.uniform(-12.0, 12.0))
    square = 2.0 * RATE**2 * (2.0 * (1.0 + distance) - (1.0 - np.cos(position)))
    return position, float(sign * np.sqrt(max(square, 0.0)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", range(4))
def test_motions_beside_a_separatrix_are_elliptic(kind: int) -> None:
    """Errors are those that rounding of the start's energy has, and no greater ones."""
    random = np.random.default_rng(kind)
    for _ in range(15):
        position, speed = near_separatrix(random, kind)
        law = integral(position, speed)
        times = np.sort(random.uniform(0.0, 3.0 * law.period, 8))
        found = law.at(np.concatenate([[0.0], times]))
        expected = pendulum_at(position, speed, found.x * 0.0 + np.append(0.0, times))
        allowed = 1e-12 + 4.0 * law.doubt * law.fastest
        np.testing.assert_allclose(found.x, expected[0], atol=allowed)
        np.testing.assert_allclose(found.v, expected[1], atol=3.0 * RATE * allowed)
        # Beside the equilibrium itself the start says how far away it is, to rounding.
        if kind < 2:
            assert allowed < 1e-5
        if not law.swings:
            way = law.at(np.linspace(0.0, 3.0 * law.period, 4000)).x
            assert np.all(np.sign(speed) * np.diff(way) >= -1e-14 * np.abs(way[:-1]))


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9])
def test_both_sides_of_a_hump_within_a_swing(distance: float) -> None:
    """cos φ + cos 2φ has a low maximum between two wells: over it, or in one of them."""
    inertia = Fourier(np.array([[1.0 + 0.0j, 0.0, 0.0]]), 1.0)
    # The force of the potential cos φ + 2 cos 2φ is sin φ + 4 sin 2φ.
    force = Fourier(np.array([[0.0j, -1.0j, -4.0j]]), 1.0)
    functions = EnergyFunctions(inertia, force, 4e-15)
    # At π the potential has its lower maximum, 1; the rate of leaving it is √7.
    for sign in (-1.0, 1.0):
        position = np.pi + sign * distance
        held = EnergyIntegral(functions, position, 0.0)
        assert held.swings and held.fastest < 5.0
        times = np.linspace(0.0, 3.0 * held.period, 301)
        ways = held.at(times)
        energy = 0.5 * ways.v**2 + np.cos(ways.x) + 2.0 * np.cos(2.0 * ways.x)
        np.testing.assert_allclose(energy, energy[0], atol=1e-13)
        assert np.min(sign * (ways.x - np.pi)) >= distance * (1.0 - 1e-6)
        # How it leaves the top: by the linear law, as long as it is near.
        soon = np.linspace(0.0, 0.3, 7)
        left = sign * (held.at(soon).x - np.pi) / distance
        np.testing.assert_allclose(left, np.cosh(np.sqrt(7.0) * soon), rtol=max(distance, 1e-6))
        over = EnergyIntegral(functions, float(np.pi), sign * distance)
        ways = over.at(np.linspace(0.0, over.period, 2001))
        assert over.swings
        assert np.min(ways.x) < np.pi - 1.0 and np.max(ways.x) > np.pi + 1.0


def test_what_hangs_on_rounding_is_said() -> None:
    with pytest.raises(NotSuitableError) as refused:
        integral(0.0, 2.0 * RATE * (1.0 + 1e-15))
    assert "rounding" in refused.value.note
    top = integral(float(np.pi), 0.0)
    assert top.period == np.inf and top.doubt == np.inf
    assert integral(0.0, 0.0).doubt == 0.0
    assert integral(1.0, 0.0).doubt < 1e-12
    assert integral(0.0, 2.0 * RATE * (1.0 + 1e-10)).doubt > 1e-7
