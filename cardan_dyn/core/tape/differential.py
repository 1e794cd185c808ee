"""Differential: how variables of a trace change with each other, written as one linear map.

A change is a sum of others, each times a factor that the trace knows. The sums are written down
once, whatever changes. Read forwards, they tell how results change in some directions; read
backwards, how sums of results do with everything. Programs of that are made of arrays, not traced:
only what changes in a direction is part of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from .derivative import Factor, checked, factors_of
from .graph import live_part, reached
from .operations import NAMES
from .program import Program
from .trace import Scalar, Trace, Variable, is_zero

NOTHING = -1
"""The number of a change that is zero whatever changes."""
_ADD, _SUBTRACT, _MULTIPLY, _NEGATIVE, _SELECT = (
    NAMES.index(name) for name in ("add", "subtract", "multiply", "negative", "select")
)


class _Terms(NamedTuple):
    """Terms of sums, those of each one behind each other; arrays `(n,)`.

    Attributes:
        sums: numbers of the changes that are sums, ascending.
        of: changes that are terms of them, each lower than the sum.
        factors: nodes of their factors; -1 for one.
        signs: 1 or -1.
        chosen: 1 where the factor is 1 in lanes in which the node is above 0, else 0; -1 where it
            is 0 there, else 1; 0 where it is what the node is.
    """

    sums: Array
    of: Array
    factors: Array
    signs: Array
    chosen: Array

    def only(self, which: Array) -> _Terms:
        """Return some of them."""
        return _Terms(*(part[which] for part in self))

    def backwards(self, last: int) -> _Terms:
        """Return those of the transposed map, in which the changes are numbered from the last."""
        order = np.argsort(last - self.of, kind="stable")
        turned = self._replace(sums=last - self.of, of=last - self.sums)
        return turned.only(order)


class Differential:
    """Changes of variables of a trace, numbered in the order in which they are written down."""

    def __init__(self, trace: Trace) -> None:
        """Begin without any."""
        self._trace, self._count = trace, 0
        self._sums: dict[int, list[tuple[Factor, int]]] = {}

    def free(self) -> int:
        """Return a change that depends on nothing."""
        self._count += 1
        return self._count - 1

    def sum(self, terms: Iterable[tuple[Factor, int]]) -> int:
        """Return a sum of changes, each times a factor; `NOTHING` of nothing."""
        own = [(of, way) for of, way in terms if way != NOTHING and not is_zero(of.number)]
        if not own:
            return NOTHING
        self._sums[self._count] = own
        return self.free()

    def tangents(
        self, outputs: Sequence[Scalar], changes: dict[Variable, int], adds: bool = False
    ) -> list[int]:
        """Return how outputs change while variables do.

        Args:
            outputs: see `tangents`.
            changes: of variables, whatever they depend on; `NOTHING` of what is held.
            adds: whether changes of all that outputs depend on are added to these.

        Raises:
            ArgumentError: see `tangents`.
        """
        trace, ends, starts = checked(outputs, list(changes))
        found = dict(zip(starts, changes.values(), strict=True))
        for node in reached(trace, ends):
            if node.index in found or found.keys().isdisjoint(node.arguments):
                continue
            pairs = zip(factors_of(node), node.arguments, strict=True)
            change = self.sum([(factor, found[k]) for factor, k in pairs if k in found])
            if change != NOTHING:
                found[node.index] = change
        if adds:
            changes |= {trace.nodes[k]: change for k, change in found.items()}
        return [found.get(end, NOTHING) for end in ends]

    def forwards(
        self,
        directions: Sequence[Mapping[int, Scalar]],
        wanted: Sequence[int],
        others: Sequence[Scalar] = (),
    ) -> tuple[Program, Array]:
        """Return a program of how some changes are made, and which of its rows they are.

        Args:
            directions: in each, changes that depend on nothing to what they are.
            wanted: changes that are asked for.
            others: scalars of the trace, which are the first rows of the program.

        Returns:
            The program, which keeps all inputs of the trace; and `(directions, wanted)` rows,
            `NOTHING` where a change is zero.
        """
        ways = {change for of in directions for change in of}
        terms = self._shortened(ways, wanted, len(directions))
        return self._program(terms, directions, wanted, others)

    def backwards(
        self,
        directions: Sequence[Mapping[int, Scalar]],
        wanted: Sequence[int],
        others: Sequence[Scalar] = (),
    ) -> tuple[Program, Array]:
        """Return a program of how weighted sums change with some changes; see `forwards`.

        Args:
            directions: in each, changes that no other depends on to their weights in a sum.
            wanted: changes, with which sums change.
            others: see `forwards`.
        """
        last = self._count - 1
        ends = {change for of in directions for change in of}
        terms = self._shortened(wanted, ends, len(directions))
        turned = [{last - change: x for change, x in of.items()} for of in directions]
        own = [last - change if change != NOTHING else NOTHING for change in wanted]
        return self._program(terms.backwards(last), turned, own, others)

    def _shortened(self, starts: Collection[int], ends: Collection[int], directions: int) -> _Terms:
        """Return terms by which ends change with starts.

        Changes between them are left out where paths around these are fewer, so that products of
        factors are made once instead of in each direction (vertex elimination: Griewank and
        Walther 2008, chapter 10).

        Args:
            starts: changes that begin.
            ends: changes that are asked for.
            directions: number of directions in which terms are computed.
        """
        kept, moving = {*starts, *ends}, {*starts}
        chosen: list[tuple[int, int, Factor]] = []
        sums: dict[int, dict[int, Scalar]] = {}
        users: dict[int, set[int]] = defaultdict(set)
        for total, terms in self._sums.items():
            for factor, of in terms:
                if of in moving:
                    moving.add(total)
                    if factor.is_one is None:
                        own = sums.setdefault(total, {})
                        own[of] = own.get(of, 0.0) + factor.number
                        users[of].add(total)
                    else:
                        chosen.append((total, of, factor))
                        kept |= {total, of}
        # What costs as much either way is left out as well: terms may meet further on.
        for change in [*sums, *reversed([*sums])]:
            if change in kept or change not in sums:
                continue
            own, above = sums[change], users[change]
            if above and not self._pays(own, [(sums[k], change) for k in above], directions):
                continue
            del sums[change]
            for of in own:
                users[of].discard(change)
                users[of] |= above
            for total in above:
                terms_of = sums[total]
                factor = terms_of.pop(change)
                for of, number in own.items():
                    term = factor * number
                    terms_of[of] = terms_of[of] + term if of in terms_of else term
        every = [
            (total, of, Factor(x))
            for total, own in sums.items()
            for of, x in own.items()
            if not is_zero(x)
        ]
        rows = [self._term(*item) for item in sorted(chain(every, chosen), key=itemgetter(0))]
        return _Terms(*np.array(rows, dtype=np.int64).reshape(-1, 5).T)

    @staticmethod
    def _pays(
        own: Mapping[int, Scalar],
        above: Sequence[tuple[Mapping[int, Scalar], int]],
        directions: int,
    ) -> bool:
        """Return whether no more operations are written if a change is left out.

        Args:
            own: terms of the change.
            above: terms of sums in which it is one, and its number.
            directions: see `_shortened`.
        """
        costs = {of: _cost(x) for of, x in own.items()}
        saved, once = sum(costs.values()) - 1, 0
        for terms, change in above:
            factor = _cost(terms[change])
            saved += factor
            for of, cost in costs.items():
                product = factor + cost
                once += (product == 4) + (of in terms)
                saved -= 0 if of in terms else 1 + (product > 2)
        return directions * saved >= once

    def _term(self, total: int, of: int, factor: Factor) -> tuple[int, int, int, int, int]:
        """Return a term, see `_Terms`."""
        number, is_one = factor
        sign, node, is_number = 1, NOTHING, type(number) is not Variable
        if is_number and number < 0.0:
            sign, number = -1, -number
        elif not is_number and is_one is None and number.operation == "negative":
            sign, number = -1, self._trace.nodes[number.arguments[0]]
        if not (is_number and number == 1.0):
            node = self._trace.index(number)
        return total, of, node, sign, 0 if is_one is None else 1 if is_one else -1

    def _program(
        self,
        terms: _Terms,
        directions: Sequence[Mapping[int, Scalar]],
        wanted: Sequence[int],
        others: Sequence[Scalar],
    ) -> tuple[Program, Array]:
        """Return a program of changes and its rows, see `forwards`."""
        moves = [0] * self._count  # In which directions, by the bits of an integer.
        for k, of in enumerate(directions):
            for change in of:
                moves[change] |= 1 << k
        is_needed = np.zeros(self._count + 1, dtype=bool)
        is_needed[[*wanted]] = True  # `NOTHING` is the last one.
        pairs = list(zip(terms.sums.tolist(), terms.of.tolist(), strict=True))
        for total, of in pairs:
            moves[total] |= moves[of]
        for total, of in reversed(pairs):
            if is_needed[total]:
                is_needed[of] = True
        terms = terms.only(
            is_needed[terms.sums] & np.array([moves[of] > 0 for _, of in pairs], bool)
        )
        width = len(directions) // 8 + 1
        each = b"".join(of.to_bytes(width, "little") for of in moves)
        bits = np.frombuffer(each, np.uint8).reshape(self._count, width)
        trace, factors = self._trace, np.unique(terms.factors)
        starts = [x for of in directions for x in of.values()]
        own = [trace.nodes[k] for k in factors.tolist() if k != NOTHING]
        every = [0.0, 1.0, *others, *starts, *own]
        graph = live_part(trace, every, keeps_inputs=True)
        zero, one, *known = graph.outputs.tolist()
        nodes = np.full(len(trace.nodes), one)
        nodes[[x.index for x in own]] = known[len(others) + len(starts) :]
        nodes = nodes[terms.factors]
        places = np.empty((len(directions), len(wanted)), dtype=int)
        parts, seeds, turns = [], len(others), [np.zeros(0, dtype=int)]
        end = len(graph.operations)
        for k, of in enumerate(directions):
            acts = (bits[terms.of, k // 8] >> (k % 8) & 1) > 0
            begun = dict(zip(of, known[seeds : seeds + len(of)], strict=True))
            seeds += len(of)
            ends = np.full(self._count + 1, NOTHING)
            part, of_terms = _written(terms.only(acts), nodes[acts], begun, (zero, one, end), ends)
            places[k] = ends[[*wanted]]
            turns.append(np.flatnonzero(acts)[of_terms])
            end += len(part)
            parts.append(part)
        written = np.concatenate([np.zeros((0, 4), dtype=np.int32), *parts])
        found = np.unique(places[places != NOTHING])
        whole = replace(
            graph,
            operations=np.concatenate([graph.operations, written[:, 0]]),
            arguments=np.concatenate([graph.arguments, written[:, 1:]]),
            outputs=np.concatenate([known[: len(others)], found]).astype(np.int32),
        )
        rows = np.searchsorted(found, places) + len(others)
        # What is written of a term in all directions comes together, and its factor right before:
        # so less has to be kept meanwhile.
        program = Program.of(whole.in_turn(np.concatenate(turns)))
        return program, np.where(places == NOTHING, NOTHING, rows)


def _cost(factor: Scalar) -> int:
    """Return the operations of a term: a sum, and a product unless the factor is one."""
    return 1 if type(factor) is float and factor in (1.0, -1.0) else 2


def _written(
    terms: _Terms,
    factors: Array,
    begun: Mapping[int, int],
    known: tuple[int, int, int],
    ends: Array,
) -> tuple[Array, Array]:
    """Write sums down.

    A term takes a node for its product, and one for the sum up to it. What needs neither takes none
    and has that of something else. With changes 0 and 1, which begin as x and one:

        2 = a (0) - (0)     n: a x; n + 1: n - x
        3 = (2)             none; it is n + 1
        4 = -(3)            n + 2: -(n + 1)
        5 = b (1)           none; it is b

    Args:
        terms: that are not zero.
        factors: nodes of theirs.
        begun: changes that depend on nothing to their nodes.
        known: nodes of 0 and 1, and where more of them begin.
        ends: the node of each change, written.

    Returns:
        `(n, 4)` operations of nodes and their arguments, and the terms that they are of.
    """
    zero, one, first_node = known
    starts = np.full(len(ends), NOTHING)
    starts[[*begun]] = [*begun.values()]
    is_factor = (starts[terms.of] == one) & (terms.factors != NOTHING) & (terms.chosen == 0)
    is_product = (terms.factors != NOTHING) & ~is_factor
    is_first = np.diff(terms.sums, prepend=NOTHING) != 0
    is_summed = ~is_first | (terms.signs < 0)
    last = first_node + np.cumsum(is_product.astype(int) + is_summed) - 1
    # What stands for each sum up to a term: a node, or what stands for a sum before it.
    places = np.zeros(len(ends), dtype=int)
    places[terms.sums] = np.arange(len(terms.sums))
    every = np.where(is_factor, factors, starts[terms.of])
    every = np.where(is_product | is_summed, last, every)
    leads = np.where(every != NOTHING, np.arange(len(every)), places[terms.of])
    while np.any(leads != (further := leads[leads])):
        leads = further
    every = every[leads]
    np.copyto(ends, starts)
    ends[terms.sums] = every[places[terms.sums]]
    of = np.where(is_factor, factors, ends[terms.of])
    products, sums = last - is_summed, last
    written = np.full((int(last[-1]) + 1 - first_node if len(last) else 0, 4), -1, dtype=np.int32)
    zeros, none = np.full(len(of), zero), np.full(len(of), -1)
    chosen = terms.chosen[:, None]
    choices = np.column_stack([np.full(len(of), _SELECT), factors, of, zeros])
    choices = np.where(chosen < 0, choices[:, [0, 1, 3, 2]], choices)
    times = np.column_stack([np.full(len(of), _MULTIPLY), factors, of, none])
    written[products[is_product] - first_node] = np.where(chosen == 0, times, choices)[is_product]
    of = np.where(is_product, products, of)
    signed = np.where(terms.signs > 0, _ADD, _SUBTRACT)
    added = np.column_stack([signed, np.roll(every, 1), of, none])
    negated = np.column_stack([np.full(len(of), _NEGATIVE), of, none, none])
    own = np.where(is_first[:, None], negated, added)
    written[sums[is_summed] - first_node] = own[is_summed]
    return written, np.repeat(np.arange(len(terms.sums)), is_product.astype(int) + is_summed)
