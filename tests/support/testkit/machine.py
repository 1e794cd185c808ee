"""The machine's operations, as `compiled/machine.h` tells them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from cardan_dyn.core.compiled import kernel

Array = NDArray[np.float64]

needs_machine = pytest.mark.skipif(
    not hasattr(kernel, "run_program"), reason="no machine is compiled here"
)

_ORDER = (
    "END LOAD LDU STORE KST ADD SUB MUL DIV RCP NEG SQRT SC ABS MAX MIN SEL FMA FMS FNMA P2 M2 P3"
    " A2 S2 AS AMX ADD3 PPM EXP LOG TANH ATAN2 PMP PMM PMA SA"
)
OPERATIONS = _ORDER.split()
"""Names by their numbers."""


def greater(a: Array, b: Array) -> Array:
    return np.where(np.isnan(a) | (a > b), a, b)


def smaller(a: Array, b: Array) -> Array:
    return np.where(np.isnan(a) | (a < b), a, b)


ROUNDED: dict[str, Callable[..., Array]] = {
    "ADD": lambda a, b: a + b,
    "SUB": lambda a, b: a - b,
    "MUL": lambda a, b: a * b,
    "DIV": lambda a, b: a / b,
    "RCP": lambda a: 1.0 / a,
    "NEG": lambda a: -a,
    "SQRT": lambda a: np.sqrt(a),
    "ABS": lambda a: np.abs(a),
    "MAX": greater,
    "MIN": smaller,
    "SEL": lambda a, b, c: np.where(a > 0.0, b, c),
    "FMA": lambda a, b, c: a * b + c,
    "FMS": lambda a, b, c: a * b - c,
    "FNMA": lambda a, b, c: c - a * b,
    "P2": lambda a, b, c, d: a * b + c * d,
    "M2": lambda a, b, c, d: a * b - c * d,
    "P3": lambda a, b, c, d, e, f: a * b + c * d + e * f,
    "A2": lambda a, b, c, d, e: a + b * c + d * e,
    "S2": lambda a, b, c, d, e: a - b * c - d * e,
    "AS": lambda a, b, c, d, e: a + b * c - d * e,
    "AMX": lambda a, b: greater(a, np.abs(b)),
    "ADD3": lambda a, b, c: a + b + c,
    "PPM": lambda a, b, c, d, e, f: a * b + c * d - e * f,
    "PMP": lambda a, b, c, d, e, f: a * b - c * d + e * f,
    "PMM": lambda a, b, c, d, e, f: a * b - c * d - e * f,
    "PMA": lambda a, b, c, d, e: a * b - c * d + e,
    "SA": lambda a, b, c, d, e: a - b * c + d * e,
}
"""Operations that write one register, and are as exact as IEEE 754 wants it."""
RESULTS = {"SC": 2}
"""Registers that an operation writes, if not one."""
