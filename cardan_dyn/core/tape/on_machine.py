"""On the machine: the code of a graph, and which blocks of lanes it runs on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from .. import compiled
from .graph import Graph

LANES, _FEW_LANES = 32, 4
"""Lanes of a block of many samples and of one of few, as the machine is compiled for them."""


def machine_is_at_hand() -> bool:
    """Return whether there is a compiled machine."""
    return hasattr(compiled.kernel, "run_program")


class Code(NamedTuple):
    """Instructions on registers, each a row of eight integers; an END closes both lists.

    Attributes:
        prologue: what runs once `(n, 8)`: uniform values, whose registers nothing else writes.
        body: what runs for each block of lanes `(m, 8)`.
        registers: how many there are.
    """

    prologue: Array
    body: Array
    registers: int


def code_of(graph: Graph) -> Code:
    """Return the code of a graph, which rounds as the graph does.

    Raises:
        ValueError: the graph is too large.
    """
    fields = graph.operations, graph.arguments, graph.constants, graph.outputs
    prologue, body, registers = compiled.kernel.instructions(*fields)
    return Code(_rows(prologue), _rows(body), registers)


def _rows(text: bytes) -> Array:
    return np.frombuffer(text, np.int32).reshape(-1, 8)


def block_for(count: int) -> int:
    """Return how many lanes a block has where so many are to run."""
    return LANES if count >= LANES else _FEW_LANES


def filled(value: Array, lanes: int) -> Array:
    """Return values side by side, the last repeated to so many lanes; one for all as it is."""
    if value.ndim and 1 < value.shape[-1] < lanes:
        value = value.take(np.minimum(np.arange(lanes), value.shape[-1] - 1), -1)
    return np.ascontiguousarray(value) if value.ndim else value
