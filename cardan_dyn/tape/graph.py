"""Graph: the part of a trace that outputs depend on, as plain data."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from .operations import INPUT
from .trace import Scalar, Trace


@dataclass(frozen=True)
class Graph:
    """Nodes in an order in which each comes after its arguments.

    Attributes:
        operations: of each node, a name of `ON_ARRAYS`, `CONSTANT` or `INPUT`.
        arguments: of each node, indices of nodes before it; of an input, its place in `inputs`.
        uniform: whether each node has one value for all lanes of a run.
        constants: nodes to the values of those that are constants.
        inputs: names of inputs, in the order of their creation.
        uniform_inputs: names of those of them that are numbers.
        outputs: the node of each output; one may be several outputs.
    """

    operations: tuple[str, ...]
    arguments: tuple[tuple[int, ...], ...]
    uniform: tuple[bool, ...]
    constants: dict[int, float]
    inputs: tuple[str, ...]
    uniform_inputs: frozenset[str]
    outputs: tuple[int, ...]


def live_part(trace: Trace, outputs: Iterable[Scalar], keeps_inputs: bool = False) -> Graph:
    """Return the nodes of a trace that outputs depend on, numbered anew in the same order.

    Args:
        trace: the trace.
        outputs: variables of it, and numbers.
        keeps_inputs: whether the names of all inputs stay, not only of those among these nodes.

    Raises:
        ArgumentError: an output is of another trace.
    """
    ends = [trace.node(x) for x in outputs]
    live = reached(trace, ends)
    number = {node: k for k, node in enumerate(live)}
    names = [name for name, node in trace.inputs.items() if keeps_inputs or node in number]
    arguments = [tuple([number[k] for k in trace.arguments[node]]) for node in live]
    for place, name in enumerate(names):
        if trace.inputs[name] in number:
            arguments[number[trace.inputs[name]]] = (place,)
    return Graph(
        operations=tuple([trace.operations[node] for node in live]),
        arguments=tuple(arguments),
        uniform=tuple([trace.uniform[node] for node in live]),
        constants={number[k]: x for k, x in trace.constants.items() if k in number},
        inputs=tuple(names),
        uniform_inputs=frozenset(name for name in names if trace.uniform[trace.inputs[name]]),
        outputs=tuple([number[node] for node in ends]),
    )


def reached(trace: Trace, ends: Iterable[int]) -> list[int]:
    """Return the nodes that some depend on, with these, each after its arguments."""
    found: set[int] = set()
    waiting = list(ends)
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting.extend(trace.arguments[node])
    return sorted(found)


def leaves(graph: Graph, node: int) -> tuple[int, ...]:
    """Return the nodes that a node is computed from; none for constants and inputs."""
    return () if graph.operations[node] == INPUT else graph.arguments[node]
