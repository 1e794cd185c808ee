"""What the notebook on Dresig and Thümmel shows: their example, f(τ), Bild 8, their errors."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from stories import tell

from cardan_dyn.analytic import clearance, damped_impact, impact, peak_factor
from cardan_dyn.clearance import LinearContact, influence

pytestmark = [pytest.mark.slow, pytest.mark.campaign]


@pytest.fixture(scope="module")
def story() -> SimpleNamespace:
    return tell("dresig_thuemmel")


def test_the_curves_of_coupler_2_are_flat(story: SimpleNamespace) -> None:
    def flatness(joint: str) -> float:
        """Return the width of a joint's force curve over its length."""
        ends = story.turn.wrench(joint, "world").force[:-1, :2]
        least, greatest = np.sqrt(np.linalg.eigvalsh(ends.T @ ends))
        return float(least / greatest)

    assert flatness("needle_pin") < 0.02 < 0.05 < flatness("main_shaft")
    # Inertia alone: every force grows with the square of the speed.
    double = story.needles.sweep(story.position, speed=2.0 * story.omega)
    np.testing.assert_allclose(
        double.wrench("needle_pin", "world").force[:, :2],
        4.0 * story.turn.wrench("needle_pin", "world").force[:, :2],
        atol=1e-9,
    )


def test_the_ramp_grows_with_the_cube_of_the_speed(story: SimpleNamespace) -> None:
    slopes = []
    for speed in (story.omega, 2.0 * story.omega):
        turn = story.needles.sweep(story.position, speed=speed)
        force = turn.wrench("needle_pin", "world").force[:, 1]
        changes = np.flatnonzero(np.sign(force[:-1]) != np.sign(force[1:]))
        assert len(changes) == 2
        slopes.append(np.diff(force)[changes] / (np.diff(story.position)[changes] / speed))
    np.testing.assert_allclose(slopes[1], 8.0 * slopes[0], rtol=1e-9)
    k_1 = np.abs(slopes[0]) / story.omega**3
    for k, slope in zip(k_1, slopes[1], strict=True):
        ramp = clearance.force_ramp(k, 2.0 * story.omega)
        np.testing.assert_allclose(ramp, np.abs(slope), rtol=1e-9)


def test_the_example(story: SimpleNamespace) -> None:
    result = story.result
    assert round(1e3 * float(result.t_1), 5) == 1.81712
    assert round(float(result.v_1), 6) == 0.165096
    assert round(float(result.tau), 5) == 3.02853
    assert round(np.rad2deg(float(result.theta_m)), 3) == 142.484
    assert round(float(result.peak), 2) == 2181.89
    assert (round(float(result.rigid), 2), round(float(result.added), 2)) == (1191.31, 990.58)
    assert round(100.0 * float(result.peak) / 2250.0) == 97
    theta, tau = 0.8e-3 * np.sqrt(1e7 / 3.6), float(result.tau)
    printed_26 = (
        12.0 * 1e7 * 0.5e-4 / tau**2
        * (1.0 + theta / tau + (tau / 2.0 - 1.0 / tau) * np.sin(theta) - np.cos(theta))
    )  # fmt: skip
    np.testing.assert_allclose(
        impact.contact_force(0.8e-3, **story.example), printed_26, rtol=1e-12
    )


def test_bild_7_is_what_the_masses_do(story: SimpleNamespace) -> None:
    np.testing.assert_allclose(story.touch.start, story.result.t_1, rtol=1e-9)
    np.testing.assert_allclose(story.touch.speed, story.result.v_1, rtol=1e-9)
    np.testing.assert_allclose(story.touch.peak, story.result.peak, rtol=1e-8)
    np.testing.assert_allclose(story.found_force, story.his_force[1:], atol=2e-4)
    assert round(story.released.peak, 2) == 1833.27


@pytest.mark.parametrize("start", ["rest", "release"])
def test_both_starts_by_an_integration_of_ones_own(story: SimpleNamespace, start: str) -> None:
    mass, stiffness, half, ramp = story.example.values()

    def contact(q: float) -> float:
        return stiffness * (q - 2.0 * half) if q > 2.0 * half else 0.0

    def rates(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (ramp * t - contact(y[0])) / mass]

    def arrives(t: float, y: np.ndarray) -> float:
        return y[0] - 2.0 * half

    def turns(t: float, y: np.ndarray) -> float:
        return y[1]

    arrives.terminal, arrives.direction = True, 1.0
    turns.terminal, turns.direction = True, -1.0
    options = {"rtol": 1e-12, "atol": 1e-16, "max_step": 1e-5}
    begun = [0.0, ramp / stiffness if start == "release" else 0.0]
    flight = solve_ivp(rates, (0.0, 0.01), begun, events=arrives, **options)
    end = flight.t[-1]
    hit = solve_ivp(
        rates, (end, end + 0.01), flight.y[:, -1] + [1e-18, 0.0], events=turns, **options
    )
    peak = impact.reversal(**story.example, start=start).peak
    np.testing.assert_allclose(contact(hit.y[0, -1]), peak, rtol=1e-8)


