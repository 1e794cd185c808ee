"""Integration of equations whose solution is known."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest

from cardan_dyn.motion.simulation.integration import Equations, Integration, Point


class Circle(Equations):
    """A point that runs about the unit circle once in 2π; its angle is counted beside, wrapped."""

    def __init__(self, decay: float = 0.0) -> None:
        self.turns = np.zeros(1)
        self.decay = decay

    def derivative(self, time: float, y: np.ndarray) -> np.ndarray:
        """Return rates of x, y, the angle, and of what decays to cos t."""
        late = self.decay * (math.cos(time) - y[3])
        return np.array([-y[1], y[0], 1.0, late])

    def restored(self, time: float, y: np.ndarray, *, crosses: bool = False) -> np.ndarray:
        """Return the point on the circle."""
        radius = math.hypot(y[0], y[1])
        return np.array([y[0] / radius, y[1] / radius, y[2], y[3]])

    def wrap(self, y: np.ndarray) -> np.ndarray:
        """Return the angle without turns."""
        turns = round(y[2] / (2.0 * math.pi))
        if turns:
            y = y - np.array([0.0, 0.0, 2.0 * math.pi * turns, 0.0])
            self.turns = self.turns + turns
        return y

    def followed(self, turns: np.ndarray, *way: object) -> np.ndarray:
        """Return the turns of a step as they are."""
        return turns

    def is_misread(self, y: np.ndarray, turns: np.ndarray) -> bool:
        """Return that nothing depends on how turns are counted."""
        return False


def integrated(method: str = "DOP853", rtol: float = 1e-10, **options: float) -> Integration:
    decay = options.pop("decay", 0.0)
    result = Integration(
        Circle(decay),
        np.array([1.0, 0.0, 0.0, 1.0]),
        options.pop("duration", 20.0),
        method=method,
        rtol=rtol,
        atol=np.full(4, rtol),
        step=options.pop("step", None),
        is_stiff=lambda time, y, length: length * decay > 2.0,
    )
    while result.is_running:
        assert result.advance() is None
    return result


@pytest.mark.parametrize(("method", "rtol"), [("DOP853", 1e-11), ("Radau", 1e-8)])
def test_a_circle_stays_one(method: str, rtol: float) -> None:
    run = integrated(method, rtol)
    assert run.time == 20.0
    for point in [*run.points, *run.points_at(np.linspace(0.0, 20.0, 77))]:
        assert abs(math.hypot(point.y[0], point.y[1]) - 1.0) < 4e-16
        angle = point.y[2] + 2.0 * math.pi * point.turns[0]
        assert abs(angle - point.time) < 1e-13
        # Some hundred steps, each with an error below the tolerance.
        assert abs(point.y[0] - math.cos(point.time)) < 200.0 * rtol
        np.testing.assert_allclose(point.rate[:3], [-point.y[1], point.y[0], 1.0])
    assert max(abs(point.y[2]) for point in run.points) <= math.pi + 1e-15


def at(run: Integration, time: float) -> Point:
    return run.points_at(np.array([time]))[0]


def test_each_step_begins_where_the_last_ended() -> None:
    run = integrated(rtol=1e-6)
    for segment, point in zip(run.steps, run.points[1:], strict=True):
        assert segment.end == point.time
        on_step = segment.dense(segment.end) + np.array([0, 0, 2.0 * math.pi, 0]) * segment.turns[0]
        there = point.y + np.array([0, 0, 2.0 * math.pi, 0]) * point.turns[0]
        # The interpolant ends at the restored row.
        np.testing.assert_allclose(on_step, there, atol=1e-14)


def test_steps_of_one_length() -> None:
    run = integrated(step=0.3, duration=2.0)
    lengths = np.diff([point.time for point in run.points])
    np.testing.assert_allclose(lengths[:-1], 0.3)
    assert run.time == 2.0
    long = integrated(step=5.0, duration=2.0)
    assert len(long.steps) == 1


def test_stiff_equations_are_found_and_left_to_radau() -> None:
    assert integrated(duration=5.0).stiff_from is None
    run = integrated(decay=1e5, rtol=1e-6, duration=5.0)
    assert run.method == "Radau"
    assert run.stiff_from is not None
    assert 0.0 < run.stiff_from < 0.1
    # Radau's steps follow cos t, not the decay: DOP853 would need 1e5 * 5 / 6 steps.
    assert len(run.steps) < 1000
    assert abs(run.points[-1].y[3] - math.cos(5.0)) < 2e-5
    # The solution lags behind by 1 / decay.
    late = at(run, 3.0).y[3] - (math.cos(3.0) + math.sin(3.0) / 1e5)
    assert abs(late) < 1e-6


def test_radau_is_left_where_its_steps_are_no_longer() -> None:
    longest, methods = 5.5e-3, []
    run = Integration(
        Circle(1e3),
        np.array([1.0, 0.0, 0.0, 1.0]),
        1.0,
        rtol=1e-6,
        atol=np.full(4, 1e-6),
        longest=longest,
        is_stiff=lambda time, y, length: length * 1e3 > 2.0,
    )
    while run.is_running:
        assert run.advance() is None
        methods.append(run.method)
    # Stability allows some more. It is tried, and again after as many steps as there were.
    assert 10 < methods.count("Radau") < 0.4 * len(methods)
    assert (run.method, run.stiff_from) == ("DOP853", None)
    assert abs(run.points[-1].y[3] - math.cos(1.0)) < 1e-3


def test_copies_give_the_same_points() -> None:
    run = integrated(duration=3.0)
    for other in (copy.deepcopy(run), pickle.loads(pickle.dumps(run))):
        np.testing.assert_array_equal(at(other, 1.7).y, at(run, 1.7).y)


def test_what_was_not_begun_has_one_point() -> None:
    run = Integration(Circle(), np.array([1.0, 0, 0, 1]), 1.0, rtol=1e-6, atol=np.full(4, 1e-6))
    assert run.is_running
    assert at(run, 0.0).time == 0.0
    assert [point.time for point in run.points_at(np.zeros(2))] == [0.0, 0.0]


def test_it_can_be_cut() -> None:
    run = Integration(Circle(), np.array([1.0, 0, 0, 1]), 5.0, rtol=1e-6, atol=np.full(4, 1e-6))
    run.advance()
    run.advance()
    inside = 0.5 * (run.steps[-1].start + run.steps[-1].end)
    run.cut(at(run, inside))
    assert not run.is_running
    assert run.time == inside == run.steps[-1].end


def test_failures_are_told() -> None:
    class Exploding(Circle):
        def derivative(self, time: float, y: np.ndarray) -> np.ndarray:
            return np.array([0.0, 0.0, 0.0, y[3] ** 2])

    run = Integration(Exploding(), np.array([1.0, 0, 0, 1]), 5.0, rtol=1e-6, atol=np.full(4, 1e-6))
    message = None
    while run.is_running and message is None:
        message = run.advance()
    # y = 1 / (1 - t).
    assert message is not None
    assert run.time == pytest.approx(1.0, abs=1e-3)


def test_a_step_planned_over_a_crossing_is_forgotten_where_other_forces_act() -> None:
    y = np.array([1.0, 0.0, 0.0, 1.0])
    integration = Integration(Circle(), y, 10.0, rtol=1e-8, atol=np.full(4, 1e-8))
    integration.advance()
    middle = at(integration, 0.5 * integration.time)
    integration._ahead = integration.time + 0.1, 0.2, 0.01
    integration.restart(middle)
    assert integration._ahead is None and integration.time == middle.time
