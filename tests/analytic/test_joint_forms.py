"""The ring by the equations of its section forces, Taylor's joint by its two pairs of teeth."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import ULP, Cross, relative_errors

from cardan_dyn.analytic import grossmann, joint_forms, single_joint

modest = settings(max_examples=60, deadline=None, derandomize=True)
BETAS = st.floats(0.0, np.radians(85.0))


def test_ring_inertia():
    """Sums over many mass points on a circle."""
    angle = np.arange(360) * np.pi / 180
    points = 0.2 * np.array([np.cos(angle), np.sin(angle)])
    normal, diameter = joint_forms.ring_inertia(3.0, 0.2)
    assert normal == pytest.approx(3.0 / 360 * np.sum(points**2))
    assert diameter == pytest.approx(3.0 / 360 * np.sum(points[0] ** 2))


def ring_solution(moment, radius):
    """Bending of an elastic ring under four tangential pin forces, by least work.

    The ring is cut once; its three section forces there make the deformation energy least, the
    energy of bending alone, as for a thin ring.
    """
    force = joint_forms.ring_pin_force(moment, radius)
    angle = (np.arange(14400) + 0.5) * (2 * np.pi / 14400)
    place = radius * np.array([np.cos(angle), np.sin(angle)])
    bending = np.zeros_like(angle)
    for k, sense in enumerate((1.0, -1.0, 1.0, -1.0)):
        pin = k * np.pi / 2 + 1e-12
        tangent = sense * force * np.array([-np.sin(pin), np.cos(pin)])
        arm = place - radius * np.array([[np.cos(pin)], [np.sin(pin)]])
        bending += np.where(angle > pin, arm[0] * tangent[1] - arm[1] * tangent[0], 0.0)
    unknown = np.array([np.ones_like(angle), place[0] - radius, place[1]]).T
    redundant, *_ = np.linalg.lstsq(unknown, -bending, rcond=None)
    return angle, bending + unknown @ redundant


def test_ring_bending_is_that_of_least_work():
    angle, bending = ring_solution(50.0, 0.3)
    np.testing.assert_allclose(np.abs(bending), joint_forms.ring_bending(50.0, angle), atol=5e-3)


def test_greatest_bending_of_the_ring():
    angle = np.linspace(0, 2 * np.pi, 721)
    bending = joint_forms.ring_bending(10.0, angle)
    assert np.max(bending) == pytest.approx(joint_forms.ring_greatest_bending(10.0), rel=4 * ULP)
    assert joint_forms.ring_greatest_bending(1.0) == pytest.approx(0.1036, abs=5e-5)
    assert np.max(bending[::180]) < 1e-14


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, np.pi / 4, 1.5, np.pi / 2, 2.0, 1e6])
def test_ring_bending_is_exact(angle):
    x = mp.mpf(angle)
    reference = (abs(mp.sin(x)) + abs(mp.cos(x)) - 1) / 4
    assert relative_errors(joint_forms.ring_bending(1.0, angle), [reference])[0] <= 8 * ULP


def test_ring_force_and_moment():
    moment = grossmann.moment_size(0.8, 0.5, 100.0)
    force = joint_forms.ring_pin_force(moment, 0.05)
    assert 2 * 0.05 * force == pytest.approx(100.0 / np.cos(grossmann.swing_angles(0.8, 0.5)[0]))


@pytest.mark.parametrize(
    ("degrees", "play"), [(5.0, 0.218), (10.0, 0.877), (20.0, 3.562), (30.0, 8.213)]
)
def test_greatest_play(degrees, play):
    beta, theta = np.radians(degrees), np.linspace(0, np.pi, 3601)
    assert np.degrees(joint_forms.taylor_greatest_play(beta)) == pytest.approx(play, abs=5e-4)
    swept = np.max(joint_forms.taylor_play(beta, theta))
    assert swept == pytest.approx(joint_forms.taylor_greatest_play(beta), rel=1e-12)


@pytest.mark.parametrize("degrees", [1e-9, 5.0, 60.0, 89.999])
@pytest.mark.parametrize("theta", [0.0, 1e-9, 0.7, np.pi / 2, 2.0, np.pi, 2e6])
def test_both_pairs_of_teeth_by_geometry(degrees, theta):
    beta = np.radians(degrees)
    # One pair is the input pin; the other one stands a quarter turn further.
    in_plane = Cross(beta, theta).phi_2
    across = Cross(beta, mp.mpf(theta) + mp.pi / 2).phi_2 - mp.pi / 2
    values = joint_forms.taylor_sleeve_angles(beta, theta)
    for value, reference in zip(values, (across, in_plane), strict=True):
        assert relative_errors(value, [reference])[0] <= 8 * ULP
    play = joint_forms.taylor_play(beta, theta)
    assert relative_errors(play, [abs(in_plane - across)])[0] <= 8 * ULP
    driven = joint_forms.taylor_driven_angle(beta, theta)
    assert relative_errors(driven, [max(in_plane, across)])[0] <= 8 * ULP


def test_driven_sleeve():
    beta = np.radians(30.0)
    theta = np.linspace(0, 2 * np.pi, 2881)
    lead = joint_forms.taylor_driven_angle(beta, theta) - theta
    assert np.min(lead) > -1e-14
    assert np.max(lead) == pytest.approx(single_joint.greatest_lead(beta), rel=1e-5)
    peaks = (lead[1:-1] > lead[:-2]) & (lead[1:-1] > lead[2:])
    assert np.count_nonzero(peaks) == 4


@modest
@given(BETAS, st.floats(0.01, np.pi / 2 - 0.01), st.integers(-20, 20))
def test_speed_ratio_is_the_slope_of_the_driven_angle(beta, within, quarter):
    theta, step = within + quarter * np.pi / 2, 1e-6
    after, before = (joint_forms.taylor_driven_angle(beta, theta + s) for s in (step, -step))
    ratio = joint_forms.taylor_speed_ratio(beta, theta)
    steepness = 1 / np.cos(beta) ** 3
    assert (after - before) / (2 * step) == pytest.approx(ratio, abs=2e-8 + 1e-9 * steepness**2)


def test_speed_ratio_jumps():
    beta = np.radians(30.0)
    before, after = joint_forms.taylor_speed_ratio(beta, [-1e-12, 0.0])
    assert before == pytest.approx(np.cos(beta), rel=1e-11)
    assert after == pytest.approx(1 / np.cos(beta), rel=1e-11)
    assert after - before == pytest.approx(single_joint.non_uniformity(beta), rel=1e-11)


def test_shapes_nan_and_bad_arguments():
    beta, theta = np.array([[0.1], [np.nan]]), np.array([0.3, np.nan, 2.0])
    missing = [[False, True, False], [True, True, True]]
    for name in ("taylor_play", "taylor_driven_angle", "taylor_speed_ratio"):
        function = getattr(joint_forms, name)
        assert np.isnan(function(beta, theta)).tolist() == missing
        assert isinstance(function(0.1, 0.2), float)
        with pytest.raises(ValueError, match=r"beta = -0\.1"):
            function(-0.1, 0.2)
    assert isinstance(joint_forms.ring_bending(1.0, 0.2), float)
    with pytest.raises(ValueError, match=r"radius = 0\.0"):
        joint_forms.ring_pin_force(1.0, 0.0)
    with pytest.raises(ValueError, match=r"mass = 0\.0"):
        joint_forms.ring_inertia(0.0, 1.0)
    with pytest.raises(ValueError, match=r"moment = -1\.0"):
        joint_forms.ring_greatest_bending(-1.0)
    with pytest.raises(ValueError, match=r"moment \(2,\), angle \(3,\)"):
        joint_forms.ring_bending(np.ones(2), np.ones(3))
