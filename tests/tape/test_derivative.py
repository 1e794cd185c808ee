"""Derivatives: against mpmath at 50 digits, forwards against backwards."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import mpmath
import numpy as np
import pytest
from testkit import arithmetic

from cardan_dyn.core import tape
from cardan_dyn.core.tape import Program, Trace, Variable, derivatives, gradient
from cardan_dyn.kit import errors

SMOOTH = ["add", "subtract", "multiply", "divide", "negative", "sin", "cos", "tanh", "arctan2"]
FUNCTIONS = {**arithmetic.EXACT, **arithmetic.LIBRARY}


def in_digits(operation: str, operands: list[Any]) -> Any:
    return arithmetic.IN_DIGITS[operation](*operands)


def exact_slopes(function: Callable[[list[Any]], Any], at: list[Any]) -> list[Any]:
    """Return derivatives by each variable, from differences in many digits."""
    return [
        mpmath.diff(lambda t, k=k: function([*at[:k], t, *at[k + 1 :]]), at[k])
        for k in range(len(at))
    ]


@pytest.mark.parametrize("operation", FUNCTIONS)
def test_the_derivative_of_each_operation_is_exact(operation: str) -> None:
    rng = np.random.default_rng(5)
    count, function = FUNCTIONS[operation]
    trace = Trace()
    x = [trace.input(f"x{k}", 1.0) for k in range(count)]
    y = function(*x)
    (forward,) = derivatives([y], x)
    graphs = [Program(trace, row).graph for row in (forward, gradient(y, x))]
    for _ in range(5):
        values = rng.uniform(0.2, 2.0, count)
        if operation in ("select", "absolute", "sin", "arctan2"):
            values *= rng.choice([-1.0, 1.0], count)
        inputs = {f"x{k}": float(value) for k, value in enumerate(values)}
        with mpmath.workdps(arithmetic.DIGITS):
            operands = [mpmath.mpf(value) for value in inputs.values()]
            exact = exact_slopes(partial(in_digits, operation), operands)
            for graph in graphs:
                for found, right in zip(arithmetic.of_graph(graph, inputs), exact, strict=True):
                    assert abs(found - right) <= 1e-20


def values_of(text: arithmetic.Text, operands: list[Any]) -> list[Any]:
    """Return what each step gives in many digits."""
    values = list(operands)
    for operation, taken in text.steps:
        values.append(in_digits(operation, [values[x] if type(x) is int else x for x in taken]))
    return values[text.inputs :]


@pytest.mark.parametrize("seed", range(6))
def test_derivatives_of_random_texts_agree_with_mpmath(seed: int) -> None:
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 25, inputs=3, operations=SMOOTH)
    trace, steps = text.traced()
    x = list(trace.inputs.values())
    outputs = steps[-3:]
    forward = derivatives(outputs, x)
    backward = [gradient(y, x) for y in outputs]
    assert len(forward) == 3
    assert {len(row) for row in forward} == {3}
    inputs = {f"x{k}": float(value) for k, value in enumerate(rng.uniform(0.3, 2.0, 3))}
    entries = [entry for rows in (forward, backward) for row in rows for entry in row]
    found = arithmetic.of_graph(Program(trace, entries).graph, inputs)
    with mpmath.workdps(arithmetic.DIGITS):
        operands = [mpmath.mpf(value) for value in inputs.values()]
        exact = [
            slope
            for i in range(3)
            for slope in exact_slopes(lambda x, i=i: values_of(text, x)[i - 3], operands)
        ]
        for value, right in zip(found, [*exact, *exact], strict=True):
            assert abs(value - right) <= 1e-18 * (1 + abs(right))


def test_derivatives_of_derivatives() -> None:
    trace = Trace()
    x, y = trace.input("x", 1.0), trace.input("y", 1.0)
    f = tape.sin(x * y) / (x + y * y)
    slopes = gradient(f, [x, y])
    (xx, xy), (yx, yy) = derivatives(slopes, [x, y])
    found = arithmetic.of_graph(Program(trace, [xx, xy, yx, yy]).graph, {"x": 0.7, "y": -1.3})
    with mpmath.workdps(arithmetic.DIGITS):
        at = (mpmath.mpf(0.7), mpmath.mpf(-1.3))
        exact = [
            mpmath.diff(lambda a, b: mpmath.sin(a * b) / (a + b * b), at, order)
            for order in ((2, 0), (1, 1), (1, 1), (0, 2))
        ]
        for value, right in zip(found, exact, strict=True):
            assert abs(value - right) <= 1e-12


def test_what_does_not_depend_is_a_structural_zero() -> None:
    trace = Trace()
    x, y = trace.input("x", 1.0), trace.input("y", 1.0)
    rows = derivatives([x * x, tape.sin(y), 3.0, x], [x, y])
    assert [[tape.is_zero(entry) for entry in row] for row in rows] == [
        [False, True],
        [True, False],
        [True, True],
        [False, True],
    ]
    assert rows[3][0] == 1.0
    assert gradient(2.0, [x]) == [0.0]
    assert gradient(y, [x, y]) == [0.0, 1.0]
    assert derivatives([x, y], []) == [[], []]
    assert derivatives([], [x]) == []
    assert derivatives([3.0], []) == [[]]


def test_derivatives_with_respect_to_what_is_between() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    y = tape.sin(x)
    z = y * y
    for slopes in (derivatives([z], [y])[0], gradient(z, [y])):
        np.testing.assert_array_equal(
            Program(trace, slopes).run_on_arrays({"x": 0.5}, 1), [[2.0 * np.sin(0.5)]]
        )
    both = gradient(z, [x, y])
    assert both[1] is derivatives([z], [y])[0][0]


def test_sides_that_are_not_chosen_do_not_matter() -> None:
    """A derivative of the other side may be infinite or NaN."""
    trace = Trace()
    x = trace.input("x", 1.0)
    outputs = [
        tape.select(x, tape.sqrt(x), -x),
        tape.greater(tape.sqrt(x), tape.sqrt(x) - 1.0),
        tape.absolute(x),
    ]
    forward = [row[0] for row in derivatives(outputs, [x])]
    backward = [gradient(y, [x])[0] for y in outputs]
    found = Program(trace, [*forward, *backward]).run_on_arrays({"x": [4.0, -4.0]}, 2)
    assert found[:, 0].tolist() == 2 * [0.25, 0.25, 1.0]
    assert found[[0, 2], 1].tolist() == [-1.0, -1.0]


def test_wrong_variables_are_refused() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    with pytest.raises(errors.ArgumentError, match="two traces"):
        derivatives([x], [Trace().input("x", 1.0)])
    for wrong in (2.0, np.ones(2), math.pi):
        with pytest.raises(errors.ArgumentError, match="not numbers"):
            gradient(x, [wrong])  # type: ignore[list-item]
    assert isinstance(gradient(x * x, [x])[0], Variable)
