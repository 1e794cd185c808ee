"""Arrays: their type, and the few operations on them that several rooms need."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
"""Of floats, unless a docstring says otherwise; docstrings give shapes and units."""


def cross(a: Array, b: Array) -> Array:
    """Return the cross product along the first axis, which `np.cross` does several times slower."""
    a, b = np.concatenate((a, a[:2])), np.concatenate((b, b[:2]))
    return np.asarray(a[1:4] * b[2:5] - a[2:5] * b[1:4])


def quaternion_product(a: Array, b: Array) -> Array:
    """Return products of quaternions `(N, 4)` (x, y, z, w): rotation `b`, then `a`."""
    av, aw, bv, bw = a[:, :3], a[:, 3:], b[:, :3], b[:, 3:]
    vector = aw * bv + bw * av + np.cross(av, bv)
    scalar = aw * bw - np.sum(av * bv, axis=1, keepdims=True)
    return np.concatenate([vector, scalar], axis=1)


def generic(rows: int, columns: int) -> Array:
    """Return numbers `(rows, columns)` between -1 and 1 without a pattern, always the same ones.

    They do what random numbers would; importing NumPy's generators takes longer than making a
    scene.
    """
    return np.asarray(np.sin(np.arange(1.0, rows * columns + 1.0) ** 2).reshape(rows, columns))
