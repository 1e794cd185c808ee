"""Domains: their samples against NumPy's Chebyshev points, phases against exact arithmetic."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import chebyshev

from cardan_dyn.core.response.domain import Domain

modest = settings(max_examples=60, deadline=None, derandomize=True)

TURN = 2.0 * np.pi
PERIOD = Domain(0.3, TURN, True)
RANGE = Domain(0.5, 2.0, False)


def test_intervals() -> None:
    assert PERIOD.interval == (-np.inf, np.inf)
    assert RANGE.interval == (-1.5, 2.5)


@pytest.mark.parametrize("steps", [8, 10, 128])
def test_nodes_of_a_range_are_chebyshev_points(steps: int) -> None:
    nodes = RANGE.nodes(steps)
    assert RANGE.steps(len(nodes)) == steps
    # The samples go down from the upper end, Chebyshev's points as NumPy gives them go up.
    expected = 0.5 + 2.0 * chebyshev.chebpts2(steps + 1)[::-1]
    np.testing.assert_allclose(nodes, expected, atol=1e-15)
    assert (nodes[0], nodes[-1]) == (2.5, -1.5)
    symmetric = Domain(0.0, 2.0, False).nodes(steps)
    np.testing.assert_array_equal(symmetric, -symmetric[::-1])


def test_nodes_of_a_period_are_equal_steps() -> None:
    nodes = PERIOD.nodes(12)
    assert PERIOD.steps(len(nodes)) == 12
    np.testing.assert_allclose(nodes, np.linspace(0.3, 0.3 + TURN, 13)[:-1], rtol=1e-15)


@pytest.mark.parametrize("domain", [PERIOD, RANGE, Domain(-1e3, 0.1, False)], ids=str)
@pytest.mark.parametrize("steps", [8, 24, 128])
def test_twice_the_steps_keep_every_node_to_the_last_digit(domain: Domain, steps: int) -> None:
    np.testing.assert_array_equal(domain.nodes(2 * steps)[::2], domain.nodes(steps))


@pytest.mark.parametrize("domain", [PERIOD, RANGE], ids=str)
def test_nodes_lie_at_their_share(domain: Domain) -> None:
    nodes = domain.nodes(64)
    np.testing.assert_allclose(domain.at_share(np.arange(len(nodes)) / 64), nodes, atol=1e-15)


def test_the_circle_of_a_range_runs_down_and_up_again() -> None:
    values = np.array([[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]])
    expected = [[1.0, 2.0, 3.0, 4.0, 3.0, 2.0], [5.0, 6.0, 7.0, 8.0, 7.0, 6.0]]
    np.testing.assert_array_equal(RANGE.on_circle(values), expected)
    np.testing.assert_array_equal(PERIOD.on_circle(values), values)


@pytest.mark.parametrize("domain", [PERIOD, RANGE], ids=str)
def test_phases_of_nodes_are_equal_steps_of_the_circle(domain: Domain) -> None:
    circle = 64 if domain.periodic else 128
    nodes = domain.nodes(64)
    np.testing.assert_allclose(domain.phase(nodes), np.arange(len(nodes)) / circle, atol=1e-15)


@modest
@given(share=st.floats(1e-12, 1.0))
def test_phases_near_the_ends_of_a_range_keep_their_digits(share: float) -> None:
    """At 1 - x of half the range the phase is the arc cosine, of about √(2x)."""
    domain = Domain(0.0, 1.0, False)
    position = 1.0 - share
    # The distance from the end is exact; its rounding in `position` belongs to the argument.
    exact = mpmath.acos(mpmath.mpf(position)) / (2 * mpmath.pi)
    assert float(domain.phase(np.array([position]))[0]) == pytest.approx(float(exact), rel=1e-14)


def test_positions_beyond_a_range_are_taken_for_its_ends() -> None:
    np.testing.assert_array_equal(RANGE.phase(np.array([2.5001, 99.0])), [0.0, 0.0])
    np.testing.assert_array_equal(RANGE.phase(np.array([-1.5001, -99.0])), [0.5, 0.5])


@modest
@given(
    position=st.floats(-1e9, 1e9),
    turns=st.integers(1, 7),
    origin=st.floats(-10.0, 10.0),
)
def test_phases_of_whole_turns_are_exact_at_any_size(
    position: float, turns: int, origin: float
) -> None:
    domain = Domain(origin, TURN * turns, True)
    phase = float(domain.phase(np.array([position]))[0])
    assert 0.0 <= phase < 1.0
    with mpmath.workdps(60):
        exact = (mpmath.mpf(position) - mpmath.mpf(origin)) / (2 * mpmath.pi * turns)
        difference = mpmath.mpf(phase) - exact
        assert abs(difference - mpmath.nint(difference)) < 4e-15


@modest
@given(position=st.floats(-1e3, 1e3))
def test_phases_of_other_periods_repeat(position: float) -> None:
    """A period of less than half a turn is no multiple of turns."""
    domain = Domain(0.1, 1.7, True)
    phase = float(domain.phase(np.array([position]))[0])
    assert 0.0 <= phase < 1.0
    periods = (position - 0.1) / 1.7 - phase
    assert periods == pytest.approx(round(periods), abs=1e-12)


def test_a_phase_never_rounds_to_one() -> None:
    origin = Domain(0.0, TURN, True)
    tiny = np.array([-1e-300, -1e-20, -1e-17, -1e-16])
    phases = origin.phase(tiny)
    assert np.all((phases >= 0.0) & (phases < 1.0))
    assert origin.phase(np.zeros(0)).shape == (0,)
