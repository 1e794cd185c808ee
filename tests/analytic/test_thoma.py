"""Thoma's bending moments against the normal to both pins, and his rig."""

import sys

import mpmath as mp
import numpy as np
import pytest
from testkit.cross_geometry import NEAR_90, TO_60, ULP, Cross, dot, grid, relative_errors

from cardan_dyn.analytic import grossmann, single_joint, thoma


@pytest.fixture(scope="module", params=[TO_60, NEAR_90], ids=["to 60 degrees", "near 90 degrees"])
def positions(request):
    """beta, phi_1 and the crosses there."""
    random = np.random.default_rng(3).uniform(0, np.max(request.param), 5)
    beta, phi = grid(np.append(request.param, random), seed=4)
    return beta, phi, [Cross(b, p) for b, p in zip(beta, phi, strict=True)]


def bending(cross):
    moment = cross.moment_per_output_torque()
    return dot(moment, cross.e_x), dot(moment, cross.e_z)


@pytest.mark.slow
def test_bending_moments_are_exact(positions):
    beta, phi, crosses = positions
    values = thoma.bending_moments(beta, phi)
    references = zip(*map(bending, crosses), strict=True)
    for value, reference in zip(values, references, strict=True):
        assert np.max(relative_errors(value, reference)) <= 8 * ULP


@pytest.mark.slow
def test_rig_moments_are_exact(positions):
    beta, phi, crosses = positions
    inertia, speed = 0.37, 150.0
    values = thoma.rig_moments(beta, phi, inertia, speed)
    references = []
    for cross in crosses:
        torque = mp.mpf(inertia) * mp.mpf(speed) ** 2 * cross.acceleration_ratio()
        references.append((torque, *(torque * part for part in bending(cross))))
    for value, reference in zip(values, zip(*references, strict=True), strict=True):
        assert np.max(relative_errors(value, reference)) <= 8 * ULP


@pytest.mark.slow
def test_powers_of_the_denominator_do_not_multiply_its_error():
    """The mean square of the errors, which a few lucky positions cannot hide."""
    rng = np.random.default_rng(9)
    beta, phi = rng.uniform(0.1, 1.05, 800), rng.uniform(0.0, 6.0, 800)
    with mp.workdps(40):
        references = []
        for cross in (Cross(b, p) for b, p in zip(beta, phi, strict=True)):
            torque = cross.acceleration_ratio()
            references.append((torque, *(torque * part for part in bending(cross))))
    values = thoma.rig_moments(beta, phi, 1.0, 1.0)
    limits = (1.0, 1.4, 1.35)
    for value, reference, limit in zip(values, zip(*references, strict=True), limits, strict=True):
        errors = relative_errors(value, reference) / ULP
        assert np.sqrt(np.mean(errors**2)) <= limit


@pytest.mark.slow
def test_moment_is_normal_to_both_pins(positions):
    beta, phi, crosses = positions
    pin_1, pin_2 = thoma.pin_cosines(beta, phi)
    moment = thoma.moment_cosines(beta, phi)
    for value, name in ((pin_1, "pin_1"), (pin_2, "pin_2"), (moment, "normal")):
        # Thoma's x, y, z lie along -e_x, -e_2 and -e_z; a pin or normal has two directions.
        exact = [[-dot(getattr(c, name), axis) for axis in (c.e_x, c.e_2, c.e_z)] for c in crosses]
        for component in range(3):
            reference = [row[component] for row in exact]
            if name == "normal":
                size = [mp.sqrt(dot(c.normal, c.normal)) for c in crosses]
                reference = [r / s for r, s in zip(reference, size, strict=True)]
            errors = relative_errors(value[:, component], reference)
            assert np.max(errors) <= 8 * ULP, (name, component)


def test_thomas_angles_are_the_ratios():
    beta, phi = np.radians(40.0), np.linspace(0.05, 6.2, 60)
    x, y, z = thoma.moment_cosines(beta, phi).T
    M_x, M_z = thoma.bending_moments(beta, phi, torque=7.0)
    np.testing.assert_allclose(M_x, 7.0 * x / y, rtol=1e-14)
    np.testing.assert_allclose(M_z, 7.0 * z / y, rtol=1e-14)


def test_hauptlagen():
    M_x, M_z = thoma.bending_moments(0.6, np.array([0.0, np.pi / 2]), 3.0)
    assert M_x[0] == pytest.approx(3.0 * np.tan(0.6), rel=4 * ULP)
    assert M_z[0] == 0.0
    assert np.abs([M_x[1], M_z[1]]).max() < 1e-15


