"""Graphs behind the groups, against SciPy's."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from cardan_dyn.kinematics.loop_groups import components, matched

ROWS = st.lists(st.lists(st.integers(0, 8), unique=True, max_size=5), max_size=10)


@given(ROWS)
@settings(max_examples=300, deadline=None)
def test_matching_is_one_and_as_great_as_any(options: list[list[int]]) -> None:
    found = matched(options)
    assert all(column in options[row] for column, row in found.items())
    assert len(set(found.values())) == len(found)
    graph = np.zeros((len(options) + 1, 9), dtype=int)
    for row, columns in enumerate(options):
        graph[row, columns] = 1
    greatest = maximum_bipartite_matching(csr_array(graph), perm_type="column")
    assert len(found) == np.sum(greatest >= 0)


@given(st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=20))
@settings(max_examples=300, deadline=None)
def test_components_are_those_of_scipy(edges: set[tuple[int, int]]) -> None:
    graph = np.zeros((8, 8), dtype=int)
    for start, end in edges:
        graph[start, end] = 1
    _, labels = connected_components(csr_array(graph), connection="strong")
    found = components(8, edges)
    for one in range(8):
        for other in range(8):
            assert (found[one] == found[other]) == (labels[one] == labels[other])
