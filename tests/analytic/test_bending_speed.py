"""Critical bending speeds: makers' examples, and beams on springs by finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh

from analytic import bending_speed as bs
from analytic import shaft_design as sd
from analytic.limits import CRITICAL_CONSTANTS, LIMITS

RPM, INCH = np.pi / 30, 0.0254
TUBE = np.array([3.5, 3.26]) * INCH


def test_example_of_pss():
    """3.5 x 0.120 in, 60 in: 6251/min."""
    speed = bs.critical_speed_by_constant(*TUBE, 60 * INCH, CRITICAL_CONSTANTS["ae_7"].value)
    assert round(float(speed / RPM)) == 6251


def test_example_of_calcady():
    """3.5 x 0.083 in, 45 in, E = 30e6 psi, 0.283 lb/in^3: 11390/min, by the beam itself."""
    psi, pound = 4.4482216152605 / INCH**2, 0.45359237
    speed = sd.critical_speed(
        3.5 * INCH, 3.334 * INCH, 45 * INCH, 30e6 * psi, 0.283 * pound / INCH**3
    )
    # It rounds I to 1.302 in^4, the weight to 0.252 lb/in and g to 386.4 in/s^2.
    area, moment = np.pi / 4 * (3.5**2 - 3.334**2), np.pi / 64 * (3.5**4 - 3.334**4)
    rounding = np.sqrt(1.302 / moment * area * 0.283 / 0.252 * 386.4 / 386.0886)
    assert speed * rounding / RPM == pytest.approx(11390, abs=1.0)
    assert rounding == pytest.approx(1.0, abs=1.1e-3)


def test_constants_are_near_the_beam_of_steel():
    beam = sd.critical_speed(0.1, 0.09, 2.0)
    speeds = {
        name: bs.critical_speed_by_constant(0.1, 0.09, 2.0, constant.value) / beam
        for name, constant in CRITICAL_CONSTANTS.items()
    }
    expected = {"steel": 1.0, "elbe": 0.9929, "ae_7": 0.9806, "ims": 1.0004}
    assert speeds == pytest.approx(expected, abs=2e-4)


def test_greatest_length():
    share, constant = LIMITS["bending_speed_share"].value, CRITICAL_CONSTANTS["elbe"].value
    speed = 3000 * RPM
    length = bs.greatest_length(0.09, 0.083, speed, constant, share)
    critical = bs.critical_speed_by_constant(0.09, 0.083, length, constant)
    assert share * critical == pytest.approx(speed, rel=1e-14)
    # In mm and 1/min, as printed.
    printed = np.sqrt(share * 1.21e8 * np.hypot(90, 83) / 3000)
    assert 1e3 * length == pytest.approx(printed, rel=1e-13)


def beam_on_a_spring(softness, elements=12):
    """Greatest-period frequency of a beam with E I = mu = L = 1, by cubic finite elements."""
    h = 1.0 / elements
    corner = 4 * h * h
    bend = [[12, 6 * h, -12, 6 * h], [0, corner, -6 * h, corner / 2], [0, 0, 12, -6 * h]]
    bend = np.array([*bend, [0, 0, 0, corner]]) / h**3
    mass = [[156, 22 * h, 54, -13 * h], [0, corner, 13 * h, -0.75 * corner], [0, 0, 156, -22 * h]]
    mass = np.array([*mass, [0, 0, 0, corner]]) * h / 420
    size = 2 * (elements + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for i in range(elements):
        place = slice(2 * i, 2 * i + 4)
        K[place, place] += np.triu(bend) + np.triu(bend, 1).T
        M[place, place] += np.triu(mass) + np.triu(mass, 1).T
    K[-2, -2] += 1.0 / softness
    return np.sqrt(eigh(K[1:, 1:], M[1:, 1:], eigvals_only=True)[0])


@pytest.mark.parametrize("softness", [1e-4, 0.01, 0.1, 1.0, 30.0, 1e4])
def test_elastic_bearing_is_that_of_finite_elements(softness):
    value = bs.elastic_bearing_factor(softness)
    assert value == pytest.approx(beam_on_a_spring(softness) / np.pi**2, rel=2e-5)


def test_limits_of_the_elastic_bearing():
    assert bs.elastic_bearing_factor(0.0) == pytest.approx(1.0, rel=1e-15)
    # A rigid rod that swings about its other end: omega^2 = 3 k / (mu L).
    assert bs.elastic_bearing_factor(1e8) == pytest.approx(np.sqrt(3e-8) / np.pi**2, rel=1e-7)
    # First order in the softness: sin^2 at the end's share of the force, 1 - pi^2 s.
    assert bs.elastic_bearing_factor(1e-5) == pytest.approx(1 - np.pi**2 * 1e-5, abs=1e-7)
    factors = bs.elastic_bearing_factor(np.geomspace(1e-6, 1e6, 50))
    assert np.all(np.diff(factors) < 0)


def test_tube_on_an_elastic_bearing():
    D, d, L, k, rho = 0.09, 0.083, 1.4, 5e5, 7850.0
    bending = 2.1e11 * np.pi / 64 * (D**4 - d**4)
    line_mass = rho * np.pi / 4 * (D**2 - d**2)
    expected = beam_on_a_spring(bending / (k * L**3)) * np.sqrt(bending / (line_mass * L**4))
    assert bs.on_elastic_bearing(D, d, L, k) == pytest.approx(expected, rel=2e-5)
    assert bs.on_elastic_bearing(D, d, L, 1e15) == pytest.approx(sd.critical_speed(D, d, L))


def test_shapes_nan_and_bad_arguments():
    assert bs.on_elastic_bearing(np.full((3, 1), 0.1), 0.0, 1.0, [1e5, 1e6]).shape == (3, 2)
    assert np.isnan(bs.elastic_bearing_factor([0.1, np.nan])).tolist() == [False, True]
    assert isinstance(bs.elastic_bearing_factor(0.1), float)
    for call, message in (
        (lambda: bs.elastic_bearing_factor(-1.0), r"softness = -1\.0"),
        (lambda: bs.on_elastic_bearing(0.1, 0.0, 1.0, 0.0), r"stiffness = 0\.0"),
        (lambda: bs.greatest_length(0.1, 0.2, 1.0, 1e4), "inner_diameter"),
        (lambda: bs.critical_speed_by_constant(0.1, 0.0, 1.0, -1.0), "constant"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
