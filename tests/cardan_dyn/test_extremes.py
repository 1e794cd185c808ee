"""Extremes of functions known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.kit.extremes import greatest, peak, turns


@pytest.mark.parametrize("count", [16, 17])
def test_the_greatest_value_of_a_period_and_its_place(count: int) -> None:
    places = np.array([0.0, 0.02, 0.3, 0.77, 0.999])
    turn = 2.0 * np.pi * (np.arange(count)[:, None] / count - places)
    top, at = greatest(1.5 + np.cos(turn) + 0.25 * np.cos(3.0 * turn))
    np.testing.assert_allclose(top, 2.75, rtol=1e-15)
    np.testing.assert_allclose(np.exp(2j * np.pi * (at - places)), 1.0, atol=1e-7)


def test_of_two_peaks_that_hardly_differ_it_is_the_higher_one() -> None:
    # Half a step beside samples the second one is 1e-4 higher, though no sample shows it.
    def wave(x: np.ndarray) -> np.ndarray:
        at = 2.0 * np.pi * x
        return np.cos(2.0 * (at - 0.5)) - 1e-4 * np.cos(at - 0.5)

    top, at = greatest(wave(np.arange(7) / 7)[:, None])
    assert top == pytest.approx(wave(np.linspace(0.0, 1.0, 100_001)).max(), rel=1e-9)
    assert at == pytest.approx((0.5 + np.pi) / (2.0 * np.pi), abs=1e-7)


def test_the_greatest_of_constants_and_of_none() -> None:
    assert greatest(np.full((6, 2), -3.0))[0].tolist() == [-3.0, -3.0]
    assert greatest(np.zeros((0, 2)))[0].tolist() == [0.0, 0.0]


def test_cubics_turn_where_they_are_flat_to_fourth_order() -> None:
    missed = []
    for count in (10, 20, 40):
        at = np.cumsum(np.r_[0.0, np.resize([1.0, 1.3], count)]) * (3.0 / (1.15 * count))
        places, values = turns(at, np.sin(at), np.cos(at))
        best = int(values.argmax())
        assert places[best] == pytest.approx(0.5 * np.pi, abs=0.02)
        assert at[best] <= places[best] <= at[best + 1]
        missed.append(abs(1.0 - values[best]))
    assert max(missed) < 1e-4
    assert missed[-1] < missed[0] / 60.0


def test_of_samples_between_which_nothing_turns_it_is_the_first() -> None:
    at = np.array([0.0, 1.0, 3.0])
    places, values = turns(at, at[:, None] ** 2, 2.0 * at[:, None])
    assert (places.tolist(), values.tolist()) == ([[0.0], [1.0]], [[0.0], [1.0]])


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e6])
def test_a_peak_is_found_in_parts_of_the_distance(scale: float) -> None:
    # However far from zero the places are, and however short the way between them.
    start = 1000.0
    place, top = peak(lambda at: -(((at - start) / scale - 0.3) ** 4), start, start + scale)
    assert (place - start) / scale == pytest.approx(0.3, abs=1e-2)
    assert top == pytest.approx(0.0, abs=1e-10)


def test_a_peak_at_an_end_or_with_an_edge_is_found() -> None:
    # To the root of 1e-12 of the distance.
    assert peak(lambda at: at, 1.0, 2.0)[0] == pytest.approx(2.0, abs=1e-6)
    assert peak(lambda at: -abs(at - 1.7), 2.0, 1.0)[0] == pytest.approx(1.7, abs=1e-6)


def test_what_is_known_stays_unless_something_is_greater() -> None:
    assert peak(lambda at: -at * at, -1.0, 1.0, (0.0, 0.0)) == (0.0, 0.0)
    assert peak(lambda at: -at * at, -1.0, 1.0, (0.5, -0.25))[0] == pytest.approx(0.0, abs=1e-6)
