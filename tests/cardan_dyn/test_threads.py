"""Threads: the same results for any number of them, errors as of one, and none that is left."""

from __future__ import annotations

import signal
import threading
import time
import warnings
from collections.abc import Callable

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.kit.arrays import LARGE_BLOCK
from cardan_dyn.kit.threads import cores, in_threads, in_turn, on_cores

NUMBERS = [1, 2, 8]


@pytest.fixture(autouse=True)
def none_is_left() -> object:
    before = threading.active_count()
    yield
    assert threading.active_count() == before


@pytest.mark.parametrize("count", NUMBERS)
def test_results_are_in_order_and_threads_are_as_many_as_cores(count: int) -> None:
    together = threading.Barrier(count, timeout=10.0)
    told: list[int] = []

    def work(item: int) -> tuple[int, str]:
        together.wait()  # For as many others as there are cores, at the same time.
        return item, threading.current_thread().name

    with on_cores(count):
        found = in_threads(work, range(2 * count), told.append)
    assert [item for item, _ in found] == list(range(2 * count))
    assert len({name for _, name in found}) == count
    assert told == sorted(told)
    assert 1 <= told[0] <= told[-1] <= 2 * count


def test_no_thread_is_started_for_few_items_or_within_another() -> None:
    here = threading.current_thread()

    def inner(item: int) -> object:
        return threading.current_thread()

    with on_cores(8):
        assert in_threads(inner, [1]) == [here]
        assert in_threads(inner, []) == []
        for thread, *others in in_threads(lambda _: [*in_threads(inner, [1, 2, 3]), 1], "ab"):
            assert thread is not here
            assert others == [thread, thread, 1]
        assert cores() == 8
    assert cores() >= 1


@pytest.mark.parametrize("count", NUMBERS)
def test_what_is_learned_is_learned_in_turn(count: int) -> None:
    """Whoever is fast or slow, items see the same; of those that ask, most are begun only twice."""
    known: list[int] = []
    begun: list[int] = []

    def work(item: int) -> tuple[int, ...]:
        begun.append(item)
        time.sleep(1e-4 * (item % 3))
        seen = tuple(known)
        if item % 10 == 7 and item not in known:
            in_turn()
            known.append(item)
        return seen

    with on_cores(count):
        found = in_threads(work, range(40))
    assert known == [7, 17, 27, 37]
    # First 7 alone, which the others have begun without; then 17 and 27.
    assert [len(seen) for seen in found] == [
        {7: 0, 17: 1, 27: 2, 37: 3}.get(item, 0) for item in range(40)
    ]
    assert len(begun) == 40 + 4 + 3 + 1
    in_turn()  # Nothing is beside this.


@pytest.mark.parametrize("count", NUMBERS)
@pytest.mark.parametrize("at", [0, 3, 9])
def test_the_first_error_is_raised(count: int, at: int) -> None:
    done: list[int] = []

    def failing(item: int) -> None:
        if item >= at:
            time.sleep(0.02 if item == at else 0.0)
            raise cd.CardanError(f"item {item}")
        done.append(item)

    with on_cores(count), pytest.raises(cd.CardanError, match=f"item {at}$"):
        in_threads(failing, range(1000))
    assert sorted(done) == list(range(at))


@pytest.mark.parametrize("count", NUMBERS)
def test_an_interrupt_ends_it_soon(count: int) -> None:
    # A process that was started behind others may ignore interrupts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    begun: list[int] = []

    def work(item: int) -> None:
        begun.append(item)
        if item == 5:
            time.sleep(0.1)  # Until all threads run.
            signal.raise_signal(signal.SIGINT)
        time.sleep(0.01)

    try:
        with on_cores(count), pytest.raises(KeyboardInterrupt):
            in_threads(work, range(1000))
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(begun) < 100


