"""On arrays: a graph computed by NumPy, operation by operation, for a block of lanes at a time."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from ...kit.arrays import Array
from .graph import Graph
from .operations import CONSTANT, INPUT, ON_ARRAYS, UNIFORM

MOST_LANES = 4096
"""Lanes of the greatest block: fewer cost more for each, as NumPy takes its time for each call."""
_FEWER_LANES = (1, 32, 512)
"""Lanes of smaller ones, for fewer samples: each takes a third of the next one's time, or less."""


class ArrayBlock:
    """A graph bound to arrays of a number of lanes: all that is left to do is to call functions.

    Attributes:
        inputs: by name, the array `(lanes,)` that holds an input, `()` of a uniform one.
        outputs: results of the last pass `(outputs, lanes)`.
    """

    def __init__(self, graph: Graph, lanes: int) -> None:
        rows, places = _registers(graph)
        registers = np.empty((rows, lanes))
        held: list[Array] = [
            np.empty(()) if uniform else registers[places[node]]
            for node, uniform in enumerate(graph.uniform)
        ]
        self.inputs: dict[str, Array] = {}
        self.outputs: Array = registers[: len(graph.outputs)]
        self._once: list[Callable[[], Any]] = []
        self._each: list[Callable[[], Any]] = []
        for node, (operation, arguments) in enumerate(graph.nodes()):
            if operation == CONSTANT:
                held[node][...] = graph.constants[arguments[0]]
            elif operation in (INPUT, UNIFORM):
                self.inputs[graph.inputs[arguments[0]]] = held[node]
            else:
                steps = self._once if graph.uniform[node] else self._each
                taken = [held[k] for k in arguments]
                steps.append(partial(ON_ARRAYS[operation], *taken, out=held[node]))
        for row, node in enumerate(graph.outputs.tolist()):
            if graph.uniform[node] or places[node] != row:
                self._each.append(partial(np.copyto, registers[row], held[node]))

    def begin(self, values: Mapping[str, Array], part: slice) -> None:
        """Fill inputs, and compute what depends on uniform ones alone.

        Args:
            values: of inputs by name, each `()` or `(count,)`; those left out are filled later.
            part: which lanes of them are these.
        """
        for name, array in self.inputs.items():
            if name in values:
                value = values[name]
                array[...] = value[part] if value.ndim else value
        for step in self._once:
            step()

    def run(self) -> None:
        """Compute the outputs from the inputs."""
        for step in self._each:
            step()


def lanes_of_block(count: int, most: int) -> int:
    """Return how many lanes blocks have where so many are to run.

    There are few sizes, since to bind a graph takes longer than to run it. Where a block has more,
    the last lane is repeated.

    Args:
        count: number of lanes.
        most: greatest number of lanes of a block.
    """
    sizes = sorted((*_FEWER_LANES, most))
    return sizes[bisect_left(sizes, min(count, most))]


def parts(count: int, lanes: int) -> Iterator[slice]:
    """Yield the lanes of each block; the last overlaps the one before it, so that all are full."""
    for first in range(0, count, lanes):
        start = max(0, min(first, count - lanes))
        yield slice(start, start + lanes)


def _registers(graph: Graph) -> tuple[int, dict[int, int]]:
    """Return how many arrays of lanes are needed, and which one each node is in.

    Outputs come first, each in the row that it is returned in, and keep theirs, as inputs do.
    An operation may write over its own arguments, where nothing reads them later.
    """
    kept: dict[int, int] = {}
    nodes = [
        (operation, () if operation in (CONSTANT, INPUT, UNIFORM) else arguments)
        for operation, arguments in graph.nodes()
    ]
    for row, node in enumerate(graph.outputs.tolist()):
        if nodes[node][0] != INPUT:
            kept.setdefault(node, row)
    last = {k: node for node, (_, arguments) in enumerate(nodes) for k in arguments}
    rows = len(graph.outputs)
    places = dict(kept)
    free: list[int] = []
    for node, (operation, arguments) in enumerate(nodes):
        if graph.uniform[node]:
            continue
        free.extend(
            places[k]
            for k in set(arguments)
            if last[k] == node and k not in kept and not graph.uniform[k]
        )
        if node not in places:
            if operation == INPUT:
                kept[node] = rows
            if operation == INPUT or not free:
                places[node] = rows
                rows += 1
            else:
                places[node] = free.pop()
    return rows, places
