"""Motion of the single joint against the geometry of the cross, and its invariants."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import NEAR_90, TO_60, ULP, Cross, grid, relative_errors

from cardan_dyn.analytic import _cross
from cardan_dyn.analytic import single_joint as sj

BETAS = st.floats(0.0, np.radians(89.0))
TURNS = st.floats(-1e3, 1e3)
ZEROS = st.sampled_from(["in_plane", "normal"])
modest = settings(max_examples=60, deadline=None, derandomize=True)


@pytest.fixture(scope="module", params=[TO_60, NEAR_90], ids=["to 60 degrees", "near 90 degrees"])
def positions(request):
    """beta, phi_1 and the crosses there."""
    random = np.random.default_rng(1).uniform(0, np.max(request.param), 5)
    beta, phi = grid(np.append(request.param, random), seed=2)
    return beta, phi, [Cross(b, p) for b, p in zip(beta, phi, strict=True)]


def worst(values, references):
    return np.max(relative_errors(values, references))


@pytest.mark.slow
def test_output_angle_is_exact(positions):
    beta, phi, crosses = positions
    assert worst(sj.output_angle(beta, phi), [c.phi_2 for c in crosses]) <= 8 * ULP


@pytest.mark.slow
def test_lead_is_exact(positions):
    beta, phi, crosses = positions
    assert worst(sj.lead(beta, phi), [c.phi_2 - c.phi_1 for c in crosses]) <= 8 * ULP


@pytest.mark.slow
def test_speed_ratio_is_exact(positions):
    beta, phi, crosses = positions
    assert worst(sj.speed_ratio(beta, phi), [c.speed_ratio() for c in crosses]) <= 8 * ULP


@pytest.mark.slow
def test_acceleration_ratio_is_exact(positions):
    beta, phi, crosses = positions
    references = [c.acceleration_ratio() for c in crosses]
    assert worst(sj.acceleration_ratio(beta, phi), references) <= 8 * ULP


@pytest.mark.slow
@pytest.mark.parametrize("name", ["output_angle", "lead", "speed_ratio", "acceleration_ratio"])
def test_weisbachs_zero_lies_a_quarter_turn_further(name, positions):
    beta, phi, _ = positions
    references = []
    for b, p in zip(beta, phi, strict=True):
        cross = Cross(b, mp.mpf(float(p)) + mp.pi / 2)
        references.append(
            {
                "output_angle": lambda c: c.phi_2 - mp.pi / 2,
                "lead": lambda c: c.phi_2 - c.phi_1,
                "speed_ratio": Cross.speed_ratio,
                "acceleration_ratio": Cross.acceleration_ratio,
            }[name](cross)
        )
    assert worst(getattr(sj, name)(beta, phi, zero="normal"), references) <= 8 * ULP


def test_error_of_the_denominator_is_its_error():
    rng = np.random.default_rng(8)
    factors = rng.uniform(-1, 1, (3, 200)) * 10.0 ** rng.integers(-8, 1, (3, 200))
    base, error = _cross.denominator_and_error(*factors)
    for value, share, (a, s, c) in zip(base, error, factors.T, strict=True):
        exact = (mp.mpf(float(a)) * mp.mpf(float(c))) ** 2 + mp.mpf(float(s)) ** 2
        corrected = mp.mpf(float(value)) * (1 + mp.mpf(float(share)))
        assert abs(corrected / exact - 1) < mp.mpf(10) ** -30


@pytest.mark.slow
def test_input_angle_is_exact(positions):
    beta, phi, _ = positions
    # Seen from shaft 2, shaft 1 is the output of the joint a quarter turn further.
    references = [
        Cross(b, mp.mpf(float(p)) + mp.pi / 2).phi_2 - mp.pi / 2
        for b, p in zip(beta, phi, strict=True)
    ]
    assert worst(sj.input_angle(beta, phi), references) <= 8 * ULP


@modest
@given(BETAS, TURNS, ZEROS)
def test_input_angle_inverts_output_angle(beta, phi, zero):
    there = sj.output_angle(beta, phi, zero=zero)
    # The inverse is as steep as 1/cos beta.
    assert sj.input_angle(beta, there, zero=zero) == pytest.approx(
        phi, rel=1e-15, abs=4 * ULP * (1 + abs(phi)) / np.cos(beta)
    )


@modest
@given(BETAS, TURNS, st.integers(-1000, 1000), ZEROS)
def test_periodic_over_half_turns(beta, phi, half_turns, zero):
    further = phi + half_turns * np.pi
    shift = 4 * ULP * (1 + abs(further)) / np.cos(beta) ** 2
    for name in ("lead", "speed_ratio", "acceleration_ratio"):
        function = getattr(sj, name)
        steepness = sj.greatest_acceleration(beta) / np.cos(beta) + 1
        assert function(beta, further, zero=zero) == pytest.approx(
            function(beta, phi, zero=zero), rel=1e-14, abs=steepness * shift
        )


@modest
@given(BETAS, TURNS, ZEROS)
def test_symmetry_about_the_zero(beta, phi, zero):
    assert sj.output_angle(beta, -phi, zero=zero) == -sj.output_angle(beta, phi, zero=zero)
    assert sj.speed_ratio(beta, -phi, zero=zero) == sj.speed_ratio(beta, phi, zero=zero)
    assert sj.acceleration_ratio(beta, -phi, zero=zero) == -sj.acceleration_ratio(
        beta, phi, zero=zero
    )


@modest
@given(BETAS, st.floats(-10, 10), ZEROS)
def test_derivatives_equal_complex_steps(beta, phi, zero):
    step = 1e-30
    sine, cosine = _cross.sine_cosine(phi + 1j * step, zero)
    angle = phi + 1j * step + _cross.lead(np.cos(beta), _cross.versine(beta), sine, cosine)
    ratio = _cross.speed_ratio(np.cos(beta), sine, cosine)
    assert sj.speed_ratio(beta, phi, zero=zero) == pytest.approx(angle.imag / step, rel=1e-12)
    assert sj.acceleration_ratio(beta, phi, zero=zero) == pytest.approx(
        ratio.imag / step, rel=1e-12, abs=1e-15
    )


@modest
@given(BETAS, TURNS)
def test_speed_ratio_stays_in_its_range(beta, phi):
    smallest, greatest = sj.speed_ratio_range(beta)
    assert smallest * (1 - 8 * ULP) <= sj.speed_ratio(beta, phi) <= greatest * (1 + 8 * ULP)


def test_series_of_the_lead():
    beta, phi = np.radians(35.0), np.linspace(0, 7, 50)
    kappa, n = np.tan(beta / 2) ** 2, np.arange(1, 30)[:, None]
    series = np.sum(kappa**n * np.sin(2 * n * phi) / n, axis=0)
    np.testing.assert_allclose(sj.lead(beta, phi), series, atol=1e-15)


@pytest.mark.parametrize("degrees", [1e-6, 1.0, 30.0, 60.0, 89.0, 89.999])
def test_greatest_values_are_the_greatest(degrees):
    beta = np.radians(degrees)
    exact = mp.mpf(float(beta))

    def position(guess, order):
        """Where the derivative of phi_2 of this order vanishes."""
        output, wanted = Cross(exact, mp.mpf(0)).output, 1 if order == 1 else 0
        guess = mp.mpf(float(guess))
        return mp.findroot(
            lambda phi: mp.diff(output, phi, order) - wanted,
            (guess, guess * (1 + mp.mpf(10) ** -6)),
        )

    with mp.workdps(60):
        equal = position(sj.equal_speed_angle(beta), 1)
        steepest = position(sj.greatest_acceleration_angle(beta), 3)
        crosses = Cross(exact, equal), Cross(exact, steepest)
        references = {
            sj.equal_speed_angle: equal,
            sj.greatest_acceleration_angle: steepest,
            sj.greatest_lead: crosses[0].phi_2 - equal,
            sj.greatest_acceleration: abs(crosses[1].acceleration_ratio()),
        }
        for function, reference in references.items():
            assert worst(function(beta), [reference]) <= 8 * ULP, function.__name__
            if function in (sj.equal_speed_angle, sj.greatest_acceleration_angle):
                other = function(beta, zero="normal")
                assert worst(other, [mp.pi / 2 - reference]) <= 8 * ULP
        spread = Cross(exact, mp.pi / 2).speed_ratio() - Cross(exact, mp.mpf(0)).speed_ratio()
        assert worst(sj.non_uniformity(beta), [abs(spread)]) <= 8 * ULP


def test_greatest_acceleration_over_a_sweep():
    phi = np.linspace(0, np.pi / 2, 20001)
    for beta in np.radians([5.0, 45.0, 80.0]):
        swept = sj.acceleration_ratio(beta, phi)
        assert np.max(np.abs(swept)) == pytest.approx(sj.greatest_acceleration(beta), rel=1e-6)
        place = sj.greatest_acceleration_angle(beta)
        assert phi[np.argmin(swept)] == pytest.approx(place, abs=1e-4)


def test_limits_at_joint_angle_zero():
    assert sj.greatest_lead(0.0) == sj.non_uniformity(0.0) == sj.greatest_acceleration(0.0) == 0.0
    assert sj.equal_speed_angle(0.0) == pytest.approx(np.pi / 4, rel=ULP)
    assert sj.greatest_acceleration_angle(0.0) == pytest.approx(np.pi / 4, rel=ULP)


def test_shapes_and_scalars():
    beta, phi = np.radians([[10.0], [20.0], [30.0]]), np.linspace(0, 1, 4)
    for function in (sj.output_angle, sj.lead, sj.speed_ratio, sj.acceleration_ratio):
        table = function(beta, phi)
        assert table.shape == (3, 4)
        assert isinstance(function(0.3, 1), float)
        assert table[1, 2] == function(beta[1, 0], phi[2])
    assert sj.input_angle(beta, phi).shape == (3, 4)
    assert isinstance(sj.input_angle(0.3, 1), float)


@pytest.mark.parametrize("zero", ["in_plane", "normal"])
def test_nan_stays_in_its_place(zero):
    beta, phi = np.array([0.1, np.nan, 0.3]), np.array([[0.5], [np.nan]])
    for name in ("output_angle", "input_angle", "lead", "speed_ratio", "acceleration_ratio"):
        missing = np.isnan(getattr(sj, name)(beta, phi, zero=zero))
        assert missing.tolist() == [[False, True, False], [True, True, True]], name
    assert np.isnan(sj.non_uniformity(beta)).tolist() == [False, True, False]


@pytest.mark.parametrize("beta", [-1e-300, np.pi / 2, 2.0, np.inf, -np.inf, [0.1, 1.6]])
def test_joint_angle_out_of_range(beta):
    with pytest.raises(ValueError, match=r"beta.* = .*\[0, pi/2\) rad"):
        sj.speed_ratio(beta, 0.0)
    with pytest.raises(ValueError, match="beta"):
        sj.greatest_lead(beta)


def test_other_bad_arguments():
    with pytest.raises(ValueError, match=r"beta \(2,\), phi_1 \(3,\)"):
        sj.output_angle([0.1, 0.2], [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="zero = 'up' is not one of 'in_plane', 'normal'"):
        sj.lead(0.1, 0.2, zero="up")
    with pytest.raises(ValueError, match="phi_1 = 1j must be real"):
        sj.output_angle(0.1, 1j)
    with pytest.raises(ValueError, match=r"beta\[1\] = 1.6 "):
        sj.lead([0.1, 1.6], 0.0)
