"""Impact in a joint with play, against the solution of its equations of motion at 50 digits."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from testkit.cross_geometry import ULP, relative_errors
from testkit.two_mass_impact import EXAMPLE, STARTS, Motion

from cardan_dyn.analytic import clearance, impact
from cardan_dyn.analytic import peak_factor as pf

modest = settings(max_examples=60, deadline=None, derandomize=True)
CASES = [
    EXAMPLE,
    {"mass": 1.0, "stiffness": 1e5, "half_clearance": 1e-3, "ramp": 1e6},
    {"mass": 0.02, "stiffness": 3e8, "half_clearance": 2e-5, "ramp": 1e4},
    {"mass": 5.0, "stiffness": 1e4, "half_clearance": 1e-7, "ramp": 1e5},
]


def test_the_reference_solves_the_differential_equation():
    motion = Motion(**EXAMPLE, start="release")
    for u in (mp.mpf("1e-4"), mp.mpf("2e-3")):
        left = mp.diff(motion.force, u, 2) + motion.omega**2 * motion.force(u)
        right = motion.omega**2 * motion.ramp * (motion.t_1 + u)
        assert abs(left / right - 1) < mp.mpf(10) ** -40


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("case", CASES)
def test_reversal_is_exact(case, start):
    motion = Motion(**case, start=start)
    result = impact.reversal(**case, start=start)
    assert relative_errors(result.t_1, [motion.t_1])[0] <= 8 * ULP
    assert relative_errors(result.v_1, [motion.v_1])[0] <= 8 * ULP
    found = motion.peak()
    if found is None:
        assert start == "release"
        assert np.isnan([result.theta_m, result.peak, result.rigid, result.added]).all()
        return
    time, force = found
    rigid = motion.ramp * (motion.t_1 + time)
    assert relative_errors(result.theta_m, [motion.omega * time])[0] <= 8 * ULP
    assert relative_errors(result.peak, [force])[0] <= 8 * ULP
    assert relative_errors(result.rigid, [rigid])[0] <= 8 * ULP
    assert relative_errors(result.added, [force - rigid])[0] <= 8 * ULP


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("case", CASES)
def test_force_over_time_is_exact(case, start):
    motion = Motion(**case, start=start)
    peak = impact.reversal(**case).theta_m / float(motion.omega)
    times = np.array([1e-9, 1e-3, 0.1, 0.5, 1.0]) * peak
    exact = [motion.force(mp.mpf(float(t))) for t in times]
    values = impact.contact_force(times, **case, start=start)
    assert np.max(relative_errors(values, exact)) <= 8 * ULP
    exact = [motion.ramp * (motion.t_1 + mp.mpf(float(t))) for t in times]
    values = impact.exciting_force(times, **case, start=start)
    assert np.max(relative_errors(values, exact)) <= 8 * ULP
    assert impact.contact_force([-1.0, 0.0], **case, start=start).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("start", "peak"), [("rest", 2181.89), ("release", 1833.27)])
def test_direct_simulation_of_both_masses(start, peak):
    m_11, m_22 = 9.0, 6.0
    assert clearance.reduced_mass(m_11, m_22) == pytest.approx(EXAMPLE["mass"], rel=4 * ULP)
    c, play, ramp = EXAMPLE["stiffness"], 2 * EXAMPLE["half_clearance"], EXAMPLE["ramp"]

    def motion(t, y):
        spring = c * (y[0] - y[1] - play) if y[0] - y[1] > play else 0.0
        force = ramp * t - spring
        return [y[2], y[3], force / m_11, -force / m_22]

    v_0 = ramp / c if start == "release" else 0.0
    begin = [0.0, 0.0, v_0 * m_22 / (m_11 + m_22), -v_0 * m_11 / (m_11 + m_22)]
    run = solve_ivp(
        motion, (0.0, 4e-3), begin, method="DOP853", rtol=1e-10, atol=1e-14, max_step=2e-6
    )
    force = c * (run.y[0] - run.y[1] - play)
    assert np.max(force) == pytest.approx(peak, abs=0.01)
    assert impact.reversal(**EXAMPLE, start=start).peak == pytest.approx(peak, abs=0.005)


def test_printed_form_of_26():
    result = impact.reversal(**EXAMPLE)
    tau, omega = result.tau, clearance.natural_frequency(3.6, 1e7)
    time = np.linspace(0, 2e-3, 50)
    theta = omega * time
    bracket = 1 + theta / tau + (tau / 2 - 1 / tau) * np.sin(theta) - np.cos(theta)
    printed = 12 * 1e7 * 0.5e-4 / tau**2 * bracket
    np.testing.assert_allclose(impact.contact_force(time, **EXAMPLE), printed, atol=1e-9)


@modest
@given(st.floats(0.05, 50.0), st.sampled_from(STARTS))
def test_nothing_is_greater_before_the_peak(tau, start):
    case = {"mass": 1.0, "stiffness": 1.0, "half_clearance": tau**3 / 12, "ramp": 1.0}
    result = impact.reversal(**case, start=start)
    if np.isnan(result.peak):
        force = impact.contact_force(np.linspace(0, 20, 2001), **case, start=start)
        assert np.all(np.diff(force) > -1e-12)
        return
    force = impact.contact_force(np.linspace(0, result.theta_m, 500), **case, start=start)
    assert np.max(force) == pytest.approx(result.peak, rel=1e-12)
    assert np.argmax(force) == 499 or result.peak - force[-1] < 1e-10 * result.peak
    assert np.all(np.diff(force) > -1e-10 * result.peak)
    assert result.rigid + result.added == pytest.approx(result.peak, rel=1e-14)
    factor = pf.peak_factor(result.tau, start=start) * tau**3 / 12
    assert factor == pytest.approx(result.peak, rel=1e-12)


def test_release_lowers_the_peak():
    tau = np.array([2.0, 3.0, 5.0, 10.0])
    ratio = pf.peak_factor(tau, start="release") / pf.peak_factor(tau)
    assert ratio == pytest.approx([0.760, 0.838, 0.929, 0.981], abs=6e-4)
    v_0 = EXAMPLE["ramp"] / EXAMPLE["stiffness"]
    result = impact.reversal(**EXAMPLE)
    assert v_0 / result.v_1 == pytest.approx(2 / result.tau**2, rel=1e-14)


def test_without_clearance():
    case = EXAMPLE | {"half_clearance": 0.0}
    result = impact.reversal(**case)
    omega = clearance.natural_frequency(3.6, 1e7)
    assert (result.t_1, result.v_1, result.tau, result.added) == (0.0, 0.0, 0.0, 0.0)
    assert result.peak == pytest.approx(2 * np.pi * EXAMPLE["ramp"] / omega, rel=4 * ULP)
    assert np.isnan(impact.reversal(**case, start="release").peak)


def test_shapes_and_nan():
    mass = np.array([[3.6], [np.nan]])
    result = impact.reversal(mass, 1e7, [0.5e-4, 1e-4, 2e-4], 360e3)
    assert all(value.shape == (2, 3) for value in result)
    assert all(np.isnan(value).tolist() == [[False] * 3, [True] * 3] for value in result)
    assert all(isinstance(value, float) for value in impact.reversal(**EXAMPLE))
    assert isinstance(impact.contact_force(1e-3, **EXAMPLE), float)
    force = impact.contact_force([0.0, np.nan, 1e-3], **EXAMPLE)
    assert np.isnan(force).tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: impact.reversal(**EXAMPLE, start="jump"),
            "'jump' is not one of 'rest', 'release'",
        ),
        (lambda: impact.reversal(**EXAMPLE | {"mass": 0.0}), r"mass = 0\.0"),
        (
            lambda: impact.reversal(**EXAMPLE | {"half_clearance": -1e-5}),
            r"half_clearance = -1e-05 .*\[0, inf\)",
        ),
        (lambda: impact.reversal(**EXAMPLE | {"ramp": 0.0}), r"ramp = 0\.0"),
        (lambda: impact.reversal(**EXAMPLE | {"stiffness": -1.0}), r"stiffness = -1\.0"),
        (
            lambda: impact.contact_force(np.zeros(2), **EXAMPLE | {"ramp": np.ones(3)}),
            r"time \(2,\), .*\(3,\)",
        ),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()
