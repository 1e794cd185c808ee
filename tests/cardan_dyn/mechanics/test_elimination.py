"""Sparse elimination beside NumPy's dense solvers."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.mechanics.elimination import THRESHOLD, UnsuitableError, eliminated, pivots

SAMPLES = 16


def system(seed: int, redundant: int = 0) -> tuple[list[dict[int, np.ndarray]], np.ndarray]:
    """Return sparse rows at many samples, some of them combinations of others; and all dense."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 9))
    while True:
        mask = rng.random((size, size)) < 0.4
        np.fill_diagonal(mask, True)
        mask = mask[rng.permutation(size)]
        dense = rng.normal(size=(SAMPLES, size, size)) * mask
        if np.linalg.cond(dense).max() < 1e4:
            break
    combined = np.einsum("ri,nij->nrj", rng.normal(size=(redundant, size)), dense)
    dense = np.concatenate([dense, combined], axis=1)[:, rng.permutation(size + redundant)]
    rows = [
        {column: dense[:, row, column] for column in range(size) if dense[:, row, column].any()}
        for row in range(dense.shape[1])
    ]
    return rows, dense


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("redundant", [0, 1, 3])
def test_systems_are_solved_as_dense_ones(seed: int, redundant: int) -> None:
    rows, dense = system(seed, redundant)
    factors = eliminated(rows, pivots(rows))
    count, size = dense.shape[1:]
    assert len(factors.redundant) == redundant
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(size, SAMPLES))
    right = np.einsum("nij,jn->in", dense, x)
    found = factors.solve(list(right))
    tolerance = 1e-13 * np.linalg.cond(dense).max()
    np.testing.assert_allclose([found[k] for k in range(size)], x, atol=tolerance * np.abs(x).max())

    effort = rng.normal(size=(size, SAMPLES))
    solved = factors.solve_transposed(dict(enumerate(effort)))
    multipliers = np.array([solved.get(row, np.zeros(SAMPLES)) for row in range(count)])
    np.testing.assert_allclose(
        np.einsum("nij,in->jn", dense, multipliers), effort, atol=tolerance * 10
    )
    for row in factors.redundant:
        assert row not in solved
        found = factors.dependence(row)
        assert found[row] == 1.0
        stress = np.array([found.get(k, 0.0) + np.zeros(SAMPLES) for k in range(count)])
        size_of = max(1.0, np.abs(stress).max())
        np.testing.assert_allclose(
            np.einsum("nij,in->jn", dense, stress), 0.0, atol=tolerance * size_of
        )


@pytest.mark.parametrize("seed", range(10))
def test_growth_tells_where_an_order_does_not_serve(seed: int) -> None:
    """Small pivots elsewhere are seen: by what is taken from other rows, or by their own size."""
    rows, dense = system(seed)
    order = pivots(rows)
    assert np.all(eliminated(rows, order).growth <= 1.0 / THRESHOLD + 1e-9) or any(
        len(row) > 1 for row in rows
    )
    first = order[0]
    spoilt = [dict(row) for row in rows]
    spoilt[first.row][first.column] = spoilt[first.row][first.column] * 1e-9
    factors = eliminated(spoilt, order)
    assert np.all(np.maximum(factors.growth, factors.narrowness) > 1e6)
    spoilt[first.row][first.column] = np.zeros(SAMPLES)
    with np.errstate(all="ignore"):
        factors = eliminated(spoilt, order)
    assert not np.any((factors.growth <= 1e6) & (factors.narrowness <= 1e6))
    assert dense.size


def test_pivots_that_are_small_at_some_samples_are_taken_where_there_is_no_other() -> None:
    angle = np.linspace(0.0, np.pi, 4 * SAMPLES)
    rows = [{0: np.cos(angle), 1: np.sin(angle)}, {0: -np.sin(angle), 1: np.cos(angle)}]
    order = pivots(rows)
    assert sorted((pivot.row, pivot.column) for pivot in order) in (
        [(0, 0), (1, 1)],
        [(0, 1), (1, 0)],
    )
    with np.errstate(all="ignore"):
        growth = eliminated(rows, order).growth
    assert 0 < np.count_nonzero(growth > 1.0 / THRESHOLD) < SAMPLES


def test_a_column_that_vanishes_has_no_order() -> None:
    with pytest.raises(UnsuitableError):
        pivots([{0: np.zeros(SAMPLES), 1: np.ones(SAMPLES)}, {1: np.ones(SAMPLES)}])
