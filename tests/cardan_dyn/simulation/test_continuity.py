"""Continuity: states that are not on one motion from the start are refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from testkit.linkages import four_bar, loop
from testkit.simulated import GRAVITY, pendulum

import cardan_dyn as cd
from cardan_dyn.motion.simulation.continuity import Continuity, States
from cardan_dyn.motion.simulation.energy_integral import _Elapsed
from cardan_dyn.motion.simulation.trajectory import Trajectory

TIMES = np.linspace(0.0, 2.0, 81)
METHODS = ["quadrature", "response", "DOP853", "Radau"]
STARTS = {"swing": {"position": 2.5}, "turn": {"speed": 9.0}}


class Faulty:
    """A run whose states are changed before they are returned."""

    def __init__(self, run: Any, change: Callable[[Any, np.ndarray], Any]) -> None:
        self._run, self._change = run, change

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["_run"], name)

    def drives_alone(self, times: np.ndarray) -> Any:
        if self._run.drives_alone(np.zeros(1)) is None:
            return None
        return self._change(self._run.drives_alone, times)

    def rows(self, times: np.ndarray, drives: Any = None) -> Any:
        if drives is None and self._run.drives_alone(np.zeros(1)) is None:
            return self._change(self._run.rows, times)
        return self._run.rows(times, drives or self.drives_alone(times))


def late(states: Callable[[np.ndarray], Any], times: np.ndarray) -> Any:
    return states(np.minimum(times + 1e-3, 2.0))


def skipping(states: Callable[[np.ndarray], Any], times: np.ndarray) -> Any:
    """What follows after half a second is that of a later swing."""
    return states(np.where(times > 0.5, np.minimum(times + 0.37, 2.0), times))


def turned(states: Callable[[np.ndarray], Any], times: np.ndarray) -> Any:
    found = states(times)
    more = 2.0 * np.pi * (times > 1.1)[:, None]
    return found._replace(x=found.x + more)


def once(states: Callable[[np.ndarray], Any], times: np.ndarray) -> Any:
    """A single time alone is wrong."""
    found = states(times)
    return found._replace(x=found.x + 1e-3 * (np.abs(times - TIMES[23]) < 1e-9)[:, None])


def slow(states: Callable[[np.ndarray], Any], times: np.ndarray) -> Any:
    found = states(times)
    return found._replace(v=found.v * 0.999)


@cache
def simulated(method: str, start: str) -> Trajectory:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    return scene.simulate(2.0, method=method, rtol=1e-8, **STARTS[start])


def again(trajectory: Trajectory, run: Any, times: np.ndarray = TIMES) -> Trajectory:
    return Trajectory(replace(trajectory._course, run=run), times)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("change", [late, skipping, turned, once, slow])
def test_wrong_states_are_refused(method: str, start: str, change: Callable[..., Any]) -> None:
    moved = simulated(method, start)
    right, wrong = again(moved, moved._run), again(moved, Faulty(moved._run, change))
    assert right.time_residual < 1e-5
    np.testing.assert_array_equal(right.position, moved.at(TIMES).position)
    for name in ("position", "sweep"):
        with pytest.raises(cd.AccuracyError, match="integrals of speeds"):
            getattr(again(moved, wrong._run), name)
    # A single time that is asked for is held against the way to it.
    if change is not once:
        with pytest.raises(cd.AccuracyError, match="integrals of speeds"):
            _ = again(moved, wrong._run, TIMES[[71]]).position


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("speed", [1.0, 8.0])
def test_another_assembly_mode_is_refused(method: str, speed: float) -> None:
    """The drive moves as it should: it is the other joints that are where they cannot have gone."""
    mechanism = cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(mechanism, free="a", gravity=GRAVITY)
    moved = scene.simulate(1.5, method=method, speed=speed, rtol=1e-8)
    times = np.linspace(0.0, 1.5, 31)
    assert again(moved, moved._run, times).time_residual < 1e-5
    other = scene.branches()["B"]
    mirrored = cd.Scene(mechanism, drive="a", gravity=GRAVITY, near=other)
    columns = scene.solver.problem.mechanism.coordinates.columns_of(["a", "b", "c"])
    there = mirrored.sweep(moved.at(times).position).motion
    assert np.min(np.abs(there.position("b") - moved.at(times).motion.position("b"))) > 0.1
    if method in ("quadrature", "response"):
        wrong = again(moved, moved._run, times)
        moved._run._solver = mirrored.solver  # type: ignore[attr-defined]
    else:

        class Mirrored(Faulty):
            def rows(self, at: np.ndarray, drives: Any = None) -> Any:
                rows = self._run.rows(at)
                x, late = rows.x.copy(), at > 0.7
                drive = x[late, columns[0]] + 2.0 * np.pi * rows.turns[late, columns[0]]
                if np.any(late):
                    motion = mirrored.sweep(drive).motion
                    x[late] = motion.rows - 2.0 * np.pi * rows.turns[late]
                return rows._replace(x=x)

        wrong = again(moved, Mirrored(moved._run, late), times)
    for name in ("kinetic_energy", "sweep", "motion"):
        with pytest.raises(cd.AccuracyError, match="assembly mode"):
            getattr(wrong, name)


def test_an_inversion_that_fails_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Positions that belong to other times, with the speeds that belong to these positions."""
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    moved = scene.simulate(4.0, position=np.pi - 1e-3)
    inverted = _Elapsed.inverted

    def cycling(self: Any, times: np.ndarray) -> Any:
        return inverted(self, np.where(times > 0.6 * self.total, times - 0.05, times))

    monkeypatch.setattr(_Elapsed, "inverted", cycling)
    with pytest.raises(cd.AccuracyError, match="integrals of speeds"):
        _ = moved.position


