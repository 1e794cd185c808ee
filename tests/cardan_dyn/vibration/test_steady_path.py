"""Motions that a slow run follows."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

from cardan_dyn import VibrationError, vibration
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.continuation import motions_of
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.motions.steady_path import SteadyPath, steady_path

STEEP = np.radians(45.0)


def path(
    urdf: str, beta: float, first: float, last: float, max_amplitude: float = 1.0
) -> SteadyPath:
    search = MotionSearch(rotating_scene(elastic_rigs.scene(urdf, beta)), max_amplitude)
    return steady_path(search, first, last)


@pytest.mark.slow
def test_the_only_motion_is_that_of_the_response() -> None:
    beta = np.radians(25.0)
    urdf = elastic_rigs.elastic_rig()
    found = path(urdf, beta, 0.48, 0.52)
    assert found.speed[0] == 0.48 and found.speed[-1] == 0.52
    assert np.all(np.diff(found.speed) > 0.0) and not found.missed
    # Closest where the motion resonates.
    later = found.speed[8:]
    closest = later[np.argmin(np.diff(later)[:-1])]
    assert 0.483 < closest < 0.488 or 0.511 < closest < 0.515
    picked = found.points[::6]
    speeds = [item.speed for item in picked]
    scene = elastic_rigs.scene(urdf, beta)
    expected = vibration.forced_response(scene, speeds, joints=[]).amplitude
    for item, waves in zip(picked, expected, strict=True):
        start = np.sum(waves, axis=0).real
        np.testing.assert_allclose(item.q[0], start, atol=1e-9)


@pytest.mark.campaign
@pytest.mark.slow
def test_up_and_down_differ_between_the_folds() -> None:
    """At 45° a resonance leans over: a run follows its branch until it ends, and jumps."""
    line = elastic_rigs.torsional_line(damping_in=0.04)
    up, down = (path(line, STEEP, *ends) for ends in ((0.40, 0.56), (0.56, 0.40)))
    assert (up.sense, down.sense) == (1.0, -1.0)
    sizes = []
    for found in (up, down):
        order = np.argsort(found.speed)
        swing = np.array([np.ptp(item.q) / 2.0 for item in found.points])
        sizes.append(np.interp(np.linspace(0.41, 0.55, 141), found.speed[order], swing[order]))
    gap = np.abs(sizes[0] - sizes[1])
    assert np.max(gap) > 0.2 and np.mean(gap > 0.01) < 0.5
    for found in (up, down):
        for item in found.points[::8]:
            start = np.r_[item.q[0], item.course.rate[0, 0]]
            shot = periodic(SpringInFront(STEEP, item.speed, 0.5, 0.02), start)
            np.testing.assert_allclose(shot.start, start, atol=1e-9)


@pytest.mark.slow
def test_motions_nearby_are_found_from_the_path() -> None:
    found = path(elastic_rigs.elastic_rig(), np.radians(25.0), 0.50, 0.52)
    for speed in (0.5141, 0.5123):
        (near,) = found.near(speed)
        assert near.course.speed.tolist() == [speed]
    groups = motions_of(found.points)
    index = np.concatenate([group.index for group in groups])
    speed = np.concatenate([group.course.speed for group in groups])
    assert len({group.model.count for group in groups}) == len(groups)
    np.testing.assert_array_equal(speed[np.argsort(index)], found.speed)


@pytest.mark.slow
def test_speeds_without_a_motion_are_missed() -> None:
    """Undamped, the twist exceeds what is looked for near its resonance."""
    line = elastic_rigs.torsional_line()
    found = path(line, np.radians(5.0), 0.45, 0.55, max_amplitude=0.01)
    assert found.missed and len(found.points) > 5
    swings = {item.speed: np.ptp(item.q) / 2.0 for item in found.points}
    # Without damping the twist goes as 1/(1 - 4 r²).
    gone = [float(abs(1.0 - 4.0 * np.square(speed))) for speed in found.missed]
    there = [abs(1.0 - 4.0 * speed**2) for speed, swing in swings.items() if swing < 0.0095]
    assert max(swings.values()) < 0.0105 and max(gone) < 0.11 and min(there) > 0.09
    with pytest.raises(VibrationError, match="no periodic motion was found"):
        path(line, np.radians(5.0), 0.4999, 0.5001, max_amplitude=0.001)
