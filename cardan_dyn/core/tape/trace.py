"""Trace: arithmetic on variables, written down as a graph of operations.

A node of the graph is a constant, an input, or an operation on nodes before it. Operations are
folded while they are written down, and equal ones are merged into one node. Results stay the same
to the last bit wherever operands are finite, but for the sign of a result that is zero:

| written | kept | differs where |
|---|---|---|
| `0 * x`, `x - x`, `0 / x` | 0.0 | x is infinite or NaN; in the quotient, 0 as well |
| `x + 0`, `x - 0`, `0 - x` | `x`, `x`, `-x` | a zero's sign |
| `1 * x`, `x / 1`, `-(-x)`, `x - (-y)`, `x + (-y)` | `x`, `x`, `x`, `x + y`, `x - y` | nowhere |
| `-(x - y)`, `(-x) - y` | `y - x`, `-(x + y)` | a zero's sign |
| `(-x) * y`, `(-x) / y`, `x / (-y)`, `sin(-x)` | minus `x * y`, ... | nowhere |
| `cos(-x)`, `absolute(-x)`, `absolute(absolute(x))` | without the inner one | nowhere |
| `greater(0, absolute(x))`, `greater(x, x)`, `smaller(x, x)` | `absolute(x)`, `x`, `x` | nowhere |
| `select(c, x, x)`, `select(number, x, y)` | what is chosen | nowhere |

Zeros and ones are numbers here, known while the trace is made: values of inputs are not. Nothing is
reassociated.
"""

from __future__ import annotations

import gc
from collections import defaultdict
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError
from .operations import CONSTANT, INPUT, ON_ARRAYS, UNIFORM

Scalar: TypeAlias = Any
"""A float, an array `(N,)` of all samples at once, or a `Variable`: texts are written for each."""


def is_zero(x: Scalar) -> bool:
    """Return whether a scalar is zero whatever the inputs are: the float 0.0 (or -0.0)."""
    return type(x) is float and x == 0.0


class Variable:
    """A scalar whose value is not known yet: a node of a trace.

    `+ - * /` and unary `-` take other variables of the same trace, and numbers. They ask for
    little beyond themselves: a first call of a scene mostly traces.

    Attributes:
        trace: that it is of.
        index: of the node.
        operation: a name of `ON_ARRAYS`, or `CONSTANT`, `INPUT` or `UNIFORM`.
        arguments: indices of nodes before it; none of constants and inputs.
    """

    __slots__ = ("arguments", "index", "operation", "trace")
    __array_ufunc__ = None  # NumPy's numbers leave operators with variables to these.
    trace: Trace
    index: int
    operation: str
    arguments: tuple[int, ...]

    @property
    def shadow(self) -> Array:
        """Values at the samples that inputs have as their shadows `(S,)`, read-only."""
        return self.trace.shadow(self.index)

    def __add__(self, other: Scalar) -> Scalar:
        trace = self.trace
        if type(other) is not Variable or other.trace is not trace:
            number = other if type(other) is float else _number(other)
            if number == 0.0:
                return self
            other = trace.constant(number)
        if other.operation == "negative":
            return self - trace.nodes[other.arguments[0]]
        if self.operation == "negative":
            return other - trace.nodes[self.arguments[0]]
        i, j = self.index, other.index
        return trace.node("add", i, j) if i <= j else trace.node("add", j, i)

    def __sub__(self, other: Scalar) -> Scalar:
        trace = self.trace
        if type(other) is not Variable or other.trace is not trace:
            number = other if type(other) is float else _number(other)
            if number == 0.0:
                return self
            other = trace.constant(number)
        if other.operation == "negative":
            return self + trace.nodes[other.arguments[0]]
        if self.operation == "negative":
            return -(trace.nodes[self.arguments[0]] + other)
        return 0.0 if self is other else trace.node("subtract", self.index, other.index)

    def __rsub__(self, other: Scalar) -> Scalar:
        number = _number(other)
        return -self if number == 0.0 else self.trace.constant(number) - self

    def __mul__(self, other: Scalar) -> Scalar:
        trace, own, negated = self.trace, self, False
        if type(other) is not Variable or other.trace is not trace:
            number = other if type(other) is float else _number(other)
            if number == 0.0:
                return 0.0
            if number < 0.0:
                number, negated = -number, True
            if number == 1.0:
                return -self if negated else self
            other = trace.constant(number)
        elif other.operation == "negative":
            other, negated = trace.nodes[other.arguments[0]], True
        if own.operation == "negative":
            own, negated = trace.nodes[own.arguments[0]], not negated
        i, j = own.index, other.index
        product = trace.node("multiply", i, j) if i <= j else trace.node("multiply", j, i)
        return -product if negated else product

    def __truediv__(self, other: Scalar) -> Scalar:
        if type(other) is Variable and other.trace is self.trace:
            return self.trace.quotient(self, other, False)
        number = _number(other)
        negated = number < 0.0
        number = -number if negated else number
        if number == 1.0:
            return -self if negated else self
        return self.trace.quotient(self, self.trace.constant(number), negated)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        number = _number(other)
        if number == 0.0:
            return 0.0
        negated = number < 0.0
        return self.trace.quotient(
            self.trace.constant(-number if negated else number), self, negated
        )

    def __neg__(self) -> Variable:
        trace = self.trace
        if self.operation == "negative":
            return trace.nodes[self.arguments[0]]
        if self.operation == "subtract":
            i, j = self.arguments
            return trace.node("subtract", j, i)
        return trace.node("negative", self.index)

    __radd__, __rmul__ = __add__, __mul__

    def __pos__(self) -> Variable:
        return self

    def __bool__(self) -> bool:
        raise ArgumentError(
            "a traced variable is neither true nor false: its value is known when the program"
            " runs; let both sides be computed and choose one by select(condition, a, b)"
        )

    def __repr__(self) -> str:
        return f"<Variable {self.index}: {self.operation}>"


