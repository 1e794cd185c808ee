"""Instructions: a graph as a list of what the compiled machine does, with few long operations.

Passes, one after the other: nodes become instructions, sums of products and other patterns one
instruction each, two sums that turn a vector one (`with_rotations`), outputs are stored, values
get registers (`on_registers`), and rows of integers are written (`encoded`). All round as the graph
does: no sum is reassociated, and the machine rounds products and sums by themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from ..arrays import Array
from .graph import Graph, leaves
from .operations import CONSTANT, INPUT

Operation = IntEnum(
    "Operation",
    "END LOAD LDU STORE KST ADD SUB MUL DIV RCP NEG SQRT SC ABS MAX MIN SEL FMA FMS FNMA P2 M2 P3"
    " A2 S2 AS ROT AMX AMD ADD3 NP2 PPM MOV EXP LOG TANH ATAN2 PMP PMM PMA SA",
    start=0,
)
"""Names and numbers of the machine's operations; `compiled/machine.h` says what each computes."""
_ROW: Final = 8
"""Integers of an instruction: the operation, what it writes and reads."""
_WITH_PLACE: Final = ("LOAD", "LDU", "STORE", "KST")
"""Operations whose second operand is an input, an output or a constant, not a register."""

_PLAIN: Final = {
    "multiply": "MUL",
    "divide": "DIV",
    "negative": "NEG",
    "sqrt": "SQRT",
    "absolute": "ABS",
    "greater": "MAX",
    "smaller": "MIN",
    "select": "SEL",
    "exp": "EXP",
    "log": "LOG",
    "tanh": "TANH",
    "arctan2": "ATAN2",
}
_SUMS: Final = {
    "+a+a": "ADD",
    "+a-a": "SUB",
    "+a+a+a": "ADD3",
    "+ab+a": "FMA",
    "+ab-a": "FMS",
    "-ab+a": "FNMA",
    "+ab+ab": "P2",
    "+ab-ab": "M2",
    "+ab-ab+a": "PMA",
    "+a+ab+ab": "A2",
    "+a+ab-ab": "AS",
    "+a-ab+ab": "SA",
    "+a-ab-ab": "S2",
    "+ab+ab+ab": "P3",
    "+ab+ab-ab": "PPM",
    "+ab-ab+ab": "PMP",
    "+ab-ab-ab": "PMM",
}
"""Sums that are one instruction, computed from left to right: signs, and which terms are products.

The first two terms may be exchanged, which rounds alike.
"""
_LONGEST_SUM: Final = 3
"""Terms of the longest of them."""

UNWANTED: Final = -1
"""Written by an instruction where nothing reads it."""


class Instruction(NamedTuple):
    """An operation of the machine on values, which are nodes of a graph or between them.

    Attributes:
        operation: its name.
        written: values that it computes; `UNWANTED` where one is not needed.
        read: values that it computes them from.
        place: which input, output or constant it moves, None for others.
    """

    operation: str
    written: tuple[int, ...]
    read: tuple[int, ...]
    place: int | None = None


@dataclass(frozen=True)
class Code:
    """Instructions on registers, each a row of eight integers; an END closes both lists.

    Attributes:
        prologue: what runs once `(n, 8)`: uniform values, whose registers nothing else writes.
        body: what runs for each block of lanes `(m, 8)`.
        constants: that the prologue brings into registers.
        registers: how many there are.
    """

    prologue: Array
    body: Array
    constants: Array
    registers: int

    def for_lanes(self, lanes: int) -> tuple[Array, Array, Array]:
        """Return prologue, constants and body, with registers as offsets in bytes.

        Args:
            lanes: that a register holds a number for.
        """
        return _offsets(self.prologue, lanes), self.constants, _offsets(self.body, lanes)


_Term: TypeAlias = tuple[str, tuple[int, ...]]
"""A term of a sum: "+a", "-a", "+ab" or "-ab", and the value, or both factors of the product."""


def code_of(graph: Graph) -> Code:
    """Return the code of a graph."""
    prologue, body, constants = _Lowering(graph).result()
    stored = _with_stores(with_rotations(body), graph)
    uniform = [value for made in prologue for value in made.written if value != UNWANTED]
    pinned = {value: register for register, value in enumerate(uniform)}
    first, _ = on_registers(prologue, pinned)
    moved, count = on_registers(stored, pinned)
    return Code(encoded(first), encoded(moved), np.array(constants), count)


