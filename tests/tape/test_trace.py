"""Traces: what is folded and merged, and that results stay what the text says."""

from __future__ import annotations

import gc
import math
import operator
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from testkit import arithmetic

from cardan_dyn.core import tape
from cardan_dyn.core.tape import Program, Trace, Variable
from cardan_dyn.kit import errors


@pytest.fixture
def trace() -> Trace:
    return Trace()


@pytest.fixture
def x(trace: Trace) -> Variable:
    return trace.input("x", 0.3)


@pytest.fixture
def y(trace: Trace) -> Variable:
    return trace.input("y", 0.7)


FOLDED: list[tuple[str, Callable[[Any, Any], Any], Callable[[Any, Any], Any]]] = [
    ("0 x", lambda x, y: 0.0 * x, lambda x, y: 0.0),
    ("x 0", lambda x, y: x * 0.0, lambda x, y: 0.0),
    ("0 / x", lambda x, y: 0.0 / x, lambda x, y: 0.0),
    ("x - x", lambda x, y: x * y - y * x, lambda x, y: 0.0),
    ("x + 0", lambda x, y: x + 0.0, lambda x, y: x),
    ("0 + x", lambda x, y: 0 + x, lambda x, y: x),
    ("x - 0", lambda x, y: x - 0.0, lambda x, y: x),
    ("0 - x", lambda x, y: 0.0 - x, lambda x, y: -x),
    ("1 x", lambda x, y: 1.0 * x, lambda x, y: x),
    ("x 1", lambda x, y: x * 1, lambda x, y: x),
    ("x / 1", lambda x, y: x / 1.0, lambda x, y: x),
    ("-1 x", lambda x, y: -1.0 * x, lambda x, y: -x),
    ("x / -1", lambda x, y: x / -1.0, lambda x, y: -x),
    ("- -x", lambda x, y: -operator.neg(x), lambda x, y: x),
    ("+x", lambda x, y: +x, lambda x, y: x),
    ("x + -y", lambda x, y: x + -y, lambda x, y: x - y),
    ("-x + y", lambda x, y: -x + y, lambda x, y: y - x),
    ("x - -y", lambda x, y: x - -y, lambda x, y: x + y),
    ("-x - y", lambda x, y: -x - y, lambda x, y: -(x + y)),
    ("-(x - y)", lambda x, y: -(x - y), lambda x, y: y - x),
    ("x + y", operator.add, lambda x, y: y + x),
    ("x y", operator.mul, lambda x, y: y * x),
    ("-x y", lambda x, y: -x * y, lambda x, y: -(x * y)),
    ("x -y", lambda x, y: x * -y, lambda x, y: -(x * y)),
    ("-x -y", lambda x, y: -x * -y, lambda x, y: x * y),
    ("-2 x", lambda x, y: -2.0 * x, lambda x, y: -(x * 2)),
    ("-0.5 x", lambda x, y: x * -0.5, lambda x, y: -(0.5 * x)),
    ("-x / y", lambda x, y: -x / y, lambda x, y: -(x / y)),
    ("x / -y", lambda x, y: x / -y, lambda x, y: -(x / y)),
    ("x / -2", lambda x, y: x / -2.0, lambda x, y: -(x / 2.0)),
    ("sin -x", lambda x, y: tape.sin(-x), lambda x, y: -tape.sin(x)),
    ("cos -x", lambda x, y: tape.cos(-x), lambda x, y: tape.cos(x)),
    ("|-x|", lambda x, y: tape.absolute(-x), lambda x, y: tape.absolute(x)),
    ("||x||", lambda x, y: tape.absolute(tape.absolute(x)), lambda x, y: tape.absolute(x)),
    ("greater x x", lambda x, y: tape.greater(x, x), lambda x, y: x),
    ("smaller x x", lambda x, y: tape.smaller(x, x), lambda x, y: x),
    ("greater x y", tape.greater, lambda x, y: tape.greater(y, x)),
    ("smaller x y", tape.smaller, lambda x, y: tape.smaller(y, x)),
    (
        "greater 0 |x|",
        lambda x, y: tape.greater(0.0, tape.absolute(x)),
        lambda x, y: tape.absolute(x),
    ),
    (
        "greater |x| 0",
        lambda x, y: tape.greater(tape.absolute(x), 0.0),
        lambda x, y: tape.absolute(x),
    ),
    ("select 1", lambda x, y: tape.select(1.0, x, y), lambda x, y: x),
    ("select 0", lambda x, y: tape.select(0.0, x, y), lambda x, y: y),
    ("select -1", lambda x, y: tape.select(-1, x, y), lambda x, y: y),
    ("select NaN", lambda x, y: tape.select(math.nan, x, y), lambda x, y: y),
    ("select c x x", lambda x, y: tape.select(y, x, x), lambda x, y: x),
    ("NumPy's numbers", lambda x, y: np.float64(0.0) * x + np.int64(1) * y, lambda x, y: y),
]


