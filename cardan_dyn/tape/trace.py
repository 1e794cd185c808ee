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

from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError
from .operations import CONSTANT, INPUT, ON_ARRAYS

Scalar: TypeAlias = Any
"""A float, an array `(N,)` of all samples at once, or a `Variable`: texts are written for each."""


def is_zero(x: Scalar) -> bool:
    """Return whether a scalar is zero whatever the inputs are: the float 0.0 (or -0.0)."""
    return type(x) is float and x == 0.0


class Variable:
    """A scalar whose value is not known yet: a node of a trace.

    `+ - * /` and unary `-` take other variables of the same trace, and numbers.
    """

    __slots__ = ("index", "trace")
    __array_ufunc__ = None  # NumPy's numbers leave operators with variables to these.

    def __init__(self, trace: Trace, index: int) -> None:
        self.trace = trace
        self.index = index

    @property
    def shadow(self) -> Array:
        """Values at the samples that inputs have as their shadows `(S,)`, read-only."""
        return self.trace.shadow(self.index)

    def __add__(self, other: Scalar) -> Scalar:
        return self.trace.add(self, other)

    def __radd__(self, other: Scalar) -> Scalar:
        return self.trace.add(other, self)

    def __sub__(self, other: Scalar) -> Scalar:
        return self.trace.subtract(self, other)

    def __rsub__(self, other: Scalar) -> Scalar:
        return self.trace.subtract(other, self)

    def __mul__(self, other: Scalar) -> Scalar:
        return self.trace.multiply(self, other)

    def __rmul__(self, other: Scalar) -> Scalar:
        return self.trace.multiply(other, self)

    def __truediv__(self, other: Scalar) -> Scalar:
        return self.trace.divide(self, other)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        return self.trace.divide(other, self)

    def __neg__(self) -> Scalar:
        return self.trace.negative(self)

    def __pos__(self) -> Variable:
        return self

    def __bool__(self) -> bool:
        raise ArgumentError(
            "a traced variable is neither true nor false: its value is known when the program"
            " runs; let both sides be computed and choose one by select(condition, a, b)"
        )

    def __repr__(self) -> str:
        return f"<Variable {self.index}: {self.trace.operations[self.index]}>"


