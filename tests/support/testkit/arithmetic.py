"""Random arithmetic, and what is right: by mpmath at 50 digits, operation by operation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from cardan_dyn.core import tape
from cardan_dyn.core.tape.graph import Graph

DIGITS = 50


def _quotient(a: Any, b: Any) -> Any:
    """Return a / b; of two floats as NumPy does, where Python raises an error."""
    return float(np.divide(a, b)) if type(a) is type(b) is float else a / b


EXACT = {
    "add": (2, lambda a, b: a + b),
    "subtract": (2, lambda a, b: a - b),
    "multiply": (2, lambda a, b: a * b),
    "divide": (2, _quotient),
    "negative": (1, lambda a: -a),
    "sqrt": (1, tape.sqrt),
    "absolute": (1, tape.absolute),
    "greater": (2, tape.greater),
    "smaller": (2, tape.smaller),
    "select": (3, tape.select),
}
"""Operations that are rounded correctly, to how many operands they have and what they are."""
LIBRARY = {
    "sin": (1, tape.sin),
    "cos": (1, tape.cos),
    "exp": (1, tape.exp),
    "log": (1, tape.log),
    "tanh": (1, tape.tanh),
    "arctan2": (2, tape.arctan2),
}
"""Operations that libraries round as they can."""
SUMS = ("add", "subtract", "multiply", "multiply")
CONSTANTS = (0.0, 1.0, -1.0, 2.0, -0.5, 3.7)

Step = tuple[str, tuple[Any, ...]]


def _sqrt(x: Any) -> Any:
    return mpmath.sqrt(x) if x >= 0 else mpmath.nan


def _log(x: Any) -> Any:
    return mpmath.nan if x < 0 else mpmath.log(x) if x > 0 else -mpmath.inf


IN_DIGITS: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b if b else mpmath.nan,
    "negative": lambda a: -a,
    "sqrt": _sqrt,
    "absolute": abs,
    "greater": max,
    "smaller": min,
    "select": lambda c, a, b: a if c > 0 else b,
    "sin": mpmath.sin,
    "cos": mpmath.cos,
    "exp": mpmath.exp,
    "log": _log,
    "tanh": mpmath.tanh,
    "arctan2": mpmath.atan2,
}


@dataclass(frozen=True)
class Text:
    """A text of arithmetic: steps, one after the other, on inputs, numbers and steps before.

    An operand that is an int is an input, or, after these, a step; a float is a number.
    """

    inputs: int
    steps: tuple[Step, ...]

    def __call__(self, inputs: Sequence[Any]) -> list[Any]:
        """Return what each step gives, for scalars of any kind."""
        values = list(inputs)
        for operation, operands in self.steps:
            function = {**EXACT, **LIBRARY}[operation][1]
            values.append(function(*[values[x] if type(x) is int else x for x in operands]))
        return values[self.inputs :]

    def traced(self, uniform: Sequence[int] = ()) -> tuple[tape.Trace, list[Any]]:
        """Return a trace with inputs x0, x1 ... and what each step gives there."""
        trace = tape.Trace()
        inputs = [trace.input(f"x{k}", 0.5, uniform=k in uniform) for k in range(self.inputs)]
        with np.errstate(all="ignore"):
            return trace, self(inputs)


def random_text(
    rng: np.random.Generator, length: int, inputs: int = 4, operations: Sequence[str] = ()
) -> Text:
    """Return a text of random steps, half of whose operands are among the latest ten."""
    names = list(operations) or [*EXACT, *LIBRARY]
    known = {**EXACT, **LIBRARY}
    steps: list[Step] = []
    for count in range(inputs, inputs + length):
        operation = names[rng.integers(len(names))]
        chosen = [
            int(rng.integers(max(0, count - 10) if rng.random() < 0.5 else 0, count))
            for _ in range(known[operation][0])
        ]
        # A number beside a variable: two numbers are Python's business.
        operands: list[int | float] = list(chosen)
        if len(operands) > 1 and rng.random() < 0.2:
            operands[rng.integers(len(operands))] = float(rng.choice(CONSTANTS))
        steps.append((operation, tuple(operands)))
    return Text(inputs, tuple(steps))


def random_lanes(rng: np.random.Generator, text: Text, count: int) -> dict[str, np.ndarray]:
    """Return values of inputs between -3 and 3."""
    return {f"x{k}": rng.uniform(-3.0, 3.0, count) for k in range(text.inputs)}


def of_graph(graph: Graph, inputs: dict[str, Any]) -> list[Any]:
    """Return the outputs of a graph as mpmath finds them, one lane."""
    values: list[Any] = []
    with mpmath.workdps(DIGITS):
        for operation, arguments in graph.nodes():
            if operation == "constant":
                values.append(mpmath.mpf(float(graph.constants[arguments[0]])))
            elif operation in ("input", "uniform input"):
                values.append(mpmath.mpf(inputs[graph.inputs[arguments[0]]]))
            else:
                values.append(IN_DIGITS[operation](*[values[k] for k in arguments]))
        return [values[node] for node in graph.outputs]


def usual(values: np.ndarray) -> np.ndarray:
    """Return where values are finite and not zero.

    Results of such are kept to the last bit; signs of zeros, and what becomes of infinite values
    and NaN, may differ.
    """
    return np.isfinite(values) & (values != 0.0)


def kept(text: Text, inputs: Sequence[np.ndarray], steps: np.ndarray) -> np.ndarray:
    """Return which steps `(steps, lanes)` go back to usual values alone."""
    known = [usual(values) for values in inputs]
    for row, (_, operands) in zip(steps, text.steps, strict=True):
        before = [known[x] for x in operands if type(x) is int]
        known.append(np.logical_and.reduce([usual(row), *before]))
    return np.array(known[text.inputs :])
