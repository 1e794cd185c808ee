"""Compiled: what calls of a few samples, and blocks of many, do most of the time, in C.

All of it is written in NumPy too, beside what calls it, and is done there where the extension is
not at hand: it is built while the package is installed, if there is a compiler. Setting the
environment variable `CARDAN_DYN_COMPILED=0` does without it. Results agree but for rounding.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..arrays import Array

kernel: Any = None
"""The module of compiled functions; None where they are not at hand."""
if os.environ.get("CARDAN_DYN_COMPILED") != "0":
    with suppress(ModuleNotFoundError):
        kernel = import_module("._kernel", __name__)


class Plan:
    """Index arrays and constants that a compiled function works along.

    It is made once per scene, and again where a scene was copied or sent to another process.
    """

    def __init__(self, integers: Sequence[Array], numbers: Sequence[Array]) -> None:
        """Keep the arrays in the order that the function defines."""
        self._arrays = (
            [np.ascontiguousarray(array, dtype=np.int64) for array in integers],
            [np.ascontiguousarray(array, dtype=float) for array in numbers],
        )
        self.handle: Any = kernel and kernel.plan(*self._arrays)

    def __reduce__(self) -> tuple[type[Plan], tuple[list[Array], list[Array]]]:
        return Plan, self._arrays
