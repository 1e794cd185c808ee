"""Whirl of shaft 2: against the non-linear equations of its two tilts, written down by Lagrange."""

import numpy as np
import pytest
from shooting import orders, periodic
from tilting_shaft import TiltingShaft

from cardan_dyn.analytic import thoma, whirl

BETA = np.radians(5.0)
# Speed, order, peak amplitude and that of the linear rotor, A = c = 1, Theta = 0.1, zeta = 0.01.
PEAKS = [
    (0.51303, 2, 2.13018e-4, 2.13084e-4),
    (0.48789, -2, 2.03884e-4, 2.03846e-4),
    (0.25320, 4, 5.2991e-5, 5.2985e-5),
]


def whirling(beta, speed, **options):
    """Fourier coefficients of s = s_x + i s_z, whose s_x is minus the tilt in the plane."""
    system = TiltingShaft(beta, speed, **options)
    found = orders(system, periodic(system, np.zeros(4)).start, 32)
    return -(found[:, 0] - 1j * found[:, 1])


def tilt(beta, order, speed, damping=0.02, moments=None):
    size = abs(order)
    moments = moments or whirl.moments_of_flywheel(beta, size, 0.1, speed)
    found = whirl.tilts(moments, size, speed, 0.1, 1.0, 1.0, damping)
    return found.forward if order >= 0 else found.backward


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "order", "exact", "linear"), PEAKS)
def test_amplitudes_at_the_peaks(speed, order, exact, linear):
    """Within 0.5 % of the non-linear ones, in phase as well; the peak is where `peak` says."""
    found = tilt(BETA, order, speed)
    reference = whirling(BETA, speed)[order // 2]
    assert abs(reference) == pytest.approx(exact, abs=6e-10)
    # There the phase turns by 1/ζ for a relative change of the speed, 3e-4 as below.
    assert abs(found - reference) < 0.03 * exact
    assert abs(found) == pytest.approx(exact, rel=5e-3)
    at, greatest = whirl.peak(BETA, abs(order), 0.1, 1.0, 1.0, 0.01, forward=order > 0)
    assert greatest == pytest.approx(linear, abs=6e-10)
    assert at == pytest.approx(speed, rel=3e-4)
    assert at == pytest.approx(
        whirl.critical_speed(1.0, abs(order), 0.1, forward=order > 0), rel=1e-3
    )


@pytest.mark.slow
def test_off_resonance_every_order_is_that_of_the_full_equations():
    """Error of the second order in the tilt and of what the tilt adds to beta."""
    reference = whirling(BETA, 0.37)
    for order in (2, -2, 4, 0):
        scale = abs(reference[order // 2])
        assert abs(tilt(BETA, order, 0.37) - reference[order // 2]) < 2e-3 * scale
    assert abs(tilt(BETA, -4, 0.37)) < 0.01 * abs(tilt(BETA, 4, 0.37))


def test_peak_is_the_greatest_amplitude():
    """By search over the speed, of the amplitude with its moments at that speed."""
    speeds = np.linspace(0.4, 0.7, 300001)
    amplitude = np.abs(tilt(0.3, 2, speeds))
    at, greatest = whirl.peak(0.3, 2, 0.1, 1.0, 1.0, 0.01)
    assert speeds[np.argmax(amplitude)] == pytest.approx(at, abs=2e-6)
    assert np.max(amplitude) == pytest.approx(greatest, rel=1e-9)


# Peaks of the full equations at 20° over those at 5°, by search over the speed.
GROWTH = [(2, True, 63.80), (2, False, 69.90), (4, True, 71.54)]


@pytest.mark.parametrize(("order", "forward", "ratio"), GROWTH)
def test_peaks_grow_about_as_beta_cubed(order, forward, ratio):
    """By 64 from 5° to 20° to the lowest order, which forward whirl of order 2 follows best."""
    angles = np.radians([5.0, 20.0])
    small, large = whirl.peak(angles, order, 0.1, 1.0, 1.0, 0.01, forward=forward)[1]
    assert large / small == pytest.approx(ratio, rel=2e-3)


# Leading term and the next of the moments over β³/4, by hand from 2 t³ with t = tan(β/2).
SERIES = [(2, True, 1.0, 0.0), (2, False, -1.0, 0.75), (4, True, 1.0, 1.0)]


@pytest.mark.parametrize(("order", "forward", "sign", "next_"), SERIES)
def test_moments_of_the_flywheel_at_small_angles(order, forward, sign, next_):
    """Β³/4 (1 + c β²) with c = 0, 3/4, 1, so that 1° to 4° is 64 (1 + 15 c β²)."""
    beta = np.radians([0.5, 1.0, 2.0, 4.0])
    found = whirl.moments_of_flywheel(beta, order)
    over = sign * np.real(found.forward if forward else found.backward) / (0.25 * beta**3)
    assert over == pytest.approx(1.0 + next_ * beta**2, abs=2.0 * beta[-1] ** 4)
    assert (over - 1.0 - next_ * beta**2)[:3] == pytest.approx(0.0, abs=2.0 * beta[2] ** 4)
    ratio = whirl.peak(beta, order, 0.1, 1.0, 1.0, 0.01, forward=forward)[1]
    assert ratio[3] / ratio[1] == pytest.approx(
        64.0 * (1.0 + 15.0 * next_ * beta[1] ** 2), rel=1e-4
    )


@pytest.mark.parametrize(("order", "forward"), [(4, False), (6, True), (6, False), (8, True)])
def test_other_orders_of_the_flywheel_vanish_faster(order, forward):
    """As β⁵ or more: at small angles Thoma's two orders are all there is."""
    found = whirl.moments_of_flywheel(np.radians([1.0, 4.0]), order)
    small, large = np.abs(found.forward if forward else found.backward)
    assert large / small > 0.99 * 4.0**5


def test_critical_speeds_of_thoma_are_those_without_gyroscopic_effect():
    assert whirl.critical_speed(120.0, [2, 4]) == pytest.approx([60.0, 30.0], rel=1e-15)
    forward = whirl.critical_speed(1.0, [2, 4], 0.1)
    assert forward == pytest.approx([1 / np.sqrt(3.8), 1 / np.sqrt(15.6)], rel=1e-15)
    backward = whirl.critical_speed(1.0, [2, 4], 0.1, forward=False)
    assert backward == pytest.approx([1 / np.sqrt(4.2), 1 / np.sqrt(16.4)], rel=1e-15)
    # Θ/A = 2: the thin disc has no forward critical speed of order 2, but one of order 4.
    assert np.isinf(whirl.critical_speed(1.0, 2, 2.0))
    assert whirl.critical_speed(1.0, 4, 2.0) == pytest.approx(1 / np.sqrt(8.0))
    speed, height = whirl.peak(BETA, [2, 4], 2.0, 1.0, 1.0, 0.01)
    assert np.isinf(speed[0]) and np.isnan(height[0]) and np.all(np.isfinite([speed[1], height[1]]))


def test_critical_speeds_are_where_an_order_meets_the_whirl_frequency():
    speed, ratio = np.array([0.0, 0.3, 2.0]), 0.7
    ahead, behind = whirl.whirl_frequencies(speed, 1.3, ratio)
    for sign, roots in ((1, ahead), (-1, behind)):
        assert np.max(np.abs(roots**2 - sign * ratio * speed * roots - 1.3**2)) < 1e-14
    for order in (2.0, 4.0):
        for number, forward in enumerate((True, False)):
            at = whirl.critical_speed(1.3, order, ratio, forward=forward)
            meets = whirl.whirl_frequencies(at, 1.3, ratio)[number]
            assert meets == pytest.approx(order * at, rel=1e-14)


@pytest.mark.parametrize("beta", np.radians([5.0, 20.0, 60.0]))
def test_moments_are_the_series_of_thomas_formulas(beta):
    """(6) and (7) by the discrete Fourier transform, for all three kinds of torque."""
    phi = 2.0 * np.pi * np.arange(256) / 256
    flywheel = thoma.rig_moments(beta, phi, 0.7, 3.0)[1:]
    nominal = np.cos(beta) ** 2 * np.cos(phi) ** 2 + np.sin(phi) ** 2
    kinds = (
        (flywheel, lambda order: whirl.moments_of_flywheel(beta, order, 0.7, 3.0)),
        (
            thoma.bending_moments(beta, phi, 5.0 * nominal / np.cos(beta)),
            lambda order: whirl.moments_of_input_torque(beta, order, 5.0),
        ),
        (
            thoma.bending_moments(beta, phi, 5.0),
            lambda order: whirl.moments_of_output_torque(beta, order, 5.0),
        ),
    )
    for (moment_x, moment_z), closed in kinds:
        series = np.fft.fft(moment_z - 1j * moment_x) / 256
        scale = np.max(np.abs(series))
        for order in (0, 2, 4, 6):
            found = closed(order)
            assert abs(found.forward - series[order]) < 1e-14 * scale
            # What is constant stands under `forward` alone.
            backward = series[-order] if order else 0.0
            assert abs(found.backward - backward) < 1e-14 * scale


def test_kinds_of_torque_have_other_orders():
    """Fourth over second order: none with a constant input torque, tan²(β/2) with an output one."""
    assert whirl.moments_of_input_torque(1.2, 4) == (0.0, 0.0)
    for angle, ratio in ((5.0, 0.0019), (20.0, 0.0311)):
        forward, backward = whirl.moments_of_output_torque(np.radians(angle), [2, 4])
        assert abs(forward[1] / forward[0]) == pytest.approx(ratio, abs=5e-5)
        assert np.all(backward == 0.0)
    flywheel = whirl.moments_of_flywheel(BETA, [2, 4])
    assert flywheel.backward[0] == pytest.approx(-flywheel.forward[0], rel=0.01)
    assert abs(flywheel.backward[1]) < 0.01 * abs(flywheel.forward[1])


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.37, 1.7])
def test_flutter_begins_at_its_torque(speed):
    """By the multipliers of the full equations a hundredth below and above; 4 ζ c without Θ."""
    torque = float(whirl.flutter_torque(1.0, 0.02, 1.0, 0.1, speed))
    for factor, grows in ((0.99, False), (1.01, True)):
        system = TiltingShaft(1e-3, speed, load=factor * torque)
        multipliers = periodic(system, np.zeros(4)).multipliers
        assert (np.max(np.abs(multipliers)) > 1.0) == grows
    assert whirl.flutter_torque(1.5, 2 * 0.01 * np.sqrt(1.5), 1.0) == pytest.approx(0.06)


@pytest.mark.parametrize(
    ("order", "forward", "small_peak", "growth", "share"),
    [
        (2, True, 2.13084e-4, 63.8, 0.0),
        (2, False, 2.03846e-4, 69.9, 0.75),
        (4, True, 5.2985e-5, 71.5, 1.0),
    ],
)
def test_peaks_without_units(order, forward, small_peak, growth, share):
    # A = c = 1, Θ = 0.1, ζ = 0.01: two independent integrations of the full equations give
    # 2.13018e-4, 2.03884e-4 and 5.2991e-5 at 5°, and 63.8, 69.9 and 71.5 times that at 20°.
    angles = np.radians([5.0, 20.0])
    _, (small, large) = whirl.peak(angles, order, 0.1, 1.0, 1.0, 0.01, forward=forward)
    assert abs(small - small_peak) < 6e-10
    assert abs(large / small - growth) < 0.15
    # From 1° to 4° it is 64, but for 15 c β² with c = 0, 3/4, 1.
    angles = np.radians([1.0, 4.0])
    _, (small, large) = whirl.peak(angles, order, 0.1, 1.0, 1.0, 0.01, forward=forward)
    assert abs(large / small / 64.0 - 1.0 - 15.0 * share * np.radians(1.0) ** 2) < 1e-4


def test_the_shape_of_the_flywheel():
    small = whirl.critical_speed(1.0, [2, 4], 0.01)
    np.testing.assert_allclose(small * [2, 4], 1.0, atol=0.01)
    assert np.isinf(whirl.critical_speed(1.0, 2, 2.0))


def test_shapes_and_bad_arguments():
    found = whirl.moments_of_input_torque([[0.1], [np.nan]], [0, 2, 4])
    assert found.forward.shape == found.backward.shape == (2, 3)
    assert np.isnan(found.forward[1]).all() and np.isfinite(found.forward[0]).all()
    moments = whirl.moments_of_output_torque(0.2, [2, 4])
    assert whirl.tilts(moments, [2, 4], np.ones((3, 1)), 0.1, 1.0, 1.0).forward.shape == (3, 2)
    # Order 4 of a massless rotor without damping at its critical speed.
    with np.errstate(all="raise"):
        assert not np.isfinite(whirl.tilts(whirl.Whirl(1.0, 0.0), 2, 0.5, 0.0, 1.0, 1.0).forward)
    for call, message in (
        (lambda: whirl.critical_speed(1.0, 2, 2.5), r"ratio = 2\.5 .*\[0, 2\]"),
        (lambda: whirl.critical_speed(0.0, 2), "frequency"),
        (lambda: whirl.moments_of_flywheel(0.1, 3), "order"),
        (lambda: whirl.moments_of_output_torque(0.1, 3), r"order = 3\.0 .*0, 2, 4"),
        (lambda: whirl.tilts(moments, 2, 1.0, 0.1, 1.0, -1.0), "stiffness"),
        (lambda: whirl.flutter_torque(1.0, -0.1), "damping"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
