"""Motions that coexist near forced resonances."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

import cardan_dyn.vibration.coexisting as module
from cardan_dyn.vibration.coexisting import coexisting, smallest
from cardan_dyn.vibration.motion_search import MotionSearch
from cardan_dyn.vibration.rotating_scene import rotating_scene

BETA = np.radians(15.0)


def search(damping: float = 0.0, beta: float = BETA) -> MotionSearch:
    line = elastic_rigs.torsional_line(damping_in=damping)
    return MotionSearch(rotating_scene(elastic_rigs.scene(line, beta)))


def test_motions_that_coexist_at_a_forced_resonance() -> None:
    finder = search()
    (first,) = finder.primary(np.array([0.5]))
    every = [first, *coexisting(finder, first)]
    starts = [
        np.r_[item.course.q[row, 0], item.course.rate[row, 0]]
        for item in every
        for row in range(len(item.index))
    ]
    assert len(starts) == 4
    for start in starts:
        found = periodic(SpringInFront(BETA, 0.5), start)
        np.testing.assert_allclose(found.start, start, atol=1e-9)
    gaps = [np.max(np.abs(a - b)) for i, a in enumerate(starts) for b in starts[:i]]
    assert min(gaps) > 0.01


def test_a_fold_has_three_motions_of_which_one_is_unstable() -> None:
    finder = search(0.04, np.radians(45.0))
    (first,) = finder.primary(np.array([0.505]))
    every = [first, *coexisting(finder, first, is_thorough=True)]
    signs = sorted(float(item.sign[0]) for item in every)
    assert signs == [-1.0, 1.0, 1.0]


def test_the_smallest_is_chosen() -> None:
    finder = search(0.04, np.radians(45.0))
    (found,), counts = smallest(finder, np.array([0.5]))
    start = np.r_[found.course.q[0, 0], found.course.rate[0, 0]]
    shot = periodic(SpringInFront(np.radians(45.0), 0.5, 0.5, 0.02), start)
    np.testing.assert_allclose(shot.start, start, atol=1e-9)
    # The others swing by 0.54 and 0.77 rad.
    assert np.max(np.abs(found.course.q - np.mean(found.course.q))) < 0.535
    assert counts.tolist() == [2]


def test_where_the_linear_equation_holds_nothing_is_searched() -> None:
    finder = search(0.4)
    (first,) = finder.primary(np.array([0.5, 0.9]))
    assert coexisting(finder, first, is_thorough=True) == []


@pytest.mark.parametrize("phase", [0.25, 0.5])
def test_where_one_of_a_pair_was_found_the_other_is_searched(
    phase: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    # These guesses alone lead to one of the two further motions.
    monkeypatch.setattr(module, "_SHARES", (0.5,))
    monkeypatch.setattr(module, "_PHASES", (phase,))
    finder = search(0.04, np.radians(45.0))
    (first,) = finder.primary(np.array([0.505]))
    others = coexisting(finder, first)
    assert sorted(float(item.sign[0]) for item in others) == [-1.0, 1.0]