@pytest.mark.parametrize("is_exact", [True, False])
def test_what_is_one_motion_is_not_refused(is_exact: bool) -> None:
    """An acceleration that jumps, after a long time at rest."""

    def look(times: np.ndarray) -> States:
        after = np.maximum(times - np.pi, 0.0)[:, None]
        return States(0.5 * after**2, after, 1.0 * (after > 0.0))

    start = np.zeros(1), np.zeros(1)
    motion = Continuity(look, np.linspace(0, 9, 5), start, tolerance=1e-8, is_exact=is_exact)
    times = np.sort(np.random.default_rng(0).uniform(0.0, 9.0, 50))
    assert motion.misfit(times, look(times)).size <= 1e-8
    jumped = look(times)._replace(x=look(times).x + 1e-4)
    assert motion.misfit(times, jumped).size > 1e-6


def test_errors_of_steps_between_their_ends_are_no_other_motion() -> None:
    """A long vibration whose speeds are off by some hundred tolerances of steps inside of each."""
    step, rate = 3.6e-3, 290.0

    def look(times: np.ndarray) -> States:
        index = np.floor(times / step)
        inside, sign = times / step - index, np.where(index % 2, -1.0, 1.0)
        error = 3e-6 * sign * (4.0 * inside * (1.0 - inside)) ** 2
        x = np.sin(rate * times) + 1e-8 * sign
        v, a = rate * (np.cos(rate * times) + error), -(rate**2) * np.sin(rate * times)
        return States(x[:, None], v[:, None], a[:, None])

    times, asked = np.arange(0.0, 15.0, step), np.linspace(0.0, 14.9, 16_000)
    begun = look(times[:1])
    motion = Continuity(look, times, (begun.x[0], begun.v[0]), tolerance=1e-5, is_exact=False)
    assert motion.misfit(asked, look(asked)).size <= 1e-5
    for wrong in (1e-4, 1e-3):
        states = look(asked)
        states.x[700] += wrong
        assert motion.misfit(asked, states).size > 0.5 * wrong


