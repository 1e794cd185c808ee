"""Convergence: rounds of a refinement whose errors are written down by hand."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.response.convergence import Convergence

TOLERANCE = 1e-10
ROUNDING = np.full(2, 1e-12)


def errors(*values: float) -> np.ndarray:
    return np.array(values)


def first(*remainder: float) -> Convergence:
    return Convergence(TOLERANCE, errors(*remainder), ROUNDING)


def test_the_first_round_cannot_have_stalled() -> None:
    convergence = first(1e-9, 3e-9)
    assert convergence.greatest_remainder == convergence.error == 3e-9
    assert not convergence.has_stalled
    assert not convergence.may_end
    assert not convergence.is_reached
    assert not convergence.is_hopeless


def test_a_remainder_below_the_tolerance_ends_once_deviations_agree() -> None:
    convergence = first(1e-11, 1e-10)
    assert convergence.may_end
    assert not convergence.is_reached
    measured = convergence.with_deviation(errors(5e-11, 2e-11))
    assert measured.is_reached
    assert measured.error == 1e-10
    assert measured.with_deviation(errors(5e-10, 0.0)).error == 5e-10


def test_a_greatest_deviation_above_the_tolerance_asks_for_more_samples() -> None:
    convergence = first(1e-11, 1e-11).with_deviation(errors(1e-11, 1e-9))
    assert not convergence.is_reached
    # It was measured for the first time, so that nothing is known of its decay.
    assert not convergence.deviation_has_stalled
    assert not convergence.is_hopeless


@pytest.mark.parametrize(("later", "stalled"), [(1e-9, False), (1.01e-9, True), (5e-9, True)])
def test_a_remainder_has_stalled_where_a_doubling_leaves_half_of_it(
    later: float, stalled: bool
) -> None:
    convergence = first(2e-9, 0.0).next_round(errors(0.0, later), ROUNDING)
    assert convergence.previous_remainder == 2e-9
    assert convergence.has_stalled == stalled
    assert convergence.is_hopeless == stalled


def test_a_great_remainder_that_falls_slowly_is_not_rounding() -> None:
    convergence = first(2e-3, 0.0).next_round(errors(1.9e-3, 0.0), ROUNDING)
    assert not convergence.has_stalled
    assert not convergence.is_hopeless


def test_a_stalled_remainder_may_end_where_rounding_explains_it() -> None:
    rounding = errors(1e-9, 2e-9)
    explained = first(1e-9, 2e-9).next_round(errors(1e-9, 2e-9), rounding)
    assert explained.is_rounded
    assert explained.may_end
    assert not explained.is_below_tolerance
    assert explained.with_deviation(errors(1e-9, 2e-9)).is_reached
    # Rounding of each function explains its own error only.
    swapped = first(1e-9, 2e-9).next_round(errors(2e-9, 1e-9), rounding)
    assert swapped.has_stalled
    assert not swapped.is_rounded
    assert not explained.with_deviation(errors(2e-9, 1e-9)).is_reached


def test_a_deviation_that_does_not_fall_is_hopeless() -> None:
    """Too few samples are not its cause, whatever the remainder says."""
    measured = first(1e-11, 0.0).with_deviation(errors(4e-9, 0.0))
    falls = measured.next_round(errors(1e-20, 0.0), ROUNDING).with_deviation(errors(2e-9, 0.0))
    assert falls.previous_deviation == 4e-9
    assert not falls.is_hopeless
    stalls = falls.next_round(errors(1e-21, 0.0), ROUNDING).with_deviation(errors(1.1e-9, 0.0))
    assert stalls.deviation_has_stalled
    assert stalls.is_hopeless


def test_rounds_without_measurement_keep_the_last_measured_deviation() -> None:
    measured = first(1e-11, 0.0).with_deviation(errors(4e-9, 0.0))
    unmeasured = measured.next_round(errors(1e-9, 0.0), ROUNDING)
    assert unmeasured.greatest_deviation == 0.0
    assert not unmeasured.deviation_has_stalled
    assert unmeasured.next_round(errors(1e-11, 0.0), ROUNDING).previous_deviation == 4e-9


def test_no_functions_at_all_are_exact() -> None:
    nothing = np.zeros(0)
    convergence = Convergence(TOLERANCE, nothing, nothing)
    assert convergence.may_end
    assert convergence.with_deviation(nothing).is_reached
    assert convergence.error == 0.0
