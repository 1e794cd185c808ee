"""Simulated runs: their revolutions, where they begin, end and stay."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import VibrationError
from cardan_dyn.core.elements.law import Law
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.driven import drive_torque
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.results.run_up import Rising, SimulatedRun, windows_of


def run(first: float, last: float, torque: Law | None, max_amplitude: float = 1.0) -> SimulatedRun:
    line = elastic_rigs.torsional_line(damping_in=0.2)
    search = MotionSearch(rotating_scene(elastic_rigs.scene(line, 0.2)), max_amplitude)
    return SimulatedRun(search, first, last, torque)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_revolutions_have_their_mean_speeds(sense: float) -> None:
    """A drive that gives way within a turn, at a speed that doubles half way."""
    time = np.linspace(0.0, 20.2, 6061)
    even = 2.0 * np.pi * np.where(time < 10.0, time, 2.0 * time - 10.0)
    drive = sense * (even + 0.05 * np.sin(2.0 * even)) + 0.7
    turning = 2.0 * np.pi * np.where(time < 10.0, 1.0, 2.0)
    free, rate = np.sin(3.0 * even), 3.0 * turning * np.cos(3.0 * even)
    still = 0.0 * time
    positions, rates = np.column_stack([free, still]), np.column_stack([rate, still])
    at, speed, envelope = windows_of(time, drive, positions, rates)
    # The last one ends with the run, after 30.4 revolutions.
    assert len(speed) == 31
    assert at[-1] == pytest.approx(20.2 - 0.25)
    expected = np.where(at < 10.0, 2.0 * np.pi, 4.0 * np.pi)
    assert speed == pytest.approx(sense * expected, rel=1e-4)
    # The greatest of samples alone is less by up to 1e-3.
    assert envelope == pytest.approx(np.tile([1.0, 0.0], (31, 1)), abs=2e-6)


def test_less_than_a_revolution_is_one_window() -> None:
    time = np.array([0.0, 0.1, 0.2, 1.0])
    _, speed, envelope = windows_of(time, 3.0 * time, time[:, None], 1.0 + 0.0 * time[:, None])
    assert (speed.tolist(), envelope.tolist()) == ([3.0], [[0.5]])


def test_a_prescribed_speed_rises_steadily() -> None:
    assert Rising(2.0, 4.0, 10.0)(5.0) == (2.0 * 5.0 + 0.1 * 25.0, 3.0, 0.2)
    found = run(1.5, 1.6, None).over(60.0, 1e-8)
    assert found.speed == pytest.approx(1.5 + 0.1 * found.time / 60.0)
    assert np.isnan(found.settled_speed)


@pytest.mark.parametrize(("first", "last", "torque"), [(1.5, 1.6, 0.02), (1.6, 1.5, -0.02)])
def test_a_torque_ends_the_run_at_the_last_speed(first: float, last: float, torque: float) -> None:
    """J = 2, less what damping takes: 0.02 N·m change the speed by 0.1 rad/s within some 10 s."""
    found = run(first, last, drive_torque(torque)).over(60.0, 1e-8)
    assert found.time[-1] == pytest.approx(10.0, abs=0.5)
    assert found.speed[-1] == pytest.approx(last, rel=0.02)


def test_it_begins_with_the_mean_speed_asked_for() -> None:
    found = run(1.5, 1.6, drive_torque(1e-5)).over(4.0 * np.pi / 1.5, 1e-8)
    assert found.window == pytest.approx(1.5, rel=1e-3)
    assert found.speed[0] != pytest.approx(1.5, rel=1e-3)


@pytest.mark.slow
def test_a_line_through_a_speed_settles_there() -> None:
    line = drive_torque(lambda speed: 0.2 * (1.55 - speed))
    assert run(1.5, 1.6, line).over(80.0, 1e-8).settled_speed == pytest.approx(1.55, rel=2e-3)
    # Still on its way, it has not settled.
    assert np.isnan(run(1.5, 1.6, line).over(15.0, 1e-8).settled_speed)


def test_no_motion_to_begin_with() -> None:
    with pytest.raises(VibrationError, match="no periodic motion was found"):
        run(0.5, 0.6, None, max_amplitude=1e-4)
