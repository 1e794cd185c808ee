"""Stacked matrices: solving one small system per sample, for many samples at once.

Transposed closure matrices are `(N, p, R)` with p ≤ R rows, one per passive coordinate; their
inverses are `(N, R, p)`.
"""

from __future__ import annotations

import numpy as np

from ....kit.arrays import Array
from ..tolerances import RANK_TOLERANCE


def same_side(rows: Array, inverses: Array) -> Array:
    """Return `(N,)` whether two positions lie on the same side of every singular configuration.

    Two assembly modes that meet in a turning point differ in the sign of the determinant of the
    closure equations; the determinant of the product is positive where the signs agree.

    Args:
        rows: `(N, p, R)` transposed closure matrices.
        inverses: `(N, R, p)` of those at the other positions.
    """
    return np.asarray(np.linalg.det(np.matmul(rows, inverses)) > 0.0)


def factorised(rows: Array, scale: Array | None, spins: int = 0) -> tuple[Array, Array]:
    """Return inverses of the closure equations, and condition numbers `(N,)`.

    Inverses are pseudoinverses of the closure equations where these are more than they have rank,
    or where a matrix is exactly singular; unit spins of idle rods follow. Condition numbers are in
    the Frobenius norm of square regular matrices, else ratios of singular values. Of a matrix that
    is not finite, inverse and condition number are none.

    Args:
        rows: transposed closure matrices `(N, p, R)`, p ≤ R + k, followed by k spins.
        scale: `(p, 1)` units of their rows for condition and rank, None if all are 1.
        spins: their number k.

    Returns:
        Inverses `(N, R + k, p)` and condition numbers.
    """
    count, p, columns = rows.shape
    if p == columns:
        try:
            inverse = np.linalg.inv(rows)
            return inverse, condition_numbers(rows, inverse, scale)
        except np.linalg.LinAlgError:
            pass  # One of them is exactly singular; pseudoinverses exist all the same.
    # Of a matrix that is not finite, singular values would be refused for all.
    is_finite = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
    rows = np.where(is_finite[:, None, None], rows, 0.0)
    units = np.ones((p, 1)) if scale is None else scale
    closure, turning = rows[:, :, : columns - spins], rows[:, :, columns - spins :]
    left, values, right = np.linalg.svd(closure * units)
    # With fewer equations there is no such rank; what else is undecided is not reported here.
    rank = min(p - spins, values.shape[1])
    greatest, values = values[:, :1], values[:, :rank]
    # No motion is taken along what vanishes; of rods in singular positions, what vanishes exactly.
    small = values <= (0.0 if spins else RANK_TOLERANCE * greatest)
    reciprocal = np.where(small, 0.0, 1.0 / np.where(small, 1.0, values))
    inverse = (transposed(right[:, :rank]) * reciprocal[:, None]) @ transposed(left[..., :rank])
    inverse *= units.T
    condition = np.full(count, np.inf if rank else 1.0)
    if rank:
        np.divide(greatest[:, 0], values[:, -1], out=condition, where=values[:, -1] > 0.0)
    if spins:
        idle = left[..., p - spins :] * units
        unit_spins = transposed(idle @ np.linalg.pinv(transposed(turning) @ idle))
        inverse = np.concatenate([inverse - (inverse @ turning) @ unit_spins, unit_spins], axis=1)
    inverse[~is_finite] = condition[~is_finite] = np.nan
    return inverse, condition


def ranks(rows: Array) -> Array:
    """Return the ranks `(K,)` of stacked closure matrices `(K, p, R)`.

    All of them are measured by the greatest singular value of the whole stack.
    """
    if 0 in rows.shape[1:]:
        return np.zeros(len(rows), dtype=int)
    values = np.linalg.svd(rows, compute_uv=False)
    return np.asarray(np.sum(values > RANK_TOLERANCE * np.max(values), axis=1))


def refined(matrices: Array, inverses: Array, right: Array) -> Array:
    """Return solutions `(N, j, k)` of linear systems from explicit inverses.

    One step of iterative refinement makes an explicit inverse as stable as an elimination.

    Args:
        matrices: `(N, i, j)`.
        inverses: `(N, j, i)`.
        right: right-hand sides `(N, i, k)`.
    """
    solution = np.matmul(inverses, right)
    solution += np.matmul(inverses, right - np.matmul(matrices, solution))
    return solution


def times(matrices: Array, vectors: Array) -> Array:
    """Return stacked products `(N, i, j) (N, j)`."""
    return np.asarray(np.matmul(matrices, vectors[:, :, None])[:, :, 0])


def transposed(matrices: Array) -> Array:
    """Return stacked transposes."""
    return matrices.transpose(0, 2, 1)


def condition_numbers(rows: Array, inverse: Array, scale: Array | None) -> Array:
    """Return condition numbers `(N,)` in the Frobenius norm, rows scaled if a scale is given.

    Args:
        rows: `(N, p, p)`.
        inverse: `(N, p, p)`.
        scale: `(p, 1)` or None.
    """
    if scale is not None:
        rows, inverse = rows * scale, inverse / scale.T
    squares = [np.einsum("nij,nij->n", matrices, matrices) for matrices in (rows, inverse)]
    return np.asarray(np.sqrt(squares[0] * squares[1]))
