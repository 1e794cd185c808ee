"""Limits: complete, replaceable, and as the sources print them."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from cardan_dyn.analytic import limits, uniformity
from cardan_dyn.analytic.limits import Limit

RPM = np.pi / 30
EVERY = [
    *limits.LIMITS.values(),
    *limits.CRITICAL_CONSTANTS.values(),
    *limits.POWER_FACTORS.values(),
    *(limit for pair in limits.SERVICE_FACTORS.values() for limit in pair),
]


def test_every_limit_names_unit_source_and_bound():
    assert all(limit.source and limit.unit and limit.value > 0 for limit in EVERY)
    assert {limit.bound for limit in EVERY} == {"most", "least", "constant"}
    units = {"rad", "1", "rad/s", "rad/s^2", "Pa", "m", "m/s", "rad m/s"}
    assert {limit.unit for limit in EVERY} == units


def test_limits_can_be_replaced_but_not_changed():
    limit = limits.LIMITS["torsional_acceleration"]
    own = limit.replaced(350.0, "own measurements")
    assert own == Limit(350.0, "rad/s^2", "own measurements")
    assert limit.value == 300.0
    assert limit.replaced(np.int64(3), "x").value == 3
    with pytest.raises(FrozenInstanceError):
        limit.value = 1.0
    with pytest.raises(TypeError):
        limits.LIMITS["torsional_acceleration"] = own
    with pytest.raises(ValueError, match="source = ' ' of a limit is empty"):
        limit.replaced(1.0, " ")
    for value in (np.nan, np.inf, "3"):
        with pytest.raises(ValueError, match="is not a finite number"):
            limit.replaced(value, "x")


def test_accelerations_behind_the_sizes_of_joints():
    """27 000 and 17 000 degrees/min are 2435 and 965 rad/s^2; M = J_2 epsilon."""
    for size, n_beta, acceleration in (("2015", 27000, 2435), ("2065", 17000, 965)):
        row = limits.JOINT_SIZES[size]
        assert row.size == size
        assert np.degrees(row.n_beta) / RPM == pytest.approx(n_beta, rel=1e-14)
        assert row.n_beta**2 == pytest.approx(acceleration, abs=0.5)
        rule = uniformity.n_beta_acceleration(1.0, n_beta)
        assert rule == pytest.approx(row.n_beta**2, rel=1e-14)


def test_sizes_fall_with_the_size():
    rows = np.array([(row.speed, row.n_beta) for row in limits.JOINT_SIZES.values()])
    assert np.all(np.diff(rows, axis=0) <= 0)
    assert rows[0, 0] / RPM == pytest.approx(6000)
    assert rows[-1, 0] / RPM == pytest.approx(3900)


def test_constants_as_printed():
    constants = limits.CRITICAL_CONSTANTS
    printed = {"steel": 1.2187e8 / 1e3, "elbe": 1.21e8 / 1e3, "ae_7": 4.705e6 * 0.0254}
    for name, value in printed.items():
        assert constants[name].value / RPM == pytest.approx(value, rel=1e-14)


def test_factors_do_not_fall():
    for table in limits.DIN_808_FACTORS.values():
        assert list(table) == sorted(table)
        assert list(table.values()) == sorted(table.values())
    pairs = [pair for load in limits.SERVICE_FACTORS.values() for pair in load]
    assert [limit.value for limit in pairs] == sorted(limit.value for limit in pairs)
