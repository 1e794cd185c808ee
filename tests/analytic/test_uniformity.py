"""Uniformity of lines: inverses, makers' sums and a published table of angles."""

import mpmath as mp
import numpy as np
import pytest
from testkit.cross_geometry import ULP, relative_errors

from cardan_dyn.analytic import drive_line, single_joint, uniformity

RPM = np.pi / 30
QUARTER = np.pi / 2
# Greatest angle of joint 2 in degrees for joint 1 at 0, 1, ... degrees (engineersedge.com).
PRINTED = {
    1500: (7.3, 7.4, 7.6, 7.9, 8.3, 8.9, 9.5, 10.1, 10.8, 11.6),
    1600: (6.9, 6.9, 7.1, 7.5, 7.9, 8.5, 9.1, 9.8, 10.5),
    1700: (6.5, 6.5, 6.8, 7.1, 7.6, 8.2, 8.8),
}


@pytest.mark.parametrize("rpm", PRINTED)
def test_printed_angles_of_the_second_joint(rpm):
    """The table rounds to 0.1 degrees; 400 rad/s^2 is the limit that reproduces all of it."""
    first = np.radians(np.arange(float(len(PRINTED[rpm]))))
    greatest = np.degrees(uniformity.allowed_second_angle(first, 400.0, rpm * RPM).greatest)
    np.testing.assert_allclose(greatest, PRINTED[rpm], atol=0.1)
    for other in (360.0, 440.0):
        wrong = np.degrees(uniformity.allowed_second_angle(first, other, rpm * RPM).greatest)
        assert np.max(np.abs(wrong - PRINTED[rpm])) > 0.2


@pytest.mark.parametrize("rpm", [800.0, 3000.0])
def test_allowed_angles_reach_the_limit(rpm):
    speed, first, limit = rpm * RPM, np.radians([1.0, 6.0, 12.0]), 300.0
    least, greatest = uniformity.allowed_second_angle(first, limit, speed)
    for second in (least, greatest):
        theta = drive_line.residual_angle_approximate(np.stack([first, second], -1), [0, QUARTER])
        reached = uniformity.angular_acceleration(theta, speed, small_angle=True)
        expected = np.where(second > 0, limit, (first * speed) ** 2)
        np.testing.assert_allclose(reached, expected, rtol=1e-11)
    assert np.all(expected <= limit * (1 + 1e-12))
    alone = uniformity.allowed_angle(limit, speed)
    assert (alone * speed) ** 2 == pytest.approx(limit, rel=1e-14)


@pytest.mark.parametrize("degrees", [0.0, 1e-9, 0.1, 3.0, 45.0, 89.9999])
def test_angle_of_non_uniformity(degrees):
    beta = np.radians(degrees)
    U = 1 / mp.cos(mp.mpf(beta)) - mp.cos(mp.mpf(beta))
    value = uniformity.angle_of_non_uniformity(float(U))
    exact = mp.acos((mp.sqrt(mp.mpf(float(U)) ** 2 + 4) - mp.mpf(float(U))) / 2)
    assert relative_errors(value, [exact])[0] <= 8 * ULP
    assert value == pytest.approx(beta, rel=1e-12)


def test_limit_of_the_catalogue():
    """U(3 degrees) = 0.0027428 is printed as 0.0027."""
    assert np.degrees(uniformity.angle_of_non_uniformity(0.0027428)) == pytest.approx(3, abs=1e-4)


def test_added_non_uniformity():
    betas, phases = np.radians([12.0, 10.0, 4.0]), [0.0, QUARTER, 0.0]
    U = single_joint.non_uniformity(betas)
    value = uniformity.added_non_uniformity(betas, phases)
    assert value == pytest.approx(U[0] - U[1] + U[2], rel=1e-13)
    exact = single_joint.non_uniformity(drive_line.residual_angle(betas, phases))
    assert value == pytest.approx(exact, rel=0.02)
    # The error falls with the square of the angles.
    small = betas / 10
    exact = single_joint.non_uniformity(drive_line.residual_angle(small, phases))
    assert uniformity.added_non_uniformity(small, phases) == pytest.approx(exact, rel=2e-4)


def test_shapes_nan_and_bad_arguments():
    values = uniformity.allowed_second_angle([[0.1], [np.nan]], 300.0, np.ones(3))
    assert all(value.shape == (2, 3) for value in values)
    assert np.isnan(values.least).tolist() == [[False] * 3, [True] * 3]
    assert isinstance(uniformity.angle_of_non_uniformity(0.1), float)
    with pytest.raises(ValueError, match=r"non_uniformity = -0\.1"):
        uniformity.angle_of_non_uniformity(-0.1)
    with pytest.raises(ValueError, match=r"acceleration = -1\.0"):
        uniformity.allowed_angle(-1.0, 1.0)
    with pytest.raises(ValueError, match=r"speed = 0\.0"):
        uniformity.allowed_second_angle(0.1, 300.0, 0.0)
    with pytest.raises(ValueError, match=r"betas\[1\] = 1\.6"):
        uniformity.added_non_uniformity([0.1, 1.6], [0.0, 0.0])
