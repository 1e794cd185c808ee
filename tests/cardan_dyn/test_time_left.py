"""Progress: shown where somebody looks and of what takes long, moved on by what runs inside."""

from __future__ import annotations

import io
import os
import sys
import threading
import types

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.kit import time_left
from cardan_dyn.kit.threads import on_cores
from cardan_dyn.kit.time_left import Task, duration


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr(time_left.time, "monotonic", lambda: now[0])
    return now


def test_a_line_says_what_how_far_and_how_long_yet(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with Task("sweep", 10, wanted=True) as task:
        clock[0] += 1.0
        task.tell(1)
        assert capsys.readouterr().err == ""  # Nobody waits for that.
        clock[0] += 29.0
        task.tell(3, "3 failed")
        line = capsys.readouterr().err
        assert line.startswith("\rsweep") and "30 %" in line and "1:10 left  3 failed" in line
        clock[0] += 0.1
        task.tell(4)
        assert capsys.readouterr().err == ""  # Too soon after the last one.
    assert capsys.readouterr().err.strip() == ""
    assert not time_left._running


def test_what_runs_inside_moves_on_what_is_outside(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with Task("joints", 4, wanted=True) as outer:
        outer.tell(1)
        with Task("simulation", 2.0, wanted=True) as inner:
            clock[0] += 10.0
            inner.tell(1.0)
        line = capsys.readouterr().err
        assert line.startswith("\rjoints") and "38 %" in line
        # Another one inside of the same step does not go back.
        with Task("simulation", 2.0, wanted=True) as inner:
            clock[0] += 10.0
            inner.tell(0.2)
        assert "38 %" in capsys.readouterr().err
        clock[0] += 10.0
        outer.tell(2)
        assert "50 %" in capsys.readouterr().err


def test_many_that_are_short_make_a_long_one(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with Task("resonances", 2, wanted=True):
        for _ in range(4):
            with Task("branch", 2.0, wanted=True) as inner:
                clock[0] += 1.0
                inner.tell(1.0)
    assert "\rresonances" in capsys.readouterr().err


def test_an_error_ends_a_task(clock: list[float]) -> None:
    with pytest.raises(KeyboardInterrupt), Task("outer", 1, wanted=True):
        Task("inner, never closed", 1, wanted=True)
        raise KeyboardInterrupt
    assert not time_left._running


def test_nothing_is_shown_where_nobody_looks(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with Task("sweep", 2) as task:
        clock[0] += 10.0
        task.tell(1)
    found = []

    def work() -> None:
        with Task("sweep", 2, wanted=True) as task:
            clock[0] += 10.0
            task.tell(1)
            found.append(1)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found and capsys.readouterr().err == ""


def test_a_terminal_is_where_somebody_looks_unless_told_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert not time_left.is_watched()
    monkeypatch.setattr(time_left.sys.stderr, "isatty", lambda: True)
    assert Task("sweep", 1)._is_shown
    with cd.progress(False):
        assert not Task("sweep", 1)._is_shown
    assert Task("sweep", 1)._is_shown
    time_left._running.clear()


def test_a_notebook_is_known_by_its_stream_and_not_by_what_is_imported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "ipykernel", types.ModuleType("ipykernel"))
    assert not time_left.is_watched()
    stream = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream"})()
    monkeypatch.setattr(sys, "stderr", stream)
    assert time_left.is_watched()


def test_the_environment_can_say_no(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.delenv("CARDAN_DYN_PROGRESS", raising=False)
    assert time_left.is_watched()
    monkeypatch.setenv("CARDAN_DYN_PROGRESS", "0")
    assert not time_left.is_watched()


def test_other_processes_say_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "getpid", lambda: -1)
    assert not Task("sweep", 1, wanted=True)._is_shown


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0:00"), (187.2, "3:07"), (7387.0, "2:03:07"), (432000.0, "5 days")],
)
def test_durations(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_sweeps_tell_of_their_blocks_and_change_nothing(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.4})
    turn = np.linspace(0.0, 6.0, 20_000)
    silent = scene.sweep(turn)
    told: list[float] = []
    tell = Task.tell
    monkeypatch.setattr(Task, "tell", lambda task, done: (told.append(done), tell(task, done)))
    monkeypatch.setattr(time_left, "_PATIENCE", 0.0)
    monkeypatch.setattr(time_left, "_EVERY", 0.0)
    with cd.progress(True), on_cores(1):  # What other threads do is told by this one.
        watched = scene.sweep(turn)
    # The clock is asked once for each block, whatever the number of samples.
    assert 1 < len(told) < 100 and told == sorted(told)
    assert "\rsweep" in capsys.readouterr().err
    np.testing.assert_array_equal(silent["bearing_out"].moment, watched["bearing_out"].moment)


@pytest.mark.slow
def test_what_looks_for_motions_and_responses_tells_how_far_it_is(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(time_left, "_PATIENCE", 0.0)
    monkeypatch.setattr(time_left, "_EVERY", 0.0)
    rig = cd.load("elastic_thoma_rig")
    springs, held = cd.described_elements(rig), {"joint_angle": np.deg2rad(8.5)}
    free = list(rig.joint_springs)
    elastic = cd.Scene(rig, drive="bearing_in", free=free, elements=springs, held=held)
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.4})
    calls = {
        "motions": lambda: cd.vibration.forced_response(elastic, [65.0, 70.0], joints=[]),
        "critical speeds": lambda: cd.vibration.critical_speeds(elastic, [100.0, 102.0], orders=2),
        "responses": lambda: scene.responses({"joint_angle": [0.1, 0.2]}),
    }
    for what, call in calls.items():
        with cd.progress(True):
            call()
        said = capsys.readouterr().err
        assert f"\r{what} " in said
        # Nothing is left on the line, and nothing is told that is over.
        assert said.endswith("\r") and not time_left._running
