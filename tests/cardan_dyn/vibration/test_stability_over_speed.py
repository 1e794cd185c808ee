"""Stability between speeds at which it is known, against that which is found right there."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from benchmarks.waiting import _rig
from cardan_dyn import Scene, vibration
from cardan_dyn.motion.vibration.model.efforts import FreeEfforts, LocalEfforts
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions import regions as module
from cardan_dyn.motion.vibration.motions.regions import StabilityOverSpeed
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.motions.stability import NONE, Stability, stability


@pytest.fixture
def looked_at(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Speeds at which motions are found."""
    speeds: list[float] = []

    def counted(search: MotionSearch, asked: np.ndarray) -> Stability:
        speeds.extend(asked.tolist())
        return stability(search, asked)

    monkeypatch.setattr(module, "stability", counted)
    return speeds


def over(scene: Scene, speeds: np.ndarray) -> tuple[MotionSearch, StabilityOverSpeed]:
    search = MotionSearch(rotating_scene(scene))
    return search, StabilityOverSpeed(search, speeds, stability(search, speeds))


def by_size(multipliers: np.ndarray) -> np.ndarray:
    return np.sort(np.abs(multipliers), axis=1)


def test_multipliers_are_told_as_they_are_found(looked_at: list[float]) -> None:
    """Through the region of a spring in front, most of 200 speeds take no motion of their own."""
    line = elastic_rigs.torsional_line(damping_in=0.01)
    ends = np.linspace(0.8, 1.2, 31)
    search, told = over(elastic_rigs.scene(line, np.radians(20.0)), ends)
    speeds = np.random.default_rng(2).uniform(0.8, 1.2, 200)
    found, exact = told.at(speeds), stability(search, speeds)
    np.testing.assert_array_equal(found.kind, exact.kind)
    assert {"stable", "instability"} == set(found.kind.tolist())
    np.testing.assert_allclose(by_size(found.multipliers), by_size(exact.multipliers), atol=1e-9)
    assert len(looked_at) < 20


def test_known_speeds_may_be_neighbours_among_floating_point_numbers() -> None:
    """Edges are found to rounding; speeds beside them are told without dividing by zero."""
    line = elastic_rigs.torsional_line(damping_in=0.01)
    beside = np.array([1.9, np.nextafter(1.9, 2.0)])
    assert beside[0] < beside[1]
    assert 1.0 / beside[0] == 1.0 / beside[1]
    ends = np.unique([*np.linspace(1.7, 2.1, 31), *beside])
    search, told = over(elastic_rigs.scene(line, np.radians(20.0)), ends)
    speeds = np.linspace(1.85, 1.95, 12)
    found, exact = told.at(speeds), stability(search, speeds)
    np.testing.assert_array_equal(found.kind, exact.kind)
    np.testing.assert_allclose(by_size(found.multipliers), by_size(exact.multipliers), atol=1e-9)


@pytest.mark.slow
def test_nothing_is_told_across_jumps(looked_at: list[float]) -> None:
    """Where a resonance leans over, the smallest motion is another one from a speed on."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.04), np.radians(45.0))
    search, told = over(scene, np.linspace(0.44, 0.56, 25))
    speeds = np.linspace(0.4401, 0.5599, 60)
    found, exact = told.at(speeds), stability(search, speeds)
    assert np.ptp(exact.coexisting) > 0
    np.testing.assert_array_equal(found.kind, exact.kind)
    np.testing.assert_allclose(by_size(found.multipliers), by_size(exact.multipliers), atol=1e-9)
    assert looked_at


@pytest.mark.slow
def test_beside_speeds_without_a_motion_each_is_looked_at(looked_at: list[float]) -> None:
    line = elastic_rigs.torsional_line(damping_in=0.02)
    scene = elastic_rigs.scene(line, np.radians(15.0))
    search = MotionSearch(rotating_scene(scene), 0.1)
    ends = np.linspace(0.46, 0.56, 26)
    known = stability(search, ends)
    (missed,) = np.nonzero(known.kind == NONE)
    assert missed.size
    speeds = 0.5 * (ends[1:] + ends[:-1])
    found = StabilityOverSpeed(search, ends, known).at(speeds)
    beside = {*missed.tolist(), *(missed - 1).tolist()} & set(range(len(speeds)))
    assert set(speeds[sorted(beside)].tolist()) <= set(looked_at)
    np.testing.assert_array_equal(found.kind, stability(search, speeds).kind)


@pytest.mark.slow
def test_a_table_of_four_freedoms_takes_few_motions(
    looked_at: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    samples: list[int] = []
    local = FreeEfforts.local

    def sampled(self: FreeEfforts, positions: np.ndarray, *moves: np.ndarray) -> LocalEfforts:
        samples.append(positions[..., 0].size)
        return local(self, positions, *moves)

    monkeypatch.setattr(FreeEfforts, "local", sampled)
    scene = _rig("twist_in", "tilt_z", "tilt_y", "twist_out")
    table = vibration.critical_speeds(scene, [0.3, 1.5], orders=(2,))
    assert [round(row.speed, 3) for row in table] == [0.364, 0.456, 0.754, 1.315]
    assert sum(samples) < 160_000
    assert len(samples) < 1_400
    assert len(looked_at) < 350
