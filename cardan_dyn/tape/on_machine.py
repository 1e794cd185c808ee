"""On the machine: which blocks of lanes compiled code runs."""

from __future__ import annotations

import numpy as np

from .. import compiled
from ..arrays import Array

_LARGE_BLOCK, _SMALL_BLOCK = 32, 4
"""Lanes of a block, as the machine is compiled for them."""


def machine_is_at_hand() -> bool:
    """Return whether there is a compiled machine."""
    return hasattr(compiled.kernel, "run_program")


def block_for(count: int) -> int:
    """Return how many lanes a block has where so many are to run."""
    return _LARGE_BLOCK if count >= _LARGE_BLOCK else _SMALL_BLOCK


def filled(value: Array, lanes: int) -> Array:
    """Return values side by side, the last repeated to so many lanes; one for all as it is."""
    if value.ndim and 1 < value.shape[-1] < lanes:
        value = value.take(np.minimum(np.arange(lanes), value.shape[-1] - 1), -1)
    return np.ascontiguousarray(value) if value.ndim else value
