"""Runs: states at any times, whichever method found them."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from testkit.simulated import GRAVITY, integrated, parallelogram_law, parallelograms, pendulum

import cardan_dyn as cd
from cardan_dyn.motion.simulation.runs import ConstrainedRun, OneCoordinateRun

TIMES = np.linspace(0.0, 2.0, 21)


@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853"])
def test_rows_are_positions_rates_and_accelerations(method: str) -> None:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    run = scene.simulate(2.0, speed=8.0, rtol=1e-12, method=method)._run
    assert isinstance(run, ConstrainedRun if method == "DOP853" else OneCoordinateRun)
    rows = run.rows(TIMES)
    position = rows.x[:, 0] + 2.0 * np.pi * rows.turns[:, 0]
    step = 1e-4
    later, sooner = run.rows(TIMES[1:-1] + step), run.rows(TIMES[1:-1] - step)
    slope = (later.v - sooner.v) / (2.0 * step)
    # Differences: step² / 6 of a third derivative of some thousands, and 1e-12 / step.
    np.testing.assert_allclose(rows.a[1:-1], slope, atol=1e-4)
    way = later.x + 2.0 * np.pi * later.turns - sooner.x - 2.0 * np.pi * sooner.turns
    np.testing.assert_allclose(rows.v[1:-1], way / (2.0 * step), atol=1e-5)
    assert position[-1] > np.pi
    own = run.rows(run.times)
    again = run.rows(run.times.copy())
    for name in ("x", "turns"):
        assert getattr(own, name).shape == (len(run.times), 1)
    counted = [item.x + 2.0 * np.pi * item.turns for item in (own, again)]
    np.testing.assert_allclose(*counted, atol=1e-11)


def test_positions_are_assembled_where_the_run_is() -> None:
    """Beyond a flat position no drive leads, but the run knows where the mechanism is."""
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=GRAVITY)
    inertia, weight = parallelogram_law(1)
    trajectory = scene.simulate(2.0, position=0.3, speed=12.0, rtol=1e-12)
    expected = integrated(lambda t, x, v: weight * np.sin(x) / inertia, 0.3, 12.0, TIMES)
    found = trajectory.at(TIMES)
    np.testing.assert_allclose(found.position, expected[0], atol=1e-9)
    np.testing.assert_allclose(
        np.unwrap(found.motion.position("pin_1")), np.unwrap(expected[0]), atol=1e-9
    )


def test_threads_may_read_one_trajectory(joint: cd.Mechanism) -> None:
    """They share the memory in which states are closed, and the turns that these lack."""
    scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.9})
    turned = scene.simulate(4.0, speed=20.0, method="DOP853", rtol=1e-9)
    random = np.random.default_rng(0)
    times = [random.uniform(0.0, 4.0, 200) for _ in range(8)]
    expected = [turned._run.rows(some).a for some in times]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as pool:
            found = list(pool.map(lambda some: turned._run.rows(some).a, times))
    finally:
        sys.setswitchinterval(interval)
    for rates, others in zip(found, expected, strict=True):
        np.testing.assert_array_equal(rates, others)
