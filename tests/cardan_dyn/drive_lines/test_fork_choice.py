"""What forks can take, and forks that are free, fixed and on splines in one line."""

import itertools

import numpy as np
import pytest

from cardan_dyn.analytic import drive_line
from cardan_dyn.practice.drive_lines.design import fork_choice as forks


def test_teeth() -> None:
    even, odd = forks.tooth_offsets(0.1, 24), forks.tooth_offsets(0.1, 7)
    assert len(even) == 12
    assert len(odd) == 7
    for offsets, teeth in ((even, 24), (odd, 7)):
        # Every offset is a whole number of teeth from the first, but for half turns.
        turns = (offsets[:, None] - 0.1 + np.pi * np.arange(2)) / (2 * np.pi / teeth)
        assert np.abs(turns - np.rint(turns)).min(axis=1) == pytest.approx(0.0, abs=1e-12)


def test_half_turns_are_taken_off() -> None:
    found = forks.halved(np.array([0.0, np.pi, -np.pi / 2, 3 * np.pi / 2, 2.0, -7.0, 1e-17]))
    expected = [0.0, 0.0, np.pi / 2, np.pi / 2, 2.0 - np.pi, 2 * np.pi - 7.0, 0.0]
    assert found == pytest.approx(expected, abs=1e-15)
    assert (found[[0, 1, 6]] == 0.0).all()


def test_offsets_and_phases_are_inverse() -> None:
    rng = np.random.default_rng(0)
    planes, offsets = rng.uniform(-3, 3, 5), rng.uniform(-1.5, 1.5, 4)
    assert forks.offsets_of(forks.phases_of(offsets, planes), planes) == pytest.approx(offsets)


def least(betas: np.ndarray, planes: np.ndarray, lists: list[np.ndarray], ends: list[int]) -> float:
    """The least greatest residual angle of all combinations [rad]."""
    offsets = np.array(list(itertools.product(*lists)))
    phases = forks.phases_of(offsets, planes)
    angles = [drive_line.residual_angle(betas[:end], phases[:, :end]) for end in ends]
    return float(np.max(angles, axis=0).min())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("kind", ["tooth first", "tooth last", "inner shaft", "later shaft"])
def test_free_forks_beside_teeth(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    betas, planes = rng.uniform(0.05, 0.5, 3), rng.uniform(-3, 3, 3)
    teeth, fine = forks.tooth_offsets(0.2, 10), np.linspace(-np.pi / 2, np.pi / 2, 2001)
    is_first = kind in ("tooth first", "inner shaft")
    ends = {"inner shaft": [2, 3], "later shaft": [2, 3]}.get(kind, [3])
    allowed = [teeth, None] if is_first else [None, teeth]
    lists = [fine if values is None else values for values in allowed]
    found = forks.least_residual(betas, planes, allowed, ends, np.zeros(2), 8)
    phases = forks.phases_of(found.offsets, planes)
    angles = [drive_line.residual_angle(betas[:end], phases[:, :end]) for end in ends]
    value = float(np.max(angles, axis=0).min())
    grid = least(betas, planes, lists, ends)
    assert value <= grid + 1e-7
    assert value**2 >= grid**2 - 2e-3 * betas.max() ** 2  # the grid's step of 0.09°
    assert found.complete == (kind != "later shaft")


def test_choices_keep_to_the_teeth() -> None:
    betas, planes = np.radians([14.0, 9.0, 12.0, 10.0]), np.array([0.0, 1.0, -2.0, 0.5])
    teeth = forks.tooth_offsets(0.3, 16)
    found = forks.least_residual(betas, planes, [None, teeth, None], [4], np.zeros(3), 8)
    apart = np.abs(forks.halved(found.offsets[:, 1, None] - teeth)).min(axis=1)
    assert apart == pytest.approx(0.0, abs=1e-14)
