"""Design torques and static ratings, in the units in which they are published."""

import numpy as np
import pytest

from cardan_dyn.analytic import design_torque as dt
from cardan_dyn.analytic.limits import POWER_FACTORS, SERVICE_FACTORS

RPM = np.pi / 30
POUND, INCH, POUND_FOOT = 4.4482216152605, 0.0254, 1.3558179483314
HORSEPOWER = 745.6998715822702
RATINGS = dt.StaticRatings(4000.0, 6000.0, 5000.0, 3500.0, 300.0)


@pytest.mark.parametrize(("kilowatts", "rpm", "printed"), [(0.65, 230, 27), (5.5, 2300, 23)])
def test_examples_of_jw_winco(kilowatts, rpm, printed):
    """9550 N / n in N m; the examples of DIN 808 with plain and with needle bearings."""
    torque = dt.power_torque(1e3 * kilowatts, rpm * RPM)
    assert torque == pytest.approx(9550 * kilowatts / rpm, rel=1e-4)
    assert round(float(torque)) == printed


def test_power_in_the_units_of_aisco():
    torque = dt.power_torque(40 * HORSEPOWER, 900 * RPM, 1.5)
    assert torque / (POUND * INCH) == pytest.approx(40 * 63025 / 900 * 1.5, rel=1e-5)


def test_wheel_slip_in_the_units_of_spicer():
    W, RR, AR = 38000.0, 20.0, 3.7
    torque = dt.wheel_slip_torque(W * POUND, RR * INCH, AR)
    assert torque / POUND_FOOT == pytest.approx(0.71 * W * RR / (11.4 * AR), rel=1e-12)


def test_wheel_slip_by_power():
    """At the limit of adhesion, the drive shaft's power less the axle's loss drives the wheels."""
    load, radius, ratio, speed = 9e4, 0.5, 4.0, 20.0
    torque = dt.wheel_slip_torque(load, radius, ratio, 0.8, 0.9)
    wheels = 0.8 * load * (speed / ratio * radius)
    assert torque * speed * 0.9 == pytest.approx(wheels, rel=1e-14)


def test_lesser_torque_of_a_vehicle():
    low = dt.low_gear_torque(1800.0, 10.0, 0.8, 1.9, 1.25, 0.95)
    assert low == pytest.approx(1800 * 10 * 0.8 * 1.9 * 1.25 * 0.95, rel=1e-14)
    slip = dt.wheel_slip_torque([5e4, 9e5], 0.5, 4.0)
    assert dt.vehicle_torque(low, slip) == pytest.approx([slip[0], low])


def test_selection_torque_is_none_of_the_other_ratings():
    factors = [POWER_FACTORS[name].value for name in ("electric", "petrol", "diesel")]
    assert dt.selection_torque(-800.0, 1.1, 1.2, factors) == pytest.approx([1056.0, 1267.2, 1320.0])


def test_static_utilisation():
    low, high = (limit.value for limit in SERVICE_FACTORS["light shock"])
    used = dt.static_utilisation(-2000.0, [low, high], 150.0, RATINGS)
    assert used.elastic == pytest.approx([0.5, 0.5])
    assert used.functional == pytest.approx([0.5, 2 / 3])
    assert used.pulsating == pytest.approx([0.6, 0.8])
    assert used.reversing == pytest.approx([6 / 7, 8 / 7])
    assert used.speed == pytest.approx([0.5, 0.5])
    assert dt.static_utilisation(1e4, 3.0, 1.0, RATINGS._replace(functional=np.inf))[1] == 0.0


def test_shapes_and_nan():
    used = dt.static_utilisation([[1.0], [np.nan]], 2.0, np.ones(3), RATINGS)
    assert all(value.shape == (2, 3) for value in used)
    assert np.isnan(used.pulsating).tolist() == [[False] * 3, [True] * 3]
    assert np.isnan(dt.vehicle_torque([1.0, np.nan], 2.0)).tolist() == [False, True]
    assert isinstance(dt.power_torque(1, 2), float)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: dt.power_torque(-1.0, 1.0), r"power = -1\.0"),
        (lambda: dt.power_torque(1.0, 0.0), r"speed = 0\.0"),
        (lambda: dt.power_torque(np.ones(2), 1.0, np.ones(3)), r"power \(2,\)"),
        (lambda: dt.low_gear_torque(1.0, 2.0, 1.1), r"efficiency = 1\.1 .*\(0, 1\]"),
        (lambda: dt.low_gear_torque(1.0, 2.0, 0.9, transfer_efficiency=0.0), "transfer_eff"),
        (lambda: dt.wheel_slip_torque(1.0, 1.0, 1.0, 0.0), "adhesion"),
        (lambda: dt.vehicle_torque(-1.0, 1.0), r"low_gear = -1\.0"),
        (lambda: dt.selection_torque(1.0, 0.0, 1.0, 1.0), "life_factor"),
        (lambda: dt.static_utilisation(1, 1, 1, RATINGS._replace(elastic=0.0)), r"elastic = 0\.0"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()
