"""Peak after an impact as a multiple of c s, against its equations of motion at 50 digits."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import ULP, relative_errors
from testkit.two_mass_impact import STARTS, Motion

from cardan_dyn.analytic import peak_factor as pf

modest = settings(max_examples=60, deadline=None, derandomize=True)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("tau", [1e-3, 0.5, 1.9, 1.999, 2.0, 2.001, 3.03, 10.0, 1e3])
def test_dimensionless_peak_is_exact(tau, start):
    # m = c = 1 and s = tau^3 / 12 with a unit ramp give this tau; f = F_max / (c s).
    s = mp.mpf(tau) ** 3 / 12
    motion = Motion(1, 1, s, 1, start)
    found = motion.peak()
    angle, factor = (f(tau, start=start) for f in (pf.peak_angle, pf.peak_factor))
    if found is None:
        assert start == "release"
        assert tau < 1.8386
        assert np.isnan([angle, factor]).all()
        return
    assert relative_errors(angle, [found[0]])[0] <= 8 * ULP
    assert relative_errors(factor, [found[1] / s])[0] <= 8 * ULP


@modest
@given(st.floats(0.05, 50.0))
def test_printed_sine_and_cosine_of_the_peak(tau):
    """(27b) and (27c), which together take the right branch."""
    theta = pf.peak_angle(tau)
    scale = tau**4 + 4
    assert np.cos(theta) == pytest.approx((4 - 2 * tau**2 - 2 * tau**3) / scale, abs=1e-13)
    assert np.sin(theta) == pytest.approx((tau**4 - 2 * tau**2 - 4 * tau) / scale, abs=1e-13)


def test_linearised_form():
    short = 100 * (1 - pf.peak_factor_linearised([2, 3.03, 5]) / pf.peak_factor([2, 3.03, 5]))
    assert short == pytest.approx([8.0, 1.2, 0.1], abs=0.05)


def test_limits():
    for tau, side in ((1e-4, 0), (1e7, 1)):
        ratio = pf.peak_factor(tau) / pf.peak_factor_limits(tau)[side]
        assert ratio == pytest.approx(1.0, abs=1e-4 if side == 0 else 3e-7)
    tau = np.geomspace(0.01, 100, 50)
    assert np.all(pf.peak_factor(tau) > pf.peak_factor_limits(tau)[1])


@pytest.mark.parametrize("start", ["rest", "release"])
@pytest.mark.parametrize(
    "tau", [1e-110, 1e-102, 1e-90, 1e-20, 1e20, 1e60, 1e90, 1e110, 1e200, 1e300]
)
def test_factors_where_powers_of_tau_are_beyond_floats(tau, start):
    x = mp.mpf(tau)
    if start == "rest":
        reference = 6 / x + 12 / x**2 + 24 / x**3 * mp.atan2(x, x - 2)
        linear = mp.pi / 2 + (2 * x**3 + 2 * x**2 - 4) / (x**4 + 4)
        other = pf.peak_factor_linearised(tau)
        assert other == pytest.approx(float(12 / x**2 * (x / 2 + 1 + linear / x)), rel=1e-14)
        assert pf.peak_factor_limits(tau)[0] == pytest.approx(float(24 * mp.pi / x**3))
    elif tau < 1:
        reference = mp.nan
    else:
        reference = 6 / x  # the next term is 1 / tau of it
    value = pf.peak_factor(tau, start=start)
    assert value == pytest.approx(float(reference), rel=1e-14, nan_ok=True)


def test_edge_of_the_release():
    edge = np.cbrt(np.sqrt(2 * np.sqrt(2) - 2) * (4 + 2 * np.sqrt(2)))
    assert edge == pytest.approx(1.8386, abs=5e-5)
    below, above = pf.peak_factor([edge * 0.9999, edge * 1.0001], start="release")
    assert np.isnan(below)
    assert above > 0.0


@pytest.mark.parametrize("start", STARTS)
def test_nan_makes_nan_in_its_own_place(start):
    factor = pf.peak_factor([3.0, np.nan], start=start)
    assert np.isnan(factor).tolist() == [False, True]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pf.peak_factor(0.0), r"tau = 0\.0 .*\(0, inf\)"),
        (lambda: pf.peak_angle(-1.0), r"tau = -1\.0"),
        (lambda: pf.peak_factor_linearised(0.0), r"tau = 0\.0"),
        (lambda: pf.peak_factor(1.0, start="jump"), "'jump' is not one of 'rest', 'release'"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()
