"""Ratings for a life, and duty cycles, against the life they are asked for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan_dyn.analytic import shaft_design as jr
from cardan_dyn.analytic import shaft_design as sd

RPM = np.pi / 30
modest = settings(max_examples=60, deadline=None, derandomize=True)
ROWS = st.lists(
    st.tuples(
        st.floats(0.01, 1.0),
        st.floats(1.0, 5000.0),
        st.floats(1.0, 400.0),
        st.floats(0.0, 0.6),
    ),
    min_size=1,
    max_size=6,
)


def test_kleins_case_by_three_ratings():
    """1000 N m, 1450/min, 7 degrees, 2000 h: T_D is not Klein's T = C R of 1339 N m."""
    case = (1000.0, 1450 * RPM, np.radians(7.0), 2000.0)
    rated = jr.required_rated_torque(*case)
    assert rated == pytest.approx(2185, abs=0.5)
    # By hand: (2000 x 1450 x 7 / 1.5e6)^0.3.
    assert rated == pytest.approx(1000 * (2000 * 1450 * 7 / 1.5e6) ** 0.3, rel=1e-13)
    assert abs(rated - 1339) > 800


def test_rating_at_the_makers_reference():
    """AISCO rates at 5000 h, 100/min and 3 degrees."""
    at = (700.0, 100 * RPM, np.radians([0.0, 2.0, 3.0]), 5000.0)
    assert jr.required_rated_torque(*at) == pytest.approx(700.0, rel=1e-13)
    assert jr.mean_life(5000.0) == 25000.0


@modest
@given(st.floats(1, 1e5), st.floats(0.1, 500), st.floats(0, 1), st.floats(1, 1e5), st.floats(1, 3))
def test_inverses(torque, speed, beta, life, shock):
    rated = jr.required_rated_torque(torque, speed, beta, life)
    assert sd.joint_life(speed, beta, torque, rated) == pytest.approx(life, rel=1e-12)
    capacity = jr.required_capacity(torque, speed, beta, life, shock)
    back = sd.joint_life_from_capacity(speed, beta, torque, capacity, shock)
    assert back == pytest.approx(life, rel=1e-12)


@modest
@given(ROWS)
def test_equivalent_duty_has_the_life_of_the_cycle(rows):
    shares, torques, speeds, betas = (np.array(column) for column in zip(*rows, strict=True))
    shares = shares / np.sum(shares)
    duty = jr.equivalent_duty(shares, torques, speeds, betas)
    cycle = sd.duty_cycle_life(shares, sd.joint_life(speeds, betas, torques, 900.0))
    one = sd.joint_life(duty.speed, duty.beta, duty.torque, 900.0)
    assert one == pytest.approx(cycle, rel=1e-12)


def test_idle_and_coast_rows():
    """Life counted in hours of the cycle: hours without damage make it longer."""
    loaded = jr.equivalent_duty([1.0], [1000.0], [150.0], [0.1])
    idle = jr.equivalent_duty([0.5, 0.3, 0.2], [1000.0, 0.0, 900.0], [150.0, 80.0, 0.0], 0.1)
    assert sd.joint_life(idle.speed, idle.beta, idle.torque, 900.0) == pytest.approx(
        2 * sd.joint_life(loaded.speed, loaded.beta, loaded.torque, 900.0), rel=1e-13
    )
    coast = jr.equivalent_duty([0.5, 0.5], [1000.0, -400.0], 150.0, 0.1)
    driven = jr.equivalent_duty([0.5, 0.5], [1000.0, 400.0], 150.0, 0.1)
    assert coast == driven
    assert jr.equivalent_duty([1.0], [0.0], [10.0], [0.1]).torque == 0.0


def test_steady_duty_is_itself():
    duty = jr.equivalent_duty([0.25, 0.75], 1e200, 40.0, np.radians(4.0))
    assert duty == pytest.approx((1e200, 40.0, np.radians(4.0)), rel=1e-14)


def test_shapes_and_nan():
    shares = np.array([0.5, 0.5])
    duty = jr.equivalent_duty(shares, [[1.0, 2.0], [np.nan, 1.0]], 3.0, 0.1)
    assert all(value.shape == (2,) for value in duty)
    assert np.isnan(duty.torque).tolist() == [False, True]
    assert jr.required_capacity(np.ones((3, 1)), 1.0, 0.1, np.ones(2)).shape == (3, 2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: jr.required_rated_torque(0.0, 1.0, 0.1, 1.0), r"torque = 0\.0"),
        (lambda: jr.required_rated_torque(1.0, 1.0, 1.6, 1.0), r"beta = 1\.6"),
        (lambda: jr.required_capacity(1.0, 1.0, 0.1, 1.0, 0.0), "shock_factor"),
        (lambda: jr.mean_life(-1.0), r"life = -1\.0"),
        (lambda: jr.equivalent_duty([0.5, 0.4], 1.0, 1.0, 0.1), r"sum of shares = 0\.9"),
        (lambda: jr.equivalent_duty([1.0], 1.0, 0.0, 0.1), r"mean of speeds = 0\.0"),
        (lambda: jr.equivalent_duty([1.0], 1.0, -1.0, 0.1), r"speeds = -1\.0"),
        (lambda: jr.equivalent_duty([0.5, 0.5], np.ones(3), 1.0, 0.1), r"torques \(3,\)"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()
