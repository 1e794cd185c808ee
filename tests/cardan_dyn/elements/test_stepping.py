"""Passages: a swing, whose zeros are known, and what cannot be integrated."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.integrate import DOP853

from cardan_dyn.core.elements.stepping import Stepper, advance, first_fall, on_step
from cardan_dyn.kit.errors import SimulationError

TIGHT = {"rtol": 1e-13, "atol": np.full(2, 1e-15)}


def swing(_: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -y[0]])


def test_the_end_is_located_to_rounding() -> None:
    found = advance(swing, 0.0, np.array([0.0, 1.0]), 10.0, [lambda _, y: float(y[0])], **TIGHT)
    assert found.event == 0
    assert found.time == pytest.approx(np.pi, rel=1e-13)
    assert found.state == pytest.approx([0.0, -1.0], abs=1e-12)


def test_the_first_of_several_ends_it() -> None:
    watches = [lambda _, y: float(y[0]), lambda _, y: 0.5 - float(y[0]), lambda t, _: 2.0 - t]
    found = advance(swing, 0.0, np.array([0.0, 1.0]), 10.0, watches, **TIGHT)
    assert found.event == 1
    assert found.time == pytest.approx(np.pi / 6.0, rel=1e-13)


def test_time_is_up() -> None:
    found = advance(swing, 1.0, np.array([0.0, 1.0]), 2.0, [lambda _, y: float(y[0])], **TIGHT)
    assert found.event is None
    assert (found.time, found.steps[-1].end) == (2.0, 2.0)
    assert found.state == pytest.approx([np.sin(1.0), np.cos(1.0)], abs=1e-12)
    assert advance(swing, 2.0, np.ones(2), 2.0, [], **TIGHT).steps == []


def test_what_falls_at_once_ends_at_the_start() -> None:
    found = advance(swing, 0.0, np.array([0.0, -1.0]), 10.0, [lambda _, y: float(y[0])], **TIGHT)
    assert (found.event, found.time) == (0, 0.0)
    assert found.state.tolist() == [0.0, -1.0]


def test_what_starts_below_zero_by_rounding_may_rise_first() -> None:
    found = advance(
        swing, 0.0, np.array([0.0, 1.0]), 10.0, [lambda _, y: float(y[0]) - 1e-13], **TIGHT
    )
    assert found.event == 0
    assert found.time == pytest.approx(np.pi, rel=1e-12)


def test_what_rises_for_less_than_a_place_is_found() -> None:
    """Positive for 1e-9 s, where the first step is far longer."""
    found = advance(
        lambda _, y: np.array([1.0]),
        0.0,
        np.zeros(1),
        1.0,
        [lambda t, y: float(y[0]) * (1e-9 - float(y[0]))],
        rtol=1e-9,
        atol=np.ones(1),
    )
    assert found.time == pytest.approx(1e-9, rel=1e-12)


def test_states_within_steps() -> None:
    found = advance(swing, 0.0, np.array([0.0, 1.0]), 6.0, [], **TIGHT)
    for step in found.steps[:5]:
        time = 0.3 * step.start + 0.7 * step.end
        exact = [np.sin(time), np.cos(time)]
        assert on_step(swing, step, time) == pytest.approx(exact, abs=1e-13)
        assert step.dense(time) == pytest.approx(exact, abs=1e-11)
        assert on_step(swing, step, step.start) is step.first


def test_rows_within_steps_are_those_of_scipy() -> None:
    y = np.array([0.0, 1.0])
    stepper, time, rate = Stepper(swing, 6.0, **TIGHT), 0.0, swing(0.0, y)
    while time < 6.0:
        step = stepper.take(time, y, rate)
        scipys = DOP853(swing, time, y, 6.0, first_step=step.end - time, rtol=1e3, atol=1e300)
        scipys.step()
        dense = scipys.dense_output()
        for place in np.linspace(step.start, step.end, 7).tolist():
            # Some roundings of rows whose size is 1.
            assert step.dense(place) == pytest.approx(dense(place), abs=2e-15)
        time, y, rate = step.end, step.last, step.rate
        np.testing.assert_array_equal(rate, swing(time, y))


def forced(time: float, y: np.ndarray) -> np.ndarray:
    """Stiff enough at 0.5 s that steps are missed there."""
    return np.array([y[1], -y[0] - y[1] + np.exp(-((20.0 * (time - 0.5)) ** 2))])


@pytest.mark.parametrize("longest", [np.inf, 0.05])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9])
def test_steps_are_those_of_scipy(rtol: float, longest: float) -> None:
    y, asked = np.array([1.0, 2.0]), {"rtol": rtol, "atol": 1e-3 * np.ones(2) * rtol}
    scipys = DOP853(forced, 0.0, y, 2.0, max_step=longest, **asked)
    time, missed = 0.0, 0
    while time < 2.0:
        # Lengths are powers of errors, whose rounding would add up over steps.
        length = scipys.h_abs if time else None
        stepper = Stepper(forced, 2.0, longest=longest, length=length, **asked)
        step = stepper.take(time, y, forced(time, y))
        before = scipys.nfev
        scipys.step()
        missed += scipys.nfev - before > 12
        assert step.end == pytest.approx(scipys.t, rel=1e-6)
        assert step.last == pytest.approx(scipys.y, rel=1e-8)
        time, y = scipys.t, scipys.y
    assert missed or longest < 1.0
    assert scipys.status == "finished"


def test_steps_and_rows_within_are_of_their_order() -> None:
    y, ends, within = np.array([0.0, 1.0]), [], []
    for length in (1.0, 0.5):
        stepper = Stepper(swing, np.inf, rtol=1e3, atol=1e300, length=length)
        step = stepper.take(0.0, y, swing(0.0, y))
        assert step.end == length
        ends.append(np.max(np.abs(step.last - [np.sin(length), np.cos(length)])))
        places = length * np.linspace(0.1, 0.9, 9)
        rows = np.array([step.dense(place) for place in places.tolist()])
        within.append(np.max(np.abs(rows - np.array([np.sin(places), np.cos(places)]).T)))
    # Of one step: one order more than over all steps.
    assert np.log2(ends[0] / ends[1]) == pytest.approx(9.0, abs=0.3)
    assert np.log2(within[0] / within[1]) == pytest.approx(8.0, abs=0.4)


def test_a_step_takes_twelve_derivatives_and_three_more_where_rows_within_are_read() -> None:
    calls = []

    def counted(time: float, y: np.ndarray) -> np.ndarray:
        calls.append(time)
        return swing(time, y)

    y = np.array([0.0, 1.0])
    stepper = Stepper(counted, 6.0, rtol=1e-9, atol=1e-12, length=0.1)
    step = stepper.take(0.0, y, swing(0.0, y))
    assert len(calls) == 11
    step.dense(0.05)
    # That at its end is the first of the next step.
    assert len(calls) == 15
    assert step.rate is not None
    np.testing.assert_array_equal(step.rate, swing(step.end, step.last))


def test_rows_lead_smoothly_to_one_at_the_end_that_was_changed() -> None:
    stepper = Stepper(swing, 6.0, **TIGHT)
    step = stepper.take(0.0, np.array([0.0, 1.0]), np.array([1.0, 0.0]))
    step.last = step.last + 1e-3
    for part, gap in ((0.0, 0.0), (0.5, 5e-4), (1.0, 1e-3)):
        time = part * step.end
        exact = np.array([np.sin(time), np.cos(time)]) + gap
        assert step.dense(time) == pytest.approx(exact, abs=1e-13)
        assert pickle.loads(pickle.dumps(step)).dense(time) == pytest.approx(exact, abs=1e-13)


def test_what_cannot_be_integrated_says_when() -> None:
    with pytest.raises(SimulationError, match="could not be integrated beyond 1") as caught:
        advance(lambda _, y: y * y, 0.0, np.ones(1), 2.0, [], rtol=1e-9, atol=np.ones(1))
    assert caught.value.time == pytest.approx(1.0, abs=1e-3)


def test_first_falls() -> None:
    times = [0.0, 1.0, 2.0, 3.0]
    assert first_fall(lambda t: 1.5 - t, times) == pytest.approx(1.5)
    assert first_fall(lambda t: 1.0 + t, times) == np.inf
    # It begins at a zero, from which it rises.
    assert first_fall(lambda t: t * (2.5 - t), times) == pytest.approx(2.5)
    # Below zero between two of the times.
    assert first_fall(lambda t: (t - 1.1) ** 2 - 0.0025, times) == pytest.approx(1.05)
    # It fell before.
    assert first_fall(lambda t: -t, times) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("length", [1.0, 1e-4, 1e-8])
def test_a_dip_below_zero_is_found_however_short_the_step(length: float) -> None:
    begin = 0.7
    times = [begin + length * part / 5.0 for part in range(6)]
    found = first_fall(lambda t: ((t - begin) / length - 0.47) ** 2 - 1e-4, times)
    assert (found - begin) / length == pytest.approx(0.46, abs=1e-7)


def test_errors_beyond_all_numbers_are_not_taken_for_none() -> None:
    """Where the square of one estimate overflows alone, their quotient would be zero."""
    for power in np.arange(150.0, 156.0, 0.25):
        stepper = Stepper(
            lambda t, y: np.cos(40.0 * t) + 0.0 * y, 10.0, rtol=0.0, atol=10.0**-power, length=1.0
        )
        with np.errstate(over="ignore", invalid="ignore"):
            step = stepper.take(0.0, np.zeros(1), np.ones(1))
        assert isinstance(step, str) or step.end < 0.1
