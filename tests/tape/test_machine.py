"""The machine does what its table of operations says, and refuses what would leave its memory."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from inspect import signature
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from testkit.machine import OPERATIONS, RESULTS, ROUNDED, needs_machine

from cardan_dyn.core import tape as tapes
from cardan_dyn.core.compiled import kernel

pytestmark = needs_machine

Array = NDArray[np.float64]
Row = list[int]

BLOCKS = (4, 32)
RNG = np.random.default_rng

END, LOAD, LDU, STORE, KST = range(5)
NUMBER = {name: number for number, name in enumerate(OPERATIONS)}

BY_LIBRARY: dict[str, Callable[..., float]] = {
    "EXP": math.exp,
    "LOG": math.log,
    "TANH": math.tanh,
    "ATAN2": math.atan2,
}


def reads(name: str) -> int:
    """How many registers an operation reads."""
    if name in RESULTS:
        return 1
    meaning: Any = {**ROUNDED, **BY_LIBRARY}[name]
    return len(signature(meaning).parameters) if name in ROUNDED else 1 + (name == "ATAN2")


class Program:
    """Rows of instructions with numbers of registers, and what they mean."""

    def __init__(self, registers: int) -> None:
        self.registers = registers
        self.prologue: list[Row] = []
        self.code: list[Row] = []
        self.constants: list[float] = []

    def fields(self) -> list[Any]:
        tapes = []
        for rows in (self.prologue, self.code):
            tapes.append(np.zeros((len(rows) + 1, 8), dtype=np.int32))
            for line, row in zip(tapes[-1], rows, strict=False):
                line[: len(row)] = row
        return [tapes[0], np.array(self.constants), tapes[1], self.registers]

    def handle(self, inputs: int, outputs: int, block: int) -> Any:
        return kernel.program(*self.fields(), inputs, outputs, block)

    def run(self, inputs: Sequence[Array], outputs: int, lanes: int, block: int) -> Array:
        found = np.full((outputs, lanes), np.nan)
        kernel.run_program(self.handle(len(inputs), outputs, block), inputs, found)
        return found

    def oracle(self, inputs: Sequence[Array], outputs: int, lanes: int) -> Array:
        """All lanes at once, operation by operation, by NumPy's arithmetic."""
        registers = np.zeros((self.registers, lanes))
        found = np.zeros((outputs, lanes))
        with np.errstate(all="ignore"):
            for operation, *operands in self.prologue + self.code:
                name = OPERATIONS[operation]
                if name in ("LOAD", "LDU"):
                    registers[operands[0]] = inputs[operands[1]]
                elif name == "KST":
                    registers[operands[0]] = self.constants[operands[1]]
                elif name == "STORE":
                    found[operands[1]] = registers[operands[0]]
                else:
                    values = [registers[k] for k in operands[1:]]
                    registers[operands[0]] = ROUNDED[name](*values)
        return found


def assert_same(found: Array, expected: Array) -> None:
    """Equal to the last bit; NaN is NaN, whatever it carries."""
    np.testing.assert_array_equal(found, expected)
    numbers = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(found[numbers]), np.signbit(expected[numbers]))


def numbers(count: int, lanes: int, seed: int, special_share: float = 0.1) -> Array:
    """Numbers of many sizes; a share are zeros of both signs, infinities, NaN and 1."""
    rng = RNG(seed)
    values = rng.normal(size=(count, lanes)) * 10.0 ** rng.integers(-3, 4, (count, lanes))
    special = rng.choice([0.0, -0.0, np.inf, -np.inf, np.nan, 1.0], (count, lanes))
    return np.where(rng.random((count, lanes)) < special_share, special, values)


def one_operation(name: str) -> Program:
    """An operation on the inputs, all results stored."""
    count, results = reads(name), RESULTS.get(name, 1)
    program = Program(count + results)
    program.code = [[LOAD, k, k] for k in range(count)]
    program.code.append([NUMBER[name], *range(count, count + results), *range(count)])
    program.code += [[STORE, count + k, k] for k in range(results)]
    return program


