"""Crossings of orders and natural frequencies."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn.analytic.whirl import critical_speed, whirl_frequencies
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.results.campbell import campbell_of
from cardan_dyn.motion.vibration.results.resonance import between, crossings


def test_a_crossing_at_a_speed_of_the_modes_is_one() -> None:
    """A frequency of 4 rad/s that grows by half of the speed's growth, and order 2."""
    for speeds in (np.linspace(1.0, 5.0, 5), np.linspace(2.0, 4.0, 3), np.array([1.0, 2.2, 5.0])):
        for speed in (speeds, -speeds[::-1]):
            found = SimpleNamespace(speed=speed, frequency=3.0 + 0.5 * np.abs(speed)[:, None])
            ((at, slope),) = between(found, 2.0, 0)
            assert at == pytest.approx(2.0 * np.sign(speed[0]))
            assert slope == pytest.approx(1.5 * np.sign(speed[0]))


def test_a_crossing_at_the_first_or_last_speed_is_one() -> None:
    speed = np.array([0.4, 0.5, 0.6])
    ones = np.ones((3, 1))
    course = SimpleNamespace(speed=speed, frequency=ones)
    assert between(course, 2.0, 0) == [(0.5, 2.0)]
    for part, count in ((slice(2), 1), (slice(1, None), 1), (slice(1), 0)):
        course = SimpleNamespace(speed=speed[part], frequency=ones[part])
        assert len(between(course, 2.0, 0)) == count


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_coarse_speeds_find_the_whirls_of_a_gyroscopic_shaft(sense: float) -> None:
    """Frequencies bend between speeds as far apart as 10 rad/s; a joint angle of 0.05° is none."""
    ratio = 0.3
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(ratio, damping_ratio=1e-3), 1e-3)
    search = MotionSearch(rotating_scene(scene))
    speeds = np.sort(sense * np.array([0.1, 0.3, 10.0, 20.0]))
    found = campbell_of(search, speeds)
    every = [item for mode in range(2) for item in crossings(search, found, 2.0, mode)]
    assert len(every) == 2
    for item in every:
        forward = item.whirl > 0.0
        assert abs(item.whirl) > 0.99
        expected = float(critical_speed(1.0, 2.0, ratio, forward=forward))
        assert item.speed == pytest.approx(sense * expected, rel=1e-5)
        assert item.value.imag == pytest.approx(2.0 * expected, rel=1e-5)
        beside = [whirl_frequencies(at, 1.0, ratio) for at in (expected - 1e-4, expected + 1e-4)]
        forward_slope, backward_slope = (np.subtract(*beside[::-1]) / 2e-4).tolist()
        bend = forward_slope if forward else backward_slope
        assert item.slope == pytest.approx(sense * (2.0 - bend), rel=1e-4)
        assert np.linalg.norm(item.shapes[:, item.mode]) > 1.0
