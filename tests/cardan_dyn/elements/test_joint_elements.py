"""Joint elements: their laws, and what they refuse."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

import cardan_dyn as cd

X, V, TIME = np.array([0.5, -1.0, 7.0]), np.array([0.1, 2.0, -3.0]), np.array([0.0, 1.0, 2.0])


def test_a_spring_pulls_back_to_its_rest() -> None:
    force = cd.JointSpring("pin", 4.0, damping=0.5, rest=1.0).force(X, V, TIME, "")
    np.testing.assert_allclose(force.effort, [2.0 - 0.05, 8.0 - 1.0, -24.0 + 1.5])
    np.testing.assert_allclose(force.energy, [0.5, 8.0, 72.0])
    np.testing.assert_allclose(force.dissipation, [0.005, 2.0, 4.5])


def test_friction_is_coulombs_far_from_rest_and_smooth_near_it() -> None:
    friction = cd.JointFriction("pin", 5.0, transition=1e-2)
    force = friction.force(X, np.array([1e3, -1e3, 0.0]), TIME, "")
    np.testing.assert_allclose(force.effort, [-5.0, 5.0, 0.0], atol=1e-9)
    at_transition = friction.force(X[:1], np.array([1e-2]), TIME[:1], "")
    assert at_transition.effort == pytest.approx(-5.0 / math.sqrt(2.0))
    assert np.all(force.dissipation >= 0.0)


@pytest.mark.parametrize(
    "function",
    [
        np.sin,
        math.sin,
        lambda t: math.sin(t) if t < 5.0 else 0.0,
        lambda t: [np.sin(t)] if np.ndim(t) == 0 else np.sin(t)[None],
    ],
    ids=["of arrays", "of numbers", "with branches", "of one more dimension"],
)
def test_an_actuator_takes_functions_of_arrays_and_of_numbers(function: Callable) -> None:
    force = cd.Actuator("pin", function).force(X, V, TIME, "")
    np.testing.assert_allclose(force.effort, np.sin(TIME))
    assert not np.any(force.energy)
    assert not np.any(force.dissipation)


def test_an_actuator_that_reduces_arrays_is_asked_time_by_time() -> None:
    effort = cd.Actuator("pin", lambda t: float(np.max(t))).force(X, V, TIME, "").effort
    np.testing.assert_array_equal(effort, TIME)


def test_an_actuator_takes_functions_of_the_position() -> None:
    load = cd.Actuator("pin", np.cos, of="position")
    force = load.force(X, V, TIME, "")
    np.testing.assert_array_equal(force.effort, np.cos(X))
    assert not np.any(force.energy) and not np.any(force.dissipation)
    assert not load.follows_time
    assert cd.Actuator("pin", np.cos).follows_time
    assert not cd.Actuator("pin", 2.0).follows_time
    assert cd.Actuator("pin", np.cos) != load
    by_number = cd.Actuator("pin", math.cos, of="position").force(X, V, TIME, "")
    np.testing.assert_array_equal(by_number.effort, force.effort)


def test_what_an_actuator_does_not_follow() -> None:
    with pytest.raises(cd.ArgumentError, match="of is 'speed'; it is position, time"):
        cd.Actuator("pin", np.cos, of="speed")
    failing = cd.Actuator("pin", lambda x: 1.0 / 0.0, of="position")
    with pytest.raises(cd.ArgumentError, match=r"effort at position 0\.5 fails: ZeroDivisionError"):
        failing.force(X[:1], V[:1], TIME[:1], "load: ")


def test_an_actuator_at_one_time_is_asked_once() -> None:
    asked: list[float] = []

    def effort(time: float) -> float:
        asked.append(time)
        return 2.0 * time

    force = cd.Actuator("pin", effort).force(X, V, np.full(3, 1.5), "")
    np.testing.assert_array_equal(force.effort, np.full(3, 3.0))
    assert asked == [1.5]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda t: 1.0 / 0.0, "effort at 0 s fails: ZeroDivisionError"),
        (lambda t: "much", "effort at 0 s is not an array of real numbers"),
        (lambda t: np.nan, "effort at 0 s is not finite"),
        (lambda t: [1.0, 2.0], r"effort at 0 s has shape \(2,\), expected a number"),
        (lambda t: 1.0 / (1.0 - t), "effort is not finite at index"),
    ],
)
def test_functions_that_fail_are_refused(function: Callable, message: str) -> None:
    with (
        np.errstate(divide="ignore"),
        pytest.raises(cd.ArgumentError, match=r"elements\[2\]: " + message),
    ):
        cd.Actuator("pin", function).force(X, V, TIME, "elements[2]")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: cd.JointSpring("pin", -1.0), "JointSpring: stiffness is -1; it is not less"),
        (lambda: cd.JointSpring("pin", 1.0, -2.0), "JointSpring: damping is -2; it is not less"),
        (lambda: cd.JointSpring("pin", np.nan), "JointSpring: stiffness is not finite"),
        (lambda: cd.JointSpring("pin", [1.0, 2.0]), "stiffness has shape (2,), expected a number"),
        (lambda: cd.JointSpring("pin", 1.0, rest="up"), "JointSpring: rest is not an array"),
        (lambda: cd.JointSpring(3, 1.0), "JointSpring: joint is 3, expected a string"),
        (lambda: cd.JointSpring("pin", 1.0, name=3), "JointSpring: name is 3, expected a string"),
        (lambda: cd.JointFriction("pin", -1.0), "JointFriction: effort is -1"),
        (lambda: cd.JointFriction("pin", 1.0, 0.0), "transition is 0; it is a positive speed"),
        (lambda: cd.Actuator("pin", "strong"), "Actuator: effort is not an array of real"),
        (lambda: cd.Actuator("pin", np.inf), "Actuator: effort is not finite"),
    ],
)
def test_bad_values_are_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=re.escape(message)):
        make()
