"""Lengths, slopes, balance and losses of installed shafts."""

import numpy as np
import pytest

from cardan_dyn.analytic import grossmann, installation, single_joint
from cardan_dyn.analytic.limits import LIMITS

RPM = np.pi / 30


def test_operating_lengths():
    assert installation.operating_lengths(1.2, 0.09) == pytest.approx((1.2, 1.23, 1.29))


def test_telescope_margins():
    margins = installation.telescope_margins(0.80, 1.30, 0.83, [1.10, 1.20])
    assert margins.travel_left == pytest.approx([0.03, 0.03])
    assert margins.overlap == pytest.approx([0.20, 0.10])
    assert (margins.overlap >= LIMITS["telescope_overlap"].value).tolist() == [True, False]
    assert np.all(margins.travel_left >= LIMITS["telescope_travel_left"].value)


def test_joint_angles_in_one_plane_are_differences_of_slopes():
    slopes = np.radians([3.0, 5.5, -1.0, 3.0])
    angles = installation.joint_angles_from_slopes(slopes)
    np.testing.assert_allclose(angles, np.abs(np.diff(slopes)), rtol=1e-13)


def test_compound_angles_from_slopes():
    """By the law of cosines on the sphere; the makers' root is of second order."""
    slopes, headings = np.radians([2.0, 9.0]), np.radians([0.0, 6.0])
    value = installation.joint_angles_from_slopes(slopes, headings)[0]
    cosine = np.sin(slopes[0]) * np.sin(slopes[1]) + np.cos(slopes[0]) * np.cos(slopes[1]) * np.cos(
        headings[1]
    )
    assert value == pytest.approx(np.arccos(cosine), rel=1e-12)
    maker = np.hypot(np.radians(7.0), np.radians(6.0))
    assert abs(value / maker - 1) < 0.01
    directions = installation.shaft_directions(np.radians(10.0), np.radians([0.0, 90.0 - 1e-9]))
    falling = np.sin(np.radians(10.0))
    np.testing.assert_allclose(directions[:, 2], -falling, rtol=1e-14)
    np.testing.assert_allclose(directions[1, :2], [0.0, np.cos(np.radians(10.0))], atol=1e-10)


def test_unbalance_in_the_units_of_the_standard():
    """U = 9549 G m / n in g mm; G16, 20 kg, 3000/min: 1018.6 g mm."""
    grade = LIMITS["balance_grade_maker"].value
    unbalance = installation.residual_unbalance(grade, 20.0, 3000 * RPM)
    assert 1e6 * unbalance == pytest.approx(9549 * 16 * 20 / 3000, rel=1e-4)


def loss_of_a_turn(beta, friction, radius, arm):
    """Friction work over work of a turn, with exact moment and exact rocking of the pins."""
    phi = np.linspace(0, 2 * np.pi, 20_001)[:-1] + 1e-4
    step = phi[1] - phi[0]
    moment = grossmann.moment_size(beta, phi)
    # The cross is normal to the moment: it rocks about each pin by the swing angle of that shaft.
    swings = grossmann.swing_angles(beta, phi)
    rates = [np.abs(np.gradient(swing, step)) for swing in swings]
    force = moment / (2 * arm)
    rubbed = sum(np.sum(2 * friction * radius * force * rate) * step for rate in rates)
    return rubbed / (2 * np.pi)


@pytest.mark.parametrize(("degrees", "short"), [(1.0, 0.0), (15.0, 0.02), (30.0, 0.08)])
def test_loss_by_integration_over_the_turn(degrees, short):
    beta = np.radians(degrees)
    loss = 1 - installation.joint_efficiency(beta, 0.05, 0.01, 0.04)
    exact = loss_of_a_turn(beta, 0.05, 0.01, 0.04)
    assert exact / loss - 1 == pytest.approx(short, abs=0.01)


def test_efficiency_near_one_hundred_percent():
    """Needle bearings: SAE 150013 measures losses of some per mille."""
    assert 0.999 < installation.joint_efficiency(np.radians(8.0), 0.003, 0.01, 0.04) < 1.0
    assert single_joint.non_uniformity(0.0) == 0.0


def test_greatest_angles_as_printed():
    """Spicer: 3.2 degrees at 5000/min, 5.0 at 3500/min, 11.5 at 1500/min."""
    rpm = np.array([5000.0, 3500.0, 1500.0])
    angles = np.degrees(installation.greatest_joint_angle(rpm * RPM))
    assert angles == pytest.approx([3.2, 5.0, 11.5], rel=1e-12)
    every = installation.greatest_joint_angle(np.linspace(0.0, 8000.0, 400) * RPM)
    assert np.all(np.diff(every) <= 1e-15)
    # Between rows no angle is above both of speed times angle.
    assert np.degrees(installation.greatest_joint_angle(1750 * RPM)) == pytest.approx(
        (1500 * 11.5 + 2000 * 8.7) / 2 / 1750
    )


def test_shapes_nan_and_bad_arguments():
    angles = installation.joint_angles_from_slopes(np.zeros((4, 3)), [0.0, 0.1, np.nan])
    assert angles.shape == (4, 2)
    assert np.isnan(angles).tolist() == [[False, True]] * 4
    lengths = installation.operating_lengths(np.ones((2, 1)), np.zeros(3))
    assert all(value.shape == (2, 3) for value in lengths)
    for call, message in (
        (lambda: installation.operating_lengths(0.0, 1.0), r"compressed = 0\.0"),
        (lambda: installation.telescope_margins(1.0, 1.0, -1.0, 1.0), "shortest"),
        (lambda: installation.shaft_directions(1.6), r"slopes = 1\.6"),
        (lambda: installation.residual_unbalance(0.016, 1.0, 0.0), r"speed = 0\.0"),
        (lambda: installation.joint_efficiency(0.1, -0.1, 1.0, 1.0), r"friction = -0\.1"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