class _Lowering:
    """Nodes become instructions: those that only one other reads may become a part of it."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.parts = _parts(graph)
        self.angles = {
            (operation, graph.arguments[node]): node
            for node, operation in enumerate(graph.operations)
            if operation in ("sin", "cos")
        }
        self.absorbed: set[int] = set()
        self.next_value = len(graph.operations)

    def result(self) -> tuple[list[Instruction], list[Instruction], list[float]]:
        """Return the prologue, for uniform values, the body, for the others, and constants."""
        graph = self.graph
        prologue: list[list[Instruction]] = []
        body: list[list[Instruction]] = []
        constants: list[float] = []
        # From the outputs on: a node is asked for its parts before these are written down.
        for node in reversed(range(len(graph.operations))):
            if node in self.absorbed:
                continue
            operation = graph.operations[node]
            if operation == CONSTANT:
                made = [Instruction("KST", (node,), (), len(constants))]
                constants.append(graph.constants[node])
            elif operation == INPUT:
                load = "LDU" if graph.uniform[node] else "LOAD"
                made = [Instruction(load, (node,), (), graph.arguments[node][0])]
            else:
                made = self._instructions(node)
            (prologue if graph.uniform[node] else body).append(made)
        return _forwards(prologue), _forwards(body), constants

    def _instructions(self, node: int) -> list[Instruction]:
        operation, arguments = self.graph.operations[node], self.graph.arguments[node]
        if operation in ("add", "subtract"):
            return self._sum(node)
        if operation in ("sin", "cos"):
            return self._sine_cosine(node)
        if operation == "greater":
            return [self._greater(node)]
        if operation == "divide" and self.graph.constants.get(arguments[0]) == 1.0:
            return [Instruction("RCP", (node,), arguments[1:])]
        return [Instruction(_PLAIN[operation], (node,), arguments)]

    def _sum(self, node: int) -> list[Instruction]:
        terms = self._terms(node)
        made = []
        while len(terms) > 1:
            operation, taken = _first_sum(terms)
            rest = terms[len(taken) :]
            value = node
            if rest:
                value, self.next_value = self.next_value, self.next_value + 1
            read = tuple([value for _, values in taken for value in values])
            made.append(Instruction(operation, (value,), read))
            terms = [("+a", (value,)), *rest]
        return made

    def _terms(self, node: int) -> list[_Term]:
        """Return the terms of a sum in the order in which they are added."""
        sums = ("add", "subtract")
        terms = []
        while True:
            left, right = self.graph.arguments[node]
            sign = "+" if self.graph.operations[node] == "add" else "-"
            if sign == "+" and self.parts[right] in sums:
                left, right = right, left
            terms.append(self._term(sign, right))
            if self.parts[left] not in sums:
                terms.append(self._term("+", left))
                return terms[::-1]
            self.absorbed.add(left)
            node = left

    def _term(self, sign: str, node: int) -> _Term:
        if self.parts[node] == "multiply":
            self.absorbed.add(node)
            return sign + "ab", self.graph.arguments[node]
        return sign + "a", (node,)

    def _sine_cosine(self, node: int) -> list[Instruction]:
        """Return an instruction for the sine and the cosine of an angle, by the first of them."""
        arguments = self.graph.arguments[node]
        sine = self.angles.get(("sin", arguments), UNWANTED)
        cosine = self.angles.get(("cos", arguments), UNWANTED)
        if UNWANTED not in (sine, cosine) and node == max(sine, cosine):
            return []
        return [Instruction("SC", (sine, cosine), arguments)]

    def _greater(self, node: int) -> Instruction:
        """Return the greater of two, one of which may be an absolute value, of a difference too."""
        a, b = self.graph.arguments[node]
        if self.parts[a] == "absolute":
            a, b = b, a
        if self.parts[b] != "absolute":
            return Instruction("MAX", (node,), (a, b))
        self.absorbed.add(b)
        (inner,) = self.graph.arguments[b]
        if self.parts[inner] != "subtract":
            return Instruction("AMX", (node,), (a, inner))
        self.absorbed.add(inner)
        return Instruction("AMD", (node,), (a, *self.graph.arguments[inner]))


def _parts(graph: Graph) -> list[str]:
    """Return the operation of each node that can be a part of another; of others, nothing.

    These differ from lane to lane, and are read by one other node, once, and by nothing else.
    """
    uses = [0] * len(graph.operations)
    for node in range(len(graph.operations)):
        for argument in leaves(graph, node):
            uses[argument] += 1
    for node in graph.outputs:
        uses[node] += 1
    return [
        operation if count == 1 and not uniform else ""
        for operation, count, uniform in zip(graph.operations, uses, graph.uniform, strict=True)
    ]


def _forwards(groups: list[list[Instruction]]) -> list[Instruction]:
    """Return groups of instructions that were collected from the end, from the beginning."""
    return [instruction for group in reversed(groups) for instruction in group]


def _first_sum(terms: list[_Term]) -> tuple[str, list[_Term]]:
    """Return the longest sum that is one instruction among the first terms, and these."""
    return next(
        (_SUMS[pattern], taken)
        for count in range(min(_LONGEST_SUM, len(terms)), 1, -1)
        for taken in (terms[:count], [terms[1], terms[0], *terms[2:count]])
        if (pattern := "".join([term[0] for term in taken])) in _SUMS
    )


def with_rotations(body: list[Instruction]) -> list[Instruction]:
    """Return instructions in which `x c - y s` and `x s + y c` are computed by one.

    It stands where the first of them stood: all four factors are known there.
    """
    sums: dict[frozenset[int], list[int]] = {}
    for place, instruction in enumerate(body):
        if instruction.operation == "P2":
            sums.setdefault(frozenset(instruction.read), []).append(place)
    made: dict[int, Instruction] = {}
    dropped: set[int] = set()
    for place, instruction in enumerate(body):
        if instruction.operation != "M2":
            continue
        x, c, y, s = instruction.read
        for other in sums.get(frozenset(instruction.read), ()):
            if other in dropped or other in made:
                continue
            a, b, d, e = body[other].read
            products = {frozenset((a, b)), frozenset((d, e))}
            if products == {frozenset((x, s)), frozenset((y, c))}:
                read = (x, y, c, s)
            elif products == {frozenset((x, y)), frozenset((c, s))}:
                # x c - s y and x y + s c: what turns is (x, s), by an angle of c and y.
                read = (x, s, c, y)
            else:
                continue
            written = (*instruction.written, *body[other].written)
            made[min(place, other)] = Instruction("ROT", written, read)
            dropped.add(max(place, other))
            break
    return [
        made.get(place, instruction)
        for place, instruction in enumerate(body)
        if place not in dropped
    ]


def _with_stores(body: list[Instruction], graph: Graph) -> list[Instruction]:
    """Return instructions in which each output is stored as soon as it is known."""
    rows: dict[int, list[int]] = {}
    for row, node in enumerate(graph.outputs):
        rows.setdefault(node, []).append(row)
    stores = {
        node: [Instruction("STORE", (), (node,), row) for row in among]
        for node, among in rows.items()
    }
    made = [store for node, among in stores.items() if graph.uniform[node] for store in among]
    for instruction in body:
        made.append(instruction)
        for value in instruction.written:
            made.extend(stores.get(value, ()))
    return made


def on_registers(
    instructions: list[Instruction], pinned: dict[int, int]
) -> tuple[list[Instruction], int]:
    """Return instructions on registers, and how many registers there are.

    A register is free again where nothing reads its value later. An instruction that writes one
    value may write it over one that it is the last to read.

    Args:
        instructions: on values.
        pinned: values to registers that stay.
    """
    registers = {UNWANTED: UNWANTED, **pinned}
    count = len(pinned)
    last = {value: k for k, made in enumerate(instructions) for value in made.read}
    free: list[int] = []
    moved: list[Instruction] = []
    for k, (operation, written, read, place) in enumerate(instructions):
        sources = tuple([registers[value] for value in read])
        ended = [
            registers[value] for value in set(read) if last[value] == k and value not in pinned
        ]
        if len(written) == 1:
            free.extend(ended)
        for value in written:
            if value not in registers:
                if not free:
                    free.append(count)
                    count += 1
                registers[value] = free.pop()
        if len(written) != 1:
            free.extend(ended)
        moved.append(
            Instruction(operation, tuple([registers[value] for value in written]), sources, place)
        )
    return moved, count


def encoded(instructions: list[Instruction]) -> Array:
    """Return instructions on registers as rows of integers `(n + 1, 8)`, with an END."""
    rows = np.zeros((len(instructions) + 1, _ROW), dtype=np.int32)
    for row, (operation, written, read, place) in zip(rows, instructions, strict=False):
        operands = (*written, *read) if place is None else (*written, *read, place)
        row[: 1 + len(operands)] = (Operation[operation], *operands)
    return rows


def _offsets(rows: Array, lanes: int) -> Array:
    """Return rows in which registers are offsets in bytes, for so many lanes each."""
    made = rows * np.int32(lanes * np.dtype(float).itemsize)
    made[:, 0] = rows[:, 0]
    made[rows == UNWANTED] = UNWANTED
    has_place = np.isin(rows[:, 0], [Operation[name] for name in _WITH_PLACE])
    made[has_place, 2] = rows[has_place, 2]
    return made
