"""Derivatives, written on and as linear maps read both ways: against mpmath at 50 digits."""

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
from cardan_dyn.core.tape import (
    NOTHING,
    Differential,
    Factor,
    Program,
    Scalar,
    Trace,
    Variable,
    derivatives,
)
from cardan_dyn.kit import errors

SMOOTH = ["add", "subtract", "multiply", "divide", "negative", "sin", "cos", "tanh", "arctan2"]
FUNCTIONS = {**arithmetic.EXACT, **arithmetic.LIBRARY}


def maps(trace: Trace, outputs: list[Scalar], x: list[Variable]) -> list[Any]:
    """Return programs and rows `[output][variable]` of derivatives, forwards and backwards."""
    differential = Differential(trace)
    free = {variable: differential.free() for variable in x}
    ways = differential.tangents(outputs, free)
    ends = [differential.sum([(Factor(1.0), way)]) for way in ways]
    program, rows = differential.forwards([{change: 1.0} for change in free.values()], ends)
    directions = [{end: 1.0} if end != NOTHING else {} for end in ends]
    return [(program, rows.T), differential.backwards(directions, [*free.values()])]


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
    written = [(Program(trace, forward), np.arange(count)[None]), *maps(trace, [y], x)]
    for _ in range(5):
        values = rng.uniform(0.2, 2.0, count)
        if operation in ("select", "absolute", "sin", "arctan2"):
            values *= rng.choice([-1.0, 1.0], count)
        inputs = {f"x{k}": float(value) for k, value in enumerate(values)}
        with mpmath.workdps(arithmetic.DIGITS):
            operands = [mpmath.mpf(value) for value in inputs.values()]
            exact = exact_slopes(partial(in_digits, operation), operands)
            for program, rows in written:
                found = [*arithmetic.of_graph(program.graph, inputs), 0]
                for row, right in zip(rows[0], exact, strict=True):
                    assert abs(found[row] - right) <= 1e-20


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
    assert len(forward) == 3
    assert {len(row) for row in forward} == {3}
    inputs = {f"x{k}": float(value) for k, value in enumerate(rng.uniform(0.3, 2.0, 3))}
    traced = Program(trace, [entry for row in forward for entry in row])
    found = []
    for program, rows in (traced, np.arange(9)), *maps(trace, outputs, x):
        own = [*arithmetic.of_graph(program.graph, inputs), 0]
        found += [own[row] for row in rows.ravel()]
    with mpmath.workdps(arithmetic.DIGITS):
        operands = [mpmath.mpf(value) for value in inputs.values()]
        exact = [
            slope
            for i in range(3)
            for slope in exact_slopes(lambda x, i=i: values_of(text, x)[i - 3], operands)
        ]
        for value, right in zip(found, 3 * exact, strict=True):
            assert abs(value - right) <= 1e-18 * (1 + abs(right))


def test_derivatives_of_derivatives() -> None:
    trace = Trace()
    x, y = trace.input("x", 1.0), trace.input("y", 1.0)
    f = tape.sin(x * y) / (x + y * y)
    (slopes,) = derivatives([f], [x, y])
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
    for _, places in maps(trace, [x * x, tape.sin(y), 3.0, x - x], [x, y]):
        assert ((places == NOTHING) == [[False, True], [True, False], *2 * [[True, True]]]).all()
    assert derivatives([x, y], []) == [[], []]
    assert derivatives([], [x]) == []
    assert derivatives([3.0], []) == [[]]


def test_derivatives_with_respect_to_what_is_between() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    y = tape.sin(x)
    z = y * y
    (slopes,) = derivatives([z], [y])
    assert Program(trace, slopes).run_on_arrays({"x": 0.5}, 1) == 2.0 * np.sin(0.5)
    for program, ((row,),) in maps(trace, [z], [y]):
        assert program.run_on_arrays({"x": 0.5}, 1)[row] == 2.0 * np.sin(0.5)


