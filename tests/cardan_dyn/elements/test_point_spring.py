"""Point springs: their law by hand, and what they refuse."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import cardan_dyn as cd

ORIGIN = (0.0, 0.0, 0.0)


def spring(stiffness: float = 10.0, damping: float = 0.0, length: float = 0.0) -> cd.PointSpring:
    return cd.PointSpring("a", ORIGIN, "b", ORIGIN, stiffness, damping, length)


def test_tension_and_force_by_hand() -> None:
    span, rate = np.array([[3.0, 0.0, 4.0]]), np.array([[1.0, 7.0, 2.0]])
    force = spring(10.0, 2.0, 1.5).force(span, rate, np.zeros(len(span)), "")
    speed = (3.0 * 1.0 + 4.0 * 2.0) / 5.0
    tension = 10.0 * 3.5 + 2.0 * speed
    assert force.length == pytest.approx(5.0)
    assert force.tension == pytest.approx(tension)
    np.testing.assert_allclose(force.force, tension * span / 5.0)
    assert force.energy == pytest.approx(0.5 * 10.0 * 3.5**2)
    assert force.dissipation == pytest.approx(2.0 * speed**2)


def test_a_spring_of_length_zero_is_linear_and_smooth_where_its_points_coincide() -> None:
    span = np.array([[1e-9, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    force = spring(10.0).force(span, np.zeros((3, 3)), np.zeros(3), "")
    np.testing.assert_allclose(force.force, 10.0 * span, rtol=1e-15)
    rate = np.tile([0.0, 0.0, 3.0], (3, 1))
    damped = spring(0.0, 2.0).force(span, rate, np.zeros(len(span)), "")
    np.testing.assert_allclose(damped.force, [[0, 0, 0], [0, 0, 6.0], [0, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(damped.dissipation, [0.0, 18.0, 0.0])


def test_a_pressed_spring_pushes() -> None:
    span = np.array([[0.5, 0.0, 0.0]])
    force = spring(10.0, length=2.0).force(span, np.zeros((1, 3)), np.zeros(1), "")
    np.testing.assert_allclose(force.tension, [-15.0])
    np.testing.assert_allclose(force.force, [[-15.0, 0.0, 0.0]])


def test_no_direction_is_refused() -> None:
    span = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    with pytest.raises(cd.ArgumentError, match=r"e\[1\]: its points coincide at sample 1, where"):
        spring(length=0.1).force(span, np.zeros((2, 3)), np.zeros(2), "e[1]")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: spring(-1.0), "PointSpring: stiffness is -1"),
        (lambda: spring(1.0, -1.0), "PointSpring: damping is -1"),
        (lambda: spring(1.0, 0.0, -1.0), "PointSpring: length is -1"),
        (lambda: cd.PointSpring("a", (0, 0), "b", ORIGIN, 1.0), "point_a has shape (2,)"),
        (lambda: cd.PointSpring("a", ORIGIN, "b", (0, np.nan, 0), 1.0), "point_b is not finite"),
        (lambda: cd.PointSpring("a", ORIGIN, "a", ORIGIN, 1.0), "both ends are on link 'a'"),
        (lambda: cd.PointSpring(None, ORIGIN, "a", ORIGIN, 1.0), "link_a is None, expected a str"),
    ],
)
def test_bad_values_are_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=re.escape(message)):
        make()
