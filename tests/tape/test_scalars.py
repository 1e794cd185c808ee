"""Scalars: floats, arrays and traced variables give the same; signs of zero, infinity and NaN."""

from __future__ import annotations

import itertools
import math
from typing import Any

import mpmath
import numpy as np
import pytest
from testkit import arithmetic

from cardan_dyn.core import tape
from cardan_dyn.core.tape import Program, Trace

SPECIAL = [0.0, -0.0, 1.0, -1.0, 0.5, -3.0, 1e-320, 1e300, math.inf, -math.inf, math.nan]
FUNCTIONS = {
    **arithmetic.EXACT,
    **arithmetic.LIBRARY,
}


def traced(operation: str, columns: list[list[float]]) -> list[np.ndarray]:
    """Return an operation on lanes by the machine, if there is one, and by NumPy."""
    trace = Trace()
    names = [f"x{k}" for k in range(len(columns))]
    outputs = [FUNCTIONS[operation][1](*[trace.input(name, 1.0) for name in names])]
    program = Program(trace, outputs)
    inputs = dict(zip(names, columns, strict=True))
    count = len(columns[0])
    return [program.run(inputs, count)[0], program.run_on_arrays(inputs, count)[0]]


@pytest.mark.parametrize("operation", FUNCTIONS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_special_values_are_those_of_floats(operation: str) -> None:
    operands, function = FUNCTIONS[operation]
    rows = list(itertools.product(SPECIAL, repeat=operands))
    expected = [function(*row) for row in rows]
    assert all(type(value) is float for value in expected)
    for found in traced(operation, [list(column) for column in zip(*rows, strict=True)]):
        np.testing.assert_allclose(found, expected, rtol=4e-16, atol=0.0)
        if operation in ("greater", "smaller"):
            continue  # Of two zeros it may be either.
        known = ~np.isnan(expected)
        np.testing.assert_array_equal(np.signbit(found)[known], np.signbit(expected)[known])


def test_nan_is_kept_by_extremes_and_means_the_second_in_a_choice() -> None:
    nan = math.nan
    for function in (tape.greater, tape.smaller):
        assert math.isnan(function(nan, 1.0))
        assert math.isnan(function(1.0, nan))
    assert tape.select(nan, 1.0, 2.0) == 2.0
    assert tape.select(1.0, 3.0, nan) == 3.0
    assert tape.select(0.0, 3.0, 4.0) == 4.0
    for found in traced("greater", [[nan, 1.0, 2.0], [1.0, nan, 1.0]]):
        np.testing.assert_array_equal(found, [nan, nan, 2.0])
    for found in traced("smaller", [[nan, 1.0, 2.0], [1.0, nan, 1.0]]):
        np.testing.assert_array_equal(found, [nan, nan, 1.0])
    for found in traced("select", [[nan, 1.0, 0.0, -1.0], [5.0] * 4, [nan, nan, 7.0, 8.0]]):
        np.testing.assert_array_equal(found, [nan, 5.0, 7.0, 8.0])


def test_functions_take_arrays_and_numbers_at_once() -> None:
    a = np.array([1.0, -2.0, 3.0])
    np.testing.assert_array_equal(tape.greater(a, 0.0), [1.0, 0.0, 3.0])
    np.testing.assert_array_equal(tape.smaller(0.0, a), [0.0, -2.0, 0.0])
    np.testing.assert_array_equal(tape.select(a, 7.0, -a), [7.0, 2.0, 7.0])
    np.testing.assert_array_equal(tape.select(1.0, a, 2.0), a)
    np.testing.assert_array_equal(tape.absolute(a), [1.0, 2.0, 3.0])
    assert type(tape.sin(1)) is float
    assert type(tape.select(1.0, 2, 3)) is float


@pytest.mark.parametrize("seed", range(8))
def test_each_step_of_a_random_text_is_rounded_as_it_should(seed: int) -> None:
    """Against mpmath, each from the operands that it really had."""
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 50)
    inputs = arithmetic.random_lanes(rng, text, 33)
    trace, outputs = text.traced()
    program = Program(trace, outputs)
    for found in (program.run(inputs, 33), program.run_on_arrays(inputs, 33)):
        values = np.vstack([*inputs.values(), found])
        checked = 0
        for step, (operation, operands) in enumerate(text.steps):
            for lane in range(33):
                taken = [values[x, lane] if type(x) is int else x for x in operands]
                if not np.all(arithmetic.usual(np.array(taken))):
                    continue
                _check_rounding(operation, taken, found[step, lane])
                checked += 1
        assert checked > 500


def _check_rounding(operation: str, operands: list[Any], found: float) -> None:
    with mpmath.workdps(arithmetic.DIGITS):
        exact = arithmetic.IN_DIGITS[operation](*[mpmath.mpf(float(x)) for x in operands])
        if mpmath.isnan(exact):
            assert math.isnan(found)
        elif operation in arithmetic.EXACT:
            assert found == float(exact)
        else:
            # NumPy and the C library state up to four units in the last place.
            units = 1 if operation in ("sin", "cos") else 4
            assert abs(found - exact) <= units * np.spacing(abs(float(exact)))
