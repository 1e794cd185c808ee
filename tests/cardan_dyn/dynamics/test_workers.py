"""Workers: the same results in the same order, errors as of one worker, nothing left behind."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.dynamics import workers
from cardan_dyn.dynamics.workers import can_fork, in_order, shares_of

forks = pytest.mark.skipif(not can_fork(), reason="this platform does not fork")


def each(tasks: Sequence[Callable[[], Any]], count: int) -> list[Any]:
    """Return what tasks return, one share of them after the other."""
    shares = in_order(lambda share: [tasks[k]() for k in share], shares_of(len(tasks), count))
    return [result for share in shares for result in share]


def process_and_number(number: int) -> tuple[int, int]:
    return os.getpid(), number


@forks
@pytest.mark.parametrize("count", [1, 2, 3])
def test_results_are_in_order_whoever_computed_them(count: int) -> None:
    found = each([partial(process_and_number, number) for number in range(13)], count)
    assert [number for _, number in found] == list(range(13))
    assert found[0][0] == os.getpid()
    assert len({process for process, _ in found}) == count
    assert not multiprocessing.active_children()


def test_few_tasks_are_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    tasks = [partial(process_and_number, number) for number in range(7)]
    assert {process for process, _ in each(tasks, 5)} == {os.getpid()}
    assert each([], 3) == []
    monkeypatch.setattr(workers, "can_fork", lambda: False)
    assert {process for process, _ in each(3 * tasks, 5)} == {os.getpid()}


def failing(number: int, at: int) -> int:
    if number >= at:
        raise cd.AssemblyError(
            f"task {number}", position=float(number), nearest=None, residual=1.0, sample=number
        )
    return number


@forks
@pytest.mark.parametrize("at", [0, 3, 9])
def test_the_first_error_is_raised(at: int) -> None:
    with pytest.raises(cd.AssemblyError, match=f"task {at}") as caught:
        each([partial(failing, number, at) for number in range(12)], 3)
    assert caught.value.sample == at
    assert not multiprocessing.active_children()


@forks
def test_a_lost_worker_is_reported() -> None:
    here = os.getpid()

    def dying() -> None:
        if os.getpid() != here:
            os._exit(9)

    with pytest.raises(cd.CardanError, match="a worker process was lost"):
        each([dying] * 8, 2)


@pytest.mark.slow
@forks
@pytest.mark.parametrize("along_path", [False, True])
def test_sweeps_are_the_same_to_the_last_bit(shaft: cd.Mechanism, along_path: bool) -> None:
    held = {"joint_angle_1": 0.3, "joint_angle_2": 0.2}
    scene = cd.Scene(shaft, drive="bearing_in", held=held, loads={"bearing_out": -10.0})
    position = np.linspace(0.0, 20.0, 7000)
    scene.sweep(position)
    closed = scene.assemble(position, along_path=along_path)
    alone = scene.sweep(closed, 9.0)
    for count in (2, 3):
        shared = scene.sweep(closed, 9.0, workers=count)
        for name in alone:
            np.testing.assert_array_equal(shared[name].force, alone[name].force)
            np.testing.assert_array_equal(shared[name].moment, alone[name].moment)
        np.testing.assert_array_equal(shared.motion.a, alone.motion.a)
        np.testing.assert_array_equal(shared.condition, alone.condition)
        assert shared.balance_residual == alone.balance_residual
    angle = np.linspace(0.1, 0.6, 7000)
    together = scene.sweep(position, held={"joint_angle_2": angle}, workers=2)
    assert together.balance_residual < 1e-12


@pytest.mark.parametrize("count", [0, -1, 1.5, True, "two", None])
def test_numbers_of_workers(joint: cd.Mechanism, count: object) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    with pytest.raises(cd.ArgumentError, match=r"workers is .*, expected a whole number from 1 on"):
        scene.sweep(0.0, workers=count)  # type: ignore[arg-type]
