"""Instructions: each computes what the machine's table says, and together what was written."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit import arithmetic
from testkit.machine import OPERATIONS, RESULTS, ROUNDED, needs_machine

from cardan_dyn.core import compiled, tape
from cardan_dyn.core.compiled import kernel
from cardan_dyn.core.tape import Program, Trace
from cardan_dyn.core.tape.on_machine import Code
from cardan_dyn.core.tape.operations import NAMES

pytestmark = needs_machine

MEANINGS: dict[str, Callable[..., Any]] = {
    **ROUNDED,
    "EXP": np.exp,
    "LOG": np.log,
    "TANH": np.tanh,
    "ATAN2": np.arctan2,
}
"""Instructions with one result, as `compiled/machine.h` tells them."""
TWO_RESULTS: dict[str, Callable[..., Any]] = {
    "SC": lambda a: (np.sin(a), np.cos(a)),
}
OPERANDS = {
    name: function.nin if isinstance(function, np.ufunc) else function.__code__.co_argcount
    for name, function in {**MEANINGS, **TWO_RESULTS}.items()
}
UNWANTED = -1
"""Written where nothing reads it."""


def run(program: Program, inputs: list[np.ndarray], count: int) -> np.ndarray:
    """Return outputs of code, instruction by instruction; nothing reads what was not written."""
    code = program.code
    registers: dict[int, np.ndarray] = {}
    outputs = np.full((program.outputs, count), np.nan)
    for number, *operands in [*code.prologue.tolist(), *code.body.tolist()]:
        name = OPERATIONS[number]
        first, second = operands[:2]
        if name == "END":
            continue
        if name in ("LOAD", "LDU"):
            registers[first] = np.broadcast_to(inputs[second], count)
        elif name == "KST":
            registers[first] = np.full(count, program.graph.constants[second])
        elif name == "STORE":
            outputs[second] = registers[first]
        else:
            results = RESULTS.get(name, 1)
            read = [registers[k] for k in operands[results : results + OPERANDS[name]]]
            found = TWO_RESULTS[name](*read) if results == 2 else (MEANINGS[name](*read),)
            for register, values in zip(operands, found, strict=False):
                if register != UNWANTED:
                    assert register < code.registers
                    registers[register] = values
    return outputs


def names(code: Code) -> list[str]:
    """Return the operations of the body but loads, stores and the end."""
    found = [OPERATIONS[number] for number in code.body[:-1, 0].tolist()]
    return [name for name in found if name not in ("LOAD", "STORE")]


@pytest.mark.parametrize("operations", [(), arithmetic.SUMS], ids=["all", "sums"])
@pytest.mark.parametrize("seed", range(15))
def test_instructions_give_what_the_graph_does_to_the_last_bit(
    seed: int, operations: tuple[str, ...]
) -> None:
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 120, operations=operations)
    trace, steps = text.traced(uniform=(1,))
    # The last steps alone, so that others are parts of them; some twice.
    outputs = [*steps[-10:], steps[-3], steps[40]]
    inputs = arithmetic.random_lanes(rng, text, 50)
    inputs["x1"] = inputs["x1"][:1]
    program = Program(trace, outputs)
    with np.errstate(all="ignore"):
        values = [inputs[name] for name in program.inputs]
        found = run(program, values, 50)
    np.testing.assert_array_equal(found, program.run_on_arrays(inputs, 50))


SUMS = {
    "ADD": lambda a, b, c, d, e, f: a + b,
    "SUB": lambda a, b, c, d, e, f: a - b,
    "ADD3": lambda a, b, c, d, e, f: a + b + c,
    "FMA": lambda a, b, c, d, e, f: c + a * b,
    "FMS": lambda a, b, c, d, e, f: a * b - c,
    "FNMA": lambda a, b, c, d, e, f: c - a * b,
    "P2": lambda a, b, c, d, e, f: a * b + c * d,
    "M2": lambda a, b, c, d, e, f: a * b - c * d,
    "P3": lambda a, b, c, d, e, f: a * b + c * d + e * f,
    "A2": lambda a, b, c, d, e, f: a + b * c + d * e,
    "S2": lambda a, b, c, d, e, f: a - b * c - d * e,
    "AS": lambda a, b, c, d, e, f: a + b * c - d * e,
    "SA": lambda a, b, c, d, e, f: a - b * c + d * e,
    "PPM": lambda a, b, c, d, e, f: a * b + c * d - e * f,
    "PMP": lambda a, b, c, d, e, f: a * b - c * d + e * f,
    "PMM": lambda a, b, c, d, e, f: a * b - c * d - e * f,
    "PMA": lambda a, b, c, d, e, f: e + (a * b - c * d),
    "AMX": lambda a, b, c, d, e, f: tape.greater(tape.absolute(a), b),
    "RCP": lambda a, b, c, d, e, f: 1.0 / a,
}


@pytest.mark.parametrize("operation", SUMS)
def test_a_pattern_is_one_instruction_that_rounds_as_written(operation: str) -> None:
    trace = Trace()
    inputs = dict(zip("abcdef", np.random.default_rng(1).normal(size=(6, 99)), strict=True))
    text = SUMS[operation]
    program = Program(trace, [text(*[trace.input(name, 1.0) for name in "abcdef"])])
    assert names(program.code) == [operation]
    np.testing.assert_array_equal(program.run(inputs, 99)[0], text(*inputs.values()))


def test_a_sum_of_many_terms_is_added_from_left_to_right() -> None:
    trace = Trace()
    x = [trace.input(f"x{k}", 1.0) for k in range(9)]
    text = x[0] * x[1] + x[2] * x[3] + x[4] * x[5] - x[6] * x[7] - x[8] + x[0] * x[8] - x[1] * x[7]
    assert names(Program(trace, [text]).code) == ["P3", "FNMA", "SUB", "AS"]


def test_what_others_read_stays_an_instruction() -> None:
    trace = Trace()
    a, b, c = (trace.input(name, 1.0) for name in "abc")
    product, distance = a * b, tape.absolute(b - c)
    assert names(Program(trace, [product + c, product]).code) == ["MUL", "ADD"]
    assert names(Program(trace, [product + c, product - c]).code) == ["MUL", "ADD", "SUB"]
    outputs = [tape.greater(a, distance), distance]
    assert names(Program(trace, outputs).code) == ["SUB", "ABS", "MAX"]
    assert names(Program(trace, [(a + b) + c, a + b]).code) == ["ADD", "ADD"]


def test_sine_and_cosine_of_an_angle_are_one_instruction() -> None:
    trace = Trace()
    x, y, angle = (trace.input(name, 1.0) for name in ("x", "y", "angle"))
    s, c = tape.sin(angle), tape.cos(angle)
    program = Program(trace, [x * c - y * s, x * s + y * c])
    assert names(program.code) == ["SC", "M2", "P2"]
    inputs = {"x": [1.0, 2.0], "y": [-1.0, 0.5], "angle": [0.3, 2.0]}
    xs, ys, angles = (np.array(values) for values in inputs.values())
    expected = [
        xs * np.cos(angles) - ys * np.sin(angles),
        xs * np.sin(angles) + ys * np.cos(angles),
    ]
    np.testing.assert_allclose(program.run(inputs, 2), expected, rtol=1e-15)
    assert names(Program(trace, [tape.cos(x)]).code) == ["SC"]


def test_uniform_values_are_computed_once() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    m = trace.input("m", 1.0, uniform=True)
    program = Program(trace, [x * (tape.sqrt(m) + 2.0), m * m])
    assert names(program.code) == ["MUL"]
    assert program.run({"x": [1.0, 2.0], "m": 4.0}, 2).tolist() == [[4.0, 8.0], [16.0, 16.0]]
    # Nor are they a part of what each lane computes.
    assert names(Program(trace, [x + m * m]).code) == ["ADD"]
    assert names(Program(trace, [tape.greater(x, tape.absolute(m - 1.0))]).code) == ["MAX"]


def test_registers_are_used_again() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    value = x
    for _ in range(100):
        value = tape.sqrt(value)
    program = Program(trace, [value])
    assert program.code.registers == 1
    assert len(program.code.body) == 103


def graph(nodes: str, outputs: Sequence[int], constants: int = 0) -> list[np.ndarray]:
    """Return a graph as the machine takes it, of nodes with their arguments or places."""
    rows = [node.split() for node in nodes.split(", ")]
    arguments = [[*map(int, row[1:]), -1, -1, -1][:3] for row in rows]
    return [
        np.array([NAMES.index(row[0]) for row in rows], dtype=np.int32),
        np.array(arguments, dtype=np.int32).reshape(-1, 3),
        np.arange(float(constants)),
        np.array(outputs, dtype=np.int32),
    ]


@pytest.mark.parametrize(
    ("nodes", "outputs"),
    [
        ("input 0, sqrt 1", [1]),
        ("input 0, sqrt -1", [1]),
        ("input 0, add 0 2", [1]),
        ("input 0, select 0 0", [1]),
        ("constant 1", [0]),
        ("constant", [0]),
        ("input 0", [1]),
        ("input 0", [-1]),
        ("input 0, sin 0, sin 0", [1, 2]),
    ],
)
def test_graphs_that_are_none_are_refused(nodes: str, outputs: list[int]) -> None:
    with pytest.raises(ValueError, match="of a graph"):
        kernel.instructions(*graph(nodes, outputs, constants=1))


def test_arrays_of_other_types_and_sizes_are_refused() -> None:
    fields = graph("input 0, sqrt 0", [1])
    kernel.instructions(*fields)
    for place in range(4):
        for dtype in (np.int64, np.float32, ">i4", ">f8"):
            others = [*fields[:place], fields[place].astype(dtype), *fields[place + 1 :]]
            with pytest.raises(TypeError):
                kernel.instructions(*others)
    for number in (-1, len(NAMES), 2**31 - 1):
        with pytest.raises(ValueError, match="node 1 of a graph"):
            kernel.instructions(np.array([1, number], dtype=np.int32), *fields[1:])
    with pytest.raises(ValueError, match="arguments"):
        kernel.instructions(fields[0][:1], *fields[1:])
    with pytest.raises((BufferError, ValueError)):
        kernel.instructions(np.ones(4, dtype=np.int32)[::2], *fields[1:])
    with pytest.raises(TypeError, match="4 arguments"):
        kernel.instructions(*fields[:3])
    with pytest.raises(TypeError):
        kernel.instructions([1, 4], *fields[1:])


def test_graphs_that_are_too_large_are_refused() -> None:
    # What is only zero takes no memory.
    most = 2**23
    operations, arguments = np.zeros(most, np.int32), np.zeros((most, 3), np.int32)
    few = graph("input 0", [0])
    with pytest.raises(ValueError, match="too many"):
        kernel.instructions(operations, arguments, np.ones(1), few[3])
    with pytest.raises(ValueError, match="too many"):
        kernel.instructions(*few[:3], operations)


@pytest.mark.parametrize("seed", range(8))
def test_any_arrays_are_refused_or_become_a_program(seed: int) -> None:
    """Also where equal nodes are written twice, or not all are read."""
    rng = np.random.default_rng(seed)
    made = 0
    for _ in range(500):
        count = int(rng.integers(1, 40))
        reach = int(rng.integers(1, 12))
        operations = rng.integers(0, len(NAMES), count, dtype=np.int32)
        operations[: min(3, count)] = 1
        if rng.random() < 0.5:  # Mostly sums of products.
            operations[3:] = rng.choice([3, 4, 5, 5], max(0, count - 3))
        last = np.arange(count)[:, None]
        arguments = (last - rng.integers(1, reach + 1, (count, 3))).astype(np.int32)
        if rng.random() < 0.9:
            arguments = np.maximum(arguments, 0)
        arguments[operations <= 2] = 0
        outputs = rng.integers(0, count, int(rng.integers(0, 9)), dtype=np.int32)
        try:
            found = kernel.instructions(operations, arguments, np.ones(1), outputs)
        except ValueError:
            continue
        made += 1
        prologue, body = (np.frombuffer(rows, np.int32).reshape(-1, 8) for rows in found[:2])
        kernel.program(prologue, np.ones(1), body, found[2], 1, len(outputs), 32)
    assert made > 100


def test_numbers_of_operations_are_those_of_the_machine() -> None:
    header = Path(compiled.__file__).parent / "machine.h"
    if not header.is_file():
        pytest.skip("sources of the machine are in checkouts alone")
    listed = re.findall(r"WITH\((\w+), \"", header.read_text(encoding="utf-8"))
    assert listed == OPERATIONS
