"""Arrays: their type, and the few operations on them that several packages need."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array: TypeAlias = NDArray[Any]
else:
    Array = np.ndarray  # Without NumPy's module of types, which nothing else needs.
"""An array of floats, unless a docstring says otherwise; docstrings give shapes and units."""

EPS = float(np.finfo(float).eps)
"""Rounding of a double."""
ROUNDED = 1e-12
"""Part of the greatest of its kind, or of the terms that it is made of, up to which a number counts
as their rounding: that of some thousand operations."""
NOTHING = 1e-9
"""The same of results, which lose digits where equations are ill-conditioned; nothing that somebody
means is as small beside the rest."""
BLOCK_SIZE = 1024
"""Greatest number of samples worked on at a time, so that their arrays stay in the cache."""
LARGE_BLOCK = 8 * BLOCK_SIZE
"""The same where tapes keep few of them in the cache: what Python does between operations on arrays
then takes little, so that threads seldom wait for it."""
_LEFT, _RIGHT = np.array([1, 2, 0, 2, 0, 1]), np.array([2, 0, 1, 1, 2, 0])
"""Components whose products a cross product adds, and three that it takes off."""
_FACTORS = np.array([[3, 2, 1, 0], [2, 3, 0, 1], [1, 0, 3, 2], [0, 1, 2, 3]])
_FACTOR_SIGNS = np.array([[1, -1, 1, 1], [1, 1, -1, 1], [-1, 1, 1, 1], [-1, -1, -1, 1.0]])
"""Which components of a quaternion multiply those of another one, and with which signs."""


def cross(a: Array, b: Array) -> Array:
    """Return cross products of `(3, …)` arrays along the first axis, faster than `np.cross`."""
    products = a.take(_LEFT, 0) * b.take(_RIGHT, 0)
    return np.asarray(products[:3] - products[3:])


def quaternion_product(a: Array, b: Array) -> Array:
    """Return products of quaternions `(…, 4)` (x, y, z, w): the rotation `b`, followed by `a`."""
    # Entry (i, j) is the component of `a` that takes b_j to component i of the product.
    matrices = a.take(_FACTORS, -1)
    matrices *= _FACTOR_SIGNS
    products = matrices * b[..., None, :]
    # One after the other, so that a sample comes out alike whatever others are beside it.
    return np.asarray(products[..., 0] + products[..., 1] + products[..., 2] + products[..., 3])


def inverse(placement: Array) -> Array:
    """Return the inverse of a `(4, 4)` placement."""
    result = np.eye(4)
    result[:3, :3] = placement[:3, :3].T
    result[:3, 3] = -placement[:3, :3].T @ placement[:3, 3]
    return result


def cardan_angles(quaternion: Array) -> Array:
    """Return the angles `(3, …)` of turns about x, the carried y, the carried z, of rotations.

    Args:
        quaternion: `(4, …)` of unit length (x, y, z, w).
    """
    x, y, z, w = quaternion
    sine, rest = 2.0 * (x * w - y * z), 1.0 - 2.0 * (x * x + y * y)
    # Of the middle angle, sine and cosine: the latter does not vanish in the former's rounding.
    cosine = np.hypot(sine, rest)
    middle = np.arctan2(2.0 * (x * z + y * w), cosine)
    # At a right angle rounding alone would tell the first one. Whatever that is, the last one leads
    # on to the rotation.
    first = np.where(cosine > 8.0 * EPS, np.arctan2(sine, rest), 0.0)
    sine, rest = np.sin(0.5 * first), np.cos(0.5 * first)
    sine, rest = rest * z - sine * y, rest * w + sine * x
    last = 2.0 * np.arctan2(np.copysign(1.0, rest) * sine, np.abs(rest))
    return np.array([first, middle, last])


def cardan_quaternion(angles: Array) -> Array:
    """Return the unit quaternion `(4,)` (x, y, z, w) of three angles, see `cardan_angles`."""
    turns = np.zeros((3, 1, 4))
    turns[[0, 1, 2], 0, [0, 1, 2]] = np.sin(0.5 * angles)
    turns[:, 0, 3] = np.cos(0.5 * angles)
    return quaternion_product(quaternion_product(turns[0], turns[1]), turns[2])[0]


def generic(rows: int, columns: int) -> Array:
    """Return numbers `(rows, columns)` between -1 and 1 without a pattern, always the same ones.

    They are used in place of random numbers, since importing NumPy's generators takes longer than
    making a scene.
    """
    return np.asarray(np.sin(np.arange(1.0, rows * columns + 1.0) ** 2).reshape(rows, columns))


def some(count: int, most: int) -> Array:
    """Return indices of some of so many samples, without a pattern: symmetric positions mislead."""
    if count <= most:
        return np.arange(count)
    return np.unique((0.5 * (1.0 + generic(most, 1)[:, 0]) * count).astype(int) % count)


def distinct(rows: Array) -> tuple[Array, Array]:
    """Return where the distinct rows of `(N, k)` first stand, ascending, and which each row is.

    As `np.unique` along an axis, which takes ten times as long.
    """
    order = np.lexsort(rows.T[::-1]) if rows.size else np.arange(len(rows))
    is_new = np.ones(len(rows), dtype=bool)
    np.not_equal(rows[order[1:]], rows[order[:-1]]).any(axis=1, out=is_new[1:])
    of = np.empty(len(rows), dtype=int)
    of[order] = np.cumsum(is_new) - 1
    return order[is_new], of


def neighbours(points: Array, most: int) -> Array:
    """Return an order of points `(N, d)` in which up to so many of them in a row lie near by.

    They are cut into strips of equal numbers along the first axis, these along the next, and so on.
    Those of a path, of which that many go no farther than such a cell, stay in their order.
    """
    count, axes = points.shape
    order = np.arange(count)
    if count <= most:
        return order
    parts, rows = (count / most) ** (1.0 / axes), np.ascontiguousarray(points.T)
    ways = np.abs(rows[:, 1:] - rows[:, :-1]).sum(axis=1)
    if np.all(ways * (parts * most / count) <= np.ptp(rows, axis=1)):
        return order
    for axis in range(axes):
        strips = np.floor(np.arange(count) / count * parts**axis)
        along = rows[axis, order]
        # Within a strip less than one, so that one number sorts by both.
        along -= along.min()
        order = order[np.argsort(strips + along / (along.max() + 1.0))]
    return order


def squeezed(values: Array) -> Array:
    """Return a single column `(N, 1)` as `(N,)`, several columns as they are."""
    return values[:, 0] if values.shape[1] == 1 else values


def consecutive(indices: Array) -> slice | Array:
    """Return ascending indices, as a slice if there are no gaps, since slices make no copies."""
    span = indices.size and indices[-1] - indices[0] == indices.size - 1
    if span and (indices[1:] - indices[:-1] == 1).all():
        return slice(int(indices[0]), int(indices[-1]) + 1)
    return indices


def blocks(count: int, most: int = BLOCK_SIZE) -> list[slice]:
    """Return so many samples in blocks of at most `most`."""
    return [slice(first, first + most) for first in range(0, count, most)]


def flat(values: Array, shape: tuple[int, ...], trailing: int = 0) -> Array:
    """Return values `(...)` over all samples `(N,)`; the last `trailing` axes are kept."""
    rest = values.shape[values.ndim - trailing :]
    return spread(values, (*shape, *rest)).reshape(-1, *rest)


def part(values: Array, shape: tuple[int, ...], span: slice, trailing: int = 0) -> Array:
    """Return values `(...)` at some of the samples that `flat` has, without spreading the others.

    Args:
        values: they broadcast with the shape.
        shape: of all samples.
        span: which of them are wanted.
        trailing: see `flat`.
    """
    rest = values.shape[values.ndim - trailing :]
    whole = spread(values, (*shape, *rest))
    # Views need no memory, as of one value for all samples.
    if len(shape) == 1:
        return whole[span]
    if not any(whole.strides[: len(shape)]) or whole.flags.c_contiguous:
        return whole.reshape(-1, *rest)[span]
    samples = np.arange(*span.indices(math.prod(shape)))
    return np.asarray(whole[np.unravel_index(samples, shape)])


def spread(values: Array, shape: tuple[int, ...]) -> Array:
    """Return values in a shape with which they broadcast, without copies."""
    if values.shape == shape:
        return values
    # Arrays of the same size differ by axes of one sample, which `reshape` is faster at.
    return (
        values.reshape(shape) if values.size == math.prod(shape) else np.broadcast_to(values, shape)
    )