def test_many_jumps_are_looked_at_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """What one question has looked at is no reason to refuse the next one."""
    jumps = np.array([0.31, 1.13, 2.07, 3.33, 4.61, 5.23])

    def look(times: np.ndarray) -> States:
        after = np.maximum(times[:, None] - jumps, 0.0)
        x, v, a = 0.5 * after**2, after, 1.0 * (after > 0.0)
        return States(*(np.sum(values, axis=1)[:, None] for values in (x, v, a)))

    grid = np.linspace(0.0, 6.0, 7)
    start = np.zeros(1), np.zeros(1)
    motion = Continuity(look, grid, start, tolerance=1e-8, is_exact=False)
    monkeypatch.setattr("cardan_dyn.motion.simulation.continuity.MOST_STATES", 40)
    for jump in jumps:
        # Beside a jump, speeds are told by closer neighbours than positions.
        times = jump + np.linspace(-4e-6, 4e-6, 9)
        assert motion.misfit(times, look(times)).size <= 1e-8


def needle_drive() -> cd.Scene:
    mechanism = cd.load("needle_drive")
    return cd.Scene(mechanism, free="main_shaft", gravity=(0.0, -9.81, 0.0))


@pytest.mark.parametrize("duration", [1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("method", [None, "DOP853"])
@pytest.mark.parametrize("speed", [0.0, 1e-9])
def test_motions_as_small_as_rounding_of_closed_loops_are_not_refused(
    duration: float, method: str | None, speed: float
) -> None:
    scene = needle_drive()
    moved = scene.simulate(duration, speed=speed, method=method)
    assert moved.time_residual < 1e-6 and moved.effort_residual < 1e-8
    assert moved.at(0.5 * duration).motion.position("needle_pin").shape == (1,)
    # As long as it has hardly moved, its acceleration is that of the start.
    fallen = scene.simulate(duration, speed=speed, method="response").acceleration[0]
    way = speed * moved.time + 0.5 * fallen * moved.time**2
    np.testing.assert_allclose(moved.position, way, rtol=1e-2, atol=1e-14)


@pytest.mark.slow
def test_loads_that_jump_between_the_steps_are_not_refused() -> None:
    """Steps on both sides of a jump are so short that rounding decides slopes of positions."""

    def effort(time: float) -> float:
        return 0.2 if np.sin(60.0 * time) > 0.0 else -0.2

    moved = needle_drive().simulate(0.3, speed=3.0, loads={"main_shaft": effort})
    assert moved.energy_residual < 1e-8
    assert moved.evenly(57).time_residual < 1e-6
    assert not any("could not be checked" in note for note in moved.notes)


@pytest.mark.slow
def test_springs_that_let_a_body_move_by_little_are_not_refused() -> None:
    """Steps are as long as stability allows, and the body moves by little more than their errors.

    Its way is that of a mass on a spring, without the mode that has decayed.
    """
    mechanism = cd.load(
        '<robot name="mount"><link name="world"/><link name="body"><inertial><mass value="1.5"/>'
        '<inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="floating"><parent link="world"/><child link="body"/></joint></robot>'
    )
    rubber = cd.Bushing("world", "body", (0, 0, 0), np.full(6, 1e6), np.full(6, 1e4))
    scene = cd.Scene(
        mechanism, free=list(mechanism.drivable), elements=[rubber], gravity=(0.0, 0.0, -9.81)
    )
    moved = scene.simulate(0.05, speed={"j.turn_y": 1.0})
    assert moved.energy_residual < 1e-8
    even = moved.evenly(13)
    sunk = even.motion.position("j.z")
    rate = 0.5 * (1e4 - np.sqrt(1e8 - 4.0 * 1.5e6)) / 1.5
    late = even.time > 0.01
    expected = 1.5 * 9.81 / 1e6 * (1.0 - np.exp(-rate * even.time) * 1.0157)
    np.testing.assert_allclose(sunk[late], -expected[late], rtol=1e-2)
