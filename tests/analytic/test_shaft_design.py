"""Critical speed, life and spline force of a cardan shaft."""

import mpmath as mp
import numpy as np
import pytest
from testkit.cross_geometry import ULP, relative_errors

from cardan_dyn.analytic import shaft_design as sd

RPM = np.pi / 30


def test_critical_speed_is_that_of_the_beam():
    """Rayleigh's quotient of the half sine, exact for a simply supported beam."""
    D, d, L, E, rho = (mp.mpf(x) for x in (0.12, 0.11, 1.7, 2.1e11, 7850.0))
    bending = E * mp.pi / 64 * (D**4 - d**4)
    line_mass = rho * mp.pi / 4 * (D**2 - d**2)
    stiff = mp.quad(lambda x: bending * mp.diff(lambda y: mp.sin(mp.pi * y / L), x, 2) ** 2, [0, L])
    heavy = mp.quad(lambda x: line_mass * mp.sin(mp.pi * x / L) ** 2, [0, L])
    value = sd.critical_speed(0.12, 0.11, 1.7)
    assert relative_errors(value, [mp.sqrt(stiff / heavy)])[0] <= 8 * ULP


def test_critical_speed_in_the_units_of_catalogues():
    speed = sd.critical_speed(0.1, 0.09, 2.0) / RPM
    coefficient = speed * 2000**2 / np.hypot(100, 90)
    assert coefficient == pytest.approx(1.2187e8, rel=3e-5)
    # Elbe prints 1.21e8 and AE-7 4.705e6 for inches.
    assert 100 * (1 - 1.21e8 / coefficient) == pytest.approx(0.7, abs=0.05)
    assert 100 * (1 - 4.705e6 * 25.4 / coefficient) == pytest.approx(1.9, abs=0.05)


def test_permissible_speeds():
    ratio = np.array([0.0, 0.41, 0.43, 0.5, 0.57, 0.59, 0.74, 0.76, 2.0, np.nan])
    expected = [True, True, False, False, False, True, True, False, False, False]
    assert sd.speed_is_permissible(ratio * 80.0, 80.0).tolist() == expected


def test_permissible_speeds_by_other_limits():
    ratio = np.array([0.46, 0.55, 0.64, 0.66, 0.75])
    industrial = sd.speed_is_permissible(ratio * 80.0, 80.0, 0.65, (0.45, 0.5))
    assert industrial.tolist() == [False, True, True, False, False]
    assert sd.speed_is_permissible(ratio, 1.0, [[0.5], [0.8]]).shape == (2, 5)


def test_joint_life():
    at = {"speed": 300 * RPM, "beta": np.radians(5.0)}
    assert sd.joint_life(**at, torque=800.0, rated_torque=800.0) == pytest.approx(1000.0)
    half = sd.joint_life(**at, torque=400.0, rated_torque=800.0)
    assert half == pytest.approx(1000.0 * 2 ** (10 / 3), rel=1e-14)
    small = sd.joint_life(300 * RPM, np.radians([0.0, 1.0, 3.0]), 800.0, 800.0)
    assert small == pytest.approx(1.5e6 / 900)


def test_joint_life_from_capacity():
    life = sd.joint_life_from_capacity(500 * RPM, np.radians(6.0), 2500.0, 1.8e-3, 1.5)
    assert life == pytest.approx(1.8e-3 * 1e10 / (500 * 6 * 2.5 ** (10 / 3) * 1.5), rel=1e-14)


def test_duty_cycle():
    assert sd.duty_cycle_life([0.25, 0.75], [1000.0, 3000.0]) == pytest.approx(2000.0)
    assert sd.duty_cycle_life(1.0, 700.0) == pytest.approx(700.0)
    assert sd.duty_cycle_life([0.5, 0.5], [1000.0, np.inf]) == pytest.approx(2000.0)
    assert sd.duty_cycle_life([0.5, 0.5], [np.inf, np.inf]) == np.inf
    table = sd.duty_cycle_life([[1.0, 0.0], [0.5, 0.5]], [10.0, 30.0])
    assert table == pytest.approx([10.0, 15.0])


def test_slip_force():
    assert sd.slip_force(1000.0, np.radians(60.0), 0.05) == pytest.approx(1100.0)
    assert sd.slip_force(-1000.0, 0.0, 0.05, 0.08) == pytest.approx(1600.0)


def test_shapes_and_nan():
    assert sd.critical_speed(np.full((3, 1), 0.1), 0.0, np.ones(2)).shape == (3, 2)
    assert np.isnan(sd.critical_speed([0.1, np.nan], 0.05, 1.0)).tolist() == [False, True]
    assert np.isnan(sd.joint_life([1.0, np.nan], 0.1, 1.0, 1.0)).tolist() == [False, True]
    assert isinstance(sd.slip_force(1, 0, 1), float)
    assert isinstance(sd.critical_speed(0.1, 0.05, 1.0), float)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sd.critical_speed(0.1, 0.1, 1.0), r"inner_diameter = 0\.1 .*outer_diameter"),
        (lambda: sd.critical_speed(0.1, [0.0, 0.2], 1.0), r"inner_diameter\[1\] = 0\.2"),
        (lambda: sd.critical_speed(0.1, 0.0, 0.0), r"length = 0\.0 .*\(0, inf\)"),
        (lambda: sd.critical_speed(0.1, 0.0, 1.0, density=-1.0), "density"),
        (lambda: sd.speed_is_permissible(-1.0, 10.0), r"speed = -1\.0"),
        (lambda: sd.joint_life(1.0, 1.6, 1.0, 1.0), r"beta = 1\.6"),
        (lambda: sd.joint_life(1.0, 0.1, 0.0, 1.0), r"torque = 0\.0"),
        (lambda: sd.joint_life(np.ones(2), 0.1, np.ones(3), 1.0), r"speed \(2,\).*torque \(3,\)"),
        (lambda: sd.joint_life_from_capacity(1.0, 0.1, 1.0, -1.0), "capacity"),
        (lambda: sd.duty_cycle_life([0.5, 0.6], [1.0, 1.0]), r"sum of shares = 1\.1"),
        (lambda: sd.duty_cycle_life([-0.5, 1.5], [1.0, 1.0]), r"shares\[0\] = -0\.5"),
        (lambda: sd.duty_cycle_life([0.5, 0.5], [1.0, 0.0]), r"lives\[1\] = 0\.0"),
        (lambda: sd.slip_force(1.0, 0.1, 0.1, -0.1), "friction"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()
