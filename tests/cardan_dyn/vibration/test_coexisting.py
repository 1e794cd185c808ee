"""Motions that coexist near forced resonances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.search import MotionSearch

BETA = np.radians(15.0)


def search(damping: float = 0.0, beta: float = BETA) -> MotionSearch:
    line = elastic_rigs.torsional_line(damping_in=damping)
    return MotionSearch(rotating_scene(elastic_rigs.scene(line, beta)))


@pytest.mark.slow
def test_motions_that_coexist_at_a_forced_resonance() -> None:
    finder = search()
    every = finder.every(np.array([0.5]))
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


@pytest.mark.slow
def test_a_fold_has_three_motions_of_which_one_is_unstable() -> None:
    finder = search(0.04, np.radians(45.0))
    every = finder.every(np.array([0.505]))
    signs = sorted(float(sign) for item in every for sign in item.sign)
    assert signs == [-1.0, 1.0, 1.0]


@pytest.mark.slow
def test_the_smallest_is_chosen() -> None:
    finder = search(0.04, np.radians(45.0))
    (found,), counts = finder.smallest(np.array([0.5]))
    start = np.r_[found.course.q[0, 0], found.course.rate[0, 0]]
    shot = periodic(SpringInFront(np.radians(45.0), 0.5, 0.5, 0.02), start)
    np.testing.assert_allclose(shot.start, start, atol=1e-9)
    # The others swing by 0.54 and 0.77 rad.
    assert np.max(np.abs(found.course.q - np.mean(found.course.q))) < 0.535
    assert counts.tolist() == [2]


def test_where_the_linear_equation_holds_nothing_is_searched() -> None:
    finder = search(0.4)
    speeds = np.array([0.5, 0.9])
    first, again = finder.primary(speeds), finder.every(speeds)
    assert sum(len(item.index) for item in first) == 2
    for one, other in zip(first, again, strict=True):
        np.testing.assert_allclose(one.course.q, other.course.q, rtol=0, atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.1, 0.34])
def test_motions_of_a_slider_crank_behind_an_elastic_shaft(ratio: float) -> None:
    """All that coexist, whichever comes first, far from the linear one; a close pair beside a fold.

    J(θ) θ'' + J'(θ) θ'²/2 + (k (θ - φ) + d Ω (θ' - 1)) / Ω² = 0 by the crank's rotation, with
    J = J₁ + m x'(θ)² and the slider at x = r cos θ + √(1 - r² sin² θ).
    """
    inertia, stiffness, damping, radius = 0.05, 0.1, 0.002, 0.3
    speed = ratio * np.sqrt(stiffness / (inertia + 0.5 * radius**2))

    def rates(phi: float, y: np.ndarray) -> np.ndarray:
        theta = phi + y[0]
        sine, cosine = np.sin(theta), np.cos(theta)
        root = np.sqrt(1.0 - (radius * sine) ** 2)
        way = -radius * sine - radius**2 * sine * cosine / root
        bend = -radius * cosine - radius**2 * (cosine**2 - sine**2) / root
        bend -= radius**4 * (sine * cosine) ** 2 / root**3
        forces = way * bend * (1.0 + y[1]) ** 2
        forces += (stiffness * y[0] + damping * speed * y[1]) / speed**2
        return np.array([y[1], -forces / (inertia + way**2)])

    urdf = elastic_rigs.elastic_crank(inertia, stiffness, damping, radius)
    finder = MotionSearch(rotating_scene(elastic_rigs.scene(urdf, 0.0)))
    every = finder.every(np.array([speed]))
    assert sorted(float(sign) for item in every for sign in item.sign) == [-1.0, 1.0, 1.0]
    for start in (
        np.r_[item.course.q[row, 0], item.course.rate[row, 0]]
        for item in every
        for row in range(len(item.index))
    ):
        run = solve_ivp(rates, (0.0, 2.0 * np.pi), start, "DOP853", rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(run.y[:, -1], start, atol=1e-8)
