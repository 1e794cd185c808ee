"""Printing: a program as C, which needs nothing of this package."""

from __future__ import annotations

import math
import re

from ...kit.errors import ArgumentError
from .graph import Graph
from .operations import CONSTANT, INPUT, UNIFORM
from .program import Program

_EXPRESSIONS = {
    "add": "{} + {}",
    "subtract": "{} - {}",
    "multiply": "{} * {}",
    "divide": "{} / {}",
    "negative": "-{}",
    "sqrt": "sqrt({})",
    "sin": "sin({})",
    "cos": "cos({})",
    "absolute": "fabs({})",
    "greater": "{0} > {1} || {0} != {0} ? {0} : {1}",
    "smaller": "{0} < {1} || {0} != {0} ? {0} : {1}",
    "select": "{} > 0.0 ? {} : {}",
    "exp": "exp({})",
    "log": "log({})",
    "tanh": "tanh({})",
    "arctan2": "atan2({}, {})",
}


def function_name(name: str) -> str:
    """Return the name of a function of C.

    Raises:
        ArgumentError: it is no identifier.
    """
    if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
        raise ArgumentError(f"{name!r} is no name of a function in C; use letters, digits and _")
    return name


def as_c(program: Program, name: str) -> str:
    """Return a function in C99 that computes what a program does.

    It is to be compiled so that products are not fused with sums (`-ffp-contract=off`, which is
    what `-std=c99` means to GCC) and without `-ffast-math`. Results are those of the program to the
    last bit, but for functions of the C library.

    Args:
        program: the program.
        name: of the function, an identifier of C.

    Raises:
        ArgumentError: the name is no identifier.
    """
    name, graph = function_name(name), program.graph
    once: list[str] = []
    each: list[str] = []
    for node, (operation, arguments) in enumerate(graph.nodes()):
        value = _value(graph, operation, arguments)
        (once if graph.uniform[node] else each).append(f"const double x{node} = {value};")
    stores = [f"outputs[{row} * count + lane] = x{node};" for row, node in enumerate(graph.outputs)]
    inputs = [
        f"   {place}: {text}{', one number' if text in graph.uniform_inputs else ''}"
        for place, text in enumerate(graph.inputs)
    ]
    return "\n".join(
        [
            "#include <math.h>",
            "",
            f"/* Outputs, {len(graph.outputs)} rows of count numbers, from inputs, each count"
            " numbers:",
            *[line.replace("*/", "* /") for line in inputs],
            "*/",
            f"void {name}(long count, const double *const *inputs, double *outputs)",
            "{",
            *[f"    {line}" for line in once],
            "    for (long lane = 0; lane < count; lane++) {",
            *[f"        {line}" for line in (*each, *stores)],
            "    }",
            "}",
            "",
        ]
    )


def _value(graph: Graph, operation: str, arguments: list[int]) -> str:
    if operation == CONSTANT:
        return _number(float(graph.constants[arguments[0]]))
    if operation in (INPUT, UNIFORM):
        return f"inputs[{arguments[0]}][{'0' if operation == UNIFORM else 'lane'}]"
    return _EXPRESSIONS[operation].format(*[f"x{argument}" for argument in arguments])


def _number(value: float) -> str:
    """Return a number as C writes it, to the last bit."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "-INFINITY"
    return value.hex()