@pytest.mark.parametrize("count", NUMBERS)
def test_numpy_warns_of_what_it_is_told_here(count: int) -> None:
    def overflowing(item: float) -> float:
        return float(np.array([1e300]) @ np.array([1e300]) + np.exp(np.array([item]))[0])

    with on_cores(count), warnings.catch_warnings():
        warnings.simplefilter("error")
        with np.errstate(over="ignore"):
            assert in_threads(overflowing, [1e3, 1e4]) == [np.inf, np.inf]
        with np.errstate(over="raise"), pytest.raises(FloatingPointError):
            in_threads(overflowing, [1e3, 1e4])


def one_drive(count: int) -> cd.Sweep:
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5})
    return scene.sweep(np.linspace(0.0, 50.0, count), 9.0)


def load_from_the_middle_on(count: int) -> cd.Sweep:
    """The tape of the first block leaves out what acts in others."""
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5})
    torque = np.where(np.arange(count) < 0.6 * count, 0.0, -10.0)
    return scene.sweep(np.linspace(0.0, 50.0, count), 9.0, loads={"bearing_out": torque})


def two_drives(count: int) -> cd.Sweep:
    """Lines to each sample, by tapes; a spring, whose forces follow of the motion."""
    spring = cd.JointSpring("bearing_out", 5.0, 0.1)
    drives = ["bearing_in", "joint_angle"]
    scene = cd.Scene(cd.load("universal_joint"), drive=drives, elements=[spring])
    turn = np.random.default_rng(0).uniform(0.0, 6.0, count)
    return scene.sweep(np.stack([turn, 0.1 * turn + 0.1], axis=-1), 3.0)


def compliant(count: int) -> cd.Sweep:
    """What no tape knows."""
    compliance = {"bearing_out": np.eye(6)}
    held = {"joint_angle_1": 0.3, "joint_angle_2": 0.2}
    scene = cd.Scene(
        cd.load("double_shaft_z"), drive="bearing_in", held=held, compliance=compliance
    )
    return scene.sweep(np.linspace(0.0, 20.0, count), 9.0, loads={"bearing_out": -10.0})


@pytest.mark.parametrize("count", [LARGE_BLOCK - 1, LARGE_BLOCK, LARGE_BLOCK + 1, 3 * LARGE_BLOCK])
@pytest.mark.parametrize("swept", [one_drive, load_from_the_middle_on, two_drives, compliant])
def test_sweeps_are_the_same_to_the_last_bit(swept: Callable[[int], cd.Sweep], count: int) -> None:
    expected, *others = (on(number, swept, count) for number in NUMBERS)
    for found in others:
        for name in expected:
            np.testing.assert_array_equal(found[name].force, expected[name].force)
            np.testing.assert_array_equal(found[name].moment, expected[name].moment)
        for rates in ("v", "a"):
            own, other = (getattr(sweep.motion, rates) for sweep in (found, expected))
            np.testing.assert_array_equal(own, other)
        np.testing.assert_array_equal(found.drive_effort, expected.drive_effort)
        np.testing.assert_array_equal(found.condition, expected.condition)
        for residual in ("loop", "balance", "power", "rate"):
            assert getattr(found, f"{residual}_residual") == getattr(
                expected, f"{residual}_residual"
            )


def on(number: int, swept: Callable[[int], cd.Sweep], count: int) -> cd.Sweep:
    with on_cores(number):
        return swept(count)


@pytest.mark.parametrize("count", NUMBERS)
def test_what_a_block_raises_is_raised(count: int) -> None:
    """Of an actuator in a thread."""

    def broken(time: float) -> float:
        if np.max(time) > 2.0:
            raise ZeroDivisionError("of the user")
        return 0.0 * time

    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        elements=[cd.Actuator("bearing_out", broken)],
    )
    times = np.linspace(0.0, 5.0, 5 * LARGE_BLOCK)
    with on_cores(count), pytest.raises(cd.ArgumentError, match="of the user"):
        scene.sweep(np.linspace(0.0, 6.0, len(times)), time=times)
