"""Graph: matching and strong components, for graphs as small as those of a mechanism.

SciPy has both for graphs of any size, but takes a hundred times as long to be imported as a
mechanism's graph takes.
"""

from __future__ import annotations

import numpy as np


def matched(options: list[list[int]]) -> dict[int, int]:
    """Return a greatest matching of rows with columns, one column per row: column to row.

    Args:
        options: columns that each row may have.
    """
    found: dict[int, int] = {}
    for first in range(len(options)):
        # Breadth first to a row with a free column; the rows on the way then pass theirs on.
        asked: dict[int, tuple[int, int]] = {}
        way = [first]
        for row in way:
            free = next((column for column in options[row] if column not in found), None)
            if free is not None:
                while row != first:
                    asking, own = asked[row]
                    found[free] = row
                    free, row = own, asking
                found[free] = first
                break
            for column in options[row]:
                holder = found[column]
                if holder != first and holder not in asked:
                    asked[holder] = (row, column)
                    way.append(holder)
    return found


def components(size: int, edges: set[tuple[int, int]]) -> list[int]:
    """Return for each of `size` nodes the least node from and to which directed edges lead."""
    reach = np.eye(size, dtype=bool)
    for start, end in edges:
        reach[start, end] = True
    for middle in range(size):
        reach |= reach[:, [middle]] & reach[middle]
    return [int(label) for label in np.argmax(reach & reach.T, axis=1)]
