"""Searches for periodic motions: ranges, what is carried, and what is missed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft
from vibrating_lines import SpringInFront

from benchmarks.waiting import _rig
from cardan_dyn.kit.errors import AccuracyError
from cardan_dyn.motion.vibration.model.build import ModelBuild
from cardan_dyn.motion.vibration.model.efforts import FreeEfforts, Terms
from cardan_dyn.motion.vibration.model.reduced_model import ReducedModel
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import course_of
from cardan_dyn.motion.vibration.motions.linear import linear_motions
from cardan_dyn.motion.vibration.motions.models import FIRST_RANGE
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.results.periodic_motion import periodic_motion

BETA = np.radians(15.0)


def search(urdf: str, beta: float, max_amplitude: float = 1.0, **options: object) -> MotionSearch:
    return MotionSearch(rotating_scene(elastic_rigs.scene(urdf, beta, **options)), max_amplitude)


def test_ranges_grow_only_where_motions_are_large() -> None:
    finder = search(elastic_rigs.torsional_line(), BETA)
    found = finder.primary(np.array([0.3, 0.5, 1.5]))
    ranges = {int(place): float(item.model.half[0]) for item in found for place in item.index}
    assert ranges[0] == ranges[2] == FIRST_RANGE
    assert ranges[1] > 0.3


def test_a_load_moves_the_middle() -> None:
    # A mean torque of 0.4 N·m twists the shaft by 0.4 rad, beyond the first range.
    finder = search(elastic_rigs.torsional_line(), 0.1, loads={"bearing_out": -0.4})
    (found,) = finder.primary(np.array([0.8]))
    assert found.model.half[0] == FIRST_RANGE
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
    (found,) = finder.every(np.array([0.51]))
    assert not finder.missed
    start = np.r_[found.course.q[0, 0], found.course.rate[0, 0]]
    shot = periodic(SpringInFront(np.radians(45.0), 0.51, 0.5, 0.02), start)
    np.testing.assert_allclose(shot.start, start, atol=1e-9)
    assert 0.4 < np.max(np.abs(found.course.q)) < 0.6
    assert finder.primary(np.array([0.51])) == []


@pytest.mark.campaign
@pytest.mark.slow
def test_a_motion_larger_than_any_model_of_a_range() -> None:
    """A shaft at 45° that tilts by 20° and more: it has a model about itself."""
    finder, speed = search(elastic_rigs.elastic_rig(), np.radians(45.0)), np.array([0.473])
    _, second = finder.every(speed)
    assert second.model.half.tolist() == [0.02, 0.02]
    assert np.max(np.abs(second.course.q)) > 0.33
    mean = np.mean(second.course.q[0], axis=0)
    assert np.max(np.abs(mean - second.middle.centre) / second.middle.half) < 1.0
    assert second.middle.count == second.model.count
    start = np.r_[second.course.q[0, 0], second.course.rate[0, 0]]
    system = TiltingShaft(np.radians(45.0), speed[0])
    np.testing.assert_allclose(periodic(system, start).start, start, atol=1e-9)
    # The linear equation is about the mean, far from the motion.
    linear = linear_motions(second)
    found = course_of(linear, speed, second.model.period)
    ways = (found.q[0] - mean, speed * found.rate[0], speed**2 * found.bend[0])

    def efforts(share: float) -> np.ndarray:
        firsts = (second.model.positions, np.full(len(ways[0]), speed[0]), np.zeros(len(ways[0])))
        middles = (mean, 0.0, 0.0)
        return finder.models.efforts(
            *(
                np.column_stack([first, middle + share * way])
                for first, middle, way in zip(firsts, middles, ways, strict=True)
            )
        )

    rise = (efforts(1e-3) - efforts(-1e-3)) / 2e-3
    np.testing.assert_allclose(efforts(0.0) + rise, 0.0, atol=1e-5 * np.max(np.abs(rise)))


def test_ranges_that_were_refused_are_not_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    finder = search(elastic_rigs.elastic_rig(), 0.1)
    models, centre = finder.models, np.zeros(2)
    models.grown(centre, 0.05)
    tried: list[float] = []

    def refused(_: ModelBuild, __: object, half: np.ndarray, *___: object) -> ReducedModel:
        tried.append(float(half[0]))
        raise AccuracyError("too uneven")

    monkeypatch.setattr(ModelBuild, "model", refused)
    assert [models.grown(centre, share) for share in (0.15, 0.15, 0.45)] == [None] * 3
    assert tried == [0.15]


@pytest.mark.slow
def test_a_range_that_is_refused_leaves_the_known_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is not smooth beyond the first range is looked at within that."""
    finder, first = search(elastic_rigs.torsional_line(), BETA), FIRST_RANGE
    (known,) = {item.model.half[0] for item in finder.primary(np.array([0.3]))}
    assert known == first
    tried: list[float] = []
    model = ModelBuild.model

    def refused(
        self: ModelBuild, centre: np.ndarray, half: np.ndarray, *given: Any
    ) -> ReducedModel:
        tried.append(float(half[0]))
        if half[0] > first:
            raise AccuracyError("uneven", residual=1e-8, tolerance=1e-9)
        return model(self, centre, half, *given)

    monkeypatch.setattr(ModelBuild, "model", refused)
    assert finder.models.widest(np.zeros(1), 0.14).half[0] == first
    assert 1 < len(tried) < 6
    assert min(tried) > first


@pytest.mark.slow
def test_four_coordinates_that_tilt_and_twist(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps agree with a motion, and no more is sampled than it takes."""
    counts: list[int] = []
    terms = FreeEfforts.terms

    def counted(self: FreeEfforts, positions: np.ndarray) -> Terms:
        counts.append(len(positions))
        return terms(self, positions)

    monkeypatch.setattr(FreeEfforts, "terms", counted)
    scene = _rig("twist_in", "tilt_z", "tilt_y", "twist_out")
    found = periodic_motion(scene, 0.6)
    assert not found.missed
    assert np.max(found.residual) < 1e-12
    assert sum(counts) < 5_000