def test_with_damping(story: SimpleNamespace) -> None:
    law = LinearContact.of_ratio(1e7, 0.25, 3.6)
    unloads = story.example["ramp"] / 1e7
    scene = story.two_masses(**story.example, law=law)
    begun = -0.5e-4 - law.damping * unloads / 1e7
    touch = scene.simulate(3.4e-3, position=begun, speed=unloads, rtol=1e-12).touches[-1]
    numbers = (*story.example.values(), 0.25)
    np.testing.assert_allclose(touch.peak, damped_impact.damped_peak(*numbers), rtol=1e-6)
    flown = damped_impact.flight(*numbers)
    np.testing.assert_allclose(touch.start, flown.t_1)
    # The contact lets go while its spring is still pressed.
    assert flown.t_1 > impact.reversal(**story.example, start="release").t_1


def test_bild_5(story: SimpleNamespace) -> None:
    np.testing.assert_allclose(story.found_f, peak_factor.peak_factor(story.tried), rtol=1e-7)
    above = story.tau > 2.0
    exact = peak_factor.peak_factor(story.tau)
    np.testing.assert_allclose(story.printed_36(story.tau[above]), exact[above], rtol=1e-12)
    too_small = story.printed_36(np.array([1.0])) / peak_factor.peak_factor(1.0) - 1.0
    assert round(100.0 * float(too_small[0])) == -51
    for at, percent in ((2.0, -8.0), (3.03, -1.2), (5.0, -0.1)):
        error = peak_factor.peak_factor_linearised(at) / peak_factor.peak_factor(at) - 1.0
        assert round(100.0 * float(error), 1) == percent
    for at, share in ((2.0, 0.760), (3.0, 0.838), (5.0, 0.929), (10.0, 0.981)):
        released = peak_factor.peak_factor(at, start="release")
        assert round(float(released / peak_factor.peak_factor(at)), 3) == share


def test_bild_8(story: SimpleNamespace) -> None:
    for name, peaks in story.varied.items():
        for factor, peak in zip(story.factors, peaks, strict=True):
            closed = impact.reversal(**{**story.example, name: factor * story.example[name]})
            np.testing.assert_allclose(peak, closed.peak, rtol=1e-7)
    # τ ~ 1/Ω from (31), and the mass to the power 1/6.
    base = clearance.tau_from_speed(3.6, 1e7, 0.5e-4, 1.0, 200.0)
    np.testing.assert_allclose(clearance.tau_from_speed(3.6, 1e7, 0.5e-4, 1.0, 400.0), base / 2.0)
    np.testing.assert_allclose(
        clearance.tau_from_speed(7.2, 1e7, 0.5e-4, 1.0, 200.0), base / 2 ** (1 / 6)
    )


def test_the_exponents(story: SimpleNamespace) -> None:
    expected = {
        "rest": [1.909, 0.636, 0.364, 0.318, 0.045],
        "release": [1.648, 0.549, 0.451, 0.275, 0.176],
    }
    for model in (story.paper, story.own):
        powers = story.exponents[model.start]
        assert [round(float(value), 3) for value in powers.values()] == expected[model.start]
        for name, value in powers.items():
            near = influence(model, name, np.exp([-1e-4, 1e-4])).peak
            slope = np.log(near[1] / near[0]) / 2e-4
            np.testing.assert_allclose(slope, value, rtol=1e-6, atol=1e-8)


def test_every_joint(story: SimpleNamespace) -> None:
    found = story.found
    for name in found.ranking:
        for item in found[name].reversals:
            # m from the mechanism, F₀/t₀ from the forces: all else is the two-mass model.
            numbers = item.reduced_mass, 1e8, 0.5e-4, item.force_slope
            released = impact.reversal(*numbers, start="release")
            np.testing.assert_allclose(item.tau, released.tau, rtol=1e-12)
            np.testing.assert_allclose(item.rigid + item.added, released.peak, rtol=1e-12)
    assert max(item.turn_through for item in found["needle_pin"].reversals) < 0.01
    assert min(item.turn_through for item in found["main_shaft"].reversals) > 0.1


def test_bild_6_by_simulation(story: SimpleNamespace) -> None:
    assert story.played.reason == ""
    assert len(story.compared) == 2
    for item in story.compared:
        assert abs(item.error) < 0.05
        assert np.mean(item.simulated) > 2.0 * item.reversal.rigid_ahead
    assert np.max(story.played["needle_pin"].depth) < 0.5e-4
