"""Steps are the same with the compiled function and without it."""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pytest

from cardan_dyn.core import compiled
from cardan_dyn.core.elements.stepping import Step, Stepper, Traced
from cardan_dyn.core.tape import Program, Trace, machine_is_at_hand, sin

pytestmark = pytest.mark.skipif(
    compiled.kernel is None, reason="the compiled functions are not built"
)
EPS = np.finfo(float).eps
ROW = np.array([0.3, -1.2, 2.0])


def rate(time: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -np.sin(y[0]) + 0.1 * np.cos(time), -y[2] * y[0]])


def taken(
    derivative: Callable[[float, np.ndarray], np.ndarray] = rate,
    atol: np.ndarray | float = 1e-9,
    row: np.ndarray = ROW,
) -> list[Step | str]:
    """Return five steps one behind the other, as far as they lead."""
    stepper = Stepper(derivative, 9.0, rtol=1e-8, atol=atol)
    steps, time = [], 0.0
    for _ in range(5):
        steps.append(stepper.take(time, row, rate(time, row)))
        if isinstance(steps[-1], str):
            break
        steps[-1].rate = rate(steps[-1].end, steps[-1].last)
        time, row = steps[-1].end, steps[-1].last
    return steps


@pytest.mark.parametrize("atol", [1e-9, np.array([1e-9, 1e-7, 1e-10])], ids=["one", "each"])
def test_steps_agree(atol: np.ndarray | float, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = taken(atol=atol)
    with monkeypatch.context() as without:
        without.setattr(compiled, "kernel", None)
        others = taken(atol=atol)
    for ours, theirs in zip(steps, others, strict=True):
        assert ours.end == pytest.approx(theirs.end, rel=1e-4)
        middle = 0.5 * (ours.start + ours.end)
        assert ours.dense(middle) == pytest.approx(theirs.dense(middle), rel=1e-6)
    # Lengths follow errors, small differences. That of the first one is the same.
    assert steps[0].last == pytest.approx(others[0].last, rel=8.0 * EPS)


@pytest.mark.parametrize("spread", [slice(None, None, 2), slice(None, None, -1)])
def test_rates_may_be_parts_of_arrays(spread: slice) -> None:
    def spread_out(time: float, y: np.ndarray) -> np.ndarray:
        whole = np.zeros(5 if spread.step == 2 else 3)
        whole[spread] = rate(time, y)
        return whole[spread]

    assert taken(spread_out)[0].last.tolist() == taken()[0].last.tolist()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_leads_beyond_all_numbers_fails_alike(
    value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def beyond(time: float, y: np.ndarray) -> np.ndarray:
        return rate(time, y) * (value if time > 0.0 else 1.0)

    with np.errstate(all="ignore"):
        found = taken(beyond)
        monkeypatch.setattr(compiled, "kernel", None)
        assert found == taken(beyond)
    assert "shorter than numbers are apart" in found[0]


def test_errors_of_rates_are_passed_on() -> None:
    def fails(time: float, y: np.ndarray) -> np.ndarray:
        if time > 0.0:
            raise ArithmeticError("here")
        return rate(time, y)

    stepper = Stepper(fails, 9.0, rtol=1e-8, atol=1e-9, length=0.1)
    with pytest.raises(ArithmeticError, match="here"):
        stepper.take(0.0, ROW, rate(0.0, ROW))


@pytest.mark.parametrize("wrong", [np.zeros(2), np.zeros((3, 1)), np.zeros(3, dtype=int), None])
def test_other_rates_are_refused(wrong: np.ndarray | None) -> None:
    stepper = Stepper(lambda time, y: wrong, 9.0, rtol=1e-8, atol=1e-9, length=0.1)
    with pytest.raises((TypeError, ValueError)):
        stepper.take(0.0, ROW, rate(0.0, ROW))


def test_a_step_takes_few_calls() -> None:
    """No Python between its stages."""
    counted = 0

    def count(frame: object, event: str, argument: object) -> None:
        nonlocal counted
        counted += event in ("call", "c_call")

    stepper, at_start = Stepper(np.multiply, 9.0, rtol=1e-8, atol=1e-9, length=0.01), np.ones(3)
    stepper.take(0.0, at_start, at_start)
    sys.setprofile(count)
    stepper.take(0.0, at_start, at_start)
    sys.setprofile(None)
    assert counted < 25


def pendulum(time: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -np.sin(y[0])])


def program(doubt: float) -> Program:
    """The same as a program with an input that it ignores, and doubts beyond an angle."""
    trace = Trace()
    x, v, _ = (trace.input(name, 1.0) for name in "xvz")
    return Program(trace, [v, -sin(x), x * doubt, x * doubt], keeps_inputs=True)


@pytest.mark.skipif(not machine_is_at_hand(), reason="no machine is compiled here")
@pytest.mark.parametrize("doubt", [0.0, 1.9])
def test_programs_give_rates_where_they_suit(doubt: float) -> None:
    row, asked, counts = np.array([0.5, 1.0]), [], []

    def derivative(time: float, y: np.ndarray) -> np.ndarray:
        asked.append(time)
        return pendulum(time, y)

    traced = program(doubt)
    given = traced.single, np.zeros(3), np.empty(4)

    def step(**by: object) -> Step | str:
        stepper = Stepper(derivative, 9.0, rtol=1e-8, atol=1e-9, length=0.1, **by)
        return stepper.take(0.0, row, pendulum(0.0, row))

    found = step(traced=lambda: Traced(given, counts.append))
    by_program, by_function = sum(counts), len(asked)
    expected = step()
    assert found.end == expected.end
    np.testing.assert_allclose(found.last, expected.last, rtol=4.0 * EPS)
    # From half of a radian on the angle grows.
    assert by_program + by_function == len(asked) - by_function
    assert by_function == 0 if not doubt else 0 < by_program < len(asked) - by_function


@pytest.mark.skipif(not machine_is_at_hand(), reason="no machine is compiled here")
@pytest.mark.parametrize("sizes", [(1, 4), (3, 3)])
def test_programs_of_other_rows_are_refused(sizes: tuple[int, int]) -> None:
    given = program(0.0).single, np.zeros(sizes[0]), np.empty(sizes[1])
    stepper = Stepper(
        pendulum, 9.0, rtol=1e-8, atol=1e-9, length=0.1, traced=lambda: Traced(given, print)
    )
    with pytest.raises(ValueError, match="not one of these rows"):
        stepper.take(0.0, np.array([0.5, 1.0]), np.array([1.0, 0.0]))


def test_one_lane_is_what_rows_of_it_give() -> None:
    traced, row = program(2.0), np.array([0.4, -0.3, 7.0])
    np.testing.assert_array_equal(traced.of_one()(row), traced.run_rows([row[:, None]], 1)[:, 0])