def test_greatest_bending():
    beta, phi = np.radians(50.0), np.linspace(0, np.pi, 100001)
    M_x, M_z = thoma.bending_moments(beta, phi)
    assert (np.min(M_x), np.max(M_x)) == pytest.approx((0.0, np.tan(beta)), abs=1e-9)
    half = np.tan(beta) / 2
    assert (np.min(M_z), np.max(M_z)) == pytest.approx((-half, half), rel=1e-8)


def test_printed_forms():
    """(6) and (7) as printed, away from their poles at 90 degrees."""
    beta, phi = np.radians([[8.5], [50.0]]), np.linspace(-1.5, 1.5, 31)
    denominator = np.cos(beta) ** 2 + np.tan(phi) ** 2
    M_x, M_z = thoma.bending_moments(beta, phi)
    np.testing.assert_allclose(M_x, np.sin(beta) * np.cos(beta) / denominator, rtol=1e-13)
    np.testing.assert_allclose(M_z, np.sin(beta) * np.tan(phi) / denominator, rtol=1e-13)


def test_rig_consists_of_8_6_and_7():
    beta, phi = np.radians([[8.5], [45.0]]), np.linspace(0, 7, 50)
    torque, M_x, M_z = thoma.rig_moments(beta, phi, 2.0, 30.0)
    np.testing.assert_allclose(torque, 1800.0 * single_joint.acceleration_ratio(beta, phi))
    bending = thoma.bending_moments(beta, phi, torque)
    np.testing.assert_allclose((M_x, M_z), bending, rtol=1e-13)


@pytest.mark.parametrize(
    ("degrees", "percent"), [(8.5, (1.5, 2.7, 2.5)), (20.0, (8.6, 14.5, 13.7))]
)
def test_error_of_the_small_angle_form(degrees, percent):
    beta, phi = np.radians(degrees), np.linspace(0, 2 * np.pi, 20001)
    exact = thoma.rig_moments(beta, phi, 1.0, 1.0)
    small = thoma.rig_moments_small_angle(beta, phi, 1.0, 1.0)
    errors = [100 * np.max(abs(s - e)) / np.max(abs(e)) for s, e in zip(small, exact, strict=True)]
    assert errors == pytest.approx(percent, abs=0.05)


def test_small_angle_form_as_printed():
    beta, phi = np.radians(12.0), np.linspace(-4, 4, 41)
    unit = 0.2 * 90.0**2 * (1 - np.cos(beta))
    printed = (
        -2 * unit * np.sin(2 * phi),
        -unit * np.sin(beta) * (np.sin(2 * phi) + 0.5 * np.sin(4 * phi)),
        -0.5 * unit * np.sin(beta) * (1 - np.cos(4 * phi)),
    )
    values = thoma.rig_moments_small_angle(beta, phi, 0.2, 90.0)
    np.testing.assert_allclose(values, printed, atol=1e-13 * unit)


def test_error_of_the_small_angle_form_falls_with_the_square():
    phi = np.linspace(0, 2 * np.pi, 721)
    errors = []
    for beta in (0.08, 0.04):
        exact = np.array(thoma.rig_moments(beta, phi, 1.0, 1.0))
        small = np.array(thoma.rig_moments_small_angle(beta, phi, 1.0, 1.0))
        errors.append(np.max(abs(small - exact), axis=1) / np.max(abs(exact), axis=1))
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.02)


@pytest.mark.parametrize("degrees", [0.0, 8.5, 45.0, 75.0])
def test_harmonics_are_those_of_the_rig(degrees):
    beta, count = np.radians(degrees), 1024
    phi = np.arange(count) * (2 * np.pi / count)
    spectra = np.fft.rfft(thoma.rig_moments(beta, phi, 0.4, 20.0), axis=1) / count
    orders = np.arange(0, 60, 2)
    harmonics = thoma.rig_harmonics(beta, orders, 0.4, 20.0)
    scale = 160.0 * single_joint.greatest_acceleration(beta) * (1 + np.tan(beta)) + 1e-300
    double = np.where(orders == 0, 1.0, 2.0)
    sines = -double * spectra.imag[:2, orders]
    np.testing.assert_allclose(harmonics[:2], sines, atol=1e-14 * scale)
    cosines = double * spectra.real[2, orders]
    np.testing.assert_allclose(harmonics.bending_z, cosines, atol=1e-14 * scale)
    assert np.max(abs(spectra[:, 1::2])) <= 1e-15 * scale


