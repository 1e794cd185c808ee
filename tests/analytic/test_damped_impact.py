"""Impacts with a damper, against integration of their equation."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan_dyn.analytic import clearance, impact
from cardan_dyn.analytic.damped_impact import damped_peak, flight, peak_exponents
from cardan_dyn.analytic.peak_exponents import peak_exponents as undamped_exponents

PAPER = (3.6, 1e7, 0.5e-4, 360e3)


@pytest.mark.parametrize("start", ["rest", "release"])
def test_without_damping_it_is_the_undamped_one(start: str) -> None:
    stiffness = np.array([3e6, 1e7, 1e9])
    expected = impact.reversal(3.6, stiffness, 0.5e-4, 360e3, start=start).peak
    found = damped_peak(3.6, stiffness, 0.5e-4, 360e3, 0.0, start=start)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def integrated(zeta: float, stiffness: float) -> tuple[float, float, float]:
    """Time and speed of the impact and the peak, from long before the reversal on.

    The contact is a spring and a damper that cannot pull, on either side of the play; it begins at
    rest in the wall, so that its steady unloading is found and not given.
    """
    mass, _, half, ramp = PAPER
    damper = 2.0 * zeta * np.sqrt(stiffness * mass)
    natural = np.sqrt(mass / stiffness)

    def part(edge: float) -> Callable[[np.ndarray], float]:
        return lambda y: damper * float(y[1]) + stiffness * (float(y[0]) - edge)

    near, far = part(0.0), part(2.0 * half)

    def run(
        contact: Callable[[np.ndarray], float], begun: float, y: list[float], until: Any
    ) -> Any:
        until.terminal = True
        found = solve_ivp(
            lambda t, y: [y[1], (ramp * t - contact(y)) / mass],
            (begun, begun + 1e4 * natural),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-17,
            events=until,
        )
        return float(found.t_events[0][0]), found.y_events[0][0]

    def lets_go(t: float, y: np.ndarray) -> float:
        return near(y)

    def arrives(t: float, y: np.ndarray) -> float:
        return float(y[0]) - 2.0 * half

    def is_greatest(t: float, y: np.ndarray) -> float:
        return damper * (ramp * t - far(y)) / mass + stiffness * float(y[1])

    is_greatest.direction = -1.0  # type: ignore[attr-defined]
    begun = -36.0 / zeta * natural
    released, y = run(near, begun, [ramp * begun / stiffness, 0.0], lets_go)
    assert abs(released) < 1e-9 * natural
    time, y = run(lambda y: 0.0, released, y, arrives)
    speed = float(y[1])
    _, y = run(far, time, y, is_greatest)
    return time, speed, far(y)


@pytest.mark.parametrize("zeta", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("stiffness", [1e7, 1e8])
def test_flight_and_peak_are_those_of_the_integrated_equation(
    zeta: float, stiffness: float
) -> None:
    mass, _, half, ramp = PAPER
    time, speed, peak = integrated(zeta, stiffness)
    found = flight(mass, stiffness, half, ramp, zeta)
    assert found.t_1 == pytest.approx(time, rel=1e-9)
    assert found.v_1 == pytest.approx(speed, rel=1e-9)
    assert damped_peak(mass, stiffness, half, ramp, zeta) == pytest.approx(peak, rel=1e-9)


@pytest.mark.parametrize("tau", [0.3, 3.0, 40.0])
@pytest.mark.parametrize("zeta", [1e-9, 0.25, 0.99])
def test_flight_is_the_root_of_its_cubic(tau: float, zeta: float) -> None:
    """In 40 digits: the pin starts 2 zeta deep, at the ramp's speed, and crosses tau^3 / 6."""
    with mpmath.workdps(40):
        play = mpmath.mpf(tau) ** 3 / 6
        way = lambda x: -2 * mpmath.mpf(zeta) + x + x**3 / 6 - play  # noqa: E731
        root = mpmath.findroot(way, tau)
        found = flight(1.0, 1.0, tau**3 / 12.0, 1.0, zeta)
        assert found.t_1 == pytest.approx(float(root), rel=1e-14)
        assert found.v_1 == pytest.approx(float(mpmath.diff(way, root)), rel=1e-14)


