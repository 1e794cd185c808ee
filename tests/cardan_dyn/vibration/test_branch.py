"""Branches of motions that turn back, against a continuation of equations by hand."""

from __future__ import annotations

import numpy as np
import pytest
from continuation import Branch as OwnBranch
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

from cardan_dyn.kit.periodic import amplitudes
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.continuation import Branch, Point
from cardan_dyn.motion.vibration.motions.search import MotionSearch

BETA, RATIO = np.radians(20.0), 4e-3


@pytest.fixture(scope="module")
def scene() -> object:
    return elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=2.0 * RATIO), BETA)


@pytest.mark.slow
def test_folds_and_peak(scene: object) -> None:
    search = MotionSearch(rotating_scene(scene))
    own = OwnBranch(lambda speed: SpringInFront(BETA, speed, 0.5, RATIO), 1, np.pi, 47, 0.3)
    curve = own.follow(0.46, 0.55)
    sizes = np.abs(curve.order(2)[:, 0])
    expected = own.extremum(curve, int(np.argmax(sizes)), lambda of: np.abs(of.order(2)[:, 0]))
    folds = [
        sense * own.extremum(curve, at, lambda of, sense=sense: sense * of.speed)[1]
        for at, sense in zip(curve.folds, (1.0, -1.0), strict=True)
    ]
    for ends in ((0.46, 0.55), (0.55, 0.46)):
        (start,) = search.primary(np.array(ends[:1]))
        found = Branch(Point.of(start), ends[1])
        assert found.is_whole
        assert not found.reason
        speeds = np.array([point.speed for point in found.points])
        turns = np.nonzero(np.diff(np.sign(np.diff(speeds))))[0] + 1
        assert len(turns) == 2
        at = [fold.point.speed for fold in found.folds]
        assert sorted(at) == pytest.approx(sorted(folds), rel=1e-8)
        # Between the folds, motions have the other sign.
        signs = [point.sign for point in found.points]
        assert signs[0] == signs[-1] == 1.0
        assert set(signs[turns[0] + 1 : turns[1]]) == {-1.0}

        def size(point: object) -> float:
            return float(np.abs(amplitudes(point.q)[1, 0]))

        at = int(np.argmax([size(point) for point in found.points]))
        top, is_met = found.greatest(at, size)
        assert is_met and all(fold.is_met for fold in found.folds)
        assert (top.speed, size(top)) == pytest.approx(expected, rel=1e-7)


def test_a_branch_ends_where_motions_are_too_large(scene: object) -> None:
    search = MotionSearch(rotating_scene(scene), max_amplitude=0.2)
    (start,) = search.primary(np.array([0.46]))
    found = Branch(Point.of(start), 0.55)
    assert not found.is_whole
    assert "`max_amplitude`, 0.2" in found.reason
    assert max(float(np.max(np.abs(point.q))) for point in found.points) > 0.1
