"""Events on known functions of time."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.motion.simulation.events import EventSearch, Happened, watched
from cardan_dyn.motion.simulation.forces import Named


def reading(times: list[float]) -> list[tuple[Named, Named]]:
    """A joint `a` that swings as sin t, at times."""
    both = ((math.sin(time), math.cos(time)) for time in times)
    return [(Named({"a": 0}, np.array([x])), Named({"a": 0}, np.array([v]))) for x, v in both]


def found(events: object, end: float = 10.0, steps: int = 20) -> tuple[list[Happened], float]:
    """Events in steps up to an end, and when a terminal one ended them, else nan."""
    search = EventSearch(watched(events), reading)
    times = np.linspace(0.0, end, steps + 1).tolist()
    for first, last in pairwise(times):
        stopped = search.step(first, last, reading)
        if stopped is not None:
            return search.happened, stopped
    return search.happened, math.nan


def half(time: float, position: Named, speed: Named) -> float:
    return position["a"] - 0.5


def test_both_directions_and_each_of_them() -> None:
    rises = [math.pi / 6.0, 13.0 * math.pi / 6.0]
    falls = [5.0 * math.pi / 6.0, 17.0 * math.pi / 6.0]
    for direction, expected in ((0, sorted(rises + falls)), (1, rises), (-1, falls)):
        happened, _ = found(cd.Event(half, direction=direction))
        # sin t has a slope of 0.87 there: rounding of time and value together.
        np.testing.assert_allclose([item.time for item in happened], expected, rtol=1e-15)
        assert {item.name for item in happened} == {"half"}


def test_a_terminal_event_ends_the_search_at_it() -> None:
    happened, stopped = found([cd.Event(half, terminal=True, name="stop"), lambda t: t - 0.1])
    assert stopped == happened[-1].time == pytest.approx(math.pi / 6.0, abs=1e-15)
    assert [item.name for item in happened] == ["<lambda>", "stop"]


def test_several_in_one_step_come_in_order_of_time() -> None:
    events = [cd.Event(lambda t, k=k: t - 0.1 * k, name=str(k)) for k in (3, 1, 2)]
    happened, _ = found(events, 1.0, 1)
    assert [item.name for item in happened] == ["1", "2", "3"]
    np.testing.assert_allclose([item.time for item in happened], [0.1, 0.2, 0.3], atol=1e-15)
    # One function that passes through zero more than once in a step.
    happened, _ = found(half, 3.0, 1)
    assert len(happened) == 2


@pytest.mark.parametrize("often", [7.0, 40.0, 333.0])
def test_many_zeros_within_one_step_are_all_found(often: float) -> None:
    """sin(k x) along x = sin t: an event of 240 zeros in steps of which one alone is looked at."""
    found_ones, _ = found(lambda t, x, v: math.sin(often * x["a"] + 0.1), 4.0, 1)
    levels = (np.arange(-110, 111) * math.pi - 0.1) / often
    places = np.arcsin(levels[np.abs(levels) < 1.0])
    every = np.concatenate([places, math.pi - places])
    expected = np.sort(every[(every > 0.0) & (every < 4.0)])
    assert len(expected) > 0.8 * often
    np.testing.assert_allclose([item.time for item in found_ones], expected, rtol=1e-11)


@pytest.mark.parametrize("apart", [1e-1, 1e-3, 1e-5])
def test_two_zeros_close_together_are_both_found(apart: float) -> None:
    """Beside a smooth minimum, beside a kink, and at two jumps."""
    for event in (
        lambda t: (t - 1.234) ** 2 - 0.25 * apart**2,
        lambda t: abs(t - 1.234) - 0.5 * apart,
        # Of two jumps one is seen at least.
        lambda t: (t > 1.234) - 0.5 - 2.0 * (t > 1.234 + apart) * (t < 3.0),
    ):
        times = [item.time for item in found(event, 4.0, 1)[0]][:2]
        np.testing.assert_allclose(np.diff(times), [apart], rtol=1e-9)


def test_what_touches_zero_has_not_passed_it() -> None:
    for event, is_constant in (
        (lambda t: (t - 1.234) ** 2, False),
        (lambda t: -abs(t - 1.234), False),
        (lambda t: max(0.0, t - 1.0), True),
        (lambda t: max(0.0, abs(t - 2.0) - 0.5), True),  # Exactly zero for a while.
    ):
        search = EventSearch(watched(event), reading)
        assert search.step(0.0, 4.0, reading) is None
        assert search.happened == []
        assert [" is constant between 0 and 4 s" in note for note in search.notes] == (
            [True] * is_constant
        )


@pytest.mark.parametrize("width", [0.02, 0.15])
@pytest.mark.parametrize("steps", [5, 17])
@pytest.mark.parametrize("what", ["switch", "tanh", "speed"])
def test_what_is_constant_is_looked_at_as_what_it_reads_moves(
    what: str, width: float, steps: int
) -> None:
    """Of the way of 2 from side to side, a window of 0.04 is wider than a hundredth."""
    function, phase = {
        "switch": (lambda t, x, v: 1.0 if abs(x["a"]) < width else -1.0, 0.0),
        "tanh": (lambda t, x, v: math.tanh(3e4 * (width**2 - x["a"] ** 2)), 0.0),
        "speed": (lambda t, x, v: -1.0 if abs(v["a"]) < width else 1.0, 0.5),
    }[what]
    search = EventSearch(watched(cd.Event(function, name="e")), reading)
    for first, last in pairwise(np.linspace(0.0, 20.3, steps + 1).tolist()):
        search.step(first, last, reading)
    half_width = math.asin(width)
    middles = math.pi * (np.arange(8) + phase)
    edges = np.sort(np.concatenate([middles - half_width, middles + half_width]))
    expected = edges[(edges > 0.0) & (edges < 20.3)]
    assert len(expected) >= 12
    np.testing.assert_allclose([item.time for item in search.happened], expected, rtol=1e-12)
    (note,) = search.notes
    assert "event 'e' is constant between" in note and "abs(position) - width" in note


def test_what_is_constant_costs_no_more_than_its_parts_and_is_told_once() -> None:
    counts = {"of nothing": 0, "of a switch": 0}

    def counted(name: str, value: float) -> float:
        counts[name] += 1
        return value

    events = [
        cd.Event(lambda t, x, v: counted("of nothing", 1.0), name="of nothing"),
        cd.Event(lambda t, x, v: counted("of a switch", float(x["a"] < 3.0)), name="of a switch"),
    ]
    search = EventSearch(watched(events), reading)
    for step in range(4):
        search.step(step * math.pi, (step + 1) * math.pi, reading)
    assert search.happened == []
    assert [note.split("'")[1] for note in search.notes] == ["of nothing", "of a switch"]
    # A way of 1 there and back, in hundredths: 200 places at least, of parts that are halved.
    assert counts["of nothing"] < 4 * 500
    assert 4 * 200 < counts["of a switch"] < 4 * 1500
    # Faster than any parts could follow: told as well, and bounded.
    fast = [(Named({"a": 0}, np.array([time * 1e9])), Named({}, np.zeros(0))) for time in (0.0,)]
    search, before = EventSearch(watched(events[1]), lambda times: fast), counts["of a switch"]

    def far(times: list[float]) -> list[tuple[Named, Named]]:
        return [(Named({"a": 0}, np.array([-1e9 * t])), fast[0][1]) for t in times]

    search.step(0.0, 1.0, far)
    assert counts["of a switch"] - before < 9 * 2 * 1024 + 2
    assert len(search.notes) == 1


def test_what_is_constant_because_what_it_reads_rests_is_not_told_of() -> None:
    """A joint that trembles by rounding, a speed that stays, and functions that are smooth."""

    def resting(times: list[float]) -> list[tuple[Named, Named]]:
        return [
            (
                Named({"rest": 0, "turn": 1}, np.array([1e-13 * math.sin(1e3 * time), 9.0 * time])),
                Named({"rest": 0, "turn": 1}, np.array([1e-10 * math.cos(1e3 * time), 9.0])),
            )
            for time in times
        ]

    events = [
        lambda t, x, v: 1.0 if abs(x["rest"]) < 0.1 else -1.0,
        lambda t, x, v: 1.0 if abs(v["rest"]) < 0.1 else -1.0,
        lambda t, x, v: v["turn"] - 5.0,
        lambda t, x, v: x["rest"] - 5.0,
        lambda t, x, v: x["turn"] - 5000.0,
        lambda t, x, v: abs(math.sin(x["turn"])) - 0.1,
    ]
    search = EventSearch(watched(events), resting)
    for step in range(5):
        search.step(step * 0.7, (step + 1) * 0.7, resting)
    assert search.notes == []


def test_the_finer_parts_of_one_step_begin_the_next() -> None:
    calls: list[float] = []

    def fast(time: float) -> float:
        calls.append(time)
        return math.sin(200.0 * time + 0.5)

    search = EventSearch(watched(fast), reading)
    counts = []
    for start in range(4):
        calls.clear()
        search.step(float(start), start + 1.0, reading)
        counts.append(len(calls))
    assert len(search.happened) == math.floor((800.0 + 0.5) / math.pi)
    assert counts[-1] < 0.9 * counts[0]


def test_what_changes_too_fast_is_told_once_and_costs_little_from_there_on() -> None:
    random = np.random.default_rng(0)
    calls: list[float] = []

    def noise(time: float) -> float:
        calls.append(time)
        return float(random.normal())

    search = EventSearch(watched([noise, half]), reading)
    for start in range(8):
        search.step(float(start), start + 1.0, reading)
        if start:
            assert len(calls) < 400
        calls.clear()
    (note,) = search.notes
    assert "'noise' changes so fast from 0 to 1 s" in note and "may be missing" in note
    # The others are found as ever.
    assert sum(item.name == "half" for item in search.happened) == 3


def test_what_begins_at_zero_has_not_happened() -> None:
    happened, _ = found(lambda t, x, v: x["a"], 4.0)
    np.testing.assert_allclose([item.time for item in happened], [math.pi])


@pytest.mark.parametrize("offset", [1e-16, -1e-16])
def test_what_begins_at_zero_but_for_rounding_has_not_happened(offset: float) -> None:
    happened, _ = found(lambda t, x, v: x["a"] + offset, 4.0)
    np.testing.assert_allclose([item.time for item in happened], [math.pi])


def test_a_zero_at_the_end_of_a_step_counts_once() -> None:
    happened, _ = found(lambda t: t - 0.5, 1.0, 2)
    assert [item.time for item in happened] == [0.5]


def test_functions_may_carry_attributes() -> None:
    def rising(time: float) -> float:
        return math.sin(time - 1.0)

    rising.terminal, rising.direction = True, -1  # type: ignore[attr-defined]
    (item,) = watched(rising)
    assert (item.terminal, item.direction, item.name) == (True, -1, "rising")
    assert found(rising)[1] == pytest.approx(1.0 + math.pi, abs=1e-15)


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (3, "events is 3, expected functions or Event"),
        ([3], r"events\[0\] is 3"),
        (cd.Event(half, direction=2), r"events\[0\]: direction 2; it is -1, 0 or 1"),
        (cd.Event(half, terminal="yes"), "terminal"),  # type: ignore[arg-type]
        (lambda t, x: 0.0, "a function of 2 arguments"),
    ],
)
def test_what_is_no_event_is_refused(events: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        watched(events)


@pytest.mark.parametrize("value", [math.nan, "x", None])
def test_events_return_numbers(value: object) -> None:
    function: Callable[[float], object] = lambda t: value if t > 0.4 else 1.0  # noqa: E731
    with pytest.raises(cd.ArgumentError, match=r"event .* returned .* at time 0\.\d+ s"):
        found(function, 1.0, 2)
