"""Tape: arithmetic of scalars, traced once and run for many samples.

Functions of `scalars` and operators are called with floats, with arrays, or with variables of a
`Trace`, which writes down what is computed. A `Program` runs what was written down for as many
samples as there are, on a compiled machine or on NumPy arrays. It knows nothing of mechanics.

Arithmetic of scalars, and nothing of mechanics. Texts are functions of scalars (`scalars`): floats,
arrays, or variables of a `trace`, which writes down what is computed, folded and merged;
`derivative` goes on writing, and `differential` makes of it how much changes with much. The part
that outputs depend on is a `graph`, plain arrays, from which others make something else, each
rounding as it does: `on_arrays` binds it to NumPy, `on_machine` has instructions of the compiled
machine made of it, `printing` writes C. A `program` runs it for as many samples as there are,
`stages` several programs on one block of them. `operations` are the primitives that all know;
`lowering.c` has their numbers.
"""

from .derivative import Factor, derivatives, tangents
from .differential import NOTHING, Differential
from .on_machine import LANES, machine_is_at_hand
from .printing import as_c, function_name
from .program import Program
from .scalars import absolute, arctan2, cos, exp, greater, log, select, sin, smaller, sqrt, tanh
from .stages import Stage, Stages
from .trace import Scalar, Trace, Variable, is_zero

__all__ = [
    "LANES",
    "NOTHING",
    "Differential",
    "Factor",
    "Program",
    "Scalar",
    "Stage",
    "Stages",
    "Trace",
    "Variable",
    "absolute",
    "arctan2",
    "as_c",
    "cos",
    "derivatives",
    "exp",
    "function_name",
    "greater",
    "is_zero",
    "log",
    "machine_is_at_hand",
    "select",
    "sin",
    "smaller",
    "sqrt",
    "tangents",
    "tanh",
]