@pytest.mark.parametrize(
    ("degrees", "order", "count"),
    [(0.01, 2, 8), (0.01, 4, 8), (8.5, 2, 40), (8.5, 4, 40), (60.0, 0, 128), (60.0, 6, 128)],
)
def test_harmonics_are_exact(degrees, order, count):
    beta = np.radians(degrees)
    sums = [mp.mpf(0)] * 3
    # The trapezium rule over a period converges as kappa to the number of nodes.
    with mp.workdps(60):
        for k in range(count):
            phi = mp.pi * k / count
            cross = Cross(beta, phi)
            torque = cross.acceleration_ratio()
            M_x, M_z = (torque * part for part in bending(cross))
            sine, cosine = mp.sin(order * phi), mp.cos(order * phi)
            terms = (torque * sine, M_x * sine, M_z * cosine)
            sums = [s + t for s, t in zip(sums, terms, strict=True)]
        references = [s * (1 if order == 0 else 2) / count for s in sums]
    for value, reference in zip(thoma.rig_harmonics(beta, order), references, strict=True):
        assert relative_errors(value, [reference])[0] <= 8 * ULP


def test_small_angles_leave_two_and_four_times_the_speed():
    beta = 1e-3
    unit = np.sin(beta) * (1 - np.cos(beta))
    values = thoma.rig_harmonics(beta, [0, 2, 4, 6])
    np.testing.assert_allclose(values.torsion / unit * beta, [0, -2, 0, 0], atol=1e-5)
    np.testing.assert_allclose(values.bending_x / unit, [0, -1, -0.5, 0], atol=1e-5)
    np.testing.assert_allclose(values.bending_z / unit, [-0.5, 0, 0.5, 0], atol=1e-5)


def test_order_four_of_the_bending_across_vanishes_once():
    place = 2 * np.arctan((1 - np.sqrt(6) / 3) ** 0.25)
    assert np.degrees(place) == pytest.approx(66.4, abs=0.05)
    below, above = thoma.rig_harmonics([place - 1e-3, place + 1e-3], 4).bending_z
    assert below > 0.0 > above


def test_one_sine_and_one_cosine_of_all_samples_have_to_do(monkeypatch):
    phi, taken = np.linspace(0, 2 * np.pi, 1000), []
    for name in ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "hypot", "sqrt"):
        function = getattr(np, name)

        def counted(*arguments, name=name, function=function, **options):
            if any(np.size(item) > 1 for item in arguments):
                taken.append(name)
            return function(*arguments, **options)

        monkeypatch.setattr(np, name, counted)
    thoma.bending_moments(0.5, phi)
    assert sorted(taken) == ["cos", "sin"]


def test_no_loop_over_samples():
    """The number of lines that Python executes does not depend on the number of samples."""

    def lines(count):
        phi, executed = np.linspace(0, 6, count), 0

        def trace(frame, event, argument):
            nonlocal executed
            executed += event == "line"
            return trace

        previous = sys.gettrace()
        sys.settrace(trace)
        try:
            thoma.bending_moments(0.5, phi)
            thoma.rig_moments(0.5, phi, 1.0, 2.0)
            grossmann.moments(0.5, phi)
            single_joint.output_angle(0.5, phi)
        finally:
            sys.settrace(previous)
        return executed

    assert 0 < lines(10) == lines(10_000) < 400


def test_nan_and_shapes():
    beta, phi = np.array([[0.2], [0.3]]), np.array([0.5, np.nan, 2.0])
    missing = [[False, True, False]] * 2
    for values in (
        thoma.bending_moments(beta, phi, 2.0),
        thoma.rig_moments(beta, phi, 1.0, 3.0),
        thoma.rig_moments_small_angle(beta, phi, 1.0, 3.0),
    ):
        assert [np.isnan(v).tolist() for v in values] == [missing] * len(values)
    harmonics = thoma.rig_harmonics(beta, [0.0, np.nan, 2.0])
    assert [np.isnan(v).tolist() for v in harmonics] == [missing] * 3
    assert thoma.moment_cosines(beta, phi).shape == (2, 3, 3)
    assert all(isinstance(v, float) for v in thoma.bending_moments(0.1, 0.2))
    assert all(isinstance(v, float) for v in thoma.rig_harmonics(0.1, 2))


def test_bad_arguments():
    with pytest.raises(ValueError, match=r"inertia = -1.0 .*\[0, inf\)"):
        thoma.rig_moments(0.1, 0.2, -1.0, 3.0)
    with pytest.raises(ValueError, match=r"beta = 1\.6"):
        thoma.bending_moments(1.6, 0.2)
    with pytest.raises(ValueError, match=r"torque \(2,\)"):
        thoma.bending_moments(0.1, np.zeros(3), np.ones(2))
    for order in (1, -2, 2.5, np.inf):
        with pytest.raises(ValueError, match=r"order = .*0, 2, 4, \.\.\."):
            thoma.rig_harmonics(0.1, order)
