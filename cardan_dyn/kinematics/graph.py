"""Graph: matching and strong components, for graphs as small as those of a mechanism.

SciPy has both for graphs of any size, but importing it takes a hundred times as long as these
functions take for the graph of a mechanism.
"""

from __future__ import annotations

import numpy as np


def matched(options: list[list[int]]) -> dict[int, int]:
    """Return a maximum matching of rows with columns, at most one column per row.

    Args:
        options: for each row, the columns that it may have.

    Returns:
        Matched column to its row.
    """
    row_of: dict[int, int] = {}
    for start in range(len(options)):
        # Breadth-first search for an augmenting path: from `start` to a row with a free column.
        # `came_from` holds, for each row reached, the row before it and the column between them.
        came_from: dict[int, tuple[int, int]] = {}
        queue = [start]
        for row in queue:
            free = next((column for column in options[row] if column not in row_of), None)
            if free is not None:
                # Every row on the path takes the next column and hands over its previous one.
                while row != start:
                    previous, column_between = came_from[row]
                    row_of[free] = row
                    free, row = column_between, previous
                row_of[free] = start
                break
            for column in options[row]:
                holder = row_of[column]
                if holder != start and holder not in came_from:
                    came_from[holder] = (row, column)
                    queue.append(holder)
    return row_of


def components(size: int, edges: set[tuple[int, int]]) -> list[int]:
    """Return the strong components of a directed graph with nodes 0 … `size` - 1.

    Returns:
        For each node the smallest node of its component: of all nodes that it can reach and that
        can reach it.
    """
    reach = np.eye(size, dtype=bool)
    for start, end in edges:
        reach[start, end] = True
    for middle in range(size):
        reach |= reach[:, [middle]] & reach[middle]
    return [int(label) for label in np.argmax(reach & reach.T, axis=1)]
