"""Searches for periodic motions: what is found from rest, and what is missed."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft
from vibrating_lines import SpringInFront

from benchmarks.waiting import _rig
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import course_of
from cardan_dyn.motion.vibration.motions.linear import linear_motions
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.results.periodic_motion import periodic_motion

BETA = np.radians(15.0)


def search(urdf: str, beta: float, max_amplitude: float = 1.0, **options: object) -> MotionSearch:
    return MotionSearch(rotating_scene(elastic_rigs.scene(urdf, beta, **options)), max_amplitude)


def test_a_load_moves_the_middle() -> None:
    finder = search(elastic_rigs.torsional_line(), 0.1, loads={"bearing_out": -0.4})
    (found,) = finder.primary(np.array([0.8]))
    assert np.mean(found.course.q) == pytest.approx(-0.4, abs=0.01)


def test_motions_beyond_what_is_searched_are_missed() -> None:
    finder = search(elastic_rigs.torsional_line(), BETA, max_amplitude=0.1)
    found = finder.every(np.array([0.3, 0.5]))
    assert [item.index.tolist() for item in found] == [[0]]
    assert list(finder.missed) == [1]
    assert "no periodic motion was found at a speed of 0.5 rad/s" in finder.missed[1]


@pytest.mark.slow
def test_motions_are_found_on_branches_from_other_speeds() -> None:
    """Beside a fold Newton's method from rest leads nowhere."""
    finder = search(elastic_rigs.torsional_line(damping_in=0.04), np.radians(45.0))
    groups, signs = finder.every(np.array([0.505])), []
    assert not finder.missed
    for motions in groups:
        signs += motions.sign.tolist()
        for q, rate in zip(motions.course.q, motions.course.rate, strict=True):
            start = np.r_[q[0], rate[0]]
            shot = periodic(SpringInFront(np.radians(45.0), 0.505, 0.5, 0.02), start)
            np.testing.assert_allclose(shot.start, start, atol=1e-9)
            assert 0.4 < np.max(np.abs(q)) < 0.8
    assert sorted(signs) == [-1.0, 1.0, 1.0]
    assert finder.primary(np.array([0.505])) == []


@pytest.mark.campaign
@pytest.mark.slow
def test_large_motions_beside_a_small_one() -> None:
    """A shaft at 45° that tilts by 20° and more."""
    finder, speed = search(elastic_rigs.elastic_rig(), np.radians(45.0)), np.array([0.473])
    found = finder.every(speed)
    assert sorted(item.sign[0] for item in found) == [-1.0, 1.0, 1.0]
    assert sorted(np.max(np.abs(item.course.q)) > 0.33 for item in found) == [False, True, True]
    for motions in found:
        start = np.r_[motions.course.q[0, 0], motions.course.rate[0, 0]]
        system = TiltingShaft(np.radians(45.0), speed[0])
        np.testing.assert_allclose(periodic(system, start).start, start, atol=1e-9)
        # The linear equation is about the mean, far from the motion.
        mean = np.mean(motions.course.q[0], axis=0)
        linear = course_of(linear_motions(motions), speed, motions.model.period)
        ways = (linear.q[0] - mean, speed * linear.rate[0], speed**2 * linear.bend[0])
        drive = (motions.model.positions, np.full(len(ways[0]), speed[0]), np.zeros(len(ways[0])))

        def efforts(share: float) -> np.ndarray:
            return finder.model.efforts(
                *(
                    np.column_stack([first, middle + share * way])
                    for first, middle, way in zip(drive, (mean, 0.0, 0.0), ways, strict=True)  # noqa: B023
                )
            )[:, 1:]

        rise = (efforts(1e-3) - efforts(-1e-3)) / 2e-3
        np.testing.assert_allclose(efforts(0.0) + rise, 0.0, atol=1e-5 * np.max(np.abs(rise)))


@pytest.mark.slow
def test_four_coordinates_that_tilt_and_twist() -> None:
    found = periodic_motion(_rig("twist_in", "tilt_z", "tilt_y", "twist_out"), 0.6)
    assert not found.missed
    assert np.max(found.residual) < 1e-12
