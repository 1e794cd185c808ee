"""Impact in a joint with play, against the solution of its equations of motion at 50 digits."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from testkit.cross_geometry import ULP, relative_errors

from analytic import clearance, impact

modest = settings(max_examples=60, deadline=None, derandomize=True)
EXAMPLE = {"mass": 3.6, "stiffness": 1e7, "half_clearance": 0.5e-4, "ramp": 360e3}
STARTS = ["rest", "release"]
CASES = [
    EXAMPLE,
    {"mass": 1.0, "stiffness": 1e5, "half_clearance": 1e-3, "ramp": 1e6},
    {"mass": 0.02, "stiffness": 3e8, "half_clearance": 2e-5, "ramp": 1e4},
    {"mass": 5.0, "stiffness": 1e4, "half_clearance": 1e-7, "ramp": 1e5},
]


class Motion:
    """Both stages of the two-mass model, each solved by its own differential equation."""

    def __init__(self, mass, stiffness, half_clearance, ramp, start):
        m, c, s, r = (mp.mpf(x) for x in (mass, stiffness, half_clearance, ramp))
        self.omega, self.ramp = mp.sqrt(c / m), r
        v_0 = r / c if start == "release" else mp.mpf(0)

        def play_left(t):
            # m q'' = r t from q = 0, q' = v_0.
            return v_0 * t + r * t**3 / (6 * m) - 2 * s

        upper = mp.cbrt(12 * m * s / r)
        self.t_1 = self.between(play_left, mp.mpf(0), upper)
        self.v_1 = v_0 + r * self.t_1**2 / (2 * m)
        # F'' + omega^2 F = omega^2 r (t_1 + u): ramp plus free oscillation, from F = 0, F' = c v_1.
        conditions = mp.matrix([[1, 0], [0, self.omega]])
        right = mp.matrix([-r * self.t_1, c * self.v_1 - r])
        self.cosine, self.sine = mp.lu_solve(conditions, right)

    def force(self, u):
        free = self.cosine * mp.cos(self.omega * u) + self.sine * mp.sin(self.omega * u)
        return self.ramp * (self.t_1 + u) + free

    def peak(self):
        """Time and force of the first maximum; None if the force never turns back."""

        def slope(u):
            return mp.diff(self.force, u)

        def curvature(u):
            return mp.diff(self.force, u, 2)

        # The slope is a constant plus a sine: it falls to its least value once in a period.
        step = mp.pi / self.omega / 10
        for k in range(1, 41):
            if curvature((k - 1) * step) < 0 <= curvature(k * step):
                flattest = self.between(curvature, (k - 1) * step, k * step)
                if slope(flattest) > 0:
                    return None
                root = self.between(slope, mp.mpf(0), flattest)
                return root, self.force(root)
        raise AssertionError

    @staticmethod
    def between(function, low, high):
        return mp.findroot(function, (low, high), solver="anderson", tol=1e-120, maxsteps=200)


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
@pytest.mark.parametrize("tau", [1e-3, 0.5, 1.9, 1.999, 2.0, 2.001, 3.03, 10.0, 1e3])
def test_dimensionless_peak_is_exact(tau, start):
    # m = c = 1 and s = tau^3 / 12 with a unit ramp give this tau; f = F_max / (c s).
    s = mp.mpf(tau) ** 3 / 12
    motion = Motion(1, 1, s, 1, start)
    found = motion.peak()
    angle, factor = (f(tau, start=start) for f in (impact.peak_angle, impact.peak_factor))
    if found is None:
        assert start == "release"
        assert tau < 1.8386
        assert np.isnan([angle, factor]).all()
        return
    assert relative_errors(angle, [found[0]])[0] <= 8 * ULP
    assert relative_errors(factor, [found[1] / s])[0] <= 8 * ULP


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
@given(st.floats(0.05, 50.0))
def test_printed_sine_and_cosine_of_the_peak(tau):
    """(27b) and (27c), which together take the right branch."""
    theta = impact.peak_angle(tau)
    scale = tau**4 + 4
    assert np.cos(theta) == pytest.approx((4 - 2 * tau**2 - 2 * tau**3) / scale, abs=1e-13)
    assert np.sin(theta) == pytest.approx((tau**4 - 2 * tau**2 - 4 * tau) / scale, abs=1e-13)


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
    factor = impact.peak_factor(result.tau, start=start) * tau**3 / 12
    assert factor == pytest.approx(result.peak, rel=1e-12)


def test_linearised_form():
    short = 100 * (
        1 - impact.peak_factor_linearised([2, 3.03, 5]) / impact.peak_factor([2, 3.03, 5])
    )
    assert short == pytest.approx([8.0, 1.2, 0.1], abs=0.05)


def test_limits():
    for tau, side in ((1e-4, 0), (1e7, 1)):
        ratio = impact.peak_factor(tau) / impact.peak_factor_limits(tau)[side]
        assert ratio == pytest.approx(1.0, abs=1e-4 if side == 0 else 3e-7)
    tau = np.geomspace(0.01, 100, 50)
    assert np.all(impact.peak_factor(tau) > impact.peak_factor_limits(tau)[1])


@pytest.mark.parametrize("start", ["rest", "release"])
@pytest.mark.parametrize(
    "tau", [1e-110, 1e-102, 1e-90, 1e-20, 1e20, 1e60, 1e90, 1e110, 1e200, 1e300]
)
def test_factors_where_powers_of_tau_are_beyond_floats(tau, start):
    x = mp.mpf(tau)
    if start == "rest":
        reference = 6 / x + 12 / x**2 + 24 / x**3 * mp.atan2(x, x - 2)
        linear = mp.pi / 2 + (2 * x**3 + 2 * x**2 - 4) / (x**4 + 4)
        other = impact.peak_factor_linearised(tau)
        assert other == pytest.approx(float(12 / x**2 * (x / 2 + 1 + linear / x)), rel=1e-14)
        assert impact.peak_factor_limits(tau)[0] == pytest.approx(float(24 * mp.pi / x**3))
    elif tau < 1:
        reference = mp.nan
    else:
        reference = 6 / x  # the next term is 1 / tau of it
    value = impact.peak_factor(tau, start=start)
    assert value == pytest.approx(float(reference), rel=1e-14, nan_ok=True)


def test_release_lowers_the_peak():
    tau = np.array([2.0, 3.0, 5.0, 10.0])
    ratio = impact.peak_factor(tau, start="release") / impact.peak_factor(tau)
    assert ratio == pytest.approx([0.760, 0.838, 0.929, 0.981], abs=6e-4)
    v_0 = EXAMPLE["ramp"] / EXAMPLE["stiffness"]
    result = impact.reversal(**EXAMPLE)
    assert v_0 / result.v_1 == pytest.approx(2 / result.tau**2, rel=1e-14)


def test_edge_of_the_release():
    edge = np.cbrt(np.sqrt(2 * np.sqrt(2) - 2) * (4 + 2 * np.sqrt(2)))
    assert edge == pytest.approx(1.8386, abs=5e-5)
    below, above = impact.peak_factor([edge * 0.9999, edge * 1.0001], start="release")
    assert np.isnan(below)
    assert above > 0.0


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
    for start in STARTS:
        factor = impact.peak_factor([3.0, np.nan], start=start)
        assert np.isnan(factor).tolist() == [False, True]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: impact.peak_factor(0.0), r"tau = 0\.0 .*\(0, inf\)"),
        (lambda: impact.peak_angle(-1.0), r"tau = -1\.0"),
        (lambda: impact.peak_factor_linearised(0.0), r"tau = 0\.0"),
        (lambda: impact.peak_factor(1.0, start="jump"), "'jump' is not one of 'rest', 'release'"),
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


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("stiffness", [1e7, 3e6, 1e8])
def test_exponents_are_logarithmic_derivatives_of_the_equations_of_motion(start, stiffness):
    """Differences at 50 digits of the peak that the equations of motion have."""
    example = {**EXAMPLE, "stiffness": stiffness}
    tau = clearance.tau(**example)
    if start == "release" and tau < 1.8386:
        assert np.isnan(impact.peak_exponents(tau, start=start)).all()
        return
    found = impact.peak_exponents(tau, start=start)
    step = mp.mpf(10) ** -12
    names = {"slope": "ramp", "play": "half_clearance", "mass": "mass", "stiffness": "stiffness"}
    for name, parameter in names.items():
        peaks = [
            Motion(
                **{**example, parameter: mp.mpf(example[parameter]) * factor}, start=start
            ).peak()
            for factor in (1 + step, 1 - step)
        ]
        expected = (mp.log(peaks[0][1]) - mp.log(peaks[1][1])) / (2 * step)
        assert float(getattr(found, name)) == pytest.approx(float(expected), rel=1e-12, abs=1e-13)
    # The ramp is k_1 times the cube of the speed.
    assert float(found.speed) == pytest.approx(3.0 * float(found.slope), rel=1e-14)


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        ("rest", (1.909, 0.636, 0.364, 0.318, 0.045)),
        ("release", (1.648, 0.549, 0.451, 0.275, 0.176)),
    ],
)
def test_exponents_of_the_example(start, expected):
    found = impact.peak_exponents(clearance.tau(**EXAMPLE), start=start)
    assert tuple(round(float(value), 3) for value in found) == expected


@pytest.mark.parametrize("start", STARTS)
def test_exponents_of_an_impact_alone(start):
    """F = v_1 sqrt(c m) with v_1 = cbrt(18 s^2 k / m)."""
    found = impact.peak_exponents([1e12, 1e80], start=start)
    expected = {"speed": 1.0, "slope": 1 / 3, "play": 2 / 3, "mass": 1 / 6, "stiffness": 0.5}
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-10)


def test_exponents_without_play_are_those_of_the_ramp():
    found = impact.peak_exponents(1e-6)
    assert found.play == pytest.approx(0.0, abs=1e-15)
    assert (found.slope, found.mass, found.stiffness) == pytest.approx((1.0, 0.5, -0.5))
    # Below tau = 1 play lowers the peak; there it neither does nor raises it.
    assert impact.peak_exponents(1.0).play == 0.0
    assert impact.peak_exponents(0.9).play < 0.0
