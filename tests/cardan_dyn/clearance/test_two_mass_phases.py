"""Phases in closed form: against SciPy's integration, and against motions known by heart."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan_dyn.clearance.two_mass_phases import Begun, Flight, LinearTouch, Push
from cardan_dyn.elements.contact_laws import LinearContact

MASS, PLAY = 2.0, 1e-3


def flight(depth: float, rate: float, value: float = 0.0, slope: float = 0.0) -> Flight:
    return Flight(Begun(0.5, -1, depth, rate), MASS, Push(value, slope))


def test_a_flight_under_a_ramp_crosses_the_play() -> None:
    phase = flight(0.0, 0.0, slope=-3e3)
    assert phase.fly(PLAY, 10.0) == "crossed"
    # Dresig and Thümmel (15), (16): t₁ = ∛(12 m s t₀ / F₀), v₁ = 6 s / t₁.
    time = math.cbrt(6.0 * MASS * PLAY / 3e3)
    assert phase.end - 0.5 == pytest.approx(time, rel=1e-14)
    assert phase.last == pytest.approx((-PLAY, -3.0 * PLAY / time), rel=1e-13)
    assert phase.work == pytest.approx(0.5 * MASS * phase.last[1] ** 2, rel=1e-13)
    assert (phase.loss, phase.is_contact) == (0.0, False)


def test_a_flight_returns() -> None:
    phase = flight(0.0, -0.1, value=40.0)
    assert phase.fly(PLAY, 10.0) == "returned"
    assert phase.end - 0.5 == pytest.approx(2.0 * MASS * 0.1 / 40.0, rel=1e-14)
    assert phase.last[1] == pytest.approx(0.1, rel=1e-13)
    assert flight(0.0, 0.0, value=40.0).fly(PLAY, 10.0) == "returned"
    assert flight(-0.5 * PLAY, 0.1).fly(PLAY, 10.0) == "returned"


def test_a_flight_whose_time_is_up() -> None:
    phase = flight(-0.5 * PLAY, 0.0, value=1e-3)
    assert phase.fly(PLAY, 0.6) == ""
    assert phase.end == 0.6
    depth, rate = phase.states(np.array([0.5, 0.55]))
    np.testing.assert_allclose(rate, [0.0, 0.05 * 1e-3 / MASS], rtol=1e-12)
    np.testing.assert_allclose(depth, -0.5 * PLAY + 0.5 * 1e-3 / MASS * np.array([0.0, 0.05**2]))


def test_a_turning_flight_just_misses_the_other_side() -> None:
    """The force turns round in the flight; at what distance follows from its cubic."""
    rate, slope = -0.1, 6e3
    turning = math.sqrt(2.0 * MASS * -rate / slope)
    way = -(rate * turning + slope * turning**3 / (6.0 * MASS))
    for play, how in ((1.0001 * way, "returned"), (0.9999 * way, "crossed")):
        assert flight(0.0, rate, slope=slope).fly(play, 10.0) == how


def test_a_spring_that_comes_back_slowly_is_left() -> None:
    law = LinearContact(1e4, 50.0)
    left = flight(1e-4, -1e4 * 1e-4 / 50.0)
    assert left.rise(law, 10.0) == "cleared"
    assert left.end - 0.5 == pytest.approx(50.0 / 1e4, rel=1e-13)
    assert left.loss == pytest.approx(0.5 * 1e4 * 1e-8, rel=1e-12)
    # A force that presses back meets the spring before it has come back.
    back = flight(1e-4, -1e4 * 1e-4 / 50.0, value=40.0)
    assert back.rise(law, 10.0) == "resumed"
    depth, rate = back.last
    assert depth > 0.0
    assert 1e4 * depth + 50.0 * rate == pytest.approx(0.0, abs=1e-12)


PUSHES = [Push(0.0, 0.0), Push(3.0, 0.0), Push(-5.0, 0.0), Push(0.0, 900.0), Push(20.0, -4e3)]


@pytest.mark.parametrize("push", PUSHES)
@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.5, 1.0, 3.0])
def test_contacts_are_those_of_an_integration(push: Push, ratio: float) -> None:
    law, until = LinearContact.of_ratio(1e4, ratio, MASS), 0.5
    phase = LinearTouch(Begun(0.0, 1, 0.0, 0.3, 0.3), law, MASS, push)

    def force(y: np.ndarray) -> float:
        return law.stiffness * y[0] + law.damping * y[1]

    def rate(time: float, y: np.ndarray) -> list[float]:
        outer = push.value + push.slope * time
        return [y[1], (outer - force(y)) / MASS, outer * y[1], law.damping * y[1] ** 2]

    def parted(time: float, y: np.ndarray) -> float:
        return force(y) if time > 1e-6 else 1.0

    def top(time: float, y: np.ndarray) -> float:
        return law.stiffness * y[1] + law.damping * rate(time, y)[1]

    parted.terminal, parted.direction, top.direction = True, -1, -1  # type: ignore[attr-defined]
    run = solve_ivp(
        rate, (0.0, until), [0.0, 0.3, 0.0, 0.0], method="DOP853", events=(parted, top),
        rtol=1e-12, atol=1e-14, dense_output=True, max_step=2e-3,
    )  # fmt: skip
    how = phase.press(until)
    assert how == ("parted" if run.t_events[0].size else "")
    assert phase.end == pytest.approx(run.t[-1], rel=1e-9)
    times = np.linspace(0.0, phase.end, 50)
    depth, speed = phase.states(times)
    wanted = run.sol(times)
    np.testing.assert_allclose(depth, wanted[0], atol=1e-10 * np.max(np.abs(wanted[0])))
    np.testing.assert_allclose(speed, wanted[1], atol=1e-10 * 0.3)
    assert phase.work == pytest.approx(run.y[2, -1], abs=1e-10)
    assert phase.loss == pytest.approx(run.y[3, -1], abs=1e-10)
    tops = [force(y) for y in run.y_events[1][:1]]
    at_once = [force(np.array([0.0, 0.3]))] if top(0.0, np.array([0.0, 0.3])) < 0.0 else []
    peak = max(tops + at_once, default=-np.inf)
    assert phase.peak == pytest.approx(peak, rel=1e-9)


def test_a_contact_that_is_pulled_off_at_once() -> None:
    phase = LinearTouch(Begun(0.2, 1, 0.0, 0.0), LinearContact(1e4), MASS, Push(-1.0, 0.0))
    assert phase.press(1.0) == "parted"
    assert phase.end == 0.2


def test_a_contact_that_stays_is_not_searched_for_ever() -> None:
    phase = LinearTouch(Begun(0.0, 1, 0.0, 1e-3), LinearContact(1e8), MASS, Push(1.0, 1e5))
    assert phase.press(10.0) == ""
    # It swings about the line of a spring under the ramp, all the time.
    assert phase.last[0] == pytest.approx((1.0 + 1e6) / 1e8, abs=1e-3 / 7071.0 + 1e-8)
    work = 0.5 * 1e8 * phase.last[0] ** 2 + 0.5 * MASS * (phase.last[1] ** 2 - 1e-6)
    assert phase.work == pytest.approx(work, rel=1e-12)