def random_program(seed: int) -> tuple[Program, list[Array], int, int]:
    """A program, its inputs, outputs and lanes; no register of the prologue is written later."""
    rng = RNG(seed)
    lanes = int(rng.integers(32, 200))
    uniform, laned, outputs, registers = 3, 4, 5, 14
    inputs = [*numbers(uniform, 1, seed), *numbers(laned, lanes, seed + 1)]
    inputs.append(np.array(rng.normal()))  # One number, where code asks for one in each lane.
    program = Program(registers)
    program.constants = list(rng.normal(size=3))
    names = [*ROUNDED]

    def operation(name: str, known: Sequence[int], written: Sequence[int]) -> Row:
        results = rng.choice(written, RESULTS.get(name, 1), replace=False)
        return [NUMBER[name], *map(int, results), *map(int, rng.choice(known, reads(name)))]

    program.prologue = [[LDU, k, k] for k in range(uniform)]
    program.prologue += [[KST, uniform + k, k] for k in range(3)]
    program.prologue += [operation("FMA", range(6), [6]), operation("P2", range(7), [0])]
    own = range(7, registers)
    program.code = [[LOAD, register, uniform + k % (laned + 1)] for k, register in enumerate(own)]
    for _ in range(60):
        if rng.random() < 0.1:
            program.code.append([STORE, int(rng.integers(registers)), int(rng.integers(outputs))])
        program.code.append(operation(str(rng.choice(names)), range(registers), own))
    program.code += [[STORE, 9 + k, k] for k in range(outputs)]
    return program, inputs, outputs, lanes


