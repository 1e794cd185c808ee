"""Reduction: which rows of a loop's closure equations are independent, as a value."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array

_ALIGNED = 1e-12
"""Greatest deviation of a projector's entries from 0 and 1 that counts as rounding. The rounding of
a projector of six columns is some 1e-15; a space that is tilted against the axes by an angle has
entries of the size of that angle."""


class Reduction(NamedTuple):
    """The rows of each loop that its motion can reach, and those that it cannot.

    Attributes:
        rows: per loop `(6, r)`: orthonormal combinations of the weighted rows, in the loop's
            `LoopAxes`, that the joints' twists span over the whole motion.
        null: per loop `(6, 6 - r)`: the combinations that they never reach.
    """

    rows: tuple[Array, ...]
    null: tuple[Array, ...]


def axis_aligned(vectors: Array) -> Array:
    """Return a basis of the same space along the axes where the space allows it.

    Exact zeros and ones keep the rows of a planar or spherical loop free of rounding.

    Args:
        vectors: `(6, r)` orthonormal columns.

    Returns:
        `(6, r)` orthonormal columns: unit vectors if axes span the space, else `vectors`.
    """
    projector = vectors @ vectors.T
    exact = np.round(projector)
    if vectors.shape[1] and np.allclose(projector, exact, rtol=0.0, atol=_ALIGNED):
        return np.eye(6)[:, np.diag(exact) == 1.0]
    return vectors
