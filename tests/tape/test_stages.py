"""Stages: programs that hand on their outputs, and repeat until these are small."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from cardan_dyn.core import compiled, tape
from cardan_dyn.core.tape import Program, Stage, Stages, Trace
from cardan_dyn.kit import errors

COUNTS = [1, 3, 4, 5, 32, 33, 100]


def root_step() -> Program:
    """Return a step of Newton's method for a square root, and how far it goes.

    A lane that is done stays as it is.
    """
    trace = Trace()
    square, guess = trace.input("square", 2.0), trace.input("guess", 1.0)
    step = 0.5 * (square / guess - guess)
    left = tape.absolute(step) - 4e-16 * guess
    return Program(trace, [guess + tape.select(left, step, 0.0), tape.select(left, left, 0.0)])


def doubled() -> Program:
    trace = Trace()
    x = trace.input("x", 1.0)
    m = trace.input("m", 1.0, uniform=True)
    return Program(trace, [m * x, x, m * m])


def newton(most: int = 50, kept: bool = False) -> Stage:
    return Stage(root_step(), carried={"guess": 0}, until=1, most=most, kept=kept)


def both(stages: Stages, inputs: list[dict[str, object]], count: int) -> list[list[np.ndarray]]:
    """Return what stages give on the machine and on arrays."""
    return [
        stages.run(inputs, count),
        stages.run_on_arrays(inputs, count),
        stages.run_on_arrays(inputs, count, block=7),
    ]


@pytest.mark.parametrize("count", COUNTS)
def test_a_stage_repeats_until_its_lanes_are_done_and_hands_on(count: int) -> None:
    squares = np.linspace(0.1, 90.0, count)
    stages = Stages([newton(kept=True), Stage(doubled(), taken={"x": 0}, kept=True)])
    inputs: list[dict[str, object]] = [{"square": squares, "guess": 1.0}, {"m": 2.0}]
    for roots, twice in both(stages, inputs, count):
        assert roots.shape == (2, count)
        np.testing.assert_allclose(roots[0], np.sqrt(squares), rtol=1e-15)
        assert np.all(roots[1] == 0.0)
        np.testing.assert_array_equal(twice, [2.0 * roots[0], roots[0], np.full(count, 4.0)])


def test_stages_give_the_same_on_the_machine_and_on_arrays() -> None:
    squares = np.linspace(0.1, 90.0, 100)
    stages = Stages([newton(), Stage(doubled(), taken={"x": 0}, kept=True)])
    inputs: list[dict[str, object]] = [{"square": squares, "guess": 1.0}, {"m": 2.0}]
    first, *others = both(stages, inputs, 100)
    assert len(first) == 1
    for other in others:
        np.testing.assert_array_equal(other, first)
    few = stages.run([{"square": squares[40:45], "guess": 1.0}, {"m": 2.0}], 5)
    np.testing.assert_array_equal(few[0], first[0][:, 40:45])


@pytest.mark.parametrize("most", [1, 2, 3])
def test_a_stage_ends_after_its_most_passes(most: int) -> None:
    stages = Stages([newton(most, kept=True)])
    guess = 1.0
    for _ in range(most):
        guess += 0.5 * (1e4 / guess - guess)
    for (found,) in both(stages, [{"square": 1e4, "guess": 1.0}], 5):
        assert found[0].tolist() == [guess] * 5


def test_passes_are_counted_and_end_within_a_bound_but_never_at_nan() -> None:
    trace = Trace()
    count, left = trace.input("count", 0.0), trace.input("left", 4.0)
    program = Program(trace, [count + 1.0, left - 1.0])
    carried = {"count": 0, "left": 1}

    def passes(left: float, **kwargs: float) -> list[float]:
        stage = Stage(program, carried=carried, until=1, most=9, kept=True, **kwargs)  # type: ignore[arg-type]
        found = [rows[0] for (rows,) in both(Stages([stage]), [{"count": 0.0, "left": left}], 4)]
        assert all(set(row) == set(found[0]) for row in found)
        return sorted(set(found[0]))

    assert passes(4.0) == [4.0]
    assert passes(4.5) == [5.0]
    assert passes(4.0, within=2.0) == [2.0]
    assert passes(-1.0) == [1.0]
    assert passes(np.nan) == [9.0]
    # All lanes of a block wait for the slowest.
    stages = Stages([Stage(program, carried=carried, until=1, most=9, kept=True)])
    for (rows,) in both(stages, [{"count": 0.0, "left": [1.0, 6.0, 2.0, 3.0]}], 4):
        assert rows[0].tolist() == [6.0] * 4
    # Lanes that fill up a block do not make others wait.
    stages = Stages([Stage(program, carried=carried, until=1, most=9, within=-3.0, kept=True)])
    for (rows,) in both(stages, [{"count": 0.0, "left": [-5.0, -6.0, -7.0]}], 3):
        assert rows[0].tolist() == [1.0] * 3
    # Without a row that ends them, passes are as many as may be.
    for (rows,) in both(
        Stages([Stage(program, carried=carried, most=3, kept=True)]),
        [{"count": 0.0, "left": 0.0}],
        6,
    ):
        assert rows[0].tolist() == [3.0] * 6


def test_an_input_may_be_taken_first_and_carried_then() -> None:
    program = doubled()
    first = Stage(program, kept=True)
    second = Stage(program, carried={"x": 0}, taken={"x": 0}, most=3, kept=True)
    inputs: list[dict[str, object]] = [{"x": [1.0, 2.0, 3.0], "m": 2.0}, {"m": 10.0}]
    for one, other in both(Stages([first, second]), inputs, 3):
        assert one[0].tolist() == [2.0, 4.0, 6.0]
        assert other[0].tolist() == [2000.0, 4000.0, 6000.0]


def test_carried_inputs_change_places_at_once() -> None:
    trace = Trace()
    a, b = trace.input("a", 1.0), trace.input("b", 1.0)
    stage = Stage(Program(trace, [b, a + b]), carried={"a": 0, "b": 1}, most=20, kept=True)
    for (found,) in both(Stages([stage]), [{"a": 0.0, "b": 1.0}], 2):
        assert found[:, 0].tolist() == [6765.0, 10946.0]


def test_names_that_a_program_does_not_depend_on_are_ignored() -> None:
    trace = Trace()
    x = trace.input("x", 1.0)
    trace.input("y", 1.0)
    stage = Stage(Program(trace, [x + 1.0]), carried={"x": 0, "y": 0}, most=2, kept=True)
    after = Stage(Program(trace, [x]), taken={"x": 0, "y": 0}, kept=True)
    for one, other in both(Stages([stage, after]), [{"x": 0.0}, {}], 3):
        assert one.tolist() == other.tolist() == [[2.0] * 3]


def test_no_lanes_and_no_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    stages = Stages([newton(kept=True)])
    inputs: list[dict[str, object]] = [{"square": 2.0, "guess": 1.0}]
    assert stages.run(inputs, 0)[0].shape == (2, 0)
    assert Stages([]).run([], 5) == []
    expected = stages.run(inputs, 5)
    copy = pickle.loads(pickle.dumps(stages))
    monkeypatch.setattr(compiled, "kernel", None)
    np.testing.assert_array_equal(copy.run(inputs, 5), expected)


def test_wrong_stages_and_inputs_are_refused() -> None:
    program = doubled()
    for wrong, told in (
        ([Stage(program, carried={"x": 3})], "row 3 of its outputs as 'x'; there are 3"),
        ([Stage(program, carried={"x": -1})], "row -1"),
        ([Stage(program, until=3)], "row 3"),
        ([Stage(program, taken={"x": 0})], "there are 0"),
        ([newton(), Stage(program, taken={"x": 2})], "row 2 of outputs of the stage before"),
        ([Stage(program, carried={"m": 0})], "'m' of stage 0 is uniform"),
        ([Stage(program, most=0)], "most=0"),
    ):
        with pytest.raises(errors.ArgumentError, match=told):
            Stages(wrong)
    stages = Stages([newton(), Stage(program, taken={"x": 0})])
    right: list[dict[str, object]] = [{"square": 2.0, "guess": 1.0}, {"m": 2.0}]
    for run in (stages.run, stages.run_on_arrays):
        with pytest.raises(errors.ArgumentError, match="inputs of 2 stages, not of 1"):
            run(right[:1], 4)
        with pytest.raises(errors.ArgumentError, match="'guess'"):
            run([{"square": 2.0}, {"m": 2.0}], 4)
