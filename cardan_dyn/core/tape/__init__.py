"""Tape: arithmetic of scalars, traced once and run for many samples.

Functions of `scalars` and operators are called with floats, with arrays, or with variables of a
`Trace`, which writes down what is computed. A `Program` runs what was written down for as many
samples as there are, on a compiled machine or on NumPy arrays. It knows nothing of mechanics.
"""

from .derivative import derivatives, gradient
from .on_machine import machine_is_at_hand
from .printing import as_c
from .program import Program
from .scalars import absolute, arctan2, cos, exp, greater, log, select, sin, smaller, sqrt, tanh
from .stages import Stage, Stages
from .trace import Scalar, Trace, Variable, is_zero

__all__ = [
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
    "gradient",
    "greater",
    "is_zero",
    "log",
    "machine_is_at_hand",
    "select",
    "sin",
    "smaller",
    "sqrt",
    "tanh",
]