def test_changes_are_sums_of_others_in_several_directions() -> None:
    """Seeds are traced, terms of one change add up, and what is asked for twice is one row."""
    trace = Trace()
    x, by = trace.input("x", 1.0), trace.input("by", 1.0)
    differential = Differential(trace)
    a, b = differential.free(), differential.free()
    both = differential.sum([(Factor(x), a), (Factor(-2.0), b), (Factor(-x), a), (Factor(3.0), b)])
    lone = differential.sum([(Factor(-1.0), b)])
    assert differential.sum([(Factor(0.0), a), (Factor(x), NOTHING)]) == NOTHING
    wanted = [both, lone, NOTHING, both]
    program, rows = differential.forwards([{a: by}, {b: by}, {a: 1.0, b: by}, {}], wanted, [x])
    found = np.append(program.run_on_arrays({"x": 5.0, "by": 7.0}, 1), 0.0)
    assert found[0] == 5.0
    assert found[rows].tolist() == [[0, 0, 0, 0], [7, -7, 0, 7], [7, -7, 0, 7], [0, 0, 0, 0]]
    end = differential.sum([(Factor(x), both), (Factor(1.0), lone)])
    program, rows = differential.backwards([{end: by}, {}], [a, b, a])
    found = np.append(program.run_on_arrays({"x": 5.0, "by": 7.0}, 1), 0.0)
    assert found[rows].tolist() == [[0, 28, 0], [0, 0, 0]]


def test_what_all_directions_have_in_common_is_computed_once() -> None:
    """Of a function of one sum, each further direction takes a term of it and a product."""
    trace = Trace()
    x = [trace.input(f"x{k}", 1.0) for k in range(24)]
    angle = sum((tape.sin(value) for value in x), 0.0)
    y = tape.sin(angle) * tape.cos(angle) * angle + tape.tanh(angle) * tape.sin(2.0 * angle)
    (forward, _), (backward, _) = maps(trace, [y], x)
    for program in (forward, backward):
        assert len(program.graph.operations) - len(trace.nodes) < 3 * len(x)


def test_nodes_come_in_turn() -> None:
    """No sooner than needed where they have none; and what is computed stays the same."""
    rng = np.random.default_rng(2)
    trace = Trace()
    values: list[Scalar] = [trace.input(f"x{k}", 1.0) for k in range(4)]
    for _ in range(200):
        first, second = (values[k] for k in rng.integers(0, len(values), 2))
        values.append(tape.tanh(first) + second * 0.5)
    graph = Program(trace, values[-20:]).graph
    moved = graph.in_turn(np.arange(5))
    places = {name: float(k) for k, name in enumerate(graph.inputs)}
    found, same = (Program.of(of).run_on_arrays(places, 1) for of in (moved, graph))
    assert found.tolist() == same.tolist()
    assert moved.outputs.tolist() != graph.outputs.tolist()
    for node, (operation, arguments) in enumerate(moved.nodes()):
        assert operation in ("constant", "input") or max(arguments) < node


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
    found = []
    for program, rows in (Program(trace, forward), np.arange(3)), *maps(trace, outputs, [x]):
        found.append(program.run_on_arrays({"x": [4.0, -4.0]}, 2)[rows.ravel()])
        assert found[-1][:, 0].tolist() == [0.25, 0.25, 1.0]
    for slopes in found[:2]:  # Backwards, weights of 0 meet what is NaN.
        assert slopes[[0, 2], 1].tolist() == [-1.0, -1.0]


def test_wrong_variables_are_refused() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    with pytest.raises(errors.ArgumentError, match="two traces"):
        derivatives([x], [Trace().input("x", 1.0)])
    for wrong in (2.0, math.pi):
        with pytest.raises(errors.ArgumentError, match="not numbers"):
            derivatives([x], [wrong])  # type: ignore[list-item]
        with pytest.raises(errors.ArgumentError, match="not numbers"):
            Differential(trace).tangents([x], {wrong: 0})  # type: ignore[dict-item]
    assert isinstance(derivatives([x * x], [x])[0][0], Variable)