@pytest.fixture(params=["as it runs here", "without AVX2"])
def instructions(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "without AVX2":
        monkeypatch.setenv("CARDAN_DYN_AVX2", "0")


@pytest.mark.usefixtures("instructions")
@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("name", ROUNDED)
def test_operations_are_rounded_as_written(name: str, block: int) -> None:
    program = one_operation(name)
    inputs = [*numbers(reads(name), 2001, NUMBER[name], 0.6)]
    outputs = RESULTS.get(name, 1)
    expected = program.oracle(inputs, outputs, 2001)
    assert_same(program.run(inputs, outputs, 2001, block), expected)


@pytest.mark.usefixtures("instructions")
@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("name", BY_LIBRARY)
def test_operations_of_the_library(name: str, block: int) -> None:
    values = np.abs(RNG(0).normal(size=(reads(name), 99)))
    expected = [BY_LIBRARY[name](*lane) for lane in values.T]
    found = one_operation(name).run([*values], 1, 99, block)
    np.testing.assert_array_max_ulp(found[0], np.array(expected), 1)


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("seed", range(25))
@pytest.mark.usefixtures("instructions")
def test_random_programs(seed: int, block: int) -> None:
    program, inputs, outputs, lanes = random_program(seed)
    assert_same(program.run(inputs, outputs, lanes, block), program.oracle(inputs, outputs, lanes))


@pytest.mark.parametrize("block", BLOCKS)
def test_all_sets_of_instructions_give_the_same_bits(
    block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    sine_cosine = one_operation("SC")
    angles = RNG(3).normal(size=5000) * 10.0 ** RNG(4).uniform(-9, 7, 5000)
    random = [random_program(seed) for seed in range(20)]

    def results() -> Iterator[Array]:
        yield sine_cosine.run([angles], 2, 5000, block)
        for name in BY_LIBRARY:
            yield one_operation(name).run([np.abs(angles), angles], 1, 5000, block)
        for program, inputs, outputs, lanes in random:
            yield program.run(inputs, outputs, lanes, block)

    fastest = list(results())
    monkeypatch.setenv("CARDAN_DYN_AVX2", "0")
    for found, expected in zip(results(), fastest, strict=True):
        assert_same(found, expected)


def ulps(found: Array, angles: Array, exact: Callable[[Any], Any]) -> Array:
    """Errors in units in the last place of the exact value."""
    with mpmath.workprec(160):
        true = [exact(mpmath.mpf(float(angle))) for angle in angles]
        return np.array(
            [
                abs(float((mpmath.mpf(float(value)) - x) / math.ulp(float(x))))
                for value, x in zip(found, true, strict=True)
            ]
        )


def test_sine_and_cosine_are_right_to_a_unit_in_the_last_place() -> None:
    """Of a million angles the worst is 0.783 off, of all multiples of π/2 and neighbours 0.601."""
    with mpmath.workprec(160):
        quarters = np.array([float(k * mpmath.pi / 2) for k in range(1, 63662, 217)])
    rng = RNG(5)
    angles = np.concatenate(
        [
            rng.uniform(-1e5, 1e5, 1000),
            rng.uniform(-math.pi, math.pi, 1000),
            10.0 ** rng.uniform(-9, 5, 1000),
            rng.uniform(0.75, 0.8, 1000),
            quarters,
            np.nextafter(quarters, 0.0),
            np.nextafter(quarters, np.inf),
        ]
    )
    found = one_operation("SC").run([angles], 2, len(angles), 32)
    assert ulps(found[0], angles, mpmath.sin).max() < 0.8
    assert ulps(found[1], angles, mpmath.cos).max() < 0.8


@pytest.mark.parametrize("block", BLOCKS)
def test_large_angles_are_left_to_the_library(block: int) -> None:
    """They lie among small ones, which keep their values; so do signs of zero."""
    small = RNG(9).uniform(-10.0, 10.0, 999)
    large = np.array([1e300, -0.0, np.nan, -2e5, np.inf, 0.0])
    angles = small.copy()
    angles[2:992:11] = np.resize(large, 90)
    alone = one_operation("SC").run([small], 2, 999, block)
    found = one_operation("SC").run([angles], 2, 999, block)
    assert_same(found[:, angles == small], alone[:, angles == small])
    sine, cosine = found[:, 2:68:11]
    assert_same(sine[[1, 5]], np.array([-0.0, 0.0]))
    assert cosine[1] == cosine[5] == 1.0
    assert np.isnan([*sine[[2, 4]], *cosine[[2, 4]]]).all()
    for place in (0, 3):
        np.testing.assert_array_max_ulp(sine[place], math.sin(large[place]), 1)
        np.testing.assert_array_max_ulp(cosine[place], math.cos(large[place]), 1)


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("unwanted", [0, 1])
def test_the_sine_or_the_cosine_alone_in_place_of_the_angle(block: int, unwanted: int) -> None:
    program = Program(1)
    places = [-1, 0] if unwanted == 0 else [0, -1]
    program.code = [[LOAD, 0, 0], [NUMBER["SC"], *places, 0], [STORE, 0, 0]]
    angles = RNG(7).normal(size=77)
    angles[30] = 1e9
    both = one_operation("SC").run([angles], 2, 77, block)
    assert_same(program.run([angles], 1, 77, block)[0], both[1 - unwanted])


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("more", [0, 1, 3])
def test_the_last_block_lies_over_the_one_before(block: int, more: int) -> None:
    program, inputs, outputs, _ = random_program(3)
    lanes = 2 * block + more
    inputs = [np.resize(values, lanes) if values.size > 1 else values for values in inputs]
    assert_same(program.run(inputs, outputs, lanes, block), program.oracle(inputs, outputs, lanes))


@pytest.mark.parametrize("apart", [0, 1, 3])
def test_outputs_larger_than_the_caches(apart: int) -> None:
    """They pass by the caches where their rows lie at multiples of a vector, else not."""
    lanes = 2**20 + apart
    program = Program(2)
    program.code = [[LOAD, 0, 0], [NUMBER["ADD"], 1, 0, 0], [STORE, 0, 0], [STORE, 1, 1]]
    values = RNG(0).normal(size=lanes)
    assert_same(program.run([values], 2, lanes, 32), np.array([values, values + values]))


def test_outputs_may_be_rows_and_lanes_of_a_larger_array() -> None:
    program, inputs, outputs, lanes = random_program(8)
    whole = np.full((2 * outputs, lanes + 9), 7.0)
    part = whole[::-2, 5 : lanes + 5]
    kernel.run_program(program.handle(len(inputs), outputs, 32), inputs, part)
    assert_same(part, program.oracle(inputs, outputs, lanes))
    assert (whole[::2] == 7.0).all() and (whole[:, :5] == 7.0).all()
    assert (whole[:, lanes + 5 :] == 7.0).all()


def test_a_program_keeps_what_it_was_made_of() -> None:
    program, inputs, outputs, lanes = random_program(9)
    fields = program.fields()
    handle = kernel.program(*fields, len(inputs), outputs, 32)
    for tape in (fields[0], fields[2]):
        tape[:] = 10**9
    fields[1][:] = np.nan
    found = np.empty((outputs, lanes))
    kernel.run_program(handle, inputs, found)
    assert_same(found, program.oracle(inputs, outputs, lanes))


def test_what_a_program_never_set_is_zero() -> None:
    program = Program(2)
    program.code = [[LOAD, 0, 0], [STORE, 1, 0]]
    assert_same(program.run([np.ones(40)], 2, 40, 32), np.zeros((2, 40)))


# ------------------------------------------------------------------------------------ stages


def newton_step() -> Program:
    """A step of Heron's for the square root y of x: the new y, and how far it moved."""
    program = Program(6)
    program.constants = [0.5]
    program.prologue = [[KST, 0, 0]]
    program.code = [
        [LOAD, 1, 0],
        [LOAD, 2, 1],
        [NUMBER["DIV"], 3, 2, 1],
        [NUMBER["ADD"], 3, 1, 3],
        [NUMBER["MUL"], 4, 0, 3],
        [STORE, 4, 0],
        [NUMBER["SUB"], 5, 4, 1],
        [NUMBER["ABS"], 5, 5],
        [STORE, 5, 1],
    ]
    return program


def difference() -> Program:
    program = Program(3)
    program.code = [[LOAD, 0, 0], [LOAD, 1, 1], [NUMBER["SUB"], 2, 0, 1], [STORE, 2, 0]]
    return program


def heron(start: Array, x: Array, within: float, most: int) -> tuple[Array, Array, int]:
    """Return roots of a block, how far the last step moved them, and how many passes it took."""
    y = start
    passes = 0
    while passes < most:
        passes += 1
        with np.errstate(all="ignore"):
            after = 0.5 * (y + x / y)
            moved = np.abs(after - y)
        y = after
        if np.all(moved <= within):
            break
    return y, moved, passes


def integers(*values: int) -> NDArray[np.int32]:
    return np.array(values, dtype=np.int32)


def expected_of_stages(
    x: Array, block: int, within: float, most: int
) -> tuple[Array, NDArray[np.int32]]:
    """Rows: root, last step, the root again and its change by two steps more."""
    lanes = len(x)
    rows, passes = np.empty((4, lanes)), np.empty(-(-lanes // block), np.int32)
    for place, first in enumerate(range(0, lanes, block)):
        # The last block lies over the one before it, and writes its own lanes.
        part = slice(min(first, lanes - block), None)
        part = slice(part.start, part.start + block)
        own = slice(first - part.start, None)
        y, moved, passes[place] = heron(np.ones(block), x[part], within, most)
        again, _, _ = heron(y, x[part], -1.0, 2)
        with np.errstate(all="ignore"):
            change = again - y
        found = np.array([y, moved, again, change])
        rows[:, first : first + block] = found[:, own]
    return rows, passes


def stages_of(
    x: Array, block: int, within: float, most: int
) -> tuple[list[tuple[Any, ...]], Array, NDArray[np.int32]]:
    """Steps to the root of x from 1; two more; what these change."""
    lanes = len(x)
    rows = np.full((5, lanes), 7.0)
    passes = np.zeros(-(-lanes // block), np.int32)
    handle = newton_step().handle(2, 2, block)
    handle_of_difference = difference().handle(2, 1, block)
    carried, none = integers(0, -1), integers(-1, -1)
    stages: list[tuple[Any, ...]] = [
        (handle, [np.ones(()), x], carried, none, 1, within, most, passes, rows[0:2]),
        (handle, [None, x], carried, integers(0, -1), -1, 0.0, 2, None, rows[2:4]),
        (handle_of_difference, (None, rows[0]), none, integers(0, -1), -1, 0.0, 1, None, rows[4:5]),
    ]
    return stages, rows, passes


@pytest.mark.usefixtures("instructions")
@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize(("within", "most"), [(1e-12, 50), (1e-12, 3), (0.0, 12), (-1.0, 4)])
def test_stages_hand_on_their_results(block: int, within: float, most: int) -> None:
    lanes = 6 * block + 3
    x = np.sort(np.exp(RNG(0).normal(0.0, 6.0, lanes)))
    x[2 * block + 1] = np.nan  # It is never within a bound.
    expected, passes = expected_of_stages(x, block, within, most)
    stages, rows, found = stages_of(x, block, within, most)
    kernel.run_stages(stages, lanes, block)
    assert_same(rows[:3], expected[:3])
    assert_same(rows[4], expected[3])
    np.testing.assert_array_equal(found, passes)
    assert found[2] == most
    if within > 0.0 and most > 12:
        assert len(set(found)) > 2


@pytest.mark.parametrize("block", BLOCKS)
def test_lanes_of_a_stage_depend_on_those_of_their_block_alone(block: int) -> None:
    lanes = 4 * block
    x = np.exp(RNG(1).normal(0.0, 6.0, lanes))
    together, rows, _ = stages_of(x, block, 1e-12, 50)
    kernel.run_stages(together, lanes, block)
    for first in range(0, lanes, block):
        alone, own, _ = stages_of(x[first : first + block], block, 1e-12, 50)
        kernel.run_stages(alone, block, block)
        assert_same(own, rows[:, first : first + block])


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("most", [1, 2, 3])
def test_carried_inputs_are_rows_of_the_last_pass(block: int, most: int) -> None:
    """Whatever this pass has stored of them meanwhile."""
    program = Program(1)
    program.code = [[LOAD, 0, 0], [STORE, 0, 1], [LOAD, 0, 1], [STORE, 0, 0]]
    first, second = numbers(2, block, 0)
    rows = np.empty((2, block))
    ends = (-1, 0.0, most, None, rows)
    exchanged = (program.handle(2, 2, block), [first, second], integers(0, 1), integers(-1, -1))
    kernel.run_stages([(*exchanged, *ends)], block, block)
    assert_same(rows, np.array([second, first] if most % 2 else [first, second]))


@pytest.mark.parametrize(
    ("stage", "field", "value", "error"),
    [
        (0, 0, None, ValueError),
        (0, 1, [np.ones(()), None], TypeError),
        (0, 1, [np.ones(())], ValueError),
        (1, 1, [np.ones(49), np.ones(50)], ValueError),
        (0, 2, integers(2, -1), ValueError),
        (0, 2, integers(-2, -1), ValueError),
        (0, 2, integers(0), ValueError),
        (0, 2, np.array([0, -1]), TypeError),
        (0, 3, integers(0, -1), ValueError),  # There is no stage before the first.
        (1, 3, integers(2, -1), ValueError),
        (1, 3, integers(-1, -1), TypeError),
        (2, 3, integers(2, -1), ValueError),
        (0, 4, 2, ValueError),
        (0, 4, -2, ValueError),
        (0, 5, None, TypeError),
        (0, 6, 0, ValueError),
        (0, 6, 2**31, ValueError),
        (0, 7, np.zeros(1, np.int32), ValueError),
        (0, 7, np.zeros(2), TypeError),
        (0, 8, np.ones((1, 50)), ValueError),
        (0, 8, np.ones((2, 49)), ValueError),
        (0, 8, [], TypeError),
    ],
)
def test_fields_of_stages_are_checked(
    stage: int, field: int, value: object, error: type[Exception]
) -> None:
    stages, _, _ = stages_of(np.ones(50), 32, 0.0, 3)
    kernel.run_stages(stages, 50, 32)
    stages[stage] = (*stages[stage][:field], value, *stages[stage][field + 1 :])
    with pytest.raises(error):
        kernel.run_stages(stages, 50, 32)


@pytest.mark.parametrize("source", ["carried", "taken"])
def test_a_uniform_input_cannot_be_a_row(source: str) -> None:
    program = Program(1)
    program.prologue, program.code = [[LDU, 0, 0]], [[STORE, 0, 0]]
    rows = {"carried": integers(-1), "taken": integers(-1)}

    def stage() -> tuple[Any, ...]:
        ends = (-1, 0.0, 2, None, np.ones((1, 40)))
        return (program.handle(1, 1, 32), [np.ones(())], rows["carried"], rows["taken"], *ends)

    first = stage()
    kernel.run_stages([first, stage()], 40, 32)
    rows[source] = integers(0)
    with pytest.raises(ValueError, match="one number for all lanes"):
        kernel.run_stages([first, stage()], 40, 32)


@pytest.mark.parametrize(
    ("place", "value", "error"),
    [
        (0, [], ValueError),
        (0, [()], TypeError),
        (0, [[None] * 9], TypeError),
        (0, 3, TypeError),
        (1, 49, ValueError),
        (1, 31, ValueError),
        (1, -1, ValueError),
        (2, 4, ValueError),
        (2, 33, ValueError),
    ],
)
def test_arguments_of_stages_are_checked(place: int, value: object, error: type[Exception]) -> None:
    arguments = [stages_of(np.ones(50), 32, 0.0, 3)[0], 50, 32]
    kernel.run_stages(*arguments)
    arguments[place] = value
    with pytest.raises(error):
        kernel.run_stages(*arguments)


# --------------------------------------------------------------------------------- malformed


def well_formed() -> Program:
    program = Program(6)
    program.constants = [2.0]
    program.prologue = [[KST, 0, 0], [LDU, 1, 0]]
    program.code = [
        [LOAD, 2, 1],
        [NUMBER["P3"], 3, 0, 1, 2, 2, 1, 0],
        [NUMBER["SC"], 4, -1, 3],
        [NUMBER["P2"], 5, 0, 1, 2, 3],
        [STORE, 5, 1],
    ]
    return program


MISFITS = [
    # Row of the prologue or code, place in it, what stands there.
    *[("code", 0, 0, operation) for operation in (-1, len(OPERATIONS), 2**31 - 1, -(2**31))],
    *[("code", 1, place, at) for place in range(1, 8) for at in (-1, 6, 2**28, -(2**28))],
    *[("code", 2, place, at) for place in (1, 2, 3) for at in (-2, 6)],
    ("code", 2, 3, -1),
    *[("code", 3, place, 6) for place in range(1, 6)],
    *[("code", 0, 2, index) for index in (-1, 2, 2**31 - 1)],
    *[("code", 4, 2, index) for index in (-1, 2, 2**31 - 1)],
    *[("prologue", 0, 2, index) for index in (-1, 1, 2**31 - 1)],
    *[("prologue", 1, 2, index) for index in (-1, 2, 2**31 - 1)],
    ("code", 5, 0, NUMBER["ADD"]),
    ("prologue", 2, 0, NUMBER["ADD"]),
    # Outputs, and inputs of lanes, have no place in a prologue.
    ("prologue", 0, 0, STORE),
    ("prologue", 1, 0, LOAD),
]


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize(("tape", "row", "place", "value"), MISFITS)
def test_instructions_that_leave_a_program_are_refused(
    tape: str, row: int, place: int, value: int, block: int
) -> None:
    fields = well_formed().fields()
    kernel.program(*fields, 2, 2, block)
    fields[{"prologue": 0, "code": 2}[tape]][row, place] = value
    with pytest.raises(ValueError, match=tape):
        kernel.program(*fields, 2, 2, block)


@pytest.mark.parametrize(
    ("place", "value", "error"),
    [
        (0, np.zeros((0, 8), np.int32), ValueError),
        (0, np.zeros((1, 7), np.int32), ValueError),
        (0, np.zeros(8, np.int32), ValueError),
        (0, np.zeros((1, 8), np.int64), TypeError),
        (0, np.zeros((1, 8), np.uint32), TypeError),
        (0, np.zeros((1, 8), ">i4"), TypeError),
        (0, np.zeros((1, 16), np.int32)[:, ::2], ValueError),
        (0, [[0] * 8], TypeError),
        (1, np.zeros(1, np.float32), TypeError),
        (1, memoryview(bytearray(17))[1:].cast("d"), ValueError),
        (2, np.zeros((0, 8), np.int32), ValueError),
        (3, 5, ValueError),
        (3, -1, ValueError),
        (3, 2**31, ValueError),
        (3, 2**80, OverflowError),
        (3, 1.5, TypeError),
        (4, 1, ValueError),
        (4, -1, ValueError),
        (5, 1, ValueError),
        (5, -1, ValueError),
        (6, 8, ValueError),
        (6, 0, ValueError),
    ],
)
def test_other_fields_of_a_program_are_checked(
    place: int, value: object, error: type[Exception]
) -> None:
    arguments = [*well_formed().fields(), 2, 2, 32]
    kernel.program(*arguments)
    arguments[place] = value
    with pytest.raises(error):
        kernel.program(*arguments)


@pytest.mark.parametrize(
    ("place", "value", "error"),
    [
        (0, None, ValueError),
        (1, [np.ones(1)], ValueError),
        (1, [np.ones(1), np.ones(50), np.ones(50)], ValueError),
        (1, [np.ones(50), np.ones(50)], ValueError),  # An LDU wants one number.
        (1, [np.ones(1), np.ones(49)], ValueError),
        (1, [np.ones(1), np.ones(51)], ValueError),
        (1, [np.ones(1), np.ones(0)], ValueError),
        (1, [np.ones(1), np.ones(100)[::2]], ValueError),
        (1, [np.ones(1), np.ones(50, np.float32)], TypeError),
        (1, [np.ones(1), None], TypeError),
        (1, 3, TypeError),
        (2, np.ones((1, 50)), ValueError),
        (2, np.ones((3, 50)), ValueError),
        (2, np.ones((2, 31)), ValueError),
        (2, np.ones((2, 0)), ValueError),
        (2, np.ones((2, 100))[:, ::2], ValueError),
        (2, np.ones((50, 2)).T, ValueError),
        (2, np.ones(100), ValueError),
        (2, np.ones((2, 50), np.float32), TypeError),
    ],
)
def test_arguments_of_a_run_are_checked(place: int, value: object, error: type[Exception]) -> None:
    arguments = [well_formed().handle(2, 2, 32), [np.ones(1), np.ones(50)], np.ones((2, 50))]
    kernel.run_program(*arguments)
    arguments[place] = value
    with pytest.raises(error):
        kernel.run_program(*arguments)


def test_outputs_have_to_be_writable() -> None:
    outputs = np.ones((2, 50))
    outputs.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        kernel.run_program(well_formed().handle(2, 2, 32), [np.ones(1), np.ones(50)], outputs)


@pytest.mark.parametrize(
    "inputs",
    [
        [np.ones((3, 50))],
        [np.ones((1, 50))],
        [np.ones((2, 49))],
        [np.ones((2, 100))[:, ::2]],
        [np.ones((1, 2, 50))],
        [np.ones((2, 0))],
        [np.ones((2, 50)), np.ones((0, 49))],
        [np.ones((2, 50), dtype=np.float32)],
    ],
)
def test_rows_of_inputs_are_checked(inputs: list[np.ndarray]) -> None:
    trace = tapes.Trace()
    x, y = trace.input("x", 1.0), trace.input("y", 1.0)
    handle, outputs = tapes.Program(trace, [x + y, x - y]).handle(32), np.ones((2, 50))
    kernel.run_program(handle, [np.ones((2, 50))], outputs)
    with pytest.raises((TypeError, ValueError)):
        kernel.run_program(handle, inputs, outputs)
