"""Branch and bound over teeth against all combinations."""

import itertools

import numpy as np
import pytest

from cardan_dyn.analytic import drive_line
from cardan_dyn.practice.drive_lines.design.fork_choice import StepSearch


@pytest.mark.parametrize("seed", range(30))
def test_all_combinations_are_no_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 5))
    betas = rng.uniform(0.03, 0.6, count)
    teeth = rng.integers(3, 12, count - 1)
    steps = [rng.uniform(0, 6) + np.arange(number) * np.pi / number for number in teeth]
    corners = [count] if seed % 2 else sorted({count, int(rng.integers(1, count + 1))})
    found = StepSearch(betas, steps, corners, 5, 20_000_000)
    choices = np.array(list(itertools.product(*(range(number) for number in teeth))))
    phases = np.zeros((len(choices), count))
    for k, step in enumerate(steps):
        phases[:, k + 1] = phases[:, k] + step[choices[:, k]]
    values = np.max(
        [
            np.tan(drive_line.residual_angle(betas[:end], phases[:, :end]) / 2) ** 2
            for end in corners
        ],
        axis=0,
    )
    best = np.sort(np.broadcast_to(values, len(choices)))[:5]
    assert found.complete
    assert found.values == pytest.approx(best, abs=1e-14)
    picked = phases[[int(np.flatnonzero((choices == c).all(axis=1))[0]) for c in found.choices]]
    again = drive_line.residual_angle(betas, picked)
    assert (np.tan(again / 2) ** 2 <= found.values + 1e-14).all()


def test_most_branches_are_left_out() -> None:
    betas = np.radians([12.0, 9.0, 14.0, 8.0, 11.0, 10.0])
    steps = [np.arange(24) * np.pi / 24 + 0.01 * k for k in range(5)]
    found = StepSearch(betas, steps, [6], 8, 20_000_000)
    assert found.complete
    assert found.visited < 24**5 / 10


def test_a_search_that_is_cut_short_says_so() -> None:
    betas = np.radians([12.0, 9.0, 14.0, 8.0])
    steps = [np.arange(24) * np.pi / 24 for _ in range(3)]
    found = StepSearch(betas, steps, [4], 8, 100)
    assert not found.complete