def test_flight_without_damping_and_from_rest() -> None:
    expected = impact.reversal(*PAPER, start="release")
    np.testing.assert_allclose(flight(*PAPER, 0.0), expected[:2], rtol=1e-14)
    found = flight(*PAPER, [0.0, 0.3], start="rest")
    expected = impact.reversal(*PAPER, start="rest")
    np.testing.assert_allclose(found, np.transpose([expected[:2]] * 2), rtol=1e-14)


@pytest.mark.parametrize(
    ("tau", "percent"), [(3.0, [1.0, 1.9, 4.7, 7.5]), (5.0, [0.3, 0.5, 1.35, 2.3])]
)
def test_what_the_damper_adds_at_the_release(tau: float, percent: list[float]) -> None:
    """Over the peak after the flight of an undamped release, with the same damper in the impact."""
    half, zetas = tau**3 / 12.0, np.array([0.05, 0.1, 0.25, 0.4])
    undamped = impact.reversal(1.0, 1.0, half, 1.0, start="release")
    # The flight from rest that lasts as long begins slower: the impact's speed has to be given.
    peaks = []
    for zeta in zetas:
        t = np.linspace(0.0, 2.6, 400_001)
        root = np.sqrt(1.0 - zeta**2)
        cosine = 2.0 * zeta - undamped.t_1
        sine = (undamped.v_1 - 1.0 + zeta * cosine) / root
        decay = np.exp(-zeta * t)
        x = undamped.t_1 + t - 2.0 * zeta
        x += decay * (cosine * np.cos(root * t) + sine * np.sin(root * t))
        peaks.append(np.max(x + 2.0 * zeta * np.gradient(x, t)))
    more = 100.0 * (damped_peak(1.0, 1.0, half, 1.0, zetas) / peaks - 1.0)
    np.testing.assert_allclose(more, percent, atol=0.05)


def test_a_strong_damper_has_its_greatest_force_at_once() -> None:
    """2 zeta sqrt(c m) v_1, the impact's time by ω from the roots of the cubic."""
    mass, stiffness, _, ramp = PAPER
    tau = float(clearance.tau(*PAPER))
    time = max(np.roots([1.0, 0.0, 6.0, -(tau**3) - 12.0 * 0.7]).real)
    expected = 2.0 * 0.7 * np.sqrt(stiffness * mass) * ramp / stiffness * (1.0 + time**2 / 2.0)
    assert damped_peak(*PAPER, 0.7) == pytest.approx(expected, rel=1e-12)


def test_no_peak_is_no_number() -> None:
    assert np.isnan(damped_peak(3.6, 1e5, 1e-8, 360e3, 0.0))


@pytest.mark.parametrize("zeta", [-0.1, 1.0])
def test_ratios_out_of_range(zeta: float) -> None:
    with pytest.raises(ValueError, match="damping_ratio"):
        damped_peak(*PAPER, zeta)
    with pytest.raises(ValueError, match="damping_ratio"):
        flight(*PAPER, zeta)
    with pytest.raises(ValueError, match="damping_ratio"):
        peak_exponents(3.0, zeta)


@pytest.mark.parametrize("start", ["rest", "release"])
@pytest.mark.parametrize("stiffness", [1e7, 1e8])
@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.25, 0.7])
def test_exponents_are_differences_of_peaks(zeta: float, stiffness: float, start: str) -> None:
    values = {"mass": 3.6, "stiffness": stiffness, "clearance": 0.5e-4, "slope": 360e3}
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
        expected = undamped_exponents(tau, start=start)
        np.testing.assert_allclose(peak_exponents(tau, 0.0, start=start), expected, rtol=1e-12)
    assert np.isnan(peak_exponents(1.5, 0.0).clearance)


def test_exponents_of_a_force_that_is_greatest_at_once() -> None:
    """2 zeta sqrt(c m) v_1, v_1 from rest cbrt(18 s^2 k / m)."""
    found = peak_exponents(3.0, 0.7, start="rest")
    np.testing.assert_allclose(found, [1.0, 1 / 3, 2 / 3, 1 / 6, 1 / 2], rtol=1e-13)


def test_bad_flights() -> None:
    with pytest.raises(ValueError, match="start = 'fall'"):
        flight(*PAPER, 0.1, start="fall")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="shape"):
        flight(3.6, [1e7, 1e8], 0.5e-4, 360e3, [0.1, 0.2, 0.3])