class Trace:
    """A graph of operations, which grows while functions of scalars are called with its variables.

    Attributes:
        operations: of each node, a name of `ON_ARRAYS`, `CONSTANT` or `INPUT`.
        arguments: of each node, indices of nodes before it; none of constants and inputs.
        uniform: whether each node has one value for all lanes of a run.
        constants: nodes to the values of those that are constants.
        inputs: names of inputs to their nodes, in the order of their creation.
    """

    def __init__(self) -> None:
        self.operations: list[str] = []
        self.arguments: list[tuple[int, ...]] = []
        self.uniform: list[bool] = []
        self.constants: dict[int, float] = {}
        self.inputs: dict[str, int] = {}
        self._variables: list[Variable] = []
        self._merged: dict[tuple[object, ...], Variable] = {}
        self._shadows: list[Any] = []
        self._given: dict[int, Any] = {}
        self._samples = 1

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
        variable = self._appended(INPUT, (), uniform)
        self._given[variable.index] = values
        self.inputs[name] = variable.index
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
        return self._variables[index] if constant is None else constant

    def node(self, x: Scalar) -> int:
        """Return the node of a scalar; a number gets one if it has none.

        Raises:
            ArgumentError: the scalar is a variable of another trace, or no number.
        """
        if type(x) is Variable:
            if x.trace is not self:
                raise ArgumentError(
                    "variables of two traces meet; make all inputs of a program by one trace"
                )
            return x.index
        value = self._number(x)
        # 0.0 and -0.0 are equal, but not the same.
        key = (CONSTANT, value, str(value)) if value == 0.0 else (CONSTANT, value)
        variable = self._merged.get(key)
        if variable is None:
            variable = self._merged[key] = self._appended(CONSTANT, (), True)
            self.constants[variable.index] = value
        return variable.index

    def add(self, a: Scalar, b: Scalar) -> Scalar:
        """Return a + b."""
        a, b = self._taken(a), self._taken(b)
        if is_zero(a):
            return b
        if is_zero(b):
            return a
        i, j = self.node(a), self.node(b)
        if self.operations[j] == "negative":
            return self.subtract(a, self._argument(j))
        if self.operations[i] == "negative":
            return self.subtract(b, self._argument(i))
        return self._commutative("add", i, j)

    def subtract(self, a: Scalar, b: Scalar) -> Scalar:
        """Return a - b."""
        a, b = self._taken(a), self._taken(b)
        if is_zero(b):
            return a
        if is_zero(a):
            return self.negative(b)
        i, j = self.node(a), self.node(b)
        if self.operations[j] == "negative":
            return self.add(a, self._argument(j))
        if self.operations[i] == "negative":
            return self.negative(self.add(self._argument(i), b))
        return 0.0 if i == j else self._node("subtract", i, j)

    def multiply(self, a: Scalar, b: Scalar) -> Scalar:
        """Return a * b."""
        a, b = self._taken(a), self._taken(b)
        if is_zero(a) or is_zero(b):
            return 0.0
        negated_a, a = self._without_sign(a)
        negated_b, b = self._without_sign(b)
        if type(a) is float and a == 1.0:
            product = b
        elif type(b) is float and b == 1.0:
            product = a
        else:
            product = self._commutative("multiply", self.node(a), self.node(b))
        return product if negated_a == negated_b else self.negative(product)

    def divide(self, a: Scalar, b: Scalar) -> Scalar:
        """Return a / b."""
        a, b = self._taken(a), self._taken(b)
        if is_zero(a):
            return 0.0
        negated_a, a = self._without_sign(a)
        negated_b, b = self._without_sign(b)
        if type(b) is float and b == 1.0:
            quotient = a
        else:
            quotient = self._node("divide", self.node(a), self.node(b))
        return quotient if negated_a == negated_b else self.negative(quotient)

    def negative(self, a: Scalar) -> Scalar:
        """Return -a."""
        if type(a) is not Variable:
            return -a
        operation, arguments = self.operations[a.index], self.arguments[a.index]
        if operation == "negative":
            return self._variables[arguments[0]]
        if operation == "subtract":
            return self._node("subtract", arguments[1], arguments[0])
        return self._node("negative", a.index)

    def function(self, operation: str, x: Variable) -> Scalar:
        """Return a function of one variable: sqrt, sin, cos, absolute, exp, log or tanh."""
        if operation in ("sin", "cos", "absolute"):
            negated, x = self._without_sign(x)
            if negated and operation == "sin":
                return self.negative(self._node(operation, x.index))
            if operation == "absolute" and self.operations[x.index] == "absolute":
                return x
        return self._node(operation, x.index)

    def arctan2(self, y: Scalar, x: Scalar) -> Scalar:
        """Return the angle of the point (x, y) from the axis of x [rad]."""
        return self._node("arctan2", self.node(y), self.node(x))

    def extreme(self, operation: str, a: Scalar, b: Scalar) -> Scalar:
        """Return the "greater" or the "smaller" one; NaN if one is NaN."""
        i, j = self.node(a), self.node(b)
        if i == j:
            return a
        if operation == "greater":
            for zero, other in ((a, j), (b, i)):
                if is_zero(zero) and self.operations[other] == "absolute":
                    return self._variables[other]
        return self._commutative(operation, i, j)

    def select(self, condition: Scalar, a: Scalar, b: Scalar) -> Scalar:
        """Return a where the condition is above 0, else b: where it is NaN as well."""
        condition = self._taken(condition)
        if type(condition) is float:
            return a if condition > 0.0 else b
        i, j = self.node(a), self.node(b)
        return a if i == j else self._node("select", self.node(condition), i, j)

    def _taken(self, x: Scalar) -> Scalar:
        """Return a variable as it is, and any number as a float."""
        kind = type(x)
        return x if kind is Variable or kind is float else self._number(x)

    def _number(self, x: Any) -> float:
        if not isinstance(x, Real):
            raise ArgumentError(
                f"a traced variable meets {type(x).__name__}; it takes numbers and variables,"
                " arrays are given to the program"
            )
        return float(x)

    def _without_sign(self, x: Scalar) -> tuple[bool, Scalar]:
        """Return whether a scalar is the negative of another, and that one; else the scalar."""
        if type(x) is float:
            return (True, -x) if x < 0.0 else (False, x)
        if self.operations[x.index] == "negative":
            return True, self._argument(x.index)
        return False, x

    def _argument(self, index: int) -> Variable:
        return self._variables[self.arguments[index][0]]

    def _commutative(self, operation: str, i: int, j: int) -> Variable:
        return self._node(operation, i, j) if i <= j else self._node(operation, j, i)

    def _node(self, operation: str, *arguments: int) -> Variable:
        """Return the variable of an operation, a new one unless it was written down before."""
        key = (operation, *arguments)
        variable = self._merged.get(key)
        if variable is None:
            uniform = True
            for argument in arguments:
                uniform = uniform and self.uniform[argument]
            variable = self._merged[key] = self._appended(operation, arguments, uniform)
        return variable

    def _appended(self, operation: str, arguments: tuple[int, ...], uniform: bool) -> Variable:
        variable = Variable(self, len(self.operations))
        self._variables.append(variable)
        self.operations.append(operation)
        self.arguments.append(arguments)
        self.uniform.append(uniform)
        return variable

    def _value(self, node: int) -> Any:
        """Return the values of a node at the shadow samples, those of nodes before it known."""
        operation = self.operations[node]
        if operation == CONSTANT:
            return self.constants[node]
        if operation == INPUT:
            return self._given[node]
        known = self._shadows
        return ON_ARRAYS[operation](*[known[argument] for argument in self.arguments[node]])


def trace_of(*scalars: Scalar) -> Trace | None:
    """Return the trace of the first variable among scalars; None if there is none."""
    return next((x.trace for x in scalars if type(x) is Variable), None)
