"""Differences, against derivatives in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.kit.differences import displacements, kinks, slope, slopes


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_derivatives_keep_twelve_digits_in_the_units_of_each_variable(scale: float) -> None:
    units = np.array([scale, 3.0])
    place = np.array([0.4 * scale, 1.2])

    def values(ways: np.ndarray) -> np.ndarray:
        x, y = (place + ways).T / units[:, None]
        return np.stack([np.stack([np.sin(x), x * y], 1), np.stack([np.exp(y), 1.0 + 0 * x], 1)], 1)

    x, y = place / units
    exact = np.array([[[np.cos(x), 0.0], [y, x]], [[0.0, np.exp(y)], [0.0, 0.0]]]) / units
    found = slopes(values(displacements(units)), units)
    np.testing.assert_allclose(found * units, exact * units, rtol=1e-12, atol=1e-12)


def test_a_quartic_has_no_error_but_rounding() -> None:
    unit = np.ones(1)
    (found,) = slopes((2.0 + displacements(unit)[:, 0]) ** 4, unit)
    assert found == pytest.approx(32.0, rel=1e-11)


@pytest.mark.parametrize("scale", [1e-6, 1.0])
@pytest.mark.parametrize("beside", [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5])
def test_kinks_are_seen_wherever_they_lie_between_the_places(beside: float, scale: float) -> None:
    """A slope changes by 2 at a place: a twelfth to one is left of it."""
    units = np.array([scale])
    ways = displacements(units)
    (step,) = np.abs(ways[1])

    def law(way: np.ndarray) -> np.ndarray:
        return np.abs(way - beside * step) + 3.0 * way + way**2

    (left,) = kinks(law(ways[:, 0]), law(np.zeros(1))[0], units)
    assert 1.0 / 12.0 - 1e-9 <= left <= 1.0


def test_smooth_functions_have_no_kinks() -> None:
    units = np.array([1.0, 0.2])
    place = np.array([0.3, 0.7])

    def law(ways: np.ndarray) -> np.ndarray:
        x, y = (place + ways).T
        return np.stack([np.sin(x) * np.exp(y), x * y**2], axis=1)

    left = kinks(law(displacements(units)), law(np.zeros((1, 2)))[0], units)
    assert left.shape == (2, 2)
    assert np.max(left) < 1e-6


def test_steps_of_a_slope_suit_what_changes_within_less_than_a_step() -> None:
    narrow = np.array([1.0, 1e-2, 1e-4])
    found = slope(
        lambda places: np.stack(
            [[np.arctan((by + narrow) / narrow), np.exp(by - narrow)] for by in places]
        )
    )
    expected = [0.5 / narrow, np.exp(-narrow)]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_slope_beside_a_kink_is_that_of_its_own_side() -> None:
    beside = np.array([1e-2, 1e-4, -1e-4, 1e-6, -1e-6])
    found = slope(lambda places: np.abs(places[:, None] + beside)[:, None])
    np.testing.assert_allclose(found, [np.sign(beside)], rtol=1e-7)


def test_a_slope_of_what_is_left_of_others_is_as_good_as_theirs() -> None:
    """Steps are halved on, and among many that rounding has the better of, some agree by chance."""
    rng = np.random.default_rng(0)
    (at, arm), rate = rng.uniform(20.0, 40.0, (2, 2000, 1)), rng.uniform(1.0, 4.0, (2000, 1))
    found = slope(
        lambda places: np.stack(
            [(at + rate * by) * (arm + 0.1) - arm * (at + rate * by) - 0.1 * at for by in places]
        )
    )
    np.testing.assert_allclose(found, 0.1 * rate, rtol=0, atol=1e-8)


def test_a_slope_of_what_does_not_change_is_exactly_zero() -> None:
    assert not slope(lambda places: np.array([[[0.1, 1.0 / 3.0]]] * len(places))).any()
