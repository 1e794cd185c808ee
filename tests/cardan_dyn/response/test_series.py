"""Series against closed forms, numpy.fft and numpy.polynomial.chebyshev."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import chebyshev

from cardan_dyn.core.response import series as series_module
from cardan_dyn.core.response.domain import Domain
from cardan_dyn.core.response.series import Series

modest = settings(max_examples=60, deadline=None, derandomize=True)

TURN = Domain(0.3, 2.0 * np.pi, True)
RANGE = Domain(0.5, 1.5, False)


def poisson(x: np.ndarray, decay: float) -> np.ndarray:
    """1/2 + Σ decay^k cos(k x)."""
    return 0.5 * (1.0 - decay**2) / (1.0 - 2.0 * decay * np.cos(x) + decay**2)


def pole(t: np.ndarray, at: float) -> np.ndarray:
    """A function with a pole at `at` > 1, on -1 … 1."""
    return 1.0 / (at - t)


def on_domain(domain: Domain, steps: int, *functions: object) -> Series:
    """The series of functions of the phase angle, or of the position in units of half the range."""
    x = (domain.nodes(steps) - domain.origin) * (1.0 if domain.periodic else 1.0 / domain.length)
    return Series(np.stack([function(x) for function in functions]), domain)  # type: ignore[operator]


@pytest.mark.parametrize("count", [16, 30, 128])
def test_the_spectrum_of_a_period_is_the_one_of_numpy(count: int) -> None:
    values = np.random.default_rng(1).normal(size=(3, count))
    expected = np.abs(np.fft.fft(values, axis=1))[:, : count // 2 + 1] / count
    np.testing.assert_allclose(Series(values, TURN).spectrum(), expected, atol=1e-15)


def test_the_spectrum_of_poissons_kernel_is_geometric() -> None:
    spectrum = on_domain(TURN, 128, lambda x: poisson(x, 0.5)).spectrum()[0]
    np.testing.assert_allclose(spectrum, 0.5 ** np.arange(1.0, 66.0), atol=1e-15, rtol=1e-10)


def test_the_spectrum_of_a_range_is_half_of_chebyshevs_coefficients() -> None:
    """On the circle of a range every order has two waves, but for the lowest one."""
    series = on_domain(RANGE, 64, lambda t: pole(t, 1.5), lambda t: np.exp(t) * t)
    for row, function in enumerate((lambda t: pole(t, 1.5), lambda t: np.exp(t) * t)):
        coefficients = np.abs(chebyshev.chebinterpolate(function, 30))
        expected = np.concatenate([coefficients[:1], 0.5 * coefficients[1:]])
        np.testing.assert_allclose(series.spectrum()[row, :31], expected, atol=1e-11)


@pytest.mark.parametrize("decay", [0.5, 0.8, 0.9])
@pytest.mark.parametrize("count", [32, 64])
def test_the_remainder_of_a_geometric_spectrum_is_its_sum(decay: float, count: int) -> None:
    """An order of amplitude a is missing at a peak, and the samples add as much to a lower order.

    The highest order of the samples is itself only half known; hence a factor of the remainder.
    """
    series = on_domain(TURN, count, lambda x: poisson(x, decay))
    exact = 2.0 * decay ** (count // 2 + 1) / (1.0 - decay)
    remainder = series.remainder(np.zeros(1))[0]
    assert 0.5 * exact < remainder < 5.0 * exact
    x = TURN.origin + np.linspace(-0.5, 0.5, 2001)
    deviation = np.max(np.abs(series.summed(x)[0] - poisson(x - TURN.origin, decay)))
    assert 0.5 * deviation < remainder < 10.0 * deviation


@pytest.mark.parametrize("at", [1.05, 1.3])
def test_the_remainder_of_a_range_bounds_the_deviation_near_its_ends(at: float) -> None:
    series = on_domain(RANGE, 32, lambda t: pole(t, at))
    t = 1.0 - np.geomspace(1e-6, 1.0, 2000)
    x = RANGE.origin + RANGE.length * t
    deviation = np.max(np.abs(series.summed(x)[0] - pole(t, at)))
    assert 0.5 * deviation < series.remainder(np.zeros(1))[0] < 10.0 * deviation


def test_every_other_order_may_be_zero() -> None:
    """As in a Cardan joint; the orders between must not pass for a fast decay."""
    series = on_domain(TURN, 64, lambda x: poisson(2.0 * x, 0.8), lambda x: poisson(2 * x, 0.8) + 1)
    remainder = series.remainder(np.zeros(2))
    # Between the orders 2 k the coefficients are 0.8 to the power k.
    exact = 2.0 * 0.8**17 / (1.0 - 0.8)
    assert np.all((0.3 * exact < remainder) & (remainder < 10.0 * exact))


def test_a_bump_in_the_spectrum_does_not_pass_for_a_fast_decay() -> None:
    orders = np.arange(65)
    even = 0.9**orders
    bumpy = np.where((orders > 32) & (orders <= 48), 30.0, 1.0) * even
    series = Series(128.0 * np.fft.irfft(np.stack([even, bumpy])), TURN)
    expected, remainder = series.remainder(np.zeros(2))
    assert remainder == pytest.approx(expected, rel=0.2)


def test_noise_that_rounding_explains_is_no_remainder() -> None:
    noise = 1e-13 * np.random.default_rng(2).normal(size=(1, 256))
    smooth = np.cos(TURN.nodes(256) - 0.3)
    series = Series(smooth + noise, TURN)
    assert series.remainder(np.array([1e-12]))[0] == 0.0
    # The same noise without such rounding, and a slow decay of the same size, are errors.
    assert series.remainder(np.array([1e-15]))[0] > 1e-13
    assert on_domain(TURN, 256, lambda x: poisson(x, 0.8)).remainder(np.array([1.0]))[0] > 0.0


def test_functions_that_end_or_vanish_have_no_remainder() -> None:
    series = on_domain(TURN, 64, np.zeros_like, np.ones_like, np.cos)
    assert np.all(series.remainder(np.full(3, 1e-16)) < 1e-14)


@pytest.mark.parametrize("domain", [TURN, RANGE], ids=["period", "range"])
@pytest.mark.parametrize("steps", [8, 128])
def test_series_take_their_samples_at_the_nodes(domain: Domain, steps: int) -> None:
    """Even where they are too few: the series interpolates."""
    nodes = domain.nodes(steps)
    values = np.random.default_rng(3).normal(size=(2, len(nodes)))
    series = Series(values, domain)
    np.testing.assert_allclose(series.summed(nodes), values, atol=1e-13)
    at_nodes = series.at(np.arange(2), series.locate(nodes))
    np.testing.assert_allclose(at_nodes, values, atol=1e-13)


@pytest.mark.parametrize("steps", [8, 30, 64])
def test_a_range_is_summed_like_numpys_chebyshev_interpolant(steps: int) -> None:
    nodes = RANGE.nodes(steps)
    values = np.random.default_rng(4).normal(size=len(nodes))
    t = (nodes - RANGE.origin) / RANGE.length
    interpolant = chebyshev.chebfit(t, values, steps)
    x = np.linspace(-1.0, 2.0, 77)
    expected = chebyshev.chebval((x - RANGE.origin) / RANGE.length, interpolant)
    series = Series(values[None], RANGE)
    np.testing.assert_allclose(series.summed(x)[0], expected, atol=1e-12)


@modest
@given(
    positions=st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=20),
    decay=st.floats(0.0, 0.9),
)
def test_functions_of_a_period_hold_at_any_position(positions: list[float], decay: float) -> None:
    x = np.array(positions)
    series = on_domain(TURN, 1024, lambda angle: poisson(angle, decay))
    exact = poisson(x - TURN.origin, decay)
    # Near the peak of height 10 the function's slope makes 1e-13 of a position's rounding.
    np.testing.assert_allclose(series.at(np.array([0]), series.locate(x))[0], exact, atol=2e-10)
    np.testing.assert_allclose(series.summed(x)[0], exact, atol=2e-10)


@modest
@given(positions=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=20), at=st.floats(1.1, 9.0))
def test_functions_on_a_range_hold_at_any_position(positions: list[float], at: float) -> None:
    t = np.array(positions)
    series = on_domain(RANGE, 256, lambda t: pole(t, at), lambda t: t * t)
    location = series.locate(RANGE.origin + RANGE.length * t)
    values = series.at(np.array([1, 0]), location)
    np.testing.assert_allclose(values, [t * t, pole(t, at)], rtol=1e-13, atol=2e-14)


def test_positions_keep_their_shape_however_many_they_are() -> None:
    series = on_domain(TURN, 64, np.sin, np.cos)
    many = np.linspace(-9.0, 9.0, 2 * series_module.LARGE_BLOCK + 3)
    values = series.at(np.array([1, 0]), series.locate(many))
    np.testing.assert_allclose(values, [np.cos(many - 0.3), np.sin(many - 0.3)], atol=1e-14)
    for shape in ((), (0,), (2, 3, 1)):
        x = np.full(shape, 1.7)
        assert series.at(np.array([0, 1]), series.locate(x)).shape == (2, *shape)


@pytest.mark.parametrize("repeats", [False, True], ids=["turn", "half a turn"])
@pytest.mark.parametrize("size", [16, 18, 128])
@pytest.mark.parametrize("count", [1, 2, 5, 8, 16, 100, 128, 1000])
def test_grids_of_any_size(size: int, count: int, repeats: bool) -> None:
    """Orders up to seven, which 16 samples determine and a coarse grid aliases."""

    def function(x: np.ndarray) -> np.ndarray:
        even = 1.0 + np.cos(2.0 * x) - 3.0 * np.sin(6.0 * x)
        return even if repeats else even + np.sin(7.0 * x) + np.cos(x)

    series = on_domain(TURN, size, function, lambda x: -2.0 * function(x))
    expected = function(2.0 * np.pi * np.arange(count) / count)
    grid = series.uniform(np.array([1, 0]), count)
    np.testing.assert_allclose(grid, [-2.0 * expected, expected], atol=5e-14)


@pytest.mark.parametrize("count", [64, 128, 192, 1024])
@pytest.mark.parametrize("size", [16, 24])
def test_grids_that_are_made_in_several_transforms(
    size: int, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = np.random.default_rng(6).normal(size=(2, size))
    series = Series(values, TURN)
    at_once = series.uniform(np.arange(2), count)
    monkeypatch.setattr(series_module, "LARGE_BLOCK", 16)
    np.testing.assert_allclose(series.uniform(np.arange(2), count), at_once, atol=1e-13)
    # Of an even number of samples the highest order is a cosine.
    nodes = TURN.origin + 2.0 * np.pi * np.arange(count) / count
    np.testing.assert_allclose(at_once, series.summed(nodes), atol=1e-13)


def test_functions_that_repeat_but_for_rounding_are_recognised() -> None:
    x = 2.0 * np.pi * np.arange(64) / 64

    def repeats(*rows: np.ndarray) -> bool:
        return series_module._repeats_in_half(np.fft.rfft(np.stack(rows)))

    assert repeats(np.cos(2.0 * x), 1.0 + np.sin(8.0 * x))
    assert not repeats(np.cos(2.0 * x), np.cos(3.0 * x))
    assert repeats(np.cos(2.0 * x) + 1e-17 * np.cos(3.0 * x))
    assert not repeats(np.cos(2.0 * x) + 1e-14 * np.cos(3.0 * x))


@pytest.mark.parametrize("t", [0.0, 0.3, 0.5, 1.0 - 1e-16])
def test_weights_reproduce_polynomials_of_degree_seven(t: float) -> None:
    weights = np.array(
        [float(weight[0]) for weight in series_module._lagrange_weights(np.array([t]))]
    )
    nodes = np.arange(8.0)
    for degree in range(8):
        moment = np.sum(weights * (nodes - 3.0) ** degree)
        assert moment == pytest.approx(t**degree if degree else 1.0, abs=2e-13)


def test_tables_are_made_once_and_not_pickled() -> None:
    series = on_domain(TURN, 64, np.sin, np.cos)
    location = series.locate(np.array([1.0]))
    series.at(np.array([0]), location)
    tables = dict(series._tables)
    assert list(tables) == [0]
    series.at(np.array([0, 1]), location)
    assert series._tables[0] is tables[0]
    again = pickle.loads(pickle.dumps(series))
    assert again._tables == {}
    np.testing.assert_array_equal(again.values, series.values)
    assert again.domain == series.domain


def test_samples_cannot_be_written_to() -> None:
    series = on_domain(TURN, 64, np.sin)
    for same in (series, pickle.loads(pickle.dumps(series))):
        with pytest.raises(ValueError, match="read-only"):
            same.values[0, 0] = 1.0


@pytest.mark.parametrize("count", [8, 64])
def test_series_of_known_functions(count: int) -> None:
    """A trigonometric polynomial is exact with as many samples as it needs, on any grid."""

    def functions(x: np.ndarray) -> np.ndarray:
        return np.stack([np.ones_like(x), np.cos(3.0 * x) - 2.0 * np.sin(x), np.sin(2.0 * x + 1.0)])

    origin, period = 0.3, 2.0 * np.pi
    nodes = Domain(origin, period, True).nodes(count)
    series = Series(functions(nodes), Domain(origin, period, True))
    rows = np.arange(3)
    x = np.linspace(-50.0, 1e6, 99)
    np.testing.assert_allclose(series.at(rows, series.locate(x)), functions(x), atol=5e-14)
    np.testing.assert_allclose(series.summed(x), functions(x), atol=5e-14)
    for points in (3, 7, 8, 100):
        grid = origin + period * np.arange(points) / points
        np.testing.assert_allclose(series.uniform(rows, points), functions(grid), atol=5e-14)
    low, high = -0.4, 1.1
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    nodes = Domain(middle, half, False).nodes(count)
    assert len(nodes) == count + 1
    cubic = np.stack([nodes**3 - nodes, 1.0 / (2.0 + nodes)])
    series = Series(cubic, Domain(middle, half, False))
    x = np.concatenate([np.linspace(low, high, 33), [high - 1e-13]])
    values = series.at(np.arange(2), series.locate(x))
    np.testing.assert_allclose(values[0], x**3 - x, atol=1e-14)
    np.testing.assert_allclose(series.summed(x)[0], x**3 - x, atol=1e-14)
    assert np.max(np.abs(values[1] - 1.0 / (2.0 + x))) < (1e-5 if count == 8 else 1e-14)
