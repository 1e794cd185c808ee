"""Growth of the peak after an impact, against its equations of motion at 50 digits."""

import mpmath as mp
import numpy as np
import pytest
from testkit.two_mass_impact import EXAMPLE, STARTS, Motion

from cardan_dyn.analytic import clearance
from cardan_dyn.analytic.peak_exponents import peak_exponents


@pytest.mark.slow
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("stiffness", [1e7, 3e6, 1e8])
def test_exponents_are_logarithmic_derivatives_of_the_equations_of_motion(start, stiffness):
    """Differences at 50 digits of the peak that the equations of motion have."""
    example = {**EXAMPLE, "stiffness": stiffness}
    tau = clearance.tau(**example)
    if start == "release" and tau < 1.8386:
        assert np.isnan(peak_exponents(tau, start=start)).all()
        return
    found = peak_exponents(tau, start=start)
    step = mp.mpf(10) ** -12
    names = {
        "slope": "ramp",
        "clearance": "half_clearance",
        "mass": "mass",
        "stiffness": "stiffness",
    }
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
    found = peak_exponents(clearance.tau(**EXAMPLE), start=start)
    assert tuple(round(float(value), 3) for value in found) == expected


@pytest.mark.parametrize("start", STARTS)
def test_exponents_of_an_impact_alone(start):
    """F = v_1 sqrt(c m) with v_1 = cbrt(18 s^2 k / m)."""
    found = peak_exponents([1e12, 1e80], start=start)
    expected = {"speed": 1.0, "slope": 1 / 3, "clearance": 2 / 3, "mass": 1 / 6, "stiffness": 0.5}
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-10)


def test_exponents_without_clearance_are_those_of_the_ramp():
    found = peak_exponents(1e-6)
    assert found.clearance == pytest.approx(0.0, abs=1e-15)
    assert (found.slope, found.mass, found.stiffness) == pytest.approx((1.0, 0.5, -0.5))
    # Below tau = 1 play lowers the peak; there it neither does nor raises it.
    assert peak_exponents(1.0).clearance == 0.0
    assert peak_exponents(0.9).clearance < 0.0
