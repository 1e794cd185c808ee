"""Run-ups of torsional lines against their equations of motion, integrated here."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve, minimize_scalar
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront, joint

import cardan_dyn as cd
from cardan_dyn import ArgumentError, vibration

BETA, RATIO = np.radians(20.0), 0.05
FRONT, BEHIND, DRIVEN, STIFFNESS, DAMPING = 0.5, 0.5, 1.0, 1.0, 2.0 * RATIO
FIRST, LAST, DURATION = 0.42, 0.5, 60.0
LINE = elastic_rigs.torsional_line(FRONT, BEHIND, STIFFNESS, damping_in=DAMPING)


def twist(phi: float, pace: float, gain: float, q: float, rate: float) -> float:
    """Return q'' by time of (J₁ + J₂ η²) (φ'' + q'') + J₂ η η_θ (φ' + q')² + k q + c q' = 0."""
    at = joint(BETA, np.asarray(phi + q))
    forces = BEHIND * at.first * at.second * (pace + rate) ** 2 + STIFFNESS * q + DAMPING * rate
    return float(-forces / (FRONT + BEHIND * at.first**2) - gain)


def own_run(
    rate: Callable[..., object], start: np.ndarray, end: float
) -> Callable[..., np.ndarray]:
    found = solve_ivp(rate, (0.0, end), start, "DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
    return found.sol


@pytest.fixture(scope="module")
def rising() -> vibration.RunUp:
    return vibration.run_up(elastic_rigs.scene(LINE, BETA), FIRST, LAST, DURATION)


def own_rising() -> Callable[..., np.ndarray]:
    """The twist and its rate over time, from the periodic motion of the first speed."""
    gain = (LAST - FIRST) / DURATION

    def rate(time: float, state: np.ndarray) -> list[float]:
        phi, pace = FIRST * time + 0.5 * gain * time**2, FIRST + gain * time
        return [state[1], twist(phi, pace, gain, *state)]

    begun = periodic(SpringInFront(BETA, FIRST, BEHIND, RATIO), np.zeros(2)).start
    return own_run(rate, begun * [1.0, FIRST], DURATION)


@pytest.mark.slow
def test_a_rising_speed_as_the_equation_has_it(rising: vibration.RunUp) -> None:
    own = own_rising()
    np.testing.assert_allclose(rising.position[:, 0], own(rising.time)[0], atol=2e-7)
    np.testing.assert_allclose(rising.speed, FIRST + (LAST - FIRST) * rising.time / DURATION)
    assert (rising.time[0], rising.time[-1]) == (0.0, DURATION)
    # Where the drive has gone round, and the last turn up to the end.
    gain = (LAST - FIRST) / DURATION
    way = FIRST * DURATION + 0.5 * gain * DURATION**2
    ends = 2.0 * np.pi * np.arange(1, int(way / (2.0 * np.pi)) + 1)
    marks = np.concatenate([[0.0], ends])
    spans = [*pairwise(marks), (way - 2.0 * np.pi, way)]
    assert len(rising.window) == len(spans) == 5
    for row, span in enumerate(spans):
        first, last = ((np.sqrt(FIRST**2 + 2.0 * gain * at) - FIRST) / gain for at in span)
        assert rising.window[row] == pytest.approx(2.0 * np.pi / (last - first), rel=1e-4)
        assert rising.window_time[row] == pytest.approx(0.5 * (first + last), rel=1e-3)
        # The greatest at any time, not at samples alone.
        swing = 0.5 * np.ptp(own(np.linspace(first, last, 4001))[0])
        assert rising.envelope[row, 0] == pytest.approx(swing, rel=1e-4)
    assert rising.captured_by is None
    assert np.isnan(rising.settled_speed) and np.isnan(rising.captured_speed)


@pytest.mark.slow
def test_a_twist_that_swings_faster_than_the_drive_turns_is_seen() -> None:
    """The run begins with a jerk, which a stiff shaft answers with some 15 swings a turn."""
    stiffness, damping, gain, duration = 100.0, 0.04, 0.08, 9.0
    line = elastic_rigs.torsional_line(FRONT, BEHIND, stiffness, damping_in=damping)
    found = vibration.run_up(elastic_rigs.scene(line, BETA), 0.5, 0.5 + gain * duration, duration)

    def rate(time: float, state: np.ndarray) -> list[float]:
        phi, pace = 0.5 * time + 0.5 * gain * time**2, 0.5 + gain * time
        acts = stiffness - STIFFNESS, damping - DAMPING
        at = joint(BETA, np.asarray(phi + state[0]))
        more = float(np.dot(acts, state)) / float(FRONT + BEHIND * at.first**2)
        return [state[1], twist(phi, pace, gain, *state) - more]

    system = SpringInFront(BETA, 0.05, BEHIND, 0.5 * damping / 10.0)
    own = own_run(rate, periodic(system, np.zeros(2)).start * [1.0, 0.5], duration)
    first = (np.sqrt(0.25 + 4.0 * np.pi * gain) - 0.5) / gain
    swing = 0.5 * np.ptp(own(np.linspace(0.0, first, 4001))[0])
    assert found.envelope[0, 0] == pytest.approx(swing, rel=5e-4)


@pytest.mark.slow
def test_what_constant_speeds_predict_is_the_motion_by_shooting(rising: vibration.RunUp) -> None:
    for row in (0, len(rising.predicted_speed) // 2):
        speed = float(rising.predicted_speed[row])
        system = SpringInFront(BETA, speed, BEHIND, RATIO)
        start = periodic(system, np.zeros(2)).start
        course = own_run(
            lambda phi, y, system=system: [y[1], float(system(phi, y[:1], y[1:])[0])], start, np.pi
        )(np.linspace(0.0, np.pi, 2001))
        swing = 0.5 * np.ptp(course[0])
        assert rising.predicted[row, 0] == pytest.approx(swing, rel=1e-5)
        # All the work that the drive does goes into the damper.
        turns = np.linspace(0.0, np.pi, 2001)
        work = np.trapezoid(DAMPING * speed * course[1] ** 2, turns)
        assert rising.predicted_torque[row] == pytest.approx(work / np.pi, rel=1e-6)
    assert rising.predicted_speed[[0, -1]] == pytest.approx([FIRST, LAST])


def test_tables_and_figures_of_a_run(rising: vibration.RunUp) -> None:
    frame = rising.to_dataframe()
    np.testing.assert_array_equal(frame.envelope, rising.envelope[:, 0])
    expected = np.interp(rising.window, rising.predicted_speed, rising.predicted[:, 0])
    np.testing.assert_allclose(frame.predicted, expected)
    assert rising.plot().axes and rising.plot.torque().axes
    assert f"{FIRST:g} to {LAST:g} rad/s in {DURATION:g} s" in repr(rising)
    with pytest.raises(ArgumentError, match="'twist' is not free; free: twist_in"):
        rising.plot("twist")


@pytest.mark.slow
def test_a_torque_moves_the_drive_as_the_equations_have_it() -> None:
    """J₀ φ'' = T + k q + c q', from a motion whose speed at φ = 0 returns after half a turn."""
    torque = 0.01
    found = vibration.run_up(elastic_rigs.scene(LINE, BETA), FIRST, LAST, 15.0, torque=torque)

    def rates(state: np.ndarray, acts: float) -> tuple[float, float]:
        phi, pace, q, rate = state
        gain = (acts + STIFFNESS * q + DAMPING * rate) / DRIVEN
        return gain, twist(phi, pace, gain, q, rate)

    def by_time(_: float, state: np.ndarray, acts: float = torque) -> list[float]:
        gain, bend = rates(state, acts)
        return [state[1], gain, state[3], bend]

    def miss(unknown: np.ndarray) -> np.ndarray:
        *start, acts = unknown

        def by_way(phi: float, state: np.ndarray) -> np.ndarray:
            pace, q, rate, _ = state
            gain, bend = rates(np.array([phi, pace, q, rate]), acts)
            return np.array([gain, rate, bend, 1.0]) / pace

        begun = np.array([*start, 0.0])
        end = solve_ivp(by_way, (0.0, np.pi), begun, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        return np.append(end[:3] - begun[:3], end[3] - np.pi / FIRST)

    pace, q, rate, _ = fsolve(miss, [FIRST, 0.0, 0.0, 0.0], xtol=1e-13)
    own = own_run(by_time, np.array([0.0, pace, q, rate]), float(found.time[-1]))(found.time)
    np.testing.assert_allclose(found.speed, own[1], rtol=1e-6)
    np.testing.assert_allclose(found.position[:, 0], own[2], atol=1e-6)
    # Within a turn the drive gives way.
    assert np.ptp(found.speed) > 5.0 * np.ptp(found.window)


def absorbed(speed: float, beta: float, ratio: float) -> float:
    """Return the mean torque that the damper of a spring behind the joint takes, of ω_n = 1.

    It is forced by φ₂ = φ + Σ κⁿ sin(2 n φ)/n. An order 2 n has the amplitude
    κⁿ/n r²/|1 - r² + 2 i ζ r|, r = 2 n Ω, and takes c (2 n Ω)² A²/2 of the power.
    """
    order = 2.0 * np.arange(1, 6)
    r = order * speed
    size = 2.0 / order * np.tan(beta / 2.0) ** order * r**2
    size /= np.abs(1.0 - r**2 + 2j * ratio * r)
    return float(np.sum(ratio * r**2 * size**2) / speed)


def most_absorbed(low: float, high: float, *line: float) -> tuple[float, float]:
    found = minimize_scalar(
        lambda speed: -absorbed(speed, *line),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return float(found.x), -float(found.fun)


def behind(inertia: float, beta: float, ratio: float) -> cd.Scene:
    line = elastic_rigs.torsional_line(inertia, 1.0, None, 1.0, damping_out=2.0 * ratio)
    return elastic_rigs.scene(line, beta)


@pytest.mark.slow
def test_a_barrier_is_what_dampers_absorb_at_most() -> None:
    """A heavy drive, which is held where its torque is half of that."""
    line = np.radians(10.0), 0.05
    speed, most = most_absorbed(0.45, 0.55, *line)
    torque = 0.5 * most
    found = vibration.run_up(behind(1e5, *line), 0.42, 0.56, 18.0, torque=torque)
    (barrier,) = found.barriers
    assert (barrier.order, barrier.mode, barrier.whirl) == (2.0, 1, "planar")
    assert barrier.speed == pytest.approx(speed, rel=5e-5)
    assert barrier.torque == pytest.approx(most, rel=2e-5)
    assert barrier.available == pytest.approx(torque)
    assert not barrier.is_passed
    held = brentq(lambda at: absorbed(at, *line) - torque, 0.42, speed)
    assert barrier.holds == pytest.approx(held, rel=1e-4)
    expected = [absorbed(at, *line) for at in found.predicted_speed.tolist()]
    np.testing.assert_allclose(found.predicted_torque, expected, rtol=2e-4)
    np.testing.assert_allclose(found.predicted_torque - found.predicted_lack, torque, rtol=1e-7)


@pytest.mark.slow
def test_a_low_barrier_before_a_high_one_counts() -> None:
    """Order 4 absorbs some ten thousand times less than order 2, and holds a weak drive."""
    line = np.radians(10.0), 5e-3
    low, high = (most_absorbed(*ends, *line) for ends in ((0.245, 0.255), (0.49, 0.51)))
    assert high[1] > 5e3 * low[1]
    found = vibration.run_up(behind(0.4, *line), 0.23, 0.53, 10.0)
    assert [item.order for item in found.barriers] == [4.0, 2.0]
    for barrier, (speed, most) in zip(found.barriers, (low, high), strict=True):
        assert (barrier.speed, barrier.torque) == pytest.approx((speed, most), rel=1e-3)


@pytest.mark.parametrize(
    ("start", "end", "duration"), [(0.0, 1.0, 9.0), (1.0, -1.0, 9.0), (1.0, 1.0, 9.0), (1, 2, 0)]
)
def test_what_is_asked_for_wrongly(start: float, end: float, duration: float) -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1)
    with pytest.raises(ArgumentError):
        vibration.run_up(scene, start, end, duration)
