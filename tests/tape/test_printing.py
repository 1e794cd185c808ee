"""Printing: the C of a program, compiled, gives what the program gives."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from testkit import arithmetic

from cardan_dyn.core import tape
from cardan_dyn.core.tape import Program, Trace, as_c
from cardan_dyn.kit import errors

needs_compiler = pytest.mark.skipif(not shutil.which("cc"), reason="there is no compiler")


def compiled_c(
    program: Program, folder: Path
) -> Callable[[dict[str, np.ndarray], int], np.ndarray]:
    source, library = folder / "printed.c", folder / "printed.so"
    source.write_text(as_c(program, "printed"), encoding="utf-8")
    command = ["cc", "-std=c99", "-pedantic-errors", "-Wall", "-Werror", "-O1", "-shared", "-fPIC"]
    subprocess.run(
        [*command, "-Wno-unused", "-Wno-parentheses", source, "-o", library, "-lm"], check=True
    )
    function = ctypes.CDLL(str(library)).printed
    function.restype = None

    def run(inputs: dict[str, np.ndarray], count: int) -> np.ndarray:
        arrays = [np.ascontiguousarray(inputs[name], dtype=float) for name in program.inputs]
        outputs = np.empty((program.outputs, count))
        pointers = (ctypes.c_void_p * max(1, len(arrays)))(*[array.ctypes.data for array in arrays])
        function(ctypes.c_long(count), pointers, ctypes.c_void_p(outputs.ctypes.data))
        return outputs

    return run


@needs_compiler
@pytest.mark.parametrize("seed", range(3))
def test_printed_texts_give_the_same_to_the_last_bit(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 150, operations=list(arithmetic.EXACT))
    trace, steps = text.traced(uniform=(2,))
    program = Program(trace, steps[-30:])
    inputs = arithmetic.random_lanes(rng, text, 57)
    inputs["x2"] = inputs["x2"][:1]
    found = compiled_c(program, tmp_path)(inputs, 57)
    np.testing.assert_array_equal(found, program.run(inputs, 57))


@needs_compiler
def test_all_functions_and_special_numbers_can_be_printed(tmp_path: Path) -> None:
    trace = Trace()
    x, y = trace.input("a */ name", 1.0), trace.input("y", 1.0, uniform=True)
    functions = [function for _, (count, function) in arithmetic.LIBRARY.items() if count == 1]
    special = [0.0, -0.0, math.inf, -math.inf, math.nan, 5e-324, 0.1, -1e308]
    nans = [tape.greater(x, y * math.nan), tape.smaller(y * math.nan, x)]
    outputs = [*[f(x) for f in functions], tape.arctan2(x, y), *nans, *special]
    program = Program(trace, outputs)
    inputs = {"a */ name": np.linspace(0.1, 5.0, 20), "y": np.array(-0.7)}
    found = compiled_c(program, tmp_path)(inputs, 20)
    expected = program.run(inputs, 20)
    np.testing.assert_allclose(found, expected, rtol=1e-15, atol=1e-16)
    np.testing.assert_array_equal(found[-len(special) :], expected[-len(special) :])
    np.testing.assert_array_equal(np.signbit(found[8:]), np.signbit(expected[8:]))


def test_names_that_c_does_not_take_are_refused() -> None:
    trace = Trace()
    program = Program(trace, [trace.input("x", 1.0)])
    assert "void f_2(long count" in as_c(program, "f_2")
    for wrong in ("", "2f", "a b", "f()", "é", "f\n"):
        with pytest.raises(errors.ArgumentError, match="no name"):
            as_c(program, wrong)
