"""Degrees of polynomials that terms need."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from benchmarks.waiting import _rig
from cardan_dyn.motion.vibration.model.build import TermSamples, needed_degrees
from cardan_dyn.motion.vibration.model.polynomials import polynomials, size_of
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene

DRIVE = np.array([0.4, 1.3, 2.9])


def sampled(urdf: str, beta: float) -> TermSamples:
    return TermSamples(rotating_scene(elastic_rigs.scene(urdf, beta)))


def error_of(samples: TermSamples, degrees: tuple[int, ...], half: np.ndarray) -> float:
    """Greatest error at places of no design."""
    basis = polynomials(degrees)
    inside = np.random.default_rng(8).uniform(-1.0, 1.0, (50, len(half)))
    still = np.zeros((3, len(half)))
    exact, terms = (samples.about(DRIVE, still, half * ways) for ways in (inside, basis.nodes))
    found = basis.values(inside).T @ basis.coefficients(terms)
    return float(np.max(np.abs(found - exact) / samples.kinds(exact)))


@pytest.mark.slow
def test_errors_are_what_was_wanted() -> None:
    samples, half = sampled(elastic_rigs.elastic_rig(), 0.5), np.full(2, 0.1)
    before = 0
    for wanted in (1e-3, 1e-6, 1e-12):
        degrees, error = needed_degrees(samples, DRIVE, np.zeros((3, 2)), half, wanted)
        assert error <= wanted
        assert error_of(samples, degrees, half) < 10.0 * wanted
        assert sum(degrees) > before
        before = sum(degrees)


def test_a_coordinate_that_terms_hardly_depend_on_takes_a_low_degree() -> None:
    """The inertia behind the outer shaft is linear in its twist."""
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, fork_inertia=0.1)
    samples, half = sampled(line, 0.5), np.full(2, 0.2)
    (first, second), error = needed_degrees(samples, DRIVE, np.zeros((3, 2)), half, 1e-13)
    assert error < 1e-13
    assert first > 8
    assert second == 1


def test_four_coordinates_take_as_many_polynomials_as_those_that_act_on_each_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The twist behind the joint is alone, and places are sampled once."""
    free = ["twist_in", "tilt_z", "tilt_y", "twist_out"]
    samples, half = TermSamples(rotating_scene(_rig(*free))), np.full(4, 0.05)
    counts: list[int] = []
    at = TermSamples.at

    def counted(self: TermSamples, drive: np.ndarray, q: np.ndarray) -> np.ndarray:
        counts.append(len(q))
        return at(self, drive, q)

    monkeypatch.setattr(TermSamples, "at", counted)
    degrees, error = needed_degrees(samples, DRIVE, np.zeros((3, 4)), half, 1e-12)
    assert degrees[3] == 1
    assert max(degrees[:3]) < 13
    assert error < 1e-12
    assert sum(counts) < 3 * (size_of(degrees) + 1000)
    assert error_of(samples, degrees, half) < 1e-11


def test_coordinates_that_act_on_each_other_alone_are_no_lone_ones() -> None:
    """Terms that are products are linear in each coordinate, yet need more than that."""

    class Product:
        def at(self, drive: np.ndarray, q: np.ndarray) -> np.ndarray:
            return (np.sin(q[:, 0]) + q[:, 1] * q[:, 2])[:, None]

        def about(self, drive: np.ndarray, centre: np.ndarray, ways: np.ndarray) -> np.ndarray:
            values = self.at(drive, ways)
            return np.broadcast_to(values, (len(drive), len(ways), 1)).copy()

        def kinds(self, values: np.ndarray) -> np.ndarray:
            return np.ones(values.shape[-1])

    degrees, error = needed_degrees(
        Product(),  # type: ignore[arg-type]
        DRIVE,
        np.zeros((3, 3)),
        np.ones(3),
        1e-12,
    )
    assert error < 1e-12
    assert degrees[0] > 8
    assert min(degrees[1:]) > 1


def test_what_is_not_smooth_is_said() -> None:
    # Tilted by a right angle, the joint locks.
    samples = sampled(elastic_rigs.elastic_rig(), 0.3)
    _, error = needed_degrees(samples, DRIVE, np.zeros((3, 2)), np.full(2, 1.25), 1e-13)
    assert not error < 1e-6