class Trace:
    """A graph of operations, which grows while functions of scalars are called with its variables.

    In `with Trace() as trace:` it ends with the block, in which programs are made of it. Its nodes
    and it refer to each other in circles: Python's collector of such is not run meanwhile, which
    would take a third as long as tracing does, and has nothing left to collect then.

    Attributes:
        nodes: the variable of each node.
        constants: nodes to the values of those that are constants.
        inputs: names of inputs to their variables, in the order of their creation.
        factors: nodes to the derivatives by their arguments that are known, see `derivative`.
    """

    def __init__(self) -> None:
        self.nodes: list[Variable] = []
        self.constants: dict[int, float] = {}
        self.inputs: dict[str, Variable] = {}
        self._known: dict[str, dict[tuple[int, ...], int]] = defaultdict(dict)
        self.factors: dict[int, tuple[Any, ...]] = {}
        self._of_numbers: dict[float | str, Variable] = {}
        self._shadows: list[Any] = []
        self._given: dict[int, Any] = {}
        self._samples = 1

    def __enter__(self) -> Trace:
        self._collects = gc.isenabled()
        gc.disable()
        return self

    def __exit__(self, *_: object) -> None:
        collects = self._collects
        vars(self).clear()
        if collects:
            gc.enable()

    def input(self, name: str, shadow: Any, uniform: bool = False) -> Variable:
        """Return a new input.

        Args:
            name: by which programs are given its values.
            shadow: values at which decisions are taken while the trace is made, such as which
                pivot is large: a number, or `(S,)` with the same S for all inputs of the trace.
            uniform: whether a run gives one number for all its lanes. What depends on uniform
                inputs alone is computed once a run.

        Raises:
            ArgumentError: the trace has an input of this name, or shadows differ in length.
        """
        if name in self.inputs:
            raise ArgumentError(f"the trace has an input {name!r} already; inputs are unique")
        values = np.array(shadow, dtype=float)
        if values.ndim > 1 or (values.ndim and self._samples not in (1, len(values))):
            raise ArgumentError(
                f"the shadow of {name!r} has the shape {values.shape}; give a number, or as many"
                f" values as other inputs have ({self._samples})"
            )
        if values.ndim:
            self._samples = len(values)
        variable = self.inputs[name] = self._leaf(UNIFORM if uniform else INPUT)
        self._given[variable.index] = values
        return variable

    def shadow(self, index: int) -> Array:
        """Return the values of a node at the shadow samples `(S,)`, read-only."""
        values = self._shadows
        if index >= len(values):
            with np.errstate(all="ignore"):
                for node in range(len(values), index + 1):
                    values.append(self._value(node))
        return np.broadcast_to(values[index], self._samples)

    def scalar(self, index: int) -> Scalar:
        """Return what a node stands for: a float if it is a constant, else its variable."""
        constant = self.constants.get(index)
        return self.nodes[index] if constant is None else constant

    def index(self, x: Scalar) -> int:
        """Return the node of a scalar; a number gets one if it has none.

        Raises:
            ArgumentError: the scalar is a variable of another trace, or no number.
        """
        is_own = type(x) is Variable and x.trace is self
        return (x if is_own else self.constant(_number(x))).index

    def constant(self, value: float) -> Variable:
        """Return the node of a number."""
        key = value or str(value)  # 0.0 and -0.0 are equal, but not the same.
        variable = self._of_numbers.get(key)
        if variable is None:
            variable = self._of_numbers[key] = self._leaf(CONSTANT)
            self.constants[variable.index] = value
        return variable

    def node(self, operation: str, *arguments: int) -> Variable:
        """Return the variable of an operation, a new one unless it was written down before."""
        nodes = self.nodes
        end = len(nodes)
        index = self._known[operation].setdefault(arguments, end)
        if index < end:
            return nodes[index]
        variable = Variable()
        variable.trace = self
        variable.index = end
        variable.operation = operation
        variable.arguments = arguments
        nodes.append(variable)
        return variable

    def quotient(self, a: Variable, b: Variable, negated: bool) -> Variable:
        """Return a / b, or minus that."""
        if a.operation == "negative":
            a, negated = self.nodes[a.arguments[0]], not negated
        if b.operation == "negative":
            b, negated = self.nodes[b.arguments[0]], not negated
        quotient = self.node("divide", a.index, b.index)
        return -quotient if negated else quotient

    def function(self, operation: str, x: Variable) -> Scalar:
        """Return a function of one variable: sqrt, sin, cos, absolute, exp, log or tanh."""
        if x.operation == "negative" and operation in ("sin", "cos", "absolute"):
            found = self.function(operation, self.nodes[x.arguments[0]])
            return -found if operation == "sin" else found
        if operation == x.operation == "absolute":
            return x
        return self.node(operation, x.index)

    def arctan2(self, y: Scalar, x: Scalar) -> Scalar:
        """Return the angle of the point (x, y) from the axis of x [rad]."""
        return self.node("arctan2", self.index(y), self.index(x))

    def extreme(self, operation: str, a: Scalar, b: Scalar) -> Scalar:
        """Return the "greater" or the "smaller" one; NaN if one is NaN."""
        i, j = self.index(a), self.index(b)
        if i == j:
            return a
        if operation == "greater" and is_zero(a) and b.operation == "absolute":
            return b
        if operation == "greater" and is_zero(b) and a.operation == "absolute":
            return a
        return self.node(operation, i, j) if i <= j else self.node(operation, j, i)

    def select(self, condition: Scalar, a: Scalar, b: Scalar) -> Scalar:
        """Return a where the condition is above 0, else b: where it is NaN as well."""
        if type(condition) is not Variable:
            return a if _number(condition) > 0.0 else b
        i, j = self.index(a), self.index(b)
        return a if i == j else self.node("select", self.index(condition), i, j)

    def _leaf(self, operation: str) -> Variable:
        """Return a new node without arguments."""
        leaf = self.node(operation, len(self.nodes))
        leaf.arguments = ()
        return leaf

    def _value(self, node: int) -> Any:
        """Return the values of a node at the shadow samples, those of nodes before it known."""
        operation = self.nodes[node].operation
        if operation == CONSTANT:
            return self.constants[node]
        if operation in (INPUT, UNIFORM):
            return self._given[node]
        known = self._shadows
        return ON_ARRAYS[operation](*[known[k] for k in self.nodes[node].arguments])


def _number(x: Any) -> float:
    """Return a number that a variable meets.

    Raises:
        ArgumentError: it is none.
    """
    if type(x) is Variable:
        raise ArgumentError(
            "variables of two traces meet; make all inputs of a program by one trace"
        )
    if not isinstance(x, Real):
        raise ArgumentError(
            f"a traced variable meets {type(x).__name__}; it takes numbers and variables,"
            " arrays are given to the program"
        )
    return float(x)


def trace_of(*scalars: Scalar) -> Trace | None:
    """Return the trace of the first variable among scalars; None if there is none."""
    return next((x.trace for x in scalars if type(x) is Variable), None)
