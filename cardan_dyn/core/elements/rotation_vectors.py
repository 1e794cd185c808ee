"""Rotation vectors: of many rotations, and how they change with them."""

from __future__ import annotations

import numpy as np

from ...kit.arrays import Array

_SMALL = 0.5
"""Angle [rad] below which a series takes the place of a formula that loses digits there."""
_SERIES = (
    1.0 / 12.0,
    1.0 / 720.0,
    1.0 / 30240.0,
    1.0 / 1209600.0,
    1.0 / 47900160.0,
    691.0 / 1307674368000.0,
    1.0 / 74724249600.0,
)
"""Coefficients of (1 - (θ/2) cot(θ/2)) / θ² in powers of θ²; the next one is some 3e-13."""


def rotation_vector(rotation: Array) -> Array:
    """Return rotation vectors `(N, 3)` of rotations `(N, 3, 3)`, shorter than pi."""
    vector = np.stack(
        [
            rotation[:, 2, 1] - rotation[:, 1, 2],
            rotation[:, 0, 2] - rotation[:, 2, 0],
            rotation[:, 1, 0] - rotation[:, 0, 1],
        ],
        axis=1,
    )
    vector *= 0.5
    sine = np.sqrt(np.einsum("ni,ni->n", vector, vector))
    cosine = 0.5 * (np.einsum("nii->n", rotation) - 1.0)
    angle = np.arctan2(sine, cosine)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(sine > 0.0, angle / sine, 1.0)
    return np.asarray(vector * factor[:, None])


def quaternion(rotation: Array) -> Array:
    """Return one of both unit quaternions `(4,)` (x, y, z, w) of a rotation `(3, 3)`."""
    # Rows of 4 q qᵀ, of which the greatest loses no digits.
    diagonal, rows = np.diag(rotation), np.empty((4, 4))
    rows[:3, :3] = rotation + rotation.T
    rows[range(3), range(3)] = 1.0 + 2.0 * diagonal - np.sum(diagonal)
    rows[3, :3] = rows[:3, 3] = [
        rotation[2, 1] - rotation[1, 2],
        rotation[0, 2] - rotation[2, 0],
        rotation[1, 0] - rotation[0, 1],
    ]
    rows[3, 3] = 1.0 + np.sum(diagonal)
    greatest = rows[np.argmax(np.diag(rows))]
    return np.asarray(greatest / np.linalg.norm(greatest))


def greatest_angle(vectors: Array) -> float:
    """Return the greatest length of rotation vectors `(N, 3)`."""
    return float(np.sqrt(np.max(np.einsum("ni,ni->n", vectors, vectors), initial=0.0)))


def left_jacobian_inverse_transposed(turn: Array, vectors: Array) -> Array:
    """Return J(θ)⁻ᵀ g, where J is the left Jacobian of rotations: ω = J(θ) dθ/dt.

    Args:
        turn: rotation vectors θ `(N, 3)`, shorter than 2 pi.
        vectors: g `(N, 3)`.
    """
    square = np.einsum("ni,ni->n", turn, turn)
    small, series = np.minimum(square, _SMALL**2), np.zeros_like(square)
    for coefficient in reversed(_SERIES):
        series = series * small + coefficient
    half = 0.5 * np.sqrt(np.maximum(square, _SMALL**2))
    formula = 0.25 * (1.0 - half / np.tan(half)) / half**2
    factor = np.where(square < _SMALL**2, series, formula)
    once = np.cross(turn, vectors)
    return np.asarray(vectors + 0.5 * once + factor[:, None] * np.cross(turn, once))
