"""Graph: the part of a trace that outputs depend on, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from ...kit.arrays import Array
from .operations import CONSTANT, INPUT, NAMES, UNIFORM
from .trace import Scalar, Trace, Variable

_NUMBERS = {name: number for number, name in enumerate(NAMES)}


@dataclass(frozen=True, eq=False)
class Graph:
    """Nodes in an order in which each comes after its arguments.

    Attributes:
        operations: of each node, its number in `NAMES` `(n,)`.
        arguments: of each node, nodes before it `(n, 3)`, -1 where it has fewer; of a constant its
            place in `constants`, of an input that in `inputs`.
        constants: values.
        inputs: names of inputs, in the order of their creation.
        uniform_inputs: names of those of them that are numbers.
        outputs: the node of each output; one may be several outputs.
    """

    operations: Array
    arguments: Array
    constants: Array
    inputs: tuple[str, ...]
    uniform_inputs: frozenset[str]
    outputs: Array

    def nodes(self) -> Iterator[tuple[str, list[int]]]:
        """Yield the name of each node's operation, and its arguments."""
        pairs = zip(self.operations.tolist(), self.arguments.tolist(), strict=True)
        return ((NAMES[number], [k for k in row if k >= 0]) for number, row in pairs)

    def in_turn(self, turns: Array) -> Graph:
        """Return the graph with its last nodes in the order of their turns.

        Args:
            turns: of these nodes, none later than of those that are made of them. The nodes before
                come right before the first one that is made of them.
        """
        first = np.isin(self.operations, [_NUMBERS[name] for name in (CONSTANT, INPUT, UNIFORM)])
        arguments = np.where(first[:, None], -1, self.arguments)
        before = len(first) - len(turns)
        last = np.max(turns, initial=0)
        earliest = np.concatenate([np.full(before, last), turns])
        for own in arguments[before:].T:
            np.minimum.at(earliest, own[own >= 0], turns[own >= 0])
        known = earliest[:before].tolist()
        for node, of_node in reversed([*enumerate(arguments[:before].tolist())]):
            for k in of_node:
                if k >= 0:
                    known[k] = min(known[k], known[node])
        earliest[:before] = known
        order = np.argsort(earliest, kind="stable")
        places = np.empty(len(order) + 1, dtype=np.int32)
        places[order], places[-1] = np.arange(len(order)), -1
        moved = np.where(first[:, None], self.arguments, places[arguments])
        return replace(
            self,
            operations=self.operations[order],
            arguments=moved[order],
            outputs=places[self.outputs],
        )

    @cached_property
    def uniform(self) -> list[bool]:
        """Whether each node has one value for all lanes of a run."""
        uniform: list[bool] = []
        for operation, arguments in self.nodes():
            is_leaf = operation in (CONSTANT, INPUT, UNIFORM)
            uniform.append(operation != INPUT if is_leaf else all(uniform[k] for k in arguments))
        return uniform


def live_part(trace: Trace, outputs: Iterable[Scalar], keeps_inputs: bool = False) -> Graph:
    """Return the nodes of a trace that outputs depend on, numbered anew in the same order.

    Args:
        trace: the trace.
        outputs: variables of it, and numbers.
        keeps_inputs: whether the names of all inputs stay, not only of those among these nodes.

    Raises:
        ArgumentError: an output is of another trace.
    """
    ends = [trace.index(x) for x in outputs]
    live = reached(trace, ends)
    number = np.full(len(trace.nodes), -1, dtype=np.int32)
    number[[node.index for node in live]] = np.arange(len(live))
    operations = np.array([_NUMBERS[node.operation] for node in live], dtype=np.int32)
    leading = [node.arguments for node in live]
    counts = np.fromiter(map(len, leading), np.int32)
    arguments = np.full((len(live), 3), -1, dtype=np.int32)
    filled = counts[:, None] > np.arange(3)
    arguments[filled] = number[np.fromiter(chain.from_iterable(leading), np.int32)]
    constants = operations == _NUMBERS[CONSTANT]
    values = [trace.constants[live[k].index] for k in np.flatnonzero(constants).tolist()]
    arguments[constants, 0] = np.arange(len(values))
    inputs = {name: x for name, x in trace.inputs.items() if keeps_inputs or number[x.index] >= 0}
    of_inputs = number[[x.index for x in inputs.values()]]
    (places,) = np.nonzero(of_inputs >= 0)
    arguments[of_inputs[places], 0] = places
    return Graph(
        operations=operations,
        arguments=arguments,
        constants=np.array(values),
        inputs=tuple(inputs),
        uniform_inputs=frozenset(name for name, x in inputs.items() if x.operation == UNIFORM),
        outputs=number[ends],
    )


def reached(trace: Trace, ends: Iterable[int]) -> list[Variable]:
    """Return the nodes that some depend on, with these, each after its arguments."""
    own = [*ends]
    # What was written down later is no argument of them.
    last = max(own, default=-1) + 1
    found = bytearray(last)
    for end in own:
        found[end] = True
    result: list[Variable] = []
    for node in reversed(trace.nodes[:last]):
        if found[node.index]:
            result.append(node)
            for argument in node.arguments:
                found[argument] = True
    result.reverse()
    return result
