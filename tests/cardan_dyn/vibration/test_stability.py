"""Kinds of stability by multipliers."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.motions.stability import _kinds, separation, stability


def test_names_of_multipliers() -> None:
    multipliers = np.array(
        [
            [1.0 + 0j, 1.0],
            [-1.2, -1.0 / 1.2],
            [1.3, 1.0 / 1.3],
            [1.1 + 0.5j, 1.1 - 0.5j],
            [1.1 + 0.5j, 1.1 - 0.5j],
            [0.3, 0.2],
        ]
    )
    grows = np.array([False, False, False, False, True, False])
    assert _kinds(multipliers, grows).tolist() == [
        *("stable", "instability", "fold", "combination", "flutter", "stable")
    ]


def test_separation() -> None:
    found = separation(np.array([[1.0 + 0j, 1.5, -1.0], [1j, -1j, 1.0]]))
    np.testing.assert_allclose(found, [0.5, np.sqrt(2.0)])
    # Double ones stand for themselves alone.
    twice = separation(np.array([[1j, 1j + 1e-12, 0.6j], [1j, 1j, 1j]]))
    np.testing.assert_allclose(twice, [0.4, np.inf])


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("beta", [15.0, 45.0])
@pytest.mark.parametrize("ratio", [0.0, 0.1])
def test_trace_and_determinant_against_shooting(beta: float, ratio: float) -> None:
    angle, speeds = np.radians(beta), np.array([0.13, 0.42, 0.95, 2.8])
    line = elastic_rigs.torsional_line(damping_in=2.0 * ratio)
    search = MotionSearch(rotating_scene(elastic_rigs.scene(line, angle)))
    found = stability(search, speeds)
    courses = {
        int(place): np.r_[item.course.q[row, 0], item.course.rate[row, 0]]
        for item in search.primary(speeds)
        for row, place in enumerate(item.index)
    }
    for index, speed in enumerate(speeds):
        shot = periodic(SpringInFront(angle, speed, 0.5, ratio), courses[index])
        assert found.trace[index] == pytest.approx(shot.trace, abs=1e-9)
        assert found.determinant[index] == pytest.approx(shot.determinant, abs=1e-9)
    np.testing.assert_allclose(found.determinant, found.liouville, atol=1e-11)
    if not ratio:
        assert np.max(np.abs(found.determinant - 1.0)) < 1e-11


def test_two_modes_that_grow_together_are_no_flutter() -> None:
    """With damping the averaged equation decays, so that its coefficients' change is to blame."""
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, 1e-4, 1e-4)
    search = MotionSearch(rotating_scene(elastic_rigs.scene(line, np.radians(15.0))))
    # ω² = 3 ∓ √5 in units of k/(2 J): the middle of the combined region.
    middle = np.mean(np.sqrt(3.0 + np.array([-1.0, 1.0]) * np.sqrt(5.0)))
    assert stability(search, np.array([middle, 1.4])).kind.tolist() == ["combination", "stable"]


@pytest.mark.slow
def test_undamped_multipliers_are_reciprocal_pairs() -> None:
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0)
    search = MotionSearch(rotating_scene(elastic_rigs.scene(line, np.radians(15.0))))
    found = stability(search, np.linspace(0.61, 2.9, 23))
    assert np.max(np.abs(found.determinant - 1.0)) < 1e-11
    apart = separation(found.multipliers) > 0.05
    assert np.sum(apart) > 15
    for values in found.multipliers[apart]:
        gaps = np.abs(values[:, None] * values[None, :] - 1.0)
        assert np.max(np.min(gaps, axis=1)) < 1e-9


def test_speeds_without_a_motion_are_marked() -> None:
    search = MotionSearch(
        rotating_scene(elastic_rigs.scene(elastic_rigs.torsional_line(), 0.3)), max_amplitude=0.1
    )
    found = stability(search, np.array([0.5, 1.5]))
    assert found.kind.tolist() == ["no motion", "stable"]
    assert np.isnan(found.trace[0])
