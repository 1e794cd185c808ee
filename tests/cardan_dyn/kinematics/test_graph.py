"""Matching and strong components, against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from cardan_dyn.core.kinematics.loops.groups import components, matched

ROWS = st.lists(st.lists(st.integers(0, 8), unique=True, max_size=5), max_size=10)


@pytest.mark.slow
@given(ROWS)
@settings(max_examples=300, deadline=None)
def test_a_matching_is_valid_and_as_great_as_that_of_scipy(options: list[list[int]]) -> None:
    matching = matched(options)
    assert all(column in options[row] for column, row in matching.items())
    assert len(set(matching.values())) == len(matching)
    graph = np.zeros((len(options) + 1, 9), dtype=int)
    for row, columns in enumerate(options):
        graph[row, columns] = 1
    greatest = maximum_bipartite_matching(csr_array(graph), perm_type="column")
    assert len(matching) == np.sum(greatest >= 0)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], {}),
        ([[], [3]], {3: 1}),
        ([[1, 2], [1]], {2: 0, 1: 1}),
        # The last row gets a column only if both rows before it take their next ones.
        ([[0, 1], [1, 2], [0]], {0: 2, 1: 0, 2: 1}),
    ],
)
def test_rows_hand_over_columns(options: list[list[int]], expected: dict[int, int]) -> None:
    assert matched(options) == expected


@pytest.mark.slow
@given(st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=20))
@settings(max_examples=300, deadline=None)
def test_components_are_those_of_scipy(edges: set[tuple[int, int]]) -> None:
    graph = np.zeros((8, 8), dtype=int)
    for start, end in edges:
        graph[start, end] = 1
    _, labels = connected_components(csr_array(graph), connection="strong")
    smallest = components(8, edges)
    for first in range(8):
        for second in range(8):
            assert (smallest[first] == smallest[second]) == (labels[first] == labels[second])


def test_components_are_named_by_their_smallest_node() -> None:
    assert components(5, {(4, 1), (1, 4), (0, 1), (2, 3)}) == [0, 1, 2, 3, 1]
    assert components(2, set()) == [0, 1]