@pytest.mark.parametrize(("folded", "kept"), [pytest.param(*c[1:], id=c[0]) for c in FOLDED])
def test_what_is_folded_is_kept_as_the_documentation_says(
    x: Variable,
    y: Variable,
    folded: Callable[[Any, Any], Any],
    kept: Callable[[Any, Any], Any],
) -> None:
    got, wanted = folded(x, y), kept(x, y)
    assert got is wanted or (type(got) is float and got == wanted)


STAYS: list[tuple[str, Callable[[Any, Any], Any], Callable[[Any, Any], Any]]] = [
    ("x / x", lambda x, y: x / x, lambda x, y: 1.0),
    ("x - y", operator.sub, lambda x, y: y - x),
    ("x / y", operator.truediv, lambda x, y: y / x),
    ("arctan2", tape.arctan2, lambda x, y: tape.arctan2(y, x)),
    ("(x + y) + y", lambda x, y: (x + y) + y, lambda x, y: x + (y + y)),
    ("(2 x) 3", lambda x, y: (2.0 * x) * 3.0, lambda x, y: 6.0 * x),
    ("x / 3", lambda x, y: x / 3.0, lambda x, y: x * (1.0 / 3.0)),
    ("x + 1e-300", lambda x, y: x + 1e-300, lambda x, y: x),
    ("greater 0 x", lambda x, y: tape.greater(0.0, x), lambda x, y: x),
    ("smaller 0 |x|", lambda x, y: tape.smaller(0.0, tape.absolute(x)), lambda x, y: 0.0),
    ("greater 1 |x|", lambda x, y: tape.greater(1.0, tape.absolute(x)), lambda x, y: x),
    ("greater, smaller", tape.greater, tape.smaller),
    ("select x", lambda x, y: tape.select(x, x, y), lambda x, y: tape.select(y, x, y)),
    ("tanh -x", lambda x, y: tape.tanh(-x), lambda x, y: tape.tanh(x)),
    ("-0", lambda x, y: tape.select(x, y, -0.0), lambda x, y: tape.select(x, y, 0.0)),
]


@pytest.mark.parametrize(("stays", "other"), [pytest.param(*c[1:], id=c[0]) for c in STAYS])
def test_what_might_differ_is_not_folded(
    x: Variable,
    y: Variable,
    stays: Callable[[Any, Any], Any],
    other: Callable[[Any, Any], Any],
) -> None:
    assert isinstance(stays(x, y), Variable)
    assert stays(x, y) is not other(x, y)
    assert stays(x, y) is stays(x, y)


def test_zeros_are_told_from_variables_and_from_their_values(x: Variable) -> None:
    assert tape.is_zero(0.0)
    assert tape.is_zero(-0.0)
    assert tape.is_zero(x * 0.0)
    assert not tape.is_zero(x)
    assert tape.is_zero(x - x)
    assert not tape.is_zero(1e-300)
    assert not tape.is_zero(np.zeros(3))


@pytest.mark.parametrize("seed", range(30))
def test_traced_texts_give_what_they_give_on_arrays_to_the_last_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 60)
    inputs = arithmetic.random_lanes(rng, text, 40)
    with np.errstate(all="ignore"):
        written = np.array([np.broadcast_to(row, 40) for row in text(list(inputs.values()))])
    trace, outputs = text.traced()
    traced = Program(trace, outputs).run_on_arrays(inputs, 40)
    kept = arithmetic.kept(text, list(inputs.values()), written)
    assert kept.sum() > 400
    np.testing.assert_array_equal(traced[kept], written[kept])


