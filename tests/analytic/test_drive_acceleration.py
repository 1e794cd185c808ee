"""Accelerations by which drive lines are judged."""

import numpy as np
import pytest

from cardan_dyn.analytic import drive_line, single_joint
from cardan_dyn.analytic import uniformity as da
from cardan_dyn.analytic.limits import JOINT_SIZES

QUARTER = np.pi / 2


def test_three_joints_with_signs():
    betas = np.radians([4.0, 6.0, 5.0])
    squares = betas**2
    signs = np.array([1, -1, 1])
    phases = np.where(signs > 0, 0.0, QUARTER)
    torsional, drive, coast = (
        function(betas, phases)
        for function in (
            drive_line.residual_angle_approximate,
            da.inertia_drive_angle,
            da.inertia_coast_angle,
        )
    )
    assert torsional == pytest.approx(np.sqrt(abs(signs @ squares)), rel=1e-14)
    assert drive == pytest.approx(np.sqrt(abs(2 * squares[0] - squares[1])), rel=1e-13)
    assert coast == pytest.approx(np.sqrt(abs(2 * squares[2] - squares[1])), rel=1e-13)


def test_drive_and_coast_are_mirror_images():
    betas, phases = np.radians([3.0, 7.0, 2.0, 5.0]), np.array([0.0, 1.0, QUARTER, 0.3])
    mirrored = da.inertia_coast_angle(betas[::-1], phases[::-1])
    assert da.inertia_drive_angle(betas, phases) == pytest.approx(mirrored, rel=1e-14)


def test_double_shaft():
    betas, phases = np.radians([4.0, 4.0]), [0.0, QUARTER]
    assert drive_line.residual_angle_approximate(betas, phases) == 0.0
    assert da.inertia_drive_angle(betas, phases) == pytest.approx(betas[0], rel=1e-15)
    assert da.inertia_coast_angle(betas, phases) == pytest.approx(betas[1], rel=1e-15)
    assert da.inertia_drive_angle([0.3], [0.0]) == 0.0


@pytest.mark.parametrize(("degrees", "short"), [(10.0, (1.5, 0.5)), (20.0, (6.4, 2.5))])
def test_both_forms_fall_short(degrees, short):
    theta, speed = np.radians(degrees), 150.0
    exact = speed**2 * single_joint.greatest_acceleration(theta)
    forms = [da.angular_acceleration(theta, speed, small_angle=small) for small in (False, True)]
    assert [100 * (1 - form / exact) for form in forms] == pytest.approx(short, abs=0.05)


def test_error_of_the_drive_acceleration_falls_with_the_square():
    """Both first-order forms against the accelerations of the joint-by-joint line."""
    phi = np.linspace(0, np.pi, 2001)
    errors = []
    for scale in (1.0, 0.5):
        betas, phases = scale * np.radians([9.0, 5.0, 7.0]), np.array([0.0, QUARTER, 0.4])
        # Inertia in drive: the sum of the accelerations of the shafts after joints 1 and 2.
        shafts = [drive_line.acceleration_ratio(betas[:k], phases[:k], phi) for k in (1, 2)]
        exact = np.max(np.abs(sum(shafts)))
        errors.append(abs(da.inertia_drive_angle(betas, phases) ** 2 / exact - 1))
    assert errors[0] < 0.05
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_n_beta_rule():
    assert da.n_beta_acceleration(1.0, 1.0) == pytest.approx(3.3405e-6, rel=1.5e-5)
    expected = da.angular_acceleration(np.radians(6.0), 1500 * np.pi / 30, small_angle=True)
    assert da.n_beta_acceleration(1500.0, 6.0) == pytest.approx(expected, rel=1e-14)


def test_example_of_pss():
    """5, 4, 3 and 2 degrees, the first shaft crossed, 2500/min: angles and rad/s^2 as printed."""
    betas, phases = np.radians([5.0, 4.0, 3.0, 2.0]), np.array([0.0, 0.0, QUARTER, 0.0])
    speed = 2500 * np.pi / 30
    printed = {
        da.inertia_drive_angle: (9.90, 2026),
        da.inertia_coast_angle: (3.16, 209),
        drive_line.residual_angle_approximate: (6.00, 749),
    }
    for function, (degrees, acceleration) in printed.items():
        theta = function(betas, phases)
        assert np.degrees(theta) == pytest.approx(degrees, abs=0.005)
        assert da.angular_acceleration(theta, speed) == pytest.approx(acceleration, abs=0.5)


def test_greatest_speed_of_a_size():
    """Dana's joint 2040: 5000/min, and 20 000 degrees/min from 4 degrees on."""
    size, rpm = JOINT_SIZES["2040"], np.pi / 30
    speeds = da.greatest_speed(np.radians([0.0, 3.9, 4.0, 10.0]), size.speed, size.n_beta) / rpm
    assert speeds == pytest.approx([5000.0, 5000.0, 5000.0, 2000.0], rel=1e-13)


def test_moment_of_the_middle_part():
    """M = J_2 epsilon_2 against the greatest acceleration of the joint, to first order."""
    beta, speed, inertia = np.radians(4.0), 200.0, 0.05
    exact = inertia * speed**2 * single_joint.greatest_acceleration(beta)
    moment = da.mass_acceleration_moment(inertia, beta, speed)
    assert moment == pytest.approx(exact, rel=2e-3)
    assert moment == pytest.approx(
        inertia * da.n_beta_acceleration(speed * 30 / np.pi, 4.0), rel=1e-13
    )


def test_shapes_nan_and_bad_arguments():
    betas = np.radians([[3.0, 4.0], [np.nan, 4.0]])
    for function in (drive_line.residual_angle_approximate, da.inertia_drive_angle):
        assert np.isnan(function(betas, [0.0, QUARTER])).tolist() == [False, True]
    assert da.angular_acceleration(np.ones((3, 1)), np.ones(2)).shape == (3, 2)
    assert isinstance(da.n_beta_acceleration(1000, 3), float)
    assert da.greatest_speed(np.full((3, 1), 0.1), [1.0, np.nan], 1.0).shape == (3, 2)
    assert np.isnan(da.mass_acceleration_moment([1.0, np.nan], 0.1, 1.0)).tolist() == [False, True]
    with pytest.raises(ValueError, match=r"n_beta = 0\.0"):
        da.greatest_speed(0.1, 1.0, 0.0)
    with pytest.raises(ValueError, match=r"inertia = -1\.0"):
        da.mass_acceleration_moment(-1.0, 0.1, 1.0)
    with pytest.raises(ValueError, match=r"theta = -0\.1"):
        da.angular_acceleration(-0.1, 1.0)
    with pytest.raises(ValueError, match=r"beta_deg = -1\.0"):
        da.n_beta_acceleration(100.0, -1.0)
    with pytest.raises(ValueError, match=r"betas = -0\.1|betas\[0\] = -0\.1"):
        da.inertia_coast_angle([-0.1, 0.2], [0.0, 0.0])
