"""Grossmann's moments and swing angles against the normal to both pins."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import (
    NEAR_90,
    TO_60,
    ULP,
    Cross,
    cross,
    dot,
    grid,
    norm,
    relative_errors,
)

from cardan_dyn.analytic import grossmann, single_joint, thoma


@pytest.fixture(scope="module", params=[TO_60, NEAR_90], ids=["to 60 degrees", "near 90 degrees"])
def positions(request):
    """beta and phi."""
    random = np.random.default_rng(5).uniform(0, np.max(request.param), 5)
    return grid(np.append(request.param, random), seed=6)


def at_input(beta, phi):
    return [Cross(b, p) for b, p in zip(beta, phi, strict=True)]


def at_output(beta, phi):
    """Crosses whose output shaft stands at phi: seen from there it is the input shaft."""
    crosses = []
    for b, p in zip(beta, phi, strict=True):
        mirrored = Cross(b, mp.mpf(float(p)) + mp.pi / 2)
        crosses.append(Cross(b, mirrored.phi_2 - mp.pi / 2))
        assert abs(crosses[-1].phi_2 - mp.mpf(float(p))) < mp.mpf(10) ** -120
    return crosses


def split(joint):
    """Bending 1, torsion 2 and bending 2 per input torque."""
    moment = joint.moment_per_input_torque()
    bending = [norm(cross(moment, axis)) for axis in (joint.e_1, joint.e_2)]
    return bending[0], dot(moment, joint.e_2), bending[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("function", "crosses"),
    [(grossmann.moments, at_input), (grossmann.moments_from_output, at_output)],
)
def test_moments_are_exact(function, crosses, positions):
    beta, phi = positions
    values = function(beta, phi)
    assert np.all(values.torsion_1 == 1.0)
    references = zip(*map(split, crosses(beta, phi)), strict=True)
    for value, reference in zip(values[1:], references, strict=True):
        assert np.max(relative_errors(value, reference)) <= 8 * ULP


@pytest.mark.slow
@pytest.mark.parametrize(
    ("function", "crosses"),
    [(grossmann.swing_angles, at_input), (grossmann.swing_angles_from_output, at_output)],
)
def test_swing_angles_are_exact(function, crosses, positions):
    beta, phi = positions
    values = function(beta, phi)
    references = zip(*(c.swing_angles() for c in crosses(beta, phi)), strict=True)
    for value, reference in zip(values, references, strict=True):
        assert np.max(relative_errors(value, reference)) <= 8 * ULP


def angles():
    return st.floats(0.0, np.radians(89.0)), st.floats(-1e3, 1e3)


modest = settings(max_examples=60, deadline=None, derandomize=True)


@modest
@given(*angles())
def test_power_is_passed_on(beta, phi):
    """D_1 d phi_1 = D_2 d phi_2."""
    values = grossmann.moments(beta, phi, 250.0)
    power = values.torsion_2 * single_joint.speed_ratio(beta, phi)
    assert power == pytest.approx(values.torsion_1, rel=16 * ULP)


@modest
@given(*angles())
def test_size_of_the_moment_is_the_same_on_both_shafts(beta, phi):
    values = grossmann.moments(beta, phi, -3.0)
    size = grossmann.moment_size(beta, phi, -3.0)
    assert np.hypot(values.torsion_1, values.bending_1) == pytest.approx(size, rel=16 * ULP)
    assert np.hypot(values.torsion_2, values.bending_2) == pytest.approx(size, rel=16 * ULP)


@modest
@given(*angles())
def test_swing_angles_close_the_right_angle(beta, phi):
    psi_1, psi_2 = grossmann.swing_angles(beta, phi)
    assert np.cos(psi_1) * np.cos(psi_2) == pytest.approx(np.cos(beta), rel=1e-13)
    values = grossmann.moments(beta, phi)
    assert values.bending_1 == pytest.approx(abs(np.tan(psi_1)), rel=1e-13)
    assert values.bending_2 == pytest.approx(values.torsion_2 * abs(np.tan(psi_2)), rel=1e-13)


@modest
@given(*angles())
def test_both_sets_of_forms_agree(beta, phi):
    phi_2 = single_joint.output_angle(beta, phi)
    # A rounded phi_2 moves the position as much as 1/cos^2 beta.
    moved = 1e-15 * (1 + abs(phi)) / np.cos(beta) ** 2
    for by_input, by_output in (
        (grossmann.moments(beta, phi), grossmann.moments_from_output(beta, phi_2)),
        (grossmann.swing_angles(beta, phi), grossmann.swing_angles_from_output(beta, phi_2)),
    ):
        scale = 1 + 1 / np.cos(beta)
        np.testing.assert_allclose(by_output, by_input, rtol=1e-13, atol=4 * scale * moved)


@modest
@given(*angles())
def test_thoma_and_grossmann_agree(beta, phi):
    by_grossmann = grossmann.moments(beta, phi, 10.0)
    M_x, M_z = thoma.bending_moments(beta, phi, by_grossmann.torsion_2)
    assert np.hypot(M_x, M_z) == pytest.approx(by_grossmann.bending_2, rel=16 * ULP)


@pytest.mark.parametrize("degrees", [20.0, 45.0, 45.5, 50.0, 89.0])
def test_greatest_bending_of_the_output_shaft(degrees):
    beta = np.radians(degrees)
    ratio, phi_1 = grossmann.greatest_bending_2(beta)
    swept = grossmann.moments(beta, np.linspace(0, np.pi, 100001)).bending_2
    assert ratio == pytest.approx(np.max(swept), rel=1e-8)
    assert grossmann.moments(beta, phi_1).bending_2 == pytest.approx(ratio, rel=1e-14)
    exact = mp.mpf(float(beta))
    if degrees > 45:
        with mp.workdps(60):
            place = mp.findroot(
                lambda p: mp.diff(lambda x: split(Cross(exact, x))[2], p),
                (phi_1 * 0.99, phi_1 * 1.01),
            )
            best = split(Cross(exact, place))[2]
        assert relative_errors(phi_1, [place])[0] <= 8 * ULP
        assert relative_errors(ratio, [best])[0] <= 8 * ULP
    else:
        assert (ratio, phi_1) == (np.sin(beta), 0.0)


def test_sign_of_the_torque():
    values = grossmann.moments(0.7, 0.4, -5.0)
    assert values.torsion_1 == -5.0
    assert values.torsion_2 < 0.0 < values.bending_1
    assert values == pytest.approx(
        [-v if i in (0, 2) else v for i, v in enumerate(grossmann.moments(0.7, 0.4, 5.0))]
    )


def test_shapes_and_nan():
    beta, phi = np.array([[0.2], [np.nan]]), np.array([0.0, np.nan, 2.0])
    for function in (grossmann.moments, grossmann.moments_from_output):
        values = function(beta, phi, 2.0)
        assert all(v.shape == (2, 3) for v in values)
        assert values.torsion_1.tolist() == [[2.0] * 3] * 2
        for value in values[1:]:
            assert np.isnan(value).tolist() == [[False, True, False], [True] * 3]
        assert all(isinstance(v, float) for v in function(0.1, 0.2))
    for function in (grossmann.swing_angles, grossmann.swing_angles_from_output):
        assert all(v.shape == (2, 3) for v in function(beta, phi))
    with pytest.raises(ValueError, match=r"beta \(2, 1\), phi_1 \(3,\), torque \(4,\)"):
        grossmann.moments([[0.1], [0.2]], phi, np.ones(4))
    with pytest.raises(ValueError, match=r"beta = 1\.6"):
        grossmann.swing_angles(1.6, 0.0)


def test_figures_3_and_4():
    """Joint angle 50 degrees: the ranges of his diagrams."""
    beta, phi = np.radians(50.0), np.linspace(0, 2 * np.pi, 721)
    values = grossmann.moments(beta, phi)
    assert np.min(values.torsion_2) == pytest.approx(0.642788, abs=5e-7)
    assert np.max(values.torsion_2) == pytest.approx(1.555724, abs=5e-7)
    assert np.max(values.bending_1) == pytest.approx(1.191754, abs=5e-7)
    assert values.bending_2[0] == pytest.approx(0.766044, abs=5e-7)
    ratio, place = grossmann.greatest_bending_2(beta)
    assert ratio == pytest.approx(0.777862, abs=5e-7)
    assert np.degrees(place) == pytest.approx(22.622, abs=5e-4)


def test_positions_after_quarter_turns():
    """Grossmann's description: psi_1 and psi_2 after each quarter turn."""
    beta = np.radians(50.0)
    psi_1, psi_2 = grossmann.swing_angles(beta, np.arange(5) * np.pi / 2)
    np.testing.assert_allclose(psi_1, [0, beta, 0, -beta, 0], atol=1e-15)
    np.testing.assert_allclose(psi_2, [beta, 0, -beta, 0, beta], atol=1e-15)
