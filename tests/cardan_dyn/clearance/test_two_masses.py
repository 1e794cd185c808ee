"""Two masses across a play: the paper's example, its formulas over tau, limits and laws.

References: Dresig and Thümmel's numbers, their formulas in 40 digits, motions that SciPy integrates
from equations written down here, and closed forms of the joint without play.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from analytic.damped_impact import damped_peak, flight
from cardan_dyn.clearance import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
    two_masses,
)
from cardan_dyn.errors import ArgumentError, CardanError

EXAMPLE = {"play": 1e-4, "mass": 3.6, "ramp": 360e3, "end": 0.005}
SPRING = LinearContact(1e7)


def test_the_papers_example() -> None:
    motion = two_masses(SPRING, start="rest", **EXAMPLE)
    (impact,) = motion.impacts
    assert motion.peak == pytest.approx(2181.89, abs=0.005)
    assert impact.time == pytest.approx(1.81712e-3, abs=5e-9)
    assert impact.speed == pytest.approx(0.165096, abs=5e-7)
    assert np.sqrt(1e7 / 3.6) * impact.time == pytest.approx(3.02853, abs=5e-6)
    rigid = 360e3 * impact.peak_time
    assert (rigid, impact.peak - rigid) == pytest.approx((1191.31, 990.58), abs=0.005)
    assert motion.energy_residual < 1e-12


def test_the_papers_example_as_its_contact_unloads() -> None:
    motion = two_masses(SPRING, **EXAMPLE)
    assert motion.peak == pytest.approx(1833.27, abs=0.005)
    assert motion.at(0.0).speed == pytest.approx(0.036)
    assert motion.energy_residual < 1e-12


def factor(tau: float, release: bool) -> float:
    """Peak over c s by Newton's method on the force's rate, in 40 digits; NaN without a peak.

    In x = ω t from the touch the force over c s is (12 / τ³)[τ₁ + x + (v - 1) sin x - τ₁ cos x]:
    τ₁ is ω times the flight's time and v the speed of the touch over F₀ / (t₀ c).
    """
    with mpmath.workdps(40):
        t = mpmath.mpf(tau)
        # From release the way 2 s c / (F₀/t₀ √(m/c)³) = τ³/6 is flown as x + x³/6, at rest as x³/6.
        flown = (
            mpmath.findroot(lambda x: release * x + x**3 / 6 - t**3 / 6, t / 2) if release else t
        )
        speed = flown**2 / 2 + int(release)

        def rate(x: mpmath.mpf) -> mpmath.mpf:
            return 1 + (speed - 1) * mpmath.cos(x) + flown * mpmath.sin(x)

        places = [mpmath.mpf(k) * 2 * mpmath.pi / 4000 for k in range(4001)]
        for low, high in pairwise(places):
            if rate(low) > 0 >= rate(high):
                x = mpmath.findroot(rate, (low, high), solver="anderson")
                force = flown + x + (speed - 1) * mpmath.sin(x) - flown * mpmath.cos(x)
                return float(12 * force / t**3)
    return float("nan")


@pytest.mark.parametrize("start", ["rest", "release"])
@pytest.mark.parametrize("tau", [0.1, 0.4, 1.0, 1.7, 1.83, 1.85, 2.0, 3.02853, 7.0, 20.0, 50.0])
def test_the_factor_of_the_peak(tau: float, start: Any) -> None:
    mass, stiffness, half = 3.6, 1e7, 5e-5
    ramp = 12.0 * mass * half * (stiffness / mass) ** 1.5 / tau**3
    swing = 2.0 * np.pi * np.sqrt(mass / stiffness)
    end = tau * np.sqrt(mass / stiffness) + swing
    motion = two_masses(
        LinearContact(stiffness), play=2 * half, mass=mass, ramp=ramp, start=start, end=end
    )
    wanted = factor(tau, start == "release")
    assert np.isnan(wanted) == (start == "release" and tau < 1.8386)
    assert motion.peak / (stiffness * half) == pytest.approx(wanted, rel=1e-10, nan_ok=True)


def test_no_release_has_a_peak_below_its_bound() -> None:
    def peak(tau: float) -> float:
        ramp = 12.0 * 3.6 * 5e-5 * (1e7 / 3.6) ** 1.5 / tau**3
        return two_masses(SPRING, **{**EXAMPLE, "ramp": ramp, "end": 0.02}).peak

    low, high = 1.7, 2.0
    for _ in range(20):
        tau = 0.5 * (low + high)
        low, high = (tau, high) if np.isnan(peak(tau)) else (low, tau)
    assert high == pytest.approx(1.8386, abs=5e-5)


@pytest.mark.parametrize("ratio", [0.05, 0.25, 0.45, 0.7])
@pytest.mark.parametrize("start", ["rest", "release"])
def test_a_damped_peak(ratio: float, start: Any) -> None:
    law = LinearContact.of_ratio(1e7, ratio, 3.6)
    motion = two_masses(law, start=start, **EXAMPLE)
    found = flight(3.6, 1e7, 5e-5, 360e3, ratio, start=start)
    assert motion.impacts[0].time == pytest.approx(float(found.t_1), rel=1e-12)
    assert motion.impacts[0].speed == pytest.approx(float(found.v_1), rel=1e-12)
    wanted = damped_peak(3.6, 1e7, 5e-5, 360e3, ratio, start=start)
    assert motion.peak == pytest.approx(float(wanted), rel=1e-11)


def equations(law: ContactLaw, mass: float, play: float, force: Callable[[float], float]) -> Any:
    """The two masses as plain equations, clipped on both sides, for laws of depth and rate."""

    def rate(time: float, y: np.ndarray) -> list[float]:
        far, near = float(y[0]) - play, -float(y[0])
        pressed = max(float(law.force(far, float(y[1]))), 0.0) if far > 0.0 else 0.0
        pressed -= max(float(law.force(near, -float(y[1]))), 0.0) if near > 0.0 else 0.0
        return [float(y[1]), (force(time) - pressed) / mass]

    return rate


@pytest.mark.parametrize(
    "law",
    [
        SPRING,
        LinearContact.of_ratio(1e7, 0.5, 3.6),
        HuntCrossley.of_factor(3e9, 1.5, factor=3.0),
        ImpactFunction(3e9, 1.5, 3e3, 2e-5),
    ],
)
def test_a_force_that_swings_drives_from_side_to_side(law: ContactLaw) -> None:
    def force(time: float) -> float:
        return 900.0 * np.sin(400.0 * time)

    motion = two_masses(law, play=1e-4, mass=3.6, force=force, start=(5e-5, 0.0), end=0.03)
    assert {impact.side for impact in motion.impacts} == {1, -1}
    assert motion.energy_residual < 1e-11
    run = solve_ivp(
        equations(law, 3.6, 1e-4, force), (0.0, 0.03), [5e-5, 0.0], method="DOP853",
        rtol=1e-11, atol=1e-15, max_step=1e-5, t_eval=np.linspace(0.0, 0.03, 301),
    )  # fmt: skip
    state = motion.at(run.t)
    np.testing.assert_allclose(state.gap, run.y[0], atol=1e-7 * 1e-4)
    np.testing.assert_allclose(state.speed, run.y[1], atol=1e-6 * 0.2)


def test_both_ways_of_solving_agree() -> None:
    """A Hunt-Crossley law with n = e = 1 is a spring, which is integrated instead."""
    for start in ("rest", "release"):
        exact = two_masses(SPRING, start=start, **EXAMPLE)  # type: ignore[arg-type]
        found = two_masses(HuntCrossley(1e7, 1.0, 1.0), start=start, **EXAMPLE)  # type: ignore[arg-type]
        assert found.peak == pytest.approx(exact.peak, rel=1e-12)
        times = np.linspace(0.0, 0.005, 60)
        np.testing.assert_allclose(found.at(times).gap, exact.at(times).gap, atol=1e-10 * 1e-4)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 2.0])
@pytest.mark.parametrize(
    ("ramp", "start", "begin"),
    [(360e3, (0.0, 0.03), 0.0), (-360e3, (1e-4, 0.0), -2e-3), (6e5, (1e-4, 0.3), -4e-3)],
)
def test_a_ramp_is_a_force_like_others(
    ratio: float, ramp: float, start: tuple[float, float], begin: float
) -> None:
    law = LinearContact.of_ratio(1e7, ratio, 3.6)
    common: dict[str, Any] = {"play": 1e-4, "mass": 3.6, "start": start, "begin": begin}
    exact = two_masses(law, ramp=ramp, end=0.006, **common)
    found = two_masses(law, force=lambda time: ramp * time, end=0.006, **common)
    assert len(exact.impacts) == len(found.impacts) > 0
    times = np.linspace(begin, 0.006, 200)
    scale = np.max(np.abs(exact.gap))
    np.testing.assert_allclose(found.at(times).gap, exact.at(times).gap, atol=1e-10 * scale)
    peaks = [[impact.peak for impact in motion.impacts] for motion in (found, exact)]
    np.testing.assert_allclose(*peaks, rtol=1e-10)


def test_a_steady_unloading_of_another_law() -> None:
    """Where it begins does not matter: further before the reversal gives the same."""
    law = HuntCrossley.of_factor(3e9, 1.5, factor=2.0)
    motion = two_masses(law, **EXAMPLE)
    begin = 2.0 * float(motion.times[0])
    pressed = two_masses(
        law, play=1e-4, mass=3.6, force=lambda time: 360e3 * time, begin=begin, end=0.005
    )
    assert motion.peak == pytest.approx(pressed.peak, rel=1e-7)
    assert motion.impacts[0].speed == pytest.approx(pressed.impacts[0].speed, rel=1e-7)
    assert motion.times[0] < -0.01


LAWS = [
    LinearContact.of_ratio(1e7, 0.2, 3.6),
    HuntCrossley(3e9, 1.5, 0.8),
    HuntCrossley(3e7, 1.1, 0.2),
    LankaraniNikravesh(3e9, 1.5, 0.6),
    HuntCrossley.of_factor(3e9, 1.5, factor=5.0),
    ImpactFunction(3e9, 1.5, 3e3, 2e-5),
]


@pytest.mark.parametrize("law", LAWS)
def test_free_impacts_lose_what_the_law_says(law: ContactLaw) -> None:
    motion = two_masses(
        law, play=1e-4, mass=3.6, ramp=0.0, start=(5e-5, 0.3), end=1e3, most_impacts=5
    )
    assert motion.ended == "it met 5 impacts"
    assert [impact.side for impact in motion.impacts] == [1, -1, 1, -1, 1]
    for impact in motion.impacts:
        assert impact.restitution == pytest.approx(law.restitution(impact.speed, 3.6), abs=1e-9)
        if isinstance(law, HuntCrossley | LankaraniNikravesh):
            # The condition of Hunt and Crossley itself.
            e, h = impact.restitution, float(law.loss(impact.speed))
            assert h * (1 + e) == pytest.approx(np.log((1 + h) / (1 - h * e)), abs=1e-8)
    speeds = [impact.speed for impact in motion.impacts]
    rest = motion.energies
    assert rest.lost[-1] == pytest.approx(
        1.8 * (0.09 - (speeds[-1] * motion.impacts[-1].restitution) ** 2), rel=1e-9
    )
    assert motion.energy_residual < 1e-11


def slope(peaks: list[float], sizes: list[float]) -> float:
    return float(np.log(peaks[1] / peaks[0]) / np.log(sizes[1] / sizes[0]))


def added(stiffness: float, half: float) -> float:
    """What the play adds to the ramp at the peak [N]."""
    (impact,) = two_masses(
        LinearContact(stiffness), **{**EXAMPLE, "play": 2.0 * half, "end": 0.05}, most_impacts=1
    ).impacts
    return impact.peak - 360e3 * impact.peak_time


def test_what_the_play_adds_where_contacts_are_stiff() -> None:
    """∛(18 s² k / m) √(c m): as s^(2/3) and √c, where τ is great."""
    stiff, small = [1e12, 4e12], [1e-6, 4e-6]
    assert slope([added(c, 1e-6) for c in stiff], stiff) == pytest.approx(0.5, abs=0.05)
    assert slope([added(1e12, s) for s in small], small) == pytest.approx(2.0 / 3.0, abs=0.05)
    predicted = np.cbrt(18.0 * 1e-12 * 360e3 / 3.6) * np.sqrt(1e12 * 3.6)
    assert added(1e12, 1e-6) == pytest.approx(predicted, rel=0.05)


def test_the_rigid_force_is_the_limit_only_if_the_play_vanishes_fast_enough() -> None:
    """Along c ∝ s^(-p) the added part falls as s^(2/3 - p/2): for p below 4/3 alone."""
    small = [1e-7, 1e-9]
    for p, falls in ((1.0, 1.0 / 6.0), (1.6, -2.0 / 15.0)):
        parts = [added(1e13 * (s / 1e-7) ** -p, s) for s in small]
        assert slope(parts, small) == pytest.approx(falls, abs=0.05)


def test_a_given_play_and_ever_stiffer_contacts() -> None:
    stiff = [1e12, 1e14]
    peaks = [two_masses(LinearContact(c), **EXAMPLE, most_impacts=1).peak for c in stiff]
    assert slope(peaks, stiff) == pytest.approx(0.5, abs=0.005)


def test_a_vanishing_play_gives_the_elastic_joint() -> None:
    """Its force c q of m q'' + c q = A sin Ωt in closed form, from the same pressed rest."""
    amplitude, speed, mass, c = 900.0, 400.0, 3.6, 1e7
    begin, end = -0.5 * np.pi / speed, 0.5 * np.pi / speed
    times = np.linspace(begin, end, 2001)
    omega = np.sqrt(c / mass)
    forced = amplitude / (1.0 - mass * speed**2 / c)
    elastic = forced * np.sin(speed * times)
    elastic += (forced - amplitude) * np.cos(omega * (times - begin))
    errors = []
    for play in (1e-7, 1e-8):
        motion = two_masses(
            LinearContact(c), play=play, mass=mass, begin=begin, end=end,
            force=lambda time: amplitude * np.sin(speed * time),
        )  # fmt: skip
        errors.append(float(np.max(np.abs(motion.at(times).force - elastic))) / amplitude)
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)


def test_undamped_impacts_are_chaotic_after_the_first() -> None:
    """Starts that differ by 1e-12 of the play agree in three impacts, and no longer later on."""

    def impacts(shift: float) -> list[float]:
        motion = two_masses(
            LinearContact(1e8), play=1e-3, mass=3.6, end=1.0, start=(1e-3 * shift, 0.0),
            force=lambda time: 900.0 * np.sin(400.0 * time), most_impacts=26,
        )  # fmt: skip
        assert motion.energy_residual < 1e-11
        return [impact.peak for impact in motion.impacts]

    first, second = np.array(impacts(0.0)), np.array(impacts(1e-12))
    gap = np.abs(first / second - 1.0)
    assert np.all(gap[:3] < 1e-10)
    assert gap[-1] > 1e-3


def test_as_many_impacts_as_are_allowed() -> None:
    motion = two_masses(
        LinearContact.of_ratio(1e7, 0.1, 3.6),
        play=1e-4, mass=3.6, end=10.0, start="rest", most_impacts=7,
        force=lambda time: 900.0 * np.sin(400.0 * time),
    )  # fmt: skip
    assert (len(motion.impacts), motion.ended) == (7, "it met 7 impacts")
    assert motion.times[-1] < 0.2
    one = two_masses(
        SPRING, **{**EXAMPLE, "ramp": 0.0, "end": 1.0}, start=(0.0, 0.1), most_impacts=1
    )
    assert (len(one.impacts), one.ended) == (1, "it met 1 impact")


GIVEN = {"law": SPRING, **EXAMPLE}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"law": 1e7}, "such as LinearContact"),
        ({"play": 0.0}, "play is 0, expected a positive number"),
        ({"play": -1e-4}, "play is -0.0001"),
        ({"play": np.inf}, "not finite"),
        ({"mass": 0.0}, "mass is 0"),
        ({"mass": (1.0, 2.0, 3.0)}, "m_11 and m_22"),
        ({"mass": (1.0, -2.0)}, "mass is -2"),
        ({"ramp": None}, "give one of ramp= "),
        ({"force": np.sin}, "give one of ramp= "),
        ({"ramp": -1.0}, "it is positive: give start="),
        ({"ramp": None, "force": 3.0}, "expected a function of time"),
        ({"ramp": None, "force": lambda t: "x", "start": "rest"}, "force at 0 s"),
        ({"ramp": None, "force": lambda t: 1.0 / 0.0, "start": "rest"}, "fails: ZeroDivisionError"),
        ({"ramp": None, "force": lambda t: [1.0, 2.0], "start": "rest"}, "expected a number"),
        ({"ramp": None, "force": np.sin}, "choose begin= before its reversal"),
        ({"start": "kick"}, "'release', 'rest' or a gap"),
        ({"start": (2e-4, 0.0)}, "lies from 0 to the play"),
        ({"start": (0.0, "a")}, "rate"),
        ({"begin": -1.0}, "give start="),
        ({"end": 0.0}, "it comes after the begin"),
        ({"most_impacts": 0}, "whole number"),
    ],
)
def test_bad_input(change: dict[str, Any], says: str) -> None:
    with pytest.raises(ArgumentError, match=says) as caught:
        two_masses(**{**GIVEN, **change})
    assert isinstance(caught.value, CardanError)
