"""Operations: the primitives that traces are made of, and what each is on NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from ...kit.arrays import Array

CONSTANT: Final = "constant"
INPUT: Final = "input"
UNIFORM: Final = "uniform input"


def _select(condition: Array, a: Array, b: Array, out: Array | None = None) -> Array:
    """Return a where the condition is above 0, else b: where it is NaN as well."""
    chosen = np.where(np.greater(condition, 0.0), a, b)
    if out is None:
        return chosen
    out[...] = chosen
    return out


ON_ARRAYS: Final[dict[str, Callable[..., Any]]] = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "negative": np.negative,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "absolute": np.absolute,
    "greater": np.maximum,
    "smaller": np.minimum,
    "select": _select,
    "exp": np.exp,
    "log": np.log,
    "tanh": np.tanh,
    "arctan2": np.arctan2,
}
"""Operations to their functions of arrays, which take an array `out` for the result."""
NAMES: Final = (CONSTANT, INPUT, UNIFORM, *ON_ARRAYS)
"""What nodes are, by their numbers in graphs: the order of `compiled/lowering.c`."""