@pytest.mark.parametrize("seed", range(10))
def test_shadows_are_what_the_program_gives_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 40)
    inputs = arithmetic.random_lanes(rng, text, 16)
    trace = Trace()
    outputs = text([trace.input(name, value) for name, value in inputs.items()])
    expected = Program(trace, outputs).run_on_arrays(inputs, 16)
    for x, row in zip(outputs, expected, strict=True):
        if isinstance(x, Variable):
            np.testing.assert_array_equal(x.shadow, row)


def test_shadows_have_as_many_values_as_inputs_have(trace: Trace) -> None:
    x = trace.input("x", 2.0)
    y = trace.input("y", [1.0, 2.0, 3.0], uniform=True)
    assert x.shadow.tolist() == [2.0, 2.0, 2.0]
    assert (x * y + 1.0).shadow.tolist() == [3.0, 5.0, 7.0]
    z = trace.input("z", [1.0, 0.0, -1.0])
    assert (x / z).shadow.tolist() == [2.0, math.inf, -2.0]
    with pytest.raises(ValueError, match="read-only"):
        z.shadow[0] = 5.0


@pytest.mark.parametrize("seed", range(10))
def test_folding_changes_no_value_in_fifty_digits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 40)
    inputs = {name: float(row[0]) for name, row in arithmetic.random_lanes(rng, text, 1).items()}
    trace, outputs = text.traced()
    found = arithmetic.of_graph(Program(trace, outputs).graph, inputs)
    values: list[Any] = [mpmath.mpf(value) for value in inputs.values()]
    with mpmath.workdps(arithmetic.DIGITS):
        for operation, operands in text.steps:
            taken = [values[x] if type(x) is int else mpmath.mpf(x) for x in operands]
            values.append(arithmetic.IN_DIGITS[operation](*taken))
            if not mpmath.isfinite(values[-1]):
                break
            assert mpmath.almosteq(found[len(values) - text.inputs - 1], values[-1], 1e-40)


def test_wrong_operands_are_refused(trace: Trace, x: Variable) -> None:
    stranger = Trace().input("x", 1.0)
    for mixed in (operator.add, operator.sub, operator.mul, operator.truediv, tape.greater):
        with pytest.raises(errors.ArgumentError, match="two traces"):
            mixed(x, stranger)
    for wrong in (np.ones(3), "2", None, [1.0, 2.0]):
        with pytest.raises(errors.ArgumentError, match="numbers and variables"):
            _ = x * wrong
    with pytest.raises(errors.ArgumentError, match="numbers and variables"):
        _ = np.ones(3) * x
    with pytest.raises(errors.ArgumentError, match="neither true nor false"):
        max(x, 2.0 * x, key=lambda value: bool(value))
    with pytest.raises(errors.ArgumentError, match="already"):
        trace.input("x", 1.0)
    trace.input("y", [1.0, 2.0])
    with pytest.raises(errors.ArgumentError, match="shape"):
        trace.input("z", [1.0, 2.0, 3.0])
    with pytest.raises(errors.ArgumentError, match="shape"):
        trace.input("z", [[1.0, 2.0]])


@pytest.mark.slow
@pytest.mark.parametrize("collects", [True, False])
def test_a_trace_leaves_nothing_to_collect_and_the_collector_as_it_was(collects: bool) -> None:
    def variables() -> int:
        return sum(type(found) is Variable for found in gc.get_objects())

    gc.collect()
    before, was = variables(), gc.isenabled()
    (gc.enable if collects else gc.disable)()
    try:
        with Trace() as trace:
            assert not gc.isenabled()
            x = trace.input("x", 1.0)
            program = Program(trace, [tape.sqrt(x * 3.0 - 1.0)])
        assert gc.isenabled() is collects
        with pytest.raises(ZeroDivisionError), Trace():
            _ = 1 / 0
        assert gc.isenabled() is collects
        gc.disable()
        del x
        assert variables() == before
    finally:
        (gc.enable if was else gc.disable)()
    assert program.run({"x": 1.0}, 1).tolist() == [[math.sqrt(2.0)]]
