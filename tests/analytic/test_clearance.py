"""Crossing the play: relations between the numbers of the model."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import ULP, relative_errors

from cardan_dyn.analytic import clearance

modest = settings(max_examples=60, deadline=None, derandomize=True)
SIZES = st.floats(1e-3, 1e3)


@modest
@given(SIZES, SIZES, SIZES, SIZES)
def test_forms_of_15_to_23_are_exact(m, c, s, r):
    mass, stiffness, half, ramp = (mp.mpf(x) for x in (m, c, s, r))
    t_1 = mp.findroot(
        lambda t: ramp * t**3 / (6 * mass) - 2 * half, float((12 * m * s / r) ** (1 / 3))
    )
    v_1 = ramp * t_1**2 / (2 * mass)
    omega = mp.sqrt(stiffness / mass)
    assert relative_errors(clearance.contact_time(m, s, r), [t_1])[0] <= 8 * ULP
    assert relative_errors(clearance.impact_speed(m, s, r), [v_1])[0] <= 8 * ULP
    assert relative_errors(clearance.natural_frequency(m, c), [omega])[0] <= 8 * ULP
    assert relative_errors(clearance.tau(m, c, s, r), [omega * t_1])[0] <= 8 * ULP


@modest
@given(SIZES, SIZES, SIZES, SIZES, SIZES)
def test_31(m, c, s, k_1, speed):
    value = clearance.tau_from_speed(m, c, s, k_1, speed)
    printed = (144 * c**3 * s**2 / (k_1**2 * m * speed**6)) ** (1 / 6)
    assert value == pytest.approx(printed, rel=1e-13)
    ramp = clearance.force_ramp(k_1, speed)
    assert ramp == pytest.approx(k_1 * speed**3, rel=1e-14)


def test_exponents():
    """Speed counts most, mass least."""
    base = np.array([2.0, 1e6, 1e-4, 3.0, 40.0])
    for place, exponent in enumerate((-1 / 6, 1 / 2, 1 / 3, -1 / 3, -1.0)):
        doubled = base.copy()
        doubled[place] *= 2
        ratio = clearance.tau_from_speed(*doubled) / clearance.tau_from_speed(*base)
        assert ratio == pytest.approx(2**exponent, rel=1e-13)


def test_speed_is_six_s_over_time():
    speed = clearance.impact_speed(3.6, 0.5e-4, 360e3)
    assert speed == pytest.approx(6 * 0.5e-4 / clearance.contact_time(3.6, 0.5e-4, 360e3))


def test_reduced_mass():
    assert clearance.reduced_mass(1e300, 1e300) == pytest.approx(5e299)
    assert clearance.reduced_mass(2.0, 1e12) == pytest.approx(2.0, rel=1e-11)


def test_shapes_nan_and_bad_arguments():
    assert clearance.tau(np.ones((2, 1)), 1.0, np.ones(3), 1.0).shape == (2, 3)
    assert np.isnan(clearance.tau([1.0, np.nan], 1.0, 1.0, 1.0)).tolist() == [False, True]
    assert isinstance(clearance.tau(1, 1, 1, 1), float)
    assert clearance.contact_time(1.0, 0.0, 1.0) == 0.0
    for call, message in (
        (lambda: clearance.reduced_mass(0.0, 1.0), r"m_11 = 0\.0 .*\(0, inf\)"),
        (lambda: clearance.reduced_mass(1.0, -2.0), r"m_22 = -2\.0"),
        (lambda: clearance.contact_time(1.0, -1e-6, 1.0), r"half_clearance = -1e-06 .*\[0, inf\)"),
        (lambda: clearance.impact_speed(0.0, 1.0, 1.0), r"mass = 0\.0"),
        (lambda: clearance.tau(1.0, 0.0, 1.0, 1.0), r"stiffness = 0\.0"),
        (lambda: clearance.force_ramp(1.0, 0.0), r"speed = 0\.0"),
        (lambda: clearance.tau(np.ones(2), 1.0, np.ones(3), 1.0), r"half_clearance \(3,\)"),
        (lambda: clearance.tau("a", 1.0, 1.0, 1.0), "mass = 'a' must be real"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
