"""Prescribed motion: its forms, and what is refused."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.motion.simulation.prescribed_motion import (
    Written,
    begun_at,
    prescribed_motion,
    prescribed_motions,
)

TIMES = np.linspace(0.0, 2.0, 41)


def sine(time: float) -> tuple[float, float, float]:
    return math.sin(time), math.cos(time), -math.sin(time)


def test_forms_of_one_motion() -> None:
    written = prescribed_motion("a", sine, 2.0)
    three = prescribed_motion("a", [lambda t, k=k: sine(t)[k] for k in range(3)], 2.0)
    spline = prescribed_motion("a", (TIMES, np.sin(TIMES)), 2.0)
    for time in (0.0, 0.33, 1.99):
        assert written(time) == three(time) == sine(time)
        # A quintic spline of step h errs by about h⁶, its second derivative by h⁴.
        np.testing.assert_allclose(spline(time), sine(time), atol=0.05**4)


def test_a_speed_begins_where_the_drive_is() -> None:
    motions, starts = prescribed_motions(("b", "c"), ("a",), {"b": 3.0, "c": sine}, 1.0)
    assert starts == {"c": 0.0}
    motions = begun_at(motions, {"a": 9.0, "b": 0.5, "c": 7.0})
    assert motions["b"](2.0) == (6.5, 3.0, 0.0)
    assert motions["c"](0.0) == sine(0.0)


def test_constant_speeds_and_splines_can_be_pickled() -> None:
    for value in (3.0, (TIMES, np.sin(TIMES)), sine):
        motion = prescribed_motion("a", value, 2.0)
        assert pickle.loads(pickle.dumps(motion))(0.7) == motion(0.7)


def fails(time: float) -> Any:
    if time > 0.9:
        raise KeyError("no more")
    return sine(time)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("fast", "is 'fast'; give a speed"),
        (np.nan, "is not finite"),
        ([1.0, 2.0, 3.0, 4.0], "give a speed, a function"),
        (lambda t: t, "returns 0.0 at time 0 s, expected position, speed and acceleration"),
        (lambda t: (t, "x", 0.0), "expected position, speed and acceleration"),
        (lambda t: (np.nan, 0.0, 0.0), "not finite at time 0 s"),
        (fails, r"failed at time 0\.\d+ s: KeyError: 'no more'"),
        (lambda t: (t * t, t, 1.0), "its speed is not the derivative of its position near time"),
        (lambda t: (t * t, 2 * t, 1.0), "its acceleration is not the derivative of its speed"),
        (lambda t: (max(t - 0.7, 0.0), float(t > 0.7), 0.0), "its speed .* time 0.7 s, or jumps"),
        ((TIMES[:5], TIMES[:5]), "K at least 6"),
        ((TIMES, TIMES[:9]), r"times \(41,\) and positions \(9,\)"),
        ((TIMES[::-1], TIMES), "times have to increase"),
        ((0.4 * TIMES, TIMES), "times from 0 to 0.8 s do not span the simulation, 0 to 1 s"),
        ((TIMES + 0.1, TIMES), "do not span"),
        ((TIMES, np.full(41, np.inf)), "positions is not finite"),
        (("a", "b"), "times is not an array of real numbers"),
    ],
)
def test_what_is_no_motion_is_refused(value: Any, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message) as caught:
        prescribed_motion("lift", value, 1.0)
    assert "motion['lift']" in str(caught.value)


@pytest.mark.parametrize(("begin", "length"), [(0.25, 0.5), (1.0 / 3.0, 1.0 / 7.0), (0.0, 1.0)])
@pytest.mark.parametrize("duration", [1.0, 1.7])
def test_times_after_which_accelerations_are_others(
    begin: float, length: float, duration: float
) -> None:
    rate = 2.0 * math.pi / length

    def bump(time: float) -> tuple[float, float, float]:
        turn = rate * (time - begin)
        if not 0.0 < time - begin < length:
            return 0.0, 0.0, 0.0
        return 1.0 - math.cos(turn), rate * math.sin(turn), rate**2 * math.cos(turn)

    motion = prescribed_motion("road", bump, duration)
    assert isinstance(motion, Written)
    assert motion.kinks == pytest.approx((begin, begin + length), rel=1e-15)
    for kink in motion.kinks:
        before, after = (bump(time)[2] for time in (kink, np.nextafter(kink, 2.0)))
        assert abs(before - after) == pytest.approx(rate**2, rel=1e-9)


def test_smooth_motion_has_no_kinks() -> None:
    motion = prescribed_motion("a", sine, 2.0)
    assert isinstance(motion, Written)
    assert not motion.kinks


def test_fast_motion_is_none_that_jumps() -> None:
    def fast(time: float) -> tuple[float, float, float]:
        return math.sin(300.0 * time), 300.0 * math.cos(300.0 * time), -9e4 * math.sin(300.0 * time)

    assert prescribed_motion("a", fast, 1.0)(0.1) == fast(0.1)


def test_drives_alone_are_moved_and_all_of_them() -> None:
    with pytest.raises(cd.ArgumentError, match=r"motion\['c'\]: .* no drive.*drives: a, b"):
        prescribed_motions(("a", "b"), ("d",), {"c": 1.0}, 1.0)
    with pytest.raises(cd.ArgumentError, match=r"motion\['d'\]: the joint is free; drives: a, b"):
        prescribed_motions(("a", "b"), ("d",), {"d": 1.0}, 1.0)
    with pytest.raises(cd.ArgumentError, match=r"drives b, of which nothing says how"):
        prescribed_motions(("a", "b"), ("d",), {"a": 1.0}, 1.0)
    with pytest.raises(cd.MobilityError, match=r"scene drives all it has: a.*Scene\.sweep"):
        prescribed_motions(("a",), (), {"a": 1.0}, 1.0)
    with pytest.raises(cd.ArgumentError, match="motion is 3"):
        prescribed_motions(("a",), ("d",), 3, 1.0)


@pytest.mark.parametrize("duration", [1.0, 1.7, 5.0])
@pytest.mark.parametrize("width", [0.5, 0.05, 0.02, 0.01])
def test_both_ends_of_a_short_bump_are_kinks(duration: float, width: float) -> None:
    begin = 0.123

    def bump(time: float) -> tuple[float, float, float]:
        if not begin < time < begin + width:
            return 0.0, 0.0, 0.0
        rate = 2.0 * np.pi / width
        turn = rate * (time - begin)
        return 1.0 - np.cos(turn), rate * np.sin(turn), rate**2 * np.cos(turn)

    found = getattr(prescribed_motion("lift", bump, duration), "kinks", None)
    assert found == pytest.approx([begin, begin + width], abs=1e-15)
    with pytest.raises(cd.ArgumentError, match="its speed is not the derivative"):
        prescribed_motion("lift", lambda time: (bump(time)[0], 1.1 * bump(time)[1], 0.0), duration)
