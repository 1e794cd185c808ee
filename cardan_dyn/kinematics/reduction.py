"""Reduction: which rows of a loop's closure equations are independent, as a value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .loop_geometry import LoopAxes
from .tolerances import RANK_TOLERANCE

_ALIGNED = 1e-12
"""Greatest deviation of a projector's entries from 0 and 1 that counts as rounding. The rounding of
a projector of six columns is some 1e-15; a space that is tilted against the axes by an angle has
entries of the size of that angle."""


class Reduction(NamedTuple):
    """The rows of each loop that its motion can reach, and those that it cannot.

    Attributes:
        rows: per loop `(6, r)`: orthonormal combinations of the weighted rows, in the loop's
            axes, that the joints' twists span over the whole motion.
        null: per loop `(6, 6 - r)`: the combinations that they never reach.
        axes: per loop, the axes in which its rows are chosen.
    """

    rows: tuple[Array, ...]
    null: tuple[Array, ...]
    axes: tuple[LoopAxes, ...]


def axis_aligned(vectors: Array) -> Array:
    """Return a basis of the same space along the axes where the space allows it.

    Exact zeros and ones keep the rows of a planar or spherical loop free of rounding.

    Args:
        vectors: `(6, r)` orthonormal columns.

    Returns:
        `(6, r)` orthonormal columns: unit vectors if axes span the space, else `vectors`.
    """
    projector = vectors @ vectors.T
    exact = np.rint(projector)
    if vectors.shape[1] and (np.abs(projector - exact) <= _ALIGNED).all():
        return np.eye(6)[:, np.diag(exact) == 1.0]
    return vectors


def reachable_rows(
    twists: Array, units: Array, candidates: Sequence[LoopAxes], actions: Array
) -> tuple[Array, Array, LoopAxes]:
    """Find the rows of a loop that its joints reach at positions all over the motion.

    The unit twists of a loop's joints at all positions together span the motions that the loop can
    make; when that space is smaller than six (a planar or a spherical chain), no motion can violate
    the rest of its rows, at any position.

    Args:
        twists: `(N, k, 6)` of the loop's moving coordinates.
        units: `(k, 6)` scale of their components.
        candidates: axes in which the rows may be chosen; the first ones that show as few as any
            are taken.
        actions: see `BatchModel.actions`.

    Returns:
        The rows `(6, r)` that are reached, the others, and their axes.
    """
    axes = candidates[0]
    space = _spanned(twists, units, axes, actions)
    # At one position, no axes can have fewer rows than its twists are independent.
    if space.rank > _spanned(twists[:1], units, axes, actions[:1]).rank:
        for other in candidates[1:]:
            there = _spanned(twists, units, other, actions)
            if there.rank < space.rank:
                space, axes = there, other
    rows, null = space.vectors[:, : space.rank], space.vectors[:, space.rank :]
    return axis_aligned(rows), axis_aligned(null), axes


class _Space(NamedTuple):
    """The space that twists span.

    Attributes:
        vectors: `(6, 6)` orthonormal, those that span it first.
        rank: its dimension.
    """

    vectors: Array
    rank: int


def _spanned(twists: Array, units: Array, axes: LoopAxes, actions: Array) -> _Space:
    """Return the space that twists `(N, k, 6)` of a loop's joints span at all positions together.

    Args:
        twists: in the base's axes about the batch model's origin.
        units: `(k, 6)` scale of their components.
        axes: in which they are compared.
        actions: see `BatchModel.actions`.
    """
    if axes.body >= 0:
        twists = twists @ axes.matrices(actions)
    # The triangular factor has the singular values and row space of the tall matrix.
    triangle = np.asarray(np.linalg.qr((twists * units).reshape(-1, 6), mode="r"))
    vectors, values, _ = np.linalg.svd(triangle.T, full_matrices=True)
    rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0
    return _Space(vectors, rank)
