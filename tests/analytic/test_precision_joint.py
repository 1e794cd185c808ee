"""Precision joints against the examples of a maker."""

import numpy as np
import pytest

from cardan_dyn.analytic import shaft_design as pj
from cardan_dyn.analytic.limits import DIN_808_FACTORS, LIMITS

PLAIN, NEEDLE = DIN_808_FACTORS["plain"], DIN_808_FACTORS["needle"]


def test_example_of_jw_winco_with_plain_bearings():
    """27 N m at 30 degrees: 61 N m by the chart's 2.25; the table's 2.2 gives 2 % less."""
    assert pj.precision_joint_torque(27.0, np.radians(30.0), {30.0: 2.25}) == pytest.approx(
        61, abs=0.5
    )
    assert pj.precision_joint_torque(-27.0, np.radians(30.0), PLAIN) == pytest.approx(59.4)
    assert pj.precision_joint_torque(27.0, np.radians(10.0), PLAIN) == pytest.approx(27.0)


def test_chart_and_table_of_needle_bearings_disagree():
    """JW Winco reads 1.43 at 18 degrees, 23 N m become 33 N m; the table has 1.19."""
    assert pj.precision_joint_torque(23.0, np.radians(18.0), {18.0: 1.43}) == pytest.approx(
        33, abs=0.5
    )
    factor = pj.precision_joint_factor(np.radians(18.0), NEEDLE)
    assert factor == pytest.approx(1.1 + 0.6 * 0.15, rel=1e-12)
    assert 1.43 / factor == pytest.approx(1.2, abs=0.01)


def test_angles_of_the_table():
    for table in (PLAIN, NEEDLE):
        angles = np.radians(list(table))
        np.testing.assert_allclose(
            pj.precision_joint_factor(angles, table), list(table.values()), rtol=1e-13
        )
        assert pj.precision_joint_factor([0.0, 0.1], table).tolist() == [1.0, 1.0]


def test_double_joints_bear_less():
    share = LIMITS["din_808_double_share"].value
    assert pj.precision_joint_torque(9.0, 0.0, PLAIN, share) == pytest.approx(10.0)


def test_shapes_nan_and_bad_arguments():
    assert pj.precision_joint_torque(np.ones((3, 1)), [0.1, np.nan], PLAIN).shape == (3, 2)
    assert np.isnan(pj.precision_joint_factor([0.1, np.nan], PLAIN)).tolist() == [False, True]
    assert isinstance(pj.precision_joint_factor(0.1, PLAIN), float)
    with pytest.raises(ValueError, match=r"beta = 0\.8.* \[0, 45\] deg"):
        pj.precision_joint_factor(0.8, PLAIN)
    with pytest.raises(ValueError, match="is empty"):
        pj.precision_joint_factor(0.1, {})
    with pytest.raises(ValueError, match=r"share = 0\.0"):
        pj.precision_joint_torque(1.0, 0.1, PLAIN, 0.0)
