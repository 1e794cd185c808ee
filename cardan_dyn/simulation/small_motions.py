"""Small motions: about an equilibrium, from its stiffness and inertia alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array

_WEIGHTLESS = 1e-13
"""Inertia along a direction, as a fraction of the greatest, that counts as none."""
_SPLIT = 1e-5
"""Imaginary part of the square of a frequency, as a fraction of it, that counts as rounding: it
parts two that are equal by the root of its size."""


class SmallMotions(NamedTuple):
    """What becomes of small displacements.

    Attributes:
        stability: `stable`, `unstable` or `indifferent`.
        frequencies: angular frequencies `(k,)` of directions that swing, ascending [rad/s].
    """

    stability: str
    frequencies: Array


def small_motions(stiffness: Array, inertia: Array, noise: float) -> SmallMotions:
    """Return what becomes of small displacements x, without damping: M ẍ + K x = 0.

    Efforts that no potential has, such as those of a force that turns with its link, make K
    unsymmetric. Two squares of frequencies may then meet and part as complex ones: flutter, whose
    swings grow.

    Args:
        stiffness: K `(d, d)`, of coordinates with one unit.
        inertia: M `(d, d)`, of the same.
        noise: error of the stiffness along any direction.

    Source: Ziegler, Die Stabilitätskriterien der Elastomechanik, Ing.-Arch. 20 (1952).
    """
    inertia = 0.5 * (inertia + inertia.T)
    if np.max(np.abs(stiffness - stiffness.T)) <= 2.0 * noise:
        stiffness = 0.5 * (stiffness + stiffness.T)
    weights, axes = np.linalg.eigh(inertia)
    is_heavy = weights > _WEIGHTLESS * np.max(np.abs(weights))
    turned = axes.T @ stiffness @ axes
    heavy, light = np.ix_(is_heavy, is_heavy), np.ix_(~is_heavy, ~is_heavy)
    # What has no inertia follows the rest as its springs want it.
    own = turned[light]
    across = turned[np.ix_(is_heavy, ~is_heavy)], turned[np.ix_(~is_heavy, is_heavy)]
    condensed = turned[heavy] - across[0] @ np.linalg.pinv(own, rcond=1e-10) @ across[1]
    root = np.sqrt(weights[is_heavy])
    squares, vectors = _spectrum(condensed / root[:, None] / root)
    errors = noise * np.sum(np.abs(vectors / root[:, None]) ** 2, axis=0)
    flutters = np.abs(squares.imag) > np.maximum(errors, _SPLIT * np.abs(squares))
    swings = (squares.real > errors) & ~flutters
    idle = _spectrum(own)[0].real
    least = np.concatenate([squares.real / np.where(errors > 0.0, errors, 1e-300), idle / noise])
    if np.any(flutters) or np.any(least < -1.0):
        stability = "unstable"
    else:
        stability = "stable" if np.all(least > 1.0) else "indifferent"
    return SmallMotions(stability, np.sort(np.sqrt(squares.real[swings])))


def _spectrum(matrix: Array) -> tuple[Array, Array]:
    """Return complex eigenvalues `(d,)` and eigenvectors of length 1, a column for each."""
    solve = np.linalg.eigh if np.array_equal(matrix, matrix.T) else np.linalg.eig
    values, vectors = solve(matrix)
    return values.astype(complex), vectors
