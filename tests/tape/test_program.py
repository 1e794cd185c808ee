"""Programs: any number of lanes, in any blocks."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from testkit import arithmetic

from cardan_dyn.core import compiled, tape
from cardan_dyn.core.tape import Program, Trace
from cardan_dyn.kit import errors


def random_program(seed: int, outputs: int = 12) -> tuple[Program, dict[str, np.ndarray]]:
    """Return the last steps of a random text without functions of a library, and 1000 lanes."""
    rng = np.random.default_rng(seed)
    text = arithmetic.random_text(rng, 100, operations=list(arithmetic.EXACT))
    trace, steps = text.traced()
    return Program(trace, steps[-outputs:]), arithmetic.random_lanes(rng, text, 1000)


def part(inputs: dict[str, np.ndarray], lanes: slice) -> dict[str, np.ndarray]:
    return {name: values[lanes] for name, values in inputs.items()}


@pytest.mark.parametrize("seed", range(10))
def test_the_machine_and_arrays_give_the_same_to_the_last_bit(seed: int) -> None:
    program, inputs = random_program(seed)
    np.testing.assert_array_equal(program.run(inputs, 1000), program.run_on_arrays(inputs, 1000))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 31, 32, 33, 63, 64, 65, 999])
def test_a_lane_gives_the_same_wherever_it_stands(count: int) -> None:
    program, inputs = random_program(3)
    expected = program.run_on_arrays(inputs, 1000)
    for first in (0, 1):
        lanes = slice(first, first + count)
        few = part(inputs, lanes)
        np.testing.assert_array_equal(program.run(few, count), expected[:, lanes])
        np.testing.assert_array_equal(program.run_on_arrays(few, count), expected[:, lanes])


@pytest.mark.parametrize("block", [1, 2, 7, 999, 1000, 5000])
def test_arrays_give_the_same_in_blocks_of_any_size(block: int) -> None:
    program, inputs = random_program(4)
    expected = program.run_on_arrays(inputs, 1000)
    np.testing.assert_array_equal(program.run_on_arrays(inputs, 1000, block), expected)


def test_programs_without_a_machine_run_on_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    program, inputs = random_program(5)
    expected = program.run(inputs, 1000)
    monkeypatch.setattr(compiled, "kernel", None)
    np.testing.assert_array_equal(program.run(inputs, 1000), expected)


def test_threads_may_run_one_program_on_arrays_at_once() -> None:
    program, inputs = random_program(8)
    expected = program.run_on_arrays(inputs, 1000)
    with ThreadPoolExecutor(4) as pool:
        found = pool.map(lambda _: program.run_on_arrays(inputs, 1000), range(40))
        for rows in found:
            np.testing.assert_array_equal(rows, expected)


def test_no_lanes_and_no_outputs() -> None:
    program, inputs = random_program(6)
    assert program.run(part(inputs, slice(0)), 0).shape == (12, 0)
    assert program.run_on_arrays(part(inputs, slice(0)), 0).shape == (12, 0)
    empty = Program(Trace(), [])
    assert empty.inputs == ()
    assert empty.run({}, 7).shape == empty.run_on_arrays({}, 7).shape == (0, 7)


@pytest.mark.parametrize("count", [1, 3, 40])
def test_outputs_may_be_numbers_inputs_and_the_same_twice(count: int) -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    m = trace.input("m", 1.0, uniform=True)
    y = x * m
    program = Program(trace, [x, 3, y, y, m, -0.0, m + 1.0, x, y + x])
    assert program.outputs == 9
    values = np.linspace(1.0, 2.0, count)
    ones = np.ones(count)
    expected = [values, 3 * ones, 2 * values, 2 * values, 2 * ones, -0.0 * ones, 3 * ones]
    expected += [values, 3 * values]
    for run in (program.run, program.run_on_arrays):
        found = run({"x": values, "m": 2.0}, count)
        np.testing.assert_array_equal(found, expected)
        assert np.all(np.signbit(found[5]))
        # What was returned does not change with the next run.
        run({"x": 0.0, "m": 0.0}, count)
        np.testing.assert_array_equal(found, expected)


def test_inputs_may_be_numbers_and_arrays_of_any_kind() -> None:
    trace = Trace()
    x, y = trace.input("x", 1.0), trace.input("y", 1.0)
    m = trace.input("m", 1.0, uniform=True)
    trace.input("unused", 1.0)
    program = Program(trace, [x * y - m])
    assert program.inputs == ("x", "y", "m")
    expected = [[-1.0, 1.0, 3.0, 5.0, 7.0]]
    wide = np.arange(20.0).reshape(5, 4)
    for xs, y_all, m_all in (
        (np.arange(5), 2, 1),
        ([0, 1, 2, 3, 4], np.array(2.0), np.array([1.0])),
        (wide[:, 0] / 4.0, np.full(5, 2, dtype=np.float32), np.ones((1, 1))),
        (np.arange(4.0, -1.0, -1.0)[::-1], [2.0], True),
    ):
        inputs = {"x": xs, "y": y_all, "m": m_all, "other": "ignored"}
        assert program.run(inputs, 5).tolist() == expected
        assert program.run_on_arrays(inputs, 5).tolist() == expected


def test_wrong_inputs_are_refused() -> None:
    trace = Trace()
    x = trace.input("position", 1.0)
    m = trace.input("mass", 1.0, uniform=True)
    program = Program(trace, [x * m])
    right: dict[str, Any] = {"position": np.ones(5), "mass": 1.0}
    for wrong, told in (
        ({"position": np.ones(5), "masses": 1.0}, "mean 'masses'"),
        ({**right, "position": np.ones(4)}, "one for each of 5 lanes"),
        ({**right, "position": np.ones((5, 1))}, "one for each of 5 lanes"),
        ({**right, "mass": np.ones(5)}, "one number for all lanes"),
    ):
        for run in (program.run, program.run_on_arrays):
            with pytest.raises(errors.ArgumentError, match=told):
                run(wrong, 5)
    with pytest.raises(errors.ArgumentError, match="two traces"):
        Program(Trace(), [x])
    with pytest.raises(errors.ArgumentError, match="numbers and variables"):
        Program(trace, [np.ones(3)])


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 31, 32, 33, 999])
def test_inputs_may_stand_in_rows_of_arrays(count: int) -> None:
    """In any number of arrays, of lanes or of numbers for all, however they lie in memory."""
    trace = Trace()
    names = [str(k) for k in range(9)]
    x = [trace.input(name, 1.0, uniform=name in "67") for name in names]
    outputs = [x[0] * x[7] - x[3], x[1] / x[8], x[2] + x[4], x[6]]  # Of x[5] nothing is made.
    program = Program(trace, outputs, keeps_inputs=True)
    assert program.inputs == tuple(names)
    rng = np.random.default_rng(0)
    a, b, c = rng.normal(size=(count, 3)), rng.normal(size=(1, 5)), rng.normal(size=(2, count, 1))
    rows = [a.T, b.T, c[1, ::1].T]
    given = {str(k): a[:, k] for k in range(3)} | {str(k): b[0, k - 3] for k in range(3, 8)}
    given["8"] = c[1, :, 0]
    expected = program.run_on_arrays(given, count)
    np.testing.assert_array_equal(program.run_rows(rows, count), expected)
    every_other = np.repeat(a, 2, axis=0)[::2].T
    np.testing.assert_array_equal(program.run_rows([every_other, *rows[1:]], count), expected)
    for wrong in (rows[:2], [*rows, b.T], [a.T[:2], *rows[1:]], [b.T, *rows]):
        with pytest.raises(ValueError):
            program.run_rows(wrong, count)


def test_programs_can_be_pickled_and_keep_what_they_give() -> None:
    program, inputs = random_program(7)
    fresh = pickle.dumps(program)
    expected = program.run(inputs, 1000)
    program.run_on_arrays(inputs, 1000)
    used = pickle.dumps(program)
    for text in (fresh, used):
        copy = pickle.loads(text)
        assert copy.inputs == program.inputs
        np.testing.assert_array_equal(copy.run(inputs, 1000), expected)
        np.testing.assert_array_equal(copy.run_on_arrays(inputs, 1000), expected)
    # Arrays of blocks are not part of it.
    assert len(used) < len(fresh) + 64 * len(program.graph.operations) + 2000


def test_what_lanes_do_not_choose_may_be_anything() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    program = Program(trace, [tape.select(x, tape.sqrt(x), 1.0 / (x + 1.0) - tape.log(-x))])
    values = np.array([4.0, -2.0, np.nan, 0.0])
    expected = [2.0, -1.0 - np.log(2.0), np.nan, np.inf]
    for run in (program.run, program.run_on_arrays):
        np.testing.assert_allclose(run({"x": values}, 4)[0], expected, rtol=1e-15)
