"""Derivatives of what was traced: more nodes of the same trace.

They are exact. At a kink (`absolute` at 0, `greater`, `smaller` and `select` where they change
over), a derivative is one of the two on its sides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

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
    trace, ends, starts = _checked(outputs, list(seeds))
    found = dict(zip(starts, seeds.values(), strict=True))
    for node in reached(trace, ends):
        if node.index not in found and any(k in found for k in node.arguments):
            tangent: Scalar = 0.0
            for argument, times in zip(node.arguments, _factors(node), strict=True):
                if argument in found:
                    tangent = tangent + times(found[argument])
            found[node.index] = tangent
    return [found.get(end, 0.0) for end in ends]


def gradient(output: Scalar, wrt: Sequence[Variable]) -> list[Scalar]:
    """Return derivatives of one output, backwards: the effort is that of one for any number.

    Args:
        output: a variable, or a number.
        wrt: as of `derivatives`.

    Returns:
        The derivative with respect to each variable, as of `derivatives`.

    Raises:
        ArgumentError: as `derivatives`.
    """
    return pulled([output], [1.0], wrt)


def pulled(
    outputs: Sequence[Scalar], weights: Sequence[Scalar], wrt: Sequence[Variable]
) -> list[Scalar]:
    """Return derivatives of a weighted sum of outputs, backwards, with the weights kept.

    Args:
        outputs: variables of one trace, and numbers.
        weights: one for each: variables of the same trace, or numbers.
        wrt: as of `derivatives`.

    Returns:
        As `gradient`.

    Raises:
        ArgumentError: as `derivatives`.
    """
    trace, ends, starts = _checked(outputs, wrt)
    order = reached(trace, ends)
    depends = set(starts)
    for node in order:
        if not depends.isdisjoint(node.arguments):
            depends.add(node.index)
    adjoints: dict[int, Scalar] = {}
    for end, weight in zip(ends, weights, strict=True):
        adjoints[end] = adjoints.get(end, 0.0) + weight
    for node in reversed(order):
        if node.index in adjoints and not depends.isdisjoint(node.arguments):
            own = adjoints[node.index]
            for argument, times in zip(node.arguments, _factors(node), strict=True):
                if argument in depends:
                    adjoints[argument] = adjoints.get(argument, 0.0) + times(own)
    return [adjoints.get(start, 0.0) for start in starts]


def _checked(
    outputs: Sequence[Scalar], wrt: Sequence[Variable]
) -> tuple[Trace, list[int], list[int]]:
    """Return the trace, and the nodes of outputs and variables."""
    if not all(isinstance(variable, Variable) for variable in wrt):
        raise ArgumentError("derivatives are with respect to variables of a trace, not numbers")
    trace = trace_of(*wrt, *outputs) or Trace()
    return trace, [trace.index(x) for x in outputs], [trace.index(x) for x in wrt]


def _factors(node: Variable) -> tuple[Callable[[Scalar], Scalar], ...]:
    """Return the derivative of a node with respect to each argument, as products with it.

    Products with 0 or 1, as lanes choose, are chosen themselves: the other may be NaN.
    """
    known = node.trace.factors
    if node.index not in known:
        arguments = [node.trace.scalar(argument) for argument in node.arguments]
        known[node.index] = _FACTORS[node.operation](node, *arguments)
    return known[node.index]


_Factors = tuple[Callable[[Scalar], Scalar], ...]


def _by(*factors: Scalar) -> _Factors:
    return tuple([lambda d, factor=factor: factor * d for factor in factors])


def _one_of(condition: Scalar) -> _Factors:
    """Return the factors 1 and 0 where a condition is above 0, else 0 and 1."""
    return (lambda d: select(condition, d, 0.0), lambda d: select(condition, 0.0, d))


def _of_arctan2(_: Scalar, y: Scalar, x: Scalar) -> _Factors:
    square = x * x + y * y
    return _by(x / square, -y / square)


_FACTORS: dict[str, Callable[..., _Factors]] = {
    "add": lambda _, a, b: _by(1.0, 1.0),
    "subtract": lambda _, a, b: _by(1.0, -1.0),
    "multiply": lambda _, a, b: _by(b, a),
    "divide": lambda y, a, b: (lambda d: d / b, lambda d: -(y * d) / b),
    "negative": lambda _, a: _by(-1.0),
    "sqrt": lambda y, a: (lambda d: 0.5 * d / y,),
    "sin": lambda _, a: _by(cos(a)),
    "cos": lambda _, a: _by(-sin(a)),
    "absolute": lambda _, a: (lambda d: select(a, d, -d),),
    "greater": lambda _, a, b: _one_of(a - b),
    "smaller": lambda _, a, b: _one_of(b - a),
    "select": lambda _, c, a, b: (lambda d: 0.0, *_one_of(c)),
    "exp": lambda y, a: _by(y),
    "log": lambda _, a: (lambda d: d / a,),
    "tanh": lambda y, a: _by(1.0 - y * y),
    "arctan2": _of_arctan2,
}
"""Operations to the derivatives of their value y, given y and the arguments."""
