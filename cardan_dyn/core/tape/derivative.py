"""Derivatives of what was traced: more nodes of the same trace.

They are exact. At a kink (`absolute` at 0, `greater`, `smaller` and `select` where they change
over), a derivative is one of the two on its sides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from ...kit.errors import ArgumentError
from .graph import reached
from .scalars import cos, select, sin
from .trace import Scalar, Trace, Variable, trace_of


def derivatives(outputs: Sequence[Scalar], wrt: Sequence[Variable]) -> list[list[Scalar]]:
    """Return derivatives of outputs, forwards: the effort grows with the number of variables.

    Args:
        outputs: variables of one trace, and numbers.
        wrt: variables of the same trace with respect to which outputs are differentiated: inputs,
            or others, through which outputs depend on inputs.

    Returns:
        Entry `[i][j]` is the derivative of output i with respect to variable j: a variable, or a
        number; the number 0.0 where one does not depend on the other.

    Raises:
        ArgumentError: something is of another trace, or of none.
    """
    columns = [tangents(outputs, {variable: 1.0}) for variable in wrt]
    return [list(row) for row in zip(*columns, strict=True)] if columns else [[] for _ in outputs]


def tangents(outputs: Sequence[Scalar], seeds: Mapping[Variable, Scalar]) -> list[Scalar]:
    """Return how fast outputs change while variables do, forwards.

    Args:
        outputs: variables of one trace, and numbers.
        seeds: variables of the same trace, inputs or others, to how fast they change: variables of
            that trace, or numbers.

    Returns:
        For each output a variable, or a number: 0.0 where it depends on none of the seeds.

    Raises:
        ArgumentError: as `derivatives`.
    """
    trace, ends, starts = checked(outputs, list(seeds))
    found = dict(zip(starts, seeds.values(), strict=True))
    for node in reached(trace, ends):
        if node.index not in found and any(k in found for k in node.arguments):
            tangent: Scalar = 0.0
            for argument, factor in zip(node.arguments, factors_of(node), strict=True):
                if argument in found:
                    tangent = tangent + factor.times(found[argument])
            found[node.index] = tangent
    return [found.get(end, 0.0) for end in ends]


def checked(
    outputs: Sequence[Scalar], wrt: Sequence[Variable]
) -> tuple[Trace, list[int], list[int]]:
    """Return the trace, and the nodes of outputs and variables."""
    if not all(isinstance(variable, Variable) for variable in wrt):
        raise ArgumentError("derivatives are with respect to variables of a trace, not numbers")
    trace = trace_of(*wrt, *outputs) or Trace()
    return trace, [trace.index(x) for x in outputs], [trace.index(x) for x in wrt]


class Factor(NamedTuple):
    """The derivative of a node with respect to an argument.

    Products with 0 or 1, as lanes choose, are chosen themselves: what is not may be NaN.

    Attributes:
        number: it, where nothing is chosen; else what is above 0 in lanes in which it is 1.
        is_one: in which lanes it is 1, else 0: those chosen, or the others; None where it is
            `number`.
    """

    number: Scalar
    is_one: bool | None = None

    def times(self, x: Scalar) -> Scalar:
        """Return its product with a scalar."""
        if self.is_one is None:
            return self.number * x
        return select(self.number, *((x, 0.0) if self.is_one else (0.0, x)))


def factors_of(node: Variable) -> tuple[Factor, ...]:
    """Return the derivative of a node with respect to each argument."""
    known = node.trace.factors
    if node.index not in known:
        arguments = [node.trace.scalar(argument) for argument in node.arguments]
        known[node.index] = _FACTORS[node.operation](node, *arguments)
    return known[node.index]


_Factors = tuple[Factor, ...]


def _by(*factors: Scalar) -> _Factors:
    return tuple(map(Factor, factors))


def _one_of(condition: Scalar) -> _Factors:
    """Return the factors 1 and 0 where a condition is above 0, else 0 and 1."""
    if type(condition) is not Variable:
        return _by(1.0, 0.0) if condition > 0.0 else _by(0.0, 1.0)
    return Factor(condition, True), Factor(condition, False)


def _of_arctan2(_: Scalar, y: Scalar, x: Scalar) -> _Factors:
    square = x * x + y * y
    return _by(x / square, -y / square)


_FACTORS: dict[str, Callable[..., _Factors]] = {
    "add": lambda _, a, b: _by(1.0, 1.0),
    "subtract": lambda _, a, b: _by(1.0, -1.0),
    "multiply": lambda _, a, b: _by(b, a),
    "divide": lambda y, a, b: _by(1.0 / b, -y / b),
    "negative": lambda _, a: _by(-1.0),
    "sqrt": lambda y, a: _by(0.5 / y),
    "sin": lambda _, a: _by(cos(a)),
    "cos": lambda _, a: _by(-sin(a)),
    "absolute": lambda _, a: _by(select(a, 1.0, -1.0)),
    "greater": lambda _, a, b: _one_of(a - b),
    "smaller": lambda _, a, b: _one_of(b - a),
    "select": lambda _, c, a, b: (Factor(0.0), *_one_of(c)),
    "exp": lambda y, a: _by(y),
    "log": lambda _, a: _by(1.0 / a),
    "tanh": lambda y, a: _by(1.0 - y * y),
    "arctan2": _of_arctan2,
}
"""Operations to the derivatives of their value y, given y and the arguments."""
