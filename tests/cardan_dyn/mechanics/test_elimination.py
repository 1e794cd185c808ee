"""Sparse elimination beside NumPy's dense solvers."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.mechanics.elimination import (
    THRESHOLD,
    UnsuitableError,
    chosen,
    chosen_at_each,
    eliminated,
)
from cardan_dyn.kit.arrays import NOTHING

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
    factors = eliminated(rows, chosen(rows))
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
    order = chosen(rows)
    assert np.all(eliminated(rows, order).growth <= 1.0 / THRESHOLD + 1e-9) or any(
        len(row) > 1 for row in rows
    )
    first = order.pivots[0]
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
    order = chosen(rows)
    assert sorted((pivot.row, pivot.column) for pivot in order.pivots) in (
        [(0, 0), (1, 1)],
        [(0, 1), (1, 0)],
    )
    with np.errstate(all="ignore"):
        growth = eliminated(rows, order).growth
    assert 0 < np.count_nonzero(growth > 1.0 / THRESHOLD) < SAMPLES


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("redundant", [0, 2])
def test_growth_says_nothing_of_units_of_rows(seed: int, redundant: int) -> None:
    """Rows of a short lever and of a long one are eliminated in the same order, alike."""
    rows, _ = system(seed, redundant)
    units = 2.0 ** np.random.default_rng(seed).integers(-20, 20, len(rows))
    scaled = [{c: unit * x for c, x in row.items()} for unit, row in zip(units, rows, strict=True)]
    order, other = chosen(rows), chosen(scaled, nothing=NOTHING * 2.0**-20)
    assert order.places == other.places
    growths = [eliminated(of, by).growth for of, by in ((rows, order), (scaled, other))]
    np.testing.assert_array_equal(*growths)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("redundant", [0, 2])
def test_orders_at_each_sample_are_those_of_the_sample_alone(seed: int, redundant: int) -> None:
    rows, _ = system(seed, redundant)
    rng = np.random.default_rng(seed)
    for row in rows:  # Large pivots here are small ones there.
        row.update({c: x * 10.0 ** rng.uniform(-3.0, 0.0, SAMPLES) for c, x in row.items()})
    together, without = chosen_at_each(rows, None, NOTHING)
    assert not len(without)
    assert sorted(np.concatenate([own for _, own in together])) == list(range(SAMPLES))
    for order, own in together:
        for sample in own:
            alone = [{c: x[sample : sample + 1] for c, x in row.items()} for row in rows]
            ((single, _),), _ = chosen_at_each(alone, None, NOTHING)
            assert single.places == order.places
            growth = eliminated(alone, single).growth
            assert np.all(growth <= 1.0 / THRESHOLD + 1e-9)


def test_a_sample_at_which_a_column_vanishes_has_no_order_of_its_own() -> None:
    entry = np.array([1.0, 0.0, 2.0])
    together, without = chosen_at_each([{0: entry, 1: entry}, {1: np.ones(3)}], None, NOTHING)
    assert without.tolist() == [1]
    assert [own.tolist() for _, own in together] == [[0, 2]]


def test_of_equally_cheap_rows_one_that_tells_more_is_taken() -> None:
    """A slide in the frame of a loop, all three rows of which are off by the same rounding."""
    along = np.array([[-7.2e-5, 6.5e-3, -1.0], [1.0, 2e-4, 0.3]])
    together, without = chosen_at_each([{0: entry} for entry in along.T], None, NOTHING)
    assert not len(without)
    for order, own in together:
        rounding = np.full(3, 1e-16)
        for sample in own:
            rows = [{0: float(entry)} for entry in along[sample]]
            found = eliminated(rows, order).solve([*(along[sample] * 0.7 + rounding)])
            assert found[0] == pytest.approx(0.7, rel=0.0, abs=1e-14)


def test_a_column_that_vanishes_has_no_order() -> None:
    with pytest.raises(UnsuitableError):
        chosen([{0: np.zeros(SAMPLES), 1: np.ones(SAMPLES)}, {1: np.ones(SAMPLES)}])


def test_blocks_are_eliminated_by_their_own_rows() -> None:
    """Redundant rows are then those of each block by itself."""
    rng = np.random.default_rng(5)
    entry = rng.normal(size=(9, SAMPLES))
    # The second block has rows of its own and a combination of these.
    second = [{0: entry[0], 2: entry[1]}, {0: entry[2], 2: entry[3], 3: entry[4]}]
    second.append(
        {column: 2.0 * second[0].get(column, 0.0) - value for column, value in second[1].items()}
    )
    rows = [{0: entry[5], 1: entry[6]}, {0: entry[7], 1: entry[8]}, *second]
    order = chosen(rows, [((0, 1), (0, 1)), ((2, 3, 4), (2, 3))])
    assert {pivot.row for pivot in order.pivots if pivot.column < 2} == {0, 1}
    factors = eliminated(rows, order)
    (redundant,) = factors.redundant
    assert redundant >= 2
    assert set(factors.dependence(redundant)) <= {2, 3, 4} or all(
        np.abs(factors.dependence(redundant)[row]).max() < 1e-10 for row in (0, 1)
    )
